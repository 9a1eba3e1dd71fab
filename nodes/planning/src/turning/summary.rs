// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A planned turning job in figures: what `summary.json` says.

use super::clearance::clearance_map;
use super::prepared::{PreparedTurning, highest_cusp};
use super::walk::points;
use camwright::cam::surface::mesh::MeshReading;
use camwright::machine::description::{Axis, InsertDescription};
use camwright::math::hermite::Sample;
use camwright::math::units::{deg_from_rad, rpm_from_rad_s, um_from_mm, wrap_turn};
use camwright::motion::point_to_point::MOVE_SHARE;
use camwright::motion::speed_plan::LimitedQuantity;
use camwright::planner::PlannedPass;
use camwright::toolpath::insert_clearance::{Flank, OFFSET_DEG};
use camwright::toolpath::insert_path::{AngleAt, BoundShare, InsertFeed};
use serde::Serialize;
use std::path::Path;

/// Turning job in `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct TurningSummary {
    /// Name of the job.
    pub job: String,
    /// One line about it.
    pub title: String,
    /// Machine it was planned for.
    pub machine: String,
    /// SHA-256 of the job with everything it names.
    pub job_hash: String,
    /// Hash of the machine.
    pub machine_hash: String,
    /// Hash of the plan.
    pub plan_hash: String,
    /// Time of the whole job, homing included.
    pub duration_s: f64,
    /// Largest use of an axis limit anywhere in the plan, as its forward check found it; 1 is the limit.
    pub max_limit_ratio: f64,
    /// Between which places it is turned.
    pub turned_mm: [f64; 2],
    /// Least and largest radius there, each widened by what the surface may do between the places looked at.
    pub radius_mm: [f64; 2],
    /// Radius of the bar.
    pub bar_radius_mm: f64,
    /// Radius of the insert.
    pub insert_radius_mm: f64,
    /// Fidelity of the surface, if it is a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshSummary>,
    /// Clearance of the insert.
    pub clearance: ClearanceSummary,
    /// Arc of the insert's edge that cuts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<EdgeSummary>,
    /// Form tolerance in addition to the cusps.
    pub tolerance_um: f64,
    /// The passes in their order.
    pub passes: Vec<TurnedPassSummary>,
}

/// Fidelity of a mesh.
#[derive(Debug, Clone, Serialize)]
pub struct MeshSummary {
    pub file: String,
    /// Triangles of the surface, and those of end faces.
    pub triangles: usize,
    /// Those of end faces, and those seen edge on.
    pub left_out: usize,
    /// Azimuths and rows of the grid through its corners.
    pub grid: [usize; 2],
    /// Largest distance of a corner from the surface.
    pub corners_off_um: f64,
    /// Largest distance of the middle of a flat face from it.
    pub faces_off_um: f64,
}

/// Clearance of the insert on the surface.
#[derive(Debug, Clone, Serialize)]
pub struct ClearanceSummary {
    /// H: how far the rake face is below the axis, negative above it.
    pub below_centre_mm: f64,
    /// asin(H / least radius).
    pub offset_angle_deg: f64,
    /// True within 40 to 60 degrees, as JP2012-71381A prefers.
    pub is_offset_preferred: bool,
    /// True within 20 to 70 degrees, as it requires.
    pub is_offset_allowed: bool,
    /// Least angle between flank and surface.
    pub clearance: AngleSummary,
    /// Least angle between surface and rake face.
    pub approach: AngleSummary,
    /// Smallest distance of the flank from the surface below the edge.
    pub flank_distance_mm: f64,
    /// The heights below the axis that work, and the best of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heights: Option<HeightsSummary>,
}

/// An angle and where it is met.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct AngleSummary {
    pub angle_deg: f64,
    /// Minimum allowed angle.
    #[serde(rename = "least_deg")]
    pub min_deg: f64,
    /// Angle of `c_axis`.
    pub c_deg: f64,
    /// Place along the part.
    pub z_mm: f64,
}

/// Arc of the insert's edge that cuts, and the arc that the machine states: 0 faces the spindle axis, positive angles lie towards +z.
#[derive(Debug, Clone, Serialize)]
pub struct EdgeSummary {
    /// Smallest angle.
    pub from: EdgeUseSummary,
    /// Largest angle.
    pub to: EdgeUseSummary,
    /// Arc of the machine; absent for the whole circle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arc_deg: Option<[f64; 2]>,
    /// True for an insert on a spindle of its own.
    pub rotates: bool,
}

/// A place on the edge, and where it cuts.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct EdgeUseSummary {
    pub angle_deg: f64,
    /// Angle of `c_axis`.
    pub c_deg: f64,
    /// Place along the part.
    pub z_mm: f64,
}

/// Heights below the axis.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct HeightsSummary {
    /// The least that works.
    pub from_mm: f64,
    /// The largest that works.
    pub to_mm: f64,
    pub best_mm: f64,
}

/// Pass in `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct TurnedPassSummary {
    /// Depth along the section's normal in the rake plane.
    pub depth_mm: f64,
    pub leaves_mm: f64,
    pub feed_mm: f64,
    /// Direction of the even feed: `z`, or the contact along the `curve` of the section.
    pub feed_along: &'static str,
    pub turns: f64,
    /// Time of the spiral.
    pub cut_s: f64,
    /// Slowest and fastest speed of the spindle between run-up and run-down.
    pub spindle_rpm: [f64; 2],
    /// Bounds of the speed, and their share of the path.
    pub bounds: Vec<SpindleBoundSummary>,
    /// Least and largest X.
    pub x_mm: [f64; 2],
    pub x_stroke_mm: f64,
    /// First and last place of the insert's centre along the part.
    pub z_mm: [f64; 2],
    /// Height of the cusps that the feed leaves where the section does not curve.
    pub cusp_um: f64,
    /// The highest cusp that the feed must leave, by the curvature of the sections; of the last pass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub highest_cusp: Option<CuspSummary>,
    /// Largest error of X between the angles at which it was computed.
    pub interpolation_error_um: f64,
    /// The tightest hollow that the insert bridges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hollow: Option<HollowSummary>,
    /// Utilisation of each axis limit, with its position.
    pub limits: Vec<TurnedLimitSummary>,
}

/// Bound of the spindle speed.
#[derive(Debug, Clone, Serialize)]
pub struct SpindleBoundSummary {
    pub bound: String,
    /// Share of the way.
    pub share: f64,
}

/// A cusp and where it is.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct CuspSummary {
    pub height_um: f64,
    /// Angle of `c_axis`.
    pub c_deg: f64,
    /// Place along the part.
    pub z_mm: f64,
}

/// A hollow that the insert does not reach into.
#[derive(Debug, Clone, Serialize)]
pub struct HollowSummary {
    /// Angle of `c_axis`.
    pub c_deg: f64,
    /// Place along the part.
    pub z_mm: f64,
    pub radius_mm: f64,
    /// Required value.
    pub bound_mm: f64,
    /// Maximum material left in it.
    pub left_um: f64,
}

/// Use of one limit.
#[derive(Debug, Clone, Serialize)]
pub struct TurnedLimitSummary {
    pub axis: &'static str,
    /// velocity, acceleration or jerk.
    pub quantity: &'static str,
    /// Unit of the two values.
    pub unit: &'static str,
    pub value: f64,
    /// Most allowed while planning.
    pub allowed: f64,
    pub ratio: f64,
    /// Angle of `c_axis` where it is met.
    pub c_deg: f64,
    /// Place of the insert's centre along the part there.
    pub z_mm: f64,
}

/// Angles of a turn, from 0 on (deg).
fn turn_deg(turned_rad: f64) -> f64 {
    deg_from_rad(wrap_turn(turned_rad))
}

/// Fidelity of a mesh, in shop units.
pub(super) fn mesh_summary(file: &Path, reading: &MeshReading) -> MeshSummary {
    MeshSummary {
        file: file.display().to_string(),
        triangles: reading.triangles,
        left_out: reading.left_out,
        grid: [reading.grid.0, reading.grid.1],
        corners_off_um: um_from_mm(reading.corners_off_mm),
        faces_off_um: um_from_mm(reading.faces_off_mm),
    }
}

/// Everything about a planned turning job but its curves.
#[must_use]
pub fn turning_summary(prepared: &PreparedTurning) -> Option<TurningSummary> {
    let spec = &prepared.job.spec;
    let insert = prepared.machine.insert.as_ref()?;
    let (from_mm, to_mm) = spec.range_mm();
    let bounds = spec.surface.bounds(from_mm, to_mm);
    let mesh = prepared.job.mesh.as_ref().map(|(file, reading)| mesh_summary(file, reading));
    Some(TurningSummary {
        job: spec.name.clone(),
        title: prepared.job.title.clone(),
        machine: prepared.machine.name.clone(),
        job_hash: prepared.provenance.job_hash.clone(),
        machine_hash: prepared.provenance.machine_hash.clone(),
        plan_hash: prepared.plan_hash().to_owned(),
        duration_s: prepared.duration_s(),
        max_limit_ratio: prepared.planned.report.max_ratio(),
        turned_mm: spec.turned_mm.into(),
        radius_mm: [bounds.min_mm, bounds.largest_mm],
        bar_radius_mm: spec.bar_radius_mm,
        insert_radius_mm: insert.radius_mm,
        mesh,
        clearance: clearance_summary(prepared, insert),
        edge: edge_summary(prepared, insert),
        tolerance_um: um_from_mm(prepared.job.tolerance_mm),
        passes: prepared.planned.passes.iter().map(|pass| pass_summary(prepared, pass)).collect(),
    })
}

fn edge_summary(prepared: &PreparedTurning, insert: &InsertDescription) -> Option<EdgeSummary> {
    let of_edge = |place: AngleAt| EdgeUseSummary {
        angle_deg: deg_from_rad(place.angle_rad),
        c_deg: turn_deg(place.turned_rad),
        z_mm: place.z_mm,
    };
    prepared.planned.edge.map(|edge| EdgeSummary {
        from: of_edge(edge.min),
        to: of_edge(edge.max),
        arc_deg: insert.edge.map(|arc| [arc.from_rad, arc.to_rad].map(deg_from_rad)),
        rotates: insert.spindle.is_some(),
    })
}

fn clearance_summary(prepared: &PreparedTurning, insert: &InsertDescription) -> ClearanceSummary {
    let found = &prepared.planned.clearance;
    let flank = Flank::from_insert(insert);
    let angle = |at: &AngleAt, min_rad: f64| AngleSummary {
        angle_deg: deg_from_rad(at.angle_rad),
        min_deg: deg_from_rad(min_rad),
        c_deg: turn_deg(at.turned_rad),
        z_mm: at.z_mm,
    };
    let offset_angle_deg = deg_from_rad(found.offset_angle_rad);
    let [preferred, allowed] = OFFSET_DEG.map(|(from, to)| (from..=to).contains(&offset_angle_deg));
    let heights = clearance_map(&prepared.job, insert).and_then(|map| map.heights()).ok();
    ClearanceSummary {
        below_centre_mm: found.height_mm,
        offset_angle_deg,
        is_offset_preferred: preferred,
        is_offset_allowed: allowed,
        clearance: angle(&found.clearance, flank.min_clearance_rad),
        approach: angle(&found.approach, flank.min_approach_rad),
        flank_distance_mm: prepared.planned.flank_distance_mm,
        heights: heights.map(|heights| HeightsSummary {
            from_mm: heights.lowest_mm,
            to_mm: heights.highest_mm,
            best_mm: heights.best_mm,
        }),
    }
}

fn pass_summary(prepared: &PreparedTurning, pass: &PlannedPass) -> TurnedPassSummary {
    let request = pass.path.request();
    let (feed_mm, feed_along) = match request.feed {
        InsertFeed::AlongZ(feed) => (feed, "z"),
        InsertFeed::AlongCurve(feed) => (feed, "curve"),
    };
    let (slowest, fastest) = pass.speed_range_rad_s();
    let (x_from, x_to) = pass.path.x_range_mm();
    let z_mm = |turned: f64| pass.path.z_at(turned).value;
    let bound = |share: &BoundShare| SpindleBoundSummary { bound: share.bound.to_string(), share: share.share };
    TurnedPassSummary {
        depth_mm: pass.depth_mm,
        leaves_mm: request.stock_mm,
        feed_mm,
        feed_along,
        turns: pass.turns,
        cut_s: pass.spindle.law.end(),
        spindle_rpm: [rpm_from_rad_s(slowest), rpm_from_rad_s(fastest)],
        bounds: pass.spindle.bounds.iter().map(bound).collect(),
        x_mm: [x_from, x_to],
        x_stroke_mm: pass.path.stroke_mm(),
        z_mm: [z_mm(pass.path.x().start()), z_mm(pass.path.x().end())],
        cusp_um: um_from_mm(pass.path.cusp_mm()),
        highest_cusp: highest_cusp(prepared, pass).map(|cusp| CuspSummary {
            height_um: um_from_mm(cusp.height_mm),
            c_deg: turn_deg(cusp.turned_rad),
            z_mm: cusp.z_mm,
        }),
        interpolation_error_um: um_from_mm(pass.path.accuracy().interpolation_error_mm),
        hollow: pass.path.hollow().map(|hollow| HollowSummary {
            c_deg: hollow.turned_deg,
            z_mm: hollow.z_mm,
            radius_mm: hollow.radius_mm,
            bound_mm: hollow.bound_mm,
            left_um: um_from_mm(hollow.left_mm),
        }),
        limits: limits(prepared, pass),
    }
}

/// The largest of every derivative of every axis, as executed from the run-up to the run-down, and where it is met.
fn limits(prepared: &PreparedTurning, pass: &PlannedPass) -> Vec<TurnedLimitSummary> {
    let mut max = [[(0.0_f64, 0.0, 0.0); 3]; 3];
    for point in points(pass) {
        for (max, sample) in max.iter_mut().zip([point.c, point.x, point.z]) {
            let Sample { first, second, third, .. } = sample;
            for (max, value) in max.iter_mut().zip([first, second, third]) {
                if value.abs() > max.0 {
                    *max = (value.abs(), point.turned_rad, point.z.value);
                }
            }
        }
    }
    let mut summaries = Vec::new();
    for (axis, max) in Axis::ALL.into_iter().zip(max) {
        let allowed = prepared.machine.axis(axis).limits.with_share(MOVE_SHARE);
        for (quantity, (value, turned_rad, z_mm)) in LimitedQuantity::ALL.into_iter().zip(max) {
            let allowed = quantity.limit(&allowed);
            summaries.push(TurnedLimitSummary {
                axis: axis.joint(),
                quantity: quantity.name(),
                unit: quantity.unit(axis),
                value,
                allowed,
                ratio: value / allowed,
                c_deg: turn_deg(turned_rad),
                z_mm,
            });
        }
    }
    summaries
}
