// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why there is no program.

use super::{FeatureRequest, NcControl, PassRequest, PostRequest, ProgramTurnSpeed};
use crate::gcode::archimedean::ChainError;
use crate::gcode::{FormatError, RaisedFeed};
use crate::math::units::TURN_RAD;
use crate::toolpath::cutter_path::CutterPath;
use alloc::boxed::Box;
use alloc::string::String;
use thiserror::Error;

/// Most turns of one call.
const MAX_TURNS: u32 = 100;

/// Most calls of a program.
const MAX_CALLS: usize = 100_000;

/// Why there is no program.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PostError {
    /// More blocks in a turn than a program should have.
    #[error(
        "a turn takes at least {blocks} blocks, at most {allowed} are allowed: so slow a turn is driven in single increments; a faster \
         work speed, or fewer decimals"
    )]
    TooLongTurn {
        /// Blocks that the turn takes at least.
        blocks: u64,
        allowed: u64,
    },
    /// More blocks in a pass than a program should have.
    #[error("the pass takes more than {allowed} blocks ({blocks} so far): a larger tolerance, or a larger feed")]
    TooLongPass {
        /// Number of blocks so far.
        blocks: u64,
        allowed: u64,
    },
    /// More turns than C has digits for.
    #[error(
        "C counts on over {turns:.1} turns; with {decimals} decimals the control has digits for {max:.1}: fewer decimals of angles, or a \
         larger feed"
    )]
    TooManyTurns {
        turns: f64,
        /// Turns that the control has digits for.
        max: f64,
        /// Decimals of angles.
        decimals: u32,
    },
    /// A number that makes no program.
    #[error("{what} is {value}; {allowed}")]
    BadNumber {
        what: String,
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    #[error("the program is empty: {what}")]
    Nothing { what: String },
    /// The path cannot be cut into pieces.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// A coordinate that the control cannot read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Something of a pass.
    #[error("{feature}, pass {pass}: {source}")]
    Of { feature: String, pass: String, source: Box<PostError> },
    /// More blocks than the control reads.
    #[error(
        "{feature}, pass {pass}: {blocks_s:.0} blocks a second with a tolerance of {tolerance_um:.3} um; the control reads {max_s:.0}. It \
         would at {fits_rpm:.3} rpm, or with a larger tolerance"
    )]
    TooManyBlocks {
        feature: String,
        pass: String,
        /// Blocks in a second.
        blocks_s: f64,
        /// Longest duration that the control reads.
        max_s: f64,
        /// With which tolerance (um).
        tolerance_um: f64,
        /// Speed of C with which it would read them (rpm).
        fits_rpm: f64,
    },
    /// More subprograms than there are numbers.
    #[error("{count} subprograms are more than there are numbers")]
    TooManySubprograms { count: usize },
    /// The program is outside its tolerance.
    #[error("the pieces are {error_um:.4} um off at {at_deg:.3} deg; allowed: {allowed_um:.4} um")]
    OffThePath {
        /// Deviation (um).
        error_um: f64,
        /// Allowed deviation (um).
        allowed_um: f64,
        /// Angle (deg).
        at_deg: f64,
    },
    /// A block that LinuxCNC would drive too fast.
    #[error(transparent)]
    RaisedFeed(RaisedFeed),
    /// Another number of calls came back.
    #[error("{found} runs of feeds, but {expected} calls")]
    OtherCalls { found: usize, expected: usize },
    /// A run of feeds that is not over the angles of its pass.
    #[error(
        "pass {pass}: the feeds turn C from {:.3} to {:.3} deg, the path from {:.3} to {:.3} deg", found[0], found[1], expected[0],
        expected[1]
    )]
    OtherAngles {
        pass: String,
        /// Begin and end as they were read (deg).
        found: [f64; 2],
        /// Begin and end of the path (deg).
        expected: [f64; 2],
    },
    /// A rapid beside the part that is not clear of it.
    #[error("{feature}: a rapid at {at_mm:.4} mm; it is clear at {clear_mm:.4} mm")]
    RapidNotClear {
        feature: String,
        /// Position of the infeed axis (mm).
        at_mm: f64,
        /// Position at which the infeed axis is clear (mm).
        clear_mm: f64,
    },
}

impl PostError {
    /// The same, of a pass of a feature.
    pub(super) fn within(self, feature: &str, pass: &str) -> Self {
        PostError::Of { feature: feature.into(), pass: pass.into(), source: Box::new(self) }
    }
}

/// Refuses numbers that make no program.
pub(super) fn check(request: &PostRequest<'_>) -> Result<(), PostError> {
    check_control(&request.control)?;
    if request.features.is_empty() {
        return Err(PostError::Nothing { what: "no cam and no groove".into() });
    }
    let calls = request.features.iter().flat_map(|of| &of.passes).map(|pass| pass.leaves_mm.len()).sum::<usize>();
    bad_unless(calls <= MAX_CALLS, "the number of calls", calls as f64, "at most 100000 are made")?;
    for of in &request.features {
        check_feature(of)?;
        for pass in &of.passes {
            check_pass(of.path, pass).map_err(|error| error.within(&of.name, &pass.name))?;
        }
    }
    Ok(())
}

/// Refuses numbers that no control has.
pub(super) fn check_control(control: &NcControl) -> Result<(), PostError> {
    positive("block rate of the control", control.max_blocks_s)?;
    if let Some(mm) = control.path_tolerance_mm {
        positive("the control's path tolerance in mm", mm)?;
    }
    let sense = f64::from(control.rotation_sense);
    bad_unless(control.rotation_sense.abs() == 1, "the rotation sense", sense, "it must be 1 or -1")
}

fn check_feature(of: &FeatureRequest<'_>) -> Result<(), PostError> {
    let named = |what: &str| alloc::format!("{}: {what}", of.name);
    if of.passes.iter().all(|pass| pass.leaves_mm.is_empty()) {
        return Err(PostError::Nothing { what: named("it has no pass") });
    }
    let angle = of.lead.angle_rad;
    bad_unless(
        angle > 0.0 && angle <= TURN_RAD,
        &named("the angle in rad over which the cutter comes"),
        angle,
        "it must be above 0 and within a turn",
    )?;
    let height = of.lead.height_mm;
    positive(&named("the height in mm from which the cutter comes"), height)?;
    bad_unless(of.clear_mm.is_finite(), &named("where the cutter is clear"), of.clear_mm, "it must be a number of mm")?;
    bad_unless(of.phase_rad.is_finite(), &named("the phase in rad"), of.phase_rad, "it must be a number")
}

fn check_pass(path: &CutterPath, pass: &PassRequest<'_>) -> Result<(), PostError> {
    positive("the tolerance in mm", pass.tolerance_mm)?;
    let widest = pass.widest_tolerance_mm;
    bad_unless(
        widest >= pass.tolerance_mm && widest.is_finite(),
        "the widest tolerance in mm",
        widest,
        "it must be no less than the tolerance",
    )?;
    let turns = f64::from(pass.turns);
    bad_unless((1..=MAX_TURNS).contains(&pass.turns), "the number of turns of a call", turns, "it must be 1 to 100")?;
    let allowed = "an open path is run once in a call";
    bad_unless(!path.is_open() || pass.turns == 1, "the number of turns of a call", turns, allowed)?;
    for leaves_mm in &pass.leaves_mm {
        bad_unless(
            leaves_mm.is_finite() && *leaves_mm >= 0.0,
            "what is left of the depth in mm",
            *leaves_mm,
            "it must not be below 0",
        )?;
    }
    let speeds = match pass.speed {
        ProgramTurnSpeed::WorkSpeed(speed) => alloc::vec![speed],
        ProgramTurnSpeed::AlongPath { feed_mm_s, max_rad_s } => alloc::vec![feed_mm_s, max_rad_s],
        ProgramTurnSpeed::Law(_) => alloc::vec![],
    };
    speeds.into_iter().try_for_each(|speed| {
        bad_unless(speed.is_finite() && speed > 0.0, "the speed (rad/s of C or mm/s)", speed, "it must be above 0")
    })
}

pub(super) fn positive(what: &str, value: f64) -> Result<(), PostError> {
    bad_unless(value.is_finite() && value > 0.0, what, value, "it must be above 0")
}

pub(super) fn bad_unless(good: bool, what: &str, value: f64, allowed: &'static str) -> Result<(), PostError> {
    if good { Ok(()) } else { Err(PostError::BadNumber { what: what.into(), value, allowed }) }
}
