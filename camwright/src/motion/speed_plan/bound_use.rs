// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bounds that limit C, and their positions: every bound of a turn as a share of the value allowed for planning.

use super::process::{Cutting, largest_speed_rad_s};
use super::{LimitedQuantity, PATH_SHARE, VARYING_X_SHARE};
use crate::job::grinding::SpeedLaw;
use crate::machine::description::{Axis, MotionLimits};
use crate::math::hermite::Sample;
use crate::math::periodic_spline::PeriodicSpline;
use crate::motion::cut_motion::chain;

/// Share of a bound from which on it is said to set the speed. The fastest turn is found on knots, between which only one
/// number is free, and jerk is kept by tangents that lie inside its true limit: on the arcs that it rules, between 0.95 and 1
/// of what planning allows is used. Below, between two arcs, nothing is.
pub const ACTIVE_SHARE: f64 = 0.95;

/// Bounds of C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// A limit of an axis.
    Limit(Axis, LimitedQuantity),
    /// Process bound of the speed law: footprint speed, removal rate, power or temperature.
    Process,
    /// The work speed of the pass; of a law that lets it vary the largest.
    WorkSpeed,
    /// The power of the wheel's spindle.
    WheelPower,
}

impl Bound {
    pub const ALL: [Bound; 9] = [
        Bound::WorkSpeed,
        Bound::Process,
        Bound::Limit(Axis::C, LimitedQuantity::Velocity),
        Bound::Limit(Axis::C, LimitedQuantity::Acceleration),
        Bound::Limit(Axis::C, LimitedQuantity::Jerk),
        Bound::Limit(Axis::X, LimitedQuantity::Velocity),
        Bound::Limit(Axis::X, LimitedQuantity::Acceleration),
        Bound::Limit(Axis::X, LimitedQuantity::Jerk),
        Bound::WheelPower,
    ];
}

/// The bounds of a turn of one pass.
#[derive(Debug, Clone, Copy)]
pub struct TurnBounds<'a> {
    /// `x_axis` position over the path angle (mm over rad).
    pub path: &'a PeriodicSpline,
    /// Share of the slope of X used by the infeed in most of a turn (mm/rad).
    pub infeed_slope_mm_rad: f64,
    /// Speed law of the pass.
    pub speed: SpeedLaw,
    /// Bound of the wheel's power, as a law.
    pub wheel_power: Option<SpeedLaw>,
    /// Wheel and infeed of a turn.
    pub cutting: Cutting,
    /// Whole limits of C.
    pub c: MotionLimits,
    /// Whole limits of X.
    pub x: MotionLimits,
}

impl TurnBounds<'_> {
    /// Returns whether the law lets the speed of C vary within a turn.
    #[must_use]
    pub const fn varies(&self) -> bool {
        !matches!(self.speed, SpeedLaw::ConstantWorkSpeed { .. })
    }

    /// The work speed, or the largest one the law may use (rad/s).
    #[must_use]
    pub const fn work_speed_rad_s(&self) -> f64 {
        self.speed.maximum_rad_s()
    }

    /// The largest speed of C that the process allows at a path angle (rad/s); none where the law does not look at it.
    #[must_use]
    pub fn process_rad_s(&self, angle_rad: f64) -> Option<f64> {
        let mut law = self.speed;
        match &mut law {
            SpeedLaw::ConstantWorkSpeed { .. } | SpeedLaw::TimeOptimal { .. } => return None,
            SpeedLaw::ConstantFootprintSpeed { max_rad_s, .. }
            | SpeedLaw::ConstantRemovalRate { max_rad_s, .. }
            | SpeedLaw::ConstantRadialRemovalRate { max_rad_s, .. }
            | SpeedLaw::ConstantPower { max_rad_s, .. }
            | SpeedLaw::ConstantTemperature { max_rad_s, .. } => *max_rad_s = f64::INFINITY,
        }
        Some(largest_speed_rad_s(&law, self.path.sample(angle_rad), &self.cutting))
    }

    /// The largest speed of C that the wheel's power allows at a path angle (rad/s), where it is bounded.
    #[must_use]
    pub fn power_rad_s(&self, angle_rad: f64) -> Option<f64> {
        Some(largest_speed_rad_s(&self.wheel_power?, self.path.sample(angle_rad), &self.cutting))
    }

    /// Share of the limits of C and of X available to a turn: a stop on the path reserves a share of acceleration and jerk,
    /// and at varying speed the end of the infeed reserves a share of X.
    #[must_use]
    pub fn allowed(&self) -> [MotionLimits; 2] {
        let for_x = if self.varies() { VARYING_X_SHARE } else { PATH_SHARE };
        [self.c.with_share(PATH_SHARE), self.x.with_share(for_x)]
    }

    /// X and its derivatives in time, in a turn with infeed, where C moves like this; its value is the path angle (rad, s).
    #[must_use]
    pub fn x_in_time(&self, c: Sample) -> Sample {
        let mut over_angle = self.path.sample(c.value);
        over_angle.first -= self.infeed_slope_mm_rad;
        chain(over_angle, c)
    }

    /// Utilisation of each bound for a motion of C, in the order of [`Bound::ALL`]; 1 is all that planning allows.
    #[must_use]
    pub fn uses(&self, c: Sample) -> [f64; 9] {
        let [of_c, of_x] = self.allowed();
        let x = self.x_in_time(c);
        let in_time = |quantity: LimitedQuantity, sample: Sample| match quantity {
            LimitedQuantity::Velocity => sample.first.abs(),
            LimitedQuantity::Acceleration => sample.second.abs(),
            LimitedQuantity::Jerk => sample.third.abs(),
        };
        Bound::ALL.map(|bound| match bound {
            Bound::Limit(Axis::C, quantity) => in_time(quantity, c) / quantity.limit(&of_c),
            Bound::Limit(_, quantity) => in_time(quantity, x) / quantity.limit(&of_x),
            Bound::Process => self.process_rad_s(c.value).map_or(0.0, |allowed| c.first / allowed),
            Bound::WheelPower => self.power_rad_s(c.value).map_or(0.0, |allowed| c.first / allowed),
            Bound::WorkSpeed => c.first / self.work_speed_rad_s(),
        })
    }

    /// The bound that sets the speed where C moves like this, if one is used so far.
    #[must_use]
    pub fn active(&self, c: Sample) -> Option<Bound> {
        let uses = self.uses(c);
        let (bound, share) =
            Bound::ALL.into_iter().zip(uses).max_by(|a, b| a.1.total_cmp(&b.1).then(core::cmp::Ordering::Greater))?;
        (share >= ACTIVE_SHARE).then_some(bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::grinding::InfeedDirection;
    use crate::job::infeed::{BLEND_SHARE, InfeedSchedule};
    use crate::machine::description::AxisScale;
    use crate::math::units::TURN_RAD;
    use crate::motion::speed_plan::tests::{C, X, eccentric, request};
    use crate::motion::speed_plan::{SpeedPlan, SpeedRequest};
    use alloc::vec::Vec;

    const CUTTING: Cutting = Cutting {
        wheel_radius_mm: 60.0,
        wheel_speed_m_s: 80.0,
        infeed_per_turn_mm: 0.04,
        infeed_direction: InfeedDirection::X,
    };

    fn bounds(path: &PeriodicSpline, speed: SpeedLaw) -> TurnBounds<'_> {
        TurnBounds {
            path,
            infeed_slope_mm_rad: 0.04 / TURN_RAD,
            speed,
            wheel_power: None,
            cutting: CUTTING,
            c: C,
            x: X,
        }
    }

    /// On a disc of radius 20 mm 8 mm²/s at a depth of 0.04 mm is 10 rad/s: 5 rad/s uses half of it, and a largest work speed
    /// of 8 rad/s is what sets the speed.
    #[test]
    fn on_a_round_part_the_law_or_the_work_speed_is_the_bound() {
        let path = eccentric(20.0, 0.0);
        let turning = |speed: f64| Sample { first: speed, ..Sample::default() };
        let law = |max_rad_s| SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 8.0, max_rad_s };
        let wide = bounds(&path, law(30.0));
        assert!((wide.uses(turning(5.0))[1] - 0.5).abs() < 1e-12);
        assert_eq!(wide.active(turning(10.0)), Some(Bound::Process));
        assert_eq!(wide.active(turning(5.0)), None);
        assert_eq!(bounds(&path, law(8.0)).active(turning(8.0)), Some(Bound::WorkSpeed));
        let constant = bounds(&path, SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 });
        assert_eq!((constant.active(turning(6.0)), constant.process_rad_s(0.0)), (Some(Bound::WorkSpeed), None));
    }

    /// e cos θ at constant speed: Ẍ = −e ω² at the nose, X⃛ = e ω³ a quarter turn on.
    #[test]
    fn limits_of_x_are_used_as_on_paper() {
        let path = eccentric(40.0, 4.0);
        let law = SpeedLaw::TimeOptimal { max_rad_s: 31.4 };
        let at = |angle: f64| bounds(&path, law).uses(Sample { value: angle, first: 20.0, ..Sample::default() });
        let share = PATH_SHARE - BLEND_SHARE;
        assert!((at(0.0)[6] / (4.0 * 400.0 / (share * X.acceleration)) - 1.0).abs() < 1e-3);
        assert!((at(TURN_RAD / 4.0)[7] / (4.0 * 8000.0 / (share * X.jerk)) - 1.0).abs() < 1e-3);
        assert!((at(0.0)[2] - 20.0 / C.velocity).abs() < 1e-12);
    }

    /// A planned turn never uses more than what planning allows, and some bound is active nearly all the time.
    #[test]
    fn a_planned_turn_is_at_one_of_its_bounds_nearly_everywhere() {
        let path = eccentric(40.0, 6.0);
        let infeed = InfeedSchedule::new(0.08, 0.04 / 3600.0, 3600, AxisScale::Linear { counts_per_mm: 100_000 })
            .expect("2 turns");
        for removal_rate_mm2_s in [3.0, 20.0, 60.0] {
            let speed = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, max_rad_s: 31.0 };
            let asked = SpeedRequest { speed, ..request(&path, &infeed, 1.0) };
            let plan = SpeedPlan::new(&asked).expect("it can be made");
            let turn = bounds(&path, speed);
            let begin = plan.plateau_s().0;
            let moments: Vec<Sample> = (0..3600)
                .map(|i| {
                    let mut c = plan.law().sample(begin + plan.turn_s() * f64::from(i) / 3600.0);
                    c.value += 1.0;
                    c
                })
                .collect();
            let max = moments.iter().flat_map(|c| turn.uses(*c)).fold(0.0, f64::max);
            assert!(max <= 1.0 + 1e-6, "{removal_rate_mm2_s} mm2/s: {max}");
            let idle = moments.iter().filter(|c| turn.active(**c).is_none()).count();
            assert!(idle < 180, "{removal_rate_mm2_s} mm2/s: {idle} of 3600");
        }
    }
}
