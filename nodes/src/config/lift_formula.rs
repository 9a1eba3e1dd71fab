//! Lifts that are no table: motion laws segment by segment, and what a follower does on an eccentric disc.

use super::ConfigError;
use super::lift_file::OfProfile;
use camwright::follower::Follower;
use camwright::lift::{LiftLaw, MotionProgram, MotionSegment, ProgramError};
use camwright::motion_law::MotionLaw;
use camwright::units::rad_from_deg;
use serde::Deserialize;

/// A segment as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SegmentFile {
    law: String,
    angle_deg: f64,
    rise_mm: Option<f64>,
    rise_deg: Option<f64>,
}

impl SegmentFile {
    /// Its rise (mm); of an arm along its arc.
    fn rise_mm(&self, mm_per_deg: Option<f64>) -> Result<f64, (&'static str, &'static str)> {
        match (self.rise_mm, self.rise_deg, mm_per_deg) {
            (Some(_), Some(_), _) => Err(("rise_deg", "a rise is given in mm and in degrees; one is needed")),
            (None, Some(_), None) => Err(("rise_deg", "rise_deg is the angle of an arm; this follower is on a slide")),
            (None, Some(rise_deg), Some(mm_per_deg)) => Ok(rise_deg * mm_per_deg),
            (rise_mm, None, _) => Ok(rise_mm.unwrap_or(0.0)),
        }
    }
}

/// An eccentric as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EccentricFile {
    eccentricity_mm: f64,
    #[serde(default)]
    nose_deg: f64,
}

/// Motion laws one after the other.
pub(super) fn program(
    segments: &[SegmentFile],
    start_deg: f64,
    profile: &OfProfile<'_>,
) -> Result<LiftLaw, Vec<ConfigError>> {
    let mut errors = Vec::new();
    let mut known = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        let rise_mm = segment.rise_mm(profile.mm_per_deg()).unwrap_or_else(|(key, message)| {
            errors.extend(profile.refuse(&format!("segments.{index}.{key}"), message));
            0.0
        });
        match MotionLaw::from_name(&segment.law) {
            Some(law) => {
                known.push(MotionSegment { law, angle_rad: rad_from_deg(segment.angle_deg), rise_mm });
            }
            None => {
                let names: Vec<&str> = MotionLaw::ALL.iter().map(|law| law.name()).collect();
                let message = format!("there is no motion law {:?}; known are {}", segment.law, names.join(", "));
                errors.extend(profile.refuse(&format!("segments.{index}.law"), message));
            }
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let program = MotionProgram::new(rad_from_deg(start_deg), &known).map_err(|error| {
        let key = segment_of(&error).map_or("segments".to_owned(), |number| format!("segments.{}", number - 1));
        profile.refuse(&key, error)
    })?;
    LiftLaw::from_program(program).map_err(|error| profile.refuse("segments", error))
}

/// Number of the segment at fault, from 1.
fn segment_of(error: &ProgramError) -> Option<usize> {
    match *error {
        ProgramError::BadNumber { segment, .. }
        | ProgramError::DwellRises { segment, .. }
        | ProgramError::BelowBase { segment, .. }
        | ProgramError::VelocityJump { segment, .. }
        | ProgramError::AccelerationJump { segment, .. } => Some(segment.max(1)),
        ProgramError::SegmentCount { .. } | ProgramError::AngleSpan { .. } | ProgramError::Misclosure { .. } => None,
    }
}

/// No lift: a journal.
pub(super) fn round(profile: &OfProfile<'_>) -> Result<LiftLaw, Vec<ConfigError>> {
    LiftLaw::eccentric_flat(0.0, 0.0).map_err(|error| profile.refuse("round", error))
}

/// What the follower does on a disc of radius base circle + eccentricity, turned about a point off its centre.
pub(super) fn eccentric(file: &EccentricFile, profile: &OfProfile<'_>) -> Result<LiftLaw, Vec<ConfigError>> {
    let refuse = |message: String| profile.refuse("eccentric", message);
    let (eccentricity_mm, nose_rad) = (file.eccentricity_mm, rad_from_deg(file.nose_deg));
    let Some((follower, base_radius_mm)) = profile.follower else {
        return Err(refuse("the lift of an eccentric needs a follower and a base circle".into()));
    };
    let round = |tip_radius_mm: f64| {
        let pitch_radius_mm = base_radius_mm + eccentricity_mm + tip_radius_mm;
        LiftLaw::eccentric_round(eccentricity_mm, pitch_radius_mm, nose_rad)
    };
    let law = match follower {
        Follower::KnifeEdge { offset_mm } | Follower::Roller { offset_mm, .. } if offset_mm.abs() > 0.0 => {
            return Err(refuse(format!(
                "the lift of an eccentric is known for a follower without offset; offset_mm is {offset_mm}"
            )));
        }
        Follower::KnifeEdge { .. } => round(0.0),
        Follower::Roller { radius_mm, .. } | Follower::Mushroom { radius_mm } => round(radius_mm),
        Follower::Flat => LiftLaw::eccentric_flat(eccentricity_mm, nose_rad),
        Follower::OscillatingRoller { .. } | Follower::OscillatingFlat { .. } => {
            let message = "the lift of an eccentric is known for a follower on a slide; this one oscillates";
            return Err(refuse(message.into()));
        }
    };
    law.map_err(|error| refuse(error.to_string()))
}
