// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The OPC UA client of the tests: asyncua in a Python environment of its own, made once under `target/`.

use super::env::{are_peers_skipped, python_3_11};
use super::{Peer, repository, target_directory};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Python of the ready environment.
#[derive(Debug)]
pub struct UaClientEnv(PathBuf);

/// The environment, made if it is missing or out of date. `None` when the developer asked to skip the peers.
///
/// # Panics
/// When it cannot be made, with what pip said; and when it is to be skipped under `CI=true`.
pub fn ua_client_env() -> Option<&'static UaClientEnv> {
    static ENV: OnceLock<UaClientEnv> = OnceLock::new();
    if are_peers_skipped() {
        return None;
    }
    Some(ENV.get_or_init(UaClientEnv::make))
}

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?} failed:\n{}", String::from_utf8_lossy(&output.stderr));
}

impl UaClientEnv {
    fn make() -> Self {
        let root = target_directory().join("opcua-client");
        std::fs::create_dir_all(&root).expect("the target directory can be written");
        let lock = File::create(root.join("lock")).expect("a lock file can be made");
        lock.lock().expect("a file of our own can be locked");
        let (venv, stamp) = (root.join("venv"), root.join("stamp"));
        let requirements = repository().join("tests/support/opcua_requirements.txt");
        let wanted = std::fs::read_to_string(&requirements).expect("the requirements");
        let python = venv.join("bin/python");
        // A virtual environment cannot be moved, so its place is part of what it is made from.
        let wanted = format!("{}\n{wanted}", root.display());
        if std::fs::read_to_string(&stamp).is_ok_and(|made| made == wanted) {
            return Self(python);
        }
        let _not_there = std::fs::remove_dir_all(&venv);
        run(Command::new(python_3_11()).args(["-m", "venv"]).arg(&venv));
        let options = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "-r"];
        run(Command::new(&python).args(options).arg(&requirements));
        std::fs::write(&stamp, wanted).expect("the target directory can be written");
        Self(python)
    }

    /// Starts a client and waits until it is connected.
    pub fn connect(&self, url: &str) -> Peer {
        let script: &Path = &repository().join("tests/support/opcua_client.py");
        Peer::start_script("opcua_client.py", Command::new(&self.0).arg("-u").arg(script).arg(url))
    }
}
