// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Contact of the insert with the section.

use super::InsertPathError;
use super::hollow::{Hollow, Hollows};
use crate::math::units::deg_from_rad;
use crate::toolpath::rake_section::{RakeSection, SectionPoint};
use alloc::vec::Vec;

/// Contact point of the insert, and position of its centre.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Contact {
    /// The point of the section.
    pub(super) point: SectionPoint,
    /// X of the insert's centre (mm).
    pub(super) x_mm: f64,
    /// 1 − R·curvature: how the centre moves with the contact; 0 where it would stand still.
    pub(super) room: f64,
    /// True if the contact was searched among all points within reach, because a hollow is near.
    pub(super) hollow: bool,
    reach_mm: f64,
}

impl Contact {
    fn at(point: SectionPoint, reach_mm: f64) -> Self {
        let w = libm::sqrt(1.0 + point.by_z * point.by_z);
        Self { point, x_mm: point.x_mm + reach_mm / w, room: 1.0 - reach_mm * point.hollow(), hollow: false, reach_mm }
    }

    /// Place of the contact on the insert's edge, with the centre at `centre_mm`: τ, positive towards +z (rad).
    pub(super) fn edge_rad(&self, centre_mm: f64) -> f64 {
        libm::atan2(self.point.z_mm - centre_mm, self.x_mm - self.point.x_mm)
    }

    /// X over the turned angle: value, first and second derivative, where z of the centre has these.
    pub(super) fn knot(&self, z_first: f64, z_second: f64) -> [f64; 3] {
        let p = &self.point;
        let w = 1.0 + p.by_z * p.by_z;
        let pull = self.reach_mm / (w * libm::sqrt(w));
        // How the contact moves: z − R sin τ = z_R all the time.
        let contact = (z_first + pull * p.by_z_and_turn) / self.room;
        [
            self.x_mm,
            p.by_turn + p.by_z * z_first,
            p.by_turn_twice
                + p.by_z_and_turn * (contact + z_first)
                + p.by_z_twice * contact * z_first
                + p.by_z * z_second,
        ]
    }
}

/// Contacts of an insert with the sections of a surface.
#[derive(Debug)]
pub(super) struct Contacts<'a> {
    section: &'a RakeSection<'a>,
    reach_mm: f64,
    hollows: &'a Hollows,
}

/// Steps of Newton's method. From the extrapolated contact two are usual.
const MAX_STEPS: u32 = 60;

/// Changes whose squares are below rounding (rad, mm): the last step is taken by derivatives, without another look at the surface.
const CLOSE: f64 = 1e-7;

/// Least [`Contact::room`] with which a contact is followed to the next.
const MIN_ROOM: f64 = 0.02;

/// Maximum distance of a contact from its extrapolation (mm) before all points are searched.
const JUMP_MM: f64 = 0.05;

/// Points from one edge of the insert to the other among which the highest is looked for.
const SCANNED: u32 = 64;

impl<'a> Contacts<'a> {
    pub(super) fn new(section: &'a RakeSection<'a>, reach_mm: f64, hollows: &'a Hollows) -> Self {
        Self { section, reach_mm, hollows }
    }

    pub(super) fn reach_mm(&self) -> f64 {
        self.reach_mm
    }

    pub(super) fn section(&self) -> &'a RakeSection<'a> {
        self.section
    }

    pub(super) fn hollows(&self) -> &'a Hollows {
        self.hollows
    }

    /// Contacts one after the other.
    pub(super) fn follow(&self) -> ContactTracker<'_> {
        ContactTracker { contacts: self, before: [(0.0, 0.0); 6], known: 0, jumped: false }
    }

    /// The contact near a place (ψ, z), by Newton's method in both at once: `None` where that leads nowhere.
    ///
    /// z is moved as if the place lay on the section already, ψ along with it; both then close in on each other.
    fn near(&self, turned_rad: f64, centre_mm: f64, lead_rad: f64, z_mm: f64) -> Option<Contact> {
        let (low, high) = (centre_mm - self.reach_mm, centre_mm + self.reach_mm);
        let (mut lead, mut z) = (lead_rad, z_mm);
        for _ in 0..MAX_STEPS {
            let (place, off) = self.section.place(turned_rad, z, lead);
            if off.is_nan() || off.abs() > 0.5 {
                return None;
            }
            let on = place.moved(off);
            let point = on.section(self.section.y_mm(), z);
            let contact = Contact::at(point, self.reach_mm);
            let sine = point.by_z / libm::sqrt(1.0 + point.by_z * point.by_z);
            let miss = z - centre_mm - self.reach_mm * sine;
            if contact.room.is_nan() || contact.room < MIN_ROOM {
                return None;
            }
            let back = miss / contact.room;
            if off.abs() < CLOSE && back.abs() < CLOSE {
                let x = point.x_mm - back * (point.by_z - 0.5 * back * point.by_z_twice);
                let by_z = point.by_z - back * point.by_z_twice;
                let point = SectionPoint { z_mm: z - back, x_mm: x, by_z, ..point };
                return Some(Contact::at(point, self.reach_mm));
            }
            let next = (z - back).clamp(low, high);
            // ψ over x is −y₀/r².
            let r = point.surface.radius_mm;
            lead = point.lead_rad - self.section.y_mm() / (r * r) * point.by_z * (next - z);
            z = next;
        }
        None
    }

    /// The contact at a turned angle and z of the centre: the one that lets the insert come no nearer, looked for among all where a
    /// hollow is within reach.
    pub(super) fn envelope(&self, turned_rad: f64, centre_mm: f64) -> Result<Contact, InsertPathError> {
        if !self.hollows.within_reach(turned_rad, centre_mm) {
            let start = self.section.point(turned_rad, centre_mm)?;
            let w = libm::sqrt(1.0 + start.by_z * start.by_z);
            let z = centre_mm + self.reach_mm * start.by_z / w;
            let start = self.section.point(turned_rad, z)?;
            if let Some(contact) = self.near(turned_rad, centre_mm, start.lead_rad, z) {
                self.section.checked(contact.point, turned_rad)?;
                return Ok(contact);
            }
        }
        self.highest(turned_rad, centre_mm)
    }

    /// The highest of all points within reach.
    fn highest(&self, turned_rad: f64, centre_mm: f64) -> Result<Contact, InsertPathError> {
        let reach = self.reach_mm;
        // Equal steps of the angle round the insert: closest together where its edge is steep.
        let at = |k: f64| centre_mm - reach * libm::cos(core::f64::consts::PI * k / f64::from(SCANNED));
        let height = |z: f64| {
            let d = z - centre_mm;
            let point = self.section.point(turned_rad, z)?;
            Ok::<_, InsertPathError>((point.x_mm + libm::sqrt(((reach - d) * (reach + d)).max(0.0)), point))
        };
        let mut best = (f64::NEG_INFINITY, 0.0);
        for k in 0..=SCANNED {
            let (value, _) = height(at(f64::from(k)))?;
            if value > best.0 {
                best = (value, f64::from(k));
            }
        }
        // Its slope falls through zero at the top: x_z = (z − z_R)/√(R² − (z − z_R)²).
        let (mut low, mut high) = (at((best.1 - 1.0).max(0.0)), at((best.1 + 1.0).min(f64::from(SCANNED))));
        let mut z = at(best.1);
        for _ in 0..MAX_STEPS {
            let point = self.section.point(turned_rad, z)?;
            let contact = Contact::at(point, reach);
            let sine = point.by_z / libm::sqrt(1.0 + point.by_z * point.by_z);
            let miss = z - centre_mm - reach * sine;
            if miss > 0.0 {
                high = z;
            } else {
                low = z;
            }
            let next = z - miss / contact.room;
            let next = if contact.room > 0.0 && next > low && next < high { next } else { 0.5 * (low + high) };
            let done = (next - z).abs() < 1e-12 * reach;
            z = next;
            if done {
                break;
            }
        }
        let (value, point) = height(z)?;
        Ok(Contact { x_mm: value, hollow: true, ..Contact::at(point, reach) })
    }

    /// Distance of a place (X, `z_R`) from the section: the least of `tried` points within reach and of what lies between the nearest (mm).
    pub(super) fn nearest(&self, turned_rad: f64, x_mm: f64, z_mm: f64, tried: u32) -> Result<f64, InsertPathError> {
        let at = |k: f64| z_mm + self.reach_mm * (2.0 * k / f64::from(tried) - 1.0);
        let mut lead = None;
        let mut distance = |z: f64| {
            let point = match lead.filter(|_| self.section.is_single()) {
                Some(lead) => self.section.near(turned_rad, z, lead),
                None => self.section.point(turned_rad, z)?,
            };
            lead = Some(point.lead_rad);
            Ok::<_, InsertPathError>(libm::hypot(point.x_mm - x_mm, z - z_mm))
        };
        let mut best = (f64::INFINITY, 0.0);
        for k in 0..=tried {
            let value = distance(at(f64::from(k)))?;
            if value < best.0 {
                best = (value, f64::from(k));
            }
        }
        let (mut low, mut high) = (at(best.1 - 1.0), at(best.1 + 1.0));
        for _ in 0..40 {
            let third = (high - low) / 3.0;
            if distance(low + third)? < distance(high - third)? { high -= third } else { low += third }
        }
        Ok(best.0.min(distance(0.5 * (low + high))?))
    }

    /// Returns the tightest hollow, with what the insert leaves in it, if the insert bridges it.
    pub(super) fn bridged_hollow(&self) -> Result<Option<Hollow>, InsertPathError> {
        /// Places along z at which the insert's edge is evaluated.
        const PLACES: u32 = 200;
        let (Some((turned, z_mm, radius_mm)), Some((low, high))) = (self.hollows.tightest(), self.hollows.range_mm())
        else {
            return Ok(None);
        };
        let reach = self.reach_mm;
        if radius_mm >= reach {
            return Ok(None);
        }
        // What the insert leaves at a place is the lowest of its edge in all positions within reach.
        let at = |k: u32, from: f64, to: f64| from + (to - from) * f64::from(k) / f64::from(PLACES);
        let mut centres = Vec::with_capacity(PLACES as usize + 1);
        for k in 0..=PLACES {
            let centre = at(k, low - reach, high + reach);
            centres.push((centre, self.envelope(turned, centre)?.x_mm));
        }
        let mut left_mm = 0.0_f64;
        for k in 0..=PLACES {
            let z = at(k, low, high);
            let edge = |&(centre, x): &(f64, f64)| {
                let d = z - centre;
                (d.abs() < reach).then(|| x - libm::sqrt((reach - d) * (reach + d)))
            };
            let lowest = centres.iter().filter_map(edge).fold(f64::INFINITY, f64::min);
            left_mm = left_mm.max(lowest - self.section().point(turned, z)?.x_mm);
        }
        Ok(Some(Hollow { turned_deg: deg_from_rad(turned), z_mm, radius_mm, bound_mm: reach, left_mm }))
    }
}

/// Extrapolation weights for one to six values at equal steps, the newest first: the polynomial through them, one step on. Six are so exact
/// that a single evaluation of the surface mostly suffices.
const POINTING: [[f64; 6]; 6] = [
    [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [2.0, -1.0, 0.0, 0.0, 0.0, 0.0],
    [3.0, -3.0, 1.0, 0.0, 0.0, 0.0],
    [4.0, -6.0, 4.0, -1.0, 0.0, 0.0],
    [5.0, -10.0, 10.0, -5.0, 1.0, 0.0],
    [6.0, -15.0, 20.0, -15.0, 6.0, -1.0],
];

/// Contacts at equal steps of the turned angle: the next is begun where the last ones point to.
#[derive(Debug)]
pub(super) struct ContactTracker<'a> {
    contacts: &'a Contacts<'a>,
    /// ψ and z − `z_R`, the newest last.
    before: [(f64, f64); 6],
    known: usize,
    jumped: bool,
}

impl ContactTracker<'_> {
    /// Returns whether the last contact differs from the extrapolation.
    pub(super) fn jumped(&self) -> bool {
        self.jumped
    }

    pub(super) fn next(&mut self, turned_rad: f64, centre_mm: f64) -> Result<Contact, InsertPathError> {
        let expected = POINTING.get(self.known.wrapping_sub(1)).map(|weights| {
            let newest = self.before.iter().rev().zip(weights);
            newest.fold((0.0, 0.0), |(lead, off), (before, weight)| (lead + weight * before.0, off + weight * before.1))
        });
        let contacts = self.contacts;
        // What is not proven to be single is looked for from outside every time.
        let follows = contacts.section.is_single() && !contacts.hollows.within_reach(turned_rad, centre_mm);
        let near = expected
            .filter(|_| follows)
            .and_then(|(lead, off)| contacts.near(turned_rad, centre_mm, lead, centre_mm + off))
            .filter(|contact| {
                let off = contact.point.z_mm - centre_mm;
                expected.is_none_or(|(_, expected)| (off - expected).abs() < JUMP_MM)
            });
        let contact = match near {
            Some(contact) => {
                contacts.section.checked(contact.point, turned_rad)?;
                contact
            }
            None => contacts.envelope(turned_rad, centre_mm)?,
        };
        let off = contact.point.z_mm - centre_mm;
        let elsewhere = |(lead, expected): (f64, f64)| {
            (off - expected).abs() > JUMP_MM || (contact.point.lead_rad - lead).abs() > 0.02
        };
        self.jumped = expected.is_some_and(elsewhere);
        if self.jumped {
            self.known = 0;
        }
        self.before.rotate_left(1);
        self.before[5] = (contact.point.lead_rad, off);
        self.known = (self.known + 1).min(6);
        Ok(contact)
    }
}
