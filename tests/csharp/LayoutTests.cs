using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;
using Crumple;
using Crumple.Native;

/// <summary>Sizes and offsets, as a C compiler sees the header, against those of the C# structs; and the defaults.</summary>
static class LayoutTests
{
    /// <summary>
    /// Lines "struct size alignment" and "struct.field offset size", which a program generated from the header prints.
    /// </summary>
    public static string Table;

    public static void SizesAndOffsets()
    {
        Assembly assembly = typeof(CrumpleMark).Assembly;
        HashSet<string> seen = new HashSet<string>();
        foreach (string line in File.ReadAllLines(Table))
        {
            string[] words = line.Split(' ');
            string[] names = words[0].Split('.');
            Type type = assembly.GetType("Crumple." + names[0], true);
            Check.That(type.IsValueType && type.IsLayoutSequential, names[0] + " is a sequential struct");
            if (names.Length == 1)
            {
                Check.Same(int.Parse(words[1]), Marshal.SizeOf(type), "size of " + names[0]);
                // As a field, so that arrays of them are right too.
                Check.Same(2 * Marshal.SizeOf(type), Twice(type), names[0] + "[2]");
                seen.Add(names[0]);
                continue;
            }
            string field = names[1];
            Check.Same(int.Parse(words[1]), (int)Marshal.OffsetOf(type, field), "offset of " + words[0]);
            Check.Same(int.Parse(words[2]), SizeOfField(type.GetField(field)), "size of " + words[0]);
            seen.Add(words[0]);
        }
        // And nothing more than C has.
        foreach (Type type in assembly.GetTypes().Where(type => type.IsValueType && !type.IsEnum && type.Namespace == "Crumple"))
        {
            if (!seen.Contains(type.Name)) continue;
            foreach (FieldInfo field in type.GetFields(BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic))
                Check.That(seen.Contains(type.Name + "." + field.Name), "C has " + type.Name + "." + field.Name);
        }
        Check.That(seen.Contains("CrumpleContactHit") && seen.Contains("CrumpleMark.Reserved"), "the table is whole");
    }

    static int Twice(Type type)
    {
        Array two = Array.CreateInstance(type, 2);
        GCHandle pin = GCHandle.Alloc(two, GCHandleType.Pinned);
        long stride = Marshal.UnsafeAddrOfPinnedArrayElement(two, 1).ToInt64() - Marshal.UnsafeAddrOfPinnedArrayElement(two, 0).ToInt64();
        pin.Free();
        return (int)(2 * stride);
    }

    static int SizeOfField(FieldInfo field)
    {
        object[] attributes = field.GetCustomAttributes(typeof(System.Runtime.CompilerServices.FixedBufferAttribute), false);
        if (attributes.Length == 1)
        {
            var array = (System.Runtime.CompilerServices.FixedBufferAttribute)attributes[0];
            return array.Length * Marshal.SizeOf(array.ElementType);
        }
        return field.FieldType.IsEnum ? Marshal.SizeOf(Enum.GetUnderlyingType(field.FieldType)) : Marshal.SizeOf(field.FieldType);
    }

    /// <summary>Every def says its own size as C sees it, and what comes back by value is what the header promises.</summary>
    public static unsafe void Defaults()
    {
        int defs = 0;
        foreach (MethodInfo method in typeof(NativeMethods).GetMethods().Where(method => method.Name.EndsWith("_def_default")))
        {
            object def = method.Invoke(null, null);
            FieldInfo size = def.GetType().GetField("StructSize");
            Check.Same((uint)Marshal.SizeOf(def), (uint)size.GetValue(def), method.Name);
            defs++;
        }
        Check.That(defs >= 12, defs + " defs");
        CrumpleInstanceDef instance = CrumpleInstanceDef.Default;
        Check.Same(64u, instance.MarkCapacity, "mark capacity");
        for (int i = 0; i < 16; i++) Check.Same(i % 5 == 0 ? 1f : 0f, instance.LocalToWorld[i], "identity");
        CrumpleExampleSetOptions options = CrumpleExampleSetDef.Default.Options;
        Check.That(options.Mirror && options.HeldRims, "bools of options");
    }

    /// <summary>All functions that are declared can be called.</summary>
    public static void EveryFunctionIsExported()
    {
        foreach (MethodInfo method in typeof(NativeMethods).GetMethods(BindingFlags.Static | BindingFlags.Public))
        {
            if ((method.Attributes & MethodAttributes.PinvokeImpl) == 0) continue;
            Marshal.Prelink(method);
            Check.Count++;
        }
        Check.Throws<EntryPointNotFoundException>(() => crumple_is_not_there());
    }

    [DllImport(NativeMethods.Library)]
    static extern void crumple_is_not_there();
}
