// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
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
mod error;
mod fixed_path;
mod in_time;
mod lead;
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
pub use error::SpeedPlanError;
use error::round_down;
pub(crate) use fixed_path::{FixedPathRequest, FixedPathSpeed};
pub use lead::{FlyingStart, LEAD_PATH_SHARE, largest_lead_speed_rad_s, shortest_lead_s};
pub use limit_use::{LimitUse, LimitedQuantity, uses_by_differences};
pub(crate) use limit_use::{figures, windows};
pub use process::{Cutting, largest_speed_rad_s};
pub use turn_request::{TurnError, TurnRequest};
pub use turn_speed::{TurnPoint, TurnSpeed};

use crate::job::grinding::{InfeedDirection, SpeedLaw};
use crate::job::infeed::{BLEND_SHARE, InfeedLaw, InfeedSchedule};
use crate::machine::description::{Axis, MotionLimits};
use crate::math::hermite::{HermiteSpline, Knot, Sample};
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use crate::motion::cut_motion::CutMotion;
use crate::motion::point_to_point::{PointToPointError, velocity_ramp};
use alloc::vec::Vec;
use lead::{ON_PATH, lead_in};
use limit_use::uses_by_chain_rule;
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

/// Refinement of the forward check's grid against the planning grid.
const CHECK_FACTOR: f64 = 8.0;

/// Longest cut (s), a day, and most knots of its law: beyond them a mistyped speed is likelier than a wish.
const MAX_CUT_S: f64 = 86_400.0;
const MAX_LAW_KNOTS: f64 = 2e6;

/// Excess of a velocity over its limit that may appear because the knots of the plan are floats, relative: then it is planned again,
/// slower by that.
const VELOCITY_ROUNDING: f64 = 1e-6;

/// Shortest step of the forward check (s): below it the digits of a position no longer carry a jerk.
const SHORTEST_CHECK_STEP_S: f64 = 5e-6;

/// Input of a speed plan.
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
    /// The wheel leaves the part at the end of the last turn, while it still turns.
    pub leaves_turning: bool,
    pub speed: SpeedLaw,
    /// Arrival of C at the cut if it turns; otherwise it starts from rest.
    pub comes: Option<FlyingStart>,
    /// Continuation of C after the cut if it turns; otherwise it stops.
    pub goes: Option<FlyingStart>,
    /// Bound of the wheel's power on this lobe, as a law; every other law keeps it too.
    pub wheel_power: Option<SpeedLaw>,
    /// σ of the machine: the path angle is σ times the cam angle, which reports show.
    pub rotation_sense: i8,
    /// Radius of the wheel (mm).
    pub wheel_radius_mm: f64,
    /// Speed of its surface (m/s).
    pub wheel_speed_m_s: f64,
    pub c: MotionLimits,
    pub x: MotionLimits,
    /// Interpolation period (s).
    pub cycle_time_s: f64,
}

/// C over time for one cut, and what it does to the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedPlan {
    law: HermiteSpline,
    infeed: InfeedLaw,
    lead: Option<HermiteSpline>,
    turns: u32,
    plateau_s: (f64, f64),
    turn_s: f64,
    speed_range_rad_s: (f64, f64),
    least_turn_s: Option<f64>,
    uses: Vec<LimitUse>,
    stop_ticks: u64,
}

/// A law for one speed, before it is proven.
struct Candidate {
    law: HermiteSpline,
    infeed: InfeedLaw,
    lead: Option<HermiteSpline>,
    plateau_s: (f64, f64),
    turn_s: f64,
    uses: Vec<LimitUse>,
}

enum LimitViolation {
    Limit(LimitUse),
    /// Speed allowed by the wheel's power (rad/s), and the path angle of its minimum.
    Power(f64, f64),
    NoPlateau(f64),
    /// Time of the whole cut (s).
    TooLong(f64),
    /// Knots of the law.
    TooManyKnots(f64),
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
        match Self::within(request, &request.c, &request.x) {
            // It sits on the limit of a velocity, and the plan's own numbers round to above it.
            Err(SpeedPlanError::Check(found))
                if found.quantity == LimitedQuantity::Velocity && found.ratio() <= 1.0 + VELOCITY_ROUNDING =>
            {
                Self::within(&request.slower(found.ratio() * (1.0 + 1e-9)), &request.c, &request.x)
            }
            outcome => outcome,
        }
    }

    /// The plan for a pass, checked against limits that may be wider than those of the request.
    fn within(request: &SpeedRequest<'_>, c: &MotionLimits, x: &MotionLimits) -> Result<Self, SpeedPlanError> {
        let (candidate, speed_range_rad_s, least_turn_s) = match request.speed {
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: speed } => {
                let candidate = constant_speed(request, speed).map_err(|misfit| request.refusal(speed, misfit))?;
                (candidate, (speed, speed), None)
            }
            SpeedLaw::ConstantFootprintSpeed { .. }
            | SpeedLaw::ConstantRemovalRate { .. }
            | SpeedLaw::ConstantRadialRemovalRate { .. }
            | SpeedLaw::ConstantPower { .. }
            | SpeedLaw::ConstantTemperature { .. }
            | SpeedLaw::TimeOptimal { .. } => {
                let (candidate, turn) =
                    variable_speed(request).map_err(|misfit| request.refusal(request.c.velocity, misfit))?;
                (candidate, turn.range_rad_s(), Some(turn.minimum_s()))
            }
        };
        let candidate = request.led(candidate)?;
        let motion = request.motion(&candidate);
        let stretches = windows(&motion, candidate.plateau_s, candidate.turn_s, candidate.infeed.varies_rad());
        let step = request.check_step(candidate.turn_s);
        let found = uses_by_differences(&motion, &stretches, step, c, x);
        if let Some(exceeded) = request.seen_from_lobe(found).into_iter().find(|found| found.ratio() > 1.0) {
            return Err(SpeedPlanError::Check(exceeded));
        }
        let limits = [c, x];
        let stop_ticks = stop::shortest(&motion, &stretches, candidate.turn_s, request.cycle_time_s, limits)
            .ok_or(SpeedPlanError::NoStop { longest_s: stop::LONGEST_S })?;
        Ok(Self {
            turns: request.turns(),
            speed_range_rad_s,
            least_turn_s,
            law: candidate.law,
            infeed: candidate.infeed,
            lead: candidate.lead,
            plateau_s: candidate.plateau_s,
            turn_s: candidate.turn_s,
            uses: candidate.uses,
            stop_ticks,
        })
    }

    /// Angle of C since the cut begins over time (rad over s), from rest to rest or from turning to turning.
    #[must_use]
    pub const fn law(&self) -> &HermiteSpline {
        &self.law
    }

    /// Distance of X from path and infeed over time where C comes or goes turning (mm over s).
    #[must_use]
    pub const fn lead(&self) -> Option<&HermiteSpline> {
        self.lead.as_ref()
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

    /// Start and end of the plateau (s).
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

    /// Speed of C in a turn at the programmed speed where the angle since the cut began is as given, whole turns apart (rad/s).
    #[must_use]
    pub fn speed_in_turn_rad_s(&self, angle_rad: f64) -> f64 {
        let begins_rad = self.law.sample(self.plateau_s.0).value;
        self.law.sample(self.law.place_of(begins_rad + wrap_turn(angle_rad - begins_rad))).first
    }

    /// A time below which no turn under the law can be (s), where the law lets the speed vary.
    #[must_use]
    pub const fn minimum_turn_s(&self) -> Option<f64> {
        self.least_turn_s
    }

    /// Utilisation of each limit, and its position: velocity, acceleration and jerk of C and of X.
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
    /// The same at velocities lower by a factor.
    fn slower(&self, factor: f64) -> Self {
        let slower = |limits: MotionLimits| MotionLimits { velocity: limits.velocity / factor, ..limits };
        let speed = match self.speed {
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s } => {
                SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: work_speed_rad_s / factor }
            }
            other => other,
        };
        Self { speed, c: slower(self.c), x: slower(self.x), ..*self }
    }

    fn turns(&self) -> u32 {
        self.infeed.turns() + self.spark_out_turns
    }

    /// Step in time of the planning grid (s).
    fn step(&self, turn_s: f64) -> f64 {
        // Two points in each interval of the path: its third derivative is a parabola there.
        let points = PLANNING_GRID.max(2 * self.path.coefficients().len()) as f64;
        turn_s / points
    }

    /// Step in time of the check by differences (s).
    fn check_step(&self, turn_s: f64) -> f64 {
        (self.step(turn_s) / CHECK_FACTOR).max(SHORTEST_CHECK_STEP_S)
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
            lead: candidate.lead.as_ref(),
            law: &candidate.law,
        }
    }

    /// Speeds of C at the ends of the cut (rad/s), 0 for rest.
    fn end_speeds_rad_s(&self) -> (f64, f64) {
        let speed = |turning: Option<FlyingStart>| turning.map_or(0.0, |turning| turning.speed_rad_s);
        (speed(self.comes), speed(self.goes))
    }

    /// A cut with the ways of X onto it and off it where C turns on.
    fn led(&self, candidate: Candidate) -> Result<Candidate, SpeedPlanError> {
        if self.comes.is_none() && self.goes.is_none() {
            return Ok(candidate);
        }
        let no_lead = |turning: &FlyingStart| SpeedPlanError::NoLead {
            speed_rad_s: turning.speed_rad_s,
            clear_x_mm: turning.clear_x_mm,
        };
        let total_rad = f64::from(self.turns()) * TURN_RAD;
        let motion = self.motion(&candidate);
        let end_s = motion.end_s();
        let mut law = candidate.law.knots().to_vec();
        let mut lead = alloc::vec![ON_PATH, Knot { at: end_s, ..ON_PATH }];
        if let Some(turning) = &self.comes {
            let limits = lead::beside(self.path, &self.x, turning).ok_or_else(|| no_lead(turning))?;
            let way = lead_in(turning, &limits, |angle| motion.over_angle(angle)).ok_or_else(|| no_lead(turning))?;
            let (at, w) = (way[0].at, turning.speed_rad_s);
            law.insert(0, Knot { at, value: w * at, first: w, second: 0.0 });
            lead.splice(0..1, way);
        }
        if let Some(turning) = &self.goes {
            let limits = lead::beside(self.path, &self.x, turning).ok_or_else(|| no_lead(turning))?;
            let backwards = |angle: f64| {
                let x = motion.over_angle(total_rad - angle);
                Sample { first: -x.first, third: -x.third, ..x }
            };
            let way = lead_in(turning, &limits, backwards).ok_or_else(|| no_lead(turning))?;
            let (at, w) = (end_s - way[0].at, turning.speed_rad_s);
            law.push(Knot { at, value: total_rad + w * (at - end_s), first: w, second: 0.0 });
            let out = way.iter().rev().skip(1);
            lead.extend(out.map(|knot| Knot { at: end_s - knot.at, first: -knot.first, ..*knot }));
        }
        let total_s = end_s;
        let spline = |knots| HermiteSpline::new(knots).map_err(|_| self.refusal(0.0, LimitViolation::TooLong(total_s)));
        let (law, lead) = (spline(law)?, Some(spline(lead)?));
        Ok(Candidate { law, lead, ..candidate })
    }

    /// Path angles become cam angles.
    fn seen_from_lobe(&self, mut uses: Vec<LimitUse>) -> Vec<LimitUse> {
        for found in &mut uses {
            found.angle_rad *= f64::from(self.rotation_sense.signum());
        }
        uses
    }

    fn refusal(&self, work_speed_rad_s: f64, misfit: LimitViolation) -> SpeedPlanError {
        let largest = || match self.speed {
            SpeedLaw::ConstantWorkSpeed { .. } => largest_speed(self, work_speed_rad_s),
            _ => None,
        };
        match misfit {
            LimitViolation::Limit(worst) => {
                SpeedPlanError::TooFast { work_speed_rad_s, worst, largest_rad_s: largest() }
            }
            LimitViolation::Power(allowed_rad_s, angle_rad) => SpeedPlanError::WheelPower {
                work_speed_rad_s,
                angle_deg: cam_angle_deg(f64::from(self.rotation_sense.signum()) * angle_rad),
                allowed_rad_s,
                largest_rad_s: largest(),
            },
            LimitViolation::NoPlateau(ramps_rad) => SpeedPlanError::NoPlateau {
                work_speed_rad_s,
                ramps_deg: deg_from_rad(ramps_rad),
                turns: self.turns(),
                largest_rad_s: largest(),
            },
            LimitViolation::TooLong(duration_s) => {
                SpeedPlanError::TooLong { turns: self.turns(), duration_s, max_s: MAX_CUT_S }
            }
            LimitViolation::TooManyKnots(knots) => {
                SpeedPlanError::TooManyKnots { turns: self.turns(), knots, max: MAX_LAW_KNOTS }
            }
            LimitViolation::Ramp(error) => error.into(),
            LimitViolation::Turn(error) => SpeedPlanError::Turn(error),
            LimitViolation::NoRunUp => SpeedPlanError::NoRunUp {
                start_deg: cam_angle_deg(f64::from(self.rotation_sense.signum()) * self.path_start_rad),
            },
        }
    }

    /// The infeed at a largest speed: its steps lie on the base circle, path angle 0.
    fn infeed_for(&self, speed_rad_s: f64) -> InfeedLaw {
        let law = self.infeed.law_for(speed_rad_s, self.x, wrap_turn(-self.path_start_rad));
        let law = if self.comes.is_some() { law.begun_at_speed() } else { law };
        if self.leaves_turning { law.left_turning(f64::from(self.turns()) * TURN_RAD) } else { law }
    }
}

/// The law of one constant speed with the shortest ramps that fit.
fn constant_speed(request: &SpeedRequest<'_>, speed: f64) -> Result<Candidate, LimitViolation> {
    // Beyond the limit of C every other figure is absurd: the jerk of X grows with the cube of the speed.
    if speed > request.c.velocity {
        let (axis, quantity) = (Axis::C, LimitedQuantity::Velocity);
        let (value, allowed, angle_rad) = (speed, request.c.velocity, request.path_start_rad);
        return Err(LimitViolation::Limit(LimitUse { axis, quantity, value, allowed, angle_rad, time_s: 0.0 }));
    }
    if let Some((allowed, angle)) = request.minimum_by_power().filter(|(allowed, _)| *allowed < speed) {
        return Err(LimitViolation::Power(allowed, angle));
    }
    let infeed = request.infeed_for(speed);
    let (comes_rad_s, goes_rad_s) = request.end_speeds_rad_s();
    let total = f64::from(request.turns()) * TURN_RAD;
    if total > MAX_CUT_S * speed {
        return Err(LimitViolation::TooLong(total / speed));
    }
    let mut misfit = None;
    for share in RAMP_SHARES {
        let limits = MotionLimits { velocity: request.c.velocity.max(speed), ..request.c.with_share(share) };
        let ramps = (ramp(comes_rad_s, speed, &limits)?, ramp(goes_rad_s, speed, &limits)?);
        let ramps_rad = ramps.0[ramps.0.len() - 1].value + ramps.1[ramps.1.len() - 1].value;
        // Less than a turn of plateau could not be previewed, nor a turn put in.
        if ramps_rad > total - TURN_RAD {
            return Err(misfit.unwrap_or(LimitViolation::NoPlateau(ramps_rad)));
        }
        let (law, plateau_s) = between(&ramps.0, &ramps.1, speed, total)?;
        let (infeed, turn_s) = (infeed.clone(), TURN_RAD / speed);
        let candidate = Candidate { law, infeed, lead: None, plateau_s, turn_s, uses: Vec::new() };
        let motion = request.motion(&candidate);
        let uses = request.seen_from_lobe(uses_by_chain_rule(
            &motion,
            &windows(&motion, plateau_s, candidate.turn_s, candidate.infeed.varies_rad()),
            request.step(candidate.turn_s),
            &request.c,
            &request.x,
        ));
        let worst = uses.iter().copied().max_by(|a, b| a.speed_ratio().total_cmp(&b.speed_ratio()));
        match worst {
            Some(worst) if worst.ratio() > 1.0 => {
                let on_plateau = worst.time_s >= plateau_s.0 && worst.time_s <= plateau_s.1;
                if on_plateau {
                    return Err(LimitViolation::Limit(worst));
                }
                misfit = Some(LimitViolation::Limit(worst));
            }
            _ => return Ok(Candidate { uses, ..candidate }),
        }
    }
    Err(misfit.unwrap_or(LimitViolation::NoPlateau(0.0)))
}

/// From one speed to another, from angle 0 at time 0 on; where they are the same, that one knot.
fn ramp(from: f64, to: f64, limits: &MotionLimits) -> Result<Vec<Knot>, LimitViolation> {
    if from.to_bits() == to.to_bits() {
        return Ok(alloc::vec![Knot { at: 0.0, value: 0.0, first: to, second: 0.0 }]);
    }
    velocity_ramp(from, to, limits).map(|ramp| ramp.knots().to_vec()).map_err(LimitViolation::Ramp)
}

/// Run-up, plateau, and run-down, which is given as the run-up that it is backwards, over `total` rad exactly.
fn between(up: &[Knot], down: &[Knot], speed: f64, total: f64) -> Result<(HermiteSpline, (f64, f64)), LimitViolation> {
    let (up_end, down_end) = (up[up.len() - 1], down[down.len() - 1]);
    let begin = up_end.at;
    let end = begin + (total - (up_end.value + down_end.value)) / speed;
    let mut knots: Vec<Knot> = up.to_vec();
    knots.extend(down.iter().rev().map(|knot| Knot {
        at: end + (down_end.at - knot.at),
        value: total - knot.value,
        first: knot.first,
        second: -knot.second,
    }));
    // So long a plateau that the knots of the run-down are the same float.
    let law = HermiteSpline::new(knots).map_err(|_| LimitViolation::TooLong(end + down_end.at))?;
    Ok((law, (begin, end)))
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

/// Cam angle of a path angle for reports: degrees in 0..360.
fn cam_angle_deg(angle_rad: f64) -> f64 {
    deg_from_rad(wrap_turn(angle_rad))
}

#[cfg(test)]
mod tests;
