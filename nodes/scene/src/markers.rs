// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Markers: the part as it is, in its nominal form, and what it is off.

use super::solids::{azimuth, body, polar, radius_at, ring};
use camwright_files::convert::centre_offset;
use camwright_msgs::geometry_msgs::msg::{Point, Pose, Quaternion, Vector3};
use camwright_msgs::std_msgs::msg::{ColorRGBA, Header};
use camwright_msgs::visualization_msgs::msg::Marker;

/// Azimuths of a solid: 26 kB, less than one message of DDS may have without fragments of its own kind everywhere.
const SOLID_AZIMUTHS: usize = 90;
/// Azimuths of a line.
const LINE_AZIMUTHS: usize = 360;

/// Red, green, blue, opacity (0..1).
pub type Rgba = [f32; 4];

/// Frame and identity of a marker.
///
/// Stamps are zero and markers are locked to their frame: they belong to what turns, not to a moment, and a viewer that comes late has
/// no transform of the moment in which a latched marker was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkerPose<'a> {
    pub frame: &'a str,
    pub ns: &'a str,
    /// Its number there, the same for the same thing for ever.
    pub id: i32,
}

impl MarkerPose<'_> {
    fn marker(&self, kind: i32, colour: Rgba) -> Marker {
        let [r, g, b, a] = colour;
        Marker {
            header: Header { frame_id: self.frame.to_owned(), ..Header::default() },
            ns: self.ns.to_owned(),
            id: self.id,
            type_: kind,
            action: Marker::ADD,
            pose: Pose { orientation: Quaternion { w: 1.0, ..Quaternion::default() }, ..Pose::default() },
            scale: Vector3 { x: 1.0, y: 1.0, z: 1.0 },
            color: ColorRGBA { r, g, b, a },
            frame_locked: true,
            ..Marker::default()
        }
    }

    fn line(&self, points: Vec<Point>, width: f64, colour: Rgba) -> Marker {
        let scale = Vector3 { x: width, y: 0.0, z: 0.0 };
        Marker { scale, points, ..self.marker(Marker::LINE_STRIP, colour) }
    }
}

/// Takes a marker away. Each by its number: some viewers take all namespaces for one when everything is to go.
#[must_use]
pub fn gone(place: MarkerPose<'_>) -> Marker {
    Marker { action: Marker::DELETE, ..place.marker(Marker::TRIANGLE_LIST, [0.0; 4]) }
}

/// The same marker about the centre of a crank pin: distance (m) and azimuth (rad) in its frame; no centre leaves it about the axis.
#[must_use]
pub fn about(mut marker: Marker, centre: &[f64]) -> Marker {
    if let Some([x, y]) = centre_offset(centre) {
        (marker.pose.position.x, marker.pose.position.y) = (x, y);
    }
    marker
}

/// A body between two places along the axis: radii at equal steps of a turn, the place (m).
#[must_use]
pub fn solid(place: MarkerPose<'_>, sections: &[(f64, &[f64])], colour: Rgba) -> Marker {
    let even = |radii: &[f64]| (0..SOLID_AZIMUTHS).map(|i| radius_at(radii, azimuth(i, SOLID_AZIMUTHS))).collect();
    let sections: Vec<(f64, Vec<f64>)> = sections.iter().map(|(z, radii)| (*z, even(radii))).collect();
    Marker { points: body(&sections), ..place.marker(Marker::TRIANGLE_LIST, colour) }
}

/// An outline round the axis at a place along it (m).
#[must_use]
pub fn outline(place: MarkerPose<'_>, radii: &[f64], z: f64, width: f64, colour: Rgba) -> Marker {
    place.line(ring(radii, z, LINE_AZIMUTHS), width, colour)
}

/// Both edges of a lobe as one line (m).
#[must_use]
pub fn rings(place: MarkerPose<'_>, radii: &[f64], [from, to]: [f64; 2], width: f64, colour: Rgba) -> Marker {
    let mut points = ring(radii, from, LINE_AZIMUTHS);
    points.extend(ring(radii, to, LINE_AZIMUTHS));
    place.line(points, width, colour)
}

/// A wheel as long as it is wide, or an insert, about the axis Z of its frame (m).
#[must_use]
pub fn wheel(place: MarkerPose<'_>, radius: f64, width: f64, colour: Rgba) -> Marker {
    let scale = Vector3 { x: 2.0 * radius, y: 2.0 * radius, z: width };
    Marker { scale, ..place.marker(Marker::CYLINDER, colour) }
}

/// Label beside a body (m).
#[must_use]
pub fn text(place: MarkerPose<'_>, [x, y, z]: [f64; 3], height: f64, text: String) -> Marker {
    let mut marker = place.marker(Marker::TEXT_VIEW_FACING, [1.0, 1.0, 1.0, 1.0]);
    marker.pose.position = Point { x, y, z };
    marker.scale = Vector3 { x: 0.0, y: 0.0, z: height };
    Marker { text, ..marker }
}

/// A form error so many times as large, outside of the contour where material is left (towards the axis in a bore), coloured by its share of what is allowed (m):
/// green is on the contour, red too much, blue too little.
#[must_use]
pub fn error_ring(
    place: MarkerPose<'_>,
    contour: &[f64],
    error: &[f64],
    z: f64,
    [magnification, tolerance]: [f64; 2],
    width: f64,
) -> Marker {
    let at = |i: usize| azimuth(i, LINE_AZIMUTHS);
    let error_at = |i: usize| radius_at(error, at(i));
    let point = |i: usize| polar((radius_at(contour, at(i)) + magnification * error_at(i)).abs(), at(i), z);
    let mut marker = place.line((0..=LINE_AZIMUTHS).map(point).collect(), width, [1.0; 4]);
    marker.colors = (0..=LINE_AZIMUTHS).map(|i| scale_colour(error_at(i) / tolerance)).collect();
    marker
}

/// Colour of a share of what is allowed, −1..1.
fn scale_colour(share: f64) -> ColorRGBA {
    let share = if share.is_finite() { share.clamp(-1.0, 1.0) } else { 1.0 };
    #[allow(clippy::cast_possible_truncation, reason = "a colour")]
    let (size, sign) = (share.abs() as f32, share);
    let [r, b] = if sign > 0.0 { [size, 0.0] } else { [0.0, size] };
    ColorRGBA { r, g: 1.0 - 0.8 * size, b, a: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A marker of a crank pin stands about the pin's centre; without a centre it stays about the axis.
    #[test]
    fn a_marker_is_moved_to_the_centre_of_a_pin() {
        let place = MarkerPose { frame: "part", ns: "stock", id: 0 };
        let sides = [(0.0, &[0.025_f64; 8][..]), (0.02, &[0.025; 8][..])];
        let solid = solid(place, &sides, [1.0; 4]);
        let pin = about(solid.clone(), &[0.04, 0.5]);
        let at = &pin.pose.position;
        assert!((at.x - 0.04 * 0.5_f64.cos()).abs() < 1e-15 && (at.y - 0.04 * 0.5_f64.sin()).abs() < 1e-15);
        assert_eq!(pin.points, solid.points);
        assert_eq!(about(solid.clone(), &[]), solid);
    }
}
