// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A section of the part in its nominal form and, magnified, how far it is off.

use super::text::{fixed, signed};
use camwright::math::range::minimum_and_maximum;
use camwright::math::units::{TURN_RAD, rad_from_deg, um_from_mm};
use camwright_planning::markup::escape;
use std::fmt::Write as _;

/// Half the width of the drawing (its own pixels).
const HALF: f64 = 200.0;
/// Height of the line of text below it.
const CAPTION: f64 = 22.0;

/// Drawn radius of the farthest point of the design, and drawn distances of the tolerance and of the largest error.
const DESIGN: f64 = 132.0;
const ALLOWED: f64 = 16.0;
const FARTHEST: f64 = 46.0;

/// A section, over equal azimuths from where C is 0.
#[derive(Debug, Clone)]
pub(super) struct DrawnSection {
    /// The design, or what stands for its shape (mm).
    pub(super) radius_mm: Vec<f64>,
    /// Minimum and maximum error at each azimuth (µm); equal if a single value is recorded.
    pub(super) lowest_um: Vec<f64>,
    pub(super) highest_um: Vec<f64>,
    /// Allowed error at each azimuth (µm).
    pub(super) allowed_um: Vec<f64>,
    /// Azimuth of the keyway (deg), if it is recorded.
    pub(super) key_way_deg: Option<f64>,
    /// Azimuth of the worst place (deg) and what it is off by (µm).
    pub(super) worst: Option<(f64, f64)>,
    pub(super) title: String,
}

/// A closed line through the design's points, shifted along their normals.
struct ShiftedOutline {
    points: Vec<[f64; 2]>,
    normals: Vec<[f64; 2]>,
    /// Position of the axis: the drawing's middle is the part's.
    axis: [f64; 2],
    /// Pixels for a millimetre.
    per_mm: f64,
}

impl ShiftedOutline {
    fn from_radii(radius_mm: &[f64]) -> Self {
        let count = radius_mm.len();
        let point = |(index, radius): (usize, &f64)| {
            let (sin, cos) = (TURN_RAD * index as f64 / count as f64).sin_cos();
            [radius * cos, -radius * sin]
        };
        let points_mm: Vec<[f64; 2]> = radius_mm.iter().enumerate().map(point).collect();
        let ranges = [0, 1].map(|side| minimum_and_maximum(points_mm.iter().map(|point| point[side])));
        let half_mm = ranges.iter().map(|(min, max)| 0.5 * (max - min)).fold(1e-9, f64::max);
        let per_mm = DESIGN / half_mm;
        let axis = ranges.map(|(min, max)| -0.5 * per_mm * (min + max));
        let points: Vec<[f64; 2]> =
            points_mm.iter().map(|point| [per_mm * point[0] + axis[0], per_mm * point[1] + axis[1]]).collect();
        let normal = |index: usize| {
            let (before, after) = (points[(index + count - 1) % count], points[(index + 1) % count]);
            let along = [after[0] - before[0], after[1] - before[1]];
            let length = along[0].hypot(along[1]).max(1e-12);
            // Azimuths grow against the clock on a drawing whose y goes down: outside is to the right of the way.
            [-along[1] / length, along[0] / length]
        };
        let normals = (0..count).map(normal).collect();
        Self { points, normals, axis, per_mm }
    }

    fn shifted(&self, by: impl Fn(usize) -> f64) -> String {
        let mut path = String::with_capacity(12 * self.points.len());
        for (index, (point, normal)) in self.points.iter().zip(&self.normals).enumerate() {
            let letter = if index == 0 { 'M' } else { 'L' };
            let shift = by(index);
            let _infallible =
                write!(path, "{letter}{:.1} {:.1}", point[0] + shift * normal[0], point[1] + shift * normal[1]);
        }
        path.push('Z');
        path
    }
}

impl DrawnSection {
    /// The drawing; empty where nothing was recorded to draw.
    pub(super) fn svg(&self) -> String {
        let count = self.radius_mm.len();
        if count < 3 || self.allowed_um.len() != count || self.radius_mm.iter().any(|radius| !radius.is_finite()) {
            return "<p class=\"none\">the section is not recorded</p>".to_owned();
        }
        let errors = self.lowest_um.iter().chain(&self.highest_um).map(|um| um.abs());
        let (smallest_um, widest_um) = minimum_and_maximum(self.allowed_um.iter().copied());
        let largest = errors.fold(widest_um, f64::max);
        let scale = (ALLOWED / widest_um.max(1e-9)).min(FARTHEST / largest.max(1e-9));
        let outline = ShiftedOutline::from_radii(&self.radius_mm);
        let mut out = format!(
            "<svg class=\"part\" viewBox=\"-{HALF:.0} -{HALF:.0} {:.0} {:.0}\" role=\"img\" aria-label=\"{}\">",
            2.0 * HALF,
            2.0 * HALF + CAPTION,
            escape(&self.title)
        );
        let allowed = |index: usize| scale * self.allowed_um[index];
        let (outer, inner) = (outline.shifted(allowed), outline.shifted(|index| -allowed(index)));
        let _infallible = write!(
            out,
            "<path class=\"allowed\" fill-rule=\"evenodd\" d=\"{outer}{inner}\"/><path class=\"limit\" d=\"{outer}\"/>\
             <path class=\"limit\" d=\"{inner}\"/><path class=\"design\" d=\"{}\"/>",
            outline.shifted(|_| 0.0)
        );
        if self.lowest_um.len() == count && self.highest_um.len() == count {
            let (low, high) = (
                outline.shifted(|index| scale * self.lowest_um[index]),
                outline.shifted(|index| scale * self.highest_um[index]),
            );
            if low == high {
                let _infallible = write!(out, "<path class=\"is\" d=\"{low}\"/>");
            } else {
                let _infallible = write!(out, "<path class=\"is range\" fill-rule=\"evenodd\" d=\"{high}{low}\"/>");
            }
        }
        self.marks(&mut out, &outline, scale);
        let magnified = magnification(outline.per_mm, scale);
        let [x, y] = outline.axis;
        let shaded = match smallest_um < widest_um {
            true => format!("{} to {}", fixed(smallest_um, 1), fixed(widest_um, 1)),
            false => fixed(widest_um, 1),
        };
        let _infallible = write!(
            out,
            "<path class=\"centre\" d=\"M{:.1} {y:.1}h16M{x:.1} {:.1}v16\"/>\
             <text class=\"start\" x=\"{:.0}\" y=\"{:.0}\">errors drawn × {magnified}, shaded: ±{shaded} µm</text></svg>",
            x - 8.0,
            y - 8.0,
            4.0 - HALF,
            HALF + CAPTION - 6.0
        );
        out
    }

    fn marks(&self, out: &mut String, outline: &ShiftedOutline, scale: f64) {
        let count = outline.points.len();
        let at = |azimuth_deg: f64| {
            #[allow(clippy::cast_possible_truncation, reason = "some hundred azimuths")]
            let index = (azimuth_deg.rem_euclid(360.0) / 360.0 * count as f64).round() as usize % count;
            (outline.points[index], outline.normals[index])
        };
        if let Some(key_way) = self.key_way_deg {
            let (sin, cos) = rad_from_deg(key_way).sin_cos();
            let [x, y] = outline.axis;
            let _infallible = write!(
                out,
                "<path class=\"centre\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/><text class=\"{}\" x=\"{:.1}\" y=\"{:.1}\">keyway</text>",
                x + 12.0 * cos,
                y - 12.0 * sin,
                x + 34.0 * cos,
                y - 34.0 * sin,
                if cos < 0.0 { "end" } else { "start" },
                x + 37.0 * cos,
                y + 4.0 - 37.0 * sin
            );
        }
        if let Some((azimuth, error_um)) = self.worst {
            let (point, normal) = at(azimuth);
            let tip = [point[0] + scale * error_um * normal[0], point[1] + scale * error_um * normal[1]];
            // The number stands outside of everything that is drawn.
            let far = FARTHEST + 6.0;
            let label = [point[0] + far * normal[0], point[1] + far * normal[1] + 5.0];
            let anchor = match normal[0] {
                x if x > 0.35 => "start",
                x if x < -0.35 => "end",
                _ => "mid",
            };
            let beside = if normal[1] <= 0.0 { -1.0 } else { 1.0 };
            let room = HALF - 4.0;
            let width = 88.0;
            let x = match anchor {
                "start" => label[0].min(room - width),
                "end" => label[0].max(width - room),
                _ => label[0].clamp(0.5 * width - room, room - 0.5 * width),
            };
            let _infallible = write!(
                out,
                "<path class=\"worst-line\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/><circle class=\"worst\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\"/>\
                 <text class=\"worst-text {anchor}\" x=\"{x:.1}\" y=\"{:.1}\">{} µm</text>",
                point[0] + far * normal[0],
                point[1] + far * normal[1],
                tip[0],
                tip[1],
                tip[0],
                tip[1],
                // A number that has no room outwards stands above or below its place.
                (label[1] + if (x - label[0]).abs() > 4.0 { 17.0 * beside } else { 0.0 }).clamp(14.0 - room, room),
                signed(error_um, 2)
            );
        }
    }
}

/// Magnification of the error relative to the part, to two digits.
fn magnification(per_mm: f64, per_um: f64) -> String {
    let times = um_from_mm(per_um) / per_mm;
    let digits = 10.0_f64.powf(times.max(1.0).log10().floor() - 1.0);
    fixed((times / digits).round() * digits, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc that is off by as much as is allowed on one side: the mark lies on the outer limit, and outside is outside.
    #[test]
    fn errors_are_drawn_outwards_and_in_the_size_of_what_is_allowed() {
        let mut off = vec![0.0; 360];
        off[0] = 5.0;
        let section = DrawnSection {
            radius_mm: vec![20.0; 360],
            lowest_um: off.clone(),
            highest_um: off,
            allowed_um: vec![5.0; 360],
            key_way_deg: Some(0.0),
            worst: Some((0.0, 5.0)),
            title: "disc".into(),
        };
        let svg = section.svg();
        assert!(
            svg.contains(&format!("cx=\"{:.1}\" cy=\"0.0\"", DESIGN + ALLOWED)) || svg.contains("cy=\"-0.0\""),
            "{svg}"
        );
        assert!(svg.contains("errors drawn × 480"), "{svg}");
        let empty = DrawnSection { radius_mm: Vec::new(), ..section };
        assert!(empty.svg().contains("not recorded"));
    }
}
