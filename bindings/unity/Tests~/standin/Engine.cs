// Stand-ins for the part of Unity's API that the package uses, written from its public scripting reference: enough to compile the
// package and to drive it under Mono. They are not Unity. Where a stand-in behaves, it behaves as the reference says; what it
// does not say is not played.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Reflection;

namespace UnityEngine
{
    public class Object
    {
        private static int lastId;
        private readonly int id = ++lastId;
        internal bool Destroyed;

        public string name { get; set; }

        public int GetInstanceID() { return id; }

        public static bool operator ==(Object a, Object b)
        {
            bool noA = ReferenceEquals(a, null) || a.Destroyed, noB = ReferenceEquals(b, null) || b.Destroyed;
            return noA || noB ? noA && noB : ReferenceEquals(a, b);
        }

        public static bool operator !=(Object a, Object b) { return !(a == b); }
        public static implicit operator bool(Object a) { return a != null; }
        public override bool Equals(object other) { return ReferenceEquals(this, other); }
        public override int GetHashCode() { return id; }

        /// <summary>At the end of the frame.</summary>
        public static void Destroy(Object target) { if (target != null) StandIn.Engine.Doomed.Add(target); }

        public static void DestroyImmediate(Object target)
        {
            if (target == null) return;
            GameObject owner = target as GameObject;
            if (!ReferenceEquals(owner, null))
                foreach (Component part in owner.Parts.ToArray()) DestroyImmediate(part);
            MonoBehaviour behaviour = target as MonoBehaviour;
            if (!ReferenceEquals(behaviour, null))
            {
                StandIn.Engine.Disable(behaviour);
                StandIn.Engine.Call(behaviour, "OnDestroy");
                StandIn.Engine.Behaviours.Remove(behaviour);
            }
            Component component = target as Component;
            if (!ReferenceEquals(component, null)) component.gameObject.Parts.Remove(component);
            target.Released();
            target.Destroyed = true;
        }

        public static T Instantiate<T>(T original) where T : Object
        {
            Mesh mesh = original as Mesh;
            if (ReferenceEquals(mesh, null)) throw new NotSupportedException("the stand-in copies meshes only");
            return (T)(Object)mesh.Copy();
        }

        internal virtual void Released() { }
    }

    public class ScriptableObject : Object
    {
        public static T CreateInstance<T>() where T : ScriptableObject, new() { return new T { name = "" }; }
    }

    public sealed class GameObject : Object
    {
        internal readonly List<Component> Parts = new List<Component>();

        public Transform transform { get; private set; }

        public GameObject(string name)
        {
            this.name = name;
            transform = AddComponent<Transform>();
        }

        public bool activeInHierarchy { get; private set; } = true;

        public void SetActive(bool value)
        {
            if (activeInHierarchy == value) return;
            activeInHierarchy = value;
            foreach (Component part in Parts.ToArray())
            {
                MonoBehaviour behaviour = part as MonoBehaviour;
                if (ReferenceEquals(behaviour, null)) continue;
                if (value) StandIn.Engine.Enable(behaviour);
                else StandIn.Engine.Disable(behaviour);
            }
        }

        public static GameObject CreatePrimitive(PrimitiveType type)
        {
            GameObject made = new GameObject(type.ToString());
            made.AddComponent<SphereCollider>();
            made.AddComponent<MeshRenderer>().sharedMaterial = new Material();
            return made;
        }

        public T AddComponent<T>() where T : Component, new()
        {
            T made = new T { gameObject = this };
            Parts.Add(made);
            MonoBehaviour behaviour = made as MonoBehaviour;
            if (!ReferenceEquals(behaviour, null))
            {
                StandIn.Engine.Behaviours.Add(behaviour);
                StandIn.Engine.Enable(behaviour);
            }
            return made;
        }

        public T GetComponent<T>() where T : Component
        {
            foreach (Component part in Parts)
            {
                T found = part as T;
                if (!ReferenceEquals(found, null)) return found;
            }
            return null;
        }
    }

    public class Component : Object
    {
        public GameObject gameObject { get; internal set; }
        public Transform transform { get { return gameObject.transform; } }
        public new string name { get { return gameObject.name; } set { gameObject.name = value; } }
        public T GetComponent<T>() where T : Component { return gameObject.GetComponent<T>(); }
    }

    public class Behaviour : Component
    {
        private bool on = true;

        public bool enabled
        {
            get { return on; }
            set
            {
                if (on == value) return;
                on = value;
                MonoBehaviour behaviour = this as MonoBehaviour;
                if (on) StandIn.Engine.Enable(behaviour);
                else StandIn.Engine.Disable(behaviour);
            }
        }

        public bool isActiveAndEnabled { get { return on && gameObject.activeInHierarchy; } }
    }

    public class MonoBehaviour : Behaviour
    {
        internal bool Running, Started;
    }

    /// <summary>Position and scale; no rotation, no parents.</summary>
    public sealed class Transform : Component
    {
        public Vector3 position { get; set; }
        public Vector3 localScale { get; set; } = Vector3.one;
        public Matrix4x4 localToWorldMatrix { get { return new Matrix4x4 { Scale = localScale, Place = position }; } }
    }

    public sealed class MeshFilter : Component
    {
        public Mesh sharedMesh { get; set; }
    }

    public sealed class MeshRenderer : Component
    {
        public Material sharedMaterial { get; set; }
    }

    public sealed class Material : Object
    {
        internal Material() { }
    }

    public class Collider : Component
    {
        public Rigidbody attachedRigidbody { get { return GetComponent<Rigidbody>(); } }
    }

    public sealed class SphereCollider : Collider { }
    public sealed class BoxCollider : Collider { public Vector3 size { get; set; } public Vector3 center { get; set; } }

    public sealed class Rigidbody : Component
    {
        public bool isKinematic { get; set; }
        public float mass { get; set; }
    }

    public enum PrimitiveType { Sphere }

    public struct ContactPoint
    {
        public Vector3 point { get; internal set; }
        public Vector3 normal { get; internal set; }
        public Collider thisCollider { get; internal set; }
    }

    public class Collision
    {
        internal ContactPoint[] Points = new ContactPoint[0];
        public Collider collider { get; internal set; }
        public Rigidbody rigidbody { get; internal set; }
        public Vector3 impulse { get; internal set; }
        public Vector3 relativeVelocity { get; internal set; }
        public int contactCount { get { return Points.Length; } }
        public ContactPoint GetContact(int index) { return Points[index]; }
    }

    public static class Physics
    {
        public static Vector3 gravity { get; set; }
    }

    public static class Time
    {
        public static float fixedTime { get; internal set; }
        public static float fixedDeltaTime { get; internal set; } = 0.02f;
    }

    public static class Application
    {
        public static bool isPlaying { get; internal set; } = true;
        public static event Action quitting;
        public static event Events.UnityAction onBeforeRender;

        internal static void Quit() { if (quitting != null) quitting(); }
        internal static void BeforeRender() { if (onBeforeRender != null) onBeforeRender(); }
    }

    public static class Debug
    {
        internal static readonly List<string> Lines = new List<string>();

        public static void Log(object message, Object about = null) { Lines.Add("log: " + message); }
        public static void LogWarning(object message, Object about = null) { Lines.Add("warning: " + message); }
        public static void LogError(object message, Object about = null) { Lines.Add("error: " + message); }
        public static void LogException(Exception error) { Lines.Add("exception: " + error); }
    }

    [AttributeUsage(AttributeTargets.Field)] public sealed class SerializeField : Attribute { }
    [AttributeUsage(AttributeTargets.Field)] public sealed class HideInInspector : Attribute { }
    [AttributeUsage(AttributeTargets.Field)] public sealed class HeaderAttribute : Attribute { public HeaderAttribute(string text) { } }
    [AttributeUsage(AttributeTargets.Field)] public sealed class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }
    [AttributeUsage(AttributeTargets.Field)] public sealed class MinAttribute : Attribute { public MinAttribute(float least) { } }
    [AttributeUsage(AttributeTargets.Class)] public sealed class AddComponentMenu : Attribute { public AddComponentMenu(string menu) { } }
    [AttributeUsage(AttributeTargets.Class)] public sealed class DisallowMultipleComponent : Attribute { }

    public enum RuntimeInitializeLoadType { SubsystemRegistration }

    [AttributeUsage(AttributeTargets.Method)]
    public sealed class RuntimeInitializeOnLoadMethodAttribute : Attribute
    {
        public RuntimeInitializeOnLoadMethodAttribute(RuntimeInitializeLoadType when) { }
    }
}

namespace UnityEngine.Events
{
    public delegate void UnityAction();
}

namespace StandIn
{
    using UnityEngine;

    /// <summary>Unity's main loop, as far as components can tell.</summary>
    public static class Engine
    {
        internal static readonly List<MonoBehaviour> Behaviours = new List<MonoBehaviour>();
        internal static readonly List<UnityEngine.Object> Doomed = new List<UnityEngine.Object>();
        private static readonly Dictionary<Type, Dictionary<string, MethodInfo>> Messages = new Dictionary<Type, Dictionary<string, MethodInfo>>();
        private static readonly Dictionary<MonoBehaviour, Action> LateUpdates = new Dictionary<MonoBehaviour, Action>();

        private static MethodInfo Message(Type type, string name)
        {
            Dictionary<string, MethodInfo> known;
            if (!Messages.TryGetValue(type, out known)) Messages.Add(type, known = new Dictionary<string, MethodInfo>());
            MethodInfo method;
            if (!known.TryGetValue(name, out method))
                known.Add(name, method = type.GetMethod(name, BindingFlags.Instance | BindingFlags.NonPublic | BindingFlags.Public));
            return method;
        }

        internal static void Call(MonoBehaviour behaviour, string name, params object[] arguments)
        {
            MethodInfo method = Message(behaviour.GetType(), name);
            if (method == null || behaviour.Destroyed) return;
            try
            {
                method.Invoke(behaviour, arguments);
            }
            catch (TargetInvocationException error)
            {
                throw new Exception(name + " threw, which Unity would log: " + error.InnerException, error.InnerException);
            }
        }

        internal static void Enable(MonoBehaviour behaviour)
        {
            if (behaviour.Running || !behaviour.isActiveAndEnabled) return;
            behaviour.Running = true;
            MethodInfo late = Message(behaviour.GetType(), "LateUpdate");
            if (late != null) LateUpdates[behaviour] = (Action)Delegate.CreateDelegate(typeof(Action), behaviour, late);
            Call(behaviour, "OnEnable");
        }

        internal static void Disable(MonoBehaviour behaviour)
        {
            if (!behaviour.Running) return;
            behaviour.Running = false;
            LateUpdates.Remove(behaviour);
            Call(behaviour, "OnDisable");
        }

        /// <summary>One frame without physics; allocates nothing of its own.</summary>
        public static void Frame()
        {
            for (int i = 0; i < Behaviours.Count; i++)
            {
                Action late;
                if (Behaviours[i].Running && !Behaviours[i].Started)
                {
                    Behaviours[i].Started = true;
                    Call(Behaviours[i], "Start");
                }
                if (Behaviours[i].Running && LateUpdates.TryGetValue(Behaviours[i], out late)) late();
            }
            Application.BeforeRender();
            Sweep();
        }

        /// <summary>What Object.Destroy() was called for goes.</summary>
        internal static void Sweep()
        {
            while (Doomed.Count > 0)
            {
                UnityEngine.Object doomed = Doomed[Doomed.Count - 1];
                Doomed.RemoveAt(Doomed.Count - 1);
                UnityEngine.Object.DestroyImmediate(doomed);
            }
        }

        /// <summary>A step of physics, which tells of a collision: what is OnCollisionEnter, OnCollisionStay or OnCollisionExit.
        /// Null: of none.</summary>
        public static void Step(GameObject struck = null, string what = null, Collision collision = null)
        {
            Time.fixedTime += Time.fixedDeltaTime;
            foreach (MonoBehaviour behaviour in Behaviours.ToArray())
                if (behaviour.Running) Call(behaviour, "FixedUpdate");
            if (struck != null) Tell(struck, what, collision);
        }

        /// <summary>Tells an object of a collision in the step that runs.</summary>
        public static void Tell(GameObject struck, string what, Collision collision)
        {
            foreach (Component part in struck.Parts.ToArray())
            {
                MonoBehaviour behaviour = part as MonoBehaviour;
                if (!ReferenceEquals(behaviour, null)) Call(behaviour, what, collision);
            }
        }

        /// <summary>A collision at these points with one normal, which points out of the other collider.</summary>
        public static Collision Touch(Collider self, Collider other, Vector3 impulse, Vector3 velocity, Vector3 normal, params Vector3[] points)
        {
            Collision collision = new Collision { collider = other, impulse = impulse, relativeVelocity = velocity };
            collision.rigidbody = other == null ? null : other.attachedRigidbody;
            collision.Points = Array.ConvertAll(points, point => new ContactPoint { point = point, normal = normal, thisCollider = self });
            return collision;
        }

        /// <summary>
        /// Scripts are reloaded, as far as it can be played without a new application domain: components are disabled, listeners
        /// told, components enabled. Statics stay, as they do not in the editor.
        /// </summary>
        public static void ReloadScripts()
        {
            MonoBehaviour[] all = Behaviours.ToArray();
            foreach (MonoBehaviour behaviour in all) Disable(behaviour);
            UnityEditor.AssemblyReloadEvents.Tell();
            foreach (MonoBehaviour behaviour in all) Enable(behaviour);
        }

        /// <summary>Another scene: every object goes.</summary>
        public static void Clear()
        {
            foreach (MonoBehaviour behaviour in Behaviours.ToArray())
                if (!behaviour.Destroyed) UnityEngine.Object.DestroyImmediate(behaviour.gameObject);
            Debug.Lines.Clear();
        }

        /// <summary>The console's lines since the last call.</summary>
        public static string[] Console()
        {
            string[] lines = Debug.Lines.ToArray();
            Debug.Lines.Clear();
            return lines;
        }
    }
}
