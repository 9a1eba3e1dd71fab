// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Points of what markers are made of, in m.

use camwright::math::units::TURN_RAD;
use camwright_msgs::geometry_msgs::msg::Point;

/// Distance from the axis at an azimuth, from radii at equal steps of a turn.
pub(super) fn radius_at(radii: &[f64], azimuth_rad: f64) -> f64 {
    let Some(last) = radii.len().checked_sub(1) else { return 0.0 };
    let place = azimuth_rad.rem_euclid(TURN_RAD) / TURN_RAD * radii.len() as f64;
    #[allow(clippy::cast_possible_truncation, reason = "it is in 0..=len")]
    let index = (place as usize).min(last);
    let (here, next) = (radii[index], radii[(index + 1) % radii.len()]);
    let share = place - index as f64;
    here + share * (next - here)
}

/// Azimuth i of n.
pub(super) fn azimuth(index: usize, count: usize) -> f64 {
    TURN_RAD * index as f64 / count as f64
}

pub(super) fn polar(radius: f64, azimuth_rad: f64, z: f64) -> Point {
    let (sin, cos) = azimuth_rad.sin_cos();
    Point { x: radius * cos, y: radius * sin, z }
}

/// A closed line round the axis. The wall of a bore has negative radii.
pub(super) fn ring(radii: &[f64], z: f64, count: usize) -> Vec<Point> {
    (0..=count).map(|i| polar(radius_at(radii, azimuth(i, count)).abs(), azimuth(i, count), z)).collect()
}

/// The triangles of a body along the axis: sections of the same number of radii at rising z, with its two faces. Every corner stands
/// counter-clockwise seen from outside. Of a bore, whose radii are negative, the wall alone, seen from the axis.
pub(super) fn body(sections: &[(f64, Vec<f64>)]) -> Vec<Point> {
    let (Some((first_z, first)), Some((last_z, last))) = (sections.first(), sections.last()) else { return Vec::new() };
    let count = first.len();
    let is_bore = first.first().is_some_and(|radius| *radius < 0.0);
    let at = |section: &(f64, Vec<f64>), i: usize| polar(section.1[i % count].abs(), azimuth(i, count), section.0);
    let mut points = Vec::with_capacity(6 * count * sections.len());
    for i in 0..count {
        for pair in sections.windows(2) {
            let pair = if is_bore { [&pair[1], &pair[0]] } else { [&pair[0], &pair[1]] };
            let [a, b] = [at(pair[0], i), at(pair[0], i + 1)];
            let [c, d] = [at(pair[1], i), at(pair[1], i + 1)];
            points.extend([a, b.clone(), d.clone(), at(pair[0], i), d, c]);
        }
        if is_bore {
            continue;
        }
        let (start, end) = (azimuth(i, count), azimuth(i + 1, count));
        let centre = |z: f64| Point { x: 0.0, y: 0.0, z };
        let next = (i + 1) % count;
        points.extend([centre(*first_z), polar(first[next], end, *first_z), polar(first[i], start, *first_z)]);
        points.extend([centre(*last_z), polar(last[i], start, *last_z), polar(last[next], end, *last_z)]);
    }
    points
}
