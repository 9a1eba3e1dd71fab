// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A lathe's insert sweeps the part in the chuck along one servo step.

use super::contact::line_rad;
use crate::machine::description::{AXIS_COUNT, Axis, InsertDescription, MachineDescription};
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::math::units::TURN_RAD;
use crate::simulation::axis::{AxisState, Span};
use crate::simulation::turned_part::{Insert, InsertMove, InsertPose, TurnedPart, TurnedRemoval};
use crate::simulation::workpiece::Removal;

/// A part in the chuck of a lathe.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Clamped {
    pub(super) part: TurnedPart,
    /// Position of the insert's centre along the part when Z is 0 (mm).
    pub(super) zero_mm: f64,
}

/// A part in a chuck: one that is read is made anew.
pub(super) fn snapshot_clamped(
    clamped: &mut Option<Clamped>,
    is_lathe: bool,
    codec: &mut SnapshotCodec<'_>,
) -> Result<(), SnapshotError> {
    let mut is_there = clamped.is_some();
    is_there.snapshot(codec)?;
    if is_there && !is_lathe {
        return Err(SnapshotError::Impossible("a machine that grinds turns nothing"));
    }
    if codec.is_reading() {
        *clamped = None;
        if is_there {
            let mut zero_mm = 0.0;
            codec.field("zero_mm", |codec| zero_mm.snapshot(codec))?;
            *clamped = Some(Clamped { part: codec.field("part", TurnedPart::read)?, zero_mm });
        }
        return Ok(());
    }
    let Some(Clamped { part, zero_mm }) = clamped else { return Ok(()) };
    fields!(codec: zero_mm, part);
    Ok(())
}

fn edge(insert: &InsertDescription) -> Insert {
    Insert { radius_mm: insert.radius_mm, height_mm: insert.height_mm }
}

impl Clamped {
    /// Sweeps the part along a servo step, from where the axes truly were to where they are.
    pub(super) fn turn(
        &mut self,
        spans: &[Span; AXIS_COUNT],
        axes: &[AxisState; AXIS_COUNT],
        step_s: f64,
        cuts: bool,
        description: &MachineDescription,
    ) -> TurnedRemoval {
        let Some(insert) = &description.insert else { return TurnedRemoval::default() };
        let sense = f64::from(description.rotation_sense);
        let per_unit = |axis: Axis| axes[axis.index()].counts_per_unit;
        let turn = libm::round(TURN_RAD * per_unit(Axis::C));
        let units = [sense * TURN_RAD / turn, 1.0 / per_unit(Axis::X), 1.0 / per_unit(Axis::Z)];
        // Speeds are per second, slopes of the step per step.
        let slope = |speed: fn(&Span) -> f64| core::array::from_fn(|i| speed(&spans[i]) * step_s * units[i]);
        let from = InsertPose {
            turned_rad: line_rad(spans[Axis::C.index()].from, turn, sense),
            x_mm: spans[Axis::X.index()].from / per_unit(Axis::X),
            z_mm: spans[Axis::Z.index()].from / per_unit(Axis::Z) + self.zero_mm,
        };
        let way = core::array::from_fn(|i| (spans[i].to - spans[i].from) * units[i]);
        let motion = InsertMove::cubic(from, way, slope(|span| span.from_velocity), slope(|span| span.to_velocity));
        self.part.sweep(&edge(insert), &motion, cuts)
    }

    /// Positions of the insert's centre at which its edge is off the part's largest and its smallest radius (mm), with the chuck at
    /// `z_mm`; `None` where the insert stands beside the part.
    pub(super) fn insert_positions_mm(&self, insert: &InsertDescription, z_mm: f64) -> Option<(f64, f64)> {
        let insert = edge(insert);
        let z_mm = z_mm + self.zero_mm;
        let grid = self.part.grid();
        if z_mm + insert.radius_mm < grid.from_mm || z_mm - insert.radius_mm > grid.to_mm {
            return None;
        }
        let height_mm = insert.height_mm;
        let centre = |r: f64| libm::sqrt((r * r - height_mm * height_mm).max(0.0)) + insert.radius_mm;
        Some((centre(self.part.raw_reach_mm()), centre(self.part.minimum_mm())))
    }
}

/// A turned volume as a wheel's removal: per width of the tool, which is that of its edge.
pub(super) fn as_of_a_wheel(turned: &TurnedRemoval, width_mm: f64) -> Removal {
    Removal { area_mm2: turned.volume_mm3 / width_mm, depth_mm: turned.depth_mm, is_over_axis: turned.is_over_axis }
}
