// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The rooms of the core stand in the order of the data flow: a room imports only from itself and from rooms before it.
//!
//! The order is that of the modules in `lib.rs`. Paths inside of macro calls are not seen.

use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// Rooms that a file names after `crate::`.
#[derive(Default)]
struct Named(Vec<String>);

impl<'ast> Visit<'ast> for Named {
    fn visit_path(&mut self, path: &'ast syn::Path) {
        let mut segments = path.segments.iter().map(|segment| segment.ident.to_string());
        if segments.next().is_some_and(|first| first == "crate") {
            self.0.extend(segments.next());
        }
        visit::visit_path(self, path);
    }

    fn visit_use_path(&mut self, path: &'ast syn::UsePath) {
        if path.ident == "crate" {
            match path.tree.as_ref() {
                syn::UseTree::Path(next) => self.0.push(next.ident.to_string()),
                syn::UseTree::Group(group) => {
                    self.0.extend(group.items.iter().filter_map(|item| match item {
                        syn::UseTree::Path(next) => Some(next.ident.to_string()),
                        syn::UseTree::Name(next) => Some(next.ident.to_string()),
                        _ => None,
                    }));
                }
                _ => {}
            }
        }
        visit::visit_use_path(self, path);
    }

    /// Tests may look anywhere.
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if module.ident != "tests" {
            visit::visit_item_mod(self, module);
        }
    }
}

fn parsed(path: &Path) -> syn::File {
    let text = std::fs::read_to_string(path).expect("a source file");
    syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn files(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the core").flatten() {
        let path = entry.path();
        let is_test = path.file_stem().is_some_and(|stem| stem == "tests");
        match path.is_dir() {
            _ if is_test => {}
            true => files(&path, into),
            false => into.push(path),
        }
    }
}

#[test]
fn a_room_imports_only_from_rooms_before_it() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let rooms: Vec<String> = parsed(&source.join("lib.rs"))
        .items
        .iter()
        .filter_map(|item| if let syn::Item::Mod(module) = item { Some(module.ident.to_string()) } else { None })
        .collect();
    assert_eq!(rooms.len(), 12);
    let (mut seen, mut wrong) = (0, Vec::new());
    for (place, room) in rooms.iter().enumerate() {
        let mut all = Vec::new();
        files(&source.join(room), &mut all);
        for path in all {
            let mut named = Named::default();
            named.visit_file(&parsed(&path));
            for other in named.0 {
                let Some(there) = rooms.iter().position(|room| *room == other) else { continue };
                seen += 1;
                if there > place {
                    wrong.push(format!("{} names {other}, which stands after {room}", path.display()));
                }
            }
        }
    }
    assert!(seen > 800, "only {seen} imports were seen");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
