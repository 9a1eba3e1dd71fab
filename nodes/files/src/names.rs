// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Names in files: of machines, jobs, lobes, profiles, passes and stations. They become file names, keys of overrides, and parts of ROS and
//! program names, so one rule holds for all of them.

use schemars::{Schema, SchemaGenerator, json_schema};

/// Longest name (characters): file names and names of ROS 2 end at 255 bytes, and names are put together.
pub(crate) const MAX_NAME: usize = 64;

/// Schema of a name.
pub(crate) fn schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "string",
        "maxLength": MAX_NAME,
        "pattern": "^[A-Za-z0-9_-]+$",
        "x-allowed": "1 to 64 letters, digits, '_' and '-'",
    })
}

/// Returns whether a name keeps the rule.
#[must_use]
pub(crate) fn is_name(name: &str) -> bool {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    !name.is_empty() && name.len() <= MAX_NAME && name.chars().all(is_allowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere() {
        for good in ["cam_grinder", "I1", "turned-cam", "4"] {
            assert!(is_name(good), "{good}");
        }
        for bad in ["", "../../x", "/etc/passwd", "a/b", "a b", "..", "a.b", "x\n", "x\0", "ä"] {
            assert!(!is_name(bad), "{bad:?}");
        }
        assert!(!is_name(&"x".repeat(MAX_NAME + 1)));
    }

    #[test]
    fn the_schema_allows_the_same_names() {
        let schema = schema(&mut SchemaGenerator::default()).to_value();
        let pattern = regex_lite::Regex::new(schema["pattern"].as_str().expect("a pattern")).expect("a pattern");
        let longest = usize::try_from(schema["maxLength"].as_u64().expect("a length")).expect("small");
        let names = (0..=300).filter_map(char::from_u32).map(|c| format!("a{c}b"));
        let others = ["", "..", "4", "x\n", "I1"].map(str::to_owned).into_iter();
        for name in names.chain(others).chain([MAX_NAME, MAX_NAME + 1].map(|length| "x".repeat(length))) {
            let allowed = pattern.is_match(&name) && name.chars().count() <= longest;
            assert_eq!(allowed, is_name(&name), "{name:?}");
        }
    }
}
