// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs of grooves over several turns, forwards: the mill of the written blocks against the walls of the follower, in closed form.

#![allow(clippy::cast_possible_truncation, reason = "counts of steps and whole degrees")]
#![allow(clippy::print_stdout, reason = "figures, with --nocapture")]

use crate::support;

use camwright::gcode::{Dialect, MotionAction, NcAxis, ProgramFile, XValues, read};
use camwright::math::units::{TURN_RAD, mm_from_um, rad_from_deg, um_from_mm};
use camwright_planning::{ProgramSummary, write_program};
use std::f64::consts::PI;

/// The mill on its way: azimuth on the part, X of its end, Y and Z.
type MillPlace = [f64; 4];

/// Places of the mill by whole degrees of the part.
struct Sweep {
    degrees: Vec<Vec<MillPlace>>,
    cutter_mm: f64,
}

/// Steps of C between blocks (rad).
const STEP_RAD: f64 = 0.1 * PI / 180.0;

impl Sweep {
    /// Feeds of the written program, as a control makes them: all axes in proportion to C.
    fn from_program(text: String, sense: f64, cutter_mm: f64) -> Self {
        let files = [ProgramFile { name: "groove.ngc".into(), text }];
        let motion = read(Dialect::LinuxCnc, XValues::Radius, &files).expect("a program");
        let mut degrees = vec![Vec::new(); 360];
        let mut before: Option<MillPlace> = None;
        for done in &motion.done {
            let (pose, feeds) = match done.action {
                MotionAction::Feed { pose, .. } => (pose, true),
                MotionAction::Rapid(pose) => (pose, false),
                _ => continue,
            };
            let at = |axis| pose.position(axis).unwrap_or(0.0);
            let to = [sense * at(NcAxis::C), at(NcAxis::X), at(NcAxis::Y), at(NcAxis::Z)];
            if let Some(from) = before.filter(|_| feeds) {
                let count = ((to[0] - from[0]).abs() / STEP_RAD).ceil().max(1.0);
                for step in 0..=count as u32 {
                    let share = f64::from(step) / count;
                    let place: MillPlace = std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]));
                    degrees[(place[0].to_degrees().rem_euclid(360.0) as usize).min(359)].push(place);
                }
            }
            before = Some(to);
        }
        Self { degrees, cutter_mm }
    }

    /// Material that the whole program leaves at a place of the part (mm), negative where it cuts into the wall. The place is in the frame of
    /// the carriage at an azimuth.
    fn left_mm(&self, azimuth: f64, [x, y, z]: [f64; 3], window_deg: f64) -> f64 {
        let degree = azimuth.to_degrees();
        let (from, to) = ((degree - window_deg).floor() as i64, (degree + window_deg).ceil() as i64);
        let near = (from..=to).flat_map(|degree| &self.degrees[degree.rem_euclid(360) as usize]);
        near.fold(f64::INFINITY, |least, mill| {
            let (sin, cos) = (mill[0] - azimuth).sin_cos();
            let (depth, beside) = (x * cos + y * sin, y * cos - x * sin);
            if depth < mill[1] - 1e-9 {
                return least;
            }
            least.min((beside - mill[2]).hypot(z - mill[3]) - self.cutter_mm)
        })
    }
}

/// A place of the wall that a roller makes at x along its axis.
fn wall(centre: &dyn Fn(f64) -> [f64; 2], roller_mm: f64, side: f64, azimuth: f64, x: f64) -> [f64; 3] {
    const STEP: f64 = 1e-5;
    let ([y, z], [y0, z0], [y1, z1]) = (centre(azimuth), centre(azimuth - STEP), centre(azimuth + STEP));
    let (across, along) = (x + (y1 - y0) / (2.0 * STEP), (z1 - z0) / (2.0 * STEP));
    let length = across.hypot(along);
    [x, y - side * roller_mm * along / length, z + side * roller_mm * across / length]
}

fn program(job: &str, set: &[&str], sense: f64, cutter_mm: f64) -> (Sweep, ProgramSummary) {
    let folder = support::Folder::new("groove-walls");
    let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
    let summary = write_program(job, &set, folder.path(), |_| {}).unwrap_or_else(|error| panic!("{job}: {error}"));
    let text = std::fs::read_to_string(folder.join(&summary.files[0])).expect("a program");
    (Sweep::from_program(text, sense, cutter_mm), summary)
}

/// The largest and the smallest error of a wall by the note of the program (µm), as printed.
fn noted_um(summary: &ProgramSummary, wall: &str) -> (f64, f64) {
    let note = summary.notes.iter().find(|note| note.contains(wall)).expect("a note on the wall");
    let words: Vec<&str> = note.split_whitespace().collect();
    let before_um = words.windows(2).filter(|pair| pair[1] == "um").map(|pair| pair[0].parse().expect("a number"));
    let um: Vec<f64> = before_um.collect();
    (um[0], um[1])
}

/// Each turn indexes a turret by 30 deg by the cycloid: every wall of every station and of the dwells, from face to face, at three depths.
#[test]
fn the_program_of_an_indexer_makes_the_walls_of_its_rollers() {
    let centre = |azimuth: f64| {
        let turns = (azimuth / TURN_RAD).clamp(0.0, 3.0 - 1e-12);
        let u = ((turns.fract() - 0.25) * 2.0).clamp(0.0, 1.0);
        let angle = rad_from_deg(-45.0 + 30.0 * (turns.floor() + u - (TURN_RAD * u).sin() / TURN_RAD));
        [76.0 - 80.0 * angle.cos(), 50.0 + 80.0 * angle.sin()]
    };
    let cycloid = "grooves.I.lift.segments.1.law=cycloidal";
    let shipped: &[&str] = &[cycloid];
    let like_roller: &[&str] =
        &[cycloid, "tool.radius_mm=8", "passes.0.leaves_mm=0", "passes.0.tolerance_um=1", "nc.rotation_sense=-1"];
    for (set, sense, cutter_mm) in [(shipped, 1.0, 6.0), (like_roller, -1.0, 8.0)] {
        let (sweep, summary) = program("barrel_indexer", set, sense, cutter_mm);
        // The program may be off along Y and along Z.
        let off_um = 1.5 * 1.0 + 0.3;
        for (side, name) in [(-1.0, "wall towards -Z"), (1.0, "wall towards +Z")] {
            let (high_um, low_um) = if cutter_mm < 8.0 { noted_um(&summary, name) } else { (0.0, 0.0) };
            let (mut high, mut low, mut places) = (f64::NEG_INFINITY, f64::INFINITY, 0);
            for azimuth in (0..540).map(|step| rad_from_deg(2.0 * f64::from(step) + 0.7)) {
                for x in [45.2, 50.0, 55.0] {
                    let place = wall(&centre, 8.0, side, azimuth, x);
                    // Walls of the cylinder only.
                    if !(18.0..=82.0).contains(&place[2]) || place[0].hypot(place[1]) > 60.0 {
                        continue;
                    }
                    let left_um = um_from_mm(sweep.left_mm(azimuth, place, 40.0));
                    (high, low, places) = (high.max(left_um), low.min(left_um), places + 1);
                }
            }
            println!("{name}, mill {cutter_mm} mm: {low:+.2} to {high:+.2} um at {places} places");
            assert!(places > 600, "{places}");
            assert!(high <= high_um + off_um && low >= low_um - off_um, "{set:?} {name}: {low} to {high}");
            assert!(high >= 0.5 * high_um, "{set:?} {name}: {high} of {high_um}");
            // A wall of a roller that is 10 um larger is not cut.
            let azimuth = rad_from_deg(540.0);
            let left_mm = sweep.left_mm(azimuth, wall(&centre, 8.01, side, azimuth, 50.0), 40.0);
            assert!(left_mm > mm_from_um(10.0 + low_um - off_um), "{left_mm}");
        }
    }
}

/// The flanks of a level wind are helices of 18 mm lead. Where it crosses itself the other turn takes the wall.
#[test]
fn the_program_of_a_level_wind_makes_helices_of_constant_lead() {
    let centre = |azimuth: f64| {
        let degree = azimuth.to_degrees();
        [0.0, 20.0 + 0.05 * if degree < 1080.0 { degree - 30.0 } else { 2130.0 - degree }]
    };
    let (sweep, summary) = program("level_wind", &[], 1.0, 4.0);
    assert!(summary.notes.is_empty(), "{:?}", summary.notes);
    let (mut high, mut low, mut places) = (f64::NEG_INFINITY, f64::INFINITY, 0);
    let degrees = (62..1018).chain(1142..2098).step_by(3).map(f64::from);
    for azimuth in degrees.map(rad_from_deg) {
        for (side, x) in [(-1.0, 25.2), (-1.0, 29.5), (1.0, 25.2), (1.0, 29.5)] {
            let place = wall(&centre, 4.0, side, azimuth, x);
            let crossed = (0..6).map(|turn| (azimuth + f64::from(turn) * TURN_RAD) % (6.0 * TURN_RAD)).skip(1);
            // At the ends of the traverse the formula is up to 1.5 mm beyond the blends.
            if crossed.into_iter().any(|there| (centre(there)[1] - place[2]).abs() < 6.2) {
                continue;
            }
            let left_um = um_from_mm(sweep.left_mm(azimuth, place, 20.0));
            (high, low, places) = (high.max(left_um), low.min(left_um), places + 1);
        }
    }
    println!("{low:+.2} to {high:+.2} um at {places} places");
    assert!(places > 500 && high <= 2.5 && low >= -2.5, "{low} to {high} at {places}");
}
