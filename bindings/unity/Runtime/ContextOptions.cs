namespace Crumple
{
    /// <summary>How a context works.</summary>
    public sealed class ContextOptions
    {
        /// <summary>
        /// Threads that deform: 0 one for each core, 1 only the calling thread, up to 1024. Without meaning where
        /// <see cref="Tasks"/> is set. Default 0.
        /// </summary>
        public int Threads { get; set; }

        /// <summary>Receives messages. Default null: none.</summary>
        public CrumpleLogHandler Log { get; set; }

        /// <summary>Your job system, instead of threads of Crumple's own. Default null: none.</summary>
        public CrumpleTaskHandler Tasks { get; set; }

        /// <summary>
        /// How many of its threads may work at once. Only decides how finely work is cut: never the result. Default 1.
        /// </summary>
        public int TaskWorkers { get; set; } = 1;
    }
}
