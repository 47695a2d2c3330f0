//! Programs of Debian sid with their own C library and Mesa's driver, unpacked into a folder beside the system.

use crate::prelude::*;

/// Signs the packages.
const KEYS: &str = "/usr/share/keyrings/debian-archive-keyring.gpg";

/// The program `name` of `packages`, unpacked with what they need below the target directory on the first call, unless the environment
/// variable `own` names another. `environment` has more words for the program's `export`, in which `$R` is where the packages are.
pub fn program(own: &str, folder: &str, packages: &[&str], name: &str, environment: &str) -> Result<PathBuf> {
    if let Some(program) = std::env::var_os(own) {
        return Ok(program.into());
    }
    let folder = in_target(folder);
    let program = folder.join(name);
    if !program.exists() {
        println!("fetching {name} from Debian sid, 170 to 290 MB, into {}", folder.display());
        fetch(&folder, packages, name, environment).with_context(|| {
            LeftOut::Missing(format!("{name} cannot be fetched. Name yours: {own}=/path/to/{name}"))
        })?;
    }
    Ok(program)
}

/// Unpacks packages, and writes the program `folder/name`, which starts `name` of them.
fn fetch(folder: &Path, packages: &[&str], name: &str, environment: &str) -> Result<()> {
    let mirror = mirror()?;
    empty_directory(folder)?;
    for part in ["lists/partial", "debs/partial", "root"] {
        make(&folder.join(part))?;
    }
    fs::write(folder.join("sources.list"), format!("deb [signed-by={KEYS}] {mirror} sid main\n"))?;
    fs::write(folder.join("status"), "")?;
    let set = |key: &str, path: &str| format!("-o{key}={}", folder.join(path).display());
    let options = [
        set("Dir::Etc::sourcelist", "sources.list"),
        set("Dir::State::lists", "lists"),
        set("Dir::State::status", "status"),
        set("Dir::Cache::archives", "debs"),
        "-oDir::Etc::sourceparts=/dev/null".into(),
        "-oDir::Cache::pkgcache=".into(),
        "-oDir::Cache::srcpkgcache=".into(),
        "-oAcquire::Languages=none".into(),
        "-oAcquire::IndexTargets::deb::DEP-11::DefaultEnabled=false".into(),
        "-oAcquire::Retries=3".into(),
        "-oAPT::Sandbox::User=root".into(),
        "-oDebug::NoLocking=1".into(),
    ];
    let options = &options;
    cmd!("apt-get {options...} -qq update").run()?;
    let download = ["-qq", "-y", "--no-install-recommends", "--download-only", "install"];
    cmd!("apt-get {options...} {download...} {packages...}").ignore_stdout().run()?;
    let root = folder.join("root");
    for package in files_of(&folder.join("debs"), &["deb"])? {
        run!("dpkg-deb -x {package} {root}")?;
    }
    fs::remove_dir_all(folder.join("debs"))?;
    let script = format!(
        "#!/bin/sh\nR={}; L=$R/usr/lib/x86_64-linux-gnu\nexport VK_DRIVER_FILES=$R/usr/share/vulkan/icd.d/lvp_icd.json \
         {environment}\nexec $L/ld-linux-x86-64.so.2 --library-path $L:$R/usr/lib:$L/pulseaudio:$L/blas:$L/lapack --argv0 \
         $R/usr/bin/{name} $R/usr/bin/{name} \"$@\"\n",
        root.display()
    );
    // Written last, and under another name first: a broken fetch leaves no program.
    let (unfinished, program) = (folder.join(format!("{name}.part")), folder.join(name));
    fs::write(&unfinished, script)?;
    run!("chmod +x {unfinished}")?;
    fs::rename(&unfinished, &program)?;
    Ok(())
}

/// The Debian mirror that this machine uses.
fn mirror() -> Result<String> {
    let mut sources = vec![PathBuf::from("/etc/apt/sources.list")];
    sources.extend(files(Path::new("/etc/apt/sources.list.d")).unwrap_or_default());
    let text: String = sources.iter().filter_map(|file| fs::read_to_string(file).ok()).collect();
    let mut words = text.lines().filter(|line| !line.trim_start().starts_with('#')).flat_map(str::split_whitespace);
    let found = words.find(|word| word.starts_with("http") && word.trim_end_matches('/').ends_with("/debian"));
    found.map(str::to_owned).context("this machine's sources of apt-get name no mirror of Debian")
}
