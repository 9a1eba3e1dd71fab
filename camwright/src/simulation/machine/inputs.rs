//! Inputs, encoders and gauges that cannot be as they are.

use super::Machine;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{AXIS_COUNT, Axis, Homing};
use crate::machine::setpoint::{Input, Latch};
use crate::math::fixed_list::FixedList;
use crate::math::snapshot::{Kept, Tape, TapeError};
use crate::math::units::TURN_RAD;
use crate::simulation::axis::{AxisState, Span};
use crate::simulation::fault::{GaugeFault, ORIGIN_TOLERANCE_RAD};
use crate::simulation::sensors::{OriginDetector, StationSwitch};
use crate::simulation::tick_report::MAX_LATCHES;
use crate::simulation::workpiece::Removal;

/// How far from its edges a switch must show what the table's position says (mm): dogs are set by hand.
const SWITCH_TOLERANCE_MM: f64 = 1.0;
/// Ticks for which a level may be wrong: filters of inputs take as long.
const WRONG_TICKS: u32 = 3;
/// Edges of one switch within [`BOUNCE_S`] that no dog can make.
const BOUNCES: u32 = 3;
/// A window of bounces (s).
const BOUNCE_S: f64 = 0.02;
/// Jump of an encoder beyond what acceleration explains (counts): rounding of three readings, and noise.
const JUMP_COUNTS: f64 = 20.0;
/// The same reading so often is suspicious.
const STUCK_READINGS: u32 = 100;
/// Depth that must have been cut all round meanwhile, for a gauge without noise (mm), besides two steps of its reading.
const STUCK_DEPTH_MM: f64 = 5.0e-4;

/// What a slide is homed on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct References {
    pub(super) switch: StationSwitch,
    marks: Option<OriginDetector>,
}

impl Kept for References {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let Self { switch, marks } = self;
        tape.field("switch", |tape| switch.keep(tape))?;
        tape.field("marks", |tape| marks.as_mut().map_or(Ok(()), |marks| marks.keep(tape)))
    }
}

impl References {
    /// A switch that stays closed from where it closes to the end of the travel, and the marks of the encoder.
    pub(super) fn new(homing: &Homing, hysteresis_mm: f64, axis: &AxisState) -> Self {
        let per_mm = axis.counts_per_unit;
        let at = axis.scale.counts(homing.switch_mm) as f64;
        // No travel is longer.
        let beyond = 1.0e7 * per_mm;
        let start = if homing.search_mm_s < 0.0 { at - beyond } else { at };
        let pitch = libm::round(homing.index_pitch_mm * per_mm);
        Self {
            switch: StationSwitch::new(start, beyond, hysteresis_mm * per_mm, axis.true_position()),
            marks: (homing.use_index && pitch >= 1.0).then(|| OriginDetector::new(pitch, 0.0)),
        }
    }
}

/// What is remembered of one switch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SwitchWatch {
    wrong_ticks: u32,
    level: Option<bool>,
    /// Reading of the table where it closed last (counts).
    closed_at: f64,
    edges: u32,
    first_edge_tick: u64,
}

crate::kept!(SwitchWatch { wrong_ticks, level, closed_at, edges, first_edge_tick } on {});

/// What is remembered of the gauge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct GaugeWatch {
    pub(super) fault: Option<GaugeFault>,
    pub(super) last: [Option<f64>; 2],
    /// How often each was the same, how far C turned meanwhile (rad), and the area cut after the first turn of it (mm²).
    same: [u32; 2],
    turned_rad: [f64; 2],
    cut_mm2: [f64; 2],
}

crate::kept!(GaugeWatch { fault, last, same, turned_rad, cut_mm2 } on {});

impl Machine {
    /// Level of an input as the control sees it.
    pub(super) fn level(&self, input: Input) -> bool {
        let own = |input: Input| match input {
            Input::Origin => self.origin.is_closed(self.axes[Axis::C.index()].true_position()),
            Input::Station(index) => self.stations.get(index).is_some_and(StationSwitch::is_closed),
            Input::Home(axis) => self.references[axis.index()].as_ref().is_some_and(|own| own.switch.is_closed()),
            Input::Index(_) => false,
            Input::SteadyForce => self.force_monitor.is_closed(),
            Input::WheelContact => self.gap.is_some_and(|gap| gap.is_closed()),
            Input::KeyWay => self.sees_key_way(),
        };
        own(input) || self.partner(input).is_some_and(own)
    }

    /// The input on the same line.
    fn partner(&self, input: Input) -> Option<Input> {
        match self.shared? {
            [one, other] if one == input => Some(other),
            [one, other] if other == input => Some(one),
            _ => None,
        }
    }

    /// Inputs along a servo step.
    pub(super) fn sense(&mut self, spans: &[Span; AXIS_COUNT], latches: &mut FixedList<Latch, MAX_LATCHES>) {
        let (headstock, table) = (&spans[Axis::C.index()], &spans[Axis::Z.index()]);
        if !headstock.is_still() {
            let edge = self.origin.edge(headstock.from, headstock.to);
            if let Some(edge) = edge {
                self.catch(Input::Origin, edge.rising, edge.position, latches);
            } else if self.axes[Axis::C.index()].homed && self.origin.mark(headstock.from, headstock.to).is_some() {
                self.raise(AlarmKind::OriginDetector, 0.0, ORIGIN_TOLERANCE_RAD);
            }
        }
        self.sense_key_way(spans, latches);
        self.sense_references(spans, latches);
        for index in 0..self.stations.len() {
            if !table.is_still() {
                for edge in self.stations[index].pass(table.from, table.to).into_iter().flatten() {
                    self.catch(Input::Station(index), edge.rising, edge.position, latches);
                }
            }
            if let Some(edge) = self.stations[index].bounce(table.to) {
                self.catch(Input::Station(index), edge.rising, edge.position, latches);
            }
        }
    }

    /// Home switches and index marks along a servo step.
    fn sense_references(&mut self, spans: &[Span; AXIS_COUNT], latches: &mut FixedList<Latch, MAX_LATCHES>) {
        for axis in Axis::ALL {
            let span = &spans[axis.index()];
            let Some(own) = &mut self.references[axis.index()] else { continue };
            let (edges, mark) = if span.is_still() {
                ([None, None], None)
            } else {
                (own.switch.pass(span.from, span.to), own.marks.and_then(|marks| marks.mark(span.from, span.to)))
            };
            let bounce = own.switch.bounce(span.to);
            for edge in edges.into_iter().flatten().chain(bounce) {
                self.catch(Input::Home(axis), edge.rising, edge.position, latches);
            }
            if let Some(mark) = mark {
                self.catch(Input::Index(axis), true, mark.position, latches);
            }
        }
    }

    /// The force at the end of a tick, under the part as it stands.
    pub(super) fn watch_force(&mut self, latches: &mut FixedList<Latch, MAX_LATCHES>) {
        let headstock = &self.axes[Axis::C.index()];
        let position = headstock.true_position();
        if let Some(closed) = self.force_monitor.tick(position / headstock.counts_per_unit, self.force_n) {
            self.catch(Input::SteadyForce, closed, position, latches);
        }
    }

    /// The zero of an axis is forgotten; whether it stands on its home switch is told like an edge.
    pub(super) fn lose_home(&mut self, axis: Axis) {
        self.axes[axis.index()].lose_home();
        if self.references[axis.index()].is_some() {
            self.tell_level(Input::Home(axis));
        }
    }

    /// Somebody asks whether an input is closed: if it is, that is told like an edge.
    pub(super) fn tell_level(&mut self, input: Input) {
        if self.level(input) {
            let axis = input.axis();
            let state = &self.axes[axis.index()];
            let counts = state.reading_at(state.true_position());
            self.asked.push(Latch { tick: self.tick, input, rising: true, axis, counts });
        }
    }

    /// An edge, and the same on the input that lies on the same line.
    fn catch(&mut self, input: Input, rising: bool, position: f64, latches: &mut FixedList<Latch, MAX_LATCHES>) {
        let partner = self.partner(input);
        self.catch_one(input, rising, Some(position), latches);
        if let Some(partner) = partner {
            self.catch_one(partner, rising, None, latches);
        }
    }

    pub(super) fn catch_one(
        &mut self,
        input: Input,
        rising: bool,
        position: Option<f64>,
        latches: &mut FixedList<Latch, MAX_LATCHES>,
    ) {
        let axis = input.axis();
        let state = &self.axes[axis.index()];
        let position = position.unwrap_or_else(|| state.true_position());
        latches.push(Latch { tick: self.tick, input, rising, axis, counts: state.reading_at(position) });
        match input {
            Input::Origin => {
                let off_rad = self.origin.off_mark(position) / state.counts_per_unit;
                if rising && off_rad > ORIGIN_TOLERANCE_RAD {
                    self.raise(AlarmKind::OriginDetector, off_rad, ORIGIN_TOLERANCE_RAD);
                }
            }
            Input::Station(index) => self.note_edge(index, rising, state.reading_at(position)),
            Input::Home(_) | Input::Index(_) | Input::SteadyForce | Input::WheelContact | Input::KeyWay => {}
        }
    }

    #[allow(clippy::cast_possible_truncation, reason = "20 ms are few ticks")]
    fn note_edge(&mut self, station: usize, rising: bool, reading: i64) {
        let window = libm::ceil(BOUNCE_S / self.description.cycle_time_s()) as u64;
        let Some(watch) = self.switch_watch.get_mut(station) else { return };
        if watch.edges == 0 || self.tick > watch.first_edge_tick + window {
            *watch = SwitchWatch { edges: 0, first_edge_tick: self.tick, ..*watch };
        }
        if rising {
            watch.closed_at = reading as f64;
        }
        watch.edges += 1;
        if watch.edges >= BOUNCES {
            watch.edges = 0;
            self.raise(AlarmKind::SwitchBounces, (station + 1) as f64, 0.0);
        }
    }

    /// A switch must show what the table's position says, away from where its dog begins and ends; and where it has closed it must stay
    /// so until the table has gone back by its hysteresis, or over the dog.
    pub(super) fn watch_switches(&mut self) {
        let table = &self.axes[Axis::Z.index()];
        if !table.homed {
            return;
        }
        let (reading, tolerance) = (table.counts() as f64, SWITCH_TOLERANCE_MM * table.counts_per_unit);
        let rests = table.is_at_rest();
        for index in 0..self.stations.len() {
            let expected = self.stations[index].expected(reading, tolerance);
            let wrong = expected.is_some_and(|expected| expected != self.level(Input::Station(index)));
            let level = self.level(Input::Station(index));
            let Some(watch) = self.switch_watch.get_mut(index) else { continue };
            // Nothing presses a switch while the table rests.
            let changed = watch.level.replace(level).is_some_and(|before| before != level);
            let dropped = changed && !level && self.stations[index].must_hold(watch.closed_at, reading);
            watch.wrong_ticks = if wrong { watch.wrong_ticks.saturating_add(1) } else { 0 };
            if watch.wrong_ticks > WRONG_TICKS || (changed && rests) || dropped {
                self.raise(AlarmKind::LimitSwitch, (index + 1) as f64, 0.0);
            }
        }
    }

    /// Three readings in a row tell the acceleration; none can exceed what the drive can do.
    pub(super) fn watch_encoders(&mut self) {
        let cycle_time_s = self.description.cycle_time_s();
        for axis in Axis::ALL {
            let i = axis.index();
            let state = &self.axes[i];
            let now = state.reading();
            let [before, last] = self.readings[i];
            self.readings[i] = [last, now];
            let description = &self.description.axes[i];
            let most = 2.0 * description.most_acceleration() * state.counts_per_unit * cycle_time_s * cycle_time_s
                + JUMP_COUNTS
                + 4.0 * (description.drive.encoder_step_counts + description.drive.encoder_noise_counts);
            let jump = (now.saturating_sub(last)).saturating_sub(last.saturating_sub(before)).unsigned_abs() as f64;
            if jump > most {
                let per_unit = state.counts_per_unit;
                // The reading after it is as far off the other way.
                self.readings[i] = [now, now];
                if self.description.axes[i].needs_homing {
                    self.axes[i].lose_home();
                }
                self.raise(AlarmKind::EncoderJump(axis), jump / per_unit, most / per_unit);
            }
        }
    }

    /// A gauge that gives no number, or the same one however much is cut.
    pub(super) fn watch_gauge(&mut self, readings_mm: [Option<f64>; 2], lobe: Option<usize>, removal: Removal) {
        let Some(description) = self.description.gauge else { return };
        let headstock = &self.axes[Axis::C.index()];
        let turned_rad = headstock.velocity().abs() * self.description.cycle_time_s();
        let round_mm = lobe.map_or(f64::INFINITY, |lobe| TURN_RAD * self.part.lobes()[lobe].reach_mm());
        for (i, reading) in readings_mm.into_iter().enumerate() {
            let Some(reading) = reading else { continue };
            if !reading.is_finite() {
                self.raise(AlarmKind::GaugeInvalid, 0.0, 0.0);
                continue;
            }
            let watch = &mut self.gauge_watch;
            let is_same = watch.last[i].is_some_and(|last| last.to_bits() == reading.to_bits());
            watch.last[i] = Some(reading);
            // Only while something is cut.
            if !is_same {
                (watch.same[i], watch.turned_rad[i], watch.cut_mm2[i]) = (0, 0.0, 0.0);
            } else if removal.area_mm2 > 0.0 {
                watch.same[i] = watch.same[i].saturating_add(1);
                watch.turned_rad[i] += turned_rad;
                // What is cut comes under the contact within a turn.
                watch.cut_mm2[i] += if watch.turned_rad[i] > TURN_RAD { removal.area_mm2 } else { 0.0 };
            }
            // Noise larger than a step never rests; without it, what is cut must show.
            let is_noisy = description.noise_mm > description.resolution_mm && description.noise_mm > 0.0;
            let must_show = watch.cut_mm2[i] / round_mm > STUCK_DEPTH_MM + 2.0 * description.resolution_mm;
            let count = watch.same[i];
            if count >= STUCK_READINGS && (is_noisy || must_show) {
                self.raise(AlarmKind::GaugeStuck, f64::from(count), 0.0);
            }
        }
    }
}
