// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The part while it is cut, for those who watch: fewer radii than it has, copied in the cyclic thread into room that was made before.

use camwright::cam::contour::LobeCentre;
use camwright::simulation::Machine;
use camwright_files::convert::m_from_mm;

/// Radii of a lobe: half a degree.
const LOBE_AZIMUTHS: usize = 720;
/// Azimuths of a turned part, and positions along it.
const TURNED_AZIMUTHS: usize = 90;
const TURNED_COLUMNS: usize = 13;

/// A coarse copy of a lobe or of a turned part.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct PartOutline {
    /// Which lobe; a lathe has one part.
    pub lobe: usize,
    /// When it was taken.
    pub tick: u64,
    /// Index of its station, and its width (mm); of a lobe.
    pub station: usize,
    pub width_mm: f64,
    /// Middle of the lobe from the position of its station along Z.
    pub offset_mm: f64,
    pub key_way_rad: f64,
    /// Centre of the radii, of a crank pin.
    pub centre: Option<LobeCentre>,
    /// Places of the columns in the part's frame (mm): one of a lobe, none where there is no part.
    pub places_mm: Vec<f64>,
    /// All radii of the first column first (mm).
    pub radii_mm: Vec<f64>,
}

impl PartOutline {
    /// Room for a lobe, or for the part of a lathe.
    pub fn for_lobe(lobe: usize, is_lathe: bool) -> Box<Self> {
        let (columns, radii) = match is_lathe {
            true => (TURNED_COLUMNS, TURNED_COLUMNS * TURNED_AZIMUTHS),
            false => (1, LOBE_AZIMUTHS),
        };
        let (places_mm, radii_mm) = (Vec::with_capacity(columns), Vec::with_capacity(radii));
        Box::new(Self { lobe, places_mm, radii_mm, ..Self::default() })
    }

    /// Copies the part as it stands, into the room there is.
    pub fn update(&mut self, machine: &Machine) {
        self.tick = machine.tick();
        self.key_way_rad = machine.key_way_rad();
        (self.centre, self.offset_mm) = (None, 0.0);
        self.places_mm.clear();
        self.radii_mm.clear();
        if let Some(part) = machine.turned_part() {
            let grid = part.grid();
            let columns = TURNED_COLUMNS.min(grid.columns).min(self.places_mm.capacity());
            for column in (0..columns).map(|i| i * (grid.columns - 1) / (columns - 1).max(1)) {
                self.places_mm.push(grid.z_mm(column) - machine.part_zero_mm());
                self.copy(part.column_mm(column), TURNED_AZIMUTHS);
            }
        } else if let Some(lobe) = machine.part().lobes().get(self.lobe) {
            let station = machine.description().stations.get(lobe.station());
            self.places_mm.push(station.map_or(0.0, |station| station.position_mm) + lobe.offset_mm());
            self.offset_mm = lobe.offset_mm();
            self.station = lobe.station();
            self.width_mm = lobe.width_mm();
            self.centre = lobe.centre();
            self.copy(lobe.radii_mm().iter().copied(), LOBE_AZIMUTHS);
        }
    }

    /// Copies at most `max` radii at equal steps of a turn, or all of them if there are fewer.
    fn copy(&mut self, radii_mm: impl ExactSizeIterator<Item = f64>, max: usize) {
        let (room, all) = (self.radii_mm.capacity() - self.radii_mm.len(), radii_mm.len());
        let count = all.min(max).min(room);
        let mut taken = 0;
        let even = radii_mm.enumerate().filter(|(index, _)| {
            let is_next = taken < count && *index == taken * all / count;
            taken += usize::from(is_next);
            is_next
        });
        self.radii_mm.extend(even.map(|(_, radius_mm)| radius_mm));
    }

    /// Its sections in the part's frame (m): place and radii.
    pub fn sections(&self) -> Vec<(f64, Vec<f64>)> {
        let Some(count) = self.radii_mm.len().checked_div(self.places_mm.len()).filter(|count| *count > 0) else {
            return Vec::new();
        };
        let radii = self.radii_mm.chunks(count).map(|radii| radii.iter().map(|mm| m_from_mm(*mm)).collect());
        self.places_mm.iter().map(|mm| m_from_mm(*mm)).zip(radii).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_into_the_room_stays_out() {
        let mut outline = PartOutline::for_lobe(3, false);
        assert!(outline.sections().is_empty(), "nothing was taken yet");
        let radii: Vec<f64> = (0..3600).map(f64::from).collect();
        outline.places_mm.push(80.0);
        outline.copy(radii.iter().copied(), LOBE_AZIMUTHS);
        outline.copy(radii.iter().copied(), LOBE_AZIMUTHS);
        assert_eq!(outline.radii_mm.len(), LOBE_AZIMUTHS);
        let sections = outline.sections();
        assert_eq!((sections[0].0, sections[0].1[1], sections.len()), (m_from_mm(80.0), m_from_mm(5.0), 1));
        let mut few = PartOutline::for_lobe(0, false);
        few.places_mm.push(0.0);
        few.copy(radii[..16].iter().copied(), LOBE_AZIMUTHS);
        assert_eq!(few.radii_mm, radii[..16], "an outline with fewer radii is taken whole");
    }
}
