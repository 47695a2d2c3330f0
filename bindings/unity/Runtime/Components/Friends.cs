using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Crumple.Tests")]
