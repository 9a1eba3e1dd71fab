// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A wheel on its way along a lobe in a tick: the blocks near it, and the positions that have still to cut.
//!
//! An azimuth keeps the smallest radius that any position leaves it, in whatever order they cut. Ahead of the contact the last position leaves
//! the smallest: so the positions of a tick cut backwards, and each azimuth there is cut once instead of by every position.

use super::candidate_blocks::BlockList;
use super::cut_record::ContactSample;
use super::{BLOCK, Lobe, Removal, WheelCentre, WheelDirection};

/// Positions that wait for their cut; a servo step seldom has more than four.
const MAX_WAITING: usize = 24;

/// A position of the wheel.
#[derive(Debug, Clone, Copy)]
struct Position {
    /// The wheel where it cuts; `None`: it only rubs.
    cuts: Option<WheelDirection>,
    /// For the record of the cut: undeflected position, contact, duration (s).
    contact: Option<(WheelCentre, ContactSample, f64)>,
}

/// A tick of a wheel along one lobe. It is empty between ticks, so that any two are equal then.
#[derive(Debug, Clone)]
pub(crate) struct WheelPass {
    pub(super) near: BlockList,
    waiting: [Position; MAX_WAITING],
    count: usize,
}

impl PartialEq for WheelPass {
    fn eq(&self, other: &Self) -> bool {
        self.count == other.count
    }
}

impl WheelPass {
    pub(crate) const fn new() -> Self {
        Self { near: BlockList::new(), waiting: [Position { cuts: None, contact: None }; MAX_WAITING], count: 0 }
    }

    /// A tick begins: another lobe may be near, and be cut already.
    pub(crate) fn begin(&mut self) {
        self.near.clear();
        self.count = 0;
    }
}

/// Fewest azimuths of a lobe for [`WheelGone`]: the arc of a block is flat within [`FLAT`] then.
const MIN_AZIMUTHS: usize = 1800;

/// Height of the arc over a block, as a share of its radius.
const FLAT: f64 = 4e-4;

/// A wheel that has cut, seen from a position before it: of two equal discs the one whose centre is nearer to a point covers it more. So what
/// lies on the side of the later centre is not inside the earlier disc any more.
#[derive(Debug, Clone, Copy)]
pub(super) struct WheelGone {
    /// From the earlier centre to the later one (mm), and the product with their middle (mm²).
    way: (f64, f64),
    middle: f64,
    length: f64,
    /// Smallest radius that the earlier wheel reaches (mm).
    lowest_mm: f64,
}

impl WheelGone {
    fn new(earlier: &WheelDirection, later: &WheelDirection) -> Option<Self> {
        if earlier.radius_mm.to_bits() != later.radius_mm.to_bits() {
            return None;
        }
        let ((ax, ay), (bx, by)) = (earlier.disc().centre, later.disc().centre);
        let way = (bx - ax, by - ay);
        Some(Self {
            way,
            middle: 0.5 * (way.0 * (ax + bx) + way.1 * (ay + by)),
            length: libm::sqrt(way.0 * way.0 + way.1 * way.1),
            lowest_mm: (earlier.centre_mm - earlier.radius_mm).max(0.0),
        })
    }

    /// Returns whether a block of this reach, from one direction to another, has nothing more inside the earlier wheel.
    pub(super) fn covers(&self, reach: f64, edges: [(f64, f64); 2]) -> bool {
        let needed = self.middle + FLAT * self.length * reach;
        edges.iter().all(|(cos, sin)| {
            let along = self.way.0 * cos + self.way.1 * sin;
            along * reach > needed && along * self.lowest_mm > needed
        })
    }
}

impl Lobe {
    /// The wheel cuts here before the tick ends.
    pub(super) fn cut_later(
        &mut self,
        cuts: Option<WheelDirection>,
        contact: Option<(WheelCentre, ContactSample, f64)>,
        pass: &mut WheelPass,
    ) -> Removal {
        let removal = if pass.count == MAX_WAITING { self.finish(pass) } else { Removal::default() };
        pass.waiting[pass.count] = Position { cuts, contact };
        pass.count += 1;
        removal
    }

    /// Makes the cuts that wait. The record of the cut gives every position the same share of the area.
    pub(crate) fn finish(&mut self, pass: &mut WheelPass) -> Removal {
        let (mut removal, mut cuts) = (Removal::default(), 0.0);
        let mut later = None;
        let positions = &pass.waiting[..core::mem::take(&mut pass.count)];
        for wheel in positions.iter().rev().filter_map(|position| position.cuts.as_ref()) {
            let gone = later.filter(|_| self.shadows_blocks()).and_then(|later| WheelGone::new(wheel, later));
            removal = removal.and(self.cut_near(wheel, &pass.near, gone.as_ref()));
            (later, cuts) = (Some(wheel), cuts + 1.0);
        }
        let Some(record) = &mut self.record else { return removal };
        for Position { cuts: cut, contact } in positions {
            if let Some((position, sample, time_s)) = contact {
                let area_mm2 = if cut.is_some() { removal.area_mm2 / cuts } else { 0.0 };
                record.note(*position, ContactSample { area_mm2, ..*sample }, *time_s);
            }
        }
        removal
    }
}

impl Lobe {
    /// [`WheelGone`] holds for this surface.
    fn shadows_blocks(&self) -> bool {
        self.radii.len() >= MIN_AZIMUTHS && !self.is_bore
    }

    /// Cuts with the listed blocks in sight, but for those that a later position has left nothing of.
    fn cut_near(&mut self, wheel: &WheelDirection, near: &BlockList, gone: Option<&WheelGone>) -> Removal {
        let mut removal = Removal::default();
        let mut near = self.search(wheel, Some(near));
        while let Some(block) = near.next(self.block_reach.len(), |block, edge| self.look(wheel, block, edge)) {
            let (first, last) = (block * BLOCK, ((block + 1) * BLOCK).min(self.radii.len()) - 1);
            let edges = [first, last].map(|at| (self.cos[at], self.sin[at]));
            if !gone.is_some_and(|gone| gone.covers(self.block_reach[block], edges)) {
                removal = removal.and(self.cut_block(block, wheel, true));
            }
        }
        removal
    }
}

#[cfg(test)]
mod tests {
    use super::super::Deflection;
    use super::*;
    use crate::machine::contact_law::ContactLaw;
    use crate::math::units::TURN_RAD;
    use alloc::string::String;
    use alloc::vec::Vec;

    /// A cam with a nose: the radius at azimuth i of n.
    fn cam(n: usize) -> Vec<f64> {
        (0..n).map(|i| 19.0 + 3.0 * libm::exp(4.0 * (libm::cos(TURN_RAD * i as f64 / n as f64) - 1.0))).collect()
    }

    /// Ticks of twelve positions, listed once per three: the part must be what every position cut by itself, in order, leaves.
    #[test]
    fn a_pass_that_cuts_backwards_leaves_the_part_of_one_that_cuts_at_once() {
        for (azimuths, sense) in [(3600, 1.0), (3600, -1.0), (1801, 1.0), (720, -1.0), (100, 1.0)] {
            let mut at_once = Lobe::new(String::from("L"), 0, 10.0, cam(azimuths)).expect("a cam");
            let mut later = at_once.clone();
            let mut pass = WheelPass::new();
            let (mut area, mut area_later) = (0.0, 0.0);
            for tick in 0..3000_u32 {
                pass.begin();
                for j in 0..12_u32 {
                    let turns = f64::from(12 * tick + j) / 12_000.0;
                    let azimuth_rad = sense * TURN_RAD * turns;
                    let height = 3.0 * libm::exp(4.0 * (libm::cos(azimuth_rad) - 1.0));
                    let wheel = WheelCentre {
                        azimuth_rad,
                        centre_mm: 79.0 + height - 0.02 * turns + 1e-3 * libm::sin(900.0 * turns),
                        radius_mm: 60.0,
                    };
                    if j % 3 == 0 {
                        later.list_blocks(wheel, false, 0.2, &mut pass);
                    }
                    area += at_once.pass(wheel, true).area_mm2;
                    area_later += later.pass_later(wheel, &mut pass).area_mm2;
                }
                area_later += later.finish(&mut pass).area_mm2;
                at_once.refresh();
                later.refresh();
            }
            for (i, (one, other)) in at_once.radii_mm().iter().zip(later.radii_mm()).enumerate() {
                assert!((one - other).abs() < 1e-13, "{azimuths} {sense} {i}: {one} {other}");
            }
            assert!(area > 1.0 && (area - area_later).abs() < 1e-9 * area, "{area} {area_later}");
        }
    }

    /// Random wheels of any size on parts of any size and number of lobes, slow and fast: listed blocks and cuts at the end of a tick leave
    /// what a search at every position and cuts at once leave, and the same deflection to the bit.
    #[test]
    fn any_wheel_leaves_what_a_search_at_every_position_leaves() {
        let mut seed = 0x9e37_79b9_u32;
        let mut random = |from: f64, to: f64| {
            seed ^= seed << 13;
            seed ^= seed >> 17;
            seed ^= seed << 5;
            from + (to - from) * f64::from(seed) / f64::from(u32::MAX)
        };
        let mut cut = 0;
        for round in 0..120 {
            let radius_mm = libm::exp(random(libm::log(2.0), libm::log(1000.0)));
            let base_mm = libm::exp(random(libm::log(2.0), libm::log(80.0)));
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small and positive")]
            let (azimuths, lobes) = (random(16.0, 4000.0) as usize, libm::floor(random(0.0, 12.0)));
            // No farther in than the part is smaller than the distance of the wheel's tangent point.
            let deepest = |lift: f64| 0.9 * (base_mm + radius_mm - libm::hypot(radius_mm, base_mm + 2.0 * lift));
            let lift = base_mm * random(0.0, 0.1) / (1.0 + lobes * lobes);
            let lift = if deepest(lift) > 0.01 * base_mm { lift } else { 0.0 };
            let deepest_mm = deepest(lift).min(0.3 * base_mm);
            let sense = if random(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
            let notch_mm = base_mm * random(0.0, 0.3);
            let raw_mm = |azimuth_rad: f64| base_mm + lift * (1.0 + libm::cos(lobes * azimuth_rad));
            let outline = (0..azimuths).map(|i| {
                let notch_mm = if i < azimuths / 40 { notch_mm } else { 0.0 };
                raw_mm(TURN_RAD * i as f64 / azimuths as f64) - notch_mm
            });
            let mut at_once = Lobe::new(String::from("L"), 0, 10.0, outline.collect()).expect("a part");
            let mut later = at_once.clone();
            let law = (round % 3 > 0).then(|| {
                let n_mm = [libm::exp(random(7.0, 11.0)), libm::exp(random(5.0, 11.0)), random(0.0, 10.0)];
                ContactLaw::new(n_mm[0], n_mm[1], n_mm[2]).expect("a law")
            });
            // Positions up to ten times as far apart as a sweep has them.
            let longest_rad = 10.0 * libm::sqrt(4e-5 * radius_mm) / (radius_mm + base_mm);
            let step_rad = sense * longest_rad * libm::exp(random(libm::log(1e-3), 0.0));
            let infeed_mm = base_mm * libm::exp(random(libm::log(1e-5), libm::log(0.2)));
            let (mut near, mut alone) = (WheelPass::new(), WheelPass::new());
            let (mut deflections, mut area) = ([Deflection::default(); 2], [0.0; 2]);
            let begin_rad = random(-9.0, 9.0);
            for tick in 0..100_u32 {
                near.begin();
                for j in 0..12_u32 {
                    let turned_rad = step_rad * f64::from(12 * tick + j);
                    let fed_mm = (infeed_mm * f64::from(12 * tick + j) / 1200.0).min(deepest_mm);
                    let azimuth_rad = begin_rad + turned_rad;
                    let centre_mm = radius_mm + raw_mm(azimuth_rad) + 1e-3 - fed_mm + 1e-4 * random(-1.0, 1.0);
                    let wheel = WheelCentre { azimuth_rad, centre_mm, radius_mm };
                    if j % 3 == 0 {
                        let margin_mm = (3.0 * step_rad * centre_mm).abs() + 1e-3 * base_mm;
                        later.list_blocks(wheel, law.is_some(), margin_mm, &mut near);
                    }
                    let Some(law) = &law else {
                        area[0] += at_once.pass(wheel, true).area_mm2;
                        area[1] += later.pass_later(wheel, &mut near).area_mm2;
                        continue;
                    };
                    alone.begin();
                    let cuts = (j % 7 > 0, 1e-4);
                    let (removal, deflection) = at_once.press(wheel, law, deflections[0], cuts, &mut alone);
                    area[0] += removal.and(at_once.finish(&mut alone)).area_mm2;
                    deflections[0] = deflection;
                    let (removal, deflection) = later.press(wheel, law, deflections[1], cuts, &mut near);
                    area[1] += removal.area_mm2;
                    deflections[1] = deflection;
                    assert_eq!(deflections[0], deflections[1], "{round} {tick} {j}");
                }
                area[1] += later.finish(&mut near).area_mm2;
                at_once.refresh();
                later.refresh();
            }
            for (i, (one, other)) in at_once.radii_mm().iter().zip(later.radii_mm()).enumerate() {
                assert!((one - other).abs() < 1e-11 * (radius_mm + base_mm), "{round} {i}: {one} {other}");
            }
            assert!((area[0] - area[1]).abs() < 1e-8 * (1e-3 + area[0]), "{round}: {area:?}");
            cut += u32::from(area[0] > 0.0);
        }
        assert!(cut > 80, "{cut}");
    }
}
