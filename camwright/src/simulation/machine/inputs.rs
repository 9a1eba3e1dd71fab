// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Switches and marks that the axes pass, and supervision of inputs that contradict each other.

use super::probes::Keyway;
use super::supervision::Supervision;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{AXIS_COUNT, Axis, Homing, MachineDescription};
use crate::machine::setpoint::{Input, Latch};
use crate::math::fixed_list::FixedList;
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::math::units::TURN_RAD;
use crate::simulation::axis::{AxisState, Span};
use crate::simulation::fault::ORIGIN_TOLERANCE_RAD;
use crate::simulation::measured::WiredInputs;
use crate::simulation::sensors::{OriginDetector, StationSwitch};
use crate::simulation::tick_report::MAX_LATCHES;
use alloc::vec::Vec;

/// Distance from its edges at which a switch must show what the table's position implies (mm): dogs are set by hand.
const SWITCH_TOLERANCE_MM: f64 = 1.0;
/// Ticks for which a level may be wrong: filters of inputs take as long.
const WRONG_TICKS: u32 = 3;
/// Edges of one switch within [`BOUNCE_S`] that no dog can make.
const BOUNCES: u32 = 3;
/// A window of bounces (s).
const BOUNCE_S: f64 = 0.02;

/// Home switch and index marks of a slide.
#[derive(Debug, Clone, PartialEq)]
struct References {
    switch: StationSwitch,
    marks: Option<OriginDetector>,
}

impl Snapshot for References {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self { switch, marks } = self;
        fields!(codec: switch);
        equipment!(codec: marks);
        Ok(())
    }
}

impl References {
    /// A switch that stays closed from where it closes to the end of the travel, and the marks of the encoder.
    fn new(homing: &Homing, hysteresis_mm: f64, axis: &AxisState) -> Self {
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

/// History of one station's switch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct SwitchWatch {
    wrong_ticks: u32,
    level: Option<bool>,
    /// Reading of the table where it closed last (counts).
    closed_at: f64,
    edges: u32,
    first_edge_tick: u64,
}

crate::snapshot!(SwitchWatch { wrong_ticks, level, closed_at, edges, first_edge_tick } on {});

/// Levels of the inputs that no axis closes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProcessLevels {
    pub(super) steady_force: bool,
    pub(super) wheel_contact: bool,
    pub(super) key_way: bool,
    pub(super) size_reached: bool,
}

/// Edges and alarms of a tick in progress.
pub(super) struct Sensing<'a> {
    pub(super) tick: u64,
    pub(super) axes: &'a [AxisState; AXIS_COUNT],
    pub(super) latches: &'a mut FixedList<Latch, MAX_LATCHES>,
    pub(super) supervision: &'a mut Supervision,
}

impl Sensing<'_> {
    /// Latches the reading at an edge; without a position, the one at the end of the servo step.
    pub(super) fn latch(&mut self, input: Input, rising: bool, position: Option<f64>) {
        let axis = input.axis();
        let state = &self.axes[axis.index()];
        let counts = state.reading_at(position.unwrap_or_else(|| state.true_position()));
        self.latches.push(Latch { tick: self.tick, input, rising, axis, counts });
    }

    fn raise(&mut self, kind: AlarmKind, value: f64, bound: f64) {
        self.supervision.raise(self.tick, kind, value, bound);
    }
}

/// Inputs along the axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Inputs {
    origin: OriginDetector,
    stations: Vec<StationSwitch>,
    /// References of the slides that have any.
    references: [Option<References>; AXIS_COUNT],
    /// Levels that a command asked for, to be reported with the next tick.
    asked: FixedList<Latch, 4>,
    /// Inputs on one line.
    shared: Option<[Input; 2]>,
    switch_watch: Vec<SwitchWatch>,
    /// Ticks in a window of bounces.
    bounce_ticks: u64,
    /// Levels of a real machine in the last two ticks; a simulated one has its own switches.
    wired: Option<[WiredInputs; 2]>,
}

/// Optional equipment of each axis.
macro_rules! each_equipment {
    ($codec:ident: $field:ident) => {
        for (index, $field) in $field.iter_mut().enumerate() {
            $codec.item(index, |codec| {
                equipment!(codec: $field);
                Ok(())
            })?;
        }
    };
}

snapshot_groups!(Inputs {
    keep_switches(fields: origin, stations, asked, shared, switch_watch),
    keep_references(each_equipment: references),
} on { bounce_ticks, wired });

impl Inputs {
    #[allow(clippy::cast_possible_truncation, reason = "20 ms are few ticks")]
    pub(super) fn new(description: &MachineDescription, axes: &[AxisState; AXIS_COUNT]) -> Self {
        let table = &axes[Axis::Z.index()];
        let per_mm = table.counts_per_unit;
        let stations = description.stations.iter().map(|station| {
            let start = table.scale.counts(station.position_mm) as f64;
            let (dog, hysteresis) = (description.dog_length_mm * per_mm, description.switch_hysteresis_mm * per_mm);
            StationSwitch::new(start, dog, hysteresis, table.true_position())
        });
        let turn = TURN_RAD * axes[Axis::C.index()].counts_per_unit;
        Self {
            origin: OriginDetector::new(libm::round(turn), description.origin_half_window_rad),
            stations: stations.collect(),
            references: core::array::from_fn(|i| {
                let homing = description.axes[i].homing.as_ref()?;
                Some(References::new(homing, description.switch_hysteresis_mm, &axes[i]))
            }),
            asked: FixedList::new(),
            shared: None,
            switch_watch: alloc::vec![SwitchWatch::default(); description.stations.len()],
            bounce_ticks: libm::ceil(BOUNCE_S / description.cycle_time_s()) as u64,
            wired: None,
        }
    }

    /// Reads every switch anew with the axes where they stand.
    pub(super) fn restart(&mut self, axes: &[AxisState; AXIS_COUNT]) {
        let table = axes[Axis::Z.index()].true_position();
        for switch in &mut self.stations {
            switch.update(table);
        }
        for (references, axis) in self.references.iter_mut().zip(axes) {
            if let Some(references) = references {
                references.switch.update(axis.true_position());
            }
        }
        self.switch_watch.fill(SwitchWatch::default());
    }

    /// Level of an input as the control sees it.
    pub(super) fn level(&self, input: Input, axes: &[AxisState; AXIS_COUNT], process: ProcessLevels) -> bool {
        let wired = |input: Input| self.wired?[1].level(input);
        let own = |input: Input| match input {
            _ if let Some(level) = wired(input) => level,
            Input::Origin => self.origin.is_closed(axes[Axis::C.index()].true_position()),
            Input::Station(index) => self.stations.get(index).is_some_and(StationSwitch::is_closed),
            Input::Home(axis) => self.references[axis.index()].as_ref().is_some_and(|own| own.switch.is_closed()),
            Input::Index(_) => false,
            Input::SteadyForce => process.steady_force,
            Input::WheelContact => process.wheel_contact,
            Input::KeyWay => process.key_way,
            Input::SizeReached => process.size_reached,
        };
        own(input) || self.partner(input).is_some_and(own)
    }

    pub(super) fn station_count(&self) -> usize {
        self.stations.len()
    }

    /// Input on the same line.
    fn partner(&self, input: Input) -> Option<Input> {
        match self.shared? {
            [one, other] if one == input => Some(other),
            [one, other] if other == input => Some(one),
            _ => None,
        }
    }

    /// Senses the edges along a servo step.
    pub(super) fn sense(&mut self, spans: &[Span; AXIS_COUNT], key_way: Option<&Keyway>, sensing: &mut Sensing<'_>) {
        let (headstock, table) = (&spans[Axis::C.index()], &spans[Axis::Z.index()]);
        if !headstock.is_still() {
            let edge = self.origin.edge(headstock.from, headstock.to);
            if let Some(edge) = edge {
                self.catch(Input::Origin, edge.rising, edge.position, sensing);
            } else if sensing.axes[Axis::C.index()].homed && self.origin.mark(headstock.from, headstock.to).is_some() {
                sensing.raise(AlarmKind::OriginDetector, 0.0, ORIGIN_TOLERANCE_RAD);
            }
            for edge in key_way.into_iter().flat_map(|key_way| key_way.edges(headstock)).flatten() {
                sensing.latch(Input::KeyWay, edge.rising, Some(edge.position));
            }
        }
        self.sense_references(spans, sensing);
        for index in 0..self.stations.len() {
            if !table.is_still() {
                for edge in self.stations[index].pass(table.from, table.to).into_iter().flatten() {
                    self.catch(Input::Station(index), edge.rising, edge.position, sensing);
                }
            }
            if let Some(edge) = self.stations[index].bounce(table.to) {
                self.catch(Input::Station(index), edge.rising, edge.position, sensing);
            }
        }
    }

    /// The levels of a real machine in a new tick.
    pub(super) fn wire(&mut self, now: WiredInputs) {
        let before = self.wired.map_or(now, |[_, before]| before);
        self.wired = Some([before, now]);
    }

    /// Catches the edges of wired inputs: each lies somewhere in the tick, and is taken to lie in its middle. The encoder itself has
    /// caught the index marks.
    pub(super) fn sense_wired(&mut self, marks: &[Option<i64>; AXIS_COUNT], sensing: &mut Sensing<'_>) {
        let Some([before, now]) = self.wired else { return };
        let homes = Axis::ALL.into_iter().map(Input::Home);
        let stations = (0..self.stations.len()).map(Input::Station);
        for input in core::iter::once(Input::Origin).chain(homes).chain(stations) {
            let (was, is) = (before.level(input), now.level(input));
            if let Some(rising) = is.filter(|_| was != is) {
                let position = sensing.axes[input.axis().index()].middle_of_tick();
                self.catch(input, rising, position, sensing);
            }
        }
        for (axis, mark) in Axis::ALL.into_iter().zip(marks) {
            if let Some(raw) = *mark {
                let position = sensing.axes[axis.index()].position_at(raw);
                self.catch(Input::Index(axis), true, position, sensing);
            }
        }
    }

    /// Senses home switches and index marks along a servo step.
    fn sense_references(&mut self, spans: &[Span; AXIS_COUNT], sensing: &mut Sensing<'_>) {
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
                self.catch(Input::Home(axis), edge.rising, edge.position, sensing);
            }
            if let Some(mark) = mark {
                self.catch(Input::Index(axis), true, mark.position, sensing);
            }
        }
    }

    /// Reports a level as an edge with the next tick, if the input is closed.
    pub(super) fn ask(&mut self, input: Input, axes: &[AxisState; AXIS_COUNT], process: ProcessLevels, tick: u64) {
        if self.level(input, axes, process) {
            let axis = input.axis();
            let state = &axes[axis.index()];
            let counts = state.reading_at(state.true_position());
            self.asked.push(Latch { tick, input, rising: true, axis, counts });
        }
    }

    pub(super) fn has_references(&self, axis: Axis) -> bool {
        self.references[axis.index()].is_some()
    }

    pub(super) fn take_asked(&mut self) -> FixedList<Latch, 4> {
        core::mem::take(&mut self.asked)
    }

    /// Catches an edge, and the same on the input that lies on the same line.
    pub(super) fn catch(&mut self, input: Input, rising: bool, position: f64, sensing: &mut Sensing<'_>) {
        self.catch_one(input, rising, Some(position), sensing);
        if let Some(partner) = self.partner(input) {
            self.catch_one(partner, rising, None, sensing);
        }
    }

    fn catch_one(&mut self, input: Input, rising: bool, position: Option<f64>, sensing: &mut Sensing<'_>) {
        sensing.latch(input, rising, position);
        let state = &sensing.axes[input.axis().index()];
        let position = position.unwrap_or_else(|| state.true_position());
        match input {
            Input::Origin => {
                let off_rad = self.origin.off_mark(position) / state.counts_per_unit;
                // The mark of a real headstock is where homing finds it.
                let is_known = state.homed || !state.is_real();
                if rising && is_known && off_rad > ORIGIN_TOLERANCE_RAD {
                    sensing.raise(AlarmKind::OriginDetector, off_rad, ORIGIN_TOLERANCE_RAD);
                }
            }
            Input::Station(index) => self.note_edge(index, rising, state.reading_at(position), sensing),
            Input::Home(_)
            | Input::Index(_)
            | Input::SteadyForce
            | Input::WheelContact
            | Input::KeyWay
            | Input::SizeReached => {}
        }
    }

    fn note_edge(&mut self, station: usize, rising: bool, reading: i64, sensing: &mut Sensing<'_>) {
        let Some(watch) = self.switch_watch.get_mut(station) else { return };
        if watch.edges == 0 || sensing.tick > watch.first_edge_tick + self.bounce_ticks {
            *watch = SwitchWatch { edges: 0, first_edge_tick: sensing.tick, ..*watch };
        }
        if rising {
            watch.closed_at = reading as f64;
        }
        watch.edges += 1;
        if watch.edges >= BOUNCES {
            watch.edges = 0;
            sensing.raise(AlarmKind::SwitchBounces, (station + 1) as f64, 0.0);
        }
    }

    /// Compares every station's switch with the table's position, away from the ends of its dog. A switch that has closed must stay so
    /// until the table has gone back by its hysteresis, or over the dog.
    pub(super) fn watch_switches(
        &mut self,
        axes: &[AxisState; AXIS_COUNT],
        process: ProcessLevels,
        tick: u64,
        supervision: &mut Supervision,
    ) {
        let table = &axes[Axis::Z.index()];
        if !table.homed {
            return;
        }
        let (reading, tolerance) = (table.counts() as f64, SWITCH_TOLERANCE_MM * table.counts_per_unit);
        let rests = table.is_at_rest();
        for index in 0..self.stations.len() {
            let level = self.level(Input::Station(index), axes, process);
            let switch = &self.stations[index];
            let wrong = switch.expected(reading, tolerance).is_some_and(|expected| expected != level);
            let Some(watch) = self.switch_watch.get_mut(index) else { continue };
            // Nothing presses a switch while the table rests.
            let changed = watch.level.replace(level).is_some_and(|before| before != level);
            let dropped = changed && !level && switch.must_hold(watch.closed_at, reading);
            watch.wrong_ticks = if wrong { watch.wrong_ticks.saturating_add(1) } else { 0 };
            if watch.wrong_ticks > WRONG_TICKS || (changed && rests) || dropped {
                supervision.raise(tick, AlarmKind::LimitSwitch, (index + 1) as f64, 0.0);
            }
        }
    }

    /// Holds an input at a level; `None` releases it. Inputs without a switch of their own stay as they are: a probe ends at its target.
    pub(super) fn set_stuck(&mut self, input: Input, level: Option<bool>) {
        match input {
            Input::Origin => self.origin.set_stuck(level),
            Input::Station(index) => {
                if let Some(switch) = self.stations.get_mut(index) {
                    switch.set_stuck(level);
                }
            }
            Input::Home(axis) | Input::Index(axis) => {
                if let Some(own) = &mut self.references[axis.index()] {
                    own.switch.set_stuck(level);
                }
            }
            Input::SteadyForce | Input::WheelContact | Input::KeyWay | Input::SizeReached => {}
        }
    }

    pub(super) fn set_second_origin(&mut self, counts: Option<f64>) {
        self.origin.set_second(counts);
    }

    pub(super) fn set_bouncing(&mut self, station: usize, active: bool) {
        if let Some(switch) = self.stations.get_mut(station) {
            switch.set_bouncing(active);
        }
    }

    pub(super) fn share(&mut self, inputs: Option<[Input; 2]>) {
        self.shared = inputs;
    }
}
