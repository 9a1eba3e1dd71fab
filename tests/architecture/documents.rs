// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Documents name files and headings that exist. The book lists every page, and its links stay within it.

use crate::support::repository;
use std::path::{Path, PathBuf};

/// Starts of paths of the repository in a document. Other paths in `bags/` are example runs.
const FOLDERS: [&str; 10] = [
    "camwright/src/",
    "camwright/tests/",
    "camwright/examples/",
    "nodes/",
    "tests/",
    "params/",
    "bags/golden",
    "bags/FAULTS.md",
    "msgs/",
    "docs/",
];

fn documents(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the repository").flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            documents(&path, into);
        } else if name.ends_with(".md") {
            into.push(path);
        }
    }
}

/// Targets of links to files of the repository and to headings.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    links.filter(|link| !link.is_empty() && !link.contains("://") && !link.starts_with("mailto:"))
}

/// Targets of links, and words in code quotes that are paths of the repository.
fn named(text: &str) -> Vec<&str> {
    let links = links(text).map(|link| link.split('#').next().unwrap_or_default()).filter(|file| !file.is_empty());
    let quoted = text.split('`').skip(1).step_by(2).flat_map(str::split_whitespace);
    let is_plain = |word: &&str| word.chars().all(|c| c.is_ascii_alphanumeric() || "._-/".contains(c));
    let quoted = quoted.filter(|word| FOLDERS.iter().any(|folder| word.starts_with(folder))).filter(is_plain);
    links.chain(quoted).collect()
}

#[test]
fn every_file_that_a_document_names_exists() {
    let root = repository();
    let mut all = Vec::new();
    documents(&root, &mut all);
    let (mut seen, mut missing) = (0, Vec::new());
    for document in &all {
        let text = std::fs::read_to_string(document).expect("a document");
        let folder = document.parent().expect("it lies in a folder");
        for name in named(&text) {
            seen += 1;
            if !folder.join(name).exists() && !root.join(name).exists() {
                missing.push(format!("{}: {name}", document.display()));
            }
        }
    }
    assert!(seen > 150, "only {seen} names were found in {} documents", all.len());
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

/// Words of the private dialect that documents once had. Each has a plain word: report, missing, replace, client, also, read.
const AVOIDED: [&str; 14] = [
    "tells",
    "told",
    "telling",
    "nought",
    "whoever",
    "nobody",
    "besides",
    "hears",
    "heard",
    "has not got",
    "gives way",
    "give way",
    "takes the place",
    "once it",
];

/// Documents with text that programs print.
const PRINTED: [&str; 2] = ["tests/INTEROPERABILITY.md", "docs/reference/alarms.md"];

/// Longest line of a paragraph.
const MAX_LINE: usize = 150;

#[test]
fn documents_use_plain_words_and_short_lines() {
    let root = repository();
    let mut all = Vec::new();
    documents(&root, &mut all);
    let (mut seen, mut found) = (0, Vec::new());
    for document in all.iter().filter(|path| !PRINTED.iter().any(|printed| **path == root.join(printed))) {
        let text = std::fs::read_to_string(document).expect("a document");
        let mut is_code = false;
        for (number, line) in text.lines().enumerate() {
            is_code ^= line.trim_start().starts_with("```");
            if is_code {
                continue;
            }
            seen += 1;
            // Names in code quotes are fixed: topics, fields, keys.
            let prose: String = line.split('`').step_by(2).collect::<Vec<_>>().join(" ");
            let plain = prose.to_lowercase().replace(|c: char| !c.is_alphabetic(), " ");
            let plain = format!(" {} ", plain.split_whitespace().collect::<Vec<_>>().join(" "));
            let is_long = line.chars().count() > MAX_LINE && !line.starts_with('|') && !line.starts_with("![");
            let word = AVOIDED.iter().find(|word| plain.contains(&format!(" {word} ")));
            if let Some(reason) = word.copied().or(is_long.then_some("too long")) {
                found.push(format!("{}:{}: {reason}", document.display(), number + 1));
            }
        }
    }
    assert!(seen > 3000, "only {seen} lines");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Anchors of the headings of a document, as GitHub and mdBook derive them.
fn anchors(text: &str) -> Vec<String> {
    let (mut anchors, mut is_code) = (Vec::<String>::new(), false);
    for line in text.lines() {
        is_code ^= line.trim_start().starts_with("```");
        let heading = line.trim_start_matches('#');
        if is_code || heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect();
        let earlier = anchors.iter().filter(|known| **known == anchor).count();
        anchors.push(if earlier == 0 { anchor } else { format!("{anchor}-{earlier}") });
    }
    anchors
}

#[test]
fn every_heading_that_a_link_names_exists() {
    assert_eq!(anchors("# A `b`, c\n```\n# no\n```\n## Why?\n## Why?"), ["a-b-c", "why", "why-1"]);
    let mut all = Vec::new();
    documents(&repository(), &mut all);
    let (mut seen, mut missing) = (0, Vec::new());
    for document in &all {
        let text = std::fs::read_to_string(document).expect("a document");
        let folder = document.parent().expect("it lies in a folder");
        for link in links(&text) {
            let Some((file, anchor)) = link.split_once('#') else { continue };
            seen += 1;
            let target = if file.is_empty() { document.clone() } else { folder.join(file) };
            let target = std::fs::read_to_string(target).unwrap_or_default();
            if !anchors(&target).iter().any(|known| known == anchor) {
                missing.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(seen > 10, "only {seen} links to headings were found");
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

/// A built book holds only `docs/`.
#[test]
fn links_of_the_book_stay_within_it() {
    let docs = repository().join("docs");
    let mut pages = Vec::new();
    documents(&docs, &mut pages);
    let (mut seen, mut leaving) = (0, Vec::new());
    for page in &pages {
        let text = std::fs::read_to_string(page).expect("a page");
        let depth = page.strip_prefix(&docs).expect("it lies in docs").components().count() - 1;
        for link in links(&text) {
            seen += 1;
            if link.split('/').take_while(|part| *part == "..").count() > depth {
                leaving.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(seen > 150, "only {seen} links were found in {} pages", pages.len());
    assert!(leaving.is_empty(), "name these files in code quotes:\n{}", leaving.join("\n"));
}

/// `docs/SUMMARY.md` is the table of contents that mdBook builds the book from.
#[test]
fn the_book_lists_every_page_once() {
    let docs = repository().join("docs");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).expect("a table of contents");
    let listed = summary.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let mut listed: Vec<String> = listed.map(str::to_owned).collect();
    let mut pages = Vec::new();
    documents(&docs, &mut pages);
    let relative = |page: &PathBuf| page.strip_prefix(&docs).expect("it lies in docs").to_string_lossy().into_owned();
    let mut pages: Vec<String> = pages.iter().map(relative).filter(|page| page != "SUMMARY.md").collect();
    listed.sort();
    pages.sort();
    let unlisted: Vec<&String> = pages.iter().filter(|page| !listed.contains(page)).collect();
    assert!(unlisted.is_empty(), "docs/SUMMARY.md does not list {unlisted:?}");
    assert_eq!(listed, pages, "docs/SUMMARY.md lists a page twice, or one that does not exist");
}
