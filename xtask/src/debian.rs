//! Programs of Debian sid with their own C library and Mesa's driver, unpacked into a folder beside the system.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::files::{empty, files, files_of, make, write};
use crate::stage::LeftOut;
use crate::workspace::{cmd, in_target, run, sh};

/// Signs the packages.
const KEYS: &str = "/usr/share/keyrings/debian-archive-keyring.gpg";

/// Options of `apt-get` that keep everything in a folder, @.
const APT: &str = "Dir::Etc::sourcelist=@/sources.list Dir::State::lists=@/lists Dir::State::status=@/status \
                   Dir::Cache::archives=@/debs Dir::Etc::sourceparts=/dev/null Dir::Cache::pkgcache= Dir::Cache::srcpkgcache= \
                   Acquire::Languages=none Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false Acquire::Retries=3 \
                   APT::Sandbox::User=root Debug::NoLocking=1";

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
    empty(folder)?;
    ["lists/partial", "debs/partial", "root"].iter().try_for_each(|part| make(folder.join(part)))?;
    write(folder.join("sources.list"), format!("deb [signed-by={KEYS}] {mirror} sid main\n"))?;
    write(folder.join("status"), "")?;
    let own = |option: &str| format!("-o{}", option.replace('@', &folder.to_string_lossy()));
    let options = &APT.split_whitespace().map(own).collect::<Vec<_>>();
    cmd!("apt-get {options...} -qq update").run()?;
    let download = ["-qq", "-y", "--no-install-recommends", "--download-only", "install"];
    cmd!("apt-get {options...} {download...} {packages...}").ignore_stdout().run()?;
    for package in files_of(folder.join("debs"), &["deb"])? {
        run!("dpkg-deb -x {package} {folder}/root")?;
    }
    sh().remove_path(folder.join("debs"))?;
    let script = format!(
        "#!/bin/sh\nR={}/root; L=$R/usr/lib/x86_64-linux-gnu\nexport VK_DRIVER_FILES=$R/usr/share/vulkan/icd.d/lvp_icd.json \
         {environment}\nexec $L/ld-linux-x86-64.so.2 --library-path $L:$R/usr/lib:$L/pulseaudio:$L/blas:$L/lapack --argv0 \
         $R/usr/bin/{name} $R/usr/bin/{name} \"$@\"\n",
        folder.display()
    );
    // Written last, and under another name first: a broken fetch leaves no program.
    write(folder.join("unfinished"), script)?;
    run!("chmod +x {folder}/unfinished")?;
    Ok(fs::rename(folder.join("unfinished"), folder.join(name))?)
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
