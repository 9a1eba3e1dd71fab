// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The tree as a URDF.

use super::link::{Inertial, Link, LinkSolid, Visual};
use super::tree::{Joint, JointMotion, Limit, Tree};
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

/// Version of the URDF specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UrdfVersion {
    /// Every parser reads it.
    V1_0,
    /// With limits of acceleration, deceleration and jerk. Parsers of ROS 2 Jazzy and Kilted refuse it.
    V1_2,
}

impl UrdfVersion {
    /// Version of a description with or without limits of acceleration and jerk.
    #[must_use]
    pub fn with_extended_limits(extended: bool) -> Self {
        if extended { Self::V1_2 } else { Self::V1_0 }
    }
}

impl Tree {
    /// The tree as `robot_state_publisher`, `RViz` and Foxglove read it.
    #[must_use]
    pub fn urdf(&self, version: UrdfVersion) -> String {
        let mut text = String::from("<?xml version=\"1.0\"?>\n");
        // Writing into a string cannot fail.
        let _ = self.write(version, &mut text);
        text
    }

    fn write(&self, version: UrdfVersion, to: &mut String) -> std::fmt::Result {
        writeln!(
            to,
            "<!-- Made from the machine file by `camwright urdf`. Frames, axes and signs: ARCHITECTURE.md, section 2. -->"
        )?;
        let attribute = match version {
            // Without the attribute the version is 1.0.
            UrdfVersion::V1_0 => "",
            UrdfVersion::V1_2 => " version=\"1.2\"",
        };
        writeln!(to, "<robot name=\"{}\"{attribute}>", escaped(&self.name))?;
        self.links.iter().try_for_each(|link| write_link(link, to))?;
        self.joints.iter().try_for_each(|joint| write_joint(joint, version, to))?;
        writeln!(to, "</robot>")
    }
}

fn write_link(link: &Link, to: &mut String) -> std::fmt::Result {
    let name = escaped(&link.name);
    if link.visuals.is_empty() && link.inertial.is_none() {
        return writeln!(to, "  <link name=\"{name}\"/>");
    }
    writeln!(to, "  <link name=\"{name}\">")?;
    if let Some(Inertial { mass, at, moments: [xx, yy, zz] }) = link.inertial {
        writeln!(to, "    <inertial>")?;
        writeln!(to, "      <origin xyz=\"{}\"/>", triple(at))?;
        writeln!(to, "      <mass value=\"{}\"/>", number(mass))?;
        let [xx, yy, zz] = [xx, yy, zz].map(number);
        writeln!(to, "      <inertia ixx=\"{xx}\" iyy=\"{yy}\" izz=\"{zz}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>")?;
        writeln!(to, "    </inertial>")?;
    }
    for (index, visual) in link.visuals.iter().enumerate() {
        write_visual(visual, &format!("{name}_{index}"), to)?;
    }
    writeln!(to, "  </link>")
}

fn write_visual(visual: &Visual, material: &str, to: &mut String) -> std::fmt::Result {
    let (rpy, shape) = match visual.solid {
        LinkSolid::Box(size) => ([0.0; 3], format!("<box size=\"{}\"/>", triple(size))),
        LinkSolid::AlongZ { radius, length } => ([0.0; 3], cylinder(radius, length)),
        LinkSolid::AlongY { radius, length } => ([-FRAC_PI_2, 0.0, 0.0], cylinder(radius, length)),
    };
    let body = format!("<origin xyz=\"{}\" rpy=\"{}\"/><geometry>{shape}</geometry>", triple(visual.at), triple(rpy));
    let rgba = visual.colour.map(number).join(" ");
    writeln!(to, "    <visual>{body}<material name=\"{material}\"><color rgba=\"{rgba}\"/></material></visual>")?;
    writeln!(to, "    <collision>{body}</collision>")
}

fn cylinder(radius: f64, length: f64) -> String {
    format!("<cylinder radius=\"{}\" length=\"{}\"/>", number(radius), number(length))
}

fn write_joint(joint: &Joint, version: UrdfVersion, to: &mut String) -> std::fmt::Result {
    let (kind, rpy, axis, limit) = match joint.motion {
        JointMotion::Fixed(rpy) => ("fixed", rpy, None, None),
        JointMotion::Slide(axis, limit) => ("prismatic", [0.0; 3], Some(axis), Some(limit)),
        JointMotion::Turn(axis, limit) => ("continuous", [0.0; 3], Some(axis), Some(limit)),
    };
    writeln!(to, "  <joint name=\"{}\" type=\"{kind}\">", escaped(&joint.name))?;
    writeln!(to, "    <parent link=\"{}\"/><child link=\"{}\"/>", escaped(&joint.parent), escaped(&joint.child))?;
    writeln!(to, "    <origin xyz=\"{}\" rpy=\"{}\"/>", triple(joint.at), triple(rpy))?;
    if let Some(axis) = axis {
        writeln!(to, "    <axis xyz=\"{}\"/>", triple(axis))?;
    }
    if let Some(limit) = limit {
        let Limit { range, velocity, effort, .. } = limit;
        let range = range
            .map_or_else(String::new, |(low, high)| format!("lower=\"{}\" upper=\"{}\" ", number(low), number(high)));
        let extended = match version {
            UrdfVersion::V1_0 => String::new(),
            UrdfVersion::V1_2 => extended_limits(&limit),
        };
        writeln!(to, "    <limit {range}velocity=\"{}\" effort=\"{}\"{extended}/>", number(velocity), number(effort))?;
    }
    writeln!(to, "  </joint>")
}

/// Attributes of URDF 1.2; without `deceleration` that is the same as `acceleration`.
fn extended_limits(limit: &Limit) -> String {
    let acceleration = format!(" acceleration=\"{}\"", number(limit.acceleration));
    match limit.jerk {
        Some(jerk) => format!("{acceleration} jerk=\"{}\"", number(jerk)),
        None => acceleration,
    }
}

/// A figure to the nanometre or better, without the noise of the last bits.
fn number(value: f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    // Minus zero is none.
    format!("{}", rounded + 0.0)
}

fn triple(values: [f64; 3]) -> String {
    values.map(number).join(" ")
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // What XML 1.0 does not allow at all.
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
