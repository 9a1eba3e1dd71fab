//! Names in files: of machines, jobs, lobes, profiles, passes and stations. They become file names, keys of overrides, and parts of ROS and
//! program names, so one rule holds for all of them.

/// Longest name (characters): file names and names of ROS 2 end at 255 bytes, and names are put together.
pub(crate) const MAX_NAME: usize = 64;

/// Characters of a name that an error repeats.
const SHOWN: usize = 40;

/// Whether a name keeps the rule.
#[must_use]
pub(crate) fn is_name(name: &str) -> bool {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    !name.is_empty() && name.len() <= MAX_NAME && name.chars().all(is_allowed)
}

/// What is wrong with a name, as a sentence; `None`: nothing.
pub(crate) fn fault(what: &str, name: &str) -> Option<String> {
    if is_name(name) {
        return None;
    }
    let shown: String = name.chars().take(SHOWN).collect();
    let more = if name.chars().count() > SHOWN { "…" } else { "" };
    Some(match name.chars().count() {
        length if length > MAX_NAME => {
            format!("{what} {shown:?}{more} has {length} characters; a name has at most {MAX_NAME}")
        }
        _ => format!("{what} {shown:?}{more}: a name is made of letters, digits, '_' and '-'"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere() {
        for good in ["cam_grinder", "I1", "turned-cam", "4"] {
            assert_eq!(fault("machine", good), None);
        }
        for bad in ["", "../../x", "/etc/passwd", "a/b", "a b", "..", "a.b", "x\n", "x\0", "ä"] {
            let said = fault("machine", bad).expect("it is refused");
            assert!(said.starts_with("machine ") && said.ends_with("letters, digits, '_' and '-'"), "{said}");
        }
        let long = fault("job", &"x".repeat(70_000)).expect("it is refused");
        assert!(long.len() < 200 && long.ends_with("has 70000 characters; a name has at most 64"), "{long}");
    }
}
