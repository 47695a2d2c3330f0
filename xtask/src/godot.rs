//! The Godot extension: packs it as an archive to unpack into a project, and tests it in the engine itself. The engine, its own C library
//! and Mesa's driver are packages of Debian sid, unpacked below the target directory beside the system. Another engine may be named by
//! `CRUMPLE_GODOT`.

use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use clap::Args;
use xshell::{Cmd, PushEnv};

use crate::files::{copy, copy_into, copy_licenses, copy_sources, copy_tree, empty, read, write};
use crate::package::{archive, licenses, markdown, nothing_of_this_machine};
use crate::stage::all_passed;
use crate::target::{Target, WINDOWS};
use crate::tools::{self, MINGW, WINDOWS_RUST};
use crate::workspace::{Background, Display, VERSION, cmd, ended, in_root, in_target, sh};
use crate::{car, debian, vulkan};

const BINDING: &str = "bindings/godot";
const PROJECT: &str = "bindings/godot/project";
/// The addon's folder in a project.
const ADDON: &str = "addons/crumple";
/// Names the program of a Godot of version 4.6 or later.
const ENGINE: &str = "CRUMPLE_GODOT";
const PACKAGES: &[&str] = &["godot", "mesa-vulkan-drivers"];
/// Default threads hang on two cores under Vulkan (godotengine/godot#102877).
const THREADS: &str = "[threading]\n\nworker_pool/max_threads=8\n";
/// The physics engines, and whether each has a thread of its own.
const PHYSICS: &[(&str, bool)] =
    &[("Jolt Physics", false), ("GodotPhysics3D", false), ("Jolt Physics", true), ("GodotPhysics3D", true)];
/// Where the engine writes.
const HOME: [&str; 3] = ["XDG_DATA_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"];
/// What an engine's output must not contain: errors in scripts, panics, and reports of leaks.
const BAD: &[&str] = &["SCRIPT ERROR", "panicked", "leaked", "still in use at exit", "Parse Error"];
/// A thread of its own for the renderer. Godot 4.6 then leaks objects at exit, also in an empty project.
const RENDER_THREAD: &str = "\n[rendering]\n\ndriver/threads/thread_model=2\n";
/// What the engine leaks without us: with a render thread, and when a script ends the editor or a game that plays a sound.
const LEAKS: &[&str] = &["leaked at exit", "were leaked", "still in use at exit"];
/// Names a folder with the demo `3d/truck_town` of godotengine/godot-demo-projects, which is not ours to keep.
const TRUCK_TOWN: &str = "CRUMPLE_TRUCK_TOWN";
/// Seconds after which a run is ended.
const PATIENCE: &str = "240";

#[derive(Args)]
pub struct Options {
    /// Folder for the archive
    #[arg(long, value_name = "DIR", default_value = "out/addon")]
    out: PathBuf,
    /// Build the extension for Windows too, with MinGW
    #[arg(long)]
    windows: bool,
    /// Also write the demo project to DIR/demo, ready to run
    #[arg(long)]
    demo: bool,
}

pub fn stage() -> Result<()> {
    let (engine, project) = (engine()?, empty(in_target("godot/project"))?);
    build()?;
    // The example project with the extension, the hood and the car.
    copy_sources(PROJECT, &["."], &project)?;
    copy(in_target("godot/debug/libcrumple_godot.so"), &project.join("addons/crumple/bin/libcrumple_godot.so"))?;
    copy("assets/demo/hood.glb", &project.join("assets/hood.glb"))?;
    lay_out_generated(&project)?;
    // What the engine writes stays out of the user's folders. It draws on Mesa's software driver, on a display without a screen; the
    // fetched engine sets its own driver.
    let (_home, _display) = (home(&project.with_file_name("home")), Display::start()?);
    let _driver = vulkan::lavapipe().ok().map(|driver| sh().push_env("VK_DRIVER_FILES", driver));
    let godot = Godot { engine, project };
    let headless = |suite| format!("--headless --fixed-fps 60 res://tests/tests.tscn -- {suite}");
    let drawn = |suites| {
        format!("--rendering-driver vulkan --audio-driver Dummy --fixed-fps 60 res://tests/tests.tscn -- {suites}")
    };
    let mut results = vec![
        ("the extension's own tests", cargo(&["test"])),
        ("the classes", godot.run(THREADS, &headless("unit"))),
        ("the editor's import", godot.import()),
        ("two processes", godot.network()),
        // As the editor does when the library was rebuilt.
        ("the extension loaded again", godot.run(THREADS, "--headless --editor --script res://tests/reload.gd")),
        ("a render thread", godot.run(&format!("{THREADS}{RENDER_THREAD}"), &drawn("compute"))),
        ("the picture and the compute shaders", godot.run(THREADS, &drawn("rendered compute"))),
        ("the demo", godot.run(THREADS, "--headless --fixed-fps 60 --quit-after 300")),
    ];
    for (physics, apart) in PHYSICS {
        let settings = format!("3d/physics_engine=\"{physics}\"\n3d/run_on_separate_thread={apart}\n");
        results.push((physics, godot.run(&format!("{THREADS}\n[physics]\n\n{settings}"), &headless("physics"))));
    }
    if let Some(demo) = std::env::var_os(TRUCK_TOWN) {
        results.push(("Truck Town", godot.truck_town(Path::new(&demo))));
    }
    all_passed(results)
}

/// Builds the extension and its tests.
pub fn build() -> Result<()> {
    cargo(&["build"])?;
    cargo(&["test", "--no-run"])
}

fn cargo(what: &[&str]) -> Result<()> {
    let target = in_target("godot");
    let cargo = cmd!("cargo {what...} --locked --manifest-path {BINDING}/Cargo.toml --target-dir {target}");
    // The binding's own profile has no debug information: its bindings of the whole engine are large.
    Ok(cargo.env_remove("CARGO_PROFILE_DEV_DEBUG").run()?)
}

/// The program of the engine, fetched on the first call.
pub fn engine() -> Result<PathBuf> {
    debian::program(ENGINE, "godot-engine", PACKAGES, "godot", "")
}

/// Writes what the demo needs beside the files of the repository: the car, and the list of extensions that the editor writes when it
/// finds one.
fn lay_out_generated(project: &Path) -> Result<()> {
    // Wheels are nodes of their own.
    car::lay_out(&project.join("assets"), &["--moving", "wheel_*"])?;
    write(project.join(".godot/extension_list.cfg"), "res://addons/crumple/crumple.gdextension\n")
}

/// Makes the engine write below a folder until the result is dropped.
pub fn home(folder: &Path) -> [PushEnv<'static>; 3] {
    HOME.map(|name| sh().push_env(name, folder.join(name)))
}

struct Godot {
    engine: PathBuf,
    project: PathBuf,
}

impl Godot {
    /// The editor imports what the unit tests wrote.
    fn import(&self) -> Result<()> {
        let home = self.project.with_file_name("home").join(HOME[0]);
        let (written, set) = ("godot/app_userdata/Crumple/sheet.crumple", self.project.join("assets/sheet.crumple"));
        copy(home.join(written), &set).context("the unit tests write a set")?;
        self.run(THREADS, "--headless --import")?;
        self.run(THREADS, "--headless res://tests/tests.tscn -- imported")
    }

    /// Makes vehicles dent in a copy of Godot's demo, as the addon's README says, and crashes its van.
    fn truck_town(&self, demo: &Path) -> Result<()> {
        let project = empty(self.project.with_file_name("truck_town"))?;
        copy_tree(demo, &project)?;
        copy_tree(self.project.join("addons"), &project.join("addons"))?;
        for name in ["tests/truck_town.gd", ".godot/extension_list.cfg"] {
            copy(self.project.join(name), &project.join(name))?;
        }
        let settings = "\n[autoload]\n\nDentVehicles=\"*res://addons/crumple/dent_vehicles.gd\"\n";
        let (godot, settings) = (Self { project, engine: self.engine.clone() }, format!("{THREADS}{settings}"));
        godot.run(&settings, "--headless --import")?;
        godot.run(&settings, "--headless --fixed-fps 60 --script res://tests/truck_town.gd")
    }

    /// A server and a client. The server compares, and ends with an error if the client's damage is not its own.
    fn network(&self) -> Result<()> {
        // A port that nobody uses now.
        let port = UdpSocket::bind("127.0.0.1:0")?.local_addr()?.port();
        let scene = |of| format!("--headless res://tests/network.tscn -- {of} {port}");
        let mut server = Command::from(self.engine(THREADS, &scene("server"))?);
        let mut server = Background(server.spawn().context("starting the server")?);
        self.run(THREADS, &scene("client"))?;
        let ended = server.0.wait()?;
        ensure!(ended.success(), "the server ends with {ended}");
        Ok(())
    }

    fn engine(&self, settings: &str, arguments: &str) -> Result<Cmd<'static>> {
        let (Self { engine, project }, arguments) = (self, arguments.split(' '));
        let file = project.join("override.cfg");
        // Another engine may read it now.
        if read(&file).unwrap_or_default() != settings {
            write(file, settings)?;
        }
        Ok(cmd!("timeout {PATIENCE} {engine} --path {project} {arguments...}"))
    }

    /// Runs the engine and looks through its output.
    fn run(&self, settings: &str, arguments: &str) -> Result<()> {
        let (ended, text) = ended(self.engine(settings, arguments)?)?;
        let leaks = settings.contains(RENDER_THREAD) || arguments.contains("--script");
        let theirs = |line: &&str| leaks && LEAKS.iter().any(|leak| line.contains(leak));
        let bad = |line: &&str| BAD.iter().any(|bad| line.contains(bad)) && !theirs(line);
        let bad: Vec<&str> = text.lines().filter(bad).collect();
        if !ended.success() || !bad.is_empty() {
            println!("{text}");
        }
        ensure!(ended.success(), "Godot ends with {ended}");
        ensure!(bad.is_empty(), "Godot reports: {}", bad.join("; "));
        text.lines().filter(|line| line.ends_with(" failed")).for_each(|line| println!("{line}"));
        Ok(())
    }
}

pub fn run(options: &Options) -> Result<()> {
    let mut targets = vec![Target::host()?];
    if options.windows {
        tools::require(&[WINDOWS_RUST, MINGW])?;
        targets.push(Target::other(WINDOWS));
    }
    let stage = empty(in_target("package/godot"))?;
    let addon = stage.join(ADDON);
    copy_sources(PROJECT, &[ADDON], &stage)?;
    for target in &targets {
        println!("Building for {}; the bindings of the whole engine take minutes.", target.triple);
        copy_into(&release(target)?, &addon.join("bin"))?;
    }
    markdown::copy_page(&Path::new(BINDING).join("README.md"), &addon)?;
    copy_licenses(&addon)?;
    licenses::write_all(&licenses::linked_of(BINDING, &targets)?, &addon)?;
    let out = in_root(&options.out);
    if options.demo {
        let project = empty(out.join("demo"))?;
        copy_sources(PROJECT, &["project.godot", "demo"], &project)?;
        copy_tree(&stage, &project)?;
        lay_out_generated(&project)?;
        println!("{0} is the demo: godot --path {0}", project.display());
    }
    archive::write(&stage.join("addons"), &out.join(format!("crumple-godot-{VERSION}.zip")))
}

/// The library of a release build, without paths of this machine.
fn release(target: &Target) -> Result<PathBuf> {
    let folder = in_target("godot");
    let cargo = target.cargo(&["build", "--release", "--locked", "--manifest-path", "bindings/godot/Cargo.toml"])?;
    cargo.arg("--target-dir").arg(&folder).run()?;
    let name = if target.is_windows() { "crumple_godot.dll" } else { "libcrumple_godot.so" };
    let library = if target.cross { folder.join(&target.triple) } else { folder }.join("release").join(name);
    nothing_of_this_machine(std::slice::from_ref(&library))?;
    Ok(library)
}
