//! Tutorials of `docs/tutorials`: every command of a page runs, and prints what the page shows.
//!
//! A block ```` ```console ```` holds commands behind `$ ` with their output below; a line `...` stands for any number of lines, and `...` at
//! the end of a line for its rest. A block behind `<!-- file: NAME -->` is written to the folder in which the commands run.

use crate::support::{Domain, Folder, repository};
use std::path::Path;
use std::process::Command;

/// Time after which a command of a tutorial counts as stuck (s).
const LIMIT_S: &str = "600";

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

/// Runs a tutorial in a folder of its own.
fn follow(name: &str) {
    let page = repository().join("docs/tutorials").join(name);
    let text = std::fs::read_to_string(&page).expect("a tutorial");
    let (folder, domain) = (Folder::new(&format!("tutorial-{name}")), Domain::take());
    let programs = Path::new(env!("CARGO_BIN_EXE_camwright")).parent().expect("it lies in a folder");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    let (mut commands, mut compared) = (0, 0);
    for step in steps(&text) {
        match step {
            Step::File { name, text } => drop(folder.write(&name, &text)),
            Step::Command { line, command, output } => {
                let done = Command::new("timeout")
                    .args([LIMIT_S, "sh", "-c", &format!("( {command} ) 2>&1")])
                    .current_dir(folder.path())
                    .env("PATH", &path)
                    .env("ROS_DOMAIN_ID", domain.id().to_string())
                    .env("XDG_STATE_HOME", folder.join("state"))
                    .env("REPOSITORY", repository())
                    .output()
                    .expect("a shell");
                let printed = String::from_utf8_lossy(&done.stdout).into_owned();
                let is_success = done.status.success() || command.contains("|| ");
                assert!(is_success, "{name}:{line}: {command}: {}\n{printed}", done.status);
                let lines: Vec<&str> = printed.lines().collect();
                let is_right = output.is_empty() || is_shown(&output, &lines);
                assert!(is_right, "{name}:{line}: {command} does not print what the page shows, but\n{printed}");
                commands += 1;
                compared += usize::from(!output.is_empty());
            }
        }
    }
    assert!(commands >= 2 && compared >= 1, "{name}: {commands} commands, {compared} with output");
}

#[test]
fn every_tutorial_is_followed() {
    let source = include_str!("tutorials.rs");
    for entry in std::fs::read_dir(repository().join("docs/tutorials")).expect("tutorials").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(source.contains(&format!("follow(\"{name}\")")), "no test follows {name}");
    }
}

#[test]
fn my_first_cam() {
    follow("my_first_cam.md");
}

#[test]
fn my_grinding_machine() {
    follow("my_grinding_machine.md");
}

#[test]
fn a_3d_cam_from_stl() {
    follow("a_3d_cam_from_stl.md");
}

#[test]
fn an_nc_program() {
    follow("an_nc_program.md");
}

#[test]
fn reading_a_report() {
    follow("reading_a_report.md");
}

#[test]
fn a_shaft_with_runout() {
    follow("a_shaft_with_runout.md");
}

#[test]
fn learning_from_part_to_part() {
    follow("learning_from_part_to_part.md");
}

#[test]
fn recording_and_replaying() {
    follow("recording_and_replaying.md");
}
