// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The in-process gauge, its faults, and supervision of its readings.

use super::contact::line_rad;
use super::inputs::Sensing;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{Axis, GaugeKind, MachineDescription};
use crate::machine::setpoint::Input;
use crate::math::snapshot::{SnapshotCodec, SnapshotError};
use crate::math::units::TURN_RAD;
use crate::simulation::axis::AxisState;
use crate::simulation::fault::GaugeFault;
use crate::simulation::gauge::SimulatedGauge;
use crate::simulation::size_monitor::SizeMonitor;
use crate::simulation::workpiece::{Deflection, Lobe};

/// Equal readings in a row that are suspicious.
const STUCK_READINGS: u32 = 100;
/// Depth that must have been cut all round meanwhile, for a gauge without noise (mm), in addition to two steps of its reading.
const STUCK_DEPTH_MM: f64 = 5.0e-4;

/// History of the readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct GaugeWatch {
    fault: Option<GaugeFault>,
    last: [Option<f64>; 2],
    /// Number of equal readings, turn of C meanwhile (rad), and area cut after the first turn of it (mm²).
    same: [u32; 2],
    turned_rad: [f64; 2],
    cut_mm2: [f64; 2],
}

crate::snapshot!(GaugeWatch { fault, last, same, turned_rad, cut_mm2 } on {});

/// A gauge and the watch over it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Gauging {
    gauge: Option<SimulatedGauge>,
    gauge_watch: GaugeWatch,
    size_monitor: SizeMonitor,
}

// The state of the size monitor stands at the end of a keyframe, which has it only while it watches.
snapshot_groups!(Gauging { keep_gauge(equipment: gauge), keep_watch(fields: gauge_watch) } on { size_monitor });

impl Gauging {
    pub(super) fn new(description: &MachineDescription) -> Self {
        Self {
            gauge: description.gauge.map(|gauge| SimulatedGauge::new(gauge, description.cycle_time_s())),
            gauge_watch: GaugeWatch::default(),
            size_monitor: SizeMonitor::default(),
        }
    }

    pub(super) fn begin_job(&mut self) {
        if let Some(gauge) = &mut self.gauge {
            gauge.begin_job();
        }
        self.size_monitor = SizeMonitor::default();
    }

    pub(super) fn watch_size(&mut self, diameter_nm: i64) {
        self.size_monitor.watch(diameter_nm);
    }

    pub(super) fn is_size_reached(&self) -> bool {
        self.size_monitor.is_closed()
    }

    pub(super) fn snapshot_size_monitor(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let watches = self.size_monitor.is_watching();
        codec.tail(&mut self.size_monitor, watches)
    }

    /// Edge of the size monitor at the end of a tick. A single contact reads the deflection of the part as well, which is no size.
    pub(super) fn sense_size(
        &mut self,
        readings_mm: [Option<f64>; 2],
        description: &MachineDescription,
        sensing: &mut Sensing<'_>,
    ) {
        let is_diameter = description.gauge.is_some_and(|gauge| gauge.kind == GaugeKind::Diameter);
        let headstock = &sensing.axes[Axis::C.index()];
        let c_rad = headstock.true_position() / headstock.counts_per_unit;
        if self.size_monitor.tick(c_rad, readings_mm[0].filter(|_| is_diameter)) {
            sensing.latch(Input::SizeReached, true, None);
        }
    }

    pub(super) fn set_fault(&mut self, fault: Option<GaugeFault>) {
        self.gauge_watch.fault = fault;
    }

    /// Readings at the end of a tick of the lobe under the gauge, if one is. The part deflects by `deflection`. `measured_mm` are the
    /// readings of a real gauge, which take the place of simulated ones.
    pub(super) fn read(
        &mut self,
        lobe: Option<&Lobe>,
        headstock: &AxisState,
        rotation_sense: f64,
        deflection: Deflection,
        measured_mm: Option<[Option<f64>; 2]>,
    ) -> [Option<f64>; 2] {
        let Some(gauge) = &mut self.gauge else { return [None; 2] };
        let Some(lobe) = lobe else {
            gauge.rest();
            return [None; 2];
        };
        let readings_mm = measured_mm.unwrap_or_else(|| {
            let turn = libm::round(TURN_RAD * headstock.counts_per_unit);
            let line_rad = line_rad(headstock.true_position(), turn, rotation_sense);
            gauge.read(lobe, line_rad, rotation_sense, deflection)
        });
        let GaugeWatch { fault, last, .. } = &self.gauge_watch;
        core::array::from_fn(|i| match (fault, readings_mm[i]) {
            (Some(GaugeFault::NotANumber), Some(_)) => Some(f64::NAN),
            // A gauge that never read anything is stuck at 0.
            (Some(GaugeFault::Stuck), Some(_)) => Some(last[i].unwrap_or(0.0)),
            (_, reading) => reading,
        })
    }

    /// Raises an alarm if a reading is not a number, or stays the same however much is cut. `round_mm` is the circumference of the lobe,
    /// `area_mm2` the area cut in this tick.
    pub(super) fn watch(
        &mut self,
        readings_mm: [Option<f64>; 2],
        (round_mm, area_mm2): (f64, f64),
        headstock: &AxisState,
        description: &MachineDescription,
        mut raise: impl FnMut(AlarmKind, f64, f64),
    ) {
        let Some(gauge) = description.gauge else { return };
        let turned_rad = headstock.velocity().abs() * description.cycle_time_s();
        let watch = &mut self.gauge_watch;
        for (i, reading) in readings_mm.into_iter().enumerate() {
            let Some(reading) = reading else { continue };
            if !reading.is_finite() {
                raise(AlarmKind::GaugeInvalid, 0.0, 0.0);
                continue;
            }
            let is_same = watch.last[i].is_some_and(|last| last.to_bits() == reading.to_bits());
            watch.last[i] = Some(reading);
            // Only while something is cut.
            if !is_same {
                (watch.same[i], watch.turned_rad[i], watch.cut_mm2[i]) = (0, 0.0, 0.0);
            } else if area_mm2 > 0.0 {
                watch.same[i] = watch.same[i].saturating_add(1);
                watch.turned_rad[i] += turned_rad;
                // A cut comes under the contact within a turn.
                watch.cut_mm2[i] += if watch.turned_rad[i] > TURN_RAD { area_mm2 } else { 0.0 };
            }
            // Noise larger than a step never rests; without it, a cut must show.
            let is_noisy = gauge.noise_mm > gauge.resolution_mm && gauge.noise_mm > 0.0;
            let must_show = watch.cut_mm2[i] / round_mm > STUCK_DEPTH_MM + 2.0 * gauge.resolution_mm;
            let count = watch.same[i];
            if count >= STUCK_READINGS && (is_noisy || must_show) {
                raise(AlarmKind::GaugeStuck, f64::from(count), 0.0);
            }
        }
    }
}
