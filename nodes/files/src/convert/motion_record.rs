// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Input of a motion, as a text that reproduces the same motion to the bit.
//!
//! It is what the core's functions take that prepare a motion: the goal in the core's units and where the axes rested. So the record of a
//! motion is short, and there is one way from it to the motion, for the node and for who computes its run again.

use crate::convert::machine_report::input_named;
use crate::record_text::record_text;
use camwright::interpolator::join::StartTolerance;
use camwright::interpolator::manual::{Jog, JogRequest};
use camwright::interpolator::setup::{self, MoveTo, Probe, ProbeRequest};
use camwright::interpolator::tolerance::{FollowingTolerances, Tolerance};
use camwright::interpolator::trajectory::{Trajectory, TrajectoryPoint, TrajectoryStart};
use camwright::interpolator::{Motion, Prepared, RestState};
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::motion::plan::Plan;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Input of a motion. Lengths are in mm, angles in rad, forces in N.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MotionRecord {
    /// The plan with this hash.
    Plan(String),
    /// These axes find their zeros.
    Home(Vec<String>),
    /// The wheel to its speed, or to rest.
    Wheel(bool),
    Move {
        moves: Vec<MoveRecord>,
        from: [i64; AXIS_COUNT],
        speed_factor: f64,
    },
    Jog {
        joint: String,
        velocity: f64,
        distance: Option<f64>,
        from: [i64; AXIS_COUNT],
        knows_zero: bool,
    },
    Probe(Box<ProbeRecord>),
    Trajectory(Box<TrajectoryRecord>),
}

/// Target of one axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MoveRecord {
    pub joint: String,
    pub position: f64,
    pub relative: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeRecord {
    pub joint: String,
    pub target: f64,
    pub speed: f64,
    pub input: String,
    pub until_open: bool,
    pub stand_off: f64,
    pub most_force_n: f64,
    pub reads: Option<(f64, f64)>,
    pub from: [i64; AXIS_COUNT],
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrajectoryRecord {
    joints: Vec<String>,
    points: Vec<PointRecord>,
    position: [f64; AXIS_COUNT],
    velocity: [f64; AXIS_COUNT],
    acceleration: [f64; AXIS_COUNT],
    path: [[Option<f64>; 3]; AXIS_COUNT],
    goal: [[Option<f64>; 3]; AXIS_COUNT],
    goal_time_ticks: Option<u64>,
    /// Tick before which it does not begin.
    starts_at: Option<u64>,
    /// Largest distance of the axes from the first point; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start_tolerance: Option<[f64; AXIS_COUNT]>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointRecord {
    time_s: f64,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
}

/// The beginning of a motion: what it is, and what the interpolator brings into it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartRecord {
    counts: [i64; AXIS_COUNT],
    homed: [bool; AXIS_COUNT],
    feed_override: i64,
    motion: MotionRecord,
}

fn axis(joint: &str) -> Result<Axis, String> {
    Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?}"))
}

impl MotionRecord {
    /// A trajectory that begins there.
    pub fn trajectory(
        joints: &[Axis],
        points: &[TrajectoryPoint],
        start: &TrajectoryStart,
        (tolerances, start_tolerance): (&FollowingTolerances, &StartTolerance),
        starts_at: Option<u64>,
    ) -> Self {
        let listed = |of: &Tolerance| [of.position, of.velocity, of.acceleration];
        Self::Trajectory(Box::new(TrajectoryRecord {
            joints: joints.iter().map(|axis| axis.joint().to_owned()).collect(),
            points: points
                .iter()
                .map(|point| PointRecord {
                    time_s: point.time_s,
                    positions: point.positions.clone(),
                    velocities: point.velocities.clone(),
                    accelerations: point.accelerations.clone(),
                })
                .collect(),
            position: start.position,
            velocity: start.velocity,
            acceleration: start.acceleration,
            path: tolerances.path.each_ref().map(listed),
            goal: tolerances.goal.each_ref().map(listed),
            goal_time_ticks: tolerances.goal_time_ticks,
            starts_at,
            start_tolerance: (*start_tolerance != StartTolerance::default()).then_some(start_tolerance.0),
        }))
    }

    /// The motion, ready to be executed; `plan` finds plans by their hash.
    pub fn prepared(
        &self,
        machine: &MachineDescription,
        plan: impl FnOnce(&str) -> Result<Arc<Plan>, String>,
    ) -> Result<Prepared, String> {
        let motion = match self {
            Self::Plan(hash) => Motion::Plan(plan(hash)?),
            Self::Home(joints) => Motion::Home(joints.iter().map(|joint| axis(joint)).collect::<Result<_, _>>()?),
            Self::Wheel(turns) => Motion::Wheel(*turns),
            Self::Move { moves, from, speed_factor } => {
                let moves = moves
                    .iter()
                    .map(|to| Ok(MoveTo { axis: axis(&to.joint)?, position: to.position, is_relative: to.relative }));
                let moves: Vec<MoveTo> = moves.collect::<Result<_, String>>()?;
                let targets = setup::targets(&moves, *from, *speed_factor, machine);
                Motion::Move(targets.map_err(|error| error.to_string())?)
            }
            Self::Jog { joint, velocity, distance, from, knows_zero } => {
                let request = JogRequest { axis: axis(joint)?, velocity: *velocity, distance: *distance };
                let jog = Jog::new(&request, *from, *knows_zero, machine);
                Motion::Jog(jog.map_err(|error| error.to_string())?)
            }
            Self::Probe(probe) => Motion::Probe(probe.probe(machine)?),
            Self::Trajectory(trajectory) => return trajectory.prepared(machine),
        };
        Prepared::new(motion, machine).map_err(|error| error.to_string())
    }

    /// The plan that it executes; empty where it is none.
    pub fn plan_hash(&self) -> &str {
        match self {
            Self::Plan(hash) => hash,
            _ => "",
        }
    }

    pub fn to_text(&self) -> String {
        record_text(self)
    }

    pub fn from_text(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| format!("the record of a motion cannot be read: {error}"))
    }
}

impl ProbeRecord {
    fn probe(&self, machine: &MachineDescription) -> Result<Probe, String> {
        let input = input_named(&self.input, machine).ok_or_else(|| {
            let switches: Vec<&str> = machine.stations.iter().map(|station| station.switch.as_str()).collect();
            let switches = switches.join(", ");
            format!("there is no input {:?}; there are wheel_contact, key_way, origin and {switches}", self.input)
        })?;
        let request = ProbeRequest {
            axis: axis(&self.joint)?,
            target: self.target,
            speed: self.speed,
            input,
            input_name: self.input.clone(),
            until_open: self.until_open,
            stand_off: self.stand_off,
            most_force_n: self.most_force_n,
            reads: self.reads,
        };
        Probe::new(&request, self.from, machine).map_err(|error| error.to_string())
    }
}

impl TrajectoryRecord {
    fn prepared(&self, machine: &MachineDescription) -> Result<Prepared, String> {
        let joints: Vec<Axis> = self.joints.iter().map(|joint| axis(joint)).collect::<Result<_, _>>()?;
        let points = self.points.iter().map(|point| TrajectoryPoint {
            time_s: point.time_s,
            positions: point.positions.clone(),
            velocities: point.velocities.clone(),
            accelerations: point.accelerations.clone(),
        });
        let points: Vec<TrajectoryPoint> = points.collect();
        let start =
            TrajectoryStart { position: self.position, velocity: self.velocity, acceleration: self.acceleration };
        let tolerance = |of: &[Option<f64>; 3]| Tolerance { position: of[0], velocity: of[1], acceleration: of[2] };
        let tolerances = FollowingTolerances {
            path: self.path.each_ref().map(tolerance),
            goal: self.goal.each_ref().map(tolerance),
            goal_time_ticks: self.goal_time_ticks,
        };
        let start_tolerance = self.start_tolerance.map(StartTolerance).unwrap_or_default();
        let trajectory = Trajectory::joined(&joints, &points, &start, &start_tolerance, machine)
            .map_err(|error| error.to_string())?
            .with_tolerances(tolerances);
        let prepared = Prepared::new(Motion::from(trajectory), machine).map_err(|error| error.to_string())?;
        Ok(match self.starts_at {
            Some(tick) => prepared.starting_at(tick),
            None => prepared,
        })
    }
}

impl StartRecord {
    pub fn new(rest: &RestState, motion: MotionRecord) -> Self {
        Self { counts: rest.counts, homed: rest.homed, feed_override: rest.feed_override, motion }
    }

    /// Start state of the interpolator, and the motion.
    pub fn parts(self) -> (RestState, MotionRecord) {
        let Self { counts, homed, feed_override, motion } = self;
        (RestState { counts, homed, feed_override }, motion)
    }

    pub fn to_text(&self) -> String {
        record_text(self)
    }

    pub fn from_text(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| format!("the record of a motion cannot be read: {error}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::machine::reference::cam_grinder;

    /// A small generator of words, the same in every run.
    struct WordGenerator(u64);

    impl WordGenerator {
        fn next(&mut self) -> u64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            self.0
        }

        /// Any finite number: of every size, with every bit pattern.
        fn number(&mut self) -> f64 {
            loop {
                let number = f64::from_bits(self.next());
                if number.is_finite() {
                    return number;
                }
            }
        }

        fn counts(&mut self) -> [i64; AXIS_COUNT] {
            [0; AXIS_COUNT].map(|_: i64| self.next().cast_signed())
        }

        fn numbers(&mut self) -> [f64; AXIS_COUNT] {
            [0.0; AXIS_COUNT].map(|_: f64| self.number())
        }

        fn joint(&mut self) -> String {
            Axis::ALL[(self.next() % 3) as usize].joint().to_owned()
        }

        fn record(&mut self) -> MotionRecord {
            match self.next() % 6 {
                0 => MotionRecord::Plan(format!("{:064x}", self.next())),
                1 => MotionRecord::Home(vec![self.joint(), self.joint()]),
                2 => MotionRecord::Wheel(self.next().is_multiple_of(2)),
                3 => MotionRecord::Move {
                    moves: vec![MoveRecord { joint: self.joint(), position: self.number(), relative: true }],
                    from: self.counts(),
                    speed_factor: self.number(),
                },
                4 => MotionRecord::Jog {
                    joint: self.joint(),
                    velocity: self.number(),
                    distance: (self.next().is_multiple_of(2)).then(|| self.number()),
                    from: self.counts(),
                    knows_zero: self.next().is_multiple_of(2),
                },
                _ => self.trajectory(),
            }
        }

        fn trajectory(&mut self) -> MotionRecord {
            let point = |words: &mut Self| TrajectoryPoint {
                time_s: words.number(),
                positions: words.numbers().into(),
                velocities: words.numbers().into(),
                accelerations: Vec::new(),
            };
            let points = [point(self), point(self)];
            let start =
                TrajectoryStart { position: self.numbers(), velocity: self.numbers(), acceleration: self.numbers() };
            let mut tolerances = FollowingTolerances::default();
            tolerances.path[1].position = Some(self.number());
            tolerances.goal_time_ticks = Some(self.next());
            let start_tolerance = StartTolerance(self.numbers());
            MotionRecord::trajectory(&Axis::ALL, &points, &start, (&tolerances, &start_tolerance), Some(self.next()))
        }
    }

    #[test]
    fn what_is_read_back_is_what_was_written_to_the_bit() {
        let mut words = WordGenerator(0x2026_1122_dead_beef);
        for _ in 0..5000 {
            let record = words.record();
            let read = MotionRecord::from_text(&record.to_text()).expect("it was written so");
            // Equal numbers may differ in bits, as 0 and −0; their texts do not.
            assert_eq!((read.to_text(), &read), (record.to_text(), &record));
        }
        let zero = MotionRecord::Jog {
            joint: "x_axis".into(),
            velocity: -0.0,
            distance: None,
            from: [0; AXIS_COUNT],
            knows_zero: true,
        };
        let MotionRecord::Jog { velocity, .. } = MotionRecord::from_text(&zero.to_text()).expect("a jog") else {
            panic!("it was a jog")
        };
        assert_eq!(velocity.to_bits(), (-0.0_f64).to_bits());
    }

    #[test]
    fn a_start_carries_what_the_interpolator_brings_into_it() {
        let rest = RestState { counts: [-5, i64::MAX, 3], homed: [true, false, true], feed_override: 1 << 31 };
        let start = StartRecord::new(&rest, MotionRecord::Home(vec!["c_axis".into()]));
        let (read, motion) = StartRecord::from_text(&start.to_text()).expect("it was written so").parts();
        assert_eq!((read, motion), (rest, MotionRecord::Home(vec!["c_axis".into()])));
    }

    #[test]
    fn a_record_of_nothing_that_moves_is_refused_by_name() {
        let machine = cam_grinder();
        let refusal = |record: &MotionRecord| {
            record.prepared(&machine, |hash| Err(format!("no plan {hash}"))).map(|_| ()).expect_err("it is refused")
        };
        assert_eq!(refusal(&MotionRecord::Plan("abc".into())), "no plan abc");
        assert_eq!(refusal(&MotionRecord::Home(vec!["y_axis".into()])), "there is no joint \"y_axis\"");
        assert!(MotionRecord::from_text("{\"move\":{}}").is_err());
        assert!(MotionRecord::from_text("{\"dance\":1}").expect_err("unknown").contains("unknown variant `dance`"));
    }
}
