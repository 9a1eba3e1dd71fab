// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A wheel that presses on a lobe: how far machine and part deflect, and what it cuts where it then stands.
//!
//! The engagement of the contact law is found against the surface that the wheel met, not the one that it leaves: every azimuth
//! keeps its radius from before the present pass until it is opposite the wheel.

use super::cut_record::ContactSample;
use super::{BLOCK, BlockList, Lobe, Removal, WheelCentre, WheelDirection, WheelPass, largest, smallest};
use crate::machine::contact_law::ContactLaw;
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Deflection of wheel and part against each other, and its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deflection {
    /// T, along the normal of the contact (mm).
    pub mm: f64,
    /// The normal, from the part to the wheel: its share along the line from the part's axis to the wheel's centre, and across it,
    /// positive towards greater azimuths.
    pub normal: (f64, f64),
}

crate::snapshot!(Deflection { mm, normal } on {});

impl Default for Deflection {
    fn default() -> Self {
        Self { mm: 0.0, normal: (1.0, 0.0) }
    }
}

impl WheelDirection {
    /// The wheel where it stands when it has given way.
    fn deflected(&self, by: Deflection) -> Self {
        let (along, across) = (self.centre_mm + by.mm * by.normal.0, by.mm * by.normal.1);
        let centre_mm = libm::copysign(libm::sqrt(along * along + across * across), along);
        let (cos, sin) = self.direction;
        Self {
            centre_mm,
            direction: ((cos * along - sin * across) / centre_mm, (sin * along + cos * across) / centre_mm),
            // Only says in which block to begin; the angle is small.
            azimuth_rad: self.azimuth_rad + across / along,
            ..*self
        }
    }
}

/// The surface that the wheel meets: radii from before the present pass.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EngagedSurface {
    radii: Vec<f64>,
    block_reach: Vec<f64>,
    reach: f64,
    /// Azimuth up to which it has been brought up to date; none while no wheel is near, and all of it is.
    upto: Option<usize>,
}

impl EngagedSurface {
    pub(super) fn new(radii: &[f64], block_reach: &[f64]) -> Self {
        Self { radii: radii.to_vec(), block_reach: block_reach.to_vec(), reach: largest(block_reach), upto: None }
    }

    /// Upper bounds of the radii of every block, and of all.
    pub(super) fn reaches(&self) -> (&[f64], f64) {
        (&self.block_reach, self.reach)
    }
}

impl Snapshot for EngagedSurface {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self { radii, block_reach, reach, upto } = self;
        codec.field("radii", |codec| codec.numbers(radii))?;
        codec.field("block_reach", |codec| codec.numbers(block_reach))?;
        codec.field("reach", |codec| reach.snapshot(codec))?;
        codec.field("upto", |codec| upto.snapshot(codec))?;
        match upto {
            Some(azimuth) if *azimuth >= radii.len() => Err(SnapshotError::Impossible("there is no such azimuth")),
            _ => Ok(()),
        }
    }
}

/// Deepest point of a wheel in the surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DeepestTouch {
    pub(crate) depth_mm: f64,
    pub(crate) normal: (f64, f64),
    /// Index of the azimuth nearest to it.
    at: usize,
}

/// Contact of an undeflected wheel with a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Engagement {
    /// The wheel is outside of the surface's largest radius.
    Clear,
    /// The wheel is over the centre of the surface.
    OverCentre,
    /// The wheel touches nothing.
    Apart,
    /// The wheel touches with its engagement as the depth.
    Touch(DeepestTouch),
}

/// Cut of a wheel that touches a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TouchedCut {
    /// U, depth of the cut along the normal (mm).
    pub(crate) depth_mm: f64,
    pub(crate) deflection: Deflection,
    /// Normal force of the whole contact (N).
    pub(crate) force_n: f64,
    /// The wheel is fast enough to cut.
    pub(crate) cuts: bool,
    /// Length of the moment (s).
    pub(crate) time_s: f64,
}

impl Lobe {
    /// No wheel is near: all that was cut has been passed.
    pub(crate) fn leave(&mut self) {
        if let Some(record) = &mut self.record {
            record.leave();
        }
        if self.met.upto.take().is_some() {
            self.met.radii.copy_from_slice(&self.radii);
            self.met.block_reach.copy_from_slice(&self.block_reach);
            self.met.reach = largest(&self.met.block_reach);
        }
    }

    /// The wheel stands here for a moment, undeflected, and had given way like this in the moment before: what it removes, and how
    /// far it deflects now. With `cuts` false it only presses. The moment is so long (s). The cut itself is made at the end of the pass.
    ///
    /// The law's engagement is the depth of the wheel as it stood deflected, and that deflection: as the deflected wheel runs along the
    /// surface that it makes, its deepest point is the one that counts, however steeply the undeflected wheel closes in.
    pub(crate) fn press(
        &mut self,
        wheel: WheelCentre,
        law: &ContactLaw,
        before: Deflection,
        (cuts, time_s): (bool, f64),
        pass: &mut WheelPass,
    ) -> (Removal, Deflection) {
        let touch = match self.engage(wheel, before, pass) {
            Engagement::Clear => return (Removal::default(), Deflection::default()),
            Engagement::OverCentre => return (self.pass(wheel, cuts), Deflection::default()),
            Engagement::Apart => return (self.part_from(pass), Deflection::default()),
            Engagement::Touch(touch) => touch,
        };
        let depth_mm = if cuts { law.depth_of_cut_mm(touch.depth_mm) } else { 0.0 };
        let deflection = Deflection { mm: touch.depth_mm - depth_mm, normal: touch.normal };
        let cut = TouchedCut { depth_mm, deflection, force_n: law.force_n(deflection.mm), cuts, time_s };
        (self.cut_touched(wheel, touch, &cut, pass), deflection)
    }

    /// Engagement of a wheel that had given way like this in the moment before.
    pub(crate) fn engage(&mut self, wheel: WheelCentre, before: Deflection, pass: &WheelPass) -> Engagement {
        if wheel.centre_mm - wheel.radius_mm >= self.met.reach {
            return Engagement::Clear;
        }
        if self.is_over_axis(wheel.centre_mm, wheel.radius_mm) {
            return Engagement::OverCentre;
        }
        self.bring_up_to(wheel.azimuth_rad);
        let wheel = WheelDirection::from_wheel(wheel);
        let touch = match self.touch(&wheel.deflected(before), Some(&pass.near)) {
            Some(touch) => Some(DeepestTouch { depth_mm: touch.depth_mm + before.mm, ..touch }),
            None => self.touch(&wheel, Some(&pass.near)),
        };
        touch.map_or(Engagement::Apart, Engagement::Touch)
    }

    /// The wheel touches nothing: makes the cuts that wait.
    pub(crate) fn part_from(&mut self, pass: &mut WheelPass) -> Removal {
        let removal = self.finish(pass);
        if let Some(record) = &mut self.record {
            record.leave();
        }
        removal
    }

    /// Lets an undeflected wheel that touches here cut at the end of the pass, where it stands when it has given way.
    pub(crate) fn cut_touched(
        &mut self,
        wheel: WheelCentre,
        touch: DeepestTouch,
        &TouchedCut { depth_mm, deflection, force_n, cuts, time_s }: &TouchedCut,
        pass: &mut WheelPass,
    ) -> Removal {
        let contact = self.record.is_some().then(|| {
            let azimuth_rad = touch.at as f64 / self.radii.len() as f64 * TURN_RAD;
            let sample = ContactSample { azimuth_rad, area_mm2: 0.0, depth_mm, force_n, cos_beta: touch.normal.0 };
            (wheel, sample, time_s)
        });
        let cut = (cuts && depth_mm > 0.0).then(|| WheelDirection::from_wheel(wheel).deflected(deflection));
        let removal = self.cut_later(cut, contact, pass);
        removal.and(Removal { depth_mm: if cuts { 0.0 } else { touch.depth_mm }, ..Removal::default() })
    }

    /// Updates the surface that the wheel meets again: its own cut, from the azimuth opposite the wheel on.
    fn bring_up_to(&mut self, azimuth_rad: f64) {
        let n = self.radii.len();
        let opposite = self.facing(azimuth_rad + 0.5 * TURN_RAD);
        let from = self.met.upto.replace(opposite).unwrap_or(opposite);
        let upwards = (opposite + n - from) % n;
        // The shorter way round.
        let (first, count) = if upwards <= n / 2 { (from, upwards) } else { (opposite, n - upwards) };
        let mut left = count;
        let mut at = first;
        let mut lost_reach = false;
        while left > 0 {
            let block = at / BLOCK;
            let end = ((block + 1) * BLOCK).min(n);
            let part = (end - at).min(left);
            self.met.radii[at..at + part].copy_from_slice(&self.radii[at..at + part]);
            // Until an edge of the block is passed, its reach stays the bound that it is.
            if at == block * BLOCK || at + part == end {
                let before = self.met.block_reach[block];
                let reach = largest(&self.met.radii[block * BLOCK..end]);
                self.met.block_reach[block] = reach;
                lost_reach |= reach < before && before >= self.met.reach;
            }
            left -= part;
            at = if end == n { 0 } else { end };
        }
        // What is cut only gets smaller: another block than the largest changes nothing.
        if lost_reach {
            self.met.reach = largest(&self.met.block_reach);
        }
    }

    /// Finds the deepest point of a wheel in the surface: the azimuth nearest to its centre, and between its neighbours the vertex of a
    /// parabola. `None` without contact.
    fn touch(&self, wheel: &WheelDirection, near: Option<&BlockList>) -> Option<DeepestTouch> {
        let (x, radius) = (wheel.centre_mm, wheel.radius_mm);
        let (cos, sin) = wheel.direction;
        let mut nearest = (radius * radius, None);
        let mut near = self.search(wheel, near);
        while let Some(block) = near.next(self.block_reach.len(), |block, edge| {
            let at = self.azimuth_of(block, edge);
            let cos = wheel.cos_to(self.cos[at], self.sin[at]);
            (wheel.has(self.met.reach, cos), wheel.has(self.met.block_reach[block], cos))
        }) {
            let start = block * BLOCK;
            let end = (start + BLOCK).min(self.radii.len());
            let squares = wheel.squares(&self.met.radii[start..end], &self.cos[start..end], &self.sin[start..end]);
            let min = smallest(&squares);
            if min < nearest.0
                && let Some(i) = squares.iter().position(|square| *square <= min)
            {
                nearest = (min, Some(start + i));
            }
        }
        let at = nearest.1?;
        let n = self.radii.len();
        // From a point of the surface to the wheel's centre, along the wheel's line and across it.
        let to_centre = |i: usize| {
            let (r, c, s) = (self.met.radii[i], self.cos[i], self.sin[i]);
            (x - r * (c * cos + s * sin), -r * (s * cos - c * sin))
        };
        let neighbours = [to_centre((at + n - 1) % n), to_centre(at), to_centre((at + 1) % n)];
        let [left, here, right] =
            neighbours.map(|(along, across)| radius - libm::sqrt(along * along + across * across));
        let bend = 2.0 * here - left - right;
        // Half a step at most, since none of the three is deeper than the middle.
        let aside = if bend > 0.0 { 0.5 * (right - left) / bend } else { 0.0 };
        let depth_mm = here + 0.25 * (right - left) * aside;
        let [(along0, across0), (along1, across1), (along2, across2)] = neighbours;
        let (along, across) = (along1 + 0.5 * (along2 - along0) * aside, across1 + 0.5 * (across2 - across0) * aside);
        let length = libm::sqrt(along * along + across * across);
        Some(DeepestTouch { depth_mm, normal: (along / length, across / length), at })
    }
}
