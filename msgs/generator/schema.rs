// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The text of a message with all it depends on, as rosbag2 writes it into a bag (`ros2msg`).

use std::collections::BTreeSet;

use super::load::{Library, nested_in};
use super::model::TypeName;

/// The definition of a message, verbatim, followed by those of its dependencies: depth first, in the order of their
/// names, each once.
pub(crate) fn text(library: &Library, name: &TypeName) -> String {
    let mut text = String::new();
    let mut seen = BTreeSet::from([name.clone()]);
    append(library, name, &mut seen, &mut text);
    text
}

fn append(library: &Library, name: &TypeName, seen: &mut BTreeSet<TypeName>, text: &mut String) {
    let Some(ty) = library.types.get(name) else { return };
    if !text.is_empty() {
        text.push('\n');
        text.push_str(&"=".repeat(80));
        text.push_str(&format!("\nMSG: {}/{}\n", name.package, name.name));
    }
    text.push_str(&ty.definition.text);
    let mut dependencies: Vec<_> = nested_in(ty).collect();
    dependencies.sort_by_key(|name| format!("{}/{}", name.package, name.name));
    for dependency in dependencies {
        if seen.insert(dependency.clone()) {
            append(library, dependency, seen, text);
        }
    }
}
