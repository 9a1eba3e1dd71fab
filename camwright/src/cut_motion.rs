//! The motion of generation: C by a time law, X by a path over C plus an infeed, and their derivatives in time.

use crate::numeric::hermite::{HermiteSpline, Sample};
use crate::numeric::periodic_spline::PeriodicSpline;
use crate::plan::{CutSegment, Plan, SegmentKind};
use crate::units::{TURN_RAD, wrap_turn};
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
    /// Angle since the start over time (rad over s).
    pub law: &'a HermiteSpline,
}

/// Both axes at one time, with derivatives in time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CutSample {
    /// Angle of C since the start (rad, s).
    pub c: Sample,
    /// Position of X (mm, s).
    pub x: Sample,
}

impl CutMotion<'_> {
    /// Length (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.law.end()
    }

    /// X over the angle since the start, with derivatives by the angle (mm, rad).
    #[must_use]
    pub fn over_angle(&self, angle_rad: f64) -> Sample {
        let (path, infeed) = (self.path.sample(self.path_start_rad + angle_rad), self.offset_over_angle(angle_rad));
        Sample {
            value: path.value + infeed.value,
            first: path.first + infeed.first,
            second: path.second + infeed.second,
            third: path.third + infeed.third,
        }
    }

    /// What the infeed adds to X over the angle since the start, with derivatives by the angle (mm, rad).
    #[must_use]
    pub fn offset_over_angle(&self, angle_rad: f64) -> Sample {
        self.way_of(self.infeed.sample(angle_rad), self.path_start_rad + angle_rad)
    }

    /// What an infeed known over the angle adds to X at a path angle, with derivatives by the angle (mm, rad).
    #[must_use]
    pub fn way_of(&self, infeed: Sample, path_angle_rad: f64) -> Sample {
        match self.ratio {
            Some(ratio) => product(ratio.sample(path_angle_rad), infeed),
            None => infeed,
        }
    }

    /// Both axes at a time since the start. The chain rule: Ẋ = X'Ċ, Ẍ = X''Ċ² + X'C̈, X⃛ = X'''Ċ³ + 3X''ĊC̈ + X'C⃛.
    #[must_use]
    pub fn at(&self, time_s: f64) -> CutSample {
        let c = self.law.sample(time_s);
        CutSample { c, x: chain(self.over_angle(c.value), c) }
    }

    /// Time since the start at which C has turned an angle (s), by bisection: the law does not turn back.
    #[must_use]
    pub fn time_of(&self, angle_rad: f64) -> f64 {
        let (mut low, mut high) = (self.law.start(), self.law.end());
        while high - low > 1e-12 * (1.0 + high) {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.law.sample(middle).value < angle_rad { low = middle } else { high = middle }
        }
        0.5 * (low + high)
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
