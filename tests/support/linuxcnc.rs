// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The interpreter of LinuxCNC: what it makes of a program, in its canonical output.

use super::{Folder, in_ci};
use camwright::gcode::{Direction, MotionAction, NcAxis, ProgramPose};
use camwright::math::units::rad_from_deg;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// Something that LinuxCNC would do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven {
    /// Action; positions are those of the machine, with shifts, and four decimal places. The time of a feed follows from its
    /// rate.
    pub action: MotionAction,
    /// Rate of a feed (mm/min, or °/min where no linear axis moves); 0 otherwise.
    pub rate_per_min: f64,
}

/// `rs274`, the interpreter alone: no machine, no real time.
#[derive(Debug)]
pub struct LinuxCnc {
    program: PathBuf,
}

impl LinuxCnc {
    /// The interpreter of the search path; `None`, loudly, where there is none.
    ///
    /// # Panics
    /// When there is none under `CI=true`.
    pub fn find() -> Option<Self> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let found = std::env::split_paths(&path).map(|folder| folder.join("rs274")).find(|program| program.is_file());
        if found.is_none() {
            assert!(!in_ci(), "rs274 is not there: the tests with LinuxCNC are not optional in CI");
            let test = std::thread::current().name().map(str::to_owned);
            eprintln!(
                "SKIPPED, NOT PASSED: rs274 is not there (linuxcnc-uspace), LinuxCNC was not asked (test {test:?})"
            );
        }
        found.map(|program| Self { program })
    }

    /// Motion of a program, or the error of LinuxCNC. Tools 1 to 99 exist, all without length.
    pub fn drive(&self, text: &str) -> Result<Vec<Driven>, String> {
        static RUNS: AtomicU32 = AtomicU32::new(0);
        let folder = Folder::new(&format!("rs274-{}", RUNS.fetch_add(1, Ordering::Relaxed)));
        let tools: String = (1..100).map(|tool| format!("T{tool} P{tool} Z0 D1\n")).collect();
        folder.write("tools.tbl", &tools);
        folder.write("empty.var", "");
        folder.write("program.ngc", text);
        let output = Command::new(&self.program)
            .args(["-t", "tools.tbl", "-v", "empty.var", "-g", "program.ngc"])
            .current_dir(folder.path())
            // It keeps tools in a file there that two at a time would spoil for each other.
            .env("HOME", folder.path())
            .stdin(Stdio::null())
            .output()
            .expect("rs274 starts");
        let text = String::from_utf8_lossy(&output.stdout);
        let against = || format!("{}\n{}", String::from_utf8_lossy(&output.stderr), text.lines().last().unwrap_or(""));
        if !output.status.success() || !text.contains("PROGRAM_END()") {
            return Err(against());
        }
        Ok(Canonical::default().read(&text))
    }
}

/// State while canonical output is read.
#[derive(Default)]
struct Canonical {
    zero: [f64; 6],
    shift: [f64; 6],
    place: [f64; 6],
    rate: f64,
    speed: f64,
    tool: u32,
    changing: bool,
    driven: Vec<Driven>,
}

impl Canonical {
    fn read(mut self, text: &str) -> Vec<Driven> {
        for line in text.lines() {
            // `   12 N..... NAME(arguments)`
            let words = line.split_once("N..... ").unwrap_or_else(|| panic!("no canonical line: {line}")).1;
            let (name, arguments) = words.split_once('(').unwrap_or_else(|| panic!("no function: {line}"));
            if name == "PROGRAM_END" {
                break;
            }
            let arguments = arguments.strip_suffix(')').unwrap_or_else(|| panic!("no end: {line}"));
            self.function(name, arguments, line);
        }
        self.driven
    }

    fn function(&mut self, name: &str, arguments: &str, line: &str) {
        match name {
            "USE_LENGTH_UNITS" => assert_eq!(arguments, "CANON_UNITS_MM", "{line}"),
            "SET_FEED_REFERENCE" => assert_eq!(arguments, "CANON_XYZ", "{line}"),
            "SET_XY_ROTATION" => assert_eq!(arguments, "0.0000", "{line}"),
            "SET_NAIVECAM_TOLERANCE"
            | "SET_FEED_MODE"
            | "SELECT_PLANE"
            | "COMMENT"
            | "ON_RESET"
            | "MIST_OFF"
            | "SET_SPINDLE_MODE" => {}
            "START_CHANGE" => self.changing = true,
            "USE_TOOL_LENGTH_OFFSET" => {
                assert!(arguments.split([' ', ',']).all(|n| matches!(n, "" | "0.0000")), "{line}");
            }
            "SET_G5X_OFFSET" => self.zero = six(&numbers(arguments, line)[1..]),
            "SET_G92_OFFSET" => self.shift = six(&numbers(arguments, line)),
            "SET_FEED_RATE" => self.rate = numbers(arguments, line)[0],
            "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" => {
                self.straight(name == "STRAIGHT_FEED", six(&numbers(arguments, line)));
            }
            "SELECT_TOOL" => self.tool = arguments.parse().expect("a tool"),
            "CHANGE_TOOL" => {
                self.changing = false;
                self.push(MotionAction::ToolChange(self.tool));
            }
            "SET_SPINDLE_SPEED" => self.speed = numbers(arguments, line)[1],
            "START_SPINDLE_CLOCKWISE" => self.turn(Direction::Clockwise),
            "START_SPINDLE_COUNTERCLOCKWISE" => self.turn(Direction::Counterclockwise),
            // A change of the tool stops the spindle by itself.
            "STOP_SPINDLE_TURNING" if self.changing => {}
            "STOP_SPINDLE_TURNING" => self.push(MotionAction::SpindleOff),
            "FLOOD_ON" | "FLOOD_OFF" => self.push(MotionAction::Coolant(name == "FLOOD_ON")),
            "DWELL" => self.push(MotionAction::Dwell(numbers(arguments, line)[0])),
            "SET_MOTION_CONTROL_MODE" => {
                let within = arguments.strip_prefix("CANON_CONTINUOUS, ").unwrap_or_else(|| panic!("{line}"));
                self.push(MotionAction::PathTolerance(Some(within.parse().expect("a tolerance"))));
            }
            _ => panic!("not known here: {line}"),
        }
    }

    fn push(&mut self, action: MotionAction) {
        self.driven.push(Driven { action, rate_per_min: 0.0 });
    }

    fn turn(&mut self, direction: Direction) {
        self.push(MotionAction::SpindleOn { direction, rpm: self.speed });
    }

    /// X, Y, Z, A, B, C of a block, without the shifts that hold.
    fn straight(&mut self, is_feed: bool, to: [f64; 6]) {
        let place: [f64; 6] = std::array::from_fn(|axis| to[axis] + self.zero[axis] + self.shift[axis]);
        let way =
            |axes: &[usize]| axes.iter().map(|axis| (place[*axis] - self.place[*axis]).powi(2)).sum::<f64>().sqrt();
        let linear = way(&[0, 1, 2]);
        let way = if linear > 0.0 { linear } else { way(&[5]) };
        self.place = place;
        let mut pose = ProgramPose::default().with(NcAxis::C, rad_from_deg(place[5]));
        for (axis, place) in [NcAxis::X, NcAxis::Y, NcAxis::Z].into_iter().zip(place) {
            pose = pose.with(axis, place);
        }
        let rate_per_min = if is_feed { self.rate } else { 0.0 };
        let feed = MotionAction::Feed { pose, time_s: way / self.rate * 60.0 };
        self.driven.push(Driven { action: if is_feed { feed } else { MotionAction::Rapid(pose) }, rate_per_min });
    }
}

fn numbers(arguments: &str, line: &str) -> Vec<f64> {
    arguments.split(", ").map(|n| n.parse().unwrap_or_else(|_| panic!("{n:?} is no number: {line}"))).collect()
}

fn six(numbers: &[f64]) -> [f64; 6] {
    numbers.try_into().unwrap_or_else(|_| panic!("six axes: {numbers:?}"))
}
