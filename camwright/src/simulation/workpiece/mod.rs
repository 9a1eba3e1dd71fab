// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The part: per lobe a polar radius over azimuth, from which the wheel takes away what it sweeps.
//!
//! Azimuths are in the part's frame, from the keyway. With the wheel's centre at distance X from the axis, at azimuth θ,
//! the wheel of radius R leaves at azimuth φ, with δ = φ − θ,
//!
//! ```text
//! r(φ) = X cos δ − √(R² − X² sin² δ)
//! ```
//! the nearer of the two intersections of the ray with the wheel. It grows with |δ|, so the point of a block of azimuths
//! nearest to θ decides whether the block can be cut at all.
//!
//! The wall of a bore has negative radii: on the ray from the axis through a point of the wall, counted against the direction of that
//! point. The wheel inside has its centre at a negative X then, and everything above holds: a smaller radius is material removed.
//!
//! The radii of a crank pin are about its own centre, in a frame parallel to the part's: [`Lobe::centre`]. [`WheelCentre::seen_from`]
//! takes the wheel into that frame; everything here is as for a lobe about the axis.

mod candidate_blocks;
mod compliance;
mod cut_record;
mod snapshot;
mod wheel_pass;

use crate::cam::contour::LobeCentre;
use crate::math::units::TURN_RAD;
use crate::toolpath::wheel_path::line_angle;
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

use candidate_blocks::{BlockEdge, BlockList, CandidateBlocks, FoundBlock, WheelDisc};
pub use compliance::Deflection;
pub(crate) use compliance::{DeepestTouch, Engagement, TouchedCut};
pub use cut_record::{CutRecord, DEGREES, RemovalAtDegree};
pub(crate) use wheel_pass::WheelPass;

/// Default number of azimuths of an outline: 0.1° apart, the block of JPS6156064B2.
pub const DEFAULT_AZIMUTHS: usize = 3600;

/// Azimuths that are looked at together. Larger blocks are rejected less often, smaller ones cost more looking.
const BLOCK: usize = 16;

/// Why an outline is not one.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LobeError {
    /// Too few radii for a turn.
    #[error("lobe {name}: {count} radii, at least {MIN_AZIMUTHS}")]
    TooFewRadii { name: String, count: usize },
    /// A radius is no number, 0, or has not the sign of the first.
    #[error(
        "lobe {name}: radius {index} is {radius} mm, must be finite, and all of them above 0, or below 0 for the wall of a bore"
    )]
    Radius {
        name: String,
        /// Index of the radius.
        index: usize,
        /// Its value (mm).
        radius: f64,
    },
    /// The width is not positive.
    #[error("lobe {name}: width {width_mm} mm, must be positive and finite")]
    Width {
        name: String,
        /// The width (mm).
        width_mm: f64,
    },
    /// The centre is no place.
    #[error(
        "lobe {name}: its centre is {distance_mm} mm from the axis at {azimuth_rad} rad, both must be finite, the distance at least 0"
    )]
    Centre {
        name: String,
        /// Distance from the axis (mm).
        distance_mm: f64,
        /// Azimuth (rad).
        azimuth_rad: f64,
    },
    /// The offset from the station is no place.
    #[error("lobe {name}: its middle is {offset_mm} mm from the station, must be finite")]
    Offset {
        name: String,
        /// The offset (mm).
        offset_mm: f64,
    },
    /// A wheel would meet more sections than the machine can grind together.
    #[error("lobe {name}: at station {station} the wheel would meet more than {max} sections at once")]
    TooManySections { name: String, station: String, max: usize },
    /// The machine has no such station.
    #[error("lobe {name}: the machine has no station {station}")]
    UnknownStation {
        name: String,
        /// The station asked for.
        station: String,
    },
    /// The compliance of the part is none, or the machine has no supports that it could come from.
    #[error(
        "lobe {name}: the part has a compliance of {part_mm_n} mm/N there; it must be 0 or above, and other than 0 only on a machine with \
         `workholding`"
    )]
    PartCompliance {
        name: String,
        /// The compliance (mm/N).
        part_mm_n: f64,
    },
    /// Another lobe stands at this station.
    #[error("lobe {name}: station {station} already has lobe {other}")]
    StationTaken {
        name: String,
        /// The station asked for.
        station: String,
        /// The lobe that is there.
        other: String,
    },
}

/// Margin of the list of a tick over that of a servo step.
const LISTED: f64 = 4.0;

/// Addition to the margin of a list of blocks, for rounding (mm).
const ROUNDING_MM: f64 = 1e-6;

/// Most sections at a station, and most that the wheel may meet at once.
pub(crate) const MAX_AT_STATION: usize = 150;
pub(crate) const MAX_FACED: usize = 5;

/// Fewest radii of an outline.
pub const MIN_AZIMUTHS: usize = 16;

/// Material removed by the wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Removal {
    /// Volume per width of the cut (mm³/mm).
    pub area_mm2: f64,
    /// Deepest penetration of the wheel where it stands, measured along the radius (mm).
    pub depth_mm: f64,
    /// The wheel is over the part's axis, where it can cut nothing.
    pub is_over_axis: bool,
}

impl Removal {
    #[must_use]
    pub fn and(self, other: Removal) -> Removal {
        Removal {
            area_mm2: self.area_mm2 + other.area_mm2,
            depth_mm: self.depth_mm.max(other.depth_mm),
            is_over_axis: self.is_over_axis || other.is_over_axis,
        }
    }

    /// This with what the same wheel does to a section beside it: the area is per width, and that of this section.
    #[must_use]
    pub fn beside(self, other: Removal) -> Removal {
        Removal { area_mm2: self.area_mm2, ..self.and(other) }
    }
}

/// The wheel as the part sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelCentre {
    /// Azimuth of its centre in the part's frame (rad).
    pub azimuth_rad: f64,
    /// Distance of its centre from the part's axis (mm); negative beyond the axis, inside a bore.
    pub centre_mm: f64,
    /// Its radius (mm).
    pub radius_mm: f64,
}

impl WheelCentre {
    /// The wheel as it is seen from the centre of a lobe.
    #[must_use]
    pub fn seen_from(self, centre: Option<LobeCentre>) -> Self {
        let Some(centre) = centre else { return self };
        let (centre_mm, azimuth_rad) = centre.relative(self.centre_mm, self.azimuth_rad);
        Self { azimuth_rad, centre_mm, ..self }
    }

    /// The wheel where something carries it along a normal.
    #[must_use]
    pub fn carried(self, by: Deflection) -> Self {
        let (along, across) = (self.centre_mm + by.mm * by.normal.0, by.mm * by.normal.1);
        Self {
            azimuth_rad: self.azimuth_rad + line_angle(across, along),
            centre_mm: libm::copysign(libm::hypot(along, across), along),
            ..self
        }
    }
}

/// The wheel as it faces the part: which way its centre lies, as a direction.
#[derive(Debug, Clone, Copy)]
struct WheelDirection {
    centre_mm: f64,
    radius_mm: f64,
    /// Cosine and sine of its azimuth.
    direction: (f64, f64),
    azimuth_rad: f64,
}

impl WheelDirection {
    fn from_wheel(wheel: WheelCentre) -> Self {
        let WheelCentre { azimuth_rad, centre_mm, radius_mm } = wheel;
        let (sin, cos) = libm::sincos(azimuth_rad);
        Self { centre_mm, radius_mm, direction: (cos, sin), azimuth_rad }
    }

    /// Returns whether a point at distance `r` from the axis, in a direction at an angle with this cosine, is inside the wheel.
    fn has(&self, r: f64, cos_delta: f64) -> bool {
        let x = self.centre_mm;
        r * (r - 2.0 * x * cos_delta) + x * x < self.radius_mm * self.radius_mm
    }

    fn disc(&self) -> WheelDisc {
        let (cos, sin) = self.direction;
        WheelDisc { centre: (self.centre_mm * cos, self.centre_mm * sin), radius_mm: self.radius_mm }
    }

    fn cos_to(&self, c: f64, s: f64) -> f64 {
        c * self.direction.0 + s * self.direction.1
    }

    /// Squares of the distances of a block's points from the wheel's centre, without a branch between two points; those of a block that
    /// is not full are endless.
    fn squares(&self, radii: &[f64], cos: &[f64], sin: &[f64]) -> [f64; BLOCK] {
        let x = self.centre_mm;
        let mut squares = [f64::INFINITY; BLOCK];
        for (((square, r), c), s) in squares.iter_mut().zip(radii).zip(cos).zip(sin) {
            *square = r * (r - 2.0 * x * self.cos_to(*c, *s)) + x * x;
        }
        squares
    }
}

/// One lobe of the part.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobe {
    name: String,
    station: usize,
    width_mm: f64,
    /// Middle of its width from the position of the station along Z (mm).
    offset_mm: f64,
    /// Centre of its radii; `None` for the axis.
    centre: Option<LobeCentre>,
    /// It is the wall of a bore.
    is_bore: bool,
    radii: Vec<f64>,
    block_reach: Vec<f64>,
    /// Cosine and sine of every azimuth; of the opposite one in a bore.
    cos: Vec<f64>,
    sin: Vec<f64>,
    reach: f64,
    changed: bool,
    met: compliance::EngagedSurface,
    record: Option<CutRecord>,
    /// Compliance of the part on its supports here (mm/N); `None` on a machine without such supports.
    part_mm_n: Option<f64>,
}

impl Lobe {
    /// A lobe from its outline: radii (mm) at azimuths i·2π/n from the keyway, negative for the wall of a bore.
    ///
    /// # Errors
    /// Too few radii, radii of two signs, a width that is not positive.
    pub fn new(name: String, station: usize, width_mm: f64, radii: Vec<f64>) -> Result<Self, LobeError> {
        if radii.len() < MIN_AZIMUTHS {
            return Err(LobeError::TooFewRadii { name, count: radii.len() });
        }
        let is_bore = radii[0] < 0.0;
        let sign = if is_bore { -1.0 } else { 1.0 };
        if let Some(index) = radii.iter().position(|r| !(sign * *r > 0.0 && r.is_finite())) {
            return Err(LobeError::Radius { name, index, radius: radii[index] });
        }
        if !(width_mm > 0.0 && width_mm.is_finite()) {
            return Err(LobeError::Width { name, width_mm });
        }
        let azimuth = |i: usize| TURN_RAD * i as f64 / radii.len() as f64;
        let cos = (0..radii.len()).map(|i| sign * libm::cos(azimuth(i))).collect();
        let sin = (0..radii.len()).map(|i| sign * libm::sin(azimuth(i))).collect();
        let block_reach: Vec<f64> = radii.chunks(BLOCK).map(largest).collect();
        let reach = largest(&radii);
        let met = compliance::EngagedSurface::new(&radii, &block_reach);
        Ok(Self {
            name,
            station,
            width_mm,
            offset_mm: 0.0,
            centre: None,
            is_bore,
            radii,
            block_reach,
            cos,
            sin,
            reach,
            changed: false,
            met,
            record: None,
            part_mm_n: None,
        })
    }

    /// The same outline about a centre off the axis.
    ///
    /// # Errors
    /// Numbers that are not finite, a distance below 0.
    pub fn about(self, centre: Option<LobeCentre>) -> Result<Self, LobeError> {
        if let Some(LobeCentre { distance_mm, azimuth_rad }) = centre
            && !(distance_mm.is_finite() && distance_mm >= 0.0 && azimuth_rad.is_finite())
        {
            return Err(LobeError::Centre { name: self.name, distance_mm, azimuth_rad });
        }
        Ok(Self { centre: centre.filter(|centre| centre.distance_mm > 0.0), ..self })
    }

    /// The same outline with the middle of its width beside the position of the station (mm along Z): a section of a wide lobe.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn beside_station(self, offset_mm: f64) -> Result<Self, LobeError> {
        if !offset_mm.is_finite() {
            return Err(LobeError::Offset { name: self.name, offset_mm });
        }
        Ok(Self { offset_mm, ..self })
    }

    /// Middle of its width from the position of the station along Z (mm); 0 but for a section of a wide lobe.
    #[must_use]
    pub fn offset_mm(&self) -> f64 {
        self.offset_mm
    }

    /// Both are sections of one lobe: they stand at one station and have one centre.
    #[must_use]
    pub fn is_section_with(&self, other: &Self) -> bool {
        self.station == other.station && self.centre == other.centre
    }

    /// Centre of its radii, of a crank pin; `None` for the axis of the part.
    #[must_use]
    pub fn centre(&self) -> Option<LobeCentre> {
        self.centre
    }

    /// Distance of that centre from the axis (mm).
    #[must_use]
    pub fn throw_mm(&self) -> f64 {
        self.centre.map_or(0.0, |centre| centre.distance_mm)
    }

    /// It is the wall of a bore; its radii are negative.
    #[must_use]
    pub fn is_bore(&self) -> bool {
        self.is_bore
    }

    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Index of the station at which it stands in front of the wheel.
    #[must_use]
    pub fn station(&self) -> usize {
        self.station
    }

    /// Width along the axis (mm).
    #[must_use]
    pub fn width_mm(&self) -> f64 {
        self.width_mm
    }

    /// Radii (mm) about its centre, at azimuths i·2π/n from the keyway; negative for the wall of a bore.
    #[must_use]
    pub fn radii_mm(&self) -> &[f64] {
        &self.radii
    }

    /// Radius at an azimuth from the keyway (rad), straight between two of its azimuths (mm).
    #[must_use]
    pub fn radius_between_mm(&self, azimuth_rad: f64) -> f64 {
        let n = self.radii.len();
        let turns = azimuth_rad / TURN_RAD;
        let steps = (turns - libm::floor(turns)) * n as f64;
        let index = self.index_of(azimuth_rad);
        let (left, right) = (self.radii[index], self.radii[(index + 1) % n]);
        left + (right - left) * (steps - index as f64)
    }

    /// Keeps a record of what is cut from now on.
    pub(crate) fn record(&mut self, record: CutRecord) {
        self.record = Some(record);
    }

    /// Holds the part here by supports of this compliance (mm/N); `None`: by none that deflect.
    pub(crate) fn hold(&mut self, part_mm_n: Option<f64>) {
        self.part_mm_n = part_mm_n;
    }

    /// It stands on a machine whose supports deflect.
    pub(crate) fn is_on_supports(&self) -> bool {
        self.part_mm_n.is_some()
    }

    /// Compliance of the part on its supports here (mm/N); 0: the part is as stiff as the machine's contact says.
    #[must_use]
    pub fn part_mm_n(&self) -> f64 {
        self.part_mm_n.unwrap_or(0.0)
    }

    /// Process values at every degree, if they are recorded.
    #[must_use]
    pub fn cut_record(&self) -> Option<&CutRecord> {
        self.record.as_ref()
    }

    /// An upper bound of its radius (mm), exact after [`Lobe::refresh`].
    #[must_use]
    pub fn reach_mm(&self) -> f64 {
        self.reach
    }

    /// Finds its largest radius anew if something was cut.
    pub fn refresh(&mut self) {
        if self.changed {
            self.reach = largest(&self.block_reach);
            self.changed = false;
        }
    }

    /// The wheel stands here for a moment: removes what it penetrates, or, with `cuts` false, only measures how deep it penetrates.
    ///
    /// Valid while the part is smaller than √(X² − R²), the distance of the wheel's tangent point: then a ray that meets
    /// the wheel leaves the part inside it. A wheel over the part's axis (X ≤ R) cuts nothing and has the whole part
    /// as depth.
    pub fn pass(&mut self, wheel: WheelCentre, cuts: bool) -> Removal {
        self.beside(&wheel).unwrap_or_else(|| self.cut(&WheelDirection::from_wheel(wheel), cuts))
    }

    /// The same in the course of a tick, which cuts at its end.
    pub(crate) fn pass_later(&mut self, wheel: WheelCentre, pass: &mut WheelPass) -> Removal {
        match self.beside(&wheel) {
            Some(removal) => removal,
            None => self.cut_later(Some(WheelDirection::from_wheel(wheel)), None, pass),
        }
    }

    /// Removal of a wheel that is off the part, or over its axis.
    fn beside(&self, wheel: &WheelCentre) -> Option<Removal> {
        if wheel.centre_mm - wheel.radius_mm >= self.reach {
            return Some(Removal::default());
        }
        let over_axis = Removal { depth_mm: self.reach, is_over_axis: true, ..Removal::default() };
        self.is_over_axis(wheel.centre_mm, wheel.radius_mm).then_some(over_axis)
    }

    /// A wheel outside of the part covers its axis.
    fn is_over_axis(&self, centre_mm: f64, radius_mm: f64) -> bool {
        !self.is_bore && centre_mm <= radius_mm
    }

    /// Lists the blocks that the wheel can meet while its centre moves by less than a margin (mm), on the surface that a deflected wheel
    /// meets or on the one that is left. A list stays as it is while it holds for the margin.
    pub(crate) fn list_blocks(&self, wheel: WheelCentre, is_deflected: bool, margin_mm: f64, pass: &mut WheelPass) {
        let wheel = WheelDirection::from_wheel(wheel);
        if !pass.near.holds(&wheel.disc(), margin_mm) {
            self.list(&wheel, is_deflected, LISTED * margin_mm, &mut pass.near);
        }
    }

    fn list(&self, wheel: &WheelDirection, is_deflected: bool, margin_mm: f64, near: &mut BlockList) {
        let larger = WheelDirection { radius_mm: wheel.radius_mm + margin_mm + ROUNDING_MM, ..*wheel };
        if self.is_over_axis(larger.centre_mm, larger.radius_mm) {
            near.clear();
            return;
        }
        let (block_reach, reach) =
            if is_deflected { self.met.reaches() } else { (self.block_reach.as_slice(), self.reach) };
        let (first, blocks) = (self.block_of(wheel.azimuth_rad), block_reach.len());
        let mut search = CandidateBlocks::of_all(first);
        near.collect(wheel.disc(), margin_mm, (first, blocks), || {
            loop {
                let (block, edge) = search.next_with_edge(blocks, |block, edge| {
                    let at = self.azimuth_of(block, edge);
                    let cos = larger.cos_to(self.cos[at], self.sin[at]);
                    (larger.has(reach, cos), larger.has(block_reach[block], cos))
                })?;
                let reach = block_reach[block];
                if block == first {
                    // The wheel's centre may face any of its azimuths: where it does now is nearest.
                    let (cos, sin) = wheel.direction;
                    if larger.has(reach, 1.0) {
                        return Some(FoundBlock { block, point: (reach * cos, reach * sin) });
                    }
                    continue;
                }
                let at = self.azimuth_of(block, edge);
                return Some(FoundBlock { block, point: (reach * self.cos[at], reach * self.sin[at]) });
            }
        });
    }

    fn cut(&mut self, wheel: &WheelDirection, cuts: bool) -> Removal {
        let mut removal = Removal::default();
        let mut near = self.search(wheel, None);
        while let Some(block) = near.next(self.block_reach.len(), |block, edge| self.look(wheel, block, edge)) {
            removal = removal.and(self.cut_block(block, wheel, cuts));
        }
        removal
    }

    /// By the edge of a block nearest to the wheel's centre: whether any block could be inside the wheel there, and whether this one is.
    fn look(&self, wheel: &WheelDirection, block: usize, edge: BlockEdge) -> (bool, bool) {
        let at = self.azimuth_of(block, edge);
        let cos = wheel.cos_to(self.cos[at], self.sin[at]);
        (wheel.has(self.reach, cos), wheel.has(self.block_reach[block], cos))
    }

    /// Looks about from the block that the wheel's centre faces, in a list if it holds there.
    fn search<'a>(&self, wheel: &WheelDirection, near: Option<&'a BlockList>) -> CandidateBlocks<'a> {
        CandidateBlocks::new(self.block_of(wheel.azimuth_rad), &wheel.disc(), near)
    }

    /// The azimuth of a block at one of its edges.
    fn azimuth_of(&self, block: usize, edge: BlockEdge) -> usize {
        match edge {
            BlockEdge::First => block * BLOCK,
            BlockEdge::Last => ((block + 1) * BLOCK).min(self.radii.len()) - 1,
        }
    }

    #[allow(clippy::cast_possible_truncation, reason = "a fraction of a turn times the count")]
    fn index_of(&self, azimuth_rad: f64) -> usize {
        let turns = azimuth_rad / TURN_RAD;
        let index = ((turns - libm::floor(turns)) * self.radii.len() as f64) as usize;
        index.min(self.radii.len() - 1)
    }

    /// The azimuth at which a wheel on this side grinds.
    fn facing(&self, azimuth_rad: f64) -> usize {
        self.index_of(if self.is_bore { azimuth_rad + 0.5 * TURN_RAD } else { azimuth_rad })
    }

    /// The block that faces a wheel at an azimuth.
    fn block_of(&self, azimuth_rad: f64) -> usize {
        self.facing(azimuth_rad) / BLOCK
    }

    fn cut_block(&mut self, block: usize, wheel: &WheelDirection, cuts: bool) -> Removal {
        let (cos, sin) = wheel.direction;
        let range = block * BLOCK..((block + 1) * BLOCK).min(self.radii.len());
        let (x, r2) = (wheel.centre_mm, wheel.radius_mm * wheel.radius_mm);
        let half_step = 0.5 * TURN_RAD / self.radii.len() as f64;
        let squares = wheel.squares(&self.radii[range.clone()], &self.cos[range.clone()], &self.sin[range.clone()]);
        if smallest(&squares) >= r2 {
            return Removal::default();
        }
        let mut inside: u32 = 0;
        for (i, square) in squares.iter().enumerate() {
            inside |= u32::from(*square < r2) << i;
        }
        let mut removal = Removal::default();
        let mut highest = f64::NEG_INFINITY;
        while inside != 0 {
            let at = range.start + inside.trailing_zeros() as usize;
            inside &= inside - 1;
            let (r, c, s) = (self.radii[at], self.cos[at], self.sin[at]);
            let (cos_delta, sin_delta) = (wheel.cos_to(c, s), s * cos - c * sin);
            let offset = x * sin_delta;
            let left = x * cos_delta - libm::sqrt((r2 - offset * offset).max(0.0));
            let penetration = r - left;
            if penetration <= 0.0 {
                continue;
            }
            removal.depth_mm = removal.depth_mm.max(penetration);
            if cuts {
                let after = r - penetration;
                removal.area_mm2 += (r * r - after * after).abs() * half_step;
                self.radii[at] = after;
                highest = r.max(highest);
            }
        }
        // While the highest azimuth stands, so does the reach.
        if highest >= self.block_reach[block] {
            self.block_reach[block] = largest(&self.radii[range]);
            self.changed = true;
        }
        removal
    }
}

fn largest(radii: &[f64]) -> f64 {
    // No radius is NaN. Four at a time, which do not wait for each other.
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (fours, rest) = radii.as_chunks::<4>();
    let none = f64::NEG_INFINITY;
    let max = fours.iter().fold([none; 4], |max, four| core::array::from_fn(|i| larger(max[i], four[i])));
    rest.iter().chain(&max).fold(none, |max, radius| larger(max, *radius))
}

/// Smallest of a block's numbers, none of which is NaN: by halves, which are read as they were written.
fn smallest(numbers: &[f64; BLOCK]) -> f64 {
    let smaller = |a: f64, b: f64| if b < a { b } else { a };
    let eight: [f64; 8] = core::array::from_fn(|i| smaller(numbers[i], numbers[i + 8]));
    let four: [f64; 4] = core::array::from_fn(|i| smaller(eight[i], eight[i + 4]));
    smaller(smaller(four[0], four[2]), smaller(four[1], four[3]))
}

/// The part between the centres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Workpiece {
    lobes: Vec<Lobe>,
}

impl Workpiece {
    /// Its lobes, in the order in which they were loaded.
    #[must_use]
    pub fn lobes(&self) -> &[Lobe] {
        &self.lobes
    }

    /// The lobe with this name.
    #[must_use]
    pub fn lobe(&self, name: &str) -> Option<&Lobe> {
        self.lobes.iter().find(|lobe| lobe.name == name)
    }

    /// No part is there.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lobes.is_empty()
    }

    /// Adds a lobe, in the place of one with the same name.
    pub fn load(&mut self, lobe: Lobe) {
        match self.lobes.iter_mut().find(|other| other.name == lobe.name) {
            Some(other) => *other = lobe,
            None => self.lobes.push(lobe),
        }
    }

    /// Takes the part out.
    pub fn clear(&mut self) {
        self.lobes.clear();
    }

    /// Another wheel with this surface speed (m/s) grinds it from now on.
    pub(crate) fn change_wheel(&mut self, wheel_speed_m_s: f64) {
        for record in self.lobes.iter_mut().filter_map(|lobe| lobe.record.as_mut()) {
            record.set_wheel_speed(wheel_speed_m_s);
        }
    }

    pub(crate) fn lobe_by_name_mut(&mut self, name: &str) -> Option<&mut Lobe> {
        self.lobes.iter_mut().find(|lobe| lobe.name == name)
    }

    pub(crate) fn lobe_mut(&mut self, index: usize) -> &mut Lobe {
        &mut self.lobes[index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::unit_numbers;
    use alloc::vec;

    fn blank(radius: f64) -> Lobe {
        Lobe::new(String::from("L"), 0, 10.0, vec![radius; DEFAULT_AZIMUTHS]).expect("a round blank")
    }

    /// Every azimuth by the formula alone.
    fn slow_pass(radii: &mut [f64], wheel: WheelCentre) {
        let n = radii.len() as f64;
        for (i, radius) in radii.iter_mut().enumerate() {
            let delta = TURN_RAD * i as f64 / n - wheel.azimuth_rad;
            let (x, r) = (wheel.centre_mm, wheel.radius_mm);
            let under = r * r - (x * libm::sin(delta)) * (x * libm::sin(delta));
            if under >= 0.0 && libm::cos(delta) > 0.0 {
                *radius = radius.min(x * libm::cos(delta) - libm::sqrt(under));
            }
        }
    }

    /// Blocks that are passed over lose nothing: random wheels against the formula on every azimuth.
    #[test]
    fn blocks_cut_exactly_what_the_formula_cuts() {
        let mut random = unit_numbers(0x2545_f491);
        for azimuths in [16, 31, 3600, 1001] {
            let mut lobe = Lobe::new(String::from("L"), 0, 10.0, vec![25.0; azimuths]).expect("a round blank");
            let mut slow = vec![25.0; azimuths];
            let mut area = 0.0;
            for _ in 0..300 {
                let wheel = WheelCentre {
                    azimuth_rad: 40.0 * (random() - 0.5),
                    radius_mm: 60.0,
                    centre_mm: 85.5 - 3.0 * random(),
                };
                area += lobe.pass(wheel, true).area_mm2;
                lobe.refresh();
                slow_pass(&mut slow, wheel);
            }
            for (i, (fast, slow)) in lobe.radii_mm().iter().zip(&slow).enumerate() {
                assert!((fast - slow).abs() < 1e-12, "{azimuths} {i}: {fast} {slow}");
            }
            let left: f64 = lobe.radii_mm().iter().map(|r| r * r * 0.5 * TURN_RAD / azimuths as f64).sum();
            assert!((area + left - 0.5 * TURN_RAD * 625.0).abs() < 1e-9, "what is gone is what was taken");
        }
    }

    #[test]
    fn looking_does_not_cut() {
        let mut lobe = blank(20.0);
        let wheel = WheelCentre { azimuth_rad: 1.0, centre_mm: 79.9, radius_mm: 60.0 };
        let seen = lobe.pass(wheel, false);
        assert!((seen.depth_mm - 0.1).abs() < 1e-4 && seen.area_mm2 == 0.0, "{seen:?}");
        assert_eq!(lobe, blank(20.0));
    }

    #[test]
    fn outlines_that_are_none_are_refused() {
        let lobe = |radii: Vec<f64>| Lobe::new(String::from("L"), 0, 10.0, radii).map(|_| ());
        assert!(matches!(lobe(vec![1.0; 3]), Err(LobeError::TooFewRadii { count: 3, .. })));
        let mut radii = vec![1.0; 100];
        radii[7] = f64::NAN;
        assert!(matches!(lobe(radii), Err(LobeError::Radius { index: 7, .. })));
    }
}
