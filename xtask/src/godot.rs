//! Tests of the Godot extension in the engine itself. The engine, its own C library and Mesa's driver are packages of Debian sid,
//! unpacked below the target directory beside the system. Another engine may be named by `CRUMPLE_GODOT`.

use std::fs;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use xshell::{PushEnv, cmd};

use crate::debian;
use crate::demo;
use crate::stage::{Outcome, all_passed};
use crate::vulkan;
use crate::wine;
use crate::workspace::{Workspace, empty_directory, files};

pub const BINDING: &str = "bindings/godot";
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

pub fn run(workspace: &Workspace) -> Result<Outcome> {
    if cfg!(not(all(target_os = "linux", target_arch = "x86_64"))) {
        return Ok(Outcome::NotApplicable("the engine is fetched for Linux on x86-64 only".into()));
    }
    let engine = match engine(workspace) {
        Ok(engine) => engine,
        Err(error) => {
            return Ok(Outcome::LeftOut(format!(
                "Godot cannot be fetched: {error:#}. Type: {ENGINE}=/path/to/godot4.6 cargo xtask test --only godot"
            )));
        }
    };
    version(workspace)?;
    build(workspace)?;
    let project = lay_out(workspace, &workspace.target.join("godot/debug/libcrumple_godot.so"))?;
    let tests = Tests { workspace, engine: &engine, project: &project };
    let _home = tests.home();
    let unit = tests.headless("unit", &["--fixed-fps", "60"], THREADS);
    // The editor imports what the unit tests wrote.
    let imported = tests.import().and_then(|()| tests.headless("imported", &[], THREADS));
    let mut results = vec![
        ("the extension's own tests", cargo(workspace, &["test"])),
        ("the classes", unit),
        ("the editor's import", imported),
    ];
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
    all_passed(results)?;
    Ok(Outcome::Passed)
}

/// Builds the extension and its tests.
pub fn build(workspace: &Workspace) -> Result<()> {
    cargo(workspace, &["build"])?;
    cargo(workspace, &["test", "--no-run"])
}

fn cargo(workspace: &Workspace, what: &[&str]) -> Result<()> {
    let (manifest, target) = (workspace.path(BINDING).join("Cargo.toml"), workspace.target.join("godot"));
    let cargo = cmd!(workspace.shell, "cargo {what...} --locked --manifest-path {manifest} --target-dir {target}");
    // The binding's own profile has no debug information: its bindings of the whole engine are large.
    Ok(cargo.env_remove("CARGO_PROFILE_DEV_DEBUG").run()?)
}

/// The addon says which version it is.
fn version(workspace: &Workspace) -> Result<()> {
    let file = "project/addons/crumple/plugin.cfg";
    let text = fs::read_to_string(workspace.path(BINDING).join(file)).with_context(|| format!("reading {file}"))?;
    let line = format!("version=\"{}\"", workspace.version);
    ensure!(text.contains(&line), "{BINDING}/{file} lacks {line}, the workspace's");
    Ok(())
}

/// The program of the engine, fetched on the first call.
pub fn engine(workspace: &Workspace) -> Result<PathBuf> {
    if let Some(engine) = std::env::var_os(ENGINE) {
        return Ok(engine.into());
    }
    let folder = workspace.target.join("godot-engine");
    let program = folder.join("godot");
    if program.exists() {
        return Ok(program);
    }
    println!("fetching Godot from Debian sid, about 170 MB, into {}", folder.display());
    debian::fetch(workspace, &folder, PACKAGES, "godot", "")?;
    let version = cmd!(workspace.shell, "{program} --headless --version").quiet().read()?;
    println!("Godot {version}");
    Ok(program)
}

/// Copies the example project with the extension, the hood and the car. Returns the copy's folder.
fn lay_out(workspace: &Workspace, library: &Path) -> Result<PathBuf> {
    let (from, project) = (workspace.path(BINDING).join("project"), workspace.target.join("godot/project"));
    empty_directory(&project)?;
    let copy = |from: &Path, to: PathBuf| -> Result<()> {
        fs::create_dir_all(to.parent().context("files lie in folders")?)?;
        fs::copy(from, &to).with_context(|| format!("copying {} to {}", from.display(), to.display()))?;
        Ok(())
    };
    for file in files(&from)? {
        let name = file.strip_prefix(&from)?;
        // What the editor or a build left there is not part of the project.
        if !name.starts_with(".godot") && !name.starts_with("addons/crumple/bin") && !name.starts_with("assets") {
            copy(&file, project.join(name))?;
        }
    }
    copy(library, project.join("addons/crumple/bin/libcrumple_godot.so"))?;
    copy(&workspace.path("assets/demo/hood.glb"), project.join("assets/hood.glb"))?;
    lay_out_generated(workspace, &project)?;
    Ok(project)
}

/// Writes what the demo needs beside the files of the repository: the car, and the list of extensions that the editor writes when it
/// finds one.
pub fn lay_out_generated(workspace: &Workspace, project: &Path) -> Result<()> {
    // Wheels are nodes of their own.
    demo::lay_out_car(workspace, &project.join("assets"), &["--moving", "wheel_*"])?;
    fs::create_dir_all(project.join(".godot"))?;
    fs::write(project.join(".godot/extension_list.cfg"), "res://addons/crumple/crumple.gdextension\n")?;
    Ok(())
}

/// Makes the engine write below a folder until the result is dropped.
pub fn home<'a>(workspace: &'a Workspace, folder: &Path) -> [PushEnv<'a>; 3] {
    HOME.map(|name| workspace.shell.push_env(name, folder.join(name)))
}

struct Tests<'a> {
    workspace: &'a Workspace,
    engine: &'a Path,
    project: &'a Path,
}

impl<'a> Tests<'a> {
    /// Keeps what the engine writes beside the project, out of the user's folders.
    fn home(&self) -> [PushEnv<'a>; 3] {
        home(self.workspace, &self.project.with_file_name("home"))
    }

    fn home_of(&self, name: &str) -> PathBuf {
        self.project.with_file_name("home").join(name)
    }

    fn headless(&self, suite: &str, options: &[&str], settings: &str) -> Result<()> {
        fs::write(self.project.join("override.cfg"), settings)?;
        self.run(&[&["--headless"], options, &["res://tests/tests.tscn"]].concat(), &["--", suite])
    }

    fn import(&self) -> Result<()> {
        let written = self.home_of(HOME[0]).join("godot/app_userdata/Crumple/sheet.crumple");
        let sheet = self.project.join("assets/sheet.crumple");
        fs::copy(&written, sheet).with_context(|| format!("the unit tests did not write {}", written.display()))?;
        self.run(&["--headless", "--import"], &[])
    }

    /// The editor loads the extension again, as it does when the library was rebuilt.
    fn reload(&self) -> Result<()> {
        fs::write(self.project.join("override.cfg"), THREADS)?;
        self.run(&["--headless", "--editor", "--script", "res://tests/reload.gd"], &[])
    }

    /// Makes vehicles dent in a copy of Godot's demo, as the addon's README says, and crashes its van.
    fn truck_town(&self, demo: &Path) -> Result<()> {
        let project = self.project.with_file_name("truck_town");
        empty_directory(&project)?;
        let ours = ["addons", "tests/truck_town.gd", ".godot/extension_list.cfg"].map(|name| self.project.join(name));
        let own = files(demo)?.into_iter().map(|file| (demo, file));
        let added = files(&ours[0])?.into_iter().chain(ours[1..].iter().cloned()).map(|file| (self.project, file));
        for (from, file) in own.chain(added) {
            let to = project.join(file.strip_prefix(from)?);
            fs::create_dir_all(to.parent().context("files lie in folders")?)?;
            fs::copy(&file, to).with_context(|| format!("copying {}", file.display()))?;
        }
        let settings = "[autoload]\n\nDentVehicles=\"*res://addons/crumple/dent_vehicles.gd\"\n";
        fs::write(project.join("override.cfg"), format!("{THREADS}\n{settings}"))?;
        let tests = Tests { project: &project, ..*self };
        tests.run(&["--headless", "--import"], &[])?;
        tests.run(&["--headless", "--fixed-fps", "60", "--script", "res://tests/truck_town.gd"], &[])
    }

    /// Draws on Mesa's software driver, on a display without a screen.
    fn drawn(&self, suites: &[&str], settings: &str) -> Result<()> {
        fs::write(self.project.join("override.cfg"), settings)?;
        let (mut display, number) = wine::display()?;
        let sh = &self.workspace.shell;
        let result = {
            let _display = sh.push_env("DISPLAY", format!(":{number}"));
            // The fetched engine sets its own.
            let _driver = vulkan::lavapipe().ok().map(|driver| sh.push_env("VK_DRIVER_FILES", driver));
            let options = ["--rendering-driver", "vulkan", "--audio-driver", "Dummy", "--fixed-fps", "60"];
            self.run(&[&options[..], &["res://tests/tests.tscn"]].concat(), &[&["--"], suites].concat())
        };
        let _ = display.kill();
        let _ = display.wait();
        result
    }

    /// A server and a client. The server compares, and ends with an error if the client's damage is not its own.
    fn network(&self) -> Result<()> {
        fs::write(self.project.join("override.cfg"), THREADS)?;
        // A port that nobody uses now.
        let port = UdpSocket::bind("127.0.0.1:0")?.local_addr()?.port().to_string();
        let scene = ["--headless", "res://tests/network.tscn"];
        let server = Command::new("timeout")
            .arg(PATIENCE)
            .arg(self.engine)
            .arg("--path")
            .arg(self.project)
            .args(scene)
            .args(["--", "server", &port])
            .envs(HOME.map(|name| (name, self.home_of(name))))
            .spawn();
        let mut server = server.context("starting the server")?;
        let client = self.run(&scene, &["--", "client", &port]);
        if client.is_err() {
            let _ = server.kill();
        }
        let ended = server.wait()?;
        client?;
        ensure!(ended.success(), "the server ends with {ended}");
        Ok(())
    }

    /// Runs the engine and looks through its output.
    fn run(&self, options: &[&str], arguments: &[&str]) -> Result<()> {
        let Self { workspace, engine, project } = self;
        let run = cmd!(workspace.shell, "timeout {PATIENCE} {engine} --path {project} {options...} {arguments...}");
        let output = run.ignore_status().output()?;
        let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
        let settings = fs::read_to_string(project.join("override.cfg")).unwrap_or_default();
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
