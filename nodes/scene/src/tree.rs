// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Links and joints of a machine, and where they stand for positions of its axes.

use super::Frames;
use super::bodies;
use super::link::{Link, SPINDLE_HEIGHT};
use camwright::machine::description::{Axis, InsertRotation, MachineDescription};
use camwright::math::units::TURN_RAD;
use camwright_files::convert::machine_description::WHEEL_JOINT;
use camwright_files::convert::{m_from_mm, si_from_core};
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::geometry_msgs::msg::{Quaternion, Transform, TransformStamped, Vector3};
use camwright_msgs::std_msgs::msg::Header;
use std::f64::consts::FRAC_PI_2;

/// A machine as links and joints, in m, rad, kg, N.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// Name of the machine.
    pub name: String,
    /// The names of its frames.
    pub frames: Frames,
    /// Its links, the root first.
    pub links: Vec<Link>,
    /// Its joints; each hangs below a link that stands before its child.
    pub joints: Vec<Joint>,
}

/// Joint between two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, that of joint states.
    pub name: String,
    pub parent: String,
    pub child: String,
    /// Position of the child in the parent at joint position 0.
    pub at: [f64; 3],
    pub motion: JointMotion,
}

/// Motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointMotion {
    /// Not at all; turned by roll, pitch and yaw.
    Fixed([f64; 3]),
    Slide([f64; 3], Limit),
    /// Round a direction, without end.
    Turn([f64; 3], Limit),
}

/// Limit of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// From where to where.
    pub range: Option<(f64, f64)>,
    /// Fastest (m/s or rad/s).
    pub velocity: f64,
    /// Maximum acceleration and deceleration (m/s² or rad/s²).
    pub acceleration: f64,
    /// Maximum jerk (m/s³ or rad/s³); `None`: not limited.
    pub jerk: Option<f64>,
    /// Strongest (N or N m).
    pub effort: f64,
}

impl Tree {
    /// The tree of a machine with a wheel of this radius (mm); of a lathe the insert's is taken.
    #[must_use]
    pub fn new(machine: &MachineDescription, wheel_radius_mm: f64, frames: Frames) -> Self {
        let wheel_radius = m_from_mm(machine.insert.map_or(wheel_radius_mm, |insert| insert.radius_mm));
        let links = bodies::links(machine, wheel_radius, &frames);
        let wheel_inertia = links.last().and_then(|link| link.inertial).map_or(0.0, |wheel| wheel.moments[2]);
        let joints = joints(machine, wheel_radius, wheel_inertia, &frames);
        Self { name: machine.name.clone(), frames, links, joints }
    }

    /// Transforms of the joints that never move.
    #[must_use]
    pub fn fixed(&self, stamp: &Time) -> Vec<TransformStamped> {
        let fixed = self.joints.iter().filter(|joint| matches!(joint.motion, JointMotion::Fixed(_)));
        fixed.map(|joint| joint.transform(0.0, stamp)).collect()
    }

    /// Transforms of the moving joints; `position` returns that of a joint (m or rad).
    #[must_use]
    pub fn moved(&self, stamp: &Time, position: impl Fn(&str) -> f64) -> Vec<TransformStamped> {
        let moving = self.joints.iter().filter(|joint| !matches!(joint.motion, JointMotion::Fixed(_)));
        moving.map(|joint| joint.transform(position(&joint.name), stamp)).collect()
    }
}

impl Joint {
    /// Transform of the child at a position of the joint (m or rad).
    fn transform(&self, position: f64, stamp: &Time) -> TransformStamped {
        let [mut x, mut y, mut z] = self.at;
        let mut rotation = Quaternion::default();
        match self.motion {
            JointMotion::Fixed(rpy) => rotation = quaternion_of(rpy),
            JointMotion::Slide(axis, _) => {
                x += axis[0] * position;
                y += axis[1] * position;
                z += axis[2] * position;
            }
            JointMotion::Turn(axis, _) => {
                // A headstock that has turned for days would lose digits in the sine.
                let (sin, cos) = (0.5 * (position % TURN_RAD)).sin_cos();
                rotation = Quaternion { x: axis[0] * sin, y: axis[1] * sin, z: axis[2] * sin, w: cos };
            }
        }
        TransformStamped {
            header: Header { stamp: stamp.clone(), frame_id: self.parent.clone() },
            child_frame_id: self.child.clone(),
            transform: Transform { translation: Vector3 { x, y, z }, rotation },
        }
    }
}

/// Roll about X, then pitch about Y, then yaw about Z, all fixed.
fn quaternion_of([roll, pitch, yaw]: [f64; 3]) -> Quaternion {
    let ([sr, cr], [sp, cp], [sy, cy]) =
        ([roll, pitch, yaw].map(|angle| [(0.5 * angle).sin(), (0.5 * angle).cos()])).into();
    Quaternion {
        x: sr * cp * cy - cr * sp * sy,
        y: cr * sp * cy + sr * cp * sy,
        z: cr * cp * sy - sr * sp * cy,
        w: cr * cp * cy + sr * sp * sy,
    }
}

fn joints(machine: &MachineDescription, wheel_radius: f64, wheel_inertia: f64, frames: &Frames) -> Vec<Joint> {
    let joint = |name: &str, parent: &str, child: &str, at, motion| Joint {
        name: name.to_owned(),
        parent: parent.to_owned(),
        child: child.to_owned(),
        at,
        motion,
    };
    let sense = f64::from(machine.rotation_sense);
    // The insert turns about the normal of its rake face, which lies at a height of its own; X is that of its centre.
    let (height, wheel_at, wheel_axis) = match &machine.insert {
        Some(insert) => {
            // Seen from below the rake face a positive angle about +Y is clockwise.
            let is_reversed =
                insert.spindle.is_some_and(|spindle| spindle.rotation == InsertRotation::Counterclockwise);
            (m_from_mm(insert.height_mm), [0.0; 3], [0.0, if is_reversed { -1.0 } else { 1.0 }, 0.0])
        }
        None => (0.0, [wheel_radius, 0.0, 0.0], [0.0, 0.0, 1.0]),
    };
    let max = machine.wheel.speed_rad_s(machine.wheel.min_radius_mm);
    let velocity = machine.wheel.max_speed_rad_s.unwrap_or(max).max(max);
    // Motor data are unknown; it accelerates the wheel in its spin-up time.
    let spin_up_s = if machine.wheel.spin_up_s > 0.0 { machine.wheel.spin_up_s } else { 1.0 };
    let acceleration = velocity / spin_up_s;
    let wheel = Limit { range: None, velocity, acceleration, jerk: None, effort: wheel_inertia * acceleration };
    let (base, table, part, head) = (&frames.base, &frames.table, &frames.part, &frames.head);
    // Machine X lies across the hall, Y up and Z along it: columns y, z, x of the world.
    let hall = JointMotion::Fixed([FRAC_PI_2, 0.0, FRAC_PI_2]);
    vec![
        joint("world_to_machine_base", &frames.world, base, [0.0, 0.0, SPINDLE_HEIGHT], hall),
        // What z_axis counts is where on the part the wheel stands, so the part moves the other way.
        joint(Axis::Z.joint(), base, table, [0.0; 3], JointMotion::Slide([0.0, 0.0, -1.0], limit(machine, Axis::Z))),
        joint(Axis::C.joint(), table, part, [0.0; 3], JointMotion::Turn([0.0, 0.0, -sense], limit(machine, Axis::C))),
        joint(
            Axis::X.joint(),
            base,
            head,
            [0.0, height, 0.0],
            JointMotion::Slide([1.0, 0.0, 0.0], limit(machine, Axis::X)),
        ),
        joint(WHEEL_JOINT, head, &frames.wheel, wheel_at, JointMotion::Turn(wheel_axis, wheel)),
    ]
}

fn limit(machine: &MachineDescription, axis: Axis) -> Limit {
    let own = machine.axis(axis);
    let range =
        own.soft_limits.or(own.overtravel).map(|(low, high)| (si_from_core(axis, low), si_from_core(axis, high)));
    // Without data of the drive, its limits are those of plans.
    let effort = own.drive.max_force.unwrap_or_else(|| own.inertia * si_from_core(axis, own.limits.acceleration));
    let [velocity, acceleration, jerk] =
        [own.limits.velocity, own.limits.acceleration, own.limits.jerk].map(|value| si_from_core(axis, value));
    Limit { range, velocity, acceleration, jerk: Some(jerk), effort }
}
