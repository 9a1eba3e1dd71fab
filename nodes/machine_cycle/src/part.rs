// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The part on its way to the cyclic thread and back.

use camwright::cam::contour::LobeCentre;
use camwright::simulation::Machine;
use camwright::simulation::turned_part::{MAX_CELLS, PartGrid, TurnedPart, TurnedPartError};
use camwright::simulation::work_area::LoadingRefused;
use camwright::simulation::workpiece::{CutRecord, LobeError};
use camwright_files::convert::pages::{RADII_PER_PAGE, split};
use camwright_files::convert::{centre_from_values, compliance_from_values, m_from_mm, mm_from_m, offset_from_values};
use camwright_msgs::camwright_msgs::msg::TurnedPage;
use camwright_msgs::camwright_msgs::srv::{LoadBarRequest, LoadLobeRequest};
use camwright_msgs::std_msgs::msg::Header;
use thiserror::Error;

/// A lobe of a raw part, on its way to the machine.
#[derive(Debug)]
pub struct RawLobe {
    pub clear: bool,
    pub name: String,
    pub station: String,
    pub width_mm: f64,
    /// Middle of its width from the position of the station along Z.
    pub offset_mm: f64,
    /// Angle of the part's keyway, the same for every lobe.
    pub key_way_rad: f64,
    pub radii_mm: Vec<f64>,
    /// Centre of the radii, of a crank pin.
    pub centre: Option<LobeCentre>,
    /// Radial compliance of the part on its supports there (mm/N).
    pub part_mm_n: f64,
    /// Request of the lobe.
    pub request: LoadLobeRequest,
}

/// A bar on its way to a lathe.
#[derive(Debug)]
pub struct RawBar {
    pub name: String,
    pub part_zero_mm: f64,
    /// Gone once the machine has it.
    pub part: Option<TurnedPart>,
    /// Request of the bar.
    pub request: LoadBarRequest,
}

/// The part as it stands, copied into room that the pump made.
#[derive(Debug, Default)]
pub struct PartSnapshot {
    pub tick: u64,
    pub finished: bool,
    pub key_way_rad: f64,
    pub lobes: Vec<SnapshotLobe>,
    /// The part of a lathe.
    pub turned: Option<SnapshotTurned>,
}

/// One lobe of a snapshot.
#[derive(Debug, Default, Clone)]
pub struct SnapshotLobe {
    pub name: String,
    pub station: String,
    pub width_mm: f64,
    /// Middle of its width from the position of the station along Z.
    pub offset_mm: f64,
    pub radii_mm: Vec<f64>,
    pub centre: Option<LobeCentre>,
    /// Process values at every degree; `None` if they are unknown.
    pub cut: Option<CutRecord>,
}

/// The turned part of a snapshot.
#[derive(Debug, Clone)]
pub struct SnapshotTurned {
    pub name: String,
    pub grid: PartGrid,
    pub part_zero_mm: f64,
    /// All azimuths of the first column first.
    pub radii_mm: Vec<f64>,
}

/// Why a lobe was not put in.
#[derive(Debug, Clone, PartialEq)]
pub enum LobeRefused {
    Moving,
    NotHeld(LoadingRefused),
    Part(LobeError),
}

/// Why a bar was not put in.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BarRefused {
    #[error("the machine is not at rest")]
    Moving,
    #[error(transparent)]
    NotHeld(LoadingRefused),
    #[error("the machine has it already")]
    Gone,
    #[error(transparent)]
    Part(TurnedPartError),
}

impl RawLobe {
    pub fn new(request: LoadLobeRequest) -> Self {
        let lobe = &request.lobe;
        Self {
            clear: request.clear,
            name: lobe.name.clone(),
            station: lobe.station.clone(),
            width_mm: mm_from_m(lobe.width),
            offset_mm: offset_from_values(&lobe.centre),
            key_way_rad: lobe.key_way,
            radii_mm: lobe.radius.iter().map(|radius| mm_from_m(*radius)).collect(),
            centre: centre_from_values(&lobe.centre),
            part_mm_n: compliance_from_values(&lobe.centre),
            request,
        }
    }

    /// Puts it on the part in a machine at rest, with or in the place of what is there.
    pub fn put_in(&mut self, machine: &mut Machine) -> Result<(), LobeRefused> {
        machine.check_part_compliance(&self.name, self.part_mm_n).map_err(LobeRefused::Part)?;
        if self.clear {
            machine.clear_part();
        }
        let radii = std::mem::take(&mut self.radii_mm);
        machine.set_keyway(self.key_way_rad);
        let outline = (self.offset_mm, self.width_mm, radii);
        machine.load_section(&self.name, &self.station, outline, self.centre).map_err(LobeRefused::Part)?;
        machine.set_part_compliance(&self.name, self.part_mm_n).map_err(LobeRefused::Part)
    }
}

impl RawBar {
    /// The bar that is asked for. It is made here, not in the cyclic thread.
    pub fn new(request: LoadBarRequest) -> Result<Self, String> {
        let size = |count: u32| usize::try_from(count).unwrap_or(usize::MAX);
        let grid = PartGrid {
            azimuths: size(request.azimuths),
            columns: size(request.columns),
            from_mm: mm_from_m(request.from_z),
            to_mm: mm_from_m(request.to_z),
        };
        let part = TurnedPart::round(request.name.clone(), grid, mm_from_m(request.radius));
        let part = Some(part.map_err(|error| error.to_string())?);
        Ok(Self { name: request.name.clone(), part_zero_mm: mm_from_m(request.part_zero), part, request })
    }

    /// Puts it into the chuck of a machine at rest, in the place of what is there.
    pub fn clamp(&mut self, machine: &mut Machine) -> Result<(), BarRefused> {
        let part = self.part.take().ok_or(BarRefused::Gone)?;
        machine.load_turned_part(part, self.part_zero_mm).map_err(BarRefused::Part)
    }
}

/// Puts the bar that is asked for into the chuck of a machine.
///
/// # Errors
/// A bar that is none, a machine that turns nothing.
pub fn clamp_bar(machine: &mut Machine, request: LoadBarRequest) -> Result<(), String> {
    RawBar::new(request)?.clamp(machine).map_err(|error| error.to_string())
}

impl PartSnapshot {
    /// Copies the part as it stands.
    pub fn update(&mut self, machine: &Machine) {
        self.tick = machine.tick();
        self.key_way_rad = machine.key_way_rad();
        let stations = &machine.description().stations;
        self.lobes.clear();
        self.lobes.extend(machine.part().lobes().iter().map(|lobe| SnapshotLobe {
            name: lobe.name().to_owned(),
            station: stations.get(lobe.station()).map_or_else(String::new, |station| station.switch.clone()),
            width_mm: lobe.width_mm(),
            offset_mm: lobe.offset_mm(),
            radii_mm: lobe.radii_mm().to_vec(),
            centre: lobe.centre(),
            cut: lobe.cut_record().cloned(),
        }));
        self.turned = machine.turned_part().map(|part| SnapshotTurned {
            name: part.name().to_owned(),
            grid: *part.grid(),
            part_zero_mm: machine.part_zero_mm(),
            radii_mm: part.radii_mm().collect(),
        });
    }
}

/// Maximum number of pages of a turned part: a late reader still gets all of them.
pub const MAX_PAGES: u32 = 512;

const _: () = assert!(MAX_PAGES as usize * RADII_PER_PAGE == MAX_CELLS);

impl SnapshotTurned {
    /// Pages of the part at a tick, with time and frame in their header.
    pub fn pages(&self, tick: u64, finished: bool, header: Header) -> impl Iterator<Item = TurnedPage> {
        let count = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        split(&self.radii_mm, RADII_PER_PAGE).map(move |piece| TurnedPage {
            header: header.clone(),
            tick,
            name: self.name.clone(),
            finished,
            part_zero: m_from_mm(self.part_zero_mm),
            azimuths: count(self.grid.azimuths),
            columns: count(self.grid.columns),
            from_z: m_from_mm(self.grid.from_mm),
            to_z: m_from_mm(self.grid.to_mm),
            page: piece.page,
            pages: piece.page_count,
            first: piece.offset as u64,
            radius: piece.items.iter().map(|radius| m_from_mm(*radius)).collect(),
        })
    }
}
