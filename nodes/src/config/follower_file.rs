//! The follower of a profile as a job writes it, and the follower it means. What its numbers must be to ride on a cam the
//! core says.

use camwright::follower::{ArmSide, Follower, Pivot, SwingLift};
use serde::Deserialize;

/// `follower` of a profile as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum FollowerFile {
    Knife {
        #[serde(default)]
        offset_mm: f64,
    },
    Roller {
        radius_mm: f64,
        #[serde(default)]
        offset_mm: f64,
    },
    Mushroom {
        radius_mm: f64,
    },
    Flat {},
    OscillatingRoller {
        radius_mm: f64,
        arm_mm: f64,
        pivot_mm: f64,
        side: SideFile,
        lift_in: LiftIn,
        arc_radius_mm: Option<f64>,
    },
    OscillatingFlat {
        #[serde(default)]
        face_offset_mm: f64,
        pivot_mm: f64,
        side: SideFile,
        lift_in: LiftIn,
        arc_radius_mm: Option<f64>,
    },
}

/// Where the arm reaches from its pivot.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SideFile {
    Ahead,
    Behind,
}

/// What the numbers of an oscillating follower's lift are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum LiftIn {
    Degrees,
    Arc,
}

impl FollowerFile {
    /// The follower it means.
    pub(super) fn follower(&self) -> Follower {
        match *self {
            FollowerFile::Knife { offset_mm } => Follower::KnifeEdge { offset_mm },
            FollowerFile::Roller { radius_mm, offset_mm } => Follower::Roller { radius_mm, offset_mm },
            FollowerFile::Mushroom { radius_mm } => Follower::Mushroom { radius_mm },
            FollowerFile::Flat {} => Follower::Flat,
            FollowerFile::OscillatingRoller { radius_mm, arm_mm, pivot_mm, side, lift_in, arc_radius_mm } => {
                let lift = swing_lift(lift_in, arc_radius_mm.unwrap_or(arm_mm));
                Follower::OscillatingRoller { radius_mm, arm_mm, pivot: pivot(pivot_mm, side, lift) }
            }
            FollowerFile::OscillatingFlat { face_offset_mm, pivot_mm, side, lift_in, arc_radius_mm } => {
                // Refused by `findings` where an arc has no radius.
                let lift = swing_lift(lift_in, arc_radius_mm.unwrap_or(pivot_mm));
                Follower::OscillatingFlat { face_offset_mm, pivot: pivot(pivot_mm, side, lift) }
            }
        }
    }

    /// Keys that contradict each other, each with what is wrong.
    pub(super) fn findings(&self) -> Vec<(&'static str, String)> {
        let (lift_in, arc_radius_mm, has_arm) = match *self {
            FollowerFile::OscillatingRoller { lift_in, arc_radius_mm, .. } => (lift_in, arc_radius_mm, true),
            FollowerFile::OscillatingFlat { lift_in, arc_radius_mm, .. } => (lift_in, arc_radius_mm, false),
            _ => return Vec::new(),
        };
        match (lift_in, arc_radius_mm) {
            (LiftIn::Degrees, Some(radius_mm)) => {
                let message = format!("arc_radius_mm is {radius_mm}, but lift_in: degrees knows no arc");
                vec![("arc_radius_mm", message)]
            }
            (LiftIn::Arc, None) if !has_arm => {
                let message = "lift_in: arc needs arc_radius_mm, the distance from the pivot at which it is measured";
                vec![("lift_in", message.into())]
            }
            _ => Vec::new(),
        }
    }
}

fn pivot(distance_mm: f64, side: SideFile, lift: SwingLift) -> Pivot {
    let side = match side {
        SideFile::Ahead => ArmSide::Ahead,
        SideFile::Behind => ArmSide::Behind,
    };
    Pivot { distance_mm, side, lift }
}

fn swing_lift(lift_in: LiftIn, arc_radius_mm: f64) -> SwingLift {
    match lift_in {
        LiftIn::Degrees => SwingLift::Degrees,
        LiftIn::Arc => SwingLift::Arc { radius_mm: arc_radius_mm },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<FollowerFile, String> {
        serde_saphyr::from_str(text).map_err(|error| error.to_string())
    }

    fn pivot_of(follower: Follower) -> Pivot {
        match follower {
            Follower::OscillatingRoller { pivot, .. } | Follower::OscillatingFlat { pivot, .. } => pivot,
            other => panic!("{other:?} has no pivot"),
        }
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
            meaning("{kind: oscillating_roller, radius_mm: 8.5, arm_mm: 42, pivot_mm: 50, side: behind, lift_in: arc}"),
            Follower::OscillatingRoller { radius_mm: 8.5, arm_mm: 42.0, pivot }
        );
        let pivot = Pivot { distance_mm: 50.0, side: ArmSide::Ahead, lift: SwingLift::Degrees };
        assert_eq!(
            meaning("{kind: oscillating_flat, pivot_mm: 50, face_offset_mm: -3, side: ahead, lift_in: degrees}"),
            Follower::OscillatingFlat { face_offset_mm: -3.0, pivot }
        );
        let elsewhere = "{kind: oscillating_flat, pivot_mm: 50, side: ahead, lift_in: arc, arc_radius_mm: 66}";
        assert_eq!(pivot_of(meaning(elsewhere)).lift, SwingLift::Arc { radius_mm: 66.0 });
    }

    #[test]
    fn an_arm_must_say_all_of_itself_and_nothing_twice() {
        let roller = "kind: oscillating_roller, radius_mm: 8.5, arm_mm: 42, pivot_mm: 50";
        for (missing, text) in [
            ("side", format!("{{{roller}, lift_in: arc}}")),
            ("lift_in", format!("{{{roller}, side: ahead}}")),
            ("offset_mm", format!("{{{roller}, side: ahead, lift_in: arc, offset_mm: 1}}")),
            ("beside", format!("{{{roller}, side: beside, lift_in: arc}}")),
        ] {
            let error = read(&text).unwrap_err();
            assert!(error.contains(missing), "{error}");
        }
        let findings = |text: String| read(&text).unwrap().findings();
        assert!(findings(format!("{{{roller}, side: ahead, lift_in: arc}}")).is_empty());
        let twice = findings(format!("{{{roller}, side: ahead, lift_in: degrees, arc_radius_mm: 40}}"));
        assert_eq!(twice[0].0, "arc_radius_mm");
        let no_radius = findings("{kind: oscillating_flat, pivot_mm: 50, side: ahead, lift_in: arc}".into());
        assert_eq!(no_radius[0].0, "lift_in");
    }
}
