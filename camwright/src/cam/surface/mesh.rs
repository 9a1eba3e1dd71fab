// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Triangles, as CAD writes them, read as points of a smooth surface.
//!
//! The corners of a good mesh lie on the part, its faces between them do not: a chord of 1° cuts 1.5 µm off a radius of 40 mm, and its
//! edges would shake the tool at every degree. So a mesh is read like a printed table: the surface is the smoothest that goes through the
//! corners. Radii are interpolated straight over azimuth and z within each triangle, taken at the nodes of a grid as fine as the mesh, and
//! what the corners then lie off the grid's spline is added in the same way until they lie on it.

use super::grid::SurfaceGrid;
use super::{Surface, SurfaceError, SurfaceKey};
use crate::math::range::minimum_and_maximum;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use alloc::vec;
use alloc::vec::Vec;

/// Corners of a triangle (mm, in the part's frame: x towards the keyway, z along the axis; the azimuth is atan2(y, x)).
pub type Triangle = [[f64; 3]; 3];

/// A piece of the line along which triangles meet a plane: x and z of its ends (mm).
pub type CrossingLine = [[f64; 2]; 2];

/// Fidelity of the reading of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshReading {
    /// Triangles of the surface.
    pub triangles: usize,
    /// Triangles across the axis, which are end faces, and those seen edge on, which say nothing.
    pub left_out: usize,
    /// Azimuths and rows of the grid.
    pub grid: (usize, usize),
    /// Largest distance of a corner from the surface, measured along the radius (mm).
    pub corners_off_mm: f64,
    /// Largest distance of a triangle's middle from the surface, along the radius (mm): what the flat faces cut off.
    pub faces_off_mm: f64,
}

const MAX_TRIANGLES: usize = 3_000_000;

/// Largest coordinate (mm).
const LARGEST_MM: f64 = 1e5;

/// A triangle less high than this share of the mesh along z is an end face.
const FLAT: f64 = 1e-7;

/// Distance outside a triangle at which a node still uses it, as a share of the triangle.
const OUTSIDE: f64 = 1e-5;

/// Maximum distance of two triangles at one position (mm): a larger step is another surface.
const APART_MM: f64 = 0.02;

/// At most so often is added what the corners are off.
const ROUNDS: usize = 30;

/// Distance of the corners from the surface at which it is good (mm), and that which is still accepted: single precision at 100 mm
/// rounds to 4e-6 mm.
const OFF_MM: (f64, f64) = (1e-7, 2e-3);

/// Fewest and most nodes of the grid round the turn and along z.
const ANGLES: (usize, usize) = (24, 3600);
const ROWS: (usize, usize) = (2, 4000);

/// A corner seen from the axis.
#[derive(Debug, Clone, Copy)]
struct MeshVertex {
    azimuth_rad: f64,
    z_mm: f64,
    radius_mm: f64,
}

/// Weights of one triangle's corners for a node of the grid.
#[derive(Debug, Clone, Copy)]
struct TriangleWeights {
    face: usize,
    weights: [f64; 3],
}

/// The smooth surface through the corners of triangles.
///
/// # Errors
/// Too few or many triangles, numbers that are not finite; triangles that lie behind one another as seen from the axis, or leave a hole;
/// corners through which no surface goes that is as smooth as the mesh is fine.
pub fn surface_of(triangles: &[Triangle]) -> Result<(Surface, MeshReading), SurfaceError> {
    let faces = faces_of(triangles)?;
    let z = faces.iter().flatten().map(|corner| corner.z_mm);
    let (from, to) = minimum_and_maximum(z);
    let (angles, rows) = resolution(&faces, to - from);
    let shares = shares(&faces, angles, rows, from, to)?;
    closes(&faces, to - from)?;
    let z_mm: Vec<f64> = (0..rows).map(|k| from + (to - from) * k as f64 / (rows - 1) as f64).collect();
    let azimuths_rad: Vec<f64> = (0..angles).map(|i| i as f64 * TURN_RAD / angles as f64).collect();
    let spread = |off: &[[f64; 3]]| -> Vec<f64> {
        let node =
            |share: &TriangleWeights| share.weights.iter().zip(off[share.face]).map(|(weight, off)| weight * off).sum();
        shares.iter().map(node).collect()
    };
    let mut off: Vec<[f64; 3]> = faces.iter().map(|face| face.map(|corner| corner.radius_mm)).collect();
    let mut grid = SurfaceGrid { azimuths_rad, z_mm, radii_mm: vec![0.0; angles * rows] };
    let mut best: Option<(Surface, f64, MeshVertex)> = None;
    for _ in 0..ROUNDS {
        for (radius, more) in grid.radii_mm.iter_mut().zip(spread(&off)) {
            *radius += more;
        }
        let surface = Surface::grid(&grid)?;
        let mut worst = (0.0_f64, faces[0][0]);
        for (face, off) in faces.iter().zip(&mut off) {
            *off = face.map(|corner| corner.radius_mm - surface.radius(corner.azimuth_rad, corner.z_mm));
            for (off, corner) in off.iter().zip(face) {
                if off.abs() > worst.0 {
                    worst = (off.abs(), *corner);
                }
            }
        }
        let slow = best.as_ref().is_some_and(|(_, before, _)| worst.0 > 0.9 * before);
        if best.as_ref().is_none_or(|(_, before, _)| worst.0 < *before) {
            best = Some((surface, worst.0, worst.1));
        }
        if slow || worst.0 < OFF_MM.0 {
            break;
        }
    }
    let (surface, corners_off_mm, place) = best.expect("there is at least one round");
    if corners_off_mm > OFF_MM.1 {
        let (azimuth_deg, z_mm) = (deg_from_rad(place.azimuth_rad), place.z_mm);
        return Err(SurfaceError::RoughMesh { azimuth_deg, z_mm, off_mm: corners_off_mm, bound_mm: OFF_MM.1 });
    }
    let faces_off_mm =
        triangles.iter().filter(|triangle| is_side(triangle, FLAT * (to - from))).fold(0.0_f64, |max, t| {
            let [x, y, z] = [0, 1, 2].map(|i| (t[0][i] + t[1][i] + t[2][i]) / 3.0);
            max.max((libm::hypot(x, y) - surface.radius(libm::atan2(y, x), z)).abs())
        });
    let left_out = triangles.len() - faces.len();
    let reading = MeshReading { triangles: faces.len(), left_out, grid: (angles, rows), corners_off_mm, faces_off_mm };
    Ok((surface, reading))
}

/// Intersection of triangles with the rake plane at height `y_mm` above the axis, with the part at θ: pieces of the section in x and z
/// (mm) with x above 0. Result of the flat faces, for comparison.
#[must_use]
pub fn cut_by_rake_plane(triangles: &[Triangle], turned_rad: f64, y_mm: f64) -> Vec<CrossingLine> {
    let (sin, cos) = libm::sincos(turned_rad);
    let mut cuts = Vec::new();
    for triangle in triangles {
        // A point at azimuth φ of the part stands at ψ = φ − θ.
        let turned = triangle.map(|[x, y, z]| [x * cos + y * sin, y * cos - x * sin - y_mm, z]);
        let mut ends = Vec::with_capacity(2);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (p, q) = (turned[a], turned[b]);
            if (p[1] < 0.0) != (q[1] < 0.0) {
                let t = p[1] / (p[1] - q[1]);
                ends.push([p[0] + t * (q[0] - p[0]), p[2] + t * (q[2] - p[2])]);
            }
        }
        if let [from, to] = ends[..]
            && (from[0] > 0.0 || to[0] > 0.0)
        {
            cuts.push([from, to]);
        }
    }
    cuts
}

fn is_side(triangle: &Triangle, flat_mm: f64) -> bool {
    let (from, to) = minimum_and_maximum(triangle.map(|corner| corner[2]));
    to - from > flat_mm
}

/// Triangles as seen from the axis, azimuths of one face side by side, without those that say nothing.
fn faces_of(triangles: &[Triangle]) -> Result<Vec<[MeshVertex; 3]>, SurfaceError> {
    let count = triangles.len();
    if !(4..=MAX_TRIANGLES).contains(&count) {
        return Err(SurfaceError::Count { what: SurfaceKey::Triangles, count, min: 4, max: MAX_TRIANGLES });
    }
    let numbers = || triangles.iter().flatten().flatten();
    if let Some(value) = numbers().find(|value| !value.is_finite() || value.abs() > LARGEST_MM) {
        let what = SurfaceKey::MeshCoordinate;
        return Err(SurfaceError::BadNumber { what, value: *value, allowed: "within ±1e5 mm" });
    }
    let z = triangles.iter().flatten().map(|corner| corner[2]);
    let (from, to) = minimum_and_maximum(z);
    if to - from < 1e-6 {
        return Err(SurfaceError::NoLength { from_mm: from, to_mm: to });
    }
    let mut faces = Vec::with_capacity(count);
    for triangle in triangles.iter().filter(|triangle| is_side(triangle, FLAT * (to - from))) {
        let mut face = triangle.map(|[x, y, z]| MeshVertex {
            azimuth_rad: wrap_turn(libm::atan2(y, x)),
            z_mm: z,
            radius_mm: libm::hypot(x, y),
        });
        if let Some(corner) = face.iter().find(|corner| corner.radius_mm < 1e-3) {
            let (azimuth_deg, z_mm) = (deg_from_rad(corner.azimuth_rad), corner.z_mm);
            let radius_mm = corner.radius_mm;
            return Err(SurfaceError::ReachesAxis { azimuth_deg, z_mm, radius_mm, bound_mm: 1e-3 });
        }
        for k in 1..3 {
            let turns = libm::round((face[k].azimuth_rad - face[0].azimuth_rad) / TURN_RAD);
            face[k].azimuth_rad -= turns * TURN_RAD;
        }
        let (u, v) = sides(&face);
        let area = u[0] * v[1] - u[1] * v[0];
        let size = libm::hypot(u[0] * face[0].radius_mm, u[1]) * libm::hypot(v[0] * face[0].radius_mm, v[1]);
        if (area * face[0].radius_mm).abs() > 1e-6 * size {
            faces.push(face);
        }
    }
    if faces.is_empty() {
        return Err(SurfaceError::Count { what: SurfaceKey::SideTriangles, count: 0, min: 4, max: MAX_TRIANGLES });
    }
    Ok(faces)
}

/// From the first corner to the other two, in azimuth and z.
fn sides(face: &[MeshVertex; 3]) -> ([f64; 2], [f64; 2]) {
    let side = |k: usize| [face[k].azimuth_rad - face[0].azimuth_rad, face[k].z_mm - face[0].z_mm];
    (side(1), side(2))
}

/// Sees to it that what the triangles cover is the whole turn and length, but for a quarter of one of them.
fn closes(faces: &[[MeshVertex; 3]], length_mm: f64) -> Result<(), SurfaceError> {
    let area = |face: &[MeshVertex; 3]| {
        let (u, v) = sides(face);
        0.5 * (u[0] * v[1] - u[1] * v[0]).abs()
    };
    let share = faces.iter().map(area).sum::<f64>() / (TURN_RAD * length_mm);
    let off = (share - 1.0).abs() * faces.len() as f64;
    if off < 0.25 { Ok(()) } else { Err(SurfaceError::OpenMesh { share }) }
}

/// Azimuths and rows as fine as the mesh: the mean width and height of its triangles.
fn resolution(faces: &[[MeshVertex; 3]], length_mm: f64) -> (usize, usize) {
    let extent = |of: fn(&MeshVertex) -> f64| {
        let sum: f64 = faces
            .iter()
            .map(|face| {
                let (low, high) = minimum_and_maximum(face.each_ref().map(of));
                high - low
            })
            .sum();
        sum / faces.len() as f64
    };
    #[allow(clippy::cast_possible_truncation, reason = "positive, and cut off")]
    let steps = |whole: f64, one: f64| libm::round(whole / one) as usize;
    let angles = steps(TURN_RAD, extent(|corner| corner.azimuth_rad));
    let rows = steps(length_mm, extent(|corner| corner.z_mm)).saturating_add(1);
    (angles.clamp(ANGLES.0, ANGLES.1), rows.clamp(ROWS.0, ROWS.1))
}

/// For every node, row by row, the triangle that covers it best.
fn shares(
    faces: &[[MeshVertex; 3]],
    angles: usize,
    rows: usize,
    from: f64,
    to: f64,
) -> Result<Vec<TriangleWeights>, SurfaceError> {
    let (per_rad, per_mm) = (angles as f64 / TURN_RAD, (rows - 1) as f64 / (to - from));
    let mut found: Vec<Option<(f64, f64, TriangleWeights)>> = vec![None; angles * rows];
    let place = |node: usize| (deg_from_rad((node % angles) as f64 / per_rad), from + (node / angles) as f64 / per_mm);
    for (index, face) in faces.iter().enumerate() {
        let (u, v) = sides(face);
        let area = u[0] * v[1] - u[1] * v[0];
        let range = |values: [f64; 3], origin: f64, per: f64| {
            let (low, high) = minimum_and_maximum(values);
            let room = 2.0 * OUTSIDE * (high - low);
            #[allow(clippy::cast_possible_truncation, reason = "coordinates are bounded")]
            let step = |value: f64| value as i64;
            step(libm::ceil((low - room - origin) * per))..=step(libm::floor((high + room - origin) * per))
        };
        for k in range(face.map(|corner| corner.z_mm), from, per_mm) {
            let Some(row) = usize::try_from(k).ok().filter(|row| *row < rows) else { continue };
            let dz = from + row as f64 / per_mm - face[0].z_mm;
            for i in range(face.map(|corner| corner.azimuth_rad), 0.0, per_rad) {
                let da = i as f64 / per_rad - face[0].azimuth_rad;
                let (second, third) = ((da * v[1] - dz * v[0]) / area, (u[0] * dz - u[1] * da) / area);
                let weights = [1.0 - second - third, second, third];
                let (inside, _) = minimum_and_maximum(weights);
                if inside < -OUTSIDE {
                    continue;
                }
                let radius: f64 = weights.iter().zip(face).map(|(weight, corner)| weight * corner.radius_mm).sum();
                let column = usize::try_from(i.rem_euclid(i64::try_from(angles).unwrap_or(i64::MAX))).unwrap_or(0);
                let node = row * angles + column;
                if let Some((_, other_mm, _)) = found[node].filter(|(_, other, _)| (other - radius).abs() > APART_MM) {
                    let (azimuth_deg, z_mm) = place(node);
                    return Err(SurfaceError::TwoRadii { azimuth_deg, z_mm, radius_mm: radius, other_mm });
                }
                if found[node].is_none_or(|(best, _, _)| inside > best) {
                    found[node] = Some((inside, radius, TriangleWeights { face: index, weights }));
                }
            }
        }
    }
    let hole = |node: usize| {
        let (azimuth_deg, z_mm) = place(node);
        SurfaceError::Hole { azimuth_deg, z_mm }
    };
    found.iter().enumerate().map(|(node, share)| share.map(|(_, _, share)| share).ok_or_else(|| hole(node))).collect()
}
