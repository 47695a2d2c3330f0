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
    /// Lines "struct size" and "struct.field offset size", which a program generated from the header prints.
    /// </summary>
    public static string Table;

    public static void SizesAndOffsets()
    {
        string[] table = File.ReadAllLines(Table);
        HashSet<string> named = new HashSet<string>(table.Select(line => line.Split(' ')[0]));
        List<string> own = new List<string>();
        foreach (Type type in typeof(CrumpleMark).Assembly.GetTypes().Where(type => type.Namespace == "Crumple" && named.Contains(type.Name)))
        {
            Check.That(type.IsValueType && type.IsLayoutSequential, type.Name + " is a sequential struct");
            own.Add(type.Name + " " + Stride(type));
            foreach (FieldInfo field in type.GetFields(BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic))
                own.Add(type.Name + "." + field.Name + " " + Marshal.OffsetOf(type, field.Name) + " " + SizeOfField(field));
        }
        Check.Same("", string.Join("; ", table.Except(own)), "only C has");
        Check.Same("", string.Join("; ", own.Except(table)), "only C# has");
        Check.That(named.Contains("CrumpleContactHit") && named.Contains("CrumpleMark.Reserved"), "the table is whole");
    }

    /// <summary>The bytes of an element of an array.</summary>
    static long Stride(Type type)
    {
        Array two = Array.CreateInstance(type, 2);
        GCHandle pin = GCHandle.Alloc(two, GCHandleType.Pinned);
        long stride = Marshal.UnsafeAddrOfPinnedArrayElement(two, 1).ToInt64() - Marshal.UnsafeAddrOfPinnedArrayElement(two, 0).ToInt64();
        pin.Free();
        return stride;
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
