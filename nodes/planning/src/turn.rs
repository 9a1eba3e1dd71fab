// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One turn of a pass at the programmed speed, with the infeed of a whole turn, point by point over the angle of `c_axis`.

use super::PreparedJob;
use camwright::machine::description::{Axis, MotionLimits};
use camwright::math::hermite::Sample;
use camwright::math::periodic_spline::PeriodicSpline;
use camwright::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use camwright::motion::speed_plan::{Bound, Cutting, TurnBounds};

/// Points of a turn: 0.1°, a tenth of what a plan can change within.
const POINTS: u32 = 3600;

#[derive(Debug, Clone)]
pub(super) struct LobeTurn<'a> {
    /// In the order of their angle of C, from the smallest on.
    pub(super) points: Vec<LobeTurnPoint>,
    /// Path, law and limits of the pass.
    pub(super) bounds: TurnBounds<'a>,
    /// Time of the turn (s).
    pub(super) turn_s: f64,
}

/// One point of a turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct LobeTurnPoint {
    /// Angle of `c_axis` (deg, 0 … 360).
    pub(super) c_deg: f64,
    /// Path angle and its derivatives in time (rad, s).
    pub(super) c: Sample,
    /// Position of the axis and its derivatives in time (mm, s).
    pub(super) x: Sample,
    /// Specific removal rate (mm²/s).
    pub(super) removal_mm2_s: f64,
    /// The most that the speed law and the work speed allow of it (mm²/s).
    pub(super) allowed_mm2_s: f64,
    /// Bound that sets the speed.
    pub(super) active: Option<Bound>,
    /// Share of the turn's time that it stands for.
    pub(super) share: f64,
}

impl<'a> LobeTurn<'a> {
    /// The turn of a pass over a lobe; none where the plan has no turn at the programmed speed.
    pub(super) fn new(prepared: &'a PreparedJob, index: usize, pass: usize) -> Option<Self> {
        let plan = &prepared.planned.plan;
        let lobe = prepared.planned.lobes.get(index)?;
        let cut = plan.cuts_of(index).nth(pass)?;
        let path: &PeriodicSpline = plan.motion_of(cut)?.path;
        let schedule = lobe.passes.get(pass)?.infeed().schedule();
        let spec = prepared.job.spec.passes_of(index).get(pass)?;
        let cutting = Cutting {
            wheel_radius_mm: lobe.tool_path.wheel_radius_mm(),
            wheel_speed_m_s: prepared.machine.wheel_at(lobe.design.wheel(&prepared.machine)).surface_speed_m_s,
            infeed_per_turn_mm: schedule.max_per_turn_mm(),
            infeed_direction: spec.infeed_direction,
        };
        let bounds = TurnBounds {
            path,
            infeed_slope_mm_rad: schedule.lasting_slope_mm_rad(),
            speed: spec.speed,
            wheel_power: prepared.job.spec.wheel_power.map(|power| power.as_law(lobe.design.width_mm)),
            cutting,
            c: prepared.machine.axis(Axis::C).limits,
            x: prepared.machine.axis(Axis::X).limits,
        };
        let phase_rad = f64::from(prepared.machine.rotation_sense) * lobe.design.phase_rad;
        let max_rad_s = bounds.work_speed_rad_s();
        let mut points: Vec<LobeTurnPoint> = (plan.turn_samples(cut, POINTS)?.iter())
            .map(|sample| {
                let (c, ratio) = (sample.c, cutting.removal_rate_ratio_mm2(path.sample(sample.angle_rad)));
                let process = bounds.process_rad_s(sample.angle_rad).unwrap_or(f64::INFINITY);
                let power = bounds.power_rad_s(sample.angle_rad).unwrap_or(f64::INFINITY);
                LobeTurnPoint {
                    c_deg: deg_from_rad(wrap_turn(sample.angle_rad + phase_rad)),
                    c,
                    x: bounds.x_in_time(c),
                    removal_mm2_s: ratio * c.first,
                    allowed_mm2_s: ratio * process.min(power).min(max_rad_s),
                    active: bounds.active(c),
                    share: 1.0 / c.first,
                }
            })
            .collect();
        // Equal angles: each stands for the time that C takes over one of them.
        let sum: f64 = points.iter().map(|point| point.share).sum();
        points.iter_mut().for_each(|point| point.share /= sum);
        let first = (0..points.len()).min_by(|a, b| points[*a].c_deg.total_cmp(&points[*b].c_deg))?;
        points.rotate_left(first);
        Some(Self { points, bounds, turn_s: cut.turn_s })
    }

    /// Largest specific removal rate (mm²/s).
    pub(super) fn peak_mm2_s(&self) -> f64 {
        self.points.iter().map(|point| point.removal_mm2_s).fold(0.0, f64::max)
    }

    /// A turn at the one work speed at which the removal rate peaks as high as it does here (s).
    pub(super) fn constant_speed_turn_s(&self) -> f64 {
        let largest = self.points.iter().map(|point| point.removal_mm2_s / point.c.first).fold(0.0, f64::max);
        TURN_RAD * largest / self.peak_mm2_s()
    }

    /// Share of the limits of C and of X available to planning.
    pub(super) fn allowed(&self) -> [MotionLimits; 2] {
        self.bounds.allowed()
    }
}
