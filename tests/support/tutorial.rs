// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tutorials of `docs/tutorials`: every command of a page runs, and prints what the page shows.
//!
//! A block ```` ```console ```` holds commands behind `$ ` with their output below; a line `...` stands for any number of lines, and `...` at
//! the end of a line for its rest. A block behind `<!-- file: NAME -->` is written to the folder in which the commands run. All commands of a
//! page run in one shell; what runs in the background ends with the page.

use super::{Domain, Folder, Guarded, PeerEnv, repository};
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command};
use std::time::{Duration, Instant};

/// Time after which a command of a tutorial counts as stuck.
const LIMIT: Duration = Duration::from_secs(600);
/// Begin of the line behind the output of a command; its exit code follows.
const DONE: &str = "tutorial command ended with ";

/// Step of a tutorial.
#[derive(Debug)]
enum Step {
    File { name: String, text: String },
    Command { line: usize, command: String, output: Vec<String> },
}

/// Files and commands of a page, in order.
fn steps(page: &str) -> Vec<Step> {
    let (mut steps, mut file) = (Vec::new(), None);
    let mut lines = page.lines().enumerate();
    while let Some((_, line)) = lines.next() {
        if let Some(name) = line.strip_prefix("<!-- file: ").and_then(|rest| rest.strip_suffix(" -->")) {
            file = Some(name.to_owned());
            continue;
        }
        let Some(language) = line.strip_prefix("```") else { continue };
        let block: Vec<(usize, &str)> = lines.by_ref().take_while(|(_, line)| *line != "```").collect();
        if let Some(name) = file.take() {
            steps.push(Step::File { name, text: block.iter().map(|(_, line)| format!("{line}\n")).collect() });
        } else if language == "console" {
            for (index, line) in block {
                if let Some(command) = line.strip_prefix("$ ") {
                    steps.push(Step::Command { line: index + 1, command: command.to_owned(), output: Vec::new() });
                } else if let Some(Step::Command { output, .. }) = steps.last_mut() {
                    output.push(line.to_owned());
                }
            }
        }
    }
    steps
}

/// Returns whether the output of a command is the shown one; trailing blanks do not count.
fn is_shown(shown: &[String], output: &[&str]) -> bool {
    match shown.split_first() {
        None => output.iter().all(|line| line.trim().is_empty()),
        Some((line, rest)) if line == "..." => (0..=output.len()).any(|skipped| is_shown(rest, &output[skipped..])),
        Some((line, rest)) => {
            let is_same = |first: &str| match line.strip_suffix("...") {
                Some(begin) => first.starts_with(begin),
                None => line.trim_end() == first.trim_end(),
            };
            output.split_first().is_some_and(|(first, others)| is_same(first) && is_shown(rest, others))
        }
    }
}

/// Shell that runs the commands of a page.
struct Shell {
    process: Guarded,
    stdin: ChildStdin,
}

impl Shell {
    /// Starts `shell` in a folder, with programs in these folders.
    fn start(name: &str, folder: &Path, domain: &Domain, mut shell: Command, mut path: Vec<PathBuf>) -> Self {
        path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
        shell
            .args(["--norc", "--noprofile"])
            .current_dir(folder)
            // Processes in the background belong to the group of the shell.
            .process_group(0)
            .env("PATH", std::env::join_paths(path).expect("no colon in the paths of this checkout"))
            .env("ROS_DOMAIN_ID", domain.id().to_string())
            .env("XDG_STATE_HOME", folder.join("state"))
            // maturin builds the Python module from the crates of the tests.
            .env("CARGO", repository().join("tests/support/cargo_for_maturin.sh"))
            .env("REPOSITORY", repository());
        let mut process = Guarded::start(name, &mut shell);
        let mut stdin = process.take_stdin();
        writeln!(stdin, "exec 2>&1").expect("the shell reads");
        Self { process, stdin }
    }

    /// Exit code and output of a command.
    fn run(&mut self, command: &str) -> (String, Vec<String>) {
        writeln!(self.stdin, "{{ {command}\n}} </dev/null\nprintf '\\n{DONE}%d\\n' $?").expect("the shell reads");
        let deadline = Instant::now() + LIMIT;
        let mut lines = Vec::new();
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let Some(line) = self.process.line_within(left) else {
                panic!("{command} did not end within {LIMIT:?}, or ended the shell; it printed\n{}", lines.join("\n"));
            };
            if let Some(code) = line.strip_prefix(DONE) {
                return (code.to_owned(), lines);
            }
            lines.push(line);
        }
    }
}

impl Drop for Shell {
    fn drop(&mut self) {
        // An error means that the group has ended.
        let _ended = Command::new("kill").args(["-KILL", "--", &format!("-{}", self.process.id())]).output();
    }
}

/// Follows a tutorial in a folder of its own; with the programs and libraries of ROS 2 if `env` is given.
pub fn follow(name: &str, env: Option<&PeerEnv>) {
    let (folder, domain) = (Folder::new(&format!("tutorial-{name}")), Domain::reserve());
    let programs = Path::new(env!("CARGO_BIN_EXE_camwright")).parent().expect("it lies in a folder");
    let mut path = vec![programs.to_owned()];
    let mut shell = Command::new("bash");
    if let Some(env) = env {
        env.enter(&mut shell, &domain);
        path.push(env.programs());
    }
    follow_page(name, folder.path(), Shell::start(name, folder.path(), &domain, shell, path))
        .unwrap_or_else(|difference| panic!("{difference}"));
}

/// Follows a tutorial in this folder, with the programs of another, in this shell: as another user.
///
/// # Errors
/// A command that fails or prints something else, with the logs.
pub fn follow_in(name: &str, (folder, programs): (&Path, &Path), shell: Command) -> Result<(), String> {
    let domain = Domain::reserve();
    let shell = Shell::start(name, folder, &domain, shell, vec![programs.to_owned()]);
    follow_page(name, folder, shell)
}

fn follow_page(name: &str, folder: &Path, mut shell: Shell) -> Result<(), String> {
    let page = repository().join("docs/tutorials").join(name);
    let text = std::fs::read_to_string(&page).expect("a tutorial");
    let (mut commands, mut compared) = (0, 0);
    for step in steps(&text) {
        match step {
            Step::File { name, text } => std::fs::write(folder.join(name), text).expect("a file of the page"),
            Step::Command { line, command, output } => {
                let (code, lines) = shell.run(&command);
                let printed = lines.join("\n");
                if code != "0" && !command.contains("|| ") {
                    return Err(format!("{name}:{line}: {command}: exit code {code}\n{printed}\n{}", logs(folder)));
                }
                let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
                if !output.is_empty() && !is_shown(&output, &lines) {
                    let difference = "does not print what the page shows, but";
                    return Err(format!("{name}:{line}: {command} {difference}\n{printed}\n{}", logs(folder)));
                }
                commands += 1;
                compared += usize::from(!output.is_empty());
            }
        }
    }
    assert!(commands >= 2 && compared >= 1, "{name}: {commands} commands, {compared} with output");
    Ok(())
}

/// Log files of processes in the background.
fn logs(folder: &Path) -> String {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|file| file.path());
    let logs = files.filter(|path| path.extension().is_some_and(|extension| extension == "log"));
    logs.map(|path| format!("--- {}\n{}", path.display(), std::fs::read_to_string(&path).unwrap_or_default())).collect()
}
