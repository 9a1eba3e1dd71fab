// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why a job cannot be planned.

use crate::cam::contour::ContourError;
use crate::job::dressing::DressError;
use crate::job::grinding::{JobError, Subject};
use crate::job::infeed::InfeedError;
use crate::machine::description::{Axis, WheelTooFast};
use crate::math::periodic_spline::PeriodicSplineError;
use crate::math::units::um_from_mm;
use crate::motion::point_to_point::PointToPointError;
use crate::motion::speed_plan::SpeedPlanError;
use crate::planner::plan_check::PlanCheckError;
use crate::toolpath::wheel_path::ToolPathError;
use alloc::string::String;
use thiserror::Error;

/// Why a job cannot be planned: what, how much, how much is allowed, and where.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// The job asks for something that no path could give.
    #[error(transparent)]
    Job(#[from] JobError),
    /// A profile has no contour.
    #[error("profile {profile}: {source}")]
    Contour {
        /// Name of the profile.
        profile: String,
        source: ContourError,
    },
    /// The wheel cannot make a profile.
    #[error("{lobes}profile {profile}: {source}{advice}")]
    Path {
        /// `lobes E1, E2: `, those that have the profile; nothing if none has.
        lobes: String,
        /// Advice to the user after a semicolon, or empty.
        advice: String,
        /// Name of the profile.
        profile: String,
        source: ToolPathError,
    },
    /// The learned correction of a lobe gives no path.
    #[error(
        "lobe {lobe}: corrected by what was learned, up to {:.3} um, it cannot be ground: {source}; learn again (form_compensation.afresh) or lower the bounds of form_compensation",
        1e3 * .max_mm
    )]
    Compensated {
        lobe: String,
        /// Its largest correction (mm).
        max_mm: f64,
        source: ToolPathError,
    },
    /// The wheel's centre comes to the axis of the part.
    #[error(
        "profile {profile}: the wheel's centre comes through the spindle axis, so the infeed cannot be measured along the normal \
         ({source}); with infeed.along: x it can"
    )]
    NoNormal {
        /// Name of the profile.
        profile: String,
        /// Cause.
        source: PeriodicSplineError,
    },
    /// C turns on, and the wheel finds no way onto the lobe.
    #[error(
        "lobe {lobe}: with c_axis turning on x_axis finds no approach from {clear_x_mm} mm, its position between the lobes, to the path; c_between_lobes: stops needs none"
    )]
    NoArrival {
        lobe: String,
        /// Position of X (mm).
        clear_x_mm: f64,
    },
    /// A variation of the work speed changes the speed faster than the axes can.
    #[error(
        "lobe {lobe}, pass {pass}: a change of the work speed takes half of {shortest_turns:.2} turns within the limits of the axes; \
         speed_variation.period_turns must be at least that, and at most 3; at a lower work speed a change takes less of a turn"
    )]
    VariationTooFast {
        lobe: String,
        pass: String,
        /// Shortest period (turns).
        shortest_turns: f64,
    },
    /// A part that needs two wheels is two jobs.
    #[error(
        "the machine has one wheel, of radius {mounted_mm:.3} mm, and the job needs {wishes}; {needs}: split it into one job per wheel"
    )]
    TwoWheels {
        /// Radius of the wheel mounted (mm).
        mounted_mm: f64,
        /// Requirements of the lobes.
        wishes: String,
        /// The largest wheel that each lobe can be ground with.
        needs: String,
    },
    /// The wheel would come too near to something.
    #[error(
        "{step}: the wheel would be at {x_mm:.3} mm from the spindle axis with z_axis at {} mm, where {what} reaches \
         {reach_mm:.3} mm; with clearance_mm at {clearance_mm} x_axis must stay at {:.3} mm or more, {:.3} mm farther out",
        range(*.z_mm), .reach_mm + .clearance_mm, .reach_mm + .clearance_mm - .x_mm
    )]
    Collision {
        /// Label of the step.
        step: String,
        /// Index of the lobe that the step is for.
        lobe: Option<usize>,
        /// Name of the obstacle: `obstacle journal 1`, `lobe E1`, `the tailstock`.
        what: String,
        /// Index of the obstacle, if it is one of the job.
        obstacle: Option<usize>,
        /// Its radius, stock included (mm).
        reach_mm: f64,
        /// Nearest position of X (mm).
        x_mm: f64,
        /// Positions of the table (mm).
        z_mm: (f64, f64),
        /// Distance to keep (mm).
        clearance_mm: f64,
    },
    /// The wheel meets the wall of a bore on the side opposite to the one that it grinds.
    #[error(
        "{step}: the wheel would reach {side_mm:.3} mm beyond the axis in bore {lobe}, whose wall is there {radius_mm:.3} mm from it; \
         {clearance_mm} mm of clearance are needed (x_axis at {x_mm:.3} mm, z_axis {:.1} to {:.1} mm): use a smaller wheel, or a smaller \
         home.x_mm, retract_clearance_mm or rapid_advance_mm",
        .z_mm.0, .z_mm.1
    )]
    OppositeWall {
        /// Label of the step.
        step: String,
        /// Name of the bore.
        lobe: String,
        /// Smallest radius of its raw wall (mm).
        radius_mm: f64,
        /// Distance of the wheel's other side from the axis (mm).
        side_mm: f64,
        /// Largest position of X (mm).
        x_mm: f64,
        /// Positions of the table (mm).
        z_mm: (f64, f64),
        /// Distance to keep (mm).
        clearance_mm: f64,
    },
    /// The wheel cannot be dressed as wanted.
    #[error(transparent)]
    Dress(#[from] DressError),
    /// The wheel would turn too fast.
    #[error("lobe {lobe}: {source}")]
    WheelTooFast {
        /// Name of the lobe.
        lobe: String,
        source: WheelTooFast,
    },
    /// The infeed fits no whole turns.
    #[error("pass {pass}: {source}")]
    Infeed {
        /// Name of the pass.
        pass: String,
        source: InfeedError,
    },
    /// C cannot turn as wanted.
    #[error("lobe {lobe}, pass {pass}: {source}")]
    Speed {
        /// Name of the lobe.
        lobe: String,
        /// Name of the pass.
        pass: String,
        source: SpeedPlanError,
    },
    /// A position lies beyond a soft limit.
    #[error("{}{what} needs {} at {position_mm:.4} mm; its soft limits are {low_mm} to {high_mm} mm", place.prefix(), axis.joint())]
    SoftLimit {
        place: Subject,
        what: RequiredPosition,
        axis: Axis,
        /// Position needed (mm).
        position_mm: f64,
        /// Smallest allowed (mm).
        low_mm: f64,
        /// Largest allowed (mm).
        high_mm: f64,
    },
    /// The wheel would meet the blank before the cut.
    #[error(
        "lobe {lobe}: the rapid advance ends {gap_mm:.4} mm off the contour, inside the {stock_mm} mm of stock: the wheel \
         would touch the blank in rapid; the total infeed of {total_infeed_mm} mm must be more than {min_mm:.4} mm there"
    )]
    TouchesBlank {
        /// Name of the lobe.
        lobe: String,
        /// Distance of the wheel from the finished contour (mm).
        gap_mm: f64,
        /// Stock of the blank (mm).
        stock_mm: f64,
        /// Total infeed (mm).
        total_infeed_mm: f64,
        /// Total infeed that would just touch (mm).
        min_mm: f64,
    },
    /// The contour is too sharp for a section inside it.
    #[error(
        "lobe {lobe}: taper_um and crown_um put the ends of the lobe {:.3} um inside profile {profile}, whose smallest convex radius is {:.3} um \
         (at cam angle {cam_deg:.2} deg); it must be more: lower them, or round the profile",
        um_from_mm(*.inside_mm), um_from_mm(*.radius_mm)
    )]
    SharpForTaper {
        lobe: String,
        /// Name of the profile.
        profile: String,
        radius_mm: f64,
        /// Largest distance of a section inside the contour (mm).
        inside_mm: f64,
        cam_deg: f64,
    },
    /// The raw part is larger than the infeed can begin above.
    #[error(
        "lobe {lobe}: the gauge finds {stock_mm:.4} mm of stock where the job says {expected_mm:.4} mm; the infeed begins so that {max_mm:.4} mm \
         are the most, with a margin of {margin_mm:.4} mm"
    )]
    TooMuchStock {
        /// Name of the lobe.
        lobe: String,
        /// Measured stock (mm).
        stock_mm: f64,
        /// Stock of the job (mm).
        expected_mm: f64,
        /// Most allowed (mm).
        max_mm: f64,
        /// The job's margin (mm).
        margin_mm: f64,
    },
    /// The raw part is too small to be ground.
    #[error(
        "lobe {lobe}: the gauge finds {stock_mm:.4} mm of stock, and more than {min_mm:.4} mm are needed: there is nothing to grind"
    )]
    NoStock {
        /// Name of the lobe.
        lobe: String,
        /// Measured stock (mm).
        stock_mm: f64,
        /// Stock that the passes leave (mm).
        min_mm: f64,
    },
    /// The wheel is not clear of the part while the table or the part moves.
    #[error(
        "{}{what} leaves x_axis at {x_mm:.3} mm while {moving} moves; lobe {highest} reaches {reach_mm:.3} mm with its \
         stock: {remedy} at least {lacking_mm:.3} mm more",
        place.prefix()
    )]
    NotClear {
        place: Subject,
        /// Motion that leaves it there.
        what: IdleWheelStep,
        /// Position of X (mm).
        x_mm: f64,
        /// Joint that moves meanwhile.
        moving: &'static str,
        /// The lobe that reaches farthest.
        highest: String,
        /// Reach (mm).
        reach_mm: f64,
        remedy: &'static str,
        /// Missing amount (mm).
        lacking_mm: f64,
    },
    /// A move cannot be made.
    #[error("{what}: {source}")]
    Move {
        /// Label of the step.
        what: String,
        source: PointToPointError,
    },
    /// The wheel of a dry run would come too near to a lobe.
    #[error(
        "lobe {lobe}: a dry run {stand_off_mm} mm farther out does not keep {needed_mm} mm off the contour all round (the stock and \
         clearance_mm); {min_mm:.2} mm are enough"
    )]
    DryRun {
        /// Name of the lobe.
        lobe: String,
        /// Position of X (mm).
        stand_off_mm: f64,
        /// Required clearance from the contour (mm).
        needed_mm: f64,
        /// The stand-off that keeps it (mm).
        min_mm: f64,
    },
    /// The wheel would be deeper in the part than allowed.
    #[error(
        "{step}: {}with c_axis at {c_deg:.2} deg the wheel would be {:.2} um below {surface} of lobe {lobe}; {:.2} um are allowed ({why})",
        in_turn(*.turn), um_from_mm(*.depth_mm), um_from_mm(*.allowed_mm)
    )]
    Gouges {
        /// Label of the step.
        step: String,
        /// Name of the lobe.
        lobe: String,
        /// Turns of C since a cut began.
        turn: Option<f64>,
        /// Angle of C (deg).
        c_deg: f64,
        /// Depth below the surface (mm).
        depth_mm: f64,
        /// Depth allowed (mm).
        allowed_mm: f64,
        surface: &'static str,
        /// Reason for the allowed depth.
        why: &'static str,
    },
    /// The finished plan failed its forward check: a defect of the planner, reported before anything moves.
    #[error("the plan failed its forward check: {0}")]
    Check(#[from] PlanCheckError),
}

/// `in turn 3 `, or nothing.
fn in_turn(turns: Option<f64>) -> String {
    turns.map_or_else(String::new, |turns| alloc::format!("in turn {:.0} ", libm::floor(turns) + 1.0))
}

/// `80.000` or `80.000 to 125.000`.
fn range((low, high): (f64, f64)) -> String {
    if high - low < 1e-9 { alloc::format!("{low:.3}") } else { alloc::format!("{low:.3} to {high:.3}") }
}

/// Position that a plan needs of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RequiredPosition {
    Home,
    LowestPoint,
    Hold,
    BetweenLobes,
    RapidAdvance,
    LowestCorrection,
    CorrectionHold,
    DryRunHome,
    DryRunHold,
    PastDresser,
    Dresser,
    SearchStart,
    SearchEnd,
    Plunge,
}

impl core::fmt::Display for RequiredPosition {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Home => "the home position",
            Self::LowestPoint => "the lowest point of the path",
            Self::Hold => "a hold on the highest point of the path",
            Self::BetweenLobes => "the wheel between the lobes",
            Self::RapidAdvance => "the start of the rapid advance",
            Self::LowestCorrection => "the lowest point of the correction",
            Self::CorrectionHold => "a hold in the correction",
            Self::DryRunHome => "the home position of the dry run",
            Self::DryRunHold => "a hold of the dry run on the highest point of the path",
            Self::PastDresser => "the path past the dresser",
            Self::Dresser => "the dresser",
            Self::SearchStart => "the start of the search for the station's switch",
            Self::SearchEnd => "the end of the search for the station's switch",
            Self::Plunge => "the plunge beside the station's switch",
        })
    }
}

/// Step that leaves the wheel where it is while another axis moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IdleWheelStep {
    Home,
    RapidRetract,
}

impl core::fmt::Display for IdleWheelStep {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Home => "home.x_mm",
            Self::RapidRetract => "the rapid retract",
        })
    }
}
