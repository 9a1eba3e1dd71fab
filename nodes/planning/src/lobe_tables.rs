// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of a ground lobe.

use super::PreparedJob;
use super::cut_table::pass_rows;
use super::inspect::inspection_table;
use super::pulses;
use super::table::NumberTable;
use camwright::math::units::{deg_from_rad, rad_from_deg, wrap_turn};
use camwright::planner::PlannedLobe;

/// Table of a ground lobe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LobeTable {
    Lift,
    Contour,
    ToolPath,
    /// Expected readings of a gauge; only profiles with a gauge have it.
    Inspection,
    SpeedPlan,
    /// Pulses of the axes; only jobs with pulse weights have it.
    Pulses,
}

impl LobeTable {
    pub(crate) const ALL: [Self; 6] =
        [Self::Lift, Self::Contour, Self::ToolPath, Self::Inspection, Self::SpeedPlan, Self::Pulses];

    /// Name, and name of the CSV file without its extension.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Lift => "lift",
            Self::Contour => "contour",
            Self::ToolPath => "tool_path",
            Self::Inspection => "inspection",
            Self::SpeedPlan => "speed_plan",
            Self::Pulses => "pulses",
        }
    }

    /// Returns true if a lobe has this table.
    pub(crate) fn exists(self, prepared: &PreparedJob, index: usize) -> bool {
        match self {
            Self::Inspection => prepared.inspections.get(index).is_some_and(Option::is_some),
            Self::Pulses => prepared.job.pulses.is_some(),
            Self::Lift | Self::Contour | Self::ToolPath | Self::SpeedPlan => true,
        }
    }

    /// Computes the table of a lobe, if the lobe has it.
    pub(crate) fn compute(self, prepared: &PreparedJob, index: usize) -> Option<NumberTable> {
        let lobe = prepared.planned.lobes.get(index)?;
        Some(match self {
            Self::Lift => lift(prepared, lobe),
            Self::Contour => contour(prepared, lobe),
            Self::ToolPath => tool_path(prepared, lobe),
            Self::Inspection => {
                inspection_table(prepared.inspections.get(index)?.as_ref()?, prepared.job.spec.blocks_per_turn)
            }
            Self::SpeedPlan => speed_plan(prepared, index, lobe),
            Self::Pulses => pulses::table(prepared, index, prepared.job.pulses.as_ref()?),
        })
    }
}

/// Degrees of block `index`: one rounding, so that 0.3 is written as 0.3.
pub(super) fn block_deg(index: u32, blocks: u32) -> f64 {
    f64::from(index) * 360.0 / f64::from(blocks)
}

/// Lift law with its derivatives; of an oscillating follower along the arc of its arm.
fn lift(prepared: &PreparedJob, lobe: &PlannedLobe) -> NumberTable {
    let (contour, blocks) = (&lobe.design.contour, prepared.job.spec.blocks_per_turn);
    let rows = (0..blocks).map(|index| {
        let cam_angle_deg = block_deg(index, blocks);
        let at = contour.lift().sample(rad_from_deg(cam_angle_deg));
        [cam_angle_deg, at.value, at.first, at.second, at.third]
    });
    let columns = [
        ("cam_angle_deg", "deg"),
        ("lift_mm", "mm"),
        ("lift_mm_rad", "mm/rad"),
        ("lift_mm_rad2", "mm/rad²"),
        ("lift_mm_rad3", "mm/rad³"),
    ];
    NumberTable::from_rows(columns, rows)
}

fn contour(prepared: &PreparedJob, lobe: &PlannedLobe) -> NumberTable {
    let (contour, blocks) = (&lobe.design.contour, prepared.job.spec.blocks_per_turn);
    let rows = (0..blocks).map(|index| {
        let azimuth_deg = block_deg(index, blocks);
        let cam_angle = contour.cam_angle_at(rad_from_deg(azimuth_deg));
        let radius_mm = contour.point(cam_angle).norm();
        let normal_deg = deg_from_rad(contour.normal_angle(cam_angle));
        [azimuth_deg, radius_mm, normal_deg, contour.curvature(cam_angle)]
    });
    let columns = [("azimuth_deg", "deg"), ("radius_mm", "mm"), ("normal_deg", "deg"), ("curvature_1_mm", "1/mm")];
    NumberTable::from_rows(columns, rows)
}

/// `x_mm` is the distance of the wheel's centre from the spindle axis, the X(θ) of the literature; `x_axis_mm` is where the
/// axis of this machine stands then: the wheel's cutting point, one wheel radius nearer.
fn tool_path(prepared: &PreparedJob, lobe: &PlannedLobe) -> NumberTable {
    let blocks = prepared.job.spec.blocks_per_turn;
    let sense = f64::from(prepared.machine.rotation_sense);
    let rows = (0..blocks).map(|index| {
        let c_deg = block_deg(index, blocks);
        let theta = sense * rad_from_deg(c_deg) - lobe.design.phase_rad;
        let x_axis_mm = lobe.tool_path.sample(theta).value;
        let x_mm = x_axis_mm + lobe.tool_path.wheel_radius_mm();
        let contact_deg = deg_from_rad(wrap_turn(lobe.tool_path.contact_azimuth(theta)));
        [c_deg, x_mm, contact_deg, deg_from_rad(wrap_turn(theta)), x_axis_mm]
    });
    let columns = [
        ("c_deg", "deg"),
        ("x_mm", "mm"),
        ("contact_azimuth_deg", "deg"),
        ("wheel_line_deg", "deg"),
        ("x_axis_mm", "mm"),
    ];
    NumberTable::from_rows(columns, rows)
}

fn speed_plan(prepared: &PreparedJob, index: usize, lobe: &PlannedLobe) -> NumberTable {
    let rows = (0..lobe.passes.len()).flat_map(|pass| {
        pass_rows(prepared, index, lobe, pass).map(move |row| {
            let ([c1, c2, c3], [x1, x2, x3]) = (row.c, row.x);
            [row.c_deg, row.t_s, c1, c2, c3, x1, x2, x3, row.removal_mm2_s, (pass + 1) as f64]
        })
    });
    let columns = [
        ("c_deg", "deg"),
        ("t_s", "s"),
        ("c_rad_s", "rad/s"),
        ("c_rad_s2", "rad/s²"),
        ("c_rad_s3", "rad/s³"),
        ("x_mm_s", "mm/s"),
        ("x_mm_s2", "mm/s²"),
        ("x_mm_s3", "mm/s³"),
        ("removal_mm2_s", "mm²/s"),
        ("pass", ""),
    ];
    NumberTable::from_rows(columns, rows)
}
