//! The Blender extension: packs it with the wheel, and tests the packed file in Blender.

use crate::prelude::*;

const BINDING: &str = "bindings/blender";
const MANIFEST: &str = "blender_manifest.toml";
/// Blender as a Python module, in two versions.
const MODULES: &[&str] = &["bpy42", NEWEST];
pub const NEWEST: &str = "bpy50";
/// Blender with a window.
const PACKAGES: &[&str] =
    &["blender", "mesa-vulkan-drivers", "python3-numpy", "python3-cattr", "python3-requests", "python3-zstandard"];
/// Where that Blender finds its files and its Python.
const FOLDERS: &str = "PYTHONHOME=$R/usr BLENDER_SYSTEM_RESOURCES=$R/usr/share/blender \
                       BLENDER_SYSTEM_SCRIPTS=$R/usr/share/blender/scripts \
                       BLENDER_SYSTEM_DATAFILES=$R/usr/share/blender/datafiles";

#[derive(Args)]
pub struct Options {
    /// Folder for the archive
    #[arg(long, value_name = "DIR", default_value = "out/extension")]
    out: PathBuf,
    /// Also dent the car of assets/car with it in Blender without a window, and draw this into car.png there; this installs
    /// `bpy`, about 400 MB
    #[arg(long)]
    picture: bool,
}

/// `cargo xtask extension`: the archive for this system, which Blender installs.
pub fn run(options: &Options) -> Result<()> {
    let wheel = python::build(true, &in_target("package/blender-wheel"))?;
    let archive = pack(&wheel, &in_root(&options.out))?;
    if options.picture {
        let python = module(NEWEST)?;
        let script = in_root(BINDING).join("examples/dent_car.py");
        let picture = archive.with_file_name("car.png");
        let home = in_target("blender-extension/home");
        empty_directory(&home)?;
        let _home = sh().push_env("BLENDER_USER_RESOURCES", &home);
        silent!("{python} -B {script} {archive} {picture}")?;
        println!("{}", picture.display());
    }
    Ok(())
}

/// Runs the extension's tests on the packed file, in the `bpy` of each of two Blenders and in a third one's window.
pub fn stage() -> Result<()> {
    let pythons = MODULES.iter().map(|name| module(name)).collect::<Result<Vec<_>>>()?;
    let folder = in_target("blender-extension");
    let (examples, wheel) = python::with_package(&folder.join("wheel"))?;
    let archive = pack(&wheel, &folder)?;
    let _environment = [
        sh().push_env("BLENDER_USER_RESOURCES", folder.join("home")),
        sh().push_env("CRUMPLE_EXTENSION", &archive),
        sh().push_env("CRUMPLE_EXAMPLES_PYTHON", &examples),
        sh().push_env("PYTHONDONTWRITEBYTECODE", "1"),
    ];
    let tests = in_root(BINDING).join("tests/test_extension.py");
    for python in &pythons {
        empty_directory(&folder.join("home"))?;
        run!("{python} {tests}")?;
    }
    if !XVFB.here() {
        return Ok(());
    }
    match debian::program("CRUMPLE_BLENDER", "blender-window", PACKAGES, "blender", FOLDERS) {
        Ok(program) => window(&program, &folder, &archive),
        Err(error) => bail!(LeftOut::Part(format!("Blender with a window: {error:#}"))),
    }
}

/// A Python with Blender as its module `bpy`, as `bindings/blender/tests/NAME.txt` says. Installed on the first call.
pub fn module(name: &str) -> Result<PathBuf> {
    let requirements = format!("{BINDING}/tests/{name}.txt");
    python::environment(PYTHON311, &format!("blender-{name}"), &requirements)
}

/// Drives the panel, the hits and the heat map on a display without a screen. The picture lies beside the archive.
fn window(program: &Path, folder: &Path, archive: &Path) -> Result<()> {
    empty_directory(&folder.join("home"))?;
    let (script, hood) = (in_root(BINDING).join("tests/window.py"), in_root("assets/demo/hood.glb"));
    let picture = folder.join("window.png");
    let display = Display::start()?;
    let options =
        ["--gpu-backend", "vulkan", "--enable-event-simulate", "--factory-startup", "--python-use-system-env"];
    let shown =
        cmd!("timeout 150 {program} {options...} --python-exit-code 1 --python {script} -- {archive} {hood} {picture}");
    let shown = shown.env("DISPLAY", &display.name).env("XDG_RUNTIME_DIR", folder.join("home"));
    let shown = shown.ignore_status().output()?;
    let text = [shown.stdout, shown.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    let good = shown.status.success() && text.contains("the window works") && !text.contains("Traceback");
    if !good {
        println!("{text}");
    }
    ensure!(good, "Blender's window does not work; it ends with {}", shown.status);
    println!("{}", picture.display());
    Ok(())
}

/// Packs the extension with the wheel into `out`.
fn pack(wheel: &Path, out: &Path) -> Result<PathBuf> {
    // The archive has the folder that Blender gives the extension.
    let stage = in_target("package/blender/crumple");
    empty_directory(&stage)?;
    copy_sources(&format!("{BINDING}/extension"), &["."], &stage)?;
    copy_licenses(&stage)?;
    markdown::copy_page(&in_root(BINDING).join("README.md"), &stage)?;
    let name = name(wheel)?;
    copy_into(wheel, &stage.join("wheels"))?;
    let manifest = read(&stage.join(MANIFEST))?;
    let (before, after) = manifest.split_once("\n[permissions]").context("the manifest lacks [permissions]")?;
    let system = system(&name).with_context(|| format!("Blender has no name for the system of {name}"))?;
    let lines = format!("platforms = [\"{system}\"]\nwheels = [\"./wheels/{name}\"]\n");
    write(&stage.join(MANIFEST), format!("{before}{lines}\n[permissions]{after}"))?;
    let path = out.join(format!("crumple-blender-{VERSION}-{system}.zip"));
    archive::write(&stage, &path)?;
    Ok(path)
}

/// Blender's name for the system that a wheel is for.
fn system(wheel: &str) -> Option<&'static str> {
    let arm = wheel.contains("arm64") || wheel.contains("aarch64");
    match () {
        () if wheel.contains("linux") && !arm => Some("linux-x64"),
        () if wheel.contains("win") && !wheel.contains("darwin") => {
            Some(if arm { "windows-arm64" } else { "windows-x64" })
        }
        () if wheel.contains("macosx") => Some(if arm { "macos-arm64" } else { "macos-x64" }),
        () => None,
    }
}
