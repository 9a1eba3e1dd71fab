// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One axis while it runs: its coordinates, the setpoint between two ticks, its drive, and when it counts as at rest.

use crate::machine::description::{AxisDescription, AxisScale, nearest_count};
use crate::math::hermite::{Sample, cubic_path, cubic_slope};
use crate::simulation::servo::{Servo, ServoCommand};
use alloc::boxed::Box;
use alloc::collections::VecDeque;

/// Ticks for which an axis must be within its window of a resting setpoint before it is clamped there. Eight outlast
/// the zero crossing of a swinging loop of any bandwidth above 20 Hz, and cost 8 ms after every motion.
const SETTLED_TICKS: u32 = 8;
/// Difference of positions that are the same, after sums (counts).
const SAME_COUNT: f64 = 1e-6;

/// A setpoint of one axis (counts, s), in true coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisSetpoint {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
}

crate::snapshot!(AxisSetpoint { position, velocity, acceleration } on {});

impl AxisSetpoint {
    pub(crate) fn resting(position: f64) -> Self {
        Self { position, velocity: 0.0, acceleration: 0.0 }
    }

    pub(crate) fn is_resting(&self) -> bool {
        self.velocity == 0.0 && self.acceleration == 0.0
    }
}

/// True position of the load of an axis at both ends of a servo step (counts, counts/s), in true coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) from_velocity: f64,
    pub(crate) to_velocity: f64,
}

impl Span {
    /// Way done at fraction `s` of the step: the cubic with these ends.
    pub(crate) fn way(&self, s: f64, step_s: f64) -> f64 {
        cubic_path(s, self.to - self.from, self.from_velocity * step_s, self.to_velocity * step_s)
    }

    pub(crate) fn is_still(&self) -> bool {
        self.to - self.from == 0.0 && self.from_velocity == 0.0 && self.to_velocity == 0.0
    }
}

/// A setpoint on its way to a real drive.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SentSetpoint {
    /// Position from the zero of its tick (counts).
    position: f64,
    /// Velocity (counts/s).
    velocity: f64,
    /// Raw count of that zero.
    zero: i64,
}

/// Drive of a real axis: setpoints reach it, and its encoder shows them, some ticks later.
#[derive(Debug, Clone, PartialEq)]
struct RealDrive {
    /// Setpoints that the encoder does not show yet, after the one that it shows now.
    sent: VecDeque<SentSetpoint>,
    /// The setpoint to which the reading of the encoder belongs.
    shown: SentSetpoint,
    /// Raw counts of the encoder in the last two ticks.
    raw: [i64; 2],
    /// Raw count of the axis' zero.
    zero: i64,
    /// Error at which the axis counts as on its setpoint (counts).
    window: f64,
}

impl RealDrive {
    /// Positions in the last two ticks, from the present zero (counts).
    fn positions(&self) -> [f64; 2] {
        self.raw.map(|raw| raw.saturating_sub(self.zero) as f64)
    }

    /// Returns whether every setpoint on its way, and the shown one, rests there (counts from the present zero).
    fn rests_at(&self, position: f64) -> bool {
        let raw = position + self.zero as f64;
        let rests =
            |sent: &SentSetpoint| sent.velocity == 0.0 && (sent.position + sent.zero as f64 - raw).abs() < SAME_COUNT;
        rests(&self.shown) && self.sent.iter().all(rests)
    }

    /// Reading of the encoder, from the zero of the tick that it belongs to (counts).
    fn reading(&self) -> i64 {
        self.raw[1].saturating_sub(self.shown.zero)
    }
}

/// One axis while it runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisState {
    pub(crate) scale: AxisScale,
    pub(crate) counts_per_unit: f64,
    pub(crate) homed: bool,
    /// True count at which the reading is 0.
    origin: i64,
    inertia: f64,
    /// Largest deceleration of a stop of the machine's own (counts/s²).
    stop: f64,
    previous: AxisSetpoint,
    target: AxisSetpoint,
    servo: Servo,
    /// Part of the distance of this tick that the setpoint has gone (counts).
    gone: f64,
    /// The encoder reads this much more than the axis has moved (counts).
    encoder_offset: f64,
    settled_ticks: u32,
    clamped: bool,
    velocity_before: f64,
    /// Force of the motor (N or N m) in the servo steps of this tick, and their number.
    pushed: (f64, f64),
    /// Force on the axis that is not the motor's, in the last servo step (N or N m).
    disturbance: f64,
    /// The drive of a real axis; a simulated one has its servo.
    real: Option<Box<RealDrive>>,
}

crate::snapshot!(AxisState {
    homed, origin, previous, target, servo, gone, encoder_offset, settled_ticks, clamped, velocity_before, pushed, disturbance,
} on { scale, counts_per_unit, inertia, stop, real });

impl AxisState {
    pub(crate) fn new(axis: &AxisDescription, step_s: f64) -> Self {
        let start = axis.scale.counts(axis.power_up_position);
        let counts_per_unit = axis.scale.counts_per_unit();
        let target = AxisSetpoint::resting(start as f64);
        Self {
            scale: axis.scale,
            counts_per_unit,
            homed: !axis.needs_homing,
            origin: if axis.needs_homing { start } else { 0 },
            inertia: axis.inertia,
            stop: axis.limits.acceleration * counts_per_unit,
            previous: target,
            target,
            servo: Servo::new(axis, step_s),
            gone: 0.0,
            encoder_offset: 0.0,
            settled_ticks: 0,
            clamped: true,
            velocity_before: 0.0,
            pushed: (0.0, 0.0),
            disturbance: 0.0,
            real: None,
        }
    }

    /// A real axis that rests where its encoder reads `raw`, and whose readings are so many ticks old. An axis that is to be homed has
    /// its zero there until then.
    pub(crate) fn real(axis: &AxisDescription, step_s: f64, raw: i64, (lag_ticks, window): (usize, f64)) -> Self {
        let simulated = Self::new(axis, step_s);
        let zero = if axis.needs_homing { raw } else { 0 };
        let target = AxisSetpoint::resting(raw.saturating_sub(zero) as f64);
        let shown = SentSetpoint { position: target.position, velocity: 0.0, zero };
        // One place more: a setpoint is added before the oldest one is taken.
        let mut sent = VecDeque::with_capacity(lag_ticks + 1);
        sent.extend(core::iter::repeat_n(shown, lag_ticks));
        let drive = RealDrive { sent, shown, raw: [raw; 2], zero, window };
        Self { origin: 0, previous: target, target, real: Some(Box::new(drive)), ..simulated }
    }

    /// The encoder of a real drive reads `raw`; the setpoint of this tick is on its way.
    pub(crate) fn measure(&mut self, raw: i64) {
        let Some(real) = &mut self.real else { return };
        let AxisSetpoint { position, velocity, .. } = self.target;
        real.sent.push_back(SentSetpoint { position, velocity, zero: real.zero });
        if let Some(shown) = real.sent.pop_front() {
            real.shown = shown;
        }
        real.raw = [real.raw[1], raw];
    }

    /// Servo step `index` of `count` of a tick whose encoder reading is known: the axis goes evenly from the reading before to this one.
    fn measured_step(&mut self, index: u32, count: u32, step_s: f64) -> Span {
        let Some(real) = &self.real else { return self.still() };
        let [before, now] = real.positions();
        let error = real.shown.position - real.reading() as f64;
        if self.clamped && error.abs() < real.window {
            return self.still();
        }
        self.clamped = false;
        let velocity = (now - before) / (step_s * f64::from(count));
        let at = |index: u32| before + (now - before) * f64::from(index) / f64::from(count);
        self.gone = self.distance();
        self.servo.measure(self.target.position - at(index + 1), velocity);
        Span { from: at(index), to: at(index + 1), from_velocity: velocity, to_velocity: velocity }
    }

    /// A servo step of a real axis without power: its setpoint is where it is, to the window.
    fn measured_coast(&mut self, index: u32, count: u32, step_s: f64) -> Span {
        let Some(real) = &self.real else { return self.still() };
        let [before, now] = real.positions();
        let at = |index: u32| before + (now - before) * f64::from(index) / f64::from(count);
        let velocity = (now - before) / (step_s * f64::from(count));
        let (moves, rests) = ((now - self.target.position).abs() >= real.window, real.rests_at(self.target.position));
        // Noise of the encoder does not move the setpoint.
        if moves {
            self.target = AxisSetpoint::resting(now);
        }
        self.previous = self.target;
        self.gone = 0.0;
        self.servo.measure(0.0, velocity);
        if index + 1 == count {
            self.settled_ticks = if moves { 0 } else { self.settled_ticks.saturating_add(1) };
            self.clamped = self.settled_ticks >= SETTLED_TICKS && rests;
            if self.clamped {
                self.servo.clamp();
            }
        }
        Span { from: at(index), to: at(index + 1), from_velocity: velocity, to_velocity: velocity }
    }

    fn still(&self) -> Span {
        let position = self.true_position();
        Span { from: position, to: position, from_velocity: 0.0, to_velocity: 0.0 }
    }

    /// Position in the middle of a tick (counts, true): an edge of a wired input lies in it somewhere.
    pub(crate) fn middle_of_tick(&self) -> f64 {
        self.real.as_ref().map_or_else(|| self.true_position(), |real| 0.5 * real.positions().iter().sum::<f64>())
    }

    /// Position at which a real encoder reads `raw` (counts, true).
    pub(crate) fn position_at(&self, raw: i64) -> f64 {
        raw.saturating_sub(self.real.as_ref().map_or(0, |real| real.zero)) as f64
    }

    pub(crate) fn is_real(&self) -> bool {
        self.real.is_some()
    }

    /// Raw count to which a real drive is to go; of a simulated one its true position.
    pub(crate) fn raw_target(&self) -> f64 {
        self.target.position + self.real.as_ref().map_or(0, |real| real.zero) as f64
    }

    /// The setpoint that the readings of this tick belong to, as a reading (counts).
    pub(crate) fn shown_setpoint_counts(&self) -> i64 {
        self.real.as_ref().map_or_else(|| self.setpoint_counts(), |real| nearest_count(real.shown.position))
    }

    /// Velocity of that setpoint (mm/s or rad/s).
    pub(crate) fn shown_setpoint_velocity(&self) -> f64 {
        self.real.as_ref().map_or(self.target.velocity, |real| real.shown.velocity) / self.counts_per_unit
    }

    pub(crate) fn begin_job(&mut self) {
        self.servo.begin_job();
    }

    /// Places the axis at rest at a true position (counts), homed.
    pub(crate) fn place(&mut self, counts: i64) {
        self.origin = 0;
        self.homed = true;
        self.target = AxisSetpoint::resting(counts as f64);
        self.previous = self.target;
        self.servo.place();
        self.clamped = true;
        self.settled_ticks = 0;
        self.disturbance = 0.0;
    }

    /// The reading `counts` is 0 from now on.
    pub(crate) fn set_home(&mut self, counts: i64) {
        self.homed = true;
        match &mut self.real {
            None => self.origin = self.origin.saturating_add(counts),
            // Nothing but the reference says where a real axis is: its positions are counted from there.
            Some(real) => {
                real.zero = real.zero.saturating_add(counts);
                self.target.position -= counts as f64;
                self.previous.position -= counts as f64;
            }
        }
    }

    /// True count at which the reading is 0.
    pub(crate) fn zero(&self) -> i64 {
        self.origin
    }

    /// The same as a true position (mm or rad).
    pub(crate) fn zero_value(&self) -> f64 {
        self.zero() as f64 / self.counts_per_unit
    }

    pub(crate) fn set_gain(&mut self, fraction: f64) {
        self.servo.set_gain(fraction);
    }

    /// The encoder reads `offset` counts more than the axis has moved; the drive takes the difference for an error.
    pub(crate) fn set_encoder_offset(&mut self, offset: f64) {
        self.servo.disturb(offset - self.encoder_offset);
        self.encoder_offset = offset;
        self.clamped = false;
        self.settled_ticks = 0;
    }

    /// The same without power: the axis stays, and what it holds is the new reading.
    pub(crate) fn set_encoder_offset_unpowered(&mut self, offset: f64) {
        self.target.position += offset - self.encoder_offset;
        self.previous = self.target;
        self.encoder_offset = offset;
    }

    pub(crate) fn target(&self) -> &AxisSetpoint {
        &self.target
    }

    /// The present setpoint as a reading (counts).
    pub(crate) fn setpoint_counts(&self) -> i64 {
        nearest_count(self.target.position).saturating_sub(self.origin)
    }

    /// Reading of the encoder (counts).
    pub(crate) fn counts(&self) -> i64 {
        match &self.real {
            Some(_) if self.clamped => self.shown_setpoint_counts(),
            Some(real) => real.reading(),
            None => nearest_count(self.target.position - self.servo.error_seen()).saturating_sub(self.origin),
        }
    }

    /// Reading of the encoder if the load were truly at `position` (counts), with the present play and structure.
    pub(crate) fn reading_at(&self, position: f64) -> i64 {
        let seen = nearest_count(position - self.servo.tool_ahead() + self.encoder_offset).saturating_sub(self.origin);
        // What is latched belongs to a tick before: its zero was another one, if the axis has been homed since.
        self.real.as_ref().map_or(seen, |real| seen.saturating_add(real.zero).saturating_sub(real.shown.zero))
    }

    /// True position of the load (counts): the wheel, or the part.
    pub(crate) fn true_position(&self) -> f64 {
        let slide = self.target.position + (self.gone - self.distance()) - self.servo.error() - self.encoder_offset;
        slide + self.servo.tool_ahead()
    }

    /// True position (mm or rad).
    pub(crate) fn true_value(&self) -> f64 {
        self.true_position() / self.counts_per_unit
    }

    /// Deflection of the structure ahead of the slide (mm or rad), and its rate (1/s).
    pub(crate) fn swing(&self) -> (f64, f64) {
        let (ahead, growth) = self.servo.swing();
        (ahead / self.counts_per_unit, growth / self.counts_per_unit)
    }

    /// Setpoint minus actual (mm or rad).
    pub(crate) fn following_error(&self) -> f64 {
        let error = match &self.real {
            Some(_) if self.clamped => 0.0,
            Some(real) => real.shown.position - real.reading() as f64,
            None => self.servo.error(),
        };
        error / self.counts_per_unit
    }

    /// Velocity (mm/s or rad/s).
    pub(crate) fn velocity(&self) -> f64 {
        self.servo.velocity() / self.counts_per_unit
    }

    /// Velocity of the setpoint (mm/s or rad/s).
    pub(crate) fn setpoint_velocity(&self) -> f64 {
        self.target.velocity / self.counts_per_unit
    }

    /// Mean force (N) or torque (N m) of the motor in the last tick. An ideal drive, and one that brakes without power, has what the
    /// mass needs, against a disturbance.
    pub(crate) fn effort(&self, cycle_time_s: f64, disturbance: f64) -> f64 {
        let (sum, steps) = self.pushed;
        if steps > 0.0 {
            return sum / steps;
        }
        let acceleration = (self.servo.velocity() - self.velocity_before) / self.counts_per_unit / cycle_time_s;
        let force = match self.scale {
            // kg mm/s² is a thousandth of a newton.
            AxisScale::Linear { .. } => self.inertia * acceleration * 1e-3,
            AxisScale::Rotary { .. } => self.inertia * acceleration,
        };
        force - disturbance
    }

    /// Raw count of the encoder, independent of the zero (counts).
    pub(crate) fn reading(&self) -> i64 {
        match &self.real {
            Some(real) => real.raw[1],
            None => nearest_count(self.target.position - self.servo.error_seen()),
        }
    }

    /// Power of the motor in the last tick (W).
    pub(crate) fn power_w(&self, cycle_time_s: f64) -> f64 {
        let power = self.effort(cycle_time_s, self.disturbance) * self.velocity();
        match self.scale {
            // N mm/s.
            AxisScale::Linear { .. } => power * 1e-3,
            AxisScale::Rotary { .. } => power,
        }
    }

    /// Clamped at its resting setpoint.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.clamped
    }

    /// The setpoint neither moves nor moved in this tick.
    fn is_resting(&self) -> bool {
        self.previous.is_resting() && self.target.is_resting() && self.distance() == 0.0
    }

    fn distance(&self) -> f64 {
        self.target.position - self.previous.position
    }

    /// A new setpoint for the tick that begins, as a reading (counts) and its derivatives (mm or rad, s).
    pub(crate) fn follow(&mut self, counts: i64, velocity: f64, acceleration: f64) {
        self.begin(AxisSetpoint {
            position: counts.saturating_add(self.origin) as f64,
            velocity: velocity * self.counts_per_unit,
            acceleration: acceleration * self.counts_per_unit,
        });
    }

    /// The same with something beside it (mm or rad, s): what an alarm adds to the path that it lets end.
    pub(crate) fn follow_beside(&mut self, counts: i64, velocity: f64, acceleration: f64, beside: &Sample) {
        self.begin(AxisSetpoint {
            position: counts.saturating_add(self.origin) as f64 + beside.value * self.counts_per_unit,
            velocity: (velocity + beside.first) * self.counts_per_unit,
            acceleration: (acceleration + beside.second) * self.counts_per_unit,
        });
    }

    /// A setpoint of the machine's own, in true coordinates.
    pub(crate) fn go(&mut self, target: AxisSetpoint) {
        self.begin(target);
    }

    /// Its zero is not known any more.
    pub(crate) fn lose_home(&mut self) {
        self.homed = false;
    }

    /// The setpoint rests where it is.
    pub(crate) fn hold(&mut self) {
        self.begin(AxisSetpoint::resting(self.target.position));
    }

    /// The setpoint rests where it was sent last: nothing newer reached the drive.
    pub(crate) fn starve(&mut self) {
        self.target = AxisSetpoint::resting(libm::round(self.target.position));
        self.previous = self.target;
    }

    /// The setpoint is brought to rest at the axis' acceleration limit, and ends on a count.
    pub(crate) fn decelerate(&mut self, cycle_time_s: f64) {
        let v0 = self.target.velocity;
        if v0 == 0.0 {
            self.begin(AxisSetpoint::resting(libm::round(self.target.position)));
            return;
        }
        let v1 = v0 - libm::copysign((self.stop * cycle_time_s).min(v0.abs()), v0);
        let position = self.target.position + 0.5 * (v0 + v1) * cycle_time_s;
        self.begin(AxisSetpoint { position, velocity: v1, acceleration: (v1 - v0) / cycle_time_s });
    }

    fn begin(&mut self, target: AxisSetpoint) {
        self.previous = self.target;
        self.target = target;
        self.gone = 0.0;
        self.velocity_before = self.servo.velocity();
        self.pushed = (0.0, 0.0);
        if !self.is_resting() {
            self.clamped = false;
            self.settled_ticks = 0;
        }
    }

    /// Servo step `index` of `count` in this tick, each `step_s` long, under power, with a force (N or N m) on the axis.
    pub(crate) fn step(&mut self, index: u32, count: u32, step_s: f64, disturbance: f64) -> Span {
        if self.real.is_some() {
            return self.measured_step(index, count, step_s);
        }
        let from = self.true_position();
        let from_velocity = self.servo.tool_velocity();
        if self.clamped {
            // Its motor holds against what it was clamped with; another force moves it.
            if self.servo.force().is_none() || disturbance.to_bits() == self.disturbance.to_bits() {
                self.push();
                return Span { from, to: from, from_velocity: 0.0, to_velocity: 0.0 };
            }
            self.clamped = false;
            self.settled_ticks = 0;
        }
        self.disturbance = disturbance;
        let tick_s = step_s * f64::from(count);
        let s = f64::from(index + 1) / f64::from(count);
        let (slope0, slope1) = (self.previous.velocity * tick_s, self.target.velocity * tick_s);
        let gone = cubic_path(s, self.distance(), slope0, slope1);
        // The derivative of the cubic; at its end the setpoint's own velocity, free of the rounding to counts.
        let velocity = if index + 1 == count {
            self.target.velocity
        } else {
            cubic_slope(s, self.distance(), slope0, slope1) / tick_s
        };
        let middle = s - 0.5 / f64::from(count);
        let acceleration =
            self.previous.acceleration + (self.target.acceleration - self.previous.acceleration) * middle;
        self.servo.step(ServoCommand {
            position: self.previous.position + gone,
            distance: gone - self.gone,
            velocity,
            acceleration,
            disturbance,
        });
        self.gone = gone;
        self.push();
        Span { from, to: self.true_position(), from_velocity, to_velocity: self.servo.tool_velocity() }
    }

    /// Adds up what the motor pushes with.
    fn push(&mut self) {
        if let Some(force) = self.servo.force() {
            self.pushed = (self.pushed.0 + force, self.pushed.1 + 1.0);
        }
    }

    /// The drive loses its power: the setpoint is where the axis is.
    pub(crate) fn release(&mut self) {
        self.target = AxisSetpoint::resting(self.target.position - self.servo.error());
        self.previous = self.target;
        self.gone = 0.0;
        self.servo.release();
        self.clamped = false;
        self.settled_ticks = 0;
    }

    /// A tick without power begins.
    pub(crate) fn begin_coasting(&mut self) {
        self.velocity_before = self.servo.velocity();
        self.pushed = (0.0, 0.0);
        self.disturbance = 0.0;
    }

    /// One servo step without power: the axis brakes and takes its setpoint along; it ends on a count.
    pub(crate) fn coast(&mut self, index: u32, count: u32, step_s: f64) -> Span {
        if self.real.is_some() {
            return self.measured_coast(index, count, step_s);
        }
        let from = self.true_position();
        let from_velocity = self.servo.tool_velocity();
        let position = self.target.position + self.servo.coast();
        let resting = self.servo.velocity() == 0.0 && self.servo.is_quiet();
        self.target = AxisSetpoint::resting(if resting { libm::round(position) } else { position });
        self.previous = self.target;
        self.clamped = resting;
        if resting {
            self.servo.clamp();
        }
        Span { from, to: self.true_position(), from_velocity, to_velocity: self.servo.tool_velocity() }
    }

    /// One servo step without power, drawn outwards to `end` (counts, true): see [`Servo::draw`].
    pub(crate) fn draw(&mut self, pull: f64, fastest: f64, end: f64) -> Span {
        let from = self.true_position();
        let from_velocity = self.servo.tool_velocity();
        let position = self.target.position + self.servo.draw(pull, end - from, fastest);
        self.target = AxisSetpoint::resting(position);
        self.previous = self.target;
        self.clamped = false;
        Span { from, to: self.true_position(), from_velocity, to_velocity: self.servo.tool_velocity() }
    }

    /// End of a tick under power: the rest rule.
    ///
    /// A resting setpoint, an error within the window of the drive (half a count where nothing is coarser), a speed within as much per
    /// tick and a quiet structure, for [`SETTLED_TICKS`] ticks: then the axis is clamped exactly on its setpoint with no speed, and
    /// nothing of it changes any more until the setpoint or the force on it does. So the number of idle ticks changes no bit of what
    /// follows. An error e₀ (counts) needs about ln(2 e₀)/Kv to get there, for a velocity loop of bandwidth w < 4 Kv about
    /// ln(2 e₀)·2/w, a structure as long as it rings, then 8 ticks.
    pub(crate) fn end_tick(&mut self, cycle_time_s: f64) {
        self.gone = self.distance();
        if self.clamped || !self.is_resting() {
            return;
        }
        let window = self.real.as_ref().map_or_else(|| self.servo.window(), |real| real.window);
        // What is on its way to a real drive moves it still.
        let is_shown = self.real.as_ref().is_none_or(|real| real.rests_at(self.target.position));
        let close = is_shown
            && self.servo.error().abs() < window
            && self.servo.velocity().abs() * cycle_time_s < window
            && self.servo.is_quiet();
        self.settled_ticks = if close { self.settled_ticks + 1 } else { 0 };
        if self.settled_ticks >= SETTLED_TICKS {
            self.servo.clamp();
            self.clamped = true;
            self.settled_ticks = 0;
        }
    }
}
