// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The motion of generation: C by a time law, X by a path over C plus an infeed, and their derivatives in time.

use crate::job::speed_variation::SpeedVariation;
use crate::math::hermite::{HermiteSpline, Knot, Sample};
use crate::math::hermite_exact::ExactHermite;
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::twofold::Twofold;
use crate::math::units::{TURN_RAD, wrap_turn};
use crate::motion::plan::{CutSegment, Plan, SegmentKind};
use alloc::vec::Vec;

/// Motion of one cut: what a [`CutSegment`] says, at any time.
#[derive(Debug, Clone, Copy)]
pub struct CutMotion<'a> {
    /// `x_axis` position over the path angle (mm over rad).
    pub path: &'a PeriodicSpline,
    /// Path angle at the start (rad).
    pub path_start_rad: f64,
    /// Infeed still to come over the angle since the start (mm over rad): an offset of X, or of depth where there is a ratio.
    pub infeed: &'a HermiteSpline,
    /// Way of X per depth along the contour's normal, over the path angle; none where the infeed is that of X.
    pub ratio: Option<&'a PeriodicSpline>,
    /// Distance of X from path and infeed over time where C turns on (mm over s), with the same ends as the law.
    pub lead: Option<&'a HermiteSpline>,
    /// Angle since the cut begins over time (rad over s).
    pub law: &'a HermiteSpline,
}

/// Both axes at one time, with derivatives in time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CutSample {
    /// Angle of C since the cut begins (rad, s).
    pub c: Sample,
    /// Position of X (mm, s).
    pub x: Sample,
}

impl CutMotion<'_> {
    /// When it begins (s): before time 0, where the cut begins, if C comes turning.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        self.law.start()
    }

    /// When it ends (s).
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.law.end()
    }

    /// Length (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.end_s() - self.start_s()
    }

    /// Speed of C at the start and at the end (rad/s), 0 where it rests.
    #[must_use]
    pub fn end_speeds_rad_s(&self) -> (f64, f64) {
        let knots = self.law.knots();
        (knots[0].first, knots[knots.len() - 1].first)
    }

    /// X on path and infeed over the angle since the cut begins, with derivatives by the angle (mm, rad).
    #[must_use]
    pub fn over_angle(&self, angle_rad: f64) -> Sample {
        sum(self.path.sample(self.path_start_rad + angle_rad), self.offset_over_angle(angle_rad))
    }

    /// Addition of the infeed to X over the angle since the start, with derivatives by the angle (mm, rad).
    #[must_use]
    pub fn offset_over_angle(&self, angle_rad: f64) -> Sample {
        self.path_position(self.infeed.sample(angle_rad), self.path_start_rad + angle_rad)
    }

    /// Addition of an infeed, known over the angle, to X at a path angle, with derivatives by the angle (mm, rad).
    #[must_use]
    pub fn path_position(&self, infeed: Sample, path_angle_rad: f64) -> Sample {
        match self.ratio {
            Some(ratio) => product(ratio.sample(path_angle_rad), infeed),
            None => infeed,
        }
    }

    /// Angle of C at a time; before its start and after its end C goes on as it does there.
    #[must_use]
    pub fn angle(&self, time_s: f64) -> Sample {
        let edge_s = time_s.clamp(self.start_s(), self.end_s());
        let edge = self.law.sample(edge_s);
        if time_s.to_bits() == edge_s.to_bits() {
            return edge;
        }
        Sample { value: edge.value + edge.first * (time_s - edge_s), first: edge.first, second: 0.0, third: 0.0 }
    }

    /// Distance of X from path and infeed at a time.
    #[must_use]
    pub fn beside_path(&self, time_s: f64) -> Sample {
        self.lead.map_or_else(Sample::default, |lead| lead.sample(time_s))
    }

    /// Both axes at a time. The chain rule: Ẋ = X'Ċ, Ẍ = X''Ċ² + X'C̈, X⃛ = X'''Ċ³ + 3X''ĊC̈ + X'C⃛. Before its start and after its
    /// end X rests.
    #[must_use]
    pub fn at(&self, time_s: f64) -> CutSample {
        let edge_s = time_s.clamp(self.start_s(), self.end_s());
        let at_edge = self.law.sample(edge_s);
        let x = sum(chain(self.over_angle(at_edge.value), at_edge), self.beside_path(edge_s));
        if time_s.to_bits() == edge_s.to_bits() {
            return CutSample { c: at_edge, x };
        }
        CutSample { c: self.angle(time_s), x: Sample { value: x.value, ..Sample::default() } }
    }

    /// Position of X at a time (mm); it rests before the start and after the end.
    #[must_use]
    pub fn x_mm(&self, time_s: f64) -> f64 {
        let time_s = time_s.clamp(self.start_s(), self.end_s());
        let x_mm = self.over_angle(self.law.sample(time_s).value).value;
        self.lead.map_or(x_mm, |lead| x_mm + lead.sample(time_s).value)
    }

    /// Time at which C has turned an angle since the cut began (s): the law does not turn back.
    #[must_use]
    pub fn time_of(&self, angle_rad: f64) -> f64 {
        self.law.place_of(angle_rad)
    }

    /// Time that a variation of the work speed adds (s), each change of speed taking `change_s` (s). The last one ends with the plateau.
    #[must_use]
    pub fn time_added_by(&self, variation: &SpeedVariation, plateau_s: (f64, f64), change_s: f64) -> f64 {
        let slow_rate = variation.slow_rate();
        // The rate of a change is symmetrical about its middle.
        let change_path_s = change_s * 0.5 * (1.0 + slow_rate);
        let end_s = plateau_s.1 - change_s;
        let half_rad = 0.5 * variation.period_turns * TURN_RAD;
        let (mut added_s, mut half) = (0.0, 1.0);
        loop {
            let from_s = self.time_of(half * half_rad).max(plateau_s.0);
            if from_s >= end_s {
                return added_s;
            }
            let to_s = self.time_of((half + 1.0) * half_rad).min(end_s);
            let steady_s = (to_s - from_s - change_path_s).max(0.0);
            added_s += 2.0 * (change_s - change_path_s) + steady_s * (1.0 / slow_rate - 1.0);
            half += 2.0;
        }
    }
}

/// Positions of a cut with the digits that a float loses behind many turns, for checks that difference them. Times follow each other.
#[derive(Debug, Clone)]
pub(crate) struct ExactCut<'a> {
    motion: &'a CutMotion<'a>,
    law: ExactHermite<'a>,
    infeed: ExactHermite<'a>,
    lead: Option<ExactHermite<'a>>,
}

impl<'a> ExactCut<'a> {
    pub(crate) fn new(motion: &'a CutMotion<'a>) -> Self {
        Self {
            motion,
            law: ExactHermite::new(motion.law),
            infeed: ExactHermite::new(motion.infeed),
            lead: motion.lead.map(ExactHermite::new),
        }
    }

    /// Same as [`CutMotion::angle`], with twice the digits.
    pub(crate) fn angle(&mut self, time_s: Twofold) -> Twofold {
        let beyond = |edge: &Knot| {
            let since = time_s.plus_float(-edge.at);
            since.times(Twofold::from(edge.first)).plus_float(edge.value)
        };
        match self.motion.law.knots() {
            [first, ..] if time_s.value() < first.at => beyond(first),
            [.., last] if time_s.value() > last.at => beyond(last),
            _ => self.law.at(time_s),
        }
    }

    /// Same as [`CutMotion::x_mm`], with twice the digits.
    pub(crate) fn x_mm(&mut self, time_s: Twofold) -> Twofold {
        let angle = self.law.at(time_s);
        let path_angle = angle.plus_float(self.motion.path_start_rad);
        let infeed = self.infeed.at(angle);
        let offset = match self.motion.ratio {
            Some(ratio) => ratio.exact_value(path_angle).times(infeed),
            None => infeed,
        };
        let x = self.motion.path.exact_value(path_angle).plus(offset);
        match &mut self.lead {
            Some(lead) => x.plus(lead.at(time_s)),
            None => x,
        }
    }
}

/// Derivatives in time of what is known over an angle that is known over time.
#[must_use]
pub fn chain(over_angle: Sample, angle: Sample) -> Sample {
    let (w, a, j) = (angle.first, angle.second, angle.third);
    Sample {
        value: over_angle.value,
        first: over_angle.first * w,
        second: over_angle.second * w * w + over_angle.first * a,
        third: over_angle.third * w * w * w + 3.0 * over_angle.second * w * a + over_angle.first * j,
    }
}

/// Sum of two functions of one variable, with derivatives.
#[must_use]
pub fn sum(a: Sample, b: Sample) -> Sample {
    Sample { value: a.value + b.value, first: a.first + b.first, second: a.second + b.second, third: a.third + b.third }
}

/// Product of two functions of one variable, with derivatives.
fn product(a: Sample, b: Sample) -> Sample {
    Sample {
        value: a.value * b.value,
        first: a.first * b.value + a.value * b.first,
        second: a.second * b.value + 2.0 * a.first * b.first + a.value * b.second,
        third: a.third * b.value + 3.0 * (a.second * b.first + a.first * b.second) + a.value * b.third,
    }
}

/// One point of a turn at the programmed speed, without infeed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnSample {
    /// Path angle: σ times the wheel-line angle in the lobe's frame (rad), 0 at the base centre.
    pub angle_rad: f64,
    /// Time since the path angle was 0 (s).
    pub time_s: f64,
    /// Speed, acceleration and jerk of C (rad, s); the value is the path angle.
    pub c: Sample,
    /// Position, speed, acceleration and jerk of X (mm, s).
    pub x: Sample,
}

impl Plan {
    /// The cuts of a lobe, pass by pass.
    pub fn cuts_of(&self, lobe: usize) -> impl Iterator<Item = &CutSegment> {
        self.segments.iter().filter(move |segment| segment.lobe == Some(lobe)).filter_map(|segment| {
            match &segment.kind {
                SegmentKind::Cut(cut) => Some(cut),
                _ => None,
            }
        })
    }

    /// The motion of a cut of this plan; `None` if it names splines that the plan does not have.
    #[must_use]
    pub fn motion_of(&self, cut: &CutSegment) -> Option<CutMotion<'_>> {
        Some(CutMotion {
            path: self.paths.get(cut.path)?,
            path_start_rad: cut.path_start_rad,
            infeed: self.angle_laws.get(cut.infeed)?,
            ratio: match cut.ratio {
                Some(ratio) => Some(self.ratios.get(ratio)?),
                None => None,
            },
            lead: match cut.lead {
                Some(lead) => Some(self.time_laws.get(lead)?),
                None => None,
            },
            law: self.time_laws.get(cut.speed)?,
        })
    }

    /// A turn of a cut at the programmed speed and without infeed, at `count` equal steps of the path angle.
    ///
    /// `None` if the plan lacks its splines, or its plateau is shorter than a turn.
    #[must_use]
    pub fn turn_samples(&self, cut: &CutSegment, count: u32) -> Option<Vec<TurnSample>> {
        let motion = self.motion_of(cut)?;
        let plateau = cut.plateau_s;
        if plateau.1 - plateau.0 < cut.turn_s {
            return None;
        }
        // Angles since the start at which the plateau begins, and at which the path angle is 0 first after that.
        let begin = motion.law.sample(plateau.0).value;
        let time_at = |angle: f64| motion.time_of(begin + wrap_turn(angle - cut.path_start_rad - begin));
        let zero_s = time_at(0.0);
        let samples = (0..count).map(|i| {
            let angle_rad = f64::from(i) * TURN_RAD / f64::from(count);
            let at = time_at(angle_rad);
            let late = at - zero_s;
            let mut c = motion.law.sample(at);
            c.value = angle_rad;
            TurnSample {
                angle_rad,
                time_s: if late < 0.0 { late + cut.turn_s } else { late },
                c,
                x: chain(motion.path.sample(angle_rad), c),
            }
        });
        Some(samples.collect())
    }
}
