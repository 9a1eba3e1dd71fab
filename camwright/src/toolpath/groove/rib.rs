// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Ribs between the turns of a groove round a cylinder, and between two grooves; rollers of a turret in them.
//!
//! Pitch curves are compared on the floor, developed: there they come nearest to each other. Where two of them come within the width of the
//! groove the rib between them vanishes. That is meant where they cross or run into each other; elsewhere it is refused.

use super::GrooveError;
use super::barrel::BarrelGroove;
use super::course::{STATION_CLOSURE_RAD, Turret};
use crate::math::extremum::golden_section;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};

/// A groove at its place on the part.
#[derive(Debug, Clone, Copy)]
pub struct PlacedGroove<'a> {
    pub name: &'a str,
    pub groove: &'a BarrelGroove,
    /// Z of the roller at lift 0, or of the turret's axis (mm).
    pub z_mm: f64,
    /// Phase α: from the keyway to azimuth 0 of the groove (rad).
    pub phase_rad: f64,
}

/// Azimuths of a turn at which neighbours are compared.
const AZIMUTHS_PER_TURN: u32 = 1440;

/// Azimuths beside a place among which the nearest one of the neighbour is looked for.
const TRIED: u32 = 32;

/// Pitch curves that come so near run into each other (mm).
const MEET_MM: f64 = 1e-6;

impl BarrelGroove {
    /// Checks that ribs remain between the turns of the groove, which may cross each other or not.
    ///
    /// # Errors
    /// Turns that come too near to each other without a crossing, or that cross and may not.
    pub fn check_turns(&self, may_cross: bool) -> Result<(), GrooveError> {
        let placed = PlacedGroove { name: "", groove: self, z_mm: 0.0, phase_rad: 0.0 };
        (1..self.course().turns()).try_for_each(|by| {
            placed.check_pair(&placed, f64::from(by) * TURN_RAD, may_cross, || "its turns".to_string())
        })
    }
}

impl PlacedGroove<'_> {
    /// Checks that a rib remains between two grooves.
    ///
    /// # Errors
    /// Grooves that come too near to each other without a crossing.
    pub fn check_rib_beside(&self, other: &PlacedGroove<'_>) -> Result<(), GrooveError> {
        let (a, b) = (self.groove, other.groove);
        if a.floor_radius_mm() >= b.outer_radius_mm() || b.floor_radius_mm() >= a.outer_radius_mm() {
            return Ok(());
        }
        let turned_rad = wrap_turn(self.phase_rad - other.phase_rad);
        let last = i32::try_from(b.course().turns()).unwrap_or(i32::MAX);
        let first = if b.course().is_open() { -i32::try_from(a.course().turns()).unwrap_or(0) } else { 0 };
        (first..last).try_for_each(|by| {
            let names = || format!("grooves {} and {}", self.name, other.name);
            self.check_pair(other, turned_rad + f64::from(by) * TURN_RAD, true, names)
        })
    }

    /// Checks that the neighbours of a roller on a turret stand in a groove too, wherever they reach into the cylinder.
    ///
    /// # Errors
    /// A roller that stands in none of the grooves.
    pub fn check_rollers(&self, all: &[PlacedGroove<'_>]) -> Result<(), GrooveError> {
        let course = self.groove.course();
        let Some(turret) = course.turret() else { return Ok(()) };
        let steps = AZIMUTHS_PER_TURN * course.turns();
        for step in 0..=steps {
            let azimuth_rad = f64::from(step) * course.span_rad() / f64::from(steps);
            if !self.groove.is_inside(course.centre(azimuth_rad).z.value) {
                continue;
            }
            for next in [-1.0, 1.0] {
                let roller_rad = course.turret_angle_rad(azimuth_rad) + next * turret.station_rad();
                if self.reaches_in(&turret, roller_rad)
                    && !all.iter().any(|other| other.guides(self, &turret, azimuth_rad, roller_rad))
                {
                    return Err(GrooveError::NoGroove {
                        angle_deg: deg_from_rad(azimuth_rad),
                        roller_deg: deg_from_rad(roller_rad),
                        station_deg: deg_from_rad(turret.station_rad()),
                    });
                }
            }
        }
        Ok(())
    }

    /// Returns whether a roller at an angle of the turret reaches into the cylinder, down to the floor of this groove.
    fn reaches_in(&self, turret: &Turret, roller_rad: f64) -> bool {
        let [y_mm, z_mm] = turret.place_mm(roller_rad);
        let beside_mm = (y_mm.abs() - self.groove.roller_radius_mm()).max(0.0);
        let is_near = libm::hypot(self.groove.floor_radius_mm(), beside_mm) < self.groove.outer_radius_mm();
        roller_rad.abs() < PI && is_near && self.groove.is_inside(z_mm)
    }

    /// Returns whether a turn of this groove guides a roller at an angle of the turret, at an azimuth of another groove.
    fn guides(&self, of: &PlacedGroove<'_>, turret: &Turret, azimuth_rad: f64, roller_rad: f64) -> bool {
        let course = self.groove.course();
        let Some(own) = course.turret() else { return false };
        let [y_mm, z_mm] = turret.place_mm(roller_rad);
        let from_rad = wrap_turn(azimuth_rad + of.phase_rad - self.phase_rad);
        (0..course.turns()).any(|turn| {
            let [there_y_mm, there_z_mm] = own.place_mm(course.turret_angle_rad(from_rad + f64::from(turn) * TURN_RAD));
            let off_mm = libm::hypot(there_y_mm - y_mm, there_z_mm + self.z_mm - (z_mm + of.z_mm));
            off_mm <= STATION_CLOSURE_RAD * turret.radius_mm
        })
    }

    /// Compares this groove with another one at azimuths ahead by an angle.
    fn check_pair(
        &self,
        other: &PlacedGroove<'_>,
        ahead_rad: f64,
        may_cross: bool,
        names: impl Fn() -> String,
    ) -> Result<(), GrooveError> {
        let course = self.groove.course();
        let steps = AZIMUTHS_PER_TURN * course.turns();
        let step_rad = course.span_rad() / f64::from(steps);
        let pair = Pair::new(self, other, ahead_rad);
        let places: Vec<Option<Beside>> =
            (0..steps + u32::from(course.is_open())).map(|step| pair.at(f64::from(step) * step_rad)).collect();
        // Round a closed groove from a place where nothing is near, if there is one.
        let from = if course.is_open() { 0 } else { places.iter().position(Option::is_none).unwrap_or(0) };
        let mut run: Vec<(usize, Beside)> = Vec::new();
        for place in (0..=places.len()).map(|place| (from + place) % places.len().max(1)).take(places.len()) {
            match &places[place] {
                Some(beside) => run.push((place, *beside)),
                None => check_run(&core::mem::take(&mut run), step_rad, (pair.width_mm, may_cross), &names)?,
            }
        }
        check_run(&run, step_rad, (pair.width_mm, may_cross), &names)
    }
}

/// A neighbour that is too near.
#[derive(Debug, Clone, Copy)]
struct Beside {
    /// Distance of the pitch curves (mm).
    distance_mm: f64,
    /// Z of the neighbour less own Z, at the same azimuth of the part (mm).
    ahead_mm: f64,
}

/// A pitch curve that comes near to cross closes in at no less than this share of the mean rate from there to the crossing. Turns that run
/// beside each other before they cross do not close in.
const CLOSING_SHARE: f64 = 0.2;

/// Places one after the other at which the neighbour is too near: each must lead to a crossing.
fn check_run(
    run: &[(usize, Beside)],
    step_rad: f64,
    (bound_mm, may_cross): (f64, bool),
    names: &impl Fn() -> String,
) -> Result<(), GrooveError> {
    let ahead = |at: usize| run[at].1.ahead_mm;
    let crosses =
        |at: usize| ahead(at).abs() <= MEET_MM || (at + 1 < run.len() && (ahead(at) > 0.0) != (ahead(at + 1) > 0.0));
    let crossings: Vec<usize> = (0..run.len()).filter(|at| crosses(*at)).collect();
    if let Some(at) = crossings.first().filter(|_| !may_cross) {
        return Err(GrooveError::Crosses { angle_deg: deg_from_rad(run[*at].0 as f64 * step_rad) });
    }
    let leads_there = |at: usize| {
        let right = crossings.partition_point(|crossing| *crossing < at);
        let beside = [right.checked_sub(1), Some(right)].into_iter().flatten();
        let steps = beside.filter_map(|index| crossings.get(index)).map(|crossing| at.abs_diff(*crossing)).min();
        let (from, to) = (at.saturating_sub(1), (at + 1).min(run.len() - 1));
        let rate_mm = (ahead(to) - ahead(from)).abs() / (to - from).max(1) as f64;
        steps.is_some_and(|steps| steps <= 1 || rate_mm * steps as f64 >= CLOSING_SHARE * ahead(at).abs())
    };
    let lost = (0..run.len()).filter(|at| !leads_there(*at)).map(|at| &run[at]);
    match lost.min_by(|a, b| a.1.distance_mm.total_cmp(&b.1.distance_mm)) {
        Some((place, beside)) => Err(GrooveError::NoRib {
            turns: names(),
            angle_deg: deg_from_rad(*place as f64 * step_rad),
            distance_mm: beside.distance_mm,
            bound_mm,
        }),
        None => Ok(()),
    }
}

/// Two pitch curves on one floor.
struct Pair<'a> {
    own: &'a PlacedGroove<'a>,
    other: &'a PlacedGroove<'a>,
    ahead_rad: f64,
    floor_mm: f64,
    width_mm: f64,
    /// Azimuth on either side within which the nearest place is looked for (rad).
    reach_rad: f64,
    /// Beyond this distance along Z at the same azimuth nothing is near (mm).
    far_mm: f64,
}

impl<'a> Pair<'a> {
    fn new(own: &'a PlacedGroove<'a>, other: &'a PlacedGroove<'a>, ahead_rad: f64) -> Self {
        let floor_mm = own.groove.floor_radius_mm().max(other.groove.floor_radius_mm());
        let width_mm = own.groove.roller_radius_mm() + other.groove.roller_radius_mm();
        let course = other.groove.course();
        let steps = AZIMUTHS_PER_TURN * course.turns();
        let centres = (0..steps).map(|step| course.centre(f64::from(step) * course.span_rad() / f64::from(steps)));
        let (steepest, beside_mm) =
            centres.fold((0.0_f64, 0.0_f64), |(steep, y), at| (steep.max(at.z.first.abs()), y.max(at.y.value.abs())));
        let reach_rad = ((width_mm + 2.0 * beside_mm) / floor_mm).min(FRAC_PI_2);
        Self { own, other, ahead_rad, floor_mm, width_mm, reach_rad, far_mm: width_mm + 1.1 * steepest * reach_rad }
    }

    /// The neighbour of the place at an azimuth, if it is too near.
    fn at(&self, azimuth_rad: f64) -> Option<Beside> {
        let there_rad = azimuth_rad + self.ahead_rad;
        let course = self.other.groove.course();
        if course.is_open() && !(0.0..=course.span_rad()).contains(&there_rad) {
            return None;
        }
        let own = self.own.groove.course().centre(azimuth_rad);
        if !self.own.groove.is_inside(own.z.value) {
            return None;
        }
        let ahead_mm = self.other.z_mm + course.centre(there_rad).z.value - self.own.z_mm - own.z.value;
        if ahead_mm.abs() > self.far_mm {
            return None;
        }
        let distance = |by_rad: f64| {
            let centre = course.centre(there_rad + by_rad);
            if !self.other.groove.is_inside(centre.z.value) {
                return f64::INFINITY;
            }
            let across_mm = self.floor_mm * by_rad + centre.y.value - own.y.value;
            libm::hypot(across_mm, self.other.z_mm + centre.z.value - self.own.z_mm - own.z.value)
        };
        let step_rad = 2.0 * self.reach_rad / f64::from(TRIED);
        let nearest = (0..=TRIED)
            .map(|step| f64::from(step) * step_rad - self.reach_rad)
            .map(|by_rad| (by_rad, distance(by_rad)))
            .fold((0.0, f64::INFINITY), |best, new| if new.1 < best.1 { new } else { best });
        let refined = golden_section(nearest.0 - step_rad, nearest.0 + step_rad, &distance);
        let distance_mm = refined.1.min(nearest.1);
        (distance_mm <= self.width_mm).then_some(Beside { distance_mm, ahead_mm })
    }
}
