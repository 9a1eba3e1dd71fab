// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parts between the centres or in the chuck, and their position relative to the wheel.

use super::probes::Keyway;
use super::turning::{Clamped, snapshot_clamped};
use crate::cam::contour::LobeCentre;
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::MachineDescription;
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::simulation::axis::AxisState;
use crate::simulation::turned_part::{TurnedPart, TurnedPartError};
use crate::simulation::workpiece::{CutRecord, Lobe, LobeError, MAX_AT_STATION, MAX_FACED, WheelCentre, Workpiece};
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Clearance that a tool near the part lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PartClearance {
    /// Position of X at which the tool is off the part (mm).
    pub(super) off_mm: f64,
    /// Position of X at which the tool would touch the part nearest to its axis (mm), at most where X is.
    pub(super) nearest_mm: f64,
}

/// A section of the part in front of the wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacedSection {
    /// Index of the lobe.
    pub(super) lobe: usize,
    /// Law of the width that it has in common with the wheel; `None` where nothing deflects.
    pub(super) law: Option<ContactLaw>,
    /// Compliance of the part on its supports (mm/N).
    pub(super) part_mm_n: f64,
    /// Radius of the wheel's rim in front of its middle less that in the middle of the wheel (mm).
    pub(super) rim_mm: f64,
}

impl FacedSection {
    /// The wheel as this section meets it, from the wheel by the middle of its rim.
    pub(super) fn wheel(&self, wheel: WheelCentre) -> WheelCentre {
        WheelCentre { radius_mm: wheel.radius_mm + self.rim_mm, ..wheel }
    }
}

/// Sections of a lobe that the wheel grinds together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacedSections {
    /// The section nearest to the middle of the wheel.
    pub(super) main: FacedSection,
    beside: [Option<FacedSection>; MAX_FACED - 1],
}

impl FacedSections {
    pub(super) fn beside(&self) -> impl Iterator<Item = FacedSection> + use<> {
        self.beside.into_iter().flatten()
    }

    pub(super) fn is_alone(&self) -> bool {
        self.beside[0].is_none()
    }
}

/// Overlap of two sections that are flush, for rounding (mm).
const FLUSH_MM: f64 = 1e-3;

/// The clamped part.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Workholding {
    part: Workpiece,
    /// The part in the chuck of a lathe.
    turned: Option<Clamped>,
    /// Azimuth of the part's keyway as it is clamped (rad): 0 faces the wheel where C is 0.
    key_way_rad: f64,
}

impl Workholding {
    pub(super) fn snapshot_parts(
        &mut self,
        description: &MachineDescription,
        codec: &mut SnapshotCodec<'_>,
    ) -> Result<(), SnapshotError> {
        // The keyway follows in a group of its own.
        let Self { part, turned, key_way_rad: _ } = self;
        codec.field("part", |codec| {
            let new = || (CutRecord::from_description(description), description.workholding.map(|_| 0.0));
            part.snapshot(codec, description.stations.len(), new)
        })?;
        codec.field("turned", |codec| snapshot_clamped(turned, description.insert.is_some(), codec))
    }

    pub(super) fn snapshot_keyway(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        codec.field("key_way_rad", |codec| self.key_way_rad.snapshot(codec))
    }

    pub(super) fn part(&self) -> &Workpiece {
        &self.part
    }

    pub(super) fn lobes(&self) -> &[Lobe] {
        self.part.lobes()
    }

    pub(super) fn lobe_mut(&mut self, index: usize) -> &mut Lobe {
        self.part.lobe_mut(index)
    }

    pub(super) fn part_mut(&mut self) -> &mut Workpiece {
        &mut self.part
    }

    /// Another wheel with this surface speed (m/s) grinds the part from now on.
    pub(super) fn change_wheel(&mut self, wheel_speed_m_s: f64) {
        self.part.change_wheel(wheel_speed_m_s);
    }

    pub(super) fn turned(&self) -> Option<&Clamped> {
        self.turned.as_ref()
    }

    pub(super) fn turned_mut(&mut self) -> Option<&mut Clamped> {
        self.turned.as_mut()
    }

    /// A part is in the machine.
    pub(super) fn has_part(&self) -> bool {
        !self.part.is_empty() || self.turned.is_some()
    }

    pub(super) fn key_way_rad(&self) -> f64 {
        self.key_way_rad
    }

    pub(super) fn set_keyway(&mut self, key_way_rad: f64) {
        self.key_way_rad = if key_way_rad.is_finite() { key_way_rad } else { 0.0 };
    }

    /// The keyway of the part under its switch; `None` without a switch or a part.
    pub(super) fn keyway(&self, headstock: &AxisState, description: &MachineDescription) -> Option<Keyway> {
        let probe = description.key_way_probe.filter(|_| self.has_part())?;
        Some(Keyway::new(&probe, self.key_way_rad, description.rotation_sense, headstock.counts_per_unit))
    }

    pub(super) fn clear(&mut self) {
        self.part.clear();
        self.turned = None;
        self.key_way_rad = 0.0;
    }

    pub(super) fn load_turned_part(
        &mut self,
        part: TurnedPart,
        zero_mm: f64,
        description: &MachineDescription,
    ) -> Result<(), TurnedPartError> {
        let name = || part.name().into();
        if description.insert.is_none() {
            return Err(TurnedPartError::NotALathe { name: name() });
        }
        if !zero_mm.is_finite() {
            return Err(TurnedPartError::Zero { name: name(), part_zero_mm: zero_mm });
        }
        self.turned = Some(Clamped { part, zero_mm });
        Ok(())
    }

    pub(super) fn load_section(
        &mut self,
        name: &str,
        station: &str,
        (offset_mm, width_mm, radii): (f64, f64, Vec<f64>),
        centre: Option<LobeCentre>,
        description: &MachineDescription,
    ) -> Result<(), LobeError> {
        let index = description
            .stations
            .iter()
            .position(|s| s.switch == station)
            .ok_or_else(|| LobeError::UnknownStation { name: name.to_string(), station: station.to_string() })?;
        let lobe = Lobe::new(String::from(name), index, width_mm, radii)?.about(centre)?;
        let mut lobe = lobe.beside_station(offset_mm)?;
        let others = || self.lobes().iter().filter(|other| other.station() == index && other.name() != name);
        if let Some(other) = others().find(|other| !lobe.is_section_with(other) || overlap_mm(&lobe, other) > FLUSH_MM)
        {
            return Err(LobeError::StationTaken {
                name: name.to_string(),
                station: station.to_string(),
                other: other.name().to_string(),
            });
        }
        let mut middles_mm: Vec<f64> = others().map(Lobe::offset_mm).chain([offset_mm]).collect();
        middles_mm.sort_unstable_by(f64::total_cmp);
        let wheel_mm = description.wheel.width_mm;
        let is_crowded = middles_mm.windows(MAX_FACED + 1).any(|few| few[MAX_FACED] - few[0] < wheel_mm);
        if is_crowded || middles_mm.len() > MAX_AT_STATION {
            let (name, station) = (name.to_string(), station.to_string());
            return Err(LobeError::TooManySections { name, station, max: MAX_FACED });
        }
        if let Some(record) = CutRecord::from_description(description) {
            lobe.record(record);
        }
        lobe.hold(description.workholding.map(|_| 0.0));
        self.part.load(lobe);
        Ok(())
    }

    /// Gives a lobe the compliance of the part on its supports (mm/N).
    pub(super) fn set_part_compliance(&mut self, name: &str, part_mm_n: f64) -> Result<(), LobeError> {
        let lobe = self.part.lobe_by_name_mut(name);
        let Some(lobe) = lobe.filter(|lobe| part_mm_n == 0.0 || lobe.is_on_supports()) else {
            return Err(LobeError::PartCompliance { name: name.to_string(), part_mm_n });
        };
        if lobe.is_on_supports() {
            lobe.hold(Some(part_mm_n));
        }
        Ok(())
    }

    /// Index of the lobe in front of the wheel with the table at `z_mm`: the one whose width overlaps the wheel's, the nearest if
    /// several do. A lobe is centred on the wheel when the table stands at its station's position.
    pub(super) fn lobe_in_front(&self, z_mm: f64, description: &MachineDescription) -> Option<usize> {
        let distance = |lobe: &Lobe| beside_mm(lobe, z_mm, description);
        self.lobes()
            .iter()
            .enumerate()
            .filter(|(_, lobe)| distance(lobe) < 0.5 * (lobe.width_mm() + description.wheel.width_mm))
            .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)))
            .map(|(index, _)| index)
    }

    /// The lobe in front of the wheel with the other sections of it whose middles the wheel faces.
    pub(super) fn faced(&self, z_mm: f64, description: &MachineDescription) -> Option<FacedSections> {
        let main = self.lobe_in_front(z_mm, description)?;
        let section = |lobe: usize| FacedSection {
            lobe,
            law: self.contact_law(lobe, z_mm, description),
            part_mm_n: self.lobes()[lobe].part_mm_n(),
            rim_mm: description.wheel.rim_mm(from_wheel_mm(&self.lobes()[lobe], z_mm, description)),
        };
        let is_beside = |(index, lobe): &(usize, &Lobe)| {
            *index != main
                && lobe.is_section_with(&self.lobes()[main])
                && beside_mm(lobe, z_mm, description) < 0.5 * description.wheel.width_mm
        };
        let mut faced = FacedSections { main: section(main), beside: [None; MAX_FACED - 1] };
        let beside = self.lobes().iter().enumerate().filter(is_beside);
        for (place, (index, _)) in faced.beside.iter_mut().zip(beside) {
            *place = Some(section(index));
        }
        Some(faced)
    }

    /// Deflection law of wheel and lobe over the width that both have in common; `None` where nothing deflects.
    pub(super) fn contact_law(&self, lobe: usize, z_mm: f64, description: &MachineDescription) -> Option<ContactLaw> {
        let contact = description.contact.as_ref()?;
        let lobe = &self.lobes()[lobe];
        let (lobe_mm, wheel_mm) = (lobe.width_mm(), description.wheel.width_mm);
        let common_mm = (0.5 * (lobe_mm + wheel_mm) - beside_mm(lobe, z_mm, description)).min(lobe_mm).min(wheel_mm);
        Some(contact.law(z_mm, common_mm)?.in_series(lobe.part_mm_n()))
    }

    /// Clearance that the wheel, or the insert's centre, lacks with X and Z at these positions; `None` where it is off the part or
    /// nothing is in front of it.
    pub(super) fn too_near(&self, x_mm: f64, z_mm: f64, description: &MachineDescription) -> Option<PartClearance> {
        let (reach_mm, nearest_mm) = if description.is_lathe() {
            self.turned()?.insert_positions_mm(&description.insert?, z_mm)?
        } else {
            let bounds = |section: FacedSection| {
                let lobe = &self.lobes()[section.lobe];
                let (reach_mm, throw_mm) = (lobe.reach_mm(), lobe.throw_mm());
                let nearest_mm = lobe.radii_mm().iter().fold(reach_mm, |min, radius| min.min(*radius));
                (reach_mm + throw_mm + section.rim_mm, nearest_mm - throw_mm + section.rim_mm)
            };
            let wider = |(reach_mm, nearest_mm): (f64, f64), other: (f64, f64)| {
                (f64::max(reach_mm, other.0), f64::min(nearest_mm, other.1))
            };
            let faced = self.faced(z_mm, description)?;
            faced.beside().map(bounds).fold(bounds(faced.main), wider)
        };
        let off_mm = reach_mm + description.retract.clearance_mm;
        (x_mm < off_mm).then_some(PartClearance { off_mm, nearest_mm: nearest_mm.min(x_mm) })
    }
}

/// Distance of the middle of a lobe from the wheel's (mm).
fn beside_mm(lobe: &Lobe, z_mm: f64, description: &MachineDescription) -> f64 {
    from_wheel_mm(lobe, z_mm, description).abs()
}

/// Middle of a lobe from that of the wheel along Z, positive towards the tailstock (mm).
fn from_wheel_mm(lobe: &Lobe, z_mm: f64, description: &MachineDescription) -> f64 {
    description.stations[lobe.station()].position_mm + lobe.offset_mm() - z_mm
}

/// Common length of two sections along Z (mm); below 0 their distance.
fn overlap_mm(one: &Lobe, other: &Lobe) -> f64 {
    0.5 * (one.width_mm() + other.width_mm()) - (one.offset_mm() - other.offset_mm()).abs()
}
