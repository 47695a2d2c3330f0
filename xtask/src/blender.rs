//! The Blender extension: packs it with the wheel, and tests the packed file in Blender.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;

use crate::files::{copy_into, copy_licenses, copy_sources, empty, name, read, write};
use crate::package::{archive, markdown};
use crate::stage::LeftOut;
use crate::tools::{PYTHON311, XVFB};
use crate::workspace::{Display, VERSION, cmd, ended, in_root, in_target, run, sh, silent};
use crate::{debian, python};

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
        let (python, picture) = (module(NEWEST)?, archive.with_file_name("car.png"));
        let _home = sh().push_env("BLENDER_USER_RESOURCES", empty(in_target("blender-extension/home"))?);
        silent!("{python} -B {BINDING}/examples/dent_car.py {archive} {picture}")?;
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
    for python in &pythons {
        empty(folder.join("home"))?;
        run!("{python} {BINDING}/tests/test_extension.py")?;
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
    python::environment(PYTHON311, &format!("blender-{name}"), &format!("{BINDING}/tests/{name}.txt"))
}

/// Drives the panel, the hits and the heat map on a display without a screen. The picture lies beside the archive.
fn window(program: &Path, folder: &Path, archive: &Path) -> Result<()> {
    let (home, picture) = (empty(folder.join("home"))?, folder.join("window.png"));
    let (script, hood) = (in_root(BINDING).join("tests/window.py"), in_root("assets/demo/hood.glb"));
    let _display = Display::start()?;
    let shown = cmd!(
        "timeout 150 {program} --gpu-backend vulkan --enable-event-simulate --factory-startup --python-use-system-env
         --python-exit-code 1 --python {script} -- {archive} {hood} {picture}"
    );
    let (ended, text) = ended(shown.env("XDG_RUNTIME_DIR", home))?;
    let good = ended.success() && text.contains("the window works") && !text.contains("Traceback");
    if !good {
        println!("{text}");
    }
    ensure!(good, "Blender's window does not work; it ends with {ended}");
    println!("{}", picture.display());
    Ok(())
}

/// Packs the extension with the wheel into `out`.
fn pack(wheel: &Path, out: &Path) -> Result<PathBuf> {
    // The archive has the folder that Blender gives the extension.
    let stage = empty(in_target("package/blender/crumple"))?;
    copy_sources(&format!("{BINDING}/extension"), &["."], &stage)?;
    copy_licenses(&stage)?;
    markdown::copy_page(&Path::new(BINDING).join("README.md"), &stage)?;
    copy_into(wheel, &stage.join("wheels"))?;
    let (name, manifest) = (name(wheel)?, stage.join(MANIFEST));
    let system = system(&name).with_context(|| format!("Blender has no name for the system of {name}"))?;
    let lines = format!("platforms = [\"{system}\"]\nwheels = [\"./wheels/{name}\"]\n\n[permissions]");
    let text = read(&manifest)?;
    ensure!(text.contains("[permissions]"), "{MANIFEST} lacks [permissions]");
    write(manifest, text.replacen("[permissions]", &lines, 1))?;
    let path = out.join(format!("crumple-blender-{VERSION}-{system}.zip"));
    archive::write(&stage, &path)?;
    Ok(path)
}

/// Blender's name for the system that a wheel is for.
fn system(wheel: &str) -> Option<&'static str> {
    let arm = wheel.contains("arm64") || wheel.contains("aarch64");
    let known = [
        ("linux", "linux-x64", None),
        ("macosx", "macos-x64", Some("macos-arm64")),
        ("win", "windows-x64", Some("windows-arm64")),
    ];
    let (.., plain, of_arm) = known.into_iter().find(|(name, ..)| wheel.contains(name))?;
    if arm { of_arm } else { Some(plain) }
}
