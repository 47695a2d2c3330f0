// The editor's API, as far as the package uses it.
using System;
using System.Collections.Generic;
using UnityEngine;

namespace UnityEditor
{
    [AttributeUsage(AttributeTargets.Class)] public sealed class InitializeOnLoadAttribute : Attribute { }

    public static class AssemblyReloadEvents
    {
        public delegate void AssemblyReloadCallback();
        public static event AssemblyReloadCallback beforeAssemblyReload;

        internal static void Tell() { if (beforeAssemblyReload != null) beforeAssemblyReload(); }
    }
}

namespace UnityEditor.AssetImporters
{
    [AttributeUsage(AttributeTargets.Class)]
    public class ScriptedImporterAttribute : Attribute
    {
        public ScriptedImporterAttribute(int version, string[] exts, string[] overrideExts) { }
    }

    public abstract class ScriptedImporter : UnityEngine.Object
    {
        public abstract void OnImportAsset(AssetImportContext ctx);
    }

    public class AssetImportContext
    {
        internal readonly Dictionary<string, UnityEngine.Object> Objects = new Dictionary<string, UnityEngine.Object>();
        internal readonly List<string> Errors = new List<string>();
        internal UnityEngine.Object Main;

        public string assetPath { get; internal set; }
        public void AddObjectToAsset(string identifier, UnityEngine.Object obj) { Objects.Add(identifier, obj); }
        public void SetMainObject(UnityEngine.Object obj) { Main = obj; }
        public void LogImportError(string msg) { Errors.Add(msg); }
    }
}
