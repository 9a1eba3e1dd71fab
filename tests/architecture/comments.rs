// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Language of doc comments and names: openings, words and function names that readers stumble over.

use crate::support::repository;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Largest share of doc comments that open with one of [`OPENINGS`], in percent.
const MAX_OPENINGS_PERCENT: f64 = 3.0;
/// Words that turn a description into a question or an aside.
const OPENINGS: [&str; 8] = ["What", "How", "Where", "By", "Whether", "As", "So", "Of"];
/// Largest number of tell, tells, told and telling per 1,000 words of comment.
const MAX_TELL_PER_1000: f64 = 0.1;
/// Function names that do not say what the function does.
const FUNCTIONS: [&str; 8] = ["of", "tell", "told", "say", "said", "hear", "heard", "keep"];

/// Files of a folder and those within that end with one of the endings.
fn sources(folder: &Path, endings: &[&str], into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the repository").flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            sources(&path, endings, into);
        } else if endings.iter().any(|ending| name.ends_with(ending)) {
            into.push(path);
        }
    }
}

/// Programs and interfaces of ours name copyright and license in one of the first two lines. `msgs/standard` repeats interfaces of ROS.
#[test]
fn every_source_names_its_copyright_and_license() {
    const ENDINGS: [&str; 11] =
        [".rs", ".py", ".pyi", ".sh", ".js", ".mjs", ".msg", ".srv", ".action", ".cmake", "CMakeLists.txt"];
    const LICENSE: &str = "Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0";
    let mut all = Vec::new();
    sources(&repository(), &ENDINGS, &mut all);
    all.retain(|path| !path.starts_with(repository().join("msgs/standard")));
    assert!(all.len() > 1000, "only {} sources", all.len());
    let is_named = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).expect("a source");
        text.lines().take(2).any(|line| line.ends_with(LICENSE))
    };
    let nameless: Vec<&PathBuf> = all.iter().filter(|path| !is_named(path)).collect();
    assert!(nameless.is_empty(), "no SPDX-License-Identifier: {nameless:#?}");
}

/// Every Rust source of the repository with its text.
fn texts() -> Vec<(PathBuf, String)> {
    let mut all = Vec::new();
    sources(&repository(), &[".rs"], &mut all);
    assert!(all.len() > 500, "only {} sources", all.len());
    all.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).expect("a source"))).collect()
}

/// Text of a doc comment line.
fn doc(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))
}

#[test]
fn doc_comments_open_with_a_noun_or_a_verb() {
    let (mut total, mut found) = (0_u32, Vec::new());
    for (path, text) in texts() {
        let mut is_inside = false;
        for (number, line) in text.lines().enumerate() {
            let comment = doc(line);
            if let Some(comment) = comment.filter(|_| !is_inside) {
                total += 1;
                let first = comment.trim_start().split(|c: char| !c.is_alphabetic()).next().unwrap_or_default();
                if OPENINGS.contains(&first) {
                    found.push(format!("{}:{}:{comment}", path.display(), number + 1));
                }
            }
            is_inside = comment.is_some();
        }
    }
    let share = 100.0 * f64::from(u32::try_from(found.len()).expect("a count")) / f64::from(total);
    assert!(total > 10_000, "only {total} doc comments");
    assert!(
        share <= MAX_OPENINGS_PERCENT,
        "{share:.1} % of {total} doc comments open with one of {OPENINGS:?}; begin with a noun or a verb:\n{}",
        found.join("\n")
    );
}

#[test]
fn comments_report_and_do_not_tell() {
    let (mut words, mut found) = (0_u32, Vec::new());
    for (path, text) in texts() {
        for (number, line) in text.lines().enumerate().filter(|(_, line)| line.trim_start().starts_with("//")) {
            for word in line.split(|c: char| !c.is_ascii_alphabetic() && c != '_').filter(|word| !word.is_empty()) {
                words += 1;
                if ["tell", "tells", "told", "telling"].contains(&word.to_lowercase().as_str()) {
                    found.push(format!("{}:{}:{}", path.display(), number + 1, line.trim()));
                }
            }
        }
    }
    let rate = 1000.0 * f64::from(u32::try_from(found.len()).expect("a count")) / f64::from(words);
    assert!(words > 100_000, "only {words} words");
    assert!(rate <= MAX_TELL_PER_1000, "{rate:.2} per 1,000 of {words} words:\n{}", found.join("\n"));
}

#[test]
fn functions_and_constants_say_what_they_are() {
    let (mut seen, mut found) = (0, Vec::new());
    for (path, text) in texts() {
        for (number, line) in text.lines().enumerate() {
            let name = line.split("fn ").nth(1).map(|rest| rest.split(|c: char| !c.is_alphanumeric() && c != '_'));
            let name = name.and_then(|mut words| words.next()).filter(|_| !line.trim_start().starts_with("//"));
            let constant =
                line.split("const ").nth(1).filter(|rest| rest.starts_with("MOST_") || rest.starts_with("LEAST_"));
            seen += usize::from(name.is_some());
            if name.is_some_and(|name| FUNCTIONS.contains(&name)) || constant.is_some() {
                found.push(format!("{}:{}:{}", path.display(), number + 1, line.trim()));
            }
        }
    }
    assert!(seen > 4000, "only {seen} functions");
    assert!(
        found.is_empty(),
        "name the action (from_…, report_…, receive_…, retain_…, MAX_…, MIN_…):\n{}",
        found.join("\n")
    );
}

/// Name that a line defines as a type outside its module.
fn shared_type(line: &str) -> Option<&str> {
    let line = line.trim_start().strip_prefix("pub")?;
    let line = line.strip_prefix('(').map_or(line, |rest| rest.split_once(')').map_or(rest, |(_, after)| after));
    let (kind, rest) = line.strip_prefix(' ')?.split_once(' ')?;
    let is_type = ["struct", "enum", "trait", "type"].contains(&kind);
    rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().filter(|name| is_type && !name.is_empty())
}

#[test]
fn type_names_have_one_meaning() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (path, text) in texts() {
        let inside = path.strip_prefix(repository()).expect("a path of the repository");
        let is_source = inside.components().any(|folder| folder.as_os_str() == "src");
        for (number, line) in text.lines().enumerate().filter(|_| is_source) {
            if let Some(name) = shared_type(line) {
                places.entry(name.to_owned()).or_default().push(format!("{}:{}", inside.display(), number + 1));
            }
        }
    }
    assert!(places.len() > 800, "only {} types", places.len());
    let twice: Vec<String> =
        places.iter().filter(|(_, at)| at.len() > 1).map(|(name, at)| format!("{name}: {}", at.join(", "))).collect();
    assert!(twice.is_empty(), "give each type a name of its own:\n{}", twice.join("\n"));
}
