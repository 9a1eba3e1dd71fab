//! The Python environment of the ROS 2 peers, made once under `target/` and shared by all test binaries.

use super::Domain;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Set by a developer without network: tests that need the peers are skipped, loudly.
const SKIP: &str = "CAMWRIGHT_SKIP_PEERS";
/// Names another Python 3.11 than `python3.11` or `python3` of the search path.
const PYTHON: &str = "CAMWRIGHT_PYTHON";

/// A ready environment: real ROS 2 Jazzy and our interfaces built by the real rosidl.
#[derive(Debug)]
pub struct PeerEnv {
    root: PathBuf,
    /// Shared while any test uses the environment; who wants to make it anew waits.
    _in_use: File,
}

/// The environment, made if it is missing or out of date. `None` when the developer asked to skip the peers.
///
/// # Panics
/// When it cannot be made, with what pip, `CMake` or the compiler said; and when it is to be skipped under `CI=true`.
pub fn peer_env() -> Option<&'static PeerEnv> {
    static ENV: OnceLock<Option<PeerEnv>> = OnceLock::new();
    ENV.get_or_init(|| {
        if std::env::var_os(SKIP).is_some_and(|value| !value.is_empty() && value != "0") {
            assert!(!in_ci(), "{SKIP} is set under CI=true: the tests with real ROS 2 peers are not optional there");
            return None;
        }
        Some(PeerEnv::make())
    })
    .as_ref()
    .or_else(|| {
        eprintln!(
            "SKIPPED, NOT PASSED: {SKIP} is set, no real ROS 2 peer was asked (test {:?})",
            std::thread::current().name()
        );
        None
    })
}

/// Returns whether this is the continuous integration, which may not skip anything.
pub fn in_ci() -> bool {
    std::env::var("CI").is_ok_and(|value| value == "true" || value == "1")
}

impl PeerEnv {
    fn make() -> Self {
        let root = target_directory().join("ros-peers");
        std::fs::create_dir_all(&root).expect("the target directory can be written");
        let lock = File::create(root.join("lock")).expect("a lock file can be made");
        let support = repository().join("tests/support");
        let msgs = repository().join("msgs");
        let recipe = support.join("make_env.py");
        let faster = support.join("faster_build.cmake");
        let requirements = support.join("requirements.txt");
        let cyclone = support.join("cyclone_requirements.txt");
        let tables = support.join("tables_requirements.txt");

        // A virtual environment cannot be moved, so its place is part of what it is made from.
        let venv_hash = hash_of(&[&recipe, &requirements], root.to_string_lossy().as_bytes());
        let mut sources = vec![faster, msgs.join("package.xml"), msgs.join("CMakeLists.txt")];
        for kind in ["msg", "srv", "action", "standard"] {
            list_files(&msgs.join(kind), &mut sources);
        }
        let interfaces_hash = hash_of(&sources.iter().map(PathBuf::as_path).collect::<Vec<_>>(), venv_hash.as_bytes());
        let cyclone_hash = hash_of(&[&cyclone], venv_hash.as_bytes());
        let tables_hash = hash_of(&[&tables], venv_hash.as_bytes());
        let steps = [
            ("venv", &venv_hash, &requirements),
            ("interfaces", &interfaces_hash, &msgs),
            ("cyclone", &cyclone_hash, &cyclone),
            ("tables", &tables_hash, &tables),
        ];

        lock.lock_shared().expect("a file of our own can be locked");
        if steps.iter().any(|(step, hash, _)| !is_made(&root, step, hash)) {
            lock.unlock().expect("it was locked");
            lock.lock().expect("a file of our own can be locked");
            for (step, hash, source) in steps {
                // Another test binary may have made it while this one waited for the lock.
                if !is_made(&root, step, hash) {
                    make_step(&root, step, hash, &recipe, source);
                }
            }
            lock.unlock().expect("it was locked");
            lock.lock_shared().expect("a file of our own can be locked");
        }
        Self { root, _in_use: lock }
    }

    /// The `share` directories that hold rosidl's type descriptions: of the wheels and of what was built here.
    pub fn share_directories(&self) -> [PathBuf; 2] {
        [self.venv().join("share"), self.install().join("share")]
    }

    fn venv(&self) -> PathBuf {
        self.root.join("venv")
    }

    fn install(&self) -> PathBuf {
        self.root.join("interfaces/install")
    }

    /// The environment's Python with a script of `tests/support/`, or one with its whole path, in the given domain.
    pub fn python(&self, script: &str, domain: &Domain) -> Command {
        let mut command = Command::new(self.venv().join("bin/python"));
        self.enter(&mut command, domain);
        command.arg("-u").arg(repository().join("tests/support").join(script));
        command
    }

    /// Folder of the environment's programs.
    pub fn programs(&self) -> PathBuf {
        self.venv().join("bin")
    }

    /// Sets the variables that ROS 2 needs; the process stays on this machine, in the given domain.
    pub fn enter(&self, command: &mut Command, domain: &Domain) {
        let site = "lib/python3.11/site-packages";
        let mut libraries = vec![self.install().join("lib"), self.venv().join("lib")];
        let wheels = std::fs::read_dir(self.venv().join(site)).expect("the environment has been made");
        libraries.extend(wheels.flatten().map(|entry| entry.path()).filter(|path| {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            name.starts_with("ros_") && name.ends_with(".libs")
        }));
        let joined = |paths: &[PathBuf]| std::env::join_paths(paths).expect("no colon in the paths of this checkout");
        command
            .env("AMENT_PREFIX_PATH", joined(&[self.install(), self.venv()]))
            .env(
                "PYTHONPATH",
                joined(&[
                    self.install().join(site),
                    repository().join("tests/support"),
                    self.root.join("cyclone"),
                    self.root.join("tables"),
                ]),
            )
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("LD_LIBRARY_PATH", joined(&libraries))
            // The libraries are found by the line above; without this the wheels start the interpreter a second time to set it.
            .env("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "1")
            .env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env("ROS_DOMAIN_ID", domain.id().to_string())
            .env("ROS_LOG_DIR", self.root.join("log"))
            .env_remove("ROS_LOCALHOST_ONLY")
            .env_remove("ROS_STATIC_PEERS")
            .env_remove("ROS_NAMESPACE");
    }
}

/// A step leaves a stamp with the hash of what it was made from as its last act, so half a build has none.
fn is_made(root: &Path, step: &str, hash: &str) -> bool {
    std::fs::read_to_string(root.join(format!("{step}.stamp"))).is_ok_and(|stamp| stamp == hash)
}

fn make_step(root: &Path, step: &str, hash: &str, recipe: &Path, source: &Path) {
    let stamp = root.join(format!("{step}.stamp"));
    let _ = std::fs::remove_file(&stamp);
    eprintln!(
        "making {} for the tests with real ROS 2 peers, once; this takes a minute or two",
        root.join(step).display()
    );
    let mut command = if matches!(step, "cyclone" | "tables") {
        let mut pip = Command::new(root.join("venv/bin/python"));
        pip.args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--no-deps",
            "--upgrade",
            "--target",
        ]);
        pip.arg(root.join(step)).arg("-r").arg(source);
        pip
    } else {
        let mut python = Command::new(python_3_11());
        python.arg(recipe).arg(step).args([root, source]);
        python
    };
    let output = command.output().expect("the interpreter was found a moment ago");
    assert!(
        output.status.success(),
        "making the {step} of the ROS 2 peers failed (without network, {SKIP}=1 skips these tests):\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    std::fs::write(&stamp, hash).expect("the target directory can be written");
}

/// The wheels are built for Python 3.11 and nothing else.
fn python_3_11() -> String {
    let named = std::env::var(PYTHON).ok();
    let candidates = named.iter().map(String::as_str).chain(["python3.11", "python3"]);
    for candidate in candidates {
        let version = Command::new(candidate).arg("--version").output();
        if version.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).starts_with("Python 3.11.")) {
            return candidate.to_owned();
        }
    }
    panic!(
        "no Python 3.11 found as {PYTHON}, python3.11 or python3 (without it, {SKIP}=1 skips the tests with real ROS 2 peers)"
    );
}

/// The root of this checkout.
pub fn repository() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).expect("the package lies in nodes/ of the workspace").to_owned()
}

/// Cargo's build folder; Cargo gives tests a directory `tmp` in it.
pub fn target_directory() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("tmp lies in the target directory").to_owned()
}

fn list_files(directory: &Path, into: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(directory) else { return };
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() { list_files(&path, into) } else { into.push(path) }
    }
}

fn hash_of(files: &[&Path], first: &[u8]) -> String {
    let mut hash = Sha256::new();
    hash.update(first);
    for file in files {
        let content = std::fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        hash.update(file.to_string_lossy().as_bytes());
        hash.update(content.len().to_le_bytes());
        hash.update(&content);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
