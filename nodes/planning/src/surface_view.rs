// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A surface as it is seen: an orthographic projection, so that all lengths across the line of sight have one scale.

use crate::chart::Point;
use camwright::math::units::TURN_RAD;

type Vector = [f64; 3];

/// Direction from the part to the viewer: x upwards, z to the right and towards the viewer.
const TO_VIEWER: Vector = [0.42, 0.62, 0.66];

/// Direction of the light, and the share of it that reaches every face.
const TO_LIGHT: Vector = [0.65, 0.45, 0.6];
const AMBIENT: f64 = 0.5;

/// Radii of a surface at equal steps of azimuth and z, the first azimuth at the keyway.
#[derive(Debug, Clone, PartialEq)]
pub struct RadiusGrid {
    pub azimuths: usize,
    /// Radius of azimuth `i` in row `k` at `k * azimuths + i` (mm).
    pub radius_mm: Vec<f64>,
    /// z of the first and of the last row (mm).
    pub from_mm: f64,
    pub to_mm: f64,
}

/// A face between two azimuths and two rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFace {
    /// Corners in the picture (mm, x to the right, y up).
    pub corners: [Point; 4],
    /// Azimuth and row that it begins at.
    pub azimuth: usize,
    pub row: usize,
    /// Light on it, 0 to 1.
    pub light: f64,
}

/// The visible part of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceView {
    /// Visible faces, the farthest first.
    pub faces: Vec<SurfaceFace>,
    /// Outline of the end that is seen, from azimuth 0 on.
    pub end: Vec<Point>,
    /// Position of the axis in this end.
    pub end_centre: Point,
    /// A millimetre along x, y and z in the picture.
    pub units: [Point; 3],
}

impl SurfaceView {
    /// The view of a surface, turned about its axis until an azimuth faces the viewer; `None` if the grid is not complete.
    #[must_use]
    pub fn new(grid: &RadiusGrid, facing_rad: f64) -> Option<Self> {
        let round = grid.azimuths;
        let rows = grid.radius_mm.len().checked_div(round)?;
        if round < 3 || rows < 2 || rows * round != grid.radius_mm.len() {
            return None;
        }
        if !grid.radius_mm.iter().chain([&grid.from_mm, &grid.to_mm]).all(|value| value.is_finite()) {
            return None;
        }
        let eye = unit(TO_VIEWER);
        let right = unit(cross([1.0, 0.0, 0.0], eye));
        let up = cross(eye, right);
        let (sin, cos) = (eye[1].atan2(eye[0]) - facing_rad).sin_cos();
        let turned = |[x, y, z]: Vector| [x * cos - y * sin, x * sin + y * cos, z];
        let flat = |point: Vector| [dot(point, right), dot(point, up)];
        let z_of = |row: usize| grid.from_mm + (grid.to_mm - grid.from_mm) * row as f64 / (rows - 1) as f64;
        let point = |azimuth: usize, row: usize| -> Vector {
            let index = azimuth % round;
            let (sin, cos) = (TURN_RAD * index as f64 / round as f64).sin_cos();
            let radius = grid.radius_mm[row * round + index];
            turned([radius * cos, radius * sin, z_of(row)])
        };
        let light = unit(TO_LIGHT);
        let mut faces: Vec<(f64, SurfaceFace)> = Vec::new();
        for row in 0..rows - 1 {
            for azimuth in 0..round {
                let corners = [(azimuth, row), (azimuth + 1, row), (azimuth + 1, row + 1), (azimuth, row + 1)]
                    .map(|(i, k)| point(i, k));
                let normal = cross(between(corners[0], corners[2]), between(corners[1], corners[3]));
                let length = dot(normal, normal).sqrt();
                if dot(normal, eye) <= 0.0 || length <= 0.0 {
                    continue;
                }
                let depth: f64 = corners.iter().map(|corner| dot(*corner, eye)).sum();
                let light = AMBIENT + (1.0 - AMBIENT) * (dot(normal, light) / length).max(0.0);
                faces.push((depth, SurfaceFace { corners: corners.map(flat), azimuth, row, light }));
            }
        }
        faces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let last = rows - 1;
        Some(Self {
            faces: faces.into_iter().map(|(_, face)| face).collect(),
            end: (0..round).map(|azimuth| flat(point(azimuth, last))).collect(),
            end_centre: flat([0.0, 0.0, grid.to_mm]),
            units: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| flat(turned(axis))),
        })
    }

    /// Lowest and highest coordinates of everything that is seen.
    #[must_use]
    pub fn extent(&self) -> [Point; 2] {
        let points = self.faces.iter().flat_map(|face| face.corners).chain(self.end.iter().copied());
        points.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], point| {
            [[low[0].min(point[0]), low[1].min(point[1])], [high[0].max(point[0]), high[1].max(point[1])]]
        })
    }
}

impl SurfaceFace {
    /// Corners moved outwards by a distance, so that no gap is seen between neighbours.
    #[must_use]
    pub fn widened(&self, by: f64) -> [Point; 4] {
        let middle = [0, 1].map(|side| 0.25 * self.corners.iter().map(|corner| corner[side]).sum::<f64>());
        self.corners.map(|[x, y]| {
            let (dx, dy) = (x - middle[0], y - middle[1]);
            let stretch = 1.0 + by / dx.hypot(dy).max(1e-9);
            [middle[0] + stretch * dx, middle[1] + stretch * dy]
        })
    }
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn between(from: Vector, to: Vector) -> Vector {
    [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
}

fn unit(vector: Vector) -> Vector {
    let length = dot(vector, vector).sqrt();
    vector.map(|value| value / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cylinder(radius: f64, length: f64) -> RadiusGrid {
        RadiusGrid { azimuths: 72, radius_mm: vec![radius; 72 * 5], from_mm: 0.0, to_mm: length }
    }

    /// Half of a cylinder is seen; its end is as large as the projection of a circle; the units are those of a projection along a line.
    #[test]
    fn half_of_a_cylinder_is_seen_in_its_true_size() {
        let view = SurfaceView::new(&cylinder(10.0, 30.0), TO_VIEWER[1].atan2(TO_VIEWER[0])).unwrap();
        assert_eq!(view.faces.len(), 72 / 2 * 4);
        let far =
            view.end.iter().map(|[x, y]| (x - view.end_centre[0]).hypot(y - view.end_centre[1])).fold(0.0, f64::max);
        assert!((far / 10.0 - 1.0).abs() < 2e-3, "a radius across the line of sight has its length: {far}");
        let squares: f64 = view.units.iter().flatten().map(|value| value * value).sum();
        assert!((squares - 2.0).abs() < 1e-12, "{squares}");
        assert!(view.units[0][0].abs() < 1e-12 && view.units[0][1] > 0.0, "x points up: {:?}", view.units);
        assert!(view.units[2][0] > 0.0, "z points to the right: {:?}", view.units);
    }

    /// The azimuth that faces the viewer is seen, and the one behind it is not.
    #[test]
    fn the_azimuth_that_faces_the_viewer_is_seen() {
        for azimuth in [0, 20, 50] {
            let view = SurfaceView::new(&cylinder(10.0, 30.0), TURN_RAD * azimuth as f64 / 72.0).unwrap();
            assert!(view.faces.iter().any(|face| face.azimuth == azimuth));
            assert!(view.faces.iter().all(|face| face.azimuth != (azimuth + 36) % 72));
        }
        let view = SurfaceView::new(&cylinder(10.0, 30.0), 0.0).unwrap();
        assert!(view.faces.iter().all(|face| (AMBIENT..=1.0).contains(&face.light)));
    }

    #[test]
    fn an_incomplete_grid_has_no_view() {
        let mut grid = cylinder(10.0, 30.0);
        grid.radius_mm.pop();
        assert_eq!(SurfaceView::new(&grid, 0.0), None);
        assert_eq!(
            SurfaceView::new(&RadiusGrid { azimuths: 0, radius_mm: vec![], from_mm: 0.0, to_mm: 1.0 }, 0.0),
            None
        );
        let mut grid = cylinder(10.0, 30.0);
        grid.radius_mm[3] = f64::NAN;
        assert_eq!(SurfaceView::new(&grid, 0.0), None);
    }
}
