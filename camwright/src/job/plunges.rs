// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes wider than the wheel: plunges side by side, and the sections that they leave.
//!
//! A lobe of width W is ground by n plunges of a wheel of width B. Neighbours overlap by at least o:
//!
//! ```text
//! n = 1 + ⌈(W − B)/(B − o)⌉        z_k = (k − (n + 1)/2) s        s = (W − B)/(n − 1)        k = 1 … n
//! ```
//! `z_k` is the middle of the wheel, from the middle of the lobe. The first and the last plunge are flush with the ends of the lobe, and every
//! two neighbours overlap by B − s ≥ o. The edges of all plunges divide the lobe into sections; the same plunges cut all of a section, and the
//! last of them finishes it.

use super::axial_shape;
use super::error::JobError;
use super::grinding::LobeSpec;
use super::key::{JobKey, Subject};
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::MachineDescription;
use alloc::string::String;
use alloc::vec::Vec;

/// Largest number of plunges of a lobe; more are likelier a mistyped width.
pub const MAX_PLUNGES: u32 = 12;

/// Largest number of sections of a part with a wide lobe: a machine reports so many outlines at once.
pub const MAX_SECTIONS: usize = 32;

/// Largest overlap as a share of the wheel's width. A plunge then meets two others on either side, and the wheel at most five sections.
pub const MAX_OVERLAP_SHARE: f64 = 1.0 / 3.0;

/// Width below which a section is rounding (mm).
const MIN_SECTION_MM: f64 = 1e-3;

/// Rounding of a quotient of widths.
const ROUNDING: f64 = 1e-9;

/// One of the plunges that grind a lobe wider than the wheel.
#[derive(Debug, Clone, PartialEq)]
pub struct Plunge {
    /// Name of the lobe.
    pub lobe: String,
    /// Number of the plunge, from 1 at the headstock.
    pub number: u32,
    /// Number of all plunges of the lobe.
    pub count: u32,
    /// Width of the lobe (mm).
    pub lobe_width_mm: f64,
}

/// A length of a lobe along Z that has one outline.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeSection {
    /// Name of the section: that of the lobe or plunge, or of the lobe and the first and last plunge that cut it.
    pub name: String,
    /// Middle of the section from the position of the station (mm).
    pub offset_mm: f64,
    /// Its width (mm).
    pub width_mm: f64,
    /// Distance of its design outside the contour, in its middle (mm); 0 but for a lobe with taper or crown.
    pub above_mm: f64,
}

/// A section with the plunges that cut it.
struct CutSection {
    first: u32,
    last: u32,
    from_mm: f64,
    to_mm: f64,
}

impl CutSection {
    fn width_mm(&self) -> f64 {
        self.to_mm - self.from_mm
    }
}

impl Plunge {
    /// Distance of two neighbouring plunges (mm) with a wheel of this width (mm).
    #[must_use]
    pub fn spacing_mm(&self, wheel_mm: f64) -> f64 {
        (self.lobe_width_mm - wheel_mm) / f64::from(self.count - 1)
    }

    /// Overlap of two neighbouring plunges (mm).
    #[must_use]
    pub fn overlap_mm(&self, wheel_mm: f64) -> f64 {
        wheel_mm - self.spacing_mm(wheel_mm)
    }

    /// Width of the lobe that this plunge is the first to cut (mm).
    #[must_use]
    pub fn fresh_width_mm(&self, wheel_mm: f64) -> f64 {
        if self.number == 1 { wheel_mm } else { self.spacing_mm(wheel_mm) }
    }

    /// Middle of the wheel from the middle of the lobe along Z (mm).
    #[must_use]
    pub fn offset_mm(&self, wheel_mm: f64) -> f64 {
        offset_mm(self.number, self.count, self.spacing_mm(wheel_mm))
    }

    /// Sections that this plunge finishes, the plunge's own first: what no other plunge cuts, else the widest. It has the plunge's name.
    #[must_use]
    pub fn finished_sections(&self, wheel_mm: f64) -> Vec<LobeSection> {
        let spacing_mm = self.spacing_mm(wheel_mm);
        let from_mm = |number: u32| offset_mm(number, self.count, spacing_mm) - 0.5 * wheel_mm;
        let to_mm = |number: u32| offset_mm(number, self.count, spacing_mm) + 0.5 * wheel_mm;
        let own_to_mm = if self.number < self.count { from_mm(self.number + 1) } else { to_mm(self.number) };
        // Plunges before it end one after the other within what it finishes.
        let mut sections = Vec::new();
        let mut begin_mm = from_mm(self.number);
        for first in 1..=self.number {
            let end_mm = to_mm(first).min(own_to_mm);
            if end_mm - begin_mm > MIN_SECTION_MM {
                sections.push(CutSection { first, last: self.number, from_mm: begin_mm, to_mm: end_mm });
                begin_mm = end_mm;
            }
        }
        let is_own = |section: &CutSection| section.first == section.last;
        sections.sort_by(|a, b| is_own(b).cmp(&is_own(a)).then(b.width_mm().total_cmp(&a.width_mm())));
        let named = sections.iter().enumerate().map(|(index, section)| LobeSection {
            name: match index {
                0 => plunge_name(&self.lobe, self.number),
                _ => alloc::format!("{}-{}-{}", self.lobe, section.first, section.last),
            },
            offset_mm: 0.5 * (section.from_mm + section.to_mm),
            width_mm: section.width_mm(),
            above_mm: 0.0,
        });
        named.collect()
    }
}

fn offset_mm(number: u32, count: u32, spacing_mm: f64) -> f64 {
    (f64::from(number) - 0.5 * f64::from(count + 1)) * spacing_mm
}

/// Middle of the wheel from the position of the station when it grinds a lobe, or a plunge of one (mm).
pub(crate) fn offset_of(lobe: &LobeSpec) -> f64 {
    lobe.plunge.as_ref().map_or(0.0, |plunge| plunge.offset_mm(lobe.width_mm))
}

/// Contact law of the wheel and a lobe, or one of its plunges, where it is ground: of a plunge over the width that no plunge has cut before;
/// with a wheel of this width (mm) and a part of this compliance on its supports (mm/N).
/// `None` on a rigid machine.
pub(crate) fn contact_law(
    machine: &MachineDescription,
    wheel_mm: f64,
    station: &str,
    width_mm: f64,
    plunge: Option<&Plunge>,
    part_mm_n: f64,
) -> Option<ContactLaw> {
    let beside = |plunge: &Plunge| (plunge.offset_mm(width_mm), plunge.fresh_width_mm(width_mm));
    let (offset_mm, fresh_mm) = plunge.map_or((0.0, width_mm), beside);
    let z_mm = machine.station(station)?.position_mm + offset_mm;
    let law = machine.contact.as_ref()?.law(z_mm, fresh_mm.min(wheel_mm))?;
    Some(law.in_series(part_mm_n))
}

/// Both are plunges of one lobe.
pub(crate) fn are_beside(one: Option<&Plunge>, other: Option<&Plunge>) -> bool {
    matches!((one, other), (Some(one), Some(other)) if one.lobe == other.lobe)
}

fn plunge_name(lobe: &str, number: u32) -> String {
    alloc::format!("{lobe}-{number}")
}

impl LobeSpec {
    /// Middle of the wheel from the position of the station when it grinds this (mm).
    #[must_use]
    pub fn offset_mm(&self) -> f64 {
        self.plunge.as_ref().map_or(0.0, |plunge| plunge.offset_mm(self.width_mm))
    }

    /// Number of sections that are finished with this.
    #[must_use]
    pub fn section_count(&self) -> usize {
        match &self.plunge {
            Some(plunge) => plunge.finished_sections(self.width_mm).len(),
            None => axial_shape::section_count(self.axial),
        }
    }

    /// Both are plunges of one lobe, or visits of wheels to one.
    #[must_use]
    pub fn is_of_one_lobe(&self, other: &Self) -> bool {
        are_beside(self.plunge.as_ref(), other.plunge.as_ref()) || self.visits_with(other)
    }

    /// The plunges of a lobe with a wheel of width `wheel_mm` that overlap by at least `overlap_mm` (mm), from the headstock on; the lobe
    /// itself where the wheel covers it.
    ///
    /// # Errors
    /// An overlap that is not above 0 or more than a third of the wheel, more than [`MAX_PLUNGES`] plunges.
    pub fn side_by_side(self, overlap_mm: f64, wheel_mm: f64) -> Result<Vec<Self>, JobError> {
        let max_mm = MAX_OVERLAP_SHARE * wheel_mm;
        if !(overlap_mm > 0.0 && overlap_mm <= max_mm * (1.0 + ROUNDING)) {
            return Err(JobError::PlungeOverlap { lobe: self.name, overlap_mm, max_mm, wheel_mm });
        }
        if self.width_mm <= wheel_mm {
            return Ok(alloc::vec![self]);
        }
        let more = libm::ceil((self.width_mm - wheel_mm) / (wheel_mm - overlap_mm) - ROUNDING).max(1.0);
        if more.is_nan() || more >= f64::from(MAX_PLUNGES) {
            let (place, value) = (Subject::Lobe(self.name), self.width_mm);
            let wanted = "a width that at most 12 plunges cover";
            return Err(JobError::OutOfRange { place, key: JobKey::Width, value, wanted });
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 11")]
        let count = 1 + more as u32;
        let plunge = |number: u32| Self {
            name: plunge_name(&self.name, number),
            width_mm: wheel_mm,
            plunge: Some(Plunge { lobe: self.name.clone(), number, count, lobe_width_mm: self.width_mm }),
            ..self.clone()
        };
        Ok((1..=count).map(plunge).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cam::form_tolerance::FormTolerance;
    use alloc::string::ToString;

    const WHEEL_MM: f64 = 25.0;

    fn wide(width_mm: f64) -> LobeSpec {
        LobeSpec {
            name: "W".into(),
            station: "LS1".into(),
            phase_rad: 0.0,
            profile: 0,
            width_mm,
            tolerance: FormTolerance::uniform(0.005),
            plunge: None,
            visit: None,
            axial: None,
        }
    }

    /// Plunges that cover a place (mm from the middle of the lobe), by the definition alone.
    fn covering(plunges: &[LobeSpec], at_mm: f64) -> Vec<u32> {
        let covers = |plunge: &&LobeSpec| (plunge.offset_mm() - at_mm).abs() < 0.5 * WHEEL_MM;
        plunges.iter().filter(covers).map(|plunge| plunge.plunge.as_ref().expect("a plunge").number).collect()
    }

    /// For widths and overlaps of all kinds: the plunges are flush with the lobe, overlap by at least what is stated, one fewer would not;
    /// the sections cover the lobe once, and the plunge that finishes one is the last that covers it.
    #[test]
    fn plunges_and_sections_cover_the_lobe() {
        for step in 1..=400_u32 {
            let width_mm = WHEEL_MM + 0.43 * f64::from(step);
            let overlap_mm = 0.1 + f64::from(step * 7 % 80) * 0.1;
            let plunges = wide(width_mm).side_by_side(overlap_mm, WHEEL_MM).expect("plunges");
            let count = u32::try_from(plunges.len()).expect("few");
            let (first, last) = (&plunges[0], &plunges[plunges.len() - 1]);
            assert!((first.offset_mm() - 0.5 * WHEEL_MM + 0.5 * width_mm).abs() < 1e-12 * width_mm);
            assert!((last.offset_mm() + 0.5 * WHEEL_MM - 0.5 * width_mm).abs() < 1e-12 * width_mm);
            for pair in plunges.windows(2) {
                let overlap = WHEEL_MM - (pair[1].offset_mm() - pair[0].offset_mm());
                assert!(overlap > overlap_mm - 1e-9 && overlap < WHEEL_MM, "{width_mm} mm: {overlap} mm");
            }
            if count > 2 {
                let fewer_mm = WHEEL_MM - (width_mm - WHEEL_MM) / f64::from(count - 2);
                assert!(fewer_mm < overlap_mm, "{width_mm} mm: {} plunges overlap by {fewer_mm} mm", count - 1);
            }
            let mut sections = Vec::new();
            for spec in &plunges {
                let plunge = spec.plunge.as_ref().expect("a plunge");
                let finished = plunge.finished_sections(WHEEL_MM);
                assert_eq!(finished[0].name, spec.name, "{width_mm} mm");
                for section in finished {
                    for share in [-0.499, 0.0, 0.499] {
                        let by = covering(&plunges, section.offset_mm + share * section.width_mm);
                        assert_eq!(by.last(), Some(&plunge.number), "{width_mm} mm, {section:?}");
                        assert!(by.len() <= 3, "{width_mm} mm, {overlap_mm} mm: {by:?}");
                        if section.name != spec.name {
                            assert_eq!(section.name, alloc::format!("W-{}-{}", by[0], plunge.number));
                        }
                    }
                    sections.push(section);
                }
            }
            let total_mm: f64 = sections.iter().map(|section| section.width_mm).sum();
            assert!((total_mm - width_mm).abs() < 1e-2 && total_mm < width_mm + 1e-9, "{width_mm} mm: {total_mm} mm");
            let names: alloc::collections::BTreeSet<&str> =
                sections.iter().map(|section| section.name.as_str()).collect();
            assert_eq!(names.len(), sections.len(), "{names:?}");
        }
    }

    #[test]
    fn the_wheel_covers_a_narrow_lobe() {
        assert_eq!(wide(25.0).side_by_side(2.0, WHEEL_MM), Ok(alloc::vec![wide(25.0)]));
    }

    /// 60 mm by a wheel of 25 mm that overlaps by 3 mm: 35/22 is more than one spacing, so 3 plunges 17.5 mm apart.
    #[test]
    fn sixty_millimetres_take_three_plunges() {
        let plunges = wide(60.0).side_by_side(3.0, WHEEL_MM).expect("plunges");
        let offsets: Vec<f64> = plunges.iter().map(LobeSpec::offset_mm).collect();
        assert_eq!(offsets, [-17.5, 0.0, 17.5]);
        let sections = plunges[1].plunge.as_ref().expect("a plunge").finished_sections(WHEEL_MM);
        let section = |name: &str, offset_mm: f64, width_mm: f64| LobeSection {
            name: name.into(),
            offset_mm,
            width_mm,
            above_mm: 0.0,
        };
        assert_eq!(sections, [section("W-2", 0.0, 10.0), section("W-1-2", -8.75, 7.5)]);
    }

    #[test]
    fn impossible_overlaps_and_widths_are_refused() {
        for overlap_mm in [0.0, -1.0, f64::NAN, 8.4] {
            let error = wide(60.0).side_by_side(overlap_mm, WHEEL_MM).expect_err("no overlap");
            assert!(matches!(&error, JobError::PlungeOverlap { lobe, .. } if lobe == "W"), "{error}");
        }
        let error = wide(9000.0).side_by_side(3.0, WHEEL_MM).expect_err("too many").to_string();
        assert_eq!(error, "lobe W: width_mm is 9000; it must be a width that at most 12 plunges cover");
    }
}
