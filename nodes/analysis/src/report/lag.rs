// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Path errors of the axes, and the resulting form error.
//!
//! The setpoints of the ticks are the path x(c). A place of X and C is off it by e = x − x(c): what of the lags of both axes moves the
//! tool across the path. A grinding wheel touches where its centre's path, x + W over θ, has its normal, which is turned by
//! η = atan(s′/s) from the wheel's line; along it the part keeps e·cos η.
//!
//! Encoders sit on the slides. What a slide carries swings, y¨ = ω²(x − y) + 2ζω(ẋ − ẏ), with the frequency and the damping that the
//! recorded machine description states; driven by the recorded x this gives where the tool was. What neither shows (wheel and part deflecting,
//! wear, warmth) is not in it.

use super::columns::Columns;
use super::motion::{MotionSample, RecordedMotion};
use super::text::um;
use camwright::machine::description::{Axis, MachineDescription, Structure};
use camwright::math::hermite::{cubic_path, cubic_slope};
use camwright::math::range::minimum_and_maximum;
use camwright::math::units::{deg_from_rad, wrap_turn};

/// Columns over a turn: a degree, so that at every speed in use some tick falls into each.
const TURN_COLUMNS: usize = 360;

/// Number of columns considered beside an empty one.
const NEAR_COLUMNS: u32 = 4;

/// Setpoints looked at before and behind a window, for what lags behind them (ticks).
pub(super) const MARGIN_TICKS: u64 = 300;

/// Setpoints on either side of a place that its slope is taken from.
const SLOPE_POINTS: usize = 4;

/// Share of the largest step of C in a tick below which C counts as standing: X over C is no path there.
const STANDING_SHARE: f64 = 0.02;

/// Steps within a tick in which a swing is followed: a fourteenth of a radian at 110 Hz and 1 ms.
const STEPS: u32 = 10;

#[derive(Debug, Clone)]
pub(super) struct Residual {
    /// Over the azimuth from where C is 0 (deg), along the normal (µm), positive where material is left; empty for an insert.
    pub(super) on_part: Columns,
    pub(super) lowest_um: f64,
    pub(super) highest_um: f64,
}

/// Form error by the axes.
#[derive(Debug, Clone)]
pub(super) struct Lag {
    /// Form error by the encoder readings: the drives alone.
    pub(super) encoders: Residual,
    /// Form error by the true tool positions, including the structures behind the encoders; `None` without structures in the machine's description.
    pub(super) tool: Option<Residual>,
}

/// Machine data in addition to its ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct CutContext<'a> {
    pub(super) description: Option<&'a MachineDescription>,
    pub(super) cycle_s: f64,
    pub(super) sense: f64,
    /// Radius of the wheel (m); none of an insert, whose normal is not that of a path.
    pub(super) wheel_m: Option<f64>,
    /// Centre of a crank pin, from where C is 0 (m); none of a lobe about the axis.
    pub(super) centre: Option<[f64; 2]>,
}

impl Lag {
    /// Form error of a cut's samples from `from` on; earlier samples let an oscillation settle.
    pub(super) fn from_motion(
        motion: &RecordedMotion,
        cut: &[MotionSample],
        from: u64,
        known: CutContext<'_>,
    ) -> Option<Self> {
        let path = Path::from_samples(motion, cut)?;
        let at = |sample: &MotionSample| [sample.position[0], sample.position[1]];
        let places = cut.iter().filter(|sample| sample.tick >= from).map(at);
        let encoders = Residual::from_path(&path, places, known)?;
        let structures =
            known.description.map(|description| [Axis::C, Axis::X].map(|axis| description.axis(axis).drive.structure));
        let tool = structures.filter(|both| both.iter().any(Option::is_some)).and_then(|[c, x]| {
            let swung = swung(cut, [c, x, None], known.cycle_s);
            let places = cut.iter().zip(swung).filter(|(sample, _)| sample.tick >= from);
            let places = places.map(|(_, [c, x, _])| [c, x]);
            Residual::from_path(&path, places, known)
        });
        Some(Self { encoders, tool })
    }

    /// All that is known: of the tool, or else of the encoders.
    pub(super) fn max(&self) -> &Residual {
        self.tool.as_ref().unwrap_or(&self.encoders)
    }
}

impl Residual {
    fn from_path(path: &Path, places: impl Iterator<Item = [f64; 2]>, known: CutContext<'_>) -> Option<Self> {
        let mut on_part = Columns::new(0.0, 360.0, TURN_COLUMNS);
        let mut all = Vec::new();
        for [c, at_x] in places {
            let Some((x, slope)) = path.at(c) else { continue };
            let Some(wheel) = known.wheel_m else {
                all.push(um(at_x - x));
                continue;
            };
            let centre = x + wheel;
            let (sin, cos) = (-known.sense * slope).atan2(centre).sin_cos();
            let off_um = um(at_x - x) * cos;
            // The contact lies a wheel's radius inwards from the centre.
            let mut contact = known.sense * c + (-wheel * sin).atan2(centre - wheel * cos);
            if let Some([x, y]) = known.centre {
                let reach = (wheel * sin).hypot(centre - wheel * cos);
                contact = (reach * contact.sin() - y).atan2(reach * contact.cos() - x);
            }
            on_part.add(deg_from_rad(wrap_turn(contact)), off_um);
            all.push(off_um);
        }
        let (lowest_um, highest_um) = minimum_and_maximum(all.iter().copied());
        (!all.is_empty()).then_some(Self { on_part, lowest_um, highest_um })
    }

    /// Form error at an azimuth (deg, µm).
    pub(super) fn at(&self, azimuth_deg: f64) -> Option<f64> {
        let width = 360.0 / TURN_COLUMNS as f64;
        let beside = |away: u32| {
            let by = f64::from(away) * width;
            let at = |azimuth: f64| self.on_part.middle_at(azimuth.rem_euclid(360.0));
            at(azimuth_deg + by).or_else(|| at(azimuth_deg - by))
        };
        (0..=NEAR_COLUMNS).find_map(beside)
    }
}

/// True positions of the loads of C, X and Z at each tick: encoder readings minus the oscillation of the structures, which starts at zero.
pub(super) fn swung(samples: &[MotionSample], structures: [Option<Structure>; 3], cycle_s: f64) -> Vec<[f64; 3]> {
    let mut places: Vec<[f64; 3]> = samples.iter().map(|sample| sample.position).collect();
    for (axis, structure) in structures.into_iter().enumerate() {
        let Some(Structure { frequency_rad_s: w, damping, .. }) = structure else { continue };
        let Some(first) = samples.first() else { continue };
        let (mut y, mut y_speed) = (first.position[axis], first.velocity[axis]);
        for (index, pair) in samples.windows(2).enumerate() {
            let ticks = (pair[1].tick - pair[0].tick).max(1);
            // A gap in the ticks longer than some periods leaves nothing of the swing before it.
            let steps = STEPS * u32::try_from(ticks).unwrap_or(1).min(100);
            let time = cycle_s * ticks as f64;
            let (step, way) = (time / f64::from(steps), pair[1].position[axis] - pair[0].position[axis]);
            // A slide that is taken to go straight from tick to tick is ahead by a T²/12 in the mean: a fifth of what swings at 250 Hz.
            let slopes = [index, index + 1].map(|at| speed_at(samples, at, axis) * ticks as f64);
            for number in 0..steps {
                // Where the slide is when the tool is at y: half a step beside would be a lead of its own.
                let share = f64::from(number) / f64::from(steps);
                let x = pair[0].position[axis] + cubic_path(share, way, slopes[0], slopes[1]);
                let speed = cubic_slope(share, way, slopes[0], slopes[1]) / time;
                y_speed += step * (w * w * (x - y) + 2.0 * damping * w * (speed - y_speed));
                y += step * y_speed;
            }
            places[index + 1][axis] = y;
        }
    }
    places
}

/// Speed of an axis at a sample, by those beside it (way per tick).
fn speed_at(samples: &[MotionSample], at: usize, axis: usize) -> f64 {
    let (before, after) = (&samples[at.saturating_sub(1)], &samples[(at + 1).min(samples.len() - 1)]);
    (after.position[axis] - before.position[axis]) / (after.tick - before.tick).max(1) as f64
}

/// Commanded X over C, with C increasing.
struct Path(Vec<(f64, f64)>);

impl Path {
    fn from_samples(motion: &RecordedMotion, samples: &[MotionSample]) -> Option<Self> {
        let (first, last) = (samples.first()?.tick, samples.last()?.tick);
        let range = first.saturating_sub(MARGIN_TICKS)..=last.saturating_add(MARGIN_TICKS);
        let setpoints: Vec<(u64, [f64; 3])> =
            motion.setpoints.range(range).map(|(tick, point)| (*tick, *point)).collect();
        let step = |pair: &[(u64, [f64; 3])]| pair[1].1[0] - pair[0].1[0];
        let (_, fastest) = minimum_and_maximum(setpoints.windows(2).map(step));
        let mut points: Vec<(f64, f64)> = Vec::new();
        let mut last_tick = 0;
        for pair in setpoints.windows(2).filter(|pair| step(pair) > STANDING_SHARE * fastest) {
            let (tick, [c, x, _]) = pair[0];
            if points.last().is_some_and(|(before, _)| c <= *before) {
                continue;
            }
            // Across a stand X is somewhere else for the same C.
            if !points.is_empty() && tick != last_tick + 1 {
                points.push((c, f64::NAN));
            }
            points.push((c, x));
            last_tick = tick;
        }
        (points.len() > 2 * SLOPE_POINTS).then_some(Self(points))
    }

    /// X there and its slope; none beyond the ends.
    fn at(&self, c: f64) -> Option<(f64, f64)> {
        let points = &self.0;
        let next = points.partition_point(|point| point.0 < c);
        let (before, after) = (points.get(next.checked_sub(1)?)?, points.get(next)?);
        let x = before.1 + (after.1 - before.1) * (c - before.0) / (after.0 - before.0);
        let left = points.get(next.saturating_sub(SLOPE_POINTS))?;
        let right = points.get((next + SLOPE_POINTS).min(points.len() - 1))?;
        Some((x, (right.1 - left.1) / (right.0 - left.0))).filter(|(x, slope)| x.is_finite() && slope.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// A wheel on an eccentric disc, 2 µm behind everywhere: what it leaves is 2 µm times the cosine of the normal, by the closed form
    /// of the disc, at the azimuths where its contact lies.
    #[test]
    fn what_is_left_lies_along_the_normal_at_the_contact() {
        let (radius, eccentric, wheel) = (0.02_f64, 0.003_f64, 0.06_f64);
        let x =
            |c: f64| eccentric * c.cos() + ((radius + wheel).powi(2) - (eccentric * c.sin()).powi(2)).sqrt() - wheel;
        let setpoints: BTreeMap<u64, [f64; 3]> =
            (0..2000_u32).map(|i| (u64::from(i), [f64::from(i) * 0.004, x(f64::from(i) * 0.004), 0.0])).collect();
        let samples: Vec<MotionSample> = (200..1700_u32)
            .map(|i| {
                let c = f64::from(i) * 0.004;
                MotionSample {
                    tick: u64::from(i),
                    position: [c, x(c) + 2e-6, 0.0],
                    velocity: [4.0, 0.0, 0.0],
                    force_x_n: 0.0,
                }
            })
            .collect();
        let motion = RecordedMotion::made_of(&samples, setpoints);
        let known = CutContext { description: None, cycle_s: 0.001, sense: 1.0, wheel_m: Some(wheel), centre: None };
        let lag = Lag::from_motion(&motion, &samples, 0, known).expect("a lag");
        assert!(lag.tool.is_none(), "nothing is known of a structure");
        for c in [0.5_f64, 1.5, 2.5, 4.0, 5.5] {
            // The normal goes through the disc's centre.
            let centre = [x(c) + wheel, c];
            let from_disc = [centre[0] * centre[1].cos() - eccentric, centre[0] * centre[1].sin()];
            let normal = from_disc[1].atan2(from_disc[0]);
            let contact = [eccentric + radius * normal.cos(), radius * normal.sin()];
            let azimuth = deg_from_rad(wrap_turn(contact[1].atan2(contact[0])));
            let expected = 2.0 * (normal - c).cos();
            let found = lag.encoders.at(azimuth).expect("a whole turn of samples");
            assert!((found - expected).abs() < 1e-3, "{c}: {found} instead of {expected}");
        }
        assert!(lag.encoders.lowest_um > 1.99 && lag.encoders.highest_um < 2.0 + 1e-6, "{lag:?}");
    }

    /// Of a crank pin the error lies at the azimuth about the pin's own centre, by the triangle of axis, pin and wheel.
    #[test]
    fn what_is_left_of_a_pin_lies_about_its_centre() {
        let (radius, throw, wheel, at) = (0.025_f64, 0.04_f64, 0.25_f64, 0.7_f64);
        let length = radius + wheel;
        let x = |c: f64| {
            let (sin, cos) = (c - at).sin_cos();
            throw * cos + (length * length - (throw * sin).powi(2)).sqrt() - wheel
        };
        let setpoints: BTreeMap<u64, [f64; 3]> =
            (0..2000_u32).map(|i| (u64::from(i), [f64::from(i) * 0.004, x(f64::from(i) * 0.004), 0.0])).collect();
        let sample = |i: u32| {
            let c = f64::from(i) * 0.004;
            let position = [c, x(c) + 2e-6 * c, 0.0];
            MotionSample { tick: u64::from(i), position, velocity: [4.0, 0.0, 0.0], force_x_n: 0.0 }
        };
        let samples: Vec<MotionSample> = (200..1700_u32).map(sample).collect();
        let motion = RecordedMotion::made_of(&samples, setpoints);
        let centre = Some([throw * at.cos(), throw * at.sin()]);
        let known = CutContext { description: None, cycle_s: 0.001, sense: 1.0, wheel_m: Some(wheel), centre };
        let lag = Lag::from_motion(&motion, &samples, 0, known).expect("a lag");
        for c in [1.2_f64, 2.5, 4.0, 5.5] {
            let beta = -(throw * (c - at).sin() / length).asin();
            // C past a turn comes by once more, between 0.8 and 6.8 rad: once at these.
            let azimuth = deg_from_rad(wrap_turn(c - beta));
            let found = lag.encoders.at(azimuth).expect("a whole turn of samples");
            let expected = 2.0 * c * beta.cos();
            assert!((found - expected).abs() < 0.03, "{c}: {found} instead of {expected}");
        }
    }

    /// X comes from far while C stands, cuts, and goes away while C stands again: neither is what the axes are off by in the cut.
    #[test]
    fn where_c_stands_x_is_off_no_path() {
        let c = |tick: u32| f64::from(tick.clamp(100, 900) - 100) * 0.01;
        let x = |tick: u32| if (100..=900).contains(&tick) { 0.02 } else { 0.031 };
        let setpoints: BTreeMap<u64, [f64; 3]> =
            (0..1000).map(|tick| (u64::from(tick), [c(tick), x(tick), 0.0])).collect();
        let samples: Vec<MotionSample> = (90..=910)
            .map(|tick| MotionSample {
                tick: u64::from(tick),
                position: [c(tick) + 1e-4, 0.02 + 3e-6, 0.0],
                velocity: [0.0; 3],
                force_x_n: 0.0,
            })
            .collect();
        let motion = RecordedMotion::made_of(&samples, setpoints);
        let known = CutContext { description: None, cycle_s: 0.001, sense: 1.0, wheel_m: None, centre: None };
        let lag = Lag::from_motion(&motion, &samples, 0, known).expect("a lag");
        let Residual { lowest_um, highest_um, .. } = lag.encoders;
        assert!((lowest_um - 3.0).abs() < 1e-6 && (highest_um - 3.0).abs() < 1e-6, "{lowest_um} to {highest_um} um");
    }

    /// A slide that is accelerated evenly: what it carries hangs back by a/ω² once the swing has died down.
    #[test]
    fn what_a_slide_carries_hangs_back_by_its_acceleration() {
        let (acceleration, w) = (3.0_f64, 110.0 * camwright::math::units::TURN_RAD);
        let samples: Vec<MotionSample> = (0..1000_u32)
            .map(|i| {
                let t = f64::from(i) * 1e-3;
                let place = 0.5 * acceleration * t * t;
                MotionSample {
                    tick: u64::from(i),
                    position: [0.0, place, 0.0],
                    velocity: [0.0, acceleration * t, 0.0],
                    force_x_n: 0.0,
                }
            })
            .collect();
        let structure = Structure { frequency_rad_s: w, damping: 0.1, mass_share: 0.2 };
        let swung = swung(&samples, [None, Some(structure), None], 1e-3);
        let behind = um(samples[999].position[1] - swung[999][1]);
        let expected = um(acceleration / (w * w));
        assert!((behind - expected).abs() < 0.02 * expected, "{behind} instead of {expected}");
    }
}
