using UnityEngine;

namespace Crumple
{
    // From collisions to hits. Callbacks of physics run on the main thread; submitting needs no lock, so none is taken here.
    public sealed partial class CrumpleMesh
    {
        /// <summary>A touch of another collider, from Enter to Exit.</summary>
        private struct Touch
        {
            internal int Other;
            internal ulong Contact;
            internal Vector3 Velocity; // of the other relative to this as the touch began, m/s in world space; zero: unknown
            internal float Begin, Last; // s, by Time.fixedTime
            internal bool Open;
        }

        private Touch[] touches = new Touch[8];
        private int touchCount;
        private ulong lastContact;

        /// <summary>
        /// A hit at a point in world space by an impulse, N s, that this body receives. Null where it could not be taken; the
        /// console says why, once.
        /// </summary>
        public CrumpleHitResult? Hit(Vector3 worldPoint, Vector3 worldImpulse)
        {
            return Submit(worldPoint, worldImpulse, Vector3.zero, 0, Vector3.zero, 0, 0);
        }

        /// <summary>
        /// The same with what is known of the striker. Zeros are unknown, which costs accuracy. A zero impulse is mass times
        /// velocity.
        /// </summary>
        /// <param name="worldPoint">Where it hit, m.</param>
        /// <param name="worldImpulse">What this body received, N s.</param>
        /// <param name="worldNormal">Contact normal, out of this body.</param>
        /// <param name="strikerMass">kg.</param>
        /// <param name="worldStrikerVelocity">Relative to this body before the touch, m/s.</param>
        /// <param name="strikerRadius">Radius of its surface at the contact, m.</param>
        public CrumpleHitResult? Hit(Vector3 worldPoint, Vector3 worldImpulse, Vector3 worldNormal, float strikerMass,
            Vector3 worldStrikerVelocity, float strikerRadius = 0)
        {
            return Submit(worldPoint, worldImpulse, worldNormal, strikerMass, worldStrikerVelocity, strikerRadius, 0);
        }

        private void OnCollisionEnter(Collision collision)
        {
            if (!fromCollisions || instance == null || !isActiveAndEnabled) return; // Unity tells disabled ones too
            int i = Begin(Id(collision));
            touches[i].Velocity = collision.relativeVelocity;
            Contact(collision, i);
        }

        private void OnCollisionStay(Collision collision)
        {
            if (!fromCollisions || instance == null || !isActiveAndEnabled) return;
            int other = Id(collision), i = Find(other);
            if (i < 0) i = Begin(other); // enabled while they touched already
            touches[i].Last = Time.fixedTime;
            if (!touches[i].Open) return;
            // What comes so late holds the body up; added on and on it would press through any metal.
            if (Time.fixedTime - touches[i].Begin <= contactTime) Contact(collision, i);
            else End(i);
        }

        private void OnCollisionExit(Collision collision)
        {
            int i = Find(Id(collision));
            if (i < 0) return;
            End(i);
            touches[i] = touches[--touchCount];
        }

        private static int Id(Collision collision)
        {
            return collision.collider == null ? 0 : collision.collider.GetInstanceID();
        }

        private int Find(int other)
        {
            for (int i = 0; i < touchCount; i++)
                if (touches[i].Other == other) return i;
            return -1;
        }

        private int Begin(int other)
        {
            int i = Find(other);
            if (i >= 0) End(i);
            else
            {
                if (touchCount == touches.Length) Forget();
                if (touchCount == touches.Length) System.Array.Resize(ref touches, 2 * touchCount);
                i = touchCount++;
            }
            touches[i] = new Touch { Other = other, Contact = ++lastContact, Begin = Time.fixedTime, Last = Time.fixedTime, Open = true };
            return i;
        }

        // Of a collider that was destroyed while it touched no Exit comes.
        private void Forget()
        {
            for (int i = touchCount - 1; i >= 0; i--)
            {
                if (touches[i].Last > Time.fixedTime - 1) continue;
                End(i);
                touches[i] = touches[--touchCount];
            }
        }

        private void End(int i)
        {
            if (!touches[i].Open) return;
            touches[i].Open = false;
            try
            {
                if (instance != null) instance.EndContact(touches[i].Contact);
            }
            catch (CrumpleException error)
            {
                Warn(error.Message);
            }
        }

        private void EndContacts()
        {
            for (int i = 0; i < touchCount; i++) End(i);
            touchCount = 0;
        }

        // One collision is one contact of Crumple's, whatever number of points it has in a step: their mean is where it hit, and
        // its impulses of all steps add up to one dent, at any fixed time step.
        private void Contact(Collision collision, int touch)
        {
            int count = collision.contactCount;
            if (count == 0) return;
            Vector3 point = Vector3.zero, normal = Vector3.zero;
            for (int i = 0; i < count; i++)
            {
                ContactPoint contact = collision.GetContact(i);
                point += contact.point;
                normal += contact.normal;
            }
            Vector3 impulse = collision.impulse;
            if (impulse == Vector3.zero) return;
            // Unity does not say of which of the two bodies the impulse is told. Its normal points from the other one to this,
            // and so does what this one receives.
            if (Vector3.Dot(impulse, normal) < 0) impulse = -impulse;
            // The other one comes towards this one, so the same holds for its velocity.
            Vector3 velocity = touches[touch].Velocity;
            if (Vector3.Dot(velocity, normal) < 0) velocity = -velocity;
            Rigidbody other = collision.rigidbody;
            float mass = other == null || other.isKinematic ? 0 : other.mass;
            Submit(point / count, impulse, -normal, mass, velocity, 0, touches[touch].Contact);
        }

        private CrumpleHitResult? Submit(Vector3 worldPoint, Vector3 worldImpulse, Vector3 worldNormal, float strikerMass,
            Vector3 worldStrikerVelocity, float strikerRadius, ulong contact)
        {
            if (instance == null) return null;
            CrumpleHitResult result;
            try
            {
                Transform space = filter.transform;
                CrumpleHitDef def = CrumpleHitDef.Default;
                def.Point = MeshMatch.ToCrumple(space.InverseTransformPoint(worldPoint));
                def.Impulse = MeshMatch.ToCrumple(space.InverseTransformVector(worldImpulse));
                def.Duration = duration;
                def.Mass = vertexMass;
                def.Normal = MeshMatch.ToCrumple(space.InverseTransformDirection(worldNormal));
                def.Striker = new CrumpleStriker(strikerMass, strikerRadius,
                    MeshMatch.ToCrumple(space.InverseTransformVector(worldStrikerVelocity)));
                def.ContactId = contact;
                result = instance.Submit(in def);
            }
            catch (CrumpleException error)
            {
                Warn(error.Message);
                return null;
            }
            changed = true;
            if (Dented != null) Dented(this, result); // may destroy this
            return result;
        }

        // A hit that cannot be taken comes again in the next step: it is said once.
        private void Warn(string message)
        {
            if (warned) return;
            warned = true;
            Debug.LogWarning("CrumpleMesh '" + name + "': a hit was not taken: " + message, this);
        }
    }
}
