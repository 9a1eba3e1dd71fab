// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Radial compliance along a round shaft on elastic supports.
//!
//! ```text
//!        kh            kr            kt
//!   ─────┴─────────────┴─────────────┴─────    x from the headstock, L between headstock and tailstock
//! ```
//! Bernoulli-Euler beam of constant bending stiffness EI = E π d⁴/64. The deflection at x under a unit force at a ≥ x is, on two springs,
//!
//! ```text
//!  f(x, a) = (1 − x/L)(1 − a/L)/kh + (x/L)(a/L)/kt + b x (L² − b² − x²)/(6 E I L)     b = L − a
//! ```
//! and in a chuck with the radial stiffness kh and the tilting stiffness kφ
//!
//! ```text
//!  f(x, a) = 1/kh + x a/kφ + x² (3a − x)/(6 E I)
//! ```
//! The last terms are cases 1e and 1a of table 8.1 in W. C. Young and R. G. Budynas, "Roark's Formulas for Stress and Strain", 7th ed., after
//! S. Timoshenko, "Strength of Materials", part I; the terms before them superpose the rigid motion on the supports. Further supports (the
//! steady rest, and the tailstock of a part in a chuck) are redundant forces X of the force method: (f(xi, xj) + δij/ki) X = f(xi, a).

use crate::machine::workholding::WorkholdingDescription;

/// Statically determinate support on which the redundant ones act.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Base {
    Centres { tailstock_n_mm: f64 },
    Chuck { tilt_n_mm_rad: f64 },
}

/// Radial spring at a distance from the headstock.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RedundantSpring {
    x_mm: f64,
    n_mm: f64,
}

/// Round shaft on its supports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupportedShaft {
    headstock_z_mm: f64,
    length_mm: f64,
    bending_n_mm2: f64,
    headstock_n_mm: f64,
    base: Base,
    /// Tailstock of a part in a chuck.
    tailstock: Option<RedundantSpring>,
    rest: Option<RedundantSpring>,
}

/// Bending stiffness E I of a round bar (N mm²) of a modulus (N/mm²) and a diameter (mm).
#[must_use]
pub fn round_bending_n_mm2(modulus_n_mm2: f64, diameter_mm: f64) -> f64 {
    let square = diameter_mm * diameter_mm;
    modulus_n_mm2 * core::f64::consts::PI * square * square / 64.0
}

/// Shaft and where its supports stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShaftLayout {
    /// Position of the headstock's centre, or of the front of the jaws of its chuck, along `z_axis` (mm).
    pub headstock_z_mm: f64,
    /// Distance to the centre of the tailstock; without tailstock the free length (mm).
    pub length_mm: f64,
    /// E I (N mm²).
    pub bending_n_mm2: f64,
    pub is_chucked: bool,
    pub has_tailstock: bool,
    /// Position of the steady rest along `z_axis` (mm); `None`: not in use.
    pub steady_rest_z_mm: Option<f64>,
}

impl SupportedShaft {
    /// Shaft on the supports of a machine; `None` where the machine lacks one of them, or a centre would hold the shaft alone.
    #[must_use]
    pub fn new(layout: &ShaftLayout, workholding: &WorkholdingDescription) -> Option<Self> {
        let tailstock_n_mm = if layout.has_tailstock { Some(workholding.tailstock_n_mm?) } else { None };
        let (base, tailstock) = match (layout.is_chucked, tailstock_n_mm) {
            (true, tailstock_n_mm) => {
                let spring = |n_mm| RedundantSpring { x_mm: layout.length_mm, n_mm };
                (Base::Chuck { tilt_n_mm_rad: workholding.chuck_tilt_n_mm_rad? }, tailstock_n_mm.map(spring))
            }
            (false, Some(tailstock_n_mm)) => (Base::Centres { tailstock_n_mm }, None),
            (false, None) => return None,
        };
        let rest = match layout.steady_rest_z_mm {
            Some(z_mm) => {
                Some(RedundantSpring { x_mm: z_mm - layout.headstock_z_mm, n_mm: workholding.steady_rest?.n_mm })
            }
            None => None,
        };
        Some(Self {
            headstock_z_mm: layout.headstock_z_mm,
            length_mm: layout.length_mm,
            bending_n_mm2: layout.bending_n_mm2,
            headstock_n_mm: workholding.headstock_n_mm,
            base,
            tailstock,
            rest,
        })
    }

    /// Position of the headstock's support, and of the other end, along `z_axis` (mm).
    #[must_use]
    pub fn ends_mm(&self) -> (f64, f64) {
        (self.headstock_z_mm, self.headstock_z_mm + self.length_mm)
    }

    /// Position of the steady rest along `z_axis` (mm).
    #[must_use]
    pub fn rest_mm(&self) -> Option<f64> {
        self.rest.map(|rest| self.headstock_z_mm + rest.x_mm)
    }

    /// The same shaft without its steady rest.
    #[must_use]
    pub fn without_rest(self) -> Self {
        Self { rest: None, ..self }
    }

    /// Deflection at a position per force there (mm/N, mm along `z_axis`).
    #[must_use]
    pub fn compliance_mm_n(&self, z_mm: f64) -> f64 {
        self.influence_mm_n(z_mm, z_mm)
    }

    /// Deflection at a position per force at another (mm/N, mm along `z_axis`).
    #[must_use]
    pub fn influence_mm_n(&self, at_mm: f64, force_mm: f64) -> f64 {
        let (x, a) = (at_mm - self.headstock_z_mm, force_mm - self.headstock_z_mm);
        let free = self.determinate(x, a);
        match (self.tailstock, self.rest) {
            (None, None) => free,
            (Some(only), None) | (None, Some(only)) => {
                free - self.determinate(x, only.x_mm) * self.determinate(only.x_mm, a) / self.own(only)
            }
            (Some(one), Some(other)) => {
                let coupling = self.determinate(one.x_mm, other.x_mm);
                let (first, second) = (self.own(one), self.own(other));
                let (load1, load2) = (self.determinate(one.x_mm, a), self.determinate(other.x_mm, a));
                let determinant = first * second - coupling * coupling;
                let force1 = (second * load1 - coupling * load2) / determinant;
                let force2 = (first * load2 - coupling * load1) / determinant;
                free - self.determinate(x, one.x_mm) * force1 - self.determinate(x, other.x_mm) * force2
            }
        }
    }

    /// Radial motion of the part at a position per radial motion of its seat in the steady rest (mm/mm, mm along `z_axis`): an error of
    /// the seat's form reaches the lobe by this share. 0 without a steady rest.
    ///
    /// By the theorem of Betti it is the force on the jaws per force at the position.
    #[must_use]
    pub fn seat_share(&self, z_mm: f64) -> f64 {
        self.rest.map_or(0.0, |rest| rest.n_mm * self.influence_mm_n(self.headstock_z_mm + rest.x_mm, z_mm))
    }

    /// Flexibility of a redundant spring with the shaft under it (mm/N).
    fn own(&self, spring: RedundantSpring) -> f64 {
        self.determinate(spring.x_mm, spring.x_mm) + 1.0 / spring.n_mm
    }

    /// f(x, a) without the redundant supports (mm/N).
    fn determinate(&self, one_mm: f64, other_mm: f64) -> f64 {
        let (x, a) = if one_mm <= other_mm { (one_mm, other_mm) } else { (other_mm, one_mm) };
        match self.base {
            Base::Centres { tailstock_n_mm } => {
                let length = self.length_mm;
                let b = length - a;
                let rigid = (1.0 - x / length) * (b / length) / self.headstock_n_mm
                    + (x / length) * (a / length) / tailstock_n_mm;
                rigid + b * x * (length * length - b * b - x * x) / (6.0 * self.bending_n_mm2 * length)
            }
            Base::Chuck { tilt_n_mm_rad } => {
                let rigid = 1.0 / self.headstock_n_mm + x * a / tilt_n_mm_rad;
                rigid + x * x * (3.0 * a - x) / (6.0 * self.bending_n_mm2)
            }
        }
    }
}
