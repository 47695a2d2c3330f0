//! The Godot extension: packs it as an archive to unpack into a project, and tests it in the engine itself. The engine, its own C library
//! and Mesa's driver are packages of Debian sid, unpacked below the target directory beside the system. Another engine may be named by
//! `CRUMPLE_GODOT`.

use crate::prelude::*;
use std::net::UdpSocket;

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

pub fn run() -> Result<()> {
    let engine = engine()?;
    build()?;
    let project = lay_out(&in_target("godot/debug/libcrumple_godot.so"))?;
    let tests = Tests { engine: &engine, project: &project };
    // What the engine writes stays out of the user's folders.
    let _home = home(&project.with_file_name("home"));
    let unit = tests.headless("unit", &["--fixed-fps", "60"], THREADS);
    // The editor imports what the unit tests wrote.
    let imported = tests.import().and_then(|()| tests.headless("imported", &[], THREADS));
    let mut results =
        vec![("the extension's own tests", cargo(&["test"])), ("the classes", unit), ("the editor's import", imported)];
    for (physics, apart) in PHYSICS {
        let settings = format!("3d/physics_engine=\"{physics}\"\n3d/run_on_separate_thread={apart}\n");
        let settings = format!("{THREADS}\n[physics]\n\n{settings}");
        results.push((physics, tests.headless("physics", &["--fixed-fps", "60"], &settings)));
    }
    results.push(("two processes", tests.network()));
    results.push(("the extension loaded again", tests.reload()));
    results.push(("a render thread", tests.drawn(&["compute"], &format!("{THREADS}{RENDER_THREAD}"))));
    results.push(("the picture and the compute shaders", tests.drawn(&["rendered", "compute"], THREADS)));
    results.push(("the demo", tests.run(&["--headless", "--fixed-fps", "60", "--quit-after", "300"], &[])));
    if let Some(demo) = std::env::var_os(TRUCK_TOWN) {
        results.push(("Truck Town", tests.truck_town(Path::new(&demo))));
    }
    all_passed(results)
}

/// Builds the extension and its tests.
pub fn build() -> Result<()> {
    cargo(&["build"])?;
    cargo(&["test", "--no-run"])
}

fn cargo(what: &[&str]) -> Result<()> {
    let (manifest, target) = (manifest(), in_target("godot"));
    let cargo = cmd!("cargo {what...} --locked --manifest-path {manifest} --target-dir {target}");
    // The binding's own profile has no debug information: its bindings of the whole engine are large.
    Ok(cargo.env_remove("CARGO_PROFILE_DEV_DEBUG").run()?)
}

/// The program of the engine, fetched on the first call.
pub fn engine() -> Result<PathBuf> {
    debian::program(ENGINE, "godot-engine", PACKAGES, "godot", "")
}

/// Copies the example project with the extension, the hood and the car. Returns the copy's folder.
fn lay_out(library: &Path) -> Result<PathBuf> {
    let project = in_target("godot/project");
    empty_directory(&project)?;
    copy_sources(PROJECT, &["."], &project)?;
    copy(library, &project.join("addons/crumple/bin/libcrumple_godot.so"))?;
    copy("assets/demo/hood.glb", &project.join("assets/hood.glb"))?;
    lay_out_generated(&project)?;
    Ok(project)
}

/// Writes what the demo needs beside the files of the repository: the car, and the list of extensions that the editor writes when it
/// finds one.
fn lay_out_generated(project: &Path) -> Result<()> {
    // Wheels are nodes of their own.
    car::lay_out(&project.join("assets"), &["--moving", "wheel_*"])?;
    make(&project.join(".godot"))?;
    write(&project.join(".godot/extension_list.cfg"), "res://addons/crumple/crumple.gdextension\n")
}

/// Makes the engine write below a folder until the result is dropped.
pub fn home<'a>(folder: &Path) -> [PushEnv<'static>; 3] {
    HOME.map(|name| sh().push_env(name, folder.join(name)))
}

struct Tests<'a> {
    engine: &'a Path,
    project: &'a Path,
}

impl<'a> Tests<'a> {
    fn settings(&self, settings: &str) -> Result<()> {
        write(&self.project.join("override.cfg"), settings)
    }

    fn headless(&self, suite: &str, options: &[&str], settings: &str) -> Result<()> {
        self.settings(settings)?;
        self.run(&[&["--headless"], options, &["res://tests/tests.tscn"]].concat(), &["--", suite])
    }

    fn import(&self) -> Result<()> {
        let written =
            self.project.with_file_name("home").join(HOME[0]).join("godot/app_userdata/Crumple/sheet.crumple");
        copy(&written, &self.project.join("assets/sheet.crumple")).context("the unit tests write a set")?;
        self.run(&["--headless", "--import"], &[])
    }

    /// The editor loads the extension again, as it does when the library was rebuilt.
    fn reload(&self) -> Result<()> {
        self.settings(THREADS)?;
        self.run(&["--headless", "--editor", "--script", "res://tests/reload.gd"], &[])
    }

    /// Makes vehicles dent in a copy of Godot's demo, as the addon's README says, and crashes its van.
    fn truck_town(&self, demo: &Path) -> Result<()> {
        let project = self.project.with_file_name("truck_town");
        empty_directory(&project)?;
        copy_tree(demo, &project)?;
        copy_tree(&self.project.join("addons"), &project.join("addons"))?;
        for name in ["tests/truck_town.gd", ".godot/extension_list.cfg"] {
            copy(&self.project.join(name), &project.join(name))?;
        }
        let settings = "[autoload]\n\nDentVehicles=\"*res://addons/crumple/dent_vehicles.gd\"\n";
        let tests = Tests { project: &project, ..*self };
        tests.settings(&format!("{THREADS}\n{settings}"))?;
        tests.run(&["--headless", "--import"], &[])?;
        tests.run(&["--headless", "--fixed-fps", "60", "--script", "res://tests/truck_town.gd"], &[])
    }

    /// Draws on Mesa's software driver, on a display without a screen.
    fn drawn(&self, suites: &[&str], settings: &str) -> Result<()> {
        self.settings(settings)?;
        let display = Display::start()?;
        let _display = sh().push_env("DISPLAY", &display.name);
        // The fetched engine sets its own.
        let _driver = vulkan::lavapipe().ok().map(|driver| sh().push_env("VK_DRIVER_FILES", driver));
        let options = ["--rendering-driver", "vulkan", "--audio-driver", "Dummy", "--fixed-fps", "60"];
        self.run(&[&options[..], &["res://tests/tests.tscn"]].concat(), &[&["--"], suites].concat())
    }

    /// A server and a client. The server compares, and ends with an error if the client's damage is not its own.
    fn network(&self) -> Result<()> {
        self.settings(THREADS)?;
        // A port that nobody uses now.
        let port = UdpSocket::bind("127.0.0.1:0")?.local_addr()?.port().to_string();
        let scene = ["--headless", "res://tests/network.tscn"];
        let mut server = Command::from(self.engine(&scene, &["--", "server", &port]));
        let mut server = Background(server.spawn().context("starting the server")?);
        self.run(&scene, &["--", "client", &port])?;
        let ended = server.0.wait()?;
        ensure!(ended.success(), "the server ends with {ended}");
        Ok(())
    }

    fn engine(&self, options: &[&str], arguments: &[&str]) -> Cmd<'static> {
        let Self { engine, project } = self;
        cmd!("timeout {PATIENCE} {engine} --path {project} {options...} {arguments...}")
    }

    /// Runs the engine and looks through its output.
    fn run(&self, options: &[&str], arguments: &[&str]) -> Result<()> {
        let output = self.engine(options, arguments).ignore_status().output()?;
        let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
        let settings = read(&self.project.join("override.cfg")).unwrap_or_default();
        let leaks = settings.contains(RENDER_THREAD) || options.contains(&"--script");
        let theirs = |line: &&str| leaks && LEAKS.iter().any(|leak| line.contains(leak));
        let bad = text.lines().filter(|line| BAD.iter().any(|bad| line.contains(bad)) && !theirs(line));
        let bad: Vec<&str> = bad.collect();
        if !output.status.success() || !bad.is_empty() {
            println!("{text}");
        }
        ensure!(output.status.success(), "Godot ends with {}", output.status);
        ensure!(bad.is_empty(), "Godot reports: {}", bad.join("; "));
        text.lines().filter(|line| line.ends_with(" failed")).for_each(|line| println!("{line}"));
        Ok(())
    }
}

/// `cargo xtask addon`: the archive.
pub fn pack(options: &Options) -> Result<()> {
    let mut targets = vec![Target::host()?];
    if options.windows {
        tools::require(&[WINDOWS_RUST, MINGW])?;
        targets.push(Target::other(WINDOWS));
    }
    let stage = in_target("package/godot");
    empty_directory(&stage)?;
    let addon = stage.join(ADDON);
    copy_sources(PROJECT, &[ADDON], &stage)?;
    for target in &targets {
        println!("Building for {}; the bindings of the whole engine take minutes.", target.triple);
        copy_into(&release(target)?, &addon.join("bin"))?;
    }
    markdown::copy_page(&in_root(BINDING).join("README.md"), &addon)?;
    copy_licenses(&addon)?;
    let linked = licenses::linked_of(&manifest(), &targets)?;
    licenses::write_all(&linked, &addon)?;

    let out = in_root(&options.out);
    make(&out)?;
    let archive = out.join(format!("crumple-godot-{}.zip", VERSION));
    archive::write(&stage.join("addons"), &archive, time()?)?;
    if options.demo {
        let project = out.join("demo");
        empty_directory(&project)?;
        copy_sources(PROJECT, &["project.godot", "demo"], &project)?;
        copy_tree(&stage, &project)?;
        lay_out_generated(&project)?;
        println!("{0} is the demo: godot --path {0}", project.display());
    }
    announce(&archive)?;
    Ok(())
}

fn manifest() -> PathBuf {
    in_root(BINDING).join("Cargo.toml")
}

/// The library of a release build, without paths of this machine.
fn release(target: &Target) -> Result<PathBuf> {
    let directory = in_target("godot");
    let cargo = target.cargo(&["build", "--release", "--locked"])?;
    cargo.arg("--manifest-path").arg(manifest()).arg("--target-dir").arg(&directory).run()?;
    let name = if target.is_windows() { "crumple_godot.dll" } else { "libcrumple_godot.so" };
    let library = if target.cross { directory.join(&target.triple) } else { directory }.join("release").join(name);
    nothing_of_this_machine(std::slice::from_ref(&library))?;
    Ok(library)
}
