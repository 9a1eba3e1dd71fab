// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Motion laws: how a follower goes from one lift to another, normalised to a rise of 1 over an angle of 1.
//!
//! Over an angle β (rad) with a rise h (mm): s = h·f(u), s′ = h/β·f′(u), s″ = h/β²·f″(u), u = angle/β. The peak
//! factors are exact (tests below).

use crate::math::hermite::Sample;
use core::f64::consts::PI;

/// A law between two dwells, or a piece that fits its neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MotionLaw {
    /// No motion: the rise is 0.
    Dwell,
    ConstantVelocity,
    /// Half a cosine: acceleration does not vanish at the ends.
    Harmonic,
    /// Straight line minus a sine.
    Cycloidal,
    /// 10u³ − 15u⁴ + 6u⁵.
    Polynomial345,
    /// 35u⁴ − 84u⁵ + 70u⁶ − 20u⁷: jerk vanishes at the ends too.
    Polynomial4567,
    /// Sine quarters of two lengths.
    ModifiedSine,
    /// Constant accelerations joined by sines.
    ModifiedTrapezoid,
    /// The quintic that takes up velocity and acceleration of both neighbours; 3-4-5 between dwells.
    QuinticBlend,
    /// The septic that does so with vanishing jerk at its ends; 4-5-6-7 between dwells.
    SepticBlend,
}

impl MotionLaw {
    pub const ALL: [MotionLaw; 10] = [
        MotionLaw::Dwell,
        MotionLaw::ConstantVelocity,
        MotionLaw::Harmonic,
        MotionLaw::Cycloidal,
        MotionLaw::Polynomial345,
        MotionLaw::Polynomial4567,
        MotionLaw::ModifiedSine,
        MotionLaw::ModifiedTrapezoid,
        MotionLaw::QuinticBlend,
        MotionLaw::SepticBlend,
    ];

    /// Name in job files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            MotionLaw::Dwell => "dwell",
            MotionLaw::ConstantVelocity => "constant_velocity",
            MotionLaw::Harmonic => "harmonic",
            MotionLaw::Cycloidal => "cycloidal",
            MotionLaw::Polynomial345 => "3-4-5",
            MotionLaw::Polynomial4567 => "4-5-6-7",
            MotionLaw::ModifiedSine => "modified_sine",
            MotionLaw::ModifiedTrapezoid => "modified_trapezoid",
            MotionLaw::QuinticBlend => "quintic_blend",
            MotionLaw::SepticBlend => "septic_blend",
        }
    }

    /// The law of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<MotionLaw> {
        MotionLaw::ALL.into_iter().find(|law| law.name() == name)
    }

    /// Returns whether the law takes its boundary conditions from its neighbours.
    #[must_use]
    pub const fn is_blend(self) -> bool {
        matches!(self, MotionLaw::QuinticBlend | MotionLaw::SepticBlend)
    }

    /// Value and derivatives of the normalised law at `u` in 0..=1; outside, those of the nearer end. Blends are taken
    /// between dwells. A dwell is 0 throughout.
    #[must_use]
    pub fn sample(self, u: f64) -> Sample {
        let u = u.clamp(0.0, 1.0);
        match self {
            MotionLaw::Dwell => Sample::default(),
            MotionLaw::ConstantVelocity => Sample { value: u, first: 1.0, second: 0.0, third: 0.0 },
            MotionLaw::Harmonic => {
                let (sin, cos) = (libm::sin(PI * u), libm::cos(PI * u));
                let half_sine = libm::sin(0.5 * PI * u);
                Sample {
                    value: half_sine * half_sine,
                    first: 0.5 * PI * sin,
                    second: 0.5 * PI * PI * cos,
                    third: -0.5 * PI * PI * PI * sin,
                }
            }
            MotionLaw::Cycloidal => {
                let (sin, cos) = (libm::sin(2.0 * PI * u), libm::cos(2.0 * PI * u));
                Sample {
                    value: u - sin / (2.0 * PI),
                    first: 1.0 - cos,
                    second: 2.0 * PI * sin,
                    third: 4.0 * PI * PI * cos,
                }
            }
            MotionLaw::Polynomial345 | MotionLaw::QuinticBlend => Sample {
                value: u * u * u * (10.0 + u * (-15.0 + 6.0 * u)),
                first: u * u * (30.0 + u * (-60.0 + 30.0 * u)),
                second: u * (60.0 + u * (-180.0 + 120.0 * u)),
                third: 60.0 + u * (-360.0 + 360.0 * u),
            },
            MotionLaw::Polynomial4567 | MotionLaw::SepticBlend => Sample {
                value: u * u * u * u * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u))),
                first: u * u * u * (140.0 + u * (-420.0 + u * (420.0 - 140.0 * u))),
                second: u * u * (420.0 + u * (-1680.0 + u * (2100.0 - 840.0 * u))),
                third: u * (840.0 + u * (-5040.0 + u * (8400.0 - 4200.0 * u))),
            },
            MotionLaw::ModifiedSine => mirrored(u, modified_sine),
            MotionLaw::ModifiedTrapezoid => mirrored(u, modified_trapezoid),
        }
    }
}

/// The second half of a law that is symmetric about its middle.
fn mirrored(u: f64, first_half: fn(f64) -> Sample) -> Sample {
    if u <= 0.5 {
        return first_half(u);
    }
    let mirror = first_half(1.0 - u);
    Sample { value: 1.0 - mirror.value, first: mirror.first, second: -mirror.second, third: mirror.third }
}

/// Acceleration: a sine quarter of length 1/8, then a sine of a third of that frequency.
fn modified_sine(u: f64) -> Sample {
    let k = 1.0 / (4.0 + PI);
    if u < 0.125 {
        let (sin, cos) = (libm::sin(4.0 * PI * u), libm::cos(4.0 * PI * u));
        Sample {
            value: k * (PI * u - sin / 4.0),
            first: k * PI * (1.0 - cos),
            second: k * 4.0 * PI * PI * sin,
            third: k * 16.0 * PI * PI * PI * cos,
        }
    } else {
        let phase = PI / 3.0 + 4.0 * PI / 3.0 * u;
        let (sin, cos) = (libm::sin(phase), libm::cos(phase));
        Sample {
            value: k * (2.0 + PI * u - 2.25 * sin),
            first: k * PI * (1.0 - 3.0 * cos),
            second: k * 4.0 * PI * PI * sin,
            third: k * 16.0 * PI * PI * PI / 3.0 * cos,
        }
    }
}

/// Acceleration: a sine quarter of length 1/8, constant to 3/8, a sine quarter down to the middle.
fn modified_trapezoid(u: f64) -> Sample {
    let a = 8.0 * PI / (2.0 + PI);
    let w = 4.0 * PI;
    let (v1, s1) = (a / w, a / w * (0.125 - 1.0 / w));
    let (v2, s2) = (v1 + 0.25 * a, s1 + 0.25 * v1 + a / 32.0);
    if u < 0.125 {
        let (sin, cos) = (libm::sin(w * u), libm::cos(w * u));
        Sample { value: a / w * (u - sin / w), first: a / w * (1.0 - cos), second: a * sin, third: a * w * cos }
    } else if u < 0.375 {
        let t = u - 0.125;
        Sample { value: s1 + t * (v1 + 0.5 * a * t), first: v1 + a * t, second: a, third: 0.0 }
    } else {
        let t = u - 0.375;
        let (sin, cos) = (libm::sin(w * t), libm::cos(w * t));
        Sample {
            value: s2 + v2 * t + a / (w * w) * (1.0 - cos),
            first: v2 + a / w * sin,
            second: a * cos,
            third: -a * w * sin,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BETWEEN_DWELLS: [MotionLaw; 6] = [
        MotionLaw::Harmonic,
        MotionLaw::Cycloidal,
        MotionLaw::Polynomial345,
        MotionLaw::Polynomial4567,
        MotionLaw::ModifiedSine,
        MotionLaw::ModifiedTrapezoid,
    ];

    fn peak(law: MotionLaw, what: impl Fn(Sample) -> f64) -> f64 {
        (0..=80_000).map(|i| what(law.sample(f64::from(i) / 80_000.0)).abs()).fold(0.0, f64::max)
    }

    /// Peak velocity, acceleration and jerk in closed form.
    #[test]
    fn peak_factors_are_exact() {
        let sqrt = libm::sqrt;
        let closed = [
            (MotionLaw::Harmonic, PI / 2.0, PI * PI / 2.0, PI * PI * PI / 2.0),
            (MotionLaw::Cycloidal, 2.0, 2.0 * PI, 4.0 * PI * PI),
            (MotionLaw::Polynomial345, 1.875, 10.0 / sqrt(3.0), 60.0),
            (MotionLaw::Polynomial4567, 2.1875, 84.0 * sqrt(5.0) / 25.0, 52.5),
            (
                MotionLaw::ModifiedSine,
                4.0 * PI / (4.0 + PI),
                4.0 * PI * PI / (4.0 + PI),
                16.0 * PI * PI * PI / (4.0 + PI),
            ),
            (MotionLaw::ModifiedTrapezoid, 2.0, 8.0 * PI / (2.0 + PI), 32.0 * PI * PI / (2.0 + PI)),
        ];
        for (law, velocity, acceleration, jerk) in closed {
            assert!((peak(law, |s| s.first) - velocity).abs() < 1e-8, "{law:?}");
            assert!((peak(law, |s| s.second) - acceleration).abs() < 1e-6, "{law:?}");
            assert!((peak(law, |s| s.third) - jerk).abs() < 1e-5, "{law:?}");
        }
    }

    #[test]
    fn laws_rise_from_zero_to_one_and_rest_at_both_ends() {
        for law in BETWEEN_DWELLS {
            let (start, middle, end) = (law.sample(0.0), law.sample(0.5), law.sample(1.0));
            assert!(start.value.abs() < 1e-15 && (end.value - 1.0).abs() < 1e-15, "{law:?}");
            assert!(start.first.abs() < 1e-14 && end.first.abs() < 1e-14, "{law:?} {start:?} {end:?}");
            assert!((middle.value - 0.5).abs() < 1e-15, "{law:?}");
            if law != MotionLaw::Harmonic {
                assert!(start.second.abs() < 1e-13 && end.second.abs() < 1e-13, "{law:?} {end:?}");
            }
        }
    }

    /// Each derivative is the derivative of the one before, across the joints inside the laws too.
    #[test]
    fn derivatives_agree_with_differences() {
        let step = 1e-6;
        for law in BETWEEN_DWELLS {
            for i in 1..997 {
                let u = f64::from(i) / 997.0;
                let (left, mid, right) = (law.sample(u - step), law.sample(u), law.sample(u + step));
                assert!(((right.value - left.value) / (2.0 * step) - mid.first).abs() < 1e-8, "{law:?} {u}");
                assert!(((right.first - left.first) / (2.0 * step) - mid.second).abs() < 1e-4, "{law:?} {u}");
                assert!(((right.second - left.second) / (2.0 * step) - mid.third).abs() < 1e-3, "{law:?} {u}");
            }
        }
    }

    #[test]
    fn names_lead_back_to_their_laws() {
        for law in MotionLaw::ALL {
            assert_eq!(MotionLaw::from_name(law.name()), Some(law));
        }
        assert_eq!(MotionLaw::from_name("parabolic"), None);
    }
}
