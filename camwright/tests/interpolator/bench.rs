// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine without inertia around the interpolator, and a plan on paper for it.

use camwright::interpolator::{
    Interpolator, InterpolatorEvent, InterpolatorStatus, Motion, MotionOutcome, MotionRequest, Order, OrderKind,
    Prepared, StepOutput, TickInputs,
};
use camwright::job::grinding::{InfeedDirection, SpeedLaw};
use camwright::job::infeed::InfeedSchedule;
use camwright::machine::axial_profile::AxialProfile;
use camwright::machine::description::{
    AXIS_COUNT, AlarmRetract, Axis, AxisDescription, AxisScale, DriveSettings, MachineDescription, MotionLimits,
    Station, WheelDescription,
};
use camwright::machine::setpoint::{Input, Latch, Setpoint};
use camwright::math::periodic_spline::PeriodicSpline;
use camwright::math::units::TURN_RAD;
use camwright::motion::plan::{AxisTarget, CutSegment, GaugeSize, Phase, Plan, PlanCommand, Segment, SegmentKind};
use camwright::motion::speed_plan::{FlyingStart, SpeedPlan, SpeedRequest};
use std::sync::Arc;

pub(crate) const TURN: i64 = 3_600_000;
pub(crate) const PER_MM: i64 = 100_000;
/// Closing positions of the origin detector and of the station's switch (counts from power-up).
pub(crate) const ORIGIN: i64 = 777_777;
pub(crate) const SWITCH: i64 = 12_345_678;
pub(crate) const START_RAD: f64 = 1.0;
pub(crate) const SAFE_X: i64 = 60 * PER_MM;

pub(crate) struct TestNoise(pub(crate) u64);

impl TestNoise {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }

    pub(crate) fn below(&mut self, bound: u64) -> u64 {
        (self.next() * bound as f64) as u64
    }
}

fn axis(
    axis: Axis,
    scale: AxisScale,
    limits: MotionLimits,
    soft_limits: Option<(f64, f64)>,
    homing: bool,
) -> AxisDescription {
    AxisDescription {
        axis,
        scale,
        limits,
        soft_limits,
        overtravel: None,
        max_following_error: 1.0,
        min_following_error: 0.1,
        needs_homing: homing,
        homing: None,
        search_velocity: if axis == Axis::C { 3.0 } else { 40.0 },
        drive: DriveSettings::IDEAL,
        good_drive: None,
        inertia: 1.0,
        power_up_position: 0.0,
    }
}

pub(crate) fn machine() -> MachineDescription {
    let linear = AxisScale::Linear { counts_per_mm: PER_MM };
    MachineDescription {
        name: "bench".into(),
        hash: String::new(),
        cycle_time_ns: 1_000_000,
        feedback_delay_ticks: 20,
        servo_steps_per_tick: 4,
        axes: [
            axis(
                Axis::C,
                AxisScale::Rotary { counts_per_turn: TURN },
                MotionLimits { velocity: 31.4, acceleration: 300.0, jerk: 30_000.0 },
                None,
                true,
            ),
            axis(
                Axis::X,
                linear,
                MotionLimits { velocity: 500.0, acceleration: 10_000.0, jerk: 1e6 },
                Some((-5.0, 200.0)),
                false,
            ),
            axis(
                Axis::Z,
                linear,
                MotionLimits { velocity: 300.0, acceleration: 3_000.0, jerk: 1e5 },
                Some((-5.0, 900.0)),
                false,
            ),
        ],
        stations: vec![Station { switch: "LS1".into(), position_mm: 123.456_78 }],
        dog_length_mm: 5.0,
        switch_hysteresis_mm: 0.1,
        origin_half_window_rad: 0.01,
        wheel: WheelDescription {
            new_radius_mm: 200.0,
            min_radius_mm: 150.0,
            width_mm: 20.0,
            surface_speed_m_s: 60.0,
            spin_up_s: 1.0,
            max_surface_speed_m_s: None,
            max_speed_rad_s: None,
            grinding_ratio: None,
            unbalance_mm: 0.0,
            rim: AxialProfile::default(),
        },
        insert: None,
        wheel_changer: None,
        contact: None,
        workholding: None,
        thermal: None,
        gauge: None,
        gap_detector: None,
        key_way_probe: None,
        loading: None,
        process: None,
        retract: AlarmRetract::default(),
        dresser: None,
        headstock: None,
        tailstock: None,
        rotation_sense: 1,
    }
}

/// An eccentric of 4.2 mm about 30 mm, 0.36 mm infeed in 2 turns, 2 turns spark-out.
pub(crate) fn eccentric(e: f64) -> PeriodicSpline {
    let values: Vec<f64> = (0..360).map(|i| 30.0 + e * (f64::from(i) * TURN_RAD / 360.0).cos()).collect();
    PeriodicSpline::interpolate(&values).expect("360 values")
}

pub(crate) fn segment(kind: SegmentKind, phase: Phase, ticks: u64, stop_ticks: u64, stock_mm: f64) -> Segment {
    Segment { kind, phase, lobe: Some(0), label: String::new(), ticks, stop_ticks, stock_mm }
}

pub(crate) fn to(machine: &MachineDescription, axis: Axis, target_counts: i64) -> AxisTarget {
    AxisTarget { axis, target_counts, limits: machine.axis(axis).limits }
}

/// A cut of the eccentric at a work speed, starting where C is 0.
pub(crate) fn cut(machine: &MachineDescription, e: f64, work_speed_rad_s: f64) -> (Plan, CutSegment, u64) {
    cut_under(machine, e, SpeedLaw::ConstantWorkSpeed { work_speed_rad_s })
}

fn cut_under(machine: &MachineDescription, e: f64, speed: SpeedLaw) -> (Plan, CutSegment, u64) {
    cut_between(machine, e, speed, None, None, 2)
}

/// A cut from where C comes turning, or from rest, to where it goes on turning, or to rest.
fn cut_between(
    machine: &MachineDescription,
    e: f64,
    speed: SpeedLaw,
    comes: Option<FlyingStart>,
    goes: Option<FlyingStart>,
    spark_out_turns: u32,
) -> (Plan, CutSegment, u64) {
    let path = eccentric(e);
    let infeed = InfeedSchedule::new(0.36, 0.000_05, 3600, machine.axis(Axis::X).scale).expect("2 turns");
    let speed = SpeedPlan::new(&SpeedRequest {
        wheel_radius_mm: 60.0,
        wheel_speed_m_s: 80.0,
        path: &path,
        path_start_rad: START_RAD,
        infeed: &infeed,
        infeed_direction: InfeedDirection::X,
        ratio: None,
        spark_out_turns,
        leaves_turning: false,
        speed,
        c: machine.axis(Axis::C).limits,
        comes,
        goes,
        wheel_power: None,
        rotation_sense: machine.rotation_sense,
        x: machine.axis(Axis::X).limits,
        cycle_time_s: machine.cycle_time_s(),
    })
    .expect("fits");
    let cut = CutSegment {
        path: 0,
        speed: 0,
        infeed: 0,
        ratio: None,
        lead: speed.lead().map(|_| 1),
        start_counts: 0,
        path_start_rad: START_RAD,
        turns: speed.turns(),
        infeed_turns: infeed.turns(),
        plateau_s: speed.plateau_s(),
        turn_s: speed.turn_s(),
        retract_mm: 2.0,
        hold_mm: 2.0,
        until_steady_n: None,
        variation: None,
    };
    let stop_ticks = speed.stop_ticks();
    let plan = Plan {
        paths: vec![path],
        time_laws: [speed.law()].into_iter().chain(speed.lead()).cloned().collect(),
        angle_laws: vec![speed.infeed().law().clone()],
        ..Plan::default()
    };
    (plan, cut, stop_ticks)
}

/// Home C, find the station, advance, cut, retract: everything once.
pub(crate) fn whole_job(machine: &MachineDescription, work_speed_rad_s: f64) -> Plan {
    let (mut plan, cut, stop_ticks) = cut(machine, 4.2, work_speed_rad_s);
    let x_start = plan.paths[0].sample(START_RAD).value + plan.angle_laws[0].sample(0.0).value;
    let x_start = machine.axis(Axis::X).scale.counts(x_start);
    let ticks = (plan.time_laws[0].end() / machine.cycle_time_s()).ceil() as u64;
    let search = |axis: Axis, input: &str, travel_counts| SegmentKind::Search {
        axis,
        input: input.into(),
        travel_counts,
        offset_counts: if axis == Axis::Z { 25 * PER_MM } else { 0 },
        limits: machine.axis(axis).limits.at_most(machine.axis(axis).search_velocity),
    };
    plan.segments = vec![
        segment(SegmentKind::Move(vec![to(machine, Axis::X, SAFE_X)]), Phase::Retract, 200, 1, 0.0),
        segment(search(Axis::C, "origin", TURN + TURN / 4), Phase::Home, 1000, 1, 0.0),
        segment(SegmentKind::Command(PlanCommand::SetHome(Axis::C)), Phase::Home, 40, 1, 0.0),
        segment(SegmentKind::Command(PlanCommand::WheelStart), Phase::Position, 40, 1, 0.0),
        segment(SegmentKind::Move(vec![to(machine, Axis::Z, 100 * PER_MM)]), Phase::Index, 500, 1, 0.0),
        segment(search(Axis::Z, "LS1", 60 * PER_MM), Phase::Index, 1000, 1, 0.0),
        segment(SegmentKind::Dwell, Phase::Position, 37, 1, 0.0),
        segment(SegmentKind::Move(vec![to(machine, Axis::X, x_start)]), Phase::Approach, 200, 1, 0.36),
        segment(SegmentKind::Cut(cut), Phase::Cut, ticks, stop_ticks, 0.36),
        segment(
            SegmentKind::Move(vec![to(machine, Axis::X, SAFE_X), to(machine, Axis::Z, 50 * PER_MM)]),
            Phase::Return,
            400,
            1,
            0.0,
        ),
        segment(SegmentKind::Command(PlanCommand::WheelStop), Phase::Return, 40, 1, 0.0),
    ];
    plan
}

/// Two cuts with C turning on in between, at another speed, and where the first starts: the table goes to its switch meanwhile.
pub(crate) fn two_cuts(machine: &MachineDescription, speed: SpeedLaw) -> (Plan, [i64; AXIS_COUNT]) {
    let turning = |speed_rad_s| FlyingStart { speed_rad_s, clear_x_mm: 40.0, rapid_mm_s: 150.0 };
    let (mut plan, first, first_stop) = cut_between(machine, 4.2, speed, None, Some(turning(4.0)), 2);
    let (second_plan, mut second, second_stop) = cut_between(machine, 4.2, speed, Some(turning(3.0)), None, 2);
    second.start_counts = TURN / 3;
    second.speed = plan.time_laws.len();
    second.lead = Some(second.speed + 1);
    second.infeed = 1;
    plan.time_laws.extend(second_plan.time_laws);
    plan.angle_laws.extend(second_plan.angle_laws);
    let x = plan.paths[0].sample(START_RAD).value + plan.angle_laws[0].sample(0.0).value;
    let ticks = |law: usize| {
        let law = &plan.time_laws[law];
        ((law.end() - law.start()) / machine.cycle_time_s()).ceil() as u64
    };
    let (first_ticks, second_ticks) = (ticks(first.speed), ticks(second.speed));
    let limits = machine.axis(Axis::Z).limits.at_most(machine.axis(Axis::Z).search_velocity);
    let search = SegmentKind::Search {
        axis: Axis::Z,
        input: "LS1".into(),
        travel_counts: 60 * PER_MM,
        offset_counts: 0,
        limits,
    };
    plan.segments = vec![
        segment(SegmentKind::Cut(first), Phase::Cut, first_ticks, first_stop, 0.36),
        segment(SegmentKind::Move(vec![to(machine, Axis::Z, 100 * PER_MM)]), Phase::Index, 700, 1, 0.0),
        segment(search, Phase::Index, 900, 1, 0.0),
        segment(SegmentKind::Dwell, Phase::Position, 37, 1, 0.0),
        segment(SegmentKind::Cut(second), Phase::Cut, second_ticks, second_stop, 0.36),
        segment(SegmentKind::Move(vec![to(machine, Axis::X, SAFE_X)]), Phase::Retract, 200, 1, 0.0),
    ];
    (plan, [0, machine.axis(Axis::X).scale.counts(x), 0])
}

/// A plan that is the cut alone, and where it starts.
pub(crate) fn cut_only(machine: &MachineDescription, e: f64, work_speed_rad_s: f64) -> (Plan, [i64; AXIS_COUNT]) {
    cut_only_under(machine, e, SpeedLaw::ConstantWorkSpeed { work_speed_rad_s })
}

/// The same under any law of speed.
pub(crate) fn cut_only_under(machine: &MachineDescription, e: f64, speed: SpeedLaw) -> (Plan, [i64; AXIS_COUNT]) {
    let (mut plan, cut, stop_ticks) = cut_under(machine, e, speed);
    let x = plan.paths[0].sample(START_RAD).value + plan.angle_laws[0].sample(0.0).value;
    let ticks = (plan.time_laws[0].end() / machine.cycle_time_s()).ceil() as u64;
    plan.segments = vec![segment(SegmentKind::Cut(cut), Phase::Cut, ticks, stop_ticks, 0.36)];
    (plan, [0, machine.axis(Axis::X).scale.counts(x), 0])
}

/// A cut alone that sparks out for so many turns at most, until the force is steady within 40 N, and where it starts.
pub(crate) fn sparking_out(machine: &MachineDescription, max_turns: u32) -> (Plan, [i64; AXIS_COUNT]) {
    let speed = SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 };
    let (mut plan, cut, stop_ticks) = cut_between(machine, 4.2, speed, None, None, max_turns);
    let x = plan.paths[0].sample(START_RAD).value + plan.angle_laws[0].sample(0.0).value;
    let ticks = (plan.time_laws[0].end() / machine.cycle_time_s()).ceil() as u64;
    let cut = CutSegment { until_steady_n: Some(40), ..cut };
    plan.segments = vec![
        segment(SegmentKind::Command(PlanCommand::WatchForce { max_n: 40 }), Phase::Position, 40, 1, 0.36),
        segment(SegmentKind::Cut(cut), Phase::Cut, ticks, stop_ticks, 0.36),
    ];
    (plan, [0, machine.axis(Axis::X).scale.counts(x), 0])
}

/// A cut alone whose infeed ends at 60.012 mm on the gauge, and where it starts.
pub(crate) fn sizing(machine: &MachineDescription, spark_out_turns: u32) -> (Plan, [i64; AXIS_COUNT]) {
    let (mut plan, start) = sparking_out(machine, spark_out_turns);
    let size = GaugeSize { diameter_nm: 60_012_000, beyond_nm: 0 };
    plan.segments[0].kind = SegmentKind::Command(PlanCommand::WatchSize(size));
    if let SegmentKind::Cut(cut) = &mut plan.segments[1].kind {
        cut.until_steady_n = None;
    }
    (plan, start)
}

/// One tick of a run. Positions are absolute: the machine's own, whatever zero is in force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub(crate) tick: u64,
    pub(crate) setpoint: Setpoint,
    pub(crate) absolute: [i64; AXIS_COUNT],
    pub(crate) status: InterpolatorStatus,
}

/// Interpolator and machine.
pub(crate) struct Bench {
    pub(crate) machine: MachineDescription,
    pub(crate) interpolator: Interpolator,
    pub(crate) rows: Vec<Row>,
    pub(crate) orders: Vec<Order>,
    pub(crate) events: Vec<(u64, InterpolatorEvent)>,
    pub(crate) outcome: Option<MotionOutcome>,
    pub(crate) tick: u64,
    /// Ticks after its own at which an edge reaches the interpolator, 1 … D.
    pub(crate) delivery: Box<dyn FnMut() -> u64>,
    pub(crate) origin_works: bool,
    shift: [i64; AXIS_COUNT],
    pending: Vec<(u64, Latch)>,
}

impl Bench {
    pub(crate) fn new(machine: MachineDescription) -> Self {
        Self {
            interpolator: Interpolator::new(&machine),
            machine,
            rows: Vec::new(),
            orders: Vec::new(),
            events: Vec::new(),
            outcome: None,
            tick: 1000,
            delivery: Box::new(|| 1),
            origin_works: true,
            shift: [0; AXIS_COUNT],
            pending: Vec::new(),
        }
    }

    pub(crate) fn start(&mut self, motion: Motion) {
        let prepared = Prepared::new(motion, &self.machine).unwrap_or_else(|error| panic!("{error}"));
        self.interpolator.start(Box::new(prepared)).unwrap_or_else(|(error, _)| panic!("{error}"));
        self.outcome = None;
    }

    pub(crate) fn start_plan(&mut self, plan: Plan) {
        self.start(Motion::Plan(Arc::new(plan)));
    }

    /// Runs a plan to its end with a hold from a tick on for so many ticks, and an edge of an input in another, counted from the start.
    pub(crate) fn run_held(&mut self, plan: Plan, (hold, length): (u64, u64), (at, edge): (u64, fn(&mut Self))) {
        self.start_plan(plan);
        for row in 0..60_000_u64 {
            if self.outcome.is_some() {
                break;
            }
            let requests: &[MotionRequest] = match row {
                row if row == hold => &[MotionRequest::Hold],
                row if row == hold + length => &[MotionRequest::Unhold],
                _ => &[],
            };
            self.step(requests);
            if row == at && self.outcome.is_none() {
                edge(self);
            }
        }
    }

    /// Machine with a homed C at the start of a cut.
    pub(crate) fn at(machine: MachineDescription, counts: [i64; AXIS_COUNT]) -> Self {
        let mut bench = Self::new(machine);
        bench.interpolator.resync(counts);
        bench.interpolator.set_homed(Axis::C, true);
        bench
    }

    pub(crate) fn step(&mut self, requests: &[MotionRequest]) -> StepOutput {
        let tick = self.tick;
        let interpolator = &mut self.interpolator;
        self.pending.retain(|(at, latch)| {
            if *at <= tick {
                assert!(interpolator.feedback(latch));
            }
            *at > tick
        });
        let out = self.interpolator.step(&TickInputs { tick, requests });
        assert_eq!(out.requests_taken, requests.len());
        for order in &self.orders {
            if order.tick == tick
                && let OrderKind::SetHome { axis, counts } = order.kind
            {
                self.shift[axis.index()] += counts;
            }
        }
        self.orders.extend(out.orders.iter().copied());
        self.events.extend(out.events.iter().map(|event| (tick, *event)));
        for event in out.events.iter() {
            if let InterpolatorEvent::Finished(outcome) = event {
                self.outcome = Some(*outcome);
            }
        }
        let absolute: [i64; AXIS_COUNT] = std::array::from_fn(|i| out.setpoint.counts[i] + self.shift[i]);
        if let Some(before) = self.rows.last().map(|row| row.absolute) {
            if self.origin_works {
                let turn = |counts: i64| (counts - ORIGIN).div_euclid(TURN);
                if turn(absolute[0]) > turn(before[0]) {
                    self.edge(tick, Input::Origin, Axis::C, ORIGIN + turn(absolute[0]) * TURN);
                }
            }
            if before[2] < SWITCH && absolute[2] >= SWITCH {
                self.edge(tick, Input::Station(0), Axis::Z, SWITCH);
            }
        }
        self.rows.push(Row { tick, setpoint: out.setpoint, absolute, status: out.status });
        self.tick += 1;
        out
    }

    fn edge(&mut self, tick: u64, input: Input, axis: Axis, absolute: i64) {
        self.deliver(Latch { tick, input, rising: true, axis, counts: absolute - self.shift[axis.index()] });
    }

    /// The force monitor's input closes or opens in the tick that was computed last.
    pub(crate) fn force_is_steady(&mut self, rising: bool) {
        let counts = self.counts()[0];
        self.deliver(Latch { tick: self.tick - 1, input: Input::SteadyForce, rising, axis: Axis::C, counts });
    }

    /// The size monitor's input closes in the tick that was computed last.
    pub(crate) fn size_is_reached(&mut self) {
        let counts = self.counts()[0];
        self.deliver(Latch { tick: self.tick - 1, input: Input::SizeReached, rising: true, axis: Axis::C, counts });
    }

    fn deliver(&mut self, latch: Latch) {
        let delay = (self.delivery)();
        assert!((1..=u64::from(self.machine.feedback_delay_ticks)).contains(&delay));
        self.pending.push((latch.tick + delay, latch));
    }

    /// Runs up to a row, holds for this number of ticks, and resumes. Returns whether the motion was still active then.
    pub(crate) fn hold_at(&mut self, row: u64, ticks: u64) -> bool {
        while (self.rows.len() as u64) < row && self.outcome.is_none() {
            self.step(&[]);
        }
        if self.outcome.is_some() {
            return false;
        }
        self.step(&[MotionRequest::Hold]);
        for _ in 0..ticks {
            self.step(&[]);
        }
        self.step(&[MotionRequest::Unhold]);
        true
    }

    /// Steps through so many rounds of fewer than `longest` ticks. Each ends with a request while the motion lasts: in a quarter of them `rare`,
    /// in another quarter any override, otherwise `common`. Then the motion is released.
    pub(crate) fn disturb(
        &mut self,
        random: &mut TestNoise,
        (rounds, longest): (u32, u64),
        [rare, common]: [MotionRequest; 2],
    ) {
        for _ in 0..rounds {
            for _ in 0..random.below(longest) {
                self.step(&[]);
            }
            let request = match random.below(4) {
                0 => rare,
                1 => MotionRequest::SetOverride(random.next()),
                _ => common,
            };
            if self.outcome.is_none() {
                self.step(&[request]);
            }
        }
        if self.outcome.is_none() {
            self.step(&[MotionRequest::SetOverride(1.0), MotionRequest::Unhold]);
        }
    }

    /// Steps until the motion ends.
    pub(crate) fn finish(&mut self, max: u64) -> MotionOutcome {
        for _ in 0..max {
            if let Some(outcome) = self.outcome {
                return outcome;
            }
            self.step(&[]);
        }
        panic!("not finished after {max} ticks: {:?}", self.rows.last());
    }

    pub(crate) fn last(&self) -> &Row {
        self.rows.last().expect("stepped")
    }

    pub(crate) fn counts(&self) -> [i64; AXIS_COUNT] {
        self.last().setpoint.counts
    }

    /// Differences of the positions keep every limit, and setpoint velocities agree with them. A position is rounded
    /// by half a count, and by half a count more where a motion begins at the rounded end of another; that bounds
    /// what differences of first, second and third order may exceed a limit by.
    pub(crate) fn assert_limits(&self, what: &str) {
        let dt = self.machine.cycle_time_s();
        for axis in Axis::ALL {
            let (limits, count) =
                (self.machine.axis(axis).limits, 1.0 / self.machine.axis(axis).scale.counts_per_unit());
            let at =
                |i: usize| (self.rows[i].absolute[axis.index()] - self.rows[0].absolute[axis.index()]) as f64 * count;
            for i in 3..self.rows.len() {
                let (a, b, c, d) = (at(i - 3), at(i - 2), at(i - 1), at(i));
                let v = (d - c) / dt;
                let acc = (d - 2.0 * c + b) / (dt * dt);
                let jerk = (d - 3.0 * c + 3.0 * b - a) / (dt * dt * dt);
                let tick = self.rows[i].tick;
                let status = &self.rows[i].status;
                assert!(v.abs() <= limits.velocity + 2.0 * count / dt, "{what}: {axis:?} {tick} v {v} {status:?}");
                assert!(
                    acc.abs() <= limits.acceleration + 4.0 * count / (dt * dt),
                    "{what}: {axis:?} {tick} a {acc} {status:?}"
                );
                assert!(
                    jerk.abs() <= limits.jerk + 8.0 * count / (dt * dt * dt),
                    "{what}: {axis:?} {tick} j {jerk} {status:?}"
                );
                let expected = 0.5
                    * (self.rows[i].setpoint.velocity[axis.index()] + self.rows[i - 1].setpoint.velocity[axis.index()]);
                // The mean of two velocities misses the mean velocity by at most jerk · dt² / 8 or so.
                let slack = 2.0 * count / dt + 0.25 * limits.jerk * dt * dt;
                assert!((v - expected).abs() <= slack, "{what}: {axis:?} {tick}: expected {expected}, went {v}");
            }
        }
    }

    pub(crate) fn assert_at_rest(&self, what: &str) {
        let row = self.last();
        assert!(row.setpoint.velocity.iter().all(|v| *v == 0.0), "{what}: {row:?}");
        assert!(row.setpoint.acceleration.iter().all(|a| *a == 0.0), "{what}: {row:?}");
    }

    /// Every row of the cut that follows its path lies on it: X against the design at the C of the same row.
    pub(crate) fn assert_on_path(&self, plan: &Plan, cut: &CutSegment, what: &str) {
        let law_end = plan.time_laws[cut.speed].end();
        let mut checked = 0;
        for row in self.rows.iter().filter(|row| row.status.turns > 0.0) {
            use camwright::interpolator::ExecutionState;
            if row.status.state != ExecutionState::Executing {
                continue;
            }
            // The reported turn omits inserted turns, and is not rounded to counts: it selects the turn only.
            let expected = row.status.turn * TURN_RAD;
            let c = (row.setpoint.counts[0] as f64) / TURN as f64 * TURN_RAD;
            let turns = ((c - expected) / TURN_RAD).round();
            let c = c - turns * TURN_RAD;
            assert!((c - expected).abs() < 1e-6 + 2.0 * TURN_RAD / TURN as f64, "{what}: {c} {expected} {law_end}");
            let x = plan.paths[0].sample(cut.path_start_rad + c).value + plan.angle_laws[0].sample(c).value;
            let slope = plan.paths[0].sample(cut.path_start_rad + c).first;
            let error = row.setpoint.counts[1] as f64 - x * PER_MM as f64;
            // Half a count of X, and what half a count of C is worth on the slope.
            let allowed = 0.5 + 0.51 * (TURN_RAD / TURN as f64) * slope.abs() * PER_MM as f64 + 1e-3;
            assert!(error.abs() <= allowed, "{what}: tick {} x off by {error} counts", row.tick);
            checked += 1;
        }
        assert!(checked > 0, "{what}: nothing followed the path");
    }
}
