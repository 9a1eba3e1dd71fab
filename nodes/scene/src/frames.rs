// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The frames of a machine by name, and what stands before their names where two machines share one tree of transforms.

use camwright::machine::description::MachineDescription;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::std_msgs::msg::Header;
use camwright_ros::running::NodeError;
use camwright_ros::{Node, Parameter};

/// Name of the parameter that says what stands before the names of frames.
pub const FRAME_PREFIX: &str = "frame_prefix";

/// Longest prefix (bytes): it stands in every transform.
const LONGEST_PREFIX: usize = 64;

/// Names of the frames of one machine.
///
/// ```text
/// world ─ machine_base ┬ z_axis ─ table ─ c_axis ─ part
///                      └ x_axis ─ wheelhead ─ wheel_spindle ─ wheel
/// ```
/// On a lathe the table is the `chuck_slide`, the wheelhead the `tool_slide`, the wheel the `insert`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frames {
    /// Root of everything that stands in one hall; it has no prefix.
    pub world: String,
    /// Z along the spindle's axis from the headstock to the tailstock, X from the part to the wheel, Y up; z 0 is the middle of the wheel.
    pub base: String,
    /// Frame moved by `z_axis`.
    pub table: String,
    /// Frame rotated by `c_axis`: azimuths of the part count from its X, z is the reading of `z_axis` with the wheel at that position.
    pub part: String,
    /// Frame moved by `x_axis`: its origin is the wheel's cutting point, on a lathe the insert's centre.
    pub head: String,
    /// Frame rotated by the wheel's spindle.
    pub wheel: String,
}

impl Frames {
    /// The frames of a machine.
    #[must_use]
    pub fn new(prefix: &str, machine: &MachineDescription) -> Self {
        let [table, head, wheel] = match machine.is_lathe() {
            true => ["chuck_slide", "tool_slide", "insert"],
            false => ["table", "wheelhead", "wheel"],
        };
        let named = |name: &str| format!("{prefix}{name}");
        Self {
            world: "world".to_owned(),
            base: named("machine_base"),
            table: named(table),
            part: named("part"),
            head: named(head),
            wheel: named(wheel),
        }
    }

    /// Header of what is measured or designed on the part.
    #[must_use]
    pub fn part_header(&self, stamp: Time) -> Header {
        Header { stamp, frame_id: self.part.clone() }
    }
}

/// The parameter of a node that names frames.
#[must_use]
pub fn parameter() -> Parameter {
    Parameter::string(FRAME_PREFIX, "")
        .describe("prefix of the names of frames; empty: from the namespace, cell1_ in /cell1; 'none': no prefix")
        .read_only()
}

/// The frames that a node of a cell names.
///
/// # Errors
/// A prefix that is no name.
pub fn frames_of(node: &Node, machine: &MachineDescription) -> Result<Frames, NodeError> {
    let prefix = prefix(&node.parameters().string(FRAME_PREFIX), node.namespace()).map_err(NodeError::Parameter)?;
    Ok(Frames::new(&prefix, machine))
}

/// Prefix of frame names in a namespace.
///
/// # Errors
/// What is no name.
pub fn prefix(wanted: &str, namespace: &str) -> Result<String, String> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '/');
    match wanted {
        "none" => Ok(String::new()),
        "" => {
            let names = namespace.split('/').filter(|name| !name.is_empty());
            Ok(names.map(|name| format!("{name}_")).collect())
        }
        _ if wanted.len() > LONGEST_PREFIX => {
            Err(format!("{FRAME_PREFIX} has {} characters, at most {LONGEST_PREFIX} are allowed", wanted.len()))
        }
        // tf2 refuses a name that begins with a slash.
        _ if wanted.starts_with('/') || !wanted.chars().all(is_name) => {
            Err(format!("{FRAME_PREFIX} is {wanted:?}; it may have letters, digits, _ and, not at its beginning, /"))
        }
        _ => Ok(wanted.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::prefix;

    #[test]
    fn two_cells_do_not_share_frames() {
        assert_eq!(prefix("", "/").unwrap(), "");
        assert_eq!(prefix("", "/cell1").unwrap(), "cell1_");
        assert_eq!(prefix("", "/hall/cell1").unwrap(), "hall_cell1_");
        assert_eq!(prefix("none", "/cell1").unwrap(), "");
        assert_eq!(prefix("left/", "/cell1").unwrap(), "left/");
    }

    #[test]
    fn a_prefix_that_is_no_name_is_refused() {
        for wrong in ["/cell1", "a b", "ä", "a\"", "<x>"] {
            assert!(prefix(wrong, "/").unwrap_err().contains("frame_prefix is"), "{wrong}");
        }
        assert!(prefix(&"x".repeat(65), "/").unwrap_err().contains("65 characters, at most 64"));
    }
}
