// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Homing of a slide with an incremental encoder, as in `LinuxCNC`.
//!
//! ```text
//!  search + , latch +          ┌────────── switch        search + , latch −       ┌────────── switch
//!   search  ───────────────────►──┐                       search ─────────────────►──┐
//!   back off          ◄──────────-┘                       latch         ◄────────────┘   the edge where it opens
//!   latch            ─────────►  the edge where it closes
//! ```
//! With an index the axis goes on in the direction of the latch to the next mark of its encoder.

/// Homing of a slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homing {
    /// Velocity of the search for the switch (mm/s); its sign says where the switch is; 0: it is not searched for.
    pub search_mm_s: f64,
    /// Velocity with which the edge or mark is caught (mm/s). With the sign of the search: after backing off, where the switch
    /// closes; with the other: where it opens. 0: nothing is caught.
    pub latch_mm_s: f64,
    /// Speed of the move to `home_mm` (mm/s).
    pub final_mm_s: f64,
    /// The zero is taken from the encoder's index and not from the switch.
    pub use_index: bool,
    /// Reading of the axis at the captured edge or mark (mm); `None`: the value given by the machine's own dimensions.
    pub offset_mm: Option<f64>,
    /// Target of the axis afterwards (mm).
    pub home_mm: f64,
    /// The switch is the hard limit switch: reaching it is no overtravel before the axis is homed.
    pub ignore_limits: bool,
    /// Axes of smaller numbers are homed before.
    pub sequence: u32,
    /// Position at which the switch closes for an axis in the search direction (mm, true); it stays closed beyond.
    pub switch_mm: f64,
    /// Distance of the encoder's index marks (mm), which lie at its multiples.
    pub index_pitch_mm: f64,
}

/// The kinds of homing that there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HomingKind {
    /// The current position of the axis is its zero.
    Immediate,
    /// The next mark of the encoder.
    IndexOnly,
    /// An edge of the switch.
    SwitchOnly,
    /// An edge of the switch, and then the next mark.
    SwitchAndIndex,
}

impl HomingKind {
    /// Returns whether an edge of a switch is searched.
    #[must_use]
    pub fn has_switch(self) -> bool {
        matches!(self, Self::SwitchOnly | Self::SwitchAndIndex)
    }
}

impl Homing {
    /// Homing sequence given by its velocities and its index; `None`: no homing.
    #[must_use]
    pub fn kind(&self) -> Option<HomingKind> {
        let zero = |value: f64| value.abs() < f64::MIN_POSITIVE;
        match (zero(self.search_mm_s), zero(self.latch_mm_s), self.use_index) {
            (true, true, false) => Some(HomingKind::Immediate),
            (true, false, true) => Some(HomingKind::IndexOnly),
            (false, false, false) => Some(HomingKind::SwitchOnly),
            (false, false, true) => Some(HomingKind::SwitchAndIndex),
            _ => None,
        }
    }

    /// The edge is caught where the switch closes, not where it opens.
    #[must_use]
    pub fn latches_closing(&self) -> bool {
        (self.search_mm_s > 0.0) == (self.latch_mm_s > 0.0)
    }

    /// True position of the captured switch edge (mm).
    #[must_use]
    pub fn edge_mm(&self, hysteresis_mm: f64) -> f64 {
        if self.latches_closing() {
            self.switch_mm
        } else {
            self.switch_mm - libm::copysign(hysteresis_mm, self.search_mm_s)
        }
    }

    /// Reading of the axis at the captured edge or mark (mm).
    #[must_use]
    pub fn offset_mm(&self, hysteresis_mm: f64) -> f64 {
        self.offset_mm.unwrap_or_else(|| match self.kind() {
            Some(HomingKind::SwitchOnly) => self.edge_mm(hysteresis_mm),
            Some(HomingKind::SwitchAndIndex) => {
                let marks = self.edge_mm(hysteresis_mm) / self.index_pitch_mm;
                let next = if self.latch_mm_s > 0.0 { libm::floor(marks) + 1.0 } else { libm::ceil(marks) - 1.0 };
                next * self.index_pitch_mm
            }
            _ => self.home_mm,
        })
    }
}
