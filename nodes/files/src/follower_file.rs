// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The follower of a profile as a job writes it, and the follower it means. What its numbers must be to ride on a cam the
//! core says.

use camwright::cam::follower::{ArmSide, Follower, Pivot, SwingLift};
use camwright::math::units::rad_from_deg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `follower` of a profile as written.
#[derive(Debug, Clone, Deserialize, JsonSchema, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum FollowerFile {
    /// Edge on a slide.
    Knife {
        /// Distance of the follower's line from the axis of the cam, positive towards increasing cam angle.
        #[serde(default)]
        offset_mm: f64,
    },
    /// Roller on a slide.
    Roller {
        /// Radius of the roller, or of the curved face.
        radius_mm: f64,
        /// Distance of the follower's line from the axis of the cam, positive towards increasing cam angle.
        #[serde(default)]
        offset_mm: f64,
    },
    /// Curved face on a slide.
    Mushroom {
        /// Radius of the roller, or of the curved face.
        radius_mm: f64,
    },
    /// Flat face on a slide.
    Flat {},
    /// Roller on an arm.
    OscillatingRoller {
        /// Radius of the roller, or of the curved face.
        radius_mm: f64,
        /// Distance from the pivot to the centre of the roller.
        #[schemars(range(min = 1e-6, max = 1e4))]
        arm_mm: f64,
        /// Distance of the pivot from the axis of the cam. The cam angle is that of the pivot, seen from the cam.
        pivot_mm: f64,
        /// Direction of the arm from its pivot.
        side: SideFile,
        /// Distance from the pivot to the point whose travel along its arc is the lift in mm. Default: `arm_mm`.
        #[schemars(range(min = 1e-6, max = 1e4))]
        arc_radius_mm: Option<f64>,
    },
    /// Flat face on an arm.
    OscillatingFlat {
        /// Distance of the face from the pivot, positive with the pivot on the cam's side of the face.
        #[serde(default)]
        face_offset_mm: f64,
        /// Distance of the pivot from the axis of the cam. The cam angle is that of the pivot, seen from the cam.
        pivot_mm: f64,
        /// Direction of the arm from its pivot.
        side: SideFile,
        /// Distance from the pivot to the point whose travel along its arc is the lift in mm.
        #[schemars(range(min = 1e-6, max = 1e4))]
        arc_radius_mm: f64,
    },
}

/// Direction of the arm from its pivot.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SideFile {
    /// Towards increasing cam angle.
    Ahead,
    /// Against increasing cam angle.
    Behind,
}

impl FollowerFile {
    /// The follower it means.
    pub(super) fn follower(&self) -> Follower {
        match *self {
            FollowerFile::Knife { offset_mm } => Follower::KnifeEdge { offset_mm },
            FollowerFile::Roller { radius_mm, offset_mm } => Follower::Roller { radius_mm, offset_mm },
            FollowerFile::Mushroom { radius_mm } => Follower::Mushroom { radius_mm },
            FollowerFile::Flat {} => Follower::Flat,
            FollowerFile::OscillatingRoller { radius_mm, arm_mm, pivot_mm, side, arc_radius_mm } => {
                let pivot = pivot(pivot_mm, side, arc_radius_mm.unwrap_or(arm_mm));
                Follower::OscillatingRoller { radius_mm, arm_mm, pivot }
            }
            FollowerFile::OscillatingFlat { face_offset_mm, pivot_mm, side, arc_radius_mm } => {
                Follower::OscillatingFlat { face_offset_mm, pivot: pivot(pivot_mm, side, arc_radius_mm) }
            }
        }
    }
}

/// A pivot whose lift is the arc of a point of the arm. A lift written in degrees becomes that arc when it is read, so that
/// every lift of a job is a length.
fn pivot(distance_mm: f64, side: SideFile, arc_radius_mm: f64) -> Pivot {
    let side = match side {
        SideFile::Ahead => ArmSide::Ahead,
        SideFile::Behind => ArmSide::Behind,
    };
    Pivot { distance_mm, side, lift: SwingLift::Arc { radius_mm: arc_radius_mm } }
}

/// Arc of a degree of a follower's arm (mm); `None` for a follower on a slide.
pub(super) fn mm_per_deg(follower: Follower) -> Option<f64> {
    match follower {
        Follower::OscillatingRoller { pivot, .. } | Follower::OscillatingFlat { pivot, .. } => match pivot.lift {
            SwingLift::Arc { radius_mm } => Some(rad_from_deg(1.0) * radius_mm),
            SwingLift::Degrees => Some(1.0),
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<FollowerFile, String> {
        serde_saphyr::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn every_kind_means_its_follower() {
        let meaning = |text: &str| read(text).unwrap().follower();
        assert_eq!(meaning("{kind: knife}"), Follower::KnifeEdge { offset_mm: 0.0 });
        assert_eq!(meaning("{kind: roller, radius_mm: 8.5}"), Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 });
        assert_eq!(meaning("{kind: mushroom, radius_mm: 400}"), Follower::Mushroom { radius_mm: 400.0 });
        assert_eq!(meaning("{kind: flat}"), Follower::Flat);
        let pivot = Pivot { distance_mm: 50.0, side: ArmSide::Behind, lift: SwingLift::Arc { radius_mm: 42.0 } };
        assert_eq!(
            meaning("{kind: oscillating_roller, radius_mm: 8.5, arm_mm: 42, pivot_mm: 50, side: behind}"),
            Follower::OscillatingRoller { radius_mm: 8.5, arm_mm: 42.0, pivot }
        );
        let pivot = Pivot { distance_mm: 50.0, side: ArmSide::Ahead, lift: SwingLift::Arc { radius_mm: 50.0 } };
        assert_eq!(
            meaning("{kind: oscillating_flat, pivot_mm: 50, face_offset_mm: -3, side: ahead, arc_radius_mm: 50}"),
            Follower::OscillatingFlat { face_offset_mm: -3.0, pivot }
        );
        let elsewhere = meaning(
            "{kind: oscillating_roller, radius_mm: 8.5, arm_mm: 42, pivot_mm: 50, side: behind, arc_radius_mm: 66}",
        );
        assert!((mm_per_deg(elsewhere).unwrap() - 66.0 * std::f64::consts::PI / 180.0).abs() < 1e-15);
        assert_eq!(mm_per_deg(Follower::Flat), None);
    }

    #[test]
    fn an_arm_must_say_all_of_itself() {
        let roller = "kind: oscillating_roller, radius_mm: 8.5, arm_mm: 42";
        for (wrong, text) in [
            ("side", format!("{{{roller}, pivot_mm: 50}}")),
            ("pivot_mm", format!("{{{roller}, side: ahead}}")),
            ("offset_mm", format!("{{{roller}, pivot_mm: 50, side: ahead, offset_mm: 1}}")),
            ("beside", format!("{{{roller}, pivot_mm: 50, side: beside}}")),
            ("arc_radius_mm", "{kind: oscillating_flat, pivot_mm: 50, side: ahead}".into()),
        ] {
            let error = read(&text).unwrap_err();
            assert!(error.contains(wrong), "{error}");
        }
    }
}
