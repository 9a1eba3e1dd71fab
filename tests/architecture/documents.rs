//! Documents name files that exist, and the book lists every page.

use crate::support::repository;
use std::path::{Path, PathBuf};

/// Folders of the repository that a path in a document begins with.
const FOLDERS: [&str; 9] = [
    "camwright/src/",
    "camwright/tests/",
    "camwright/examples/",
    "nodes/",
    "tests/",
    "params/",
    "bags/",
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

/// Targets of links, and words in code quotes that are paths of the repository.
fn named(text: &str) -> Vec<&str> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let links = links.map(|link| link.split('#').next().unwrap_or_default());
    let links = links.filter(|link| !link.is_empty() && !link.contains("://") && !link.starts_with("mailto:"));
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
    assert_eq!(listed, pages);
}
