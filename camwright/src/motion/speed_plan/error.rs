// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why there is no speed plan, in sentences.

use super::{LimitUse, LimitedQuantity, TurnError, cam_angle_deg, figures};
use crate::machine::description::Axis;
use crate::math::units::TURN_RAD;
use crate::motion::point_to_point::PointToPointError;
use alloc::string::String;
use thiserror::Error;

/// Why there is no speed plan.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SpeedPlanError {
    /// An axis would exceed a limit at the speed wanted.
    #[error("{}; {}", too_fast(*.work_speed_rad_s, worst), largest(*.largest_rad_s))]
    TooFast {
        work_speed_rad_s: f64,
        /// The limit exceeded most.
        worst: LimitUse,
        /// The largest speed that fits, rounded down; `None` if a thousandth of the wanted one does not.
        largest_rad_s: Option<f64>,
    },
    /// The ramps take more than the turns there are.
    #[error(
        "reaching {} rad/s ({} rpm) and coming to rest again takes {ramps_deg:.1} deg; the cut has {turns} turns and one \
         is kept for the plateau; {}",
        figures(*.work_speed_rad_s), rpm(*.work_speed_rad_s), largest(*.largest_rad_s)
    )]
    NoPlateau {
        work_speed_rad_s: f64,
        /// Angle of both ramps.
        ramps_deg: f64,
        /// Turns of the cut.
        turns: u32,
        /// The largest speed that fits, rounded down; `None` if a thousandth of the wanted one does not.
        largest_rad_s: Option<f64>,
    },
    /// The wheel has not the power for the speed wanted.
    #[error(
        "at a work speed of {} rad/s ({} rpm) the wheel needs more than its power at cam angle {angle_deg:.1} deg, where that \
         allows {} rad/s; {}",
        figures(*.work_speed_rad_s), rpm(*.work_speed_rad_s), figures(*.allowed_rad_s), largest(*.largest_rad_s)
    )]
    WheelPower {
        work_speed_rad_s: f64,
        /// Angle of the lowest power bound (deg).
        angle_deg: f64,
        /// Allowed speed there.
        allowed_rad_s: f64,
        /// The largest speed that fits, rounded down; `None` if a thousandth of the wanted one does not.
        largest_rad_s: Option<f64>,
    },
    /// The cut takes longer than any should.
    #[error(
        "the cut of {turns} turns takes {} h, the maximum is {} h: use a higher work speed or fewer turns",
        figures(*.duration_s / 3600.0), figures(*.max_s / 3600.0)
    )]
    TooLong {
        /// Turns of the cut.
        turns: u32,
        /// Time it takes (s).
        duration_s: f64,
        /// Most allowed (s).
        max_s: f64,
    },
    /// A varying speed over so many turns is more than a plan holds.
    #[error(
        "the speed of {turns} turns has {knots:.0} knots, at most {max:.0} are allowed: use fewer turns or a constant work speed"
    )]
    TooManyKnots {
        /// Turns of the cut.
        turns: u32,
        /// Knots of its law.
        knots: f64,
        max: f64,
    },
    /// No stop on the path within ten seconds keeps the limits.
    #[error("no stop of up to {longest_s} s on the path keeps the limits of the axes")]
    NoStop { longest_s: f64 },
    /// The forward check found an exceeded limit: a defect of the planner, reported before anything moves.
    #[error("the speed plan failed its forward check: {0}")]
    Check(LimitUse),
    /// There is no turn under the law.
    #[error(transparent)]
    Turn(TurnError),
    /// From where the cut starts no run-up reaches the speed of the turn.
    #[error("no run-up of C within a turn from cam angle {start_deg:.1} deg keeps the limits of both axes")]
    NoRunUp {
        /// Start and end of the cut (deg).
        start_deg: f64,
    },
    /// X finds no way onto the moving path, or off it.
    #[error(
        "with C turning at {} rad/s X finds no approach from its rest position {clear_x_mm} mm to the path; with C stopped it needs none",
        figures(*.speed_rad_s)
    )]
    NoLead {
        speed_rad_s: f64,
        /// Rest position of X (mm).
        clear_x_mm: f64,
    },
    /// There is no ramp to the speed wanted.
    #[error("no run-up: {0}")]
    Ramp(#[from] PointToPointError),
}

fn rpm(rad_s: f64) -> String {
    figures(rad_s * 60.0 / TURN_RAD)
}

/// The limit that a speed exceeds, and the speed that it allows.
fn too_fast(work_speed_rad_s: f64, worst: &LimitUse) -> String {
    let (speed, in_rpm) = (figures(work_speed_rad_s), rpm(work_speed_rad_s));
    let (axis, quantity) = (worst.axis, worst.quantity);
    let is_speed_of_c = (axis, quantity) == (Axis::C, LimitedQuantity::Velocity);
    let allowed_rad_s = if is_speed_of_c { worst.allowed } else { work_speed_rad_s / worst.speed_ratio() };
    let (limit, limit_rpm) = (figures(allowed_rad_s), rpm(allowed_rad_s));
    let exceeds =
        alloc::format!("the work speed of {in_rpm} rpm ({speed} rad/s) exceeds {limit_rpm} rpm ({limit} rad/s)");
    if is_speed_of_c {
        return exceeds + ", the limit of c_axis";
    }
    exceeds
        + &alloc::format!(
            ", the speed at which {} reaches a {} of {} {} at cam angle {:.1} deg{}",
            axis.joint(),
            quantity.name(),
            figures(worst.allowed),
            quantity.unit(axis),
            cam_angle_deg(worst.angle_rad),
            reserve(quantity)
        )
}

fn reserve(quantity: LimitedQuantity) -> &'static str {
    match quantity {
        LimitedQuantity::Velocity => ", its limit",
        LimitedQuantity::Acceleration | LimitedQuantity::Jerk => ", its limit less 5 % for a stop on the path",
    }
}

fn largest(rad_s: Option<f64>) -> String {
    match rad_s {
        // Rounded down once more after the change of unit, so that whichever of the two is typed in fits.
        Some(w) => alloc::format!(
            "the largest work speed that fits is {} rad/s ({} rpm)",
            figures(w),
            figures(round_down(w * 60.0 / TURN_RAD))
        ),
        None => String::from("not even a thousandth of it fits"),
    }
}

/// Rounded down to four significant digits.
pub(super) fn round_down(value: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(value)) - 3.0);
    libm::floor(value / unit) * unit
}
