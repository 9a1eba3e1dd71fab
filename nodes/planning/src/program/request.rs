// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A program to be posted, and the shapes that its drawings show.

use crate::chart::Point;
use camwright::gcode::post::{PostRequest, PostedTurn};
use camwright::math::units::TURN_RAD;
use camwright_files::nc_file::NcSettings;
use camwright_files::yaml::Document;

/// A program to be posted, with its names and notes.
pub(crate) struct ToPost<'a> {
    /// Shapes, tool, control and tolerances.
    pub(crate) request: PostRequest<'a>,
    pub(crate) settings: NcSettings,
    /// The job file, for messages that point into it.
    pub(crate) document: &'a Document,
    /// Name of the job.
    pub(crate) job: &'a str,
    /// Hash of the job, 64 hexadecimal digits.
    pub(crate) job_hash: &'a str,
    /// Shape of each feature; without one it has no drawings.
    pub(crate) outlines: Vec<Option<ProgramOutline>>,
    /// Notes for users, in sentences.
    pub(crate) notes: Vec<String>,
}

/// A shape, in mm of the part's frame.
#[derive(Debug, Clone)]
pub(crate) struct ProgramOutline {
    /// Closed lines; material is inside of the first.
    pub closed: Vec<Vec<Point>>,
    /// Radius of the cutter (mm).
    pub cutter_mm: f64,
    /// Distance of its centre beyond the programmed X (mm).
    pub edge_mm: f64,
    /// The plane in which it is drawn.
    pub plane: Plane,
}

/// The plane of a drawing.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Plane {
    /// Across the spindle axis, seen from +Z.
    Across,
    /// A cylinder rolled off: to the right along its circumference, up along Z.
    Developed {
        /// Its radius (mm).
        radius_mm: f64,
        /// Turns lie over each other; else they follow each other to the right.
        is_folded: bool,
    },
}

impl Plane {
    /// Points of a line at their places in the drawing: one line, or several where it passes the edge of a fold or a gap.
    pub(crate) fn folded(self, points: impl Iterator<Item = Option<Point>>) -> Vec<Vec<Point>> {
        let turn_mm = match self {
            Plane::Developed { radius_mm, is_folded: true } => Some(TURN_RAD * radius_mm),
            _ => None,
        };
        let (mut lines, mut line, mut turn_before) = (Vec::new(), Vec::new(), None);
        for point in points {
            let turn = point.zip(turn_mm).map(|(point, turn_mm)| (point[0] / turn_mm).floor());
            if point.is_none() || turn != turn_before {
                lines.push(std::mem::take(&mut line));
            }
            turn_before = turn;
            line.extend(point.map(|[x, y]| [x - turn.zip(turn_mm).map_or(0.0, |(turn, mm)| turn * mm), y]));
        }
        lines.push(line);
        lines.retain(|line: &Vec<Point>| line.len() > 1);
        lines
    }

    /// A point at its place in the drawing.
    pub(crate) fn place(self, [x, y]: Point) -> Point {
        match self {
            Plane::Developed { radius_mm, is_folded: true } => [x.rem_euclid(TURN_RAD * radius_mm), y],
            _ => [x, y],
        }
    }
}

/// Error of an axis of a posted turn at an angle, along the axis (mm).
pub(crate) fn error_mm(turn: &PostedTurn, axis: usize, u_rad: f64, wanted_mm: f64) -> f64 {
    let right = turn.knots.partition_point(|knot| knot.0 < u_rad).clamp(1, turn.knots.len().saturating_sub(1).max(1));
    let (Some(from), Some(to)) = (turn.knots.get(right - 1), turn.knots.get(right)) else { return 0.0 };
    let share = (u_rad - from.0) / (to.0 - from.0);
    from.1[axis] + share * (to.1[axis] - from.1[axis]) - wanted_mm
}
