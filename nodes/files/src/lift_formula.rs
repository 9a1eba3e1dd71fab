// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lifts that are no table: motion laws segment by segment, what a follower does on an eccentric disc, the arms of a brake's S-cam, and the
//! second cam of a conjugate pair.

use super::ConfigError;
use super::follower_file::mm_per_deg;
use super::lift_context::LiftContext;
use super::lift_file::ProfileLift;
use camwright::cam::follower::Follower;
use camwright::cam::lift::{LiftLaw, LiftLawError, MotionProgram, MotionSegment, ProgramError};
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::rad_from_deg;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// Schema of the name of a motion law.
fn motion_law(_: &mut SchemaGenerator) -> Schema {
    let names: Vec<&str> = MotionLaw::ALL.iter().map(|law| law.name()).collect();
    json_schema!({"type": "string", "enum": names})
}

/// A segment as written.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SegmentFile {
    /// Motion law of the segment.
    #[schemars(schema_with = "motion_law")]
    law: String,
    /// Cam angle of the segment; all segments together make a turn, in a groove as many as its `turns`.
    #[schemars(range(min = 1e-6, max = 18000.0))]
    angle_deg: f64,
    /// Change of the lift; all segments together make 0, except in an open groove. Default: 0.
    #[schemars(range(min = -1e4, max = 1e4))]
    rise_mm: Option<f64>,
    /// Change of the angle of an oscillating follower or of a turret, instead of `rise_mm`.
    #[schemars(range(min = -360.0, max = 360.0))]
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

/// An eccentric as written: what the profile's follower does on it, or, with a diameter, the disc itself.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EccentricFile {
    /// Distance of the disc's centre from the axis. In grinding jobs, with a diameter, it may exceed the radius of the disc: a crank pin.
    #[schemars(range(min = 0.0, max = 1e4))]
    eccentricity_mm: f64,
    /// Cam angle of the farthest point.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    #[serde(default)]
    nose_deg: f64,
    /// Diameter of the disc itself, instead of a follower and a base circle. Needs `diameter_is`.
    #[schemars(range(min = 1e-6, max = 1e4))]
    diameter_mm: Option<f64>,
    /// Meaning of the diameter.
    diameter_is: Option<DiameterFile>,
}

/// Body whose diameter is given.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum DiameterFile {
    /// The disc.
    Disc,
    /// The circle that the disc sweeps: disc and twice the eccentricity.
    Largest,
}

impl EccentricFile {
    /// Returns whether it is the disc itself.
    pub(super) fn is_disc(&self) -> bool {
        self.diameter_mm.is_some() || self.diameter_is.is_some()
    }
}

/// A crank pin as written: a cylinder whose axis lies beside that of the spindle.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CrankPinFile {
    /// Throw: distance of the pin's axis from the spindle axis, in the direction of cam angle 0.
    #[schemars(range(min = 1e-6, max = 1e4))]
    throw_mm: f64,
    /// Diameter of the finished pin.
    #[schemars(range(min = 1e-6, max = 1e4))]
    diameter_mm: f64,
}

/// The S-cam of a brake as written.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SCamFile {
    /// Angle over which an arm lifts the roller by its offset per radian.
    #[schemars(range(min = 1e-6, max = 180.0))]
    working_deg: f64,
    /// Angle of the blend before and after.
    #[schemars(range(min = 1e-6, max = 180.0))]
    blend_deg: f64,
    /// Cam angle at which the first blend begins.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    #[serde(default)]
    start_deg: f64,
}

/// Most segments of a turn, repeats counted.
const MAX_SEGMENTS: usize = 1000;

/// Motion laws one after the other, over one turn or over those of a groove.
pub(super) fn program(
    segments: &[SegmentFile],
    lowest_mm: f64,
    start_deg: f64,
    repeat: usize,
    profile: &LiftContext<'_>,
) -> Result<LiftLaw, Vec<ConfigError>> {
    let turn = repeated(segments, repeat, profile)?;
    let program = MotionProgram::over_turns(profile.turns(), lowest_mm, rad_from_deg(start_deg), &turn)
        .map_err(|error| refuse_program(&error, segments.len(), profile))?;
    LiftLaw::from_program(program).map_err(|error| profile.refuse("segments", error))
}

/// Motion laws one after the other from one end of an open groove to the other.
pub(super) fn open_program(
    segments: &[SegmentFile],
    lowest_mm: f64,
    repeat: usize,
    profile: &LiftContext<'_>,
) -> Result<MotionProgram, Vec<ConfigError>> {
    let all = repeated(segments, repeat, profile)?;
    MotionProgram::open(profile.turns(), lowest_mm, &all)
        .map_err(|error| refuse_program(&error, segments.len(), profile))
}

/// Segments as often as they repeat.
fn repeated(
    segments: &[SegmentFile],
    repeat: usize,
    profile: &LiftContext<'_>,
) -> Result<Vec<MotionSegment>, Vec<ConfigError>> {
    let mut errors = Vec::new();
    let mut known = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        let rise_mm = segment.rise_mm(profile.mm_per_deg()).unwrap_or_else(|(key, message)| {
            errors.extend(profile.refuse(&format!("segments.{index}.{key}"), message));
            0.0
        });
        // Other names are refused with the schema.
        if let Some(law) = MotionLaw::from_name(&segment.law) {
            known.push(MotionSegment { law, angle_rad: rad_from_deg(segment.angle_deg), rise_mm });
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    if known.len().saturating_mul(repeat) > MAX_SEGMENTS {
        let count = known.len();
        let message = format!("repeat is {repeat} with {count} segments; a turn has at most {MAX_SEGMENTS} segments");
        return Err(profile.refuse("repeat", message));
    }
    Ok(core::iter::repeat_n(&known, repeat).flatten().copied().collect())
}

/// A refusal of so many segments at the one at fault.
fn refuse_program(error: &ProgramError, segments: usize, profile: &LiftContext<'_>) -> Vec<ConfigError> {
    let place = |number: usize| format!("segments.{}", (number - 1) % segments.max(1));
    let key = segment_of(error).map_or("segments".to_owned(), place);
    let hint = match error {
        ProgramError::BelowBase { .. } => "; `lowest_lift_mm` allows lifts below the base circle",
        ProgramError::Misclosure { .. } if profile.groove.is_some() => "; `open: true` is for a groove with two ends",
        _ => "",
    };
    profile.refuse(&key, format!("{error}{hint}"))
}

/// Number of the segment at fault, from 1.
fn segment_of(error: &ProgramError) -> Option<usize> {
    match *error {
        ProgramError::BadNumber { segment, .. }
        | ProgramError::DwellRises { segment, .. }
        | ProgramError::BelowBase { segment, .. }
        | ProgramError::MovesAtEnd { segment, .. }
        | ProgramError::VelocityJump { segment, .. }
        | ProgramError::AccelerationJump { segment, .. } => Some(segment.max(1)),
        ProgramError::SegmentCount { .. }
        | ProgramError::AngleSpan { .. }
        | ProgramError::TurnCount { .. }
        | ProgramError::Misclosure { .. } => None,
    }
}

/// Second cam of a pair whose followers are joined.
pub(super) fn conjugate(
    name: &str,
    at_deg: Option<f64>,
    profile: &LiftContext<'_>,
) -> Result<LiftLaw, Vec<ConfigError>> {
    let Some(first) = profile.before.iter().find(|other| other.name == name) else {
        let before: Vec<&str> = profile.before.iter().map(|other| other.name.as_str()).collect();
        let before = if before.is_empty() { "none".to_owned() } else { before.join(", ") };
        let message = format!("conjugate_of is {name}; profiles without errors before this one: {before}");
        return Err(profile.refuse("conjugate_of", message));
    };
    if first.is_pin() {
        let message = format!("{name} is a crank pin, which lifts no follower");
        return Err(profile.refuse("conjugate_of", message));
    }
    let (ratio, usual_deg) = match (profile.mm_per_deg(), mm_per_deg(first.follower)) {
        (None, None) => (1.0, 180.0),
        (Some(second), Some(first)) => (second / first, 0.0),
        _ => {
            let message = format!("the followers of {name} and of this profile are joined: both slide or both swing");
            return Err(profile.refuse("conjugate_of", message));
        }
    };
    let law = first.lift.conjugate(ratio, rad_from_deg(at_deg.unwrap_or(usual_deg)));
    law.map_err(|error| profile.refuse("conjugate_of", error))
}

/// No lift: a journal.
pub(super) fn round(profile: &LiftContext<'_>) -> Result<LiftLaw, Vec<ConfigError>> {
    LiftLaw::eccentric_flat(0.0, 0.0).map_err(|error| profile.refuse("round", error))
}

/// The disc of an eccentric by its diameter, as the lift of a flat follower on it, with that follower and base circle; a disc that
/// misses the axis is a crank pin.
pub(super) fn disc(file: &EccentricFile, profile: &LiftContext<'_>) -> Result<ProfileLift, Vec<ConfigError>> {
    let refuse = |key: &str, message: String| profile.refuse(&format!("eccentric.{key}"), message);
    let (eccentricity_mm, nose_rad) = (file.eccentricity_mm, rad_from_deg(file.nose_deg));
    let (Some(diameter_mm), Some(diameter_is)) = (file.diameter_mm, file.diameter_is) else {
        let message =
            "an eccentric by its diameter needs diameter_mm and what it is that of, diameter_is: disc or largest";
        return Err(refuse("diameter_mm", message.into()));
    };
    let radius_mm = match diameter_is {
        DiameterFile::Disc => 0.5 * diameter_mm,
        DiameterFile::Largest => 0.5 * diameter_mm - eccentricity_mm,
    };
    if radius_mm <= 0.0 {
        let message = format!(
            "eccentricity {eccentricity_mm} mm leaves a disc of {radius_mm} mm within the largest diameter; it must be below half of \
             diameter_mm"
        );
        return Err(refuse("eccentricity_mm", message));
    }
    if eccentricity_mm >= radius_mm {
        if nose_rad != 0.0 {
            let message = format!(
                "nose_deg is {}; the disc misses the axis, and its farthest point is at cam angle 0: turn the lobe by its phase_deg",
                file.nose_deg
            );
            return Err(refuse("nose_deg", message));
        }
        return pin(eccentricity_mm, radius_mm).map_err(|error| refuse("eccentricity_mm", error.to_string()));
    }
    let law = LiftLaw::eccentric_flat(eccentricity_mm, nose_rad)
        .map_err(|error| refuse("eccentricity_mm", error.to_string()))?;
    Ok(ProfileLift::formula(law, Some((Follower::Flat, radius_mm - eccentricity_mm))))
}

/// A crank pin by its throw and diameter.
pub(super) fn crank_pin(file: &CrankPinFile, profile: &LiftContext<'_>) -> Result<ProfileLift, Vec<ConfigError>> {
    pin(file.throw_mm, 0.5 * file.diameter_mm).map_err(|error| profile.refuse("crank_pin", error))
}

/// A circle about a centre so far from the axis, in the direction of cam angle 0.
fn pin(throw_mm: f64, radius_mm: f64) -> Result<ProfileLift, LiftLawError> {
    let law = LiftLaw::eccentric_flat(0.0, 0.0)?;
    Ok(ProfileLift { throw_mm, ..ProfileLift::formula(law, Some((Follower::Flat, radius_mm))) })
}

/// The S-cam of a drum brake: two equal arms half a turn apart, which push a roller each.
///
/// Along the working part of an arm its roller, on a line that passes the axis at a distance e, is lifted by e per radian. Its centre then
/// runs on the involute of the circle of radius e about the axis, and so does the contour beside it, as an involute of the same circle: the
/// normal is that line itself, wherever the arm touches, and no angle of pressure takes force away.
///
/// ```text
///   blend │ working: s′ = e │ blend │ return (4-5-6-7) │ the same once more
/// ```
pub(super) fn s_cam(file: &SCamFile, profile: &LiftContext<'_>) -> Result<LiftLaw, Vec<ConfigError>> {
    let refuse = |key: &str, message: String| profile.refuse(&format!("s_cam.{key}"), message);
    let offset_mm = match profile.follower {
        Some((Follower::Roller { offset_mm, .. } | Follower::KnifeEdge { offset_mm }, _)) => offset_mm,
        _ => {
            return Err(profile.refuse(
                "s_cam",
                "an s_cam is made for a roller on a line beside the axis: follower: {kind: roller, offset_mm: …}",
            ));
        }
    };
    if !offset_mm.is_finite() || offset_mm.abs() <= 0.0 {
        let message = format!(
            "the offset of the roller's line is the radius of the circle whose involutes the arms are; offset_mm is {offset_mm}, it must not be 0"
        );
        return Err(profile.refuse("s_cam", message));
    }
    let back_deg = 180.0 - file.working_deg - 2.0 * file.blend_deg;
    if back_deg <= 0.0 {
        let message = format!(
            "working_deg and twice blend_deg leave {back_deg:.3} deg of the half turn for the return; it must be above 0"
        );
        return Err(refuse("working_deg", message));
    }
    let (working, blend) = (rad_from_deg(file.working_deg), rad_from_deg(file.blend_deg));
    let rise = |angle_rad: f64, share: f64| share * offset_mm.abs() * angle_rad;
    let lift_mm = rise(working, 1.0) + 2.0 * rise(blend, 0.5);
    let mut arm = vec![
        MotionSegment { law: MotionLaw::SepticBlend, angle_rad: blend, rise_mm: rise(blend, 0.5) },
        MotionSegment { law: MotionLaw::ConstantVelocity, angle_rad: working, rise_mm: rise(working, 1.0) },
        MotionSegment { law: MotionLaw::SepticBlend, angle_rad: blend, rise_mm: rise(blend, 0.5) },
        MotionSegment { law: MotionLaw::Polynomial4567, angle_rad: rad_from_deg(back_deg), rise_mm: -lift_mm },
    ];
    // Past the axis on its other side the roller is lifted against the cam angle.
    if offset_mm < 0.0 {
        arm.reverse();
        arm.iter_mut().for_each(|segment| segment.rise_mm = -segment.rise_mm);
    }
    let turn = [arm.clone(), arm].concat();
    let program =
        MotionProgram::new(rad_from_deg(file.start_deg), &turn).map_err(|error| profile.refuse("s_cam", error))?;
    LiftLaw::from_program(program).map_err(|error| profile.refuse("s_cam", error))
}

/// Motion of the follower on a disc of radius base circle + eccentricity, turned about a point off its centre.
pub(super) fn eccentric(file: &EccentricFile, profile: &LiftContext<'_>) -> Result<LiftLaw, Vec<ConfigError>> {
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
