// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Packages for users: `cargo install`, the .deb and the tarball, each run in a root that holds nothing but the package and the
//! shared libraries of the system.

use crate::support;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::{Folder, repository};

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Folder of a root in which programs run without the repository, a home and the rest of this computer.
struct CleanRoot(PathBuf);

impl CleanRoot {
    /// A root with the shared libraries that a program needs.
    fn with_libraries_of(root: PathBuf, program: &Path) -> Self {
        for folder in ["proc", "tmp"] {
            std::fs::create_dir_all(root.join(folder)).expect("our folder");
        }
        let libraries = run(Command::new("ldd").arg(program));
        for library in libraries.split_whitespace().filter(|word| word.starts_with('/')) {
            let copy = root.join(&library[1..]);
            std::fs::create_dir_all(copy.parent().expect("a folder")).expect("our folder");
            std::fs::copy(library, copy).expect("a library of the system");
        }
        Self(root)
    }

    /// Runs a program of the root, from the folder `/tmp` of the root.
    fn run(&self, program: &str, words: &[&str]) -> Output {
        let mut command = Command::new("unshare");
        command.args(["--map-root-user", "--mount", "--pid", "--fork", "--mount-proc", "--wd=/tmp", "--root"]);
        command
            .arg(&self.0)
            .arg(program)
            .args(words)
            .env_clear()
            .env("PATH", std::env::var_os("PATH").unwrap_or_default());
        command.output().expect("unshare is part of util-linux")
    }

    /// Lists the jobs, and checks and plans one of them.
    fn works(&self, program: &str) {
        let run = |words: &[&str]| {
            let output = self.run(program, words);
            let (text, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
            assert!(output.status.success() && errors.is_empty(), "{program} {words:?}: {text}{errors}");
            text.into_owned()
        };
        assert!(run(&["list", "jobs"]).contains("four_lobe_camshaft"));
        assert!(run(&["check", "four_lobe_camshaft"]).starts_with("CLEAN: four_lobe_camshaft"));
        assert!(run(&["plan", "plate_cam", "--out", "plan"]).starts_with("PLANNED: plate_cam"));
        assert!(self.0.join("tmp/plan/summary.json").is_file());
    }
}

/// Folder of the binaries under test.
fn binaries() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_camwright")).parent().expect("Cargo's folder")
}

/// Builds both packages from the binaries under test; returns tarball and .deb.
fn packages(folder: &Folder) -> [PathBuf; 2] {
    let mut command = Command::new(repository().join("nodes/camwright/packaging/build.py"));
    command.arg("--binaries").arg(binaries()).arg("--out").arg(folder.path()).arg("--fast");
    let paths = run(&mut command);
    let mut paths = paths.lines().map(PathBuf::from);
    let two = [paths.next().expect("the tarball"), paths.next().expect("the .deb")];
    assert_eq!(paths.next(), None);
    two
}

fn files(root: &Path, folder: &Path, into: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        match entry.file_type().expect("it exists").is_dir() {
            true => files(root, &entry.path(), into),
            false => drop(into.insert(entry.path().strip_prefix(root).expect("below").display().to_string())),
        }
    }
}

fn files_below(root: &Path) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    files(root, root, &mut all);
    all
}

fn unzipped(path: &Path) -> String {
    run(Command::new("gzip").arg("-dc").arg(path))
}

#[test]
fn the_deb_and_the_tarball_run_in_a_clean_root() {
    let folder = Folder::new("packages");
    let [tarball, deb] = packages(&folder);
    let root = folder.join("root");
    run(Command::new("dpkg-deb").arg("-x").arg(&deb).arg(&root));
    run(Command::new("tar").arg("-xf").arg(&tarball).arg("-C").arg(folder.path()));
    let unpacked = folder.join(tarball.file_name().expect("a name").to_string_lossy().trim_end_matches(".tar.gz"));

    let (installed, all) = (root.join("usr"), files_below(&root.join("usr")));
    assert_eq!(all, files_below(&unpacked), "both hold the same");
    for file in [
        "bin/camwright",
        "lib/camwright/machine_sim",
        "share/camwright/params/nodes.yaml",
        "share/camwright/params/jobs/four_lobe_camshaft.yaml",
        "share/camwright/urdf/lathe.urdf",
        "share/bash-completion/completions/camwright",
        "share/zsh/vendor-completions/_camwright",
        "share/fish/vendor_completions.d/camwright.fish",
        "share/man/man1/camwright.1.gz",
        "share/man/man1/camwright-bag-info.1.gz",
        "share/doc/camwright/copyright",
        "share/doc/camwright/changelog.gz",
    ] {
        assert!(all.contains(file), "{file} is not in the packages: {all:?}");
    }
    let licences = unzipped(&installed.join("share/doc/camwright/THIRD_PARTY_LICENSES.gz"));
    for package in ["clap", "rustdds", "ros2-client", "mcap", "zstd-sys", "nalgebra"] {
        assert!(licences.lines().any(|line| line.starts_with(&format!("{package} "))), "{package} has no licence");
    }
    for words in ["Permission is hereby granted, free of charge", "Apache License", "zstd/LICENSE"] {
        assert!(licences.contains(words), "{words}");
    }
    let field = |name: &str| run(Command::new("dpkg-deb").arg("-f").arg(&deb).arg(name)).trim().to_owned();
    assert_eq!((field("Package"), field("Version")), ("camwright".to_owned(), env!("CARGO_PKG_VERSION").to_owned()));
    assert!(field("Depends").starts_with("libc6 (>= 2."), "{}", field("Depends"));

    let program = installed.join("lib/camwright/camwright");
    CleanRoot::with_libraries_of(root.clone(), &program).works("/usr/bin/camwright");
    // Params beside the program come before those inside of it: a machine that only this folder has is found, with both layouts.
    for prefix in [&installed, &unpacked] {
        let params = prefix.join("share/camwright/params/machines");
        let own = std::fs::read_to_string(params.join("lathe.yaml")).expect("a machine");
        std::fs::write(params.join("own.yaml"), own.replace("name: lathe", "name: own")).expect("our folder");
        let listed = run(Command::new(prefix.join("bin/camwright")).args(["list", "machines"]).current_dir("/"));
        assert!(listed.lines().any(|line| line.starts_with("own ")), "{listed}");
    }
}

#[test]
fn the_packages_are_the_same_every_time() {
    let (one, two) = (Folder::new("packages-one"), Folder::new("packages-two"));
    for (first, second) in packages(&one).into_iter().zip(packages(&two)) {
        let read = |path: &Path| std::fs::read(path).expect("a package");
        assert!(read(&first) == read(&second), "{} differs", first.display());
    }
}

/// In the target folder of the tests. Without the other packages of the workspace some crates have fewer features, and most of the
/// suite compiles again.
#[test]
#[ignore = "compiles for minutes; run it by name before a release"]
fn cargo_install_needs_the_sources_no_longer() {
    let folder = Folder::new("cargo-install");
    let target = binaries().parent().expect("the target folder");
    let root = folder.join("root");
    let mut command = Command::new(env!("CARGO"));
    command.args([
        "install",
        "--path",
        "nodes/camwright",
        "--locked",
        "--debug",
        "--no-track",
        "--quiet",
        "--target-dir",
    ]);
    command.arg(target).arg("--root").arg(&root).current_dir(repository());
    run(&mut command);
    let names: Vec<String> =
        ["axis_interpolator", "camwright", "job_planner", "machine_hal", "machine_sim", "run_logger"]
            .iter()
            .map(|name| format!("bin/{name}"))
            .collect();
    assert_eq!(files_below(&root).into_iter().collect::<Vec<_>>(), names);
    CleanRoot::with_libraries_of(root.clone(), &root.join("bin/camwright")).works("/bin/camwright");
}

/// No registry is reachable from a test, so the image is not built here: its instructions are read.
#[test]
fn the_containerfile_copies_what_exists() {
    let path = repository().join("nodes/camwright/packaging/Containerfile");
    let text = std::fs::read_to_string(&path).expect("the Containerfile");
    let text = text.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n").replace("\\\n", " ");
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    let mut stages = Vec::new();
    for words in lines.iter().filter(|words| !words.is_empty()) {
        match words[0] {
            "FROM" => {
                assert!(words[1].contains(':'), "{words:?} names no version");
                stages.push(words.get(3).copied().unwrap_or_default());
            }
            "COPY" => match words[1].strip_prefix("--from=") {
                Some(stage) => assert!(stages.contains(&stage), "{words:?} names no stage"),
                None => {
                    for source in &words[1..words.len() - 1] {
                        assert!(repository().join(source).exists(), "{source} does not exist");
                    }
                }
            },
            "RUN" | "WORKDIR" | "ARG" | "USER" | "ENTRYPOINT" | "CMD" => {}
            other => panic!("{other} is no instruction that this image needs"),
        }
    }
    let manifest = std::fs::read_to_string(repository().join("Cargo.toml")).expect("the workspace");
    let version =
        manifest.split("rust-version = \"").nth(1).and_then(|rest| rest.split('"').next()).expect("a version");
    assert!(text.starts_with(&format!("FROM rust:{version}-")), "the image has the Rust of the workspace");
    assert!(text.contains("nodes/camwright/packaging/build.py --out /package"));
    assert_eq!(stages, ["build", ""]);
}
