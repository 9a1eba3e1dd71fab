// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which tick the insert's edge made a place of a turned part in, and what of the deviation there each axis left.
//!
//! A place is a cell of the part's grid: azimuth φ and z'. With the axes at C, X and Z the edge's point at z' is at
//! xₑ = X − √(R² − (z' − Z)²), the rake face at the height H; it passes the azimuth where σ·C + atan2(H, xₑ) = φ and leaves the radius
//! √(xₑ² + H²) there. Of all turns that come by, the one that leaves the least made the place.
//!
//! What an axis left is found by letting the edge come by once more in that turn, on the setpoints of the other two axes and where this one was
//! by its encoder: an X that stands off moves the edge; a C that lags passes the azimuth later, when X follows another place of a flank; a Z that
//! lags has the round edge at another height there. On the setpoints of all three it leaves the cusp of the feed. All along the normal of
//! the design, as the form is judged; together they are the sum to first order, and what is missing from it is in the rest.

use super::lag::{MARGIN_TICKS, swung};
use super::motion::{MotionSample, RecordedMotion};
use camwright::cam::surface::SurfacePoint;
use camwright::machine::description::{Axis, InsertDescription, MachineDescription, Structure};
use camwright::math::units::{TURN_RAD, um_from_mm, wrap_turn};
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::msg::TurnedResult;
use camwright_planning::PreparedTurning;
use std::f64::consts::PI;

/// Ticks on either side of a passing in which the edge passes with an axis elsewhere.
const NEAR_TICKS: u64 = 25;

/// Halvings of a tick: below the rounding of its time.
const HALVINGS: u32 = 40;

/// An edge farther from the azimuth than this does not pass it within a tick (rad).
const NEAR_RAD: f64 = 1.0;

/// Weights of six ticks at the middle two's share `u`, by Lagrange's formula.
fn weights(u: f64) -> [f64; 6] {
    let at = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    std::array::from_fn(|i| {
        let others = (0..at.len()).filter(|j| *j != i);
        others.map(|j| (u - at[j]) / (at[i] - at[j])).product()
    })
}

/// Positions of the axes, tick by tick: C, X, Z (rad, mm, mm along the part); NaN where they are not recorded.
#[derive(Debug, Clone)]
pub(super) struct AxisTrack {
    first: u64,
    points: Vec<[f64; 3]>,
}

impl AxisTrack {
    fn from_positions(first: u64, last: u64, places: impl Iterator<Item = (u64, [f64; 3])>, zero_mm: f64) -> Self {
        let count = usize::try_from(last.saturating_sub(first)).map_or(0, |ticks| ticks.saturating_add(1));
        let mut points = vec![[f64::NAN; 3]; count];
        for (tick, [c, x, z]) in places {
            let index = tick.checked_sub(first).and_then(|index| usize::try_from(index).ok());
            if let Some(point) = index.and_then(|index| points.get_mut(index)) {
                *point = [c, mm_from_m(x), mm_from_m(z) + zero_mm];
            }
        }
        Self { first, points }
    }

    /// Between ticks by the quintic through six of them: a tick is a millimetre of way, and X is accelerated by µm in it.
    fn at(&self, time: f64) -> Option<[f64; 3]> {
        let whole = time.floor();
        #[allow(clippy::cast_possible_truncation, reason = "ticks; get() refuses what is none")]
        let start = (whole as u64).checked_sub(self.first)?.checked_sub(2)?;
        let start = usize::try_from(start).ok()?;
        let six = self.points.get(start..start.checked_add(6)?)?;
        let weights = weights(time - whole);
        let axis = |axis: usize| six.iter().zip(weights).map(|(point, weight)| point[axis] * weight).sum();
        let found: [f64; 3] = std::array::from_fn(axis);
        found.iter().all(|value: &f64| value.is_finite()).then_some(found)
    }
}

/// A place of the surface, and the design there.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgePosition {
    pub(super) azimuth_rad: f64,
    pub(super) z_mm: f64,
    pub(super) design: SurfacePoint,
}

impl EdgePosition {
    /// Height of a radius above the design, along its normal (µm).
    fn above_um(&self, radius_mm: f64) -> f64 {
        let across = self.design.by_azimuth / self.design.radius_mm;
        um_from_mm((radius_mm - self.design.radius_mm) / (1.0 + across * across + self.design.by_z.powi(2)).sqrt())
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct CuttingEdge {
    pub(super) radius_mm: f64,
    pub(super) height_mm: f64,
    /// +1 where the part turns clockwise with a positive C.
    pub(super) sense: f64,
}

/// The edge comes by.
#[derive(Debug, Clone, Copy)]
struct EdgePassage {
    time: f64,
    radius_mm: f64,
}

impl CuttingEdge {
    /// x of the edge's point at the place's column (mm).
    fn x_mm(&self, place: &EdgePosition, [_, x, z]: [f64; 3]) -> Option<f64> {
        let under = self.radius_mm.powi(2) - (place.z_mm - z).powi(2);
        (under >= 0.0).then(|| x - under.sqrt()).filter(|x| *x > 0.0)
    }

    /// Angle of that point from the position's azimuth, −π to π.
    fn short_of(&self, place: &EdgePosition, at: [f64; 3]) -> Option<f64> {
        let azimuth = self.sense * at[0] + self.height_mm.atan2(self.x_mm(place, at)?);
        Some(wrap_turn(place.azimuth_rad - azimuth + PI) - PI)
    }

    /// Crossing of the azimuth by the edge between two ticks.
    fn passing(&self, place: &EdgePosition, tick: u64, at: &impl Fn(f64) -> Option<[f64; 3]>) -> Option<EdgePassage> {
        let (mut from, mut to) = (tick as f64, tick as f64 + 1.0);
        let short = |time: f64| self.short_of(place, at(time)?);
        let (before, after) = (short(from)?, short(to)?);
        if (before < 0.0) == (after < 0.0) || before.abs().max(after.abs()) > NEAR_RAD {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            *(if (short(middle)? < 0.0) == (before < 0.0) { &mut from } else { &mut to }) = middle;
        }
        let time = 0.5 * (from + to);
        Some(EdgePassage { time, radius_mm: self.x_mm(place, at(time)?)?.hypot(self.height_mm) })
    }

    /// The passing that leaves least of all.
    fn min(&self, place: &EdgePosition, track: &AxisTrack) -> Option<EdgePassage> {
        let ticks = track.first..track.first.saturating_add(track.points.len() as u64);
        let all = ticks.filter_map(|tick| self.passing(place, tick, &|time| track.at(time)));
        all.min_by(|a, b| a.radius_mm.total_cmp(&b.radius_mm))
    }

    /// The passing nearest to a time, with the axes elsewhere.
    fn near(&self, place: &EdgePosition, time: f64, at: impl Fn(f64) -> Option<[f64; 3]>) -> Option<EdgePassage> {
        #[allow(clippy::cast_possible_truncation, reason = "a tick of a track")]
        let tick = time.floor() as u64;
        let ticks = tick.saturating_sub(NEAR_TICKS)..=tick.saturating_add(NEAR_TICKS);
        let all = ticks.filter_map(|tick| self.passing(place, tick, &at));
        all.min_by(|a, b| (a.time - time).abs().total_cmp(&(b.time - time).abs()))
    }
}

/// Error of an axis as the edge passed, and the resulting form error along the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisShare {
    pub(super) axis: Axis,
    /// Encoder less setpoint at that time (rad or mm).
    pub(super) lag: f64,
    pub(super) lag_um: f64,
    /// Tool or part less encoder, by the swing of the structure (rad or mm); none where the machine's description has none.
    pub(super) swing: Option<f64>,
    pub(super) swing_um: f64,
}

/// The deviation at a place, by what left it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ErrorSplit {
    /// The tick in which the edge came by, and where the axes were by their encoders (rad, mm along the part).
    pub(super) tick: u64,
    pub(super) position: [f64; 3],
    pub(super) axes: [AxisShare; 3],
    /// Form error of the setpoints there (µm): the cusp of the feed.
    pub(super) cusp_um: f64,
    /// Unexplained remainder (µm).
    pub(super) rest_um: f64,
    pub(super) error_um: f64,
}

impl ErrorSplit {
    /// Form error by the lags of all axes (µm).
    pub(super) fn lag_um(&self) -> f64 {
        self.axes.iter().map(|axis| axis.lag_um).sum()
    }

    /// Form error by the oscillation of all structures (µm).
    pub(super) fn swing_um(&self) -> f64 {
        self.axes.iter().map(|axis| axis.swing_um).sum()
    }

    pub(super) fn has_swing(&self) -> bool {
        self.axes.iter().any(|axis| axis.swing.is_some())
    }
}

/// Tracks of a pass: setpoints, encoder readings, and true positions of tool and part.
#[derive(Debug, Clone)]
pub(super) struct Tracks {
    setpoints: AxisTrack,
    encoders: AxisTrack,
    tool: Option<AxisTrack>,
    has_structure: [bool; 3],
}

impl Tracks {
    /// Builds the tracks of a pass from its ticks; `zero_mm` is the position of the insert along the part with Z at 0.
    pub(super) fn from_recording(
        motion: &RecordedMotion,
        pass: &[MotionSample],
        behind: [Option<Structure>; 3],
        cycle_s: f64,
        zero_mm: f64,
    ) -> Option<Self> {
        let (first, last) = (pass.first()?.tick, pass.last()?.tick);
        let (from, to) = (first.saturating_sub(MARGIN_TICKS), last.saturating_add(MARGIN_TICKS));
        let setpoints = motion.setpoints.range(from..=to).map(|(tick, place)| (*tick, *place));
        let swing = behind.iter().any(Option::is_some).then(|| swung(pass, behind, cycle_s));
        let ticks = || pass.iter().map(|sample| sample.tick);
        Some(Self {
            setpoints: AxisTrack::from_positions(from, to, setpoints, zero_mm),
            encoders: AxisTrack::from_positions(
                first,
                last,
                pass.iter().map(|sample| (sample.tick, sample.position)),
                zero_mm,
            ),
            tool: swing.map(|places| AxisTrack::from_positions(first, last, ticks().zip(places), zero_mm)),
            has_structure: behind.map(|structure| structure.is_some()),
        })
    }

    /// Splits the deviation of a position by cause.
    ///
    /// # Errors
    /// Why that is not known, as the end of a sentence.
    pub(super) fn split(&self, edge: CuttingEdge, place: &EdgePosition, error_um: f64) -> Result<ErrorSplit, String> {
        let made = edge.min(place, self.tool.as_ref().unwrap_or(&self.encoders));
        let made = made.ok_or("the insert's edge does not come by there in the recorded ticks of the last pass")?;
        let missing = || String::from("setpoints or samples about the tick that made it are not in the bag");
        // One axis from another track than the others.
        let left = |tracks: [&AxisTrack; 3]| {
            let at = |time: f64| {
                let mut found = [0.0; 3];
                for (axis, track) in tracks.into_iter().enumerate() {
                    found[axis] = track.at(time)?[axis];
                }
                Some(found)
            };
            edge.near(place, made.time, at).map(|passing| place.above_um(passing.radius_mm)).ok_or_else(missing)
        };
        let places = |track: &AxisTrack| track.at(made.time).ok_or_else(missing);
        let (setpoints, encoders) = (places(&self.setpoints)?, places(&self.encoders)?);
        let cusp_um = left([&self.setpoints; 3])?;
        let with_encoders = left([&self.encoders; 3])?;
        let mut axes = [Axis::C, Axis::X, Axis::Z].map(|axis| AxisShare {
            axis,
            lag: 0.0,
            lag_um: 0.0,
            swing: None,
            swing_um: 0.0,
        });
        for (index, axis) in axes.iter_mut().enumerate() {
            let mut tracks = [&self.setpoints; 3];
            tracks[index] = &self.encoders;
            (axis.lag, axis.lag_um) = (encoders[index] - setpoints[index], left(tracks)? - cusp_um);
            if let Some(tool) = self.tool.as_ref().filter(|_| self.has_structure[index]) {
                let mut tracks = [&self.encoders; 3];
                tracks[index] = tool;
                axis.swing = Some(places(tool)?[index] - encoders[index]);
                axis.swing_um = left(tracks)? - with_encoders;
            }
        }
        let known: f64 = axes.iter().map(|axis| axis.lag_um + axis.swing_um).sum();
        #[allow(clippy::cast_possible_truncation, reason = "a tick of a track")]
        let tick = made.time.round() as u64;
        Ok(ErrorSplit { tick, position: encoders, axes, cusp_um, rest_um: error_um - cusp_um - known, error_um })
    }
}

/// Causes at the worst position of a turned part.
///
/// # Errors
/// Why that is not known, as the end of a sentence.
pub(super) fn worst(
    prepared: &PreparedTurning,
    result: &TurnedResult,
    motion: &RecordedMotion,
    pass: &[MotionSample],
) -> Result<ErrorSplit, String> {
    let machine: &MachineDescription = &prepared.machine;
    let InsertDescription { radius_mm, height_mm, .. } =
        machine.insert.ok_or("the recorded machine turns with no insert")?;
    let spec = &prepared.job.spec;
    let (azimuth_rad, z_mm) = (wrap_turn(result.form_error_max_azimuth), mm_from_m(result.form_error_max_z));
    let place = EdgePosition { azimuth_rad, z_mm, design: spec.surface.point(azimuth_rad, z_mm) };
    let behind = [Axis::C, Axis::X, Axis::Z].map(|axis| machine.axis(axis).drive.structure);
    let tracks = Tracks::from_recording(motion, pass, behind, machine.cycle_time_s(), spec.part_zero_mm)
        .ok_or("the ticks of the last pass are not in the bag")?;
    let edge = CuttingEdge { radius_mm, height_mm, sense: f64::from(machine.rotation_sense) };
    tracks.split(edge, &place, um_from_mm(mm_from_m(result.form_error_max)))
}

/// Turns of C from the first sample of a pass to a place of it.
pub(super) fn turns_since(pass: &[MotionSample], c_rad: f64) -> Option<f64> {
    Some((c_rad - pass.first()?.position[0]).abs() / TURN_RAD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_files::convert::m_from_mm;
    use std::collections::BTreeMap;

    const R: f64 = 8.0;
    const ZERO_MM: f64 = 2.0;
    const SPEED: f64 = 0.03;
    const FEED: f64 = 0.3;

    /// A pass of some turns over x(θ, z) (mm), the section at a turned angle and the place of the insert's centre, and the axes off it.
    struct SurfacePass<'a> {
        sense: f64,
        x_mm: &'a dyn Fn(f64, f64) -> f64,
        off: [f64; 3],
    }

    fn z_mm(time: f64) -> f64 {
        10.0 + FEED * SPEED * time / TURN_RAD
    }

    impl SurfacePass<'_> {
        fn at(&self, tick: u32) -> [f64; 3] {
            let (time, turned) = (f64::from(tick), SPEED * f64::from(tick));
            let (x, z) = ((self.x_mm)(turned, z_mm(time)), z_mm(time) - ZERO_MM);
            [self.sense * turned, m_from_mm(x), m_from_mm(z)]
        }

        fn split(&self, height_mm: f64, place: &EdgePosition, error_um: f64) -> ErrorSplit {
            let setpoints: BTreeMap<u64, [f64; 3]> = (0..1300).map(|tick| (u64::from(tick), self.at(tick))).collect();
            let sample = |tick: u32| {
                let [c, x, z] = self.at(tick);
                let position = [c + self.off[0], x + m_from_mm(self.off[1]), z + m_from_mm(self.off[2])];
                MotionSample { tick: u64::from(tick), position, velocity: [0.0; 3], force_x_n: 0.0 }
            };
            let samples: Vec<MotionSample> = (20..1280).map(sample).collect();
            let motion = RecordedMotion::made_of(&samples, setpoints);
            let tracks = Tracks::from_recording(&motion, &samples, [None; 3], 1e-3, ZERO_MM).expect("there are ticks");
            let edge = CuttingEdge { radius_mm: R, height_mm, sense: self.sense };
            tracks.split(edge, place, error_um).expect("the edge comes by")
        }
    }

    /// C, X, Z, the cusp and the rest are these (µm).
    fn is(split: &ErrorSplit, axes: [f64; 3], cusp: f64, within: f64) {
        let found = split.axes.map(|axis| axis.lag_um);
        let near = |a: f64, b: f64| (a - b).abs() <= within;
        assert!(found.iter().zip(axes).all(|(a, b)| near(*a, b)), "{split:?}");
        assert!(near(split.cusp_um, cusp) && near(split.rest_um, 0.0), "{split:?}");
        let sum = split.lag_um() + split.swing_um() + split.cusp_um + split.rest_um;
        assert!((sum - split.error_um).abs() < 1e-9, "{split:?}");
    }

    fn cylinder(radius_mm: f64) -> SurfacePoint {
        SurfacePoint { radius_mm, ..SurfacePoint::default() }
    }

    /// X stands 3 µm off on a cylinder of 20 mm, the rake face 14 mm below the axis: the edge then stands √((xₑ + 3 µm)² + H²) off the axis.
    #[test]
    fn an_axis_x_that_is_off_leaves_that_on_the_radius() {
        let (radius, height) = (20.0_f64, -14.0_f64);
        let edge = (radius * radius - height * height).sqrt();
        let expected = um_from_mm((edge + 0.003).hypot(height) - radius);
        for sense in [1.0, -1.0] {
            let pass = SurfacePass { sense, x_mm: &|_, _| edge + R, off: [0.0, 0.003, 0.0] };
            // The insert's centre stands at the place as the edge comes by in the third turn.
            let turned = 2.2 + 2.0 * TURN_RAD;
            let azimuth_rad = wrap_turn(turned + height.atan2(edge));
            let place = EdgePosition { azimuth_rad, z_mm: z_mm(turned / SPEED), design: cylinder(radius) };
            let split = pass.split(height, &place, expected);
            is(&split, [0.0, expected, 0.0], 0.0, 1e-4);
            assert!((um_from_mm(split.axes[1].lag) - 3.0).abs() < 1e-6, "{split:?}");
            assert!(split.tick.abs_diff(492) <= 1, "2.2 rad and two turns at 0.03 rad a tick: {split:?}");
        }
    }

    /// C lags on the flank of r = 20 + 2 sin φ: what X has gone on meanwhile, slope times lag along the normal.
    #[test]
    fn an_axis_c_that_lags_leaves_slope_times_lag_on_a_flank() {
        let (amplitude, lag) = (2.0, 2e-4);
        for (sense, azimuth_rad) in [(1.0, 0.4_f64), (-1.0, 0.4), (1.0, 2.6)] {
            let pass = SurfacePass {
                sense,
                x_mm: &|turned, _| 20.0 + amplitude * turned.sin() + R,
                off: [-sense * lag, 0.0, 0.0],
            };
            let (radius_mm, by_azimuth) = (20.0 + amplitude * azimuth_rad.sin(), amplitude * azimuth_rad.cos());
            let design = SurfacePoint { radius_mm, by_azimuth, ..SurfacePoint::default() };
            let place = EdgePosition { azimuth_rad, z_mm: z_mm((azimuth_rad + TURN_RAD) / SPEED), design };
            let expected = um_from_mm(by_azimuth * lag) / (1.0 + (by_azimuth / radius_mm).powi(2)).sqrt();
            is(&pass.split(0.0, &place, expected), [expected, 0.0, 0.0], 0.0, 2e-3);
        }
    }

    /// Z off on a cone of slope k: what the cone is lower there, −k times the way, along the normal.
    #[test]
    fn an_axis_z_that_is_off_leaves_slope_times_way_on_a_cone() {
        let (slope, off) = (0.3_f64, 0.004);
        let normal = slope.atan();
        // The contact lies R sin τ farther on than the centre.
        let x_mm = |_: f64, z: f64| 20.0 + slope * (z + R * normal.sin()) + R * normal.cos();
        let pass = SurfacePass { sense: 1.0, x_mm: &x_mm, off: [0.0, 0.0, off] };
        let z_mm = z_mm((1.0 + 2.0 * TURN_RAD) / SPEED) + R * normal.sin();
        let design = SurfacePoint { radius_mm: 20.0 + slope * z_mm, by_z: slope, ..SurfacePoint::default() };
        let expected = -um_from_mm(slope * off) * normal.cos();
        let split = pass.split(0.0, &EdgePosition { azimuth_rad: 1.0, z_mm, design }, expected);
        is(&split, [0.0, 0.0, expected], 0.0, 5e-3);
    }

    /// Midway between two turns on a cylinder the edge leaves f²/8R.
    #[test]
    fn a_pass_without_lag_leaves_the_cusp_of_its_feed() {
        let pass = SurfacePass { sense: 1.0, x_mm: &|_, _| 20.0 + R, off: [0.0; 3] };
        let middle = z_mm((1.0 + 2.5 * TURN_RAD) / SPEED);
        let expected = um_from_mm(FEED * FEED / (8.0 * R));
        let place = EdgePosition { azimuth_rad: 1.0, z_mm: middle, design: cylinder(20.0) };
        is(&pass.split(0.0, &place, expected), [0.0; 3], expected, 1e-3);
    }

    #[test]
    fn unreached_positions_and_missing_setpoints_are_reported() {
        let pass = SurfacePass { sense: 1.0, x_mm: &|_, _| 20.0 + R, off: [0.0; 3] };
        let samples: Vec<MotionSample> = (20..1280_u32)
            .map(|tick| MotionSample {
                tick: u64::from(tick),
                position: pass.at(tick),
                velocity: [0.0; 3],
                force_x_n: 0.0,
            })
            .collect();
        let motion = RecordedMotion::made_of(&samples, BTreeMap::new());
        let tracks = Tracks::from_recording(&motion, &samples, [None; 3], 1e-3, ZERO_MM).expect("there are ticks");
        let edge = CuttingEdge { radius_mm: R, height_mm: 0.0, sense: 1.0 };
        let split =
            |z_mm: f64| tracks.split(edge, &EdgePosition { azimuth_rad: 1.0, z_mm, design: cylinder(20.0) }, 1.0);
        let error_at = |z_mm: f64| split(z_mm).expect_err("it is not known");
        assert!(error_at(60.0).contains("does not come by"), "{}", error_at(60.0));
        assert!(error_at(10.5).contains("setpoints or samples"), "{}", error_at(10.5));
    }
}
