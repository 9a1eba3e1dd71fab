// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Links of a machine: solids with mass, in m, rad, kg.

/// Height of the spindle's axis above the floor (m).
pub(super) const SPINDLE_HEIGHT: f64 = 1.05;

/// A body, or none.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name, which is that of its frame.
    pub name: String,
    /// Solids that draw it.
    pub visuals: Vec<Visual>,
    /// Mass and moments; none where nothing moves it.
    pub inertial: Option<Inertial>,
}

/// A solid of one colour in the frame of its link.
#[derive(Debug, Clone, PartialEq)]
pub struct Visual {
    pub solid: LinkSolid,
    pub at: [f64; 3],
    /// Red, green, blue, opacity (0..1).
    pub colour: [f64; 4],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LinkSolid {
    /// Its edges along X, Y, Z.
    Box([f64; 3]),
    /// A cylinder along Z.
    AlongZ { radius: f64, length: f64 },
    /// A cylinder along Y.
    AlongY { radius: f64, length: f64 },
}

/// Mass and its moments about the middle, along X, Y, Z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    /// Mass (kg).
    pub mass: f64,
    /// Its middle in the frame of the link.
    pub at: [f64; 3],
    /// Moments (kg m²).
    pub moments: [f64; 3],
}
