// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The Python environment of the ROS 2 peers, made once under `target/` and shared by all test binaries.

use super::Domain;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Set by a developer without network: tests that need the peers are skipped, loudly.
const SKIP: &str = "CAMWRIGHT_SKIP_PEERS";
/// Names another Python 3.11 than `python3.11` or `python3` of the search path.
const PYTHON: &str = "CAMWRIGHT_PYTHON";
/// Names the ROS 2 distribution of the peers: `jazzy` (default) or `kilted`.
const DISTRIBUTION: &str = "CAMWRIGHT_ROS_DISTRIBUTION";

/// ROS 2 distribution of the peers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RosDistribution {
    /// Tested by default.
    Jazzy,
    /// Tested on request.
    Kilted,
}

impl RosDistribution {
    /// Reads the distribution from the environment.
    ///
    /// # Panics
    /// The variable names another distribution.
    fn from_environment() -> Self {
        match std::env::var(DISTRIBUTION).unwrap_or_default().as_str() {
            "" | "jazzy" => Self::Jazzy,
            "kilted" => Self::Kilted,
            other => panic!("{DISTRIBUTION} is {other:?}; it must be jazzy or kilted"),
        }
    }

    /// Name in file names and arguments.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jazzy => "jazzy",
            Self::Kilted => "kilted",
        }
    }

    /// Version of a package of the distribution, as pinned for the peers.
    ///
    /// # Panics
    /// The package is not pinned.
    pub fn version_of(self, package: &str) -> String {
        let file = repository().join(format!("tests/support/{}_requirements.txt", self.name()));
        let pinned = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let version = pinned.lines().find_map(|line| line.strip_prefix(package)?.strip_prefix("=="));
        version.unwrap_or_else(|| panic!("{} does not pin {package}", file.display())).to_owned()
    }
}

/// A ready environment: a real ROS 2 distribution and our interfaces built by the real rosidl.
#[derive(Debug)]
pub struct PeerEnv {
    /// Distribution of the rclpy peers.
    pub distribution: RosDistribution,
    root: PathBuf,
    /// Shared while any test uses the environment; who wants to make it anew waits.
    _in_use: File,
}

/// The environment, made if it is missing or out of date. `None` when the developer asked to skip the peers.
///
/// # Panics
/// When it cannot be made, with what pip, `CMake` or the compiler said; and when it is to be skipped under `CI=true`.
pub fn peer_env() -> Option<&'static PeerEnv> {
    static ENV: OnceLock<PeerEnv> = OnceLock::new();
    if are_peers_skipped() {
        return None;
    }
    Some(ENV.get_or_init(PeerEnv::make))
}

/// Returns whether the developer asked to skip the peers, and reports it.
///
/// # Panics
/// When they are to be skipped under `CI=true`.
pub(super) fn are_peers_skipped() -> bool {
    let is_skipped = std::env::var_os(SKIP).is_some_and(|value| !value.is_empty() && value != "0");
    if is_skipped {
        assert!(!in_ci(), "{SKIP} is set under CI=true: the tests with real ROS 2 peers are not optional there");
        eprintln!(
            "SKIPPED, NOT PASSED: {SKIP} is set, no real ROS 2 peer was asked (test {:?})",
            std::thread::current().name()
        );
    }
    is_skipped
}

/// Returns whether this is the continuous integration, which may not skip anything.
pub fn in_ci() -> bool {
    std::env::var("CI").is_ok_and(|value| value == "true" || value == "1")
}

impl PeerEnv {
    fn make() -> Self {
        let distribution = RosDistribution::from_environment();
        let root = target_directory().join(match distribution {
            RosDistribution::Jazzy => "ros-peers",
            RosDistribution::Kilted => "ros-peers-kilted",
        });
        std::fs::create_dir_all(&root).expect("the target directory can be written");
        let lock = File::create(root.join("lock")).expect("a lock file can be made");
        let recipe = repository().join("tests/support/make_env.py");
        let mut making = Command::new(python_3_11());
        let made = making
            .arg(recipe)
            .args(["--distribution", distribution.name()])
            .arg(&root)
            .output()
            .expect("the interpreter was found a moment ago");
        assert!(
            made.status.success(),
            "making {} for the tests with real ROS 2 peers failed (without network, {SKIP}=1 skips these tests):\n{}",
            root.display(),
            String::from_utf8_lossy(&made.stderr)
        );
        lock.lock_shared().expect("a file of our own can be locked");
        Self { distribution, root, _in_use: lock }
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

/// The wheels are built for Python 3.11 and nothing else.
pub(super) fn python_3_11() -> String {
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
