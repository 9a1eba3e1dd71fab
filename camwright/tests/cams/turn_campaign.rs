// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random turns against their limits, from a seed to a verdict: rough and smooth paths, coarse and fine ones, axes of extreme ratios,
//! bounds that are flat, notched or of the process.

use crate::cams::{self, SplitMix64, random_law, reference_contour};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::job::grinding::SpeedLaw;
use camwright::job::infeed::InfeedSchedule;
use camwright::machine::description::{AxisScale, MotionLimits};
use camwright::math::hermite::Sample;
use camwright::math::periodic_spline::PeriodicSpline;
use camwright::math::units::TURN_RAD;
use camwright::motion::speed_plan::{
    Cutting, SpeedPlan, SpeedPlanError, SpeedRequest, TurnBounds, TurnError, TurnRequest, TurnSpeed,
};
use camwright::toolpath::wheel_path::ToolPath;

/// Outcome of a turn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TurnVerdict {
    /// No turn: the input allows none, or no speed keeps the limits of X.
    Refused,
    /// Planned: the time of the turn (s), and the largest use of each limit.
    Planned { turn_s: f64, uses: [f64; USES], input: String },
    /// A turn that is none.
    Wrong(String),
}

/// Speed bound, speed, acceleration and jerk of C, then of X.
pub(crate) const USES: usize = 7;

/// Points of a turn, at least: some ten times those of the planner.
const POINTS: usize = 120_000;

/// Points in each interval of the path, at least.
const POINTS_OF_INTERVAL: usize = 24;

/// A path and the process on it.
struct Path {
    spline: PeriodicSpline,
    cutting: Cutting,
}

/// Limits over as many decades either way.
fn limits(random: &mut SplitMix64, ordinary: [f64; 3], decades: f64) -> MotionLimits {
    let [velocity, acceleration, jerk] = ordinary.map(|value| value * 10_f64.powf(random.within(-decades, decades)));
    MotionLimits { velocity, acceleration, jerk }
}

/// The path of a wheel up to the largest that fits, which makes notches in the bound of the process.
fn wheel_path(random: &mut SplitMix64) -> Option<Path> {
    let contour = if random.next().is_multiple_of(4) {
        reference_contour()
    } else {
        let lift = random_law(random, 3.0);
        let follower = Follower::Roller { radius_mm: random.within(3.0, 15.0), offset_mm: 0.0 };
        Contour::from_lift(&lift, &follower, random.within(12.0, 40.0)).ok()?
    };
    let largest_mm = contour.recommended_wheel_radius_mm().unwrap_or(250.0).clamp(10.0, 250.0);
    let share = if random.next().is_multiple_of(2) { 1.0 } else { random.within(0.2, 1.0) };
    let path = ToolPath::for_wheel(&contour, share * largest_mm).ok()?;
    let cutting = cams::cutting(path.wheel_radius_mm(), 10_f64.powf(random.within(-2.5, -0.7)));
    Some(Path { spline: path.spline().clone(), cutting })
}

/// Harmonics, with or without a dwell, on few or many knots.
fn harmonic_path(random: &mut SplitMix64) -> Option<Path> {
    let knots = random.one_of(&[12, 36, 90, 361, 1440, 5000]);
    let highest = u32::try_from(random.next() % 12).ok()?;
    let lift_mm = 10_f64.powf(random.within(-3.0, 1.0));
    let terms: Vec<(f64, f64, f64)> =
        (0..=highest).map(|k| (f64::from(k), lift_mm / f64::from(1 + k * k), random.within(0.0, TURN_RAD))).collect();
    let dwell_rad = if random.next().is_multiple_of(2) { 0.0 } else { random.within(0.3, 4.0) };
    let value = |angle: f64| {
        // A lift between its dwells, smooth up to its third derivative.
        let share = ((angle - dwell_rad) / (TURN_RAD - dwell_rad)).max(0.0);
        let wave: f64 = terms.iter().map(|(k, size, phase)| size * (k * angle + phase).cos()).sum();
        let window = (16.0 * (share * (1.0 - share)).powi(2)).powi(2);
        30.0 + if dwell_rad > 0.0 { window * wave } else { wave }
    };
    let values: Vec<f64> = (0..knots).map(|i| value(TURN_RAD * f64::from(i) / f64::from(knots))).collect();
    let cutting = cams::cutting(60.0, 0.02);
    Some(Path { spline: PeriodicSpline::interpolate(&values).ok()?, cutting })
}

/// A bound on C's speed.
#[derive(Debug, Clone, Copy)]
enum Bound {
    /// The same everywhere, at a share of C's largest speed.
    Flat { rad_s: f64 },
    /// A removal rate up to a largest speed.
    Removal { rate_mm2_s: f64, max_rad_s: f64 },
    /// Flat, with a notch at an angle.
    Notch { rad_s: f64, angle_rad: f64, width_rad: f64, depth: f64 },
    /// Flat but for a wave.
    Wave { rad_s: f64, size: f64, waves: f64 },
}

impl Bound {
    fn random(random: &mut SplitMix64, path: &Path, c: &MotionLimits) -> Self {
        let rad_s = c.velocity * 10_f64.powf(random.within(-2.0, 0.3));
        match random.next() % 6 {
            0 => Self::Flat { rad_s },
            1..=3 => Self::removal(random, path, c),
            4 => Self::Notch {
                rad_s,
                angle_rad: random.within(0.0, TURN_RAD),
                width_rad: random.within(0.3, 10.0).to_radians(),
                depth: 10_f64.powf(random.within(-4.0, -0.1)),
            },
            _ => Self::Wave {
                rad_s,
                size: 10_f64.powf(random.within(-5.0, -1.0)),
                waves: (1 + random.next() % 40) as f64,
            },
        }
    }

    /// A removal rate, with a largest speed of C that may be so little above its slowest one that just the bottoms of notches show.
    fn removal(random: &mut SplitMix64, path: &Path, c: &MotionLimits) -> Self {
        let rate_mm2_s = 10_f64.powf(random.within(-0.5, 1.7));
        if random.next().is_multiple_of(2) {
            return Self::Removal { rate_mm2_s, max_rad_s: c.velocity };
        }
        let speed = |i: u32| {
            let path_there = path.spline.sample(f64::from(i) * TURN_RAD / 20_000.0);
            rate_mm2_s / path.cutting.removal_rate_ratio_mm2(path_there)
        };
        let slowest = (0..20_000).map(speed).fold(f64::INFINITY, f64::min);
        Self::Removal { rate_mm2_s, max_rad_s: slowest * (1.0 + 10_f64.powf(random.within(-4.0, -0.5))) }
    }

    fn at(&self, angle_rad: f64, x: Sample, cutting: &Cutting) -> f64 {
        match *self {
            Self::Flat { rad_s } => rad_s,
            Self::Removal { rate_mm2_s, max_rad_s } => (rate_mm2_s / cutting.removal_rate_ratio_mm2(x)).min(max_rad_s),
            Self::Notch { rad_s, angle_rad: centre_rad, width_rad, depth } => {
                let off = (0.5 * (angle_rad - centre_rad)).sin() / (0.5 * width_rad);
                rad_s * (1.0 - depth * (-off * off).exp())
            }
            Self::Wave { rad_s, size, waves } => rad_s * (1.0 + size * (waves * angle_rad).cos()),
        }
    }
}

/// One turn.
pub(crate) fn judge_turn(seed: u64) -> TurnVerdict {
    let mut random = SplitMix64(seed);
    let path = if random.next().is_multiple_of(2) { wheel_path(&mut random) } else { harmonic_path(&mut random) };
    let Some(path) = path else { return TurnVerdict::Refused };
    let decades = random.one_of(&[0.3, 1.0, 2.0]);
    let c = limits(&mut random, [31.4, 300.0, 3e4], decades);
    let x = limits(&mut random, [500.0, 1e4, 1e6], decades);
    let bound = Bound::random(&mut random, &path, &c);
    let infeed_slope_mm_rad = if random.next().is_multiple_of(2) { 0.0 } else { -0.005 };
    let process = |angle: f64, sample: Sample| bound.at(angle, sample, &path.cutting);
    let request = TurnRequest { path: &path.spline, infeed_slope_mm_rad, bound: &process, c, x };
    let turn = match TurnSpeed::fastest(&request) {
        Ok(turn) => turn,
        Err(TurnError::BadLimit { .. }) => return TurnVerdict::Wrong(format!("{c:?} {x:?} are refused")),
        Err(TurnError::NoSpeed { .. } | TurnError::NoStart) => return TurnVerdict::Refused,
    };
    let turn_s = turn.turn_s();
    if !(turn_s >= turn.minimum_s() && turn_s.is_finite()) {
        return TurnVerdict::Wrong(format!("a turn of {turn_s} s, at least {} s", turn.minimum_s()));
    }
    let uses = uses(&turn, &request);
    let input = format!("{} knots, {bound:?}, C {c:?}, X {x:?}", path.spline.coefficients().len());
    verdict(turn_s, uses, input)
}

fn verdict(turn_s: f64, uses: [f64; USES], input: String) -> TurnVerdict {
    match uses.iter().any(|used| used.is_nan()) {
        true => TurnVerdict::Wrong(format!("{uses:?} of its limits; {input}")),
        false => TurnVerdict::Planned { turn_s, uses, input },
    }
}

/// One cut: a turn of it, as C and X go through it in time.
pub(crate) fn judge_turn_of_cut(seed: u64) -> TurnVerdict {
    let mut random = SplitMix64(seed);
    let Some(path) = wheel_path(&mut random) else { return TurnVerdict::Refused };
    let decades = random.one_of(&[0.3, 0.7, 1.2]);
    let c = limits(&mut random, [31.4, 300.0, 3e4], decades);
    let x = limits(&mut random, [500.0, 1e4, 1e6], decades);
    let Bound::Removal { rate_mm2_s: removal_rate_mm2_s, max_rad_s } = Bound::removal(&mut random, &path, &c) else {
        return TurnVerdict::Refused;
    };
    let speed = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, max_rad_s };
    let per_turn_mm = (path.cutting.infeed_per_turn_mm * 1e5).round() / 1e5;
    let cutting = Cutting { infeed_per_turn_mm: per_turn_mm, ..path.cutting };
    let scale = AxisScale::Linear { counts_per_mm: 100_000 };
    let infeed = InfeedSchedule::new(4.0 * per_turn_mm, per_turn_mm / 3600.0, 3600, scale).expect("4 turns");
    let request = SpeedRequest {
        path: &path.spline,
        path_start_rad: random.within(0.0, TURN_RAD),
        infeed: &infeed,
        infeed_direction: cutting.infeed_direction,
        ratio: None,
        spark_out_turns: 1,
        leaves_turning: false,
        speed,
        comes: None,
        goes: None,
        wheel_power: None,
        rotation_sense: 1,
        wheel_radius_mm: cutting.wheel_radius_mm,
        wheel_speed_m_s: cutting.wheel_speed_m_s,
        c,
        x,
        cycle_time_s: 1e-3,
    };
    let plan = match SpeedPlan::new(&request) {
        Ok(plan) => plan,
        Err(SpeedPlanError::Check(found)) => return TurnVerdict::Wrong(format!("its own check: {found}")),
        Err(_) => return TurnVerdict::Refused,
    };
    let infeed_slope_mm_rad = -infeed.lasting_slope_mm_rad();
    let bounds = TurnBounds {
        path: &path.spline,
        infeed_slope_mm_rad: -infeed_slope_mm_rad,
        speed,
        wheel_power: None,
        cutting,
        c,
        x,
    };
    let allowed = bounds.allowed();
    let step_s = plan.turn_s() / POINTS as f64;
    let mut largest = [0.0_f64; USES];
    for i in 0..POINTS {
        let c = plan.law().sample(plan.plateau_s().0 + i as f64 * step_s);
        let (v, a) = (c.first, c.second);
        let mut over_angle = path.spline.sample(request.path_start_rad + c.value);
        let process_rad_s = (removal_rate_mm2_s / cutting.removal_rate_ratio_mm2(over_angle)).min(max_rad_s);
        over_angle.first += infeed_slope_mm_rad;
        let [d1, d2, d3] = [over_angle.first, over_angle.second, over_angle.third];
        let used = [
            v / process_rad_s,
            v / allowed[0].velocity,
            a / allowed[0].acceleration,
            c.third / allowed[0].jerk,
            d1 * v / allowed[1].velocity,
            (d2 * v * v + d1 * a) / allowed[1].acceleration,
            (d3 * v * v * v + 3.0 * d2 * v * a + d1 * c.third) / allowed[1].jerk,
        ];
        enlarge(&mut largest, used);
    }
    verdict(plan.turn_s(), largest, format!("{} knots, {speed:?}, C {c:?}, X {x:?}", path.spline.coefficients().len()))
}

/// Keeps the larger magnitudes, and NaN.
fn enlarge(largest: &mut [f64; USES], used: [f64; USES]) {
    for (largest, used) in largest.iter_mut().zip(used) {
        if used.is_nan() || used.abs() > *largest {
            *largest = used.abs();
        }
    }
}

/// Largest use of each limit on a fine grid, by the chain rule over the angle, with the jerk of C differenced.
fn uses(turn: &TurnSpeed, request: &TurnRequest<'_>) -> [f64; USES] {
    let (c, x) = (&request.c, &request.x);
    let points = POINTS.max(POINTS_OF_INTERVAL * request.path.coefficients().len());
    let d = TURN_RAD / points as f64;
    let mut largest = [0.0_f64; USES];
    let mut before = turn.at(-d);
    let mut here = turn.at(0.0);
    for i in 0..points {
        let angle = i as f64 * d;
        let after = turn.at(angle + d);
        let (v, a) = (here.speed, here.acceleration);
        // A step that crosses a knot, where jerk jumps, mixes two of them; the step on the other side does not.
        let jerks = [a - before.acceleration, after.acceleration - a].map(|change| change / d * v);
        let mut path = request.path.sample(angle);
        let process_rad_s = (request.bound)(angle, path);
        path.first += request.infeed_slope_mm_rad;
        let lower = |jerk: [f64; 2]| if jerk[0].abs() < jerk[1].abs() { jerk[0] } else { jerk[1] };
        let x_jerk = |jerk: f64| path.third * v * v * v + 3.0 * path.second * v * a + path.first * jerk;
        let used = [
            v / process_rad_s,
            v / c.velocity,
            a / c.acceleration,
            lower(jerks) / c.jerk,
            path.first * v / x.velocity,
            (path.second * v * v + path.first * a) / x.acceleration,
            lower(jerks.map(x_jerk)) / x.jerk,
        ];
        (before, here) = (here, after);
        enlarge(&mut largest, used);
    }
    largest
}
