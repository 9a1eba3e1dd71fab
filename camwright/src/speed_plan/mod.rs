//! The speed plan: how fast C turns at every moment of a cut, so that both axes keep their limits.
//!
//! ```text
//!  Ċ    ________________________      run-up and run-down: constant-jerk phases, exact cubics in time
//!      /|                      |\     plateau: periodic over a turn, so that whole turns may be put in
//!     / |                      | \    the whole: a whole number of turns, to the bit
//! ___/  |                      |  \___
//! ```
//!
//! Limits hold along the path with its infeed, ramps included, by the chain rule: Ẋ = X'Ċ, Ẍ = X''Ċ² + X'C̈,
//! X⃛ = X'''Ċ³ + 3X''ĊC̈ + X'C⃛. A plan is checked by differencing positions on an eight times finer grid before it
//! leaves here; one that fails is an error.

mod bound_use;
mod envelope;
mod limit_use;
mod peaks;
mod process;
mod run_up;
mod square_speed;
mod stop;
mod table;
mod time_optimal;
mod turn_request;
mod turn_speed;
mod variable;

pub use bound_use::{ACTIVE_SHARE, Bound, TurnBounds};
pub use limit_use::{LimitUse, Quantity, uses_by_differences};
pub(crate) use limit_use::{figures, windows};
pub use process::{Cutting, footprint_speed_ratio_mm, largest_speed_rad_s};
pub use turn_request::{TurnError, TurnRequest};
pub use turn_speed::{TurnPoint, TurnSpeed};

use crate::cut_motion::CutMotion;
use crate::infeed::{BLEND_SHARE, InfeedLaw, InfeedSchedule};
use crate::job::{InfeedDirection, SpeedLaw};
use crate::machine::description::MotionLimits;
use crate::numeric::hermite::{HermiteSpline, Knot};
use crate::numeric::periodic_spline::PeriodicSpline;
use crate::point_to_point::{PointToPointError, velocity_ramp};
use crate::units::{TURN_RAD, deg_from_rad, wrap_turn};
use alloc::string::String;
use alloc::vec::Vec;
use limit_use::uses_by_chain_rule;
use thiserror::Error;
use variable::variable_speed;

/// Share of acceleration and jerk limits a speed plan may use. A stop on the path adds to both while it slows down, the
/// more the shorter it is; with nothing in reserve it could not begin at all where the path is at a limit. 0.95 costs
/// under 2 % of speed where jerk limits (cube root), and keeps a stop well under a second on ordinary paths.
pub const PATH_SHARE: f64 = 0.95;

/// Share of X's acceleration and jerk limits that a turn of varying speed may use: the end of the infeed takes its own.
const VARYING_X_SHARE: f64 = PATH_SHARE - BLEND_SHARE;

/// Shares of C's acceleration and jerk limit that the ramps try, first to last. Ramps take a hundredth of a cut, so half
/// the limits costs nothing and leaves room for a short stop; smaller ones are for starts on a flank, where X follows.
const RAMP_SHARES: [f64; 6] = [0.5, 0.25, 0.125, 0.0625, 0.031_25, 0.015_625];

/// Grid points per turn while planning, at least; the check takes eight times as many.
const PLANNING_GRID: usize = 3600;

/// How much finer the forward check looks than the planning did.
const CHECK_FACTOR: f64 = 8.0;

/// Shortest step of the forward check (s): below it the digits of a position no longer carry a jerk.
const SHORTEST_CHECK_STEP_S: f64 = 5e-6;

/// What a speed plan is made for.
#[derive(Debug, Clone, Copy)]
pub struct SpeedRequest<'a> {
    /// `x_axis` position over the path angle (mm over rad).
    pub path: &'a PeriodicSpline,
    /// Path angle at the start (rad).
    pub path_start_rad: f64,
    /// Infeed of the pass.
    pub infeed: &'a InfeedSchedule,
    /// Along what the infeed is measured.
    pub infeed_direction: InfeedDirection,
    /// Way of X per depth along the normal, over the path angle, where the infeed is measured so.
    pub ratio: Option<&'a PeriodicSpline>,
    /// Turns without infeed after it.
    pub spark_out_turns: u32,
    /// Speed wanted.
    pub speed: SpeedLaw,
    /// What the wheel's power allows on this lobe, as a law; every other law keeps it too.
    pub wheel_power: Option<SpeedLaw>,
    /// σ of the machine: the path angle is σ times the cam angle, which is what people are told.
    pub rotation_sense: i8,
    /// Radius of the wheel (mm).
    pub wheel_radius_mm: f64,
    /// Speed of its surface (m/s).
    pub wheel_speed_m_s: f64,
    /// Limits of C.
    pub c: MotionLimits,
    /// Limits of X.
    pub x: MotionLimits,
    /// Interpolation period (s).
    pub cycle_time_s: f64,
}

/// C over time for one cut, and what it does to the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedPlan {
    law: HermiteSpline,
    infeed: InfeedLaw,
    turns: u32,
    plateau_s: (f64, f64),
    turn_s: f64,
    speed_range_rad_s: (f64, f64),
    least_turn_s: Option<f64>,
    uses: Vec<LimitUse>,
    stop_ticks: u64,
}

/// Why there is no speed plan.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SpeedPlanError {
    /// An axis would exceed a limit at the speed wanted.
    #[error(
        "at a work speed of {} rad/s ({} rpm) {worst}{}; {}",
        figures(*.work_speed_rad_s), rpm(*.work_speed_rad_s), reserve(*.worst), largest(*.largest_rad_s)
    )]
    TooFast {
        /// Speed wanted.
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
        /// Speed wanted.
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
        /// Speed wanted.
        work_speed_rad_s: f64,
        /// Where the power allows least (deg).
        angle_deg: f64,
        /// What it allows there.
        allowed_rad_s: f64,
        /// The largest speed that fits, rounded down; `None` if a thousandth of the wanted one does not.
        largest_rad_s: Option<f64>,
    },
    /// No stop on the path within ten seconds keeps the limits.
    #[error("no stop of up to {longest_s} s on the path keeps the limits of the axes")]
    NoStop {
        /// Longest stop tried.
        longest_s: f64,
    },
    /// The forward check found a limit exceeded: a defect of the planner, told rather than driven.
    #[error("the speed plan failed its forward check: {0}")]
    Check(LimitUse),
    /// There is no turn under the law.
    #[error(transparent)]
    Turn(TurnError),
    /// From where the cut starts no run-up reaches the speed of the turn.
    #[error("no run-up of C within a turn from cam angle {start_deg:.1} deg keeps the limits of both axes")]
    NoRunUp {
        /// Where the cut starts and ends (deg).
        start_deg: f64,
    },
    /// There is no ramp to the speed wanted.
    #[error("no run-up: {0}")]
    Ramp(#[from] PointToPointError),
}

fn rpm(rad_s: f64) -> String {
    figures(rad_s * 60.0 / TURN_RAD)
}

fn reserve(worst: LimitUse) -> &'static str {
    match worst.quantity {
        Quantity::Velocity => "",
        Quantity::Acceleration | Quantity::Jerk => " (5 % of the axis limit is kept for a stop on the path)",
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
fn round_down(value: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(value)) - 3.0);
    libm::floor(value / unit) * unit
}

/// A law for one speed, before it is proven.
struct Candidate {
    law: HermiteSpline,
    infeed: InfeedLaw,
    plateau_s: (f64, f64),
    turn_s: f64,
    uses: Vec<LimitUse>,
}

enum Misfit {
    Limit(LimitUse),
    /// What the wheel's power allows (rad/s), and the path angle where it is least.
    Power(f64, f64),
    NoPlateau(f64),
    Ramp(PointToPointError),
    Turn(TurnError),
    NoRunUp,
}

impl SpeedPlan {
    /// The plan for a pass: the speed wanted, or a refusal that names the largest one that fits.
    ///
    /// # Errors
    /// A limit exceeded at the speed wanted, ramps longer than the cut, no stop, a failed forward check.
    pub fn new(request: &SpeedRequest<'_>) -> Result<Self, SpeedPlanError> {
        let (candidate, speed_range_rad_s, least_turn_s) = match request.speed {
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: speed } => {
                let candidate = constant_speed(request, speed).map_err(|misfit| request.refusal(speed, misfit))?;
                (candidate, (speed, speed), None)
            }
            SpeedLaw::ConstantFootprintSpeed { .. }
            | SpeedLaw::ConstantRemovalRate { .. }
            | SpeedLaw::ConstantPower { .. }
            | SpeedLaw::ConstantTemperature { .. }
            | SpeedLaw::TimeOptimal { .. } => {
                let (candidate, turn) =
                    variable_speed(request).map_err(|misfit| request.refusal(request.c.velocity, misfit))?;
                (candidate, turn.range_rad_s(), Some(turn.least_s()))
            }
        };
        let motion = request.motion(&candidate);
        let stretches = windows(&motion, candidate.plateau_s, candidate.turn_s, candidate.infeed.last_blend_rad());
        let step = (request.step(candidate.turn_s) / CHECK_FACTOR).max(SHORTEST_CHECK_STEP_S);
        let found = uses_by_differences(&motion, &stretches, step, &request.c, &request.x);
        if let Some(exceeded) = request.seen_from_lobe(found).into_iter().find(|found| found.ratio() > 1.0) {
            return Err(SpeedPlanError::Check(exceeded));
        }
        let limits = [&request.c, &request.x];
        let stop_ticks = stop::shortest(&motion, &stretches, candidate.turn_s, request.cycle_time_s, limits)
            .ok_or(SpeedPlanError::NoStop { longest_s: stop::LONGEST_S })?;
        Ok(Self {
            turns: request.turns(),
            speed_range_rad_s,
            least_turn_s,
            law: candidate.law,
            infeed: candidate.infeed,
            plateau_s: candidate.plateau_s,
            turn_s: candidate.turn_s,
            uses: candidate.uses,
            stop_ticks,
        })
    }

    /// Angle of C since the start over time (rad over s), at rest at both ends.
    #[must_use]
    pub const fn law(&self) -> &HermiteSpline {
        &self.law
    }

    /// The infeed law that goes with it: its blend depends on the speed.
    #[must_use]
    pub const fn infeed(&self) -> &InfeedLaw {
        &self.infeed
    }

    /// Turns of C, spark-out included.
    #[must_use]
    pub const fn turns(&self) -> u32 {
        self.turns
    }

    /// Where the plateau begins and ends (s).
    #[must_use]
    pub const fn plateau_s(&self) -> (f64, f64) {
        self.plateau_s
    }

    /// Time of one turn within the plateau (s).
    #[must_use]
    pub const fn turn_s(&self) -> f64 {
        self.turn_s
    }

    /// Slowest and fastest C on the plateau (rad/s).
    #[must_use]
    pub const fn speed_range_rad_s(&self) -> (f64, f64) {
        self.speed_range_rad_s
    }

    /// A time below which no turn under the law can be (s), where the law lets the speed vary.
    #[must_use]
    pub const fn least_turn_s(&self) -> Option<f64> {
        self.least_turn_s
    }

    /// How far each limit is used, and where: velocity, acceleration and jerk of C and of X.
    #[must_use]
    pub fn uses(&self) -> &[LimitUse] {
        &self.uses
    }

    /// The limit used most.
    #[must_use]
    pub fn tightest(&self) -> Option<&LimitUse> {
        self.uses.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()))
    }

    /// Length of a stop on the path that keeps every limit wherever it begins, and over which every smaller change of rate,
    /// down or up, keeps them too (ticks).
    #[must_use]
    pub const fn stop_ticks(&self) -> u64 {
        self.stop_ticks
    }
}

impl<'a> SpeedRequest<'a> {
    fn turns(&self) -> u32 {
        self.infeed.turns() + self.spark_out_turns
    }

    /// Step in time of the planning grid (s).
    fn step(&self, turn_s: f64) -> f64 {
        // Two points in each interval of the path: its third derivative is a parabola there.
        #[allow(clippy::cast_precision_loss, reason = "a few thousand points")]
        let points = PLANNING_GRID.max(2 * self.path.coefficients().len()) as f64;
        turn_s / points
    }

    fn motion<'b>(&self, candidate: &'b Candidate) -> CutMotion<'b>
    where
        'a: 'b,
    {
        CutMotion {
            path: self.path,
            path_start_rad: self.path_start_rad,
            infeed: candidate.infeed.law(),
            ratio: self.ratio,
            law: &candidate.law,
        }
    }

    /// Path angles become cam angles.
    fn seen_from_lobe(&self, mut uses: Vec<LimitUse>) -> Vec<LimitUse> {
        for found in &mut uses {
            found.angle_rad *= f64::from(self.rotation_sense.signum());
        }
        uses
    }

    fn refusal(&self, work_speed_rad_s: f64, misfit: Misfit) -> SpeedPlanError {
        let largest = || match self.speed {
            SpeedLaw::ConstantWorkSpeed { .. } => largest_speed(self, work_speed_rad_s),
            _ => None,
        };
        match misfit {
            Misfit::Limit(worst) => SpeedPlanError::TooFast { work_speed_rad_s, worst, largest_rad_s: largest() },
            Misfit::Power(allowed_rad_s, angle_rad) => SpeedPlanError::WheelPower {
                work_speed_rad_s,
                angle_deg: cam_angle_deg(f64::from(self.rotation_sense.signum()) * angle_rad),
                allowed_rad_s,
                largest_rad_s: largest(),
            },
            Misfit::NoPlateau(ramps_rad) => SpeedPlanError::NoPlateau {
                work_speed_rad_s,
                ramps_deg: deg_from_rad(ramps_rad),
                turns: self.turns(),
                largest_rad_s: largest(),
            },
            Misfit::Ramp(error) => error.into(),
            Misfit::Turn(error) => SpeedPlanError::Turn(error),
            Misfit::NoRunUp => SpeedPlanError::NoRunUp {
                start_deg: cam_angle_deg(f64::from(self.rotation_sense.signum()) * self.path_start_rad),
            },
        }
    }

    /// The infeed at a largest speed: its steps lie on the base circle, path angle 0.
    fn infeed_for(&self, speed_rad_s: f64) -> InfeedLaw {
        self.infeed.law_for(speed_rad_s, self.x, wrap_turn(-self.path_start_rad))
    }
}

/// The law of one constant speed with the shortest ramps that fit.
fn constant_speed(request: &SpeedRequest<'_>, speed: f64) -> Result<Candidate, Misfit> {
    if let Some((allowed, angle)) = request.least_by_power().filter(|(allowed, _)| *allowed < speed) {
        return Err(Misfit::Power(allowed, angle));
    }
    let infeed = request.infeed_for(speed);
    let total = f64::from(request.turns()) * TURN_RAD;
    let mut misfit = None;
    for share in RAMP_SHARES {
        let limits = MotionLimits { velocity: request.c.velocity.max(speed), ..request.c.with_share(share) };
        let ramp = velocity_ramp(0.0, speed, &limits).map_err(Misfit::Ramp)?;
        let ramp_rad = ramp.knots()[ramp.knots().len() - 1].value;
        // Less than a turn of plateau could not be previewed, nor a turn put in.
        if 2.0 * ramp_rad > total - TURN_RAD {
            return Err(misfit.unwrap_or(Misfit::NoPlateau(2.0 * ramp_rad)));
        }
        let (law, plateau_s) = mirrored(&ramp, speed, total);
        let candidate =
            Candidate { law, infeed: infeed.clone(), plateau_s, turn_s: TURN_RAD / speed, uses: Vec::new() };
        let motion = request.motion(&candidate);
        let uses = request.seen_from_lobe(uses_by_chain_rule(
            &motion,
            &windows(&motion, plateau_s, candidate.turn_s, candidate.infeed.last_blend_rad()),
            request.step(candidate.turn_s),
            &request.c,
            &request.x,
        ));
        let worst = uses.iter().copied().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        match worst {
            Some(worst) if worst.ratio() > 1.0 => {
                let on_plateau = worst.time_s >= plateau_s.0 && worst.time_s <= plateau_s.1;
                if on_plateau {
                    return Err(Misfit::Limit(worst));
                }
                misfit = Some(Misfit::Limit(worst));
            }
            _ => return Ok(Candidate { uses, ..candidate }),
        }
    }
    Err(misfit.unwrap_or(Misfit::NoPlateau(0.0)))
}

/// Run-up, plateau, and the run-up mirrored as run-down, over `total` rad exactly.
fn mirrored(ramp: &HermiteSpline, speed: f64, total: f64) -> (HermiteSpline, (f64, f64)) {
    let (ramp_s, ramp_rad) = (ramp.end(), ramp.knots()[ramp.knots().len() - 1].value);
    let begin = ramp_s;
    let end = begin + (total - 2.0 * ramp_rad) / speed;
    let mut knots: Vec<Knot> = ramp.knots().to_vec();
    knots.extend(ramp.knots().iter().rev().map(|knot| Knot {
        at: end + (ramp_s - knot.at),
        value: total - knot.value,
        first: knot.first,
        second: -knot.second,
    }));
    let law = HermiteSpline::new(knots).expect("the plateau is at least a turn long and the ramp's knots increase");
    (law, (begin, end))
}

/// The largest speed below `speed` that fits, rounded down to four digits.
fn largest_speed(request: &SpeedRequest<'_>, speed: f64) -> Option<f64> {
    let fits = |speed: f64| constant_speed(request, speed).is_ok();
    let mut low = speed;
    let mut high = speed;
    while !fits(low) {
        high = low;
        low *= 0.5;
        if low < 1e-3 * speed {
            return None;
        }
    }
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        if fits(middle) { low = middle } else { high = middle }
    }
    Some(round_down(low))
}

/// Where on the lobe a path angle is, for people: degrees in 0..360.
fn cam_angle_deg(angle_rad: f64) -> f64 {
    deg_from_rad(wrap_turn(angle_rad))
}

#[cfg(test)]
mod tests;
