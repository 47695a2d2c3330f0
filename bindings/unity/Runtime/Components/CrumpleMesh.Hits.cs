using UnityEngine;

namespace Crumple
{
    // From collisions to hits. Callbacks of physics run on the main thread; contact points and hits need no lock, so none is taken here.
    public sealed partial class CrumpleMesh
    {
        private static readonly float[] Matrix = new float[16];

        /// <summary>
        /// A hit at a point in world space by an impulse, N s, that this body receives. Null where it could not be taken; the
        /// console says why, once.
        /// </summary>
        public CrumpleHitResult? Hit(Vector3 worldPoint, Vector3 worldImpulse)
        {
            return Hit(worldPoint, worldImpulse, Vector3.zero, 0, Vector3.zero);
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
            if (instance == null) return null;
            CrumpleHitResult result;
            try
            {
                PlaceInWorld();
                CrumpleHitDef def = CrumpleHitDef.Default;
                def.Space = CrumpleSpace.World;
                def.Point = MeshMatch.ToCrumple(worldPoint);
                def.Impulse = MeshMatch.ToCrumple(worldImpulse);
                def.Normal = MeshMatch.ToCrumple(worldNormal);
                def.Striker.Mass = strikerMass;
                def.Striker.Radius = strikerRadius;
                def.Striker.Velocity = MeshMatch.ToCrumple(worldStrikerVelocity);
                result = instance.Submit(in def);
            }
            catch (CrumpleException error)
            {
                Warn(error.Message);
                return null;
            }
            Took(result);
            return result;
        }

        private bool TakesCollisions
        {
            get { return fromCollisions && instance != null && isActiveAndEnabled; }
        }

        private void FixedUpdate()
        {
            CrumpleWorld.BeginStep();
        }

        private void OnCollisionEnter(Collision collision)
        {
            Touched(collision);
        }

        private void OnCollisionStay(Collision collision)
        {
            Touched(collision);
        }

        // Of two bodies that dent, both tell of their pair: the impulse is that of the pair, whoever tells it and how often.
        private void Touched(Collision collision)
        {
            if (!TakesCollisions) return; // Unity tells disabled ones too
            CrumpleMesh other = collision.collider == null ? null : collision.collider.GetComponent<CrumpleMesh>();
            if (other != null && !other.TakesCollisions) other = null;
            try
            {
                PlaceInWorld();
                if (other != null) other.PlaceInWorld();
                CrumpleWorld.Report(collision, this, other);
            }
            catch (CrumpleException error)
            {
                Warn(error.Message);
            }
        }

        /// <summary>Tells Crumple where the object is: hits are in world space.</summary>
        private void PlaceInWorld()
        {
            Matrix4x4 place = filter.transform.localToWorldMatrix;
            for (int i = 0; i < 16; i++) Matrix[i] = place[i];
            instance.SetTransform(Matrix);
        }

        /// <summary>A hit arrived. The component may be gone afterwards.</summary>
        internal void Took(CrumpleHitResult result)
        {
            changed = true;
            if (Dented != null) Dented(this, result);
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
