// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Motion of the axes over the angle of a call: lead-in, cut at full depth, lead-out.

use super::{FeatureRequest, NcControl, PassRequest, ProgramTurnSpeed};
use crate::math::hermite::Sample;
use crate::math::units::TURN_RAD;
use crate::toolpath::cutter_path::{CarriageAxis, CutterPath};
use alloc::vec::Vec;

/// Steps of C at which a speed that varies is looked at, per turn.
const STEPS_PER_TURN: f64 = 3600.0;

/// A call of a subprogram as motion over u, the part's angle read forwards: it comes in over the lead and is at full depth from then on. A
/// closed path begins at u = 0. An open one lies over the azimuths 0 to its span, and begins where C comes to it first.
pub(super) struct SubprogramMotion<'a> {
    path: &'a CutterPath,
    stands_mm: &'a [(CarriageAxis, f64)],
    height_mm: f64,
    lead_rad: f64,
    leaves_turning: bool,
    sense: f64,
    speed: ProgramTurnSpeed<'a>,
    /// Angle at which full depth begins (rad).
    pub(super) begin_rad: f64,
    /// Angle at which full depth ends (rad).
    pub(super) full_rad: f64,
}

impl<'a> SubprogramMotion<'a> {
    pub(super) fn new(control: &NcControl, of: &'a FeatureRequest<'a>, pass: &PassRequest<'a>) -> Self {
        let span_rad = of.path.span_rad();
        let begin_rad = if of.path.is_open() && control.rotation_sense < 0 { -span_rad } else { 0.0 };
        Self {
            path: of.path,
            stands_mm: &of.stands_mm,
            height_mm: of.lead.height_mm,
            lead_rad: of.lead.angle_rad,
            leaves_turning: of.lead.leaves_turning,
            sense: f64::from(control.rotation_sense),
            speed: pass.speed,
            begin_rad,
            full_rad: begin_rad + f64::from(pass.turns) * span_rad,
        }
    }

    /// Turns of the part over which the path runs once.
    pub(super) fn turns_of_path(&self) -> u32 {
        self.path.turns()
    }

    /// Stretches that are cut into pieces by themselves: coming in, the turns, leaving.
    pub(super) fn stretches(&self) -> Vec<(f64, f64)> {
        let mut stretches =
            alloc::vec![(self.begin_rad - self.lead_rad, self.begin_rad), (self.begin_rad, self.full_rad)];
        if self.leaves_turning {
            stretches.push((self.full_rad, self.full_rad + self.lead_rad));
        }
        stretches
    }

    /// Axes that move over all of it, in the order of their letters.
    pub(super) fn axes(&self) -> Vec<CarriageAxis> {
        [CarriageAxis::X, CarriageAxis::Y, CarriageAxis::Z].into_iter().filter(|axis| self.moves(*axis, true)).collect()
    }

    /// Returns whether an axis moves during a lead (`leading`) or at full depth.
    pub(super) fn moves(&self, axis: CarriageAxis, leading: bool) -> bool {
        self.path.travels.iter().any(|travel| travel.axis == axis) || (leading && axis == self.path.infeed)
    }

    /// The axis along which the cutter comes to its depth.
    pub(super) fn infeed(&self) -> CarriageAxis {
        self.path.infeed
    }

    /// Position of axes that do not move at all.
    pub(super) fn standing(&self) -> impl Iterator<Item = (CarriageAxis, f64)> + '_ {
        self.stands_mm.iter().copied().filter(|(axis, _)| !self.moves(*axis, true))
    }

    /// An axis at an angle: position and derivatives (mm, mm/rad, …).
    pub(super) fn at(&self, axis: CarriageAxis, u_rad: f64) -> Sample {
        let stands = || self.stands_mm.iter().find(|(stands, _)| *stands == axis).map_or(0.0, |(_, mm)| *mm);
        let mut sample = match self.path.sample(axis, self.sense * u_rad) {
            Some(along) => Sample { first: self.sense * along.first, third: self.sense * along.third, ..along },
            None => Sample { value: stands(), ..Sample::default() },
        };
        if axis == self.path.infeed {
            let off = self.height_at(u_rad);
            sample.value += off.value;
            sample.first += off.first;
            sample.second += off.second;
        }
        sample
    }

    /// Height of the cutter above its depth: a quintic from rest to rest over the lead.
    fn height_at(&self, u_rad: f64) -> Sample {
        let (outside, sense) =
            if u_rad < self.begin_rad { (self.begin_rad - u_rad, -1.0) } else { (u_rad - self.full_rad, 1.0) };
        if outside <= 0.0 {
            return Sample::default();
        }
        let (w, per_rad) = ((outside / self.lead_rad).min(1.0), 1.0 / self.lead_rad);
        Sample {
            value: self.height_mm * w * w * w * (10.0 + w * (-15.0 + 6.0 * w)),
            first: sense * per_rad * self.height_mm * 30.0 * w * w * (1.0 - w) * (1.0 - w),
            second: per_rad * per_rad * self.height_mm * 60.0 * w * (1.0 - w) * (1.0 - 2.0 * w),
            third: 0.0,
        }
    }

    /// Speed of C (rad/s).
    pub(super) fn speed_rad_s(&self, u_rad: f64) -> f64 {
        match self.speed {
            ProgramTurnSpeed::WorkSpeed(speed) => speed,
            ProgramTurnSpeed::Law(law) => law(u_rad),
            ProgramTurnSpeed::AlongPath { feed_mm_s, max_rad_s } => {
                // The cutter's centre round the axis, and the travels beside it. Y is small against the radius.
                let radius = self.at(CarriageAxis::X, u_rad).value;
                let travels = self.path.travels.iter().map(|travel| self.at(travel.axis, u_rad).first);
                let along = libm::sqrt(radius * radius + travels.map(|first| first * first).sum::<f64>());
                max_rad_s.min(feed_mm_s / along)
            }
        }
    }

    /// Time from an angle to a later one (s): Simpson's rule where the speed varies.
    pub(super) fn time_s(&self, from_rad: f64, to_rad: f64) -> f64 {
        if let ProgramTurnSpeed::WorkSpeed(speed) = self.speed {
            return (to_rad - from_rad) / speed;
        }
        let way = to_rad - from_rad;
        #[allow(clippy::cast_possible_truncation, reason = "a way within the turns of a call")]
        let steps = libm::ceil(way * STEPS_PER_TURN / TURN_RAD).clamp(1.0, 1e9) as u32;
        let step = way / f64::from(steps);
        let slowness = |at: f64| 1.0 / self.speed_rad_s(from_rad + at * step);
        let simpson = |index: u32| {
            let index = f64::from(index);
            step / 6.0 * (slowness(index) + 4.0 * slowness(index + 0.5) + slowness(index + 1.0))
        };
        (0..steps).map(simpson).sum()
    }
}
