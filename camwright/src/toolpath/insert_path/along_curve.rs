// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The spiral whose contact goes along every section at constant speed.
//!
//! On the section at angle j the contact has gone `s_j(k)` = `S_j·k/K` along the curve at knot k, `S_j` being the length of that section and K
//! the number of knots, so that all sections begin and end together and the way of a turn is the same each turn. Derivatives over the
//! turned angle are differences of sixth order over the equal steps, for the contact depends on all of the way behind it.

use super::contact::Contacts;
use super::{InsertPathError, PathRequest, ZLaw, spline};
use crate::math::uniform_hermite::UniformHermite;
use crate::math::units::deg_from_rad;
use crate::toolpath::rake_section::SectionPoint;
use alloc::vec;
use alloc::vec::Vec;

/// Knots beyond either end that differences need.
const BESIDE: u32 = 3;

/// Pieces in which the length of a whole section is measured, at least.
const PIECES: u32 = 64;

/// Nodes and weights of Gauss and Legendre's rule of five points on −1..1.
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

pub(super) fn spiral(
    contacts: &Contacts<'_>,
    request: &PathRequest,
    feed: f64,
) -> Result<(UniformHermite, ZLaw, Vec<f64>), InsertPathError> {
    let reach = contacts.reach_mm();
    if let Some((turned, z_mm, radius_mm)) = contacts.hollows().tightest().filter(|(_, _, radius)| *radius <= reach) {
        let turned_deg = deg_from_rad(turned);
        return Err(InsertPathError::TooHollow { turned_deg, z_mm, radius_mm, bound_mm: reach });
    }
    let step = request.step_rad();
    let turned = |angle: u32| request.start_rad + (f64::from(angle) - f64::from(BESIDE)) * step;
    let mut lengths = Vec::with_capacity(request.angles as usize);
    for angle in 0..request.angles {
        let mut length = 0.0;
        let mut along = SectionLocation::new(contacts, turned(angle), request.from_mm)?;
        for piece in 1..=PIECES {
            let share = f64::from(piece) / f64::from(PIECES);
            let to = request.from_mm + share * (request.to_mm - request.from_mm);
            length += along.length(along.z_mm, to)?;
            along.z_mm = to;
        }
        lengths.push(length);
    }
    let longest = lengths.iter().fold(0.0_f64, |max, length| max.max(length.abs()));
    let steps = request.steps(longest / feed)?;
    // Knot k − BESIDE of the path is entry k here.
    let count = steps + 1 + 2 * BESIDE;
    let mut centres = vec![[0.0; 2]; count as usize];
    let mut edge_rad = vec![0.0; count as usize];
    for (angle, length) in (0..request.angles.min(count)).zip(lengths) {
        let mut along = SectionLocation::new(contacts, turned(angle), request.from_mm)?;
        let way = |knots: f64| length * knots / f64::from(steps);
        along.advance(way(f64::from(angle) - f64::from(BESIDE)))?;
        let mut k = angle;
        loop {
            centres[k as usize] = along.centre(reach);
            edge_rad[k as usize] = libm::atan(along.point.by_z);
            k += request.angles;
            if k >= count {
                break;
            }
            along.advance(way(f64::from(request.angles)))?;
        }
    }
    let knots = |axis: usize| {
        let value = |k: usize, by: usize, sign: f64| centres[k + by][axis] + sign * centres[k - by][axis];
        (3..centres.len() - 3)
            .map(|k| {
                let first = (45.0 * value(k, 1, -1.0) - 9.0 * value(k, 2, -1.0) + value(k, 3, -1.0)) / (60.0 * step);
                let here = centres[k][axis];
                let bend = |by: usize| value(k, by, 1.0) - 2.0 * here;
                let second = (270.0 * bend(1) - 27.0 * bend(2) + 2.0 * bend(3)) / (180.0 * step * step);
                [here, first, second]
            })
            .collect::<Vec<_>>()
    };
    let x = spline(request.start_rad, step, knots(0))?;
    let z = spline(request.start_rad, step, knots(1))?;
    Ok((x, ZLaw::Spline(z), edge_rad[BESIDE as usize..].iter().copied().take(steps as usize + 1).collect()))
}

/// A place on the section of one angle.
struct SectionLocation<'a> {
    contacts: &'a Contacts<'a>,
    turned_rad: f64,
    z_mm: f64,
    point: SectionPoint,
}

impl<'a> SectionLocation<'a> {
    fn new(contacts: &'a Contacts<'a>, turned_rad: f64, z_mm: f64) -> Result<Self, InsertPathError> {
        let point = contacts.section().point(turned_rad, z_mm)?;
        Ok(Self { contacts, turned_rad, z_mm, point })
    }

    /// The section's point at a z, near the one known.
    fn point(&self, z_mm: f64) -> Result<SectionPoint, InsertPathError> {
        let section = self.contacts.section();
        if section.is_single() {
            let point = section.near(self.turned_rad, z_mm, self.point.lead_rad);
            Ok(section.checked(point, self.turned_rad)?)
        } else {
            Ok(section.point(self.turned_rad, z_mm)?)
        }
    }

    /// Length of the section's curve from one z to another, negative backwards (mm).
    fn length(&self, from: f64, to: f64) -> Result<f64, InsertPathError> {
        let half = 0.5 * (to - from);
        let mut sum = 0.0;
        for (node, weight) in GAUSS {
            let slope = self.point(from + half * (1.0 + node))?.by_z;
            sum += weight * libm::sqrt(1.0 + slope * slope);
        }
        Ok(half * sum)
    }

    /// Goes a way along the curve (mm).
    fn advance(&mut self, way: f64) -> Result<(), InsertPathError> {
        let from = self.z_mm;
        let speed = |point: &SectionPoint| libm::sqrt(1.0 + point.by_z * point.by_z);
        let mut to = from + way / speed(&self.point);
        for _ in 0..20 {
            let miss = self.length(from, to)? - way;
            self.point = self.point(to)?;
            let back = miss / speed(&self.point);
            to -= back;
            if back.abs() < 1e-11 {
                break;
            }
        }
        self.z_mm = to;
        self.point = self.point(to)?;
        Ok(())
    }

    /// Position of the centre of an insert that touches here.
    fn centre(&self, reach: f64) -> [f64; 2] {
        let slope = self.point.by_z;
        let w = libm::sqrt(1.0 + slope * slope);
        [self.point.x_mm + reach / w, self.z_mm - reach * slope / w]
    }
}
