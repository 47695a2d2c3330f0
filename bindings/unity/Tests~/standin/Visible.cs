// The tests look at what the stand-ins keep to themselves. Unity has no such door, so the package's own assemblies are not named
// here.
[assembly: System.Runtime.CompilerServices.InternalsVisibleTo("Crumple.Tests")]
