using System;
using UnityEngine;

namespace Crumple
{
    // From Unity's collisions to the context's contact points, and from its hits to components.
    public static partial class CrumpleWorld
    {
        private static CrumpleContactPointDef[] points = new CrumpleContactPointDef[16];
        private static CrumpleContactHit[] hits = new CrumpleContactHit[16];
        private static float began = float.NaN; // the step of physics that collisions belong to, s
        private static bool stepping;

        /// <summary>A step of physics begins, so the one before has ended. Every component says so.</summary>
        internal static void BeginStep()
        {
            if (Time.fixedTime == began) return;
            EndStep();
            began = Time.fixedTime;
            stepping = true;
        }

        /// <summary>Turns the contact points of the last step of physics into hits, once.</summary>
        internal static void EndStep()
        {
            if (!stepping || context == null) return;
            stepping = false;
            CrumpleContactReport report = context.StepContacts(Time.fixedDeltaTime);
            if (report.Refused > 0) SayOnce(true, "a hit was not taken: " + report.Refusal, null);
            if (report.Hits == 0) return;
            if (hits.Length < (int)report.Hits) hits = new CrumpleContactHit[(int)report.Hits];
            int count = context.GetContactHits(hits);
            for (int i = 0; i < count; i++)
            {
                CrumpleMesh struck = Find(hits[i].Instance); // listeners may destroy the others
                if (struck != null) struck.Took(hits[i].Result);
            }
        }

        /// <summary>Reports the points of a collision, told to a body, with another body that dents or none.</summary>
        internal static unsafe void Report(Collision collision, CrumpleMesh body, CrumpleMesh other)
        {
            int count = collision.contactCount;
            if (count == 0) return;
            if (points.Length < count) points = new CrumpleContactPointDef[2 * count];
            stepping = true;
            Vector3 impulse = collision.impulse, velocity = collision.relativeVelocity, normals = Vector3.zero;
            for (int i = 0; i < count; i++) normals += collision.GetContact(i).normal;
            // Unity's normal points at this body. It does not say of which body the velocity is, but bodies that touch approach.
            if (Vector3.Dot(velocity, normals) < 0) velocity = -velocity;
            for (int i = 0; i < count; i++)
            {
                ContactPoint contact = collision.GetContact(i);
                CrumpleContactPointDef point = CrumpleContactPointDef.Default;
                point.Pair = Pair(body, other != null ? other : (UnityEngine.Object)collision.collider);
                point.Bodies0 = body.Instance.Id;
                if (other != null) point.Bodies1 = other.Instance.Id;
                point.Point = MeshMatch.ToCrumple(contact.point);
                point.Normal = MeshMatch.ToCrumple(-contact.normal);
                point.HasVelocity = true;
                point.Velocity = MeshMatch.ToCrumple(velocity);
                point.Impulse = Math.Abs(Vector3.Dot(impulse, contact.normal));
                point.Masses[0] = Mass(contact.thisCollider == null ? null : contact.thisCollider.attachedRigidbody);
                point.Masses[1] = Mass(collision.rigidbody);
                points[i] = point;
            }
            context.ReportContacts(new ReadOnlySpan<CrumpleContactPointDef>(points, 0, count));
        }

        private static float Mass(Rigidbody body)
        {
            return body == null || body.isKinematic ? float.PositiveInfinity : body.mass;
        }

        // The same, whichever of the two tells.
        private static ulong Pair(UnityEngine.Object a, UnityEngine.Object b)
        {
            uint first = (uint)a.GetInstanceID(), second = ReferenceEquals(b, null) ? 0 : (uint)b.GetInstanceID();
            return (ulong)Math.Min(first, second) << 32 | Math.Max(first, second);
        }

        private static CrumpleMesh Find(CrumpleInstance id)
        {
            foreach (CrumpleMesh mesh in Meshes)
                if (mesh.Instance.Id.Index == id.Index && mesh.Instance.Id.Generation == id.Generation) return mesh;
            return null;
        }
    }
}
