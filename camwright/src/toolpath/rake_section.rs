// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Intersection of the rake face of a lathe tool with the surface of the part.
//!
//! ```text
//!        y                         The rake face lies in the plane y = y₀: −H for a tool H below centre, +H above. What of the part
//!        |   part                  stands on it at ψ = atan2(y₀, x) has the azimuth φ = ψ + θ, θ = σ·C; as θ grows the surface moves
//!   -----+-----.--- X              downwards past a tool at +x, whose body lies below the plane.
//!        |      \
//!   -----|-------x==== rake face   r(ψ + θ, z)·sin ψ = y₀,   x = r cos ψ
//! ```
//!
//! With G(x, z, θ) = r(ψ(x) + θ, z) − √(x² + y₀²) = 0 the section x(z) and how it changes with θ follow from the derivatives of r, e.g.
//! dx/dz = r·∂r/∂z / (r cos ψ + ∂r/∂φ sin ψ).
//!
//! All points of the section have |sin ψ| = |y₀|/r, so they lie in a narrow range of ψ. If in all of it r cos ψ + ∂r/∂φ sin ψ > 0 the left
//! side grows with ψ and there is one point for each z: this is proven once, from bounds of r and its slope. Where it cannot be proven
//! the plane is walked from outside in steps that the slope's bound proves to be free of material, so that what is found is the outermost
//! point and nothing stands in front of it.

use crate::cam::surface::{Surface, SurfaceBounds, SurfacePoint};
use crate::math::uniform_hermite::UniformHermite;
use crate::math::units::{TURN_RAD, deg_from_rad};
use crate::math::work::WorkBudget;
use alloc::vec::Vec;
use core::f64::consts::FRAC_PI_2;
use thiserror::Error;

/// Why a rake plane does not cut a surface.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RakeSectionError {
    /// A number that is none, or out of its range.
    #[error("{what} is {value}, it must be {allowed}")]
    BadNumber { what: &'static str, value: f64, allowed: &'static str },
    /// The plane lies so far from the axis that it passes beside part of the surface.
    #[error(
        "the rake plane lies {height_mm:.3} mm from the axis, but at azimuth {azimuth_deg:.1} deg, z = {z_mm:.3} mm the part has a \
         radius of {bound_mm:.3} mm only: it must be below that"
    )]
    Misses {
        /// Distance of the plane from the axis (mm).
        height_mm: f64,
        /// Azimuth of the least radius (deg).
        azimuth_deg: f64,
        /// z there (mm).
        z_mm: f64,
        /// The radius there, less what it may fall between the places looked at (mm).
        bound_mm: f64,
    },
    /// The surface is so flat to the plane that it is not cut but scraped.
    #[error(
        "turned to {turned_deg:.2} deg, the surface at z = {z_mm:.3} mm lies at {angle_deg:.1} deg to the rake plane, it must be above \
         {bound_deg} deg: material stands in front of it, or it is met edge on"
    )]
    Grazes {
        /// Turned angle θ (deg).
        turned_deg: f64,
        /// z (mm).
        z_mm: f64,
        /// Angle between surface and plane across the axis (deg).
        angle_deg: f64,
        /// Lower bound, exclusive (deg).
        bound_deg: f64,
    },
    /// More looks at the surface than are allowed.
    #[error(
        "turned to {turned_deg:.2} deg, z = {z_mm:.3} mm the surface has been looked at {allowed} times, as often as is allowed for a job: \
         fewer or coarser passes, fewer angles a turn, or a smoother surface without narrow hollows"
    )]
    TooMuchWork {
        /// Turned angle θ (deg).
        turned_deg: f64,
        /// z (mm).
        z_mm: f64,
        /// Looks that are allowed.
        allowed: u64,
    },
    /// A section that bends too sharply for its spline.
    #[error(
        "turned to {turned_deg:.2} deg, {knots} knots leave {error_mm:e} mm of the section between them; allowed: {bound_mm:e} mm"
    )]
    Unresolved {
        /// Turned angle θ (deg).
        turned_deg: f64,
        knots: usize,
        /// Remaining error (mm).
        error_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
}

/// A point of the section, and how it moves with z and with the turned angle θ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SectionPoint {
    /// z (mm).
    pub z_mm: f64,
    /// Distance x from the plane through the axis that is perpendicular to the rake plane (mm).
    pub x_mm: f64,
    /// ψ, the angle of the point above the X axis line (rad): negative below centre.
    pub lead_rad: f64,
    /// ∂x/∂z.
    pub by_z: f64,
    /// ∂x/∂θ (mm/rad).
    pub by_turn: f64,
    /// ∂²x/∂z² (1/mm).
    pub by_z_twice: f64,
    /// ∂²x/∂z∂θ (1/rad).
    pub by_z_and_turn: f64,
    /// ∂²x/∂θ² (mm/rad²).
    pub by_turn_twice: f64,
    pub surface: SurfacePoint,
}

impl SectionPoint {
    /// Angle of the outward normal above the X axis line, across the axis: ψ − atan(r′/r) over the azimuth (rad).
    #[must_use]
    pub fn normal_rad(&self) -> f64 {
        self.lead_rad + self.surface.normal_lead_rad()
    }

    /// Curvature of the section (1/mm), positive where it is hollow.
    #[must_use]
    pub fn hollow(&self) -> f64 {
        let w = 1.0 + self.by_z * self.by_z;
        self.by_z_twice / (w * libm::sqrt(w))
    }
}

/// The sections of a surface with one rake plane, at every turned angle.
#[derive(Debug, Clone, PartialEq)]
pub struct RakeSection<'a> {
    surface: &'a Surface,
    y_mm: f64,
    from_mm: f64,
    to_mm: f64,
    bounds: SurfaceBounds,
    /// Range of ψ in which all points lie.
    leads: (f64, f64),
    single: bool,
    /// Work budget that each look at the surface uses.
    budget: Option<&'a WorkBudget>,
}

/// A section along z as a spline.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionCurve {
    /// x over z (mm over mm), with exact slope and bend at its knots.
    pub spline: UniformHermite,
    /// Largest distance from the section midway between knots (mm).
    pub error_mm: f64,
}

/// Error of calculations that do not solve for ψ at every angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shortcuts {
    /// Largest error of x if the radius is taken at ψ = 0 (mm).
    pub ignored_mm: f64,
    /// Largest error of x if it is taken at one ψ, that of the least radius (mm).
    pub constant_mm: f64,
    /// That ψ (rad).
    pub shift_rad: f64,
}

/// A change of ψ after which its square is below rounding (rad).
const CLOSE_RAD: f64 = 1e-8;

/// Least angle between surface and rake plane (rad): below it the section moves by some 30 mm for every mm of the surface.
const MIN_ANGLE_RAD: f64 = 0.035;

/// Steps of Newton's method within its bracket, which bisection alone would need.
const MAX_STEPS: u32 = 100;

/// Most steps from outside to the surface.
const MAX_WALK: u32 = 20_000;

/// Fewest and most pieces of a [`SectionCurve`].
const PIECES: (u32, u32) = (16, 16_384);

impl<'a> RakeSection<'a> {
    /// Sections of a surface with the plane y = `y_mm` between two z (mm), which may lie beyond the ends of the part.
    ///
    /// # Errors
    /// Numbers that are not finite; a plane that passes beside part of the surface.
    pub fn new(surface: &'a Surface, y_mm: f64, from_mm: f64, to_mm: f64) -> Result<Self, RakeSectionError> {
        for (what, value) in
            [("the height of the rake plane", y_mm), ("the z to begin at", from_mm), ("the z to end at", to_mm)]
        {
            if !value.is_finite() || value.abs() > 1e6 {
                return Err(RakeSectionError::BadNumber { what, value, allowed: "within ±1e6 mm" });
            }
        }
        if from_mm > to_mm {
            let what = "the z to begin at";
            return Err(RakeSectionError::BadNumber { what, value: from_mm, allowed: "no more than that to end at" });
        }
        let bounds = surface.bounds(from_mm, to_mm);
        let height_mm = y_mm.abs();
        let min = bounds.min_mm.max(0.0);
        // Not a number misses too. At the axis itself there is nothing to turn.
        if !(bounds.min_mm > height_mm && bounds.largest_mm.is_finite()) {
            let (azimuth, z_mm) = bounds.min_at;
            let azimuth_deg = deg_from_rad(azimuth);
            return Err(RakeSectionError::Misses { height_mm, azimuth_deg, z_mm, bound_mm: min });
        }
        let (near, far) = (libm::asin(height_mm / bounds.largest_mm), libm::asin(height_mm / min));
        let leads = if y_mm < 0.0 { (-far, -near) } else { (near, far) };
        let single = bounds.steepest_ratio * libm::tan(far) < 1.0;
        Ok(Self { surface, y_mm, from_mm, to_mm, bounds, leads, single, budget: None })
    }

    /// The same sections, of which every look at the surface counts against a budget.
    #[must_use]
    pub fn within(self, budget: &'a WorkBudget) -> Self {
        Self { budget: Some(budget), ..self }
    }

    #[must_use]
    pub fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// Height of the plane above the axis (mm).
    #[must_use]
    pub fn y_mm(&self) -> f64 {
        self.y_mm
    }

    /// Between which z it was looked for what the surface does (mm).
    #[must_use]
    pub fn range_mm(&self) -> (f64, f64) {
        (self.from_mm, self.to_mm)
    }

    /// Returns whether every section is proven to have one point for each z.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.single
    }

    /// The outermost point of the section at a turned angle θ (rad) and z (mm), with no material in front of it.
    ///
    /// # Errors
    /// A surface that lies flat to the plane there, or is not met at all on this side.
    pub fn point(&self, turned_rad: f64, z_mm: f64) -> Result<SectionPoint, RakeSectionError> {
        if !turned_rad.is_finite() || !z_mm.is_finite() {
            let value = if z_mm.is_finite() { turned_rad } else { z_mm };
            return Err(RakeSectionError::BadNumber { what: "a place of the section", value, allowed: "finite" });
        }
        let guess = if self.single { 0.5 * (self.leads.0 + self.leads.1) } else { self.walk(turned_rad, z_mm)? };
        self.checked(self.near(turned_rad, z_mm, guess), turned_rad)
    }

    /// A point, unless the surface lies flat to the plane there.
    pub(crate) fn checked(&self, point: SectionPoint, turned_rad: f64) -> Result<SectionPoint, RakeSectionError> {
        if let Some(budget) = self.budget.filter(|budget| budget.is_used_up()) {
            let (turned_deg, z_mm) = (deg_from_rad(turned_rad), point.z_mm);
            return Err(RakeSectionError::TooMuchWork { turned_deg, z_mm, allowed: budget.allowed() });
        }
        let angle = FRAC_PI_2 - point.normal_rad().abs();
        if angle >= MIN_ANGLE_RAD && point.x_mm.is_finite() {
            return Ok(point);
        }
        Err(RakeSectionError::Grazes {
            turned_deg: deg_from_rad(turned_rad),
            z_mm: point.z_mm,
            angle_deg: deg_from_rad(angle),
            bound_deg: libm::round(deg_from_rad(MIN_ANGLE_RAD)),
        })
    }

    /// The point of the section near an angle ψ, by Newton's method in the bracket of all of them. Where the section is single this is
    /// the one; elsewhere the one that a near enough guess leads to.
    pub(crate) fn near(&self, turned_rad: f64, z_mm: f64, guess_rad: f64) -> SectionPoint {
        let (mut low, mut high) = self.leads;
        let mut lead = guess_rad.clamp(low, high);
        for _ in 0..MAX_STEPS {
            let (place, off) = self.place(turned_rad, z_mm, lead);
            if off.abs() < CLOSE_RAD {
                return place.moved(off).section(self.y_mm, z_mm);
            }
            // The sign of the left side shows the side of the point only if the left side is proven to grow.
            if self.single {
                if off < 0.0 { low = lead } else { high = lead }
            }
            let next = lead - off;
            lead = if next > low && next < high { next } else { 0.5 * (low + high) };
            if high - low < 1e-15 {
                break;
            }
        }
        self.place(turned_rad, z_mm, lead).0.section(self.y_mm, z_mm)
    }

    /// The surface seen at an angle ψ, and how far off the plane it is: (r sin ψ − y₀) over its slope (rad).
    #[inline]
    pub(crate) fn place(&self, turned_rad: f64, z_mm: f64, lead_rad: f64) -> (SectionPosition, f64) {
        if let Some(budget) = self.budget {
            budget.spend(1);
        }
        let (sin, cos) = libm::sincos(lead_rad);
        let surface = self.surface.point(lead_rad + turned_rad, z_mm);
        let off = (surface.radius_mm * sin - self.y_mm) / (surface.radius_mm * cos + surface.by_azimuth * sin);
        (SectionPosition { lead_rad, surface }, off)
    }

    /// From outside to the surface along the plane at one z, in steps that cannot pass it.
    fn walk(&self, turned_rad: f64, z_mm: f64) -> Result<f64, RakeSectionError> {
        let y = self.y_mm;
        // |d(r − ρ)/dx| = |r_φ·y/ρ² + x/ρ|, and outside ρ is at least r.
        let min = self.bounds.min_mm;
        let steepest = 1.0 + self.bounds.steepest_mm_rad * y.abs() / (min * min);
        let mut x = libm::sqrt(self.bounds.largest_mm * self.bounds.largest_mm - y * y) + 1e-6;
        let mut lead = 0.0;
        for _ in 0..MAX_WALK {
            if let Some(budget) = self.budget {
                budget.spend(1);
                if budget.is_used_up() {
                    break;
                }
            }
            lead = libm::atan2(y, x);
            let outside = libm::hypot(x, y) - self.surface.radius(lead + turned_rad, z_mm);
            if outside < 1e-9 * min {
                return Ok(lead);
            }
            x -= outside / steepest;
            if x.is_nan() || x <= 0.0 {
                break;
            }
        }
        if let Some(budget) = self.budget.filter(|budget| budget.is_used_up()) {
            let turned_deg = deg_from_rad(turned_rad);
            return Err(RakeSectionError::TooMuchWork { turned_deg, z_mm, allowed: budget.allowed() });
        }
        let place = self.place(turned_rad, z_mm, lead).0;
        Err(RakeSectionError::Grazes {
            turned_deg: deg_from_rad(turned_rad),
            z_mm,
            angle_deg: deg_from_rad((FRAC_PI_2 - (lead + place.surface.normal_lead_rad()).abs()).min(0.0)),
            bound_deg: libm::round(deg_from_rad(MIN_ANGLE_RAD)),
        })
    }

    /// Error of a simplified calculation of the section, at angles of a turn and positions along z; see [`Shortcuts`].
    ///
    /// # Errors
    /// What [`Self::point`] says.
    pub fn shortcuts(&self) -> Result<Shortcuts, RakeSectionError> {
        let (azimuth, z) = self.bounds.min_at;
        let shift_rad = libm::asin(self.y_mm / self.surface.radius(azimuth, z));
        let (angles, rows) = self.surface.looked_at();
        let mut found = Shortcuts { ignored_mm: 0.0, constant_mm: 0.0, shift_rad };
        for row in 0..=rows {
            let z = self.from_mm + (self.to_mm - self.from_mm) * f64::from(row) / f64::from(rows);
            for angle in 0..angles {
                let turned = f64::from(angle) * TURN_RAD / f64::from(angles);
                let x = self.point(turned, z)?.x_mm;
                let off = |shift: f64| {
                    let r = self.surface.radius(turned + shift, z);
                    (x - libm::sqrt((r - self.y_mm) * (r + self.y_mm))).abs()
                };
                found.ignored_mm = found.ignored_mm.max(off(0.0));
                found.constant_mm = found.constant_mm.max(off(shift_rad));
            }
        }
        Ok(found)
    }

    /// The section at a turned angle as a spline over z that leaves it by no more than `tolerance_mm` midway between its knots.
    ///
    /// # Errors
    /// What [`Self::point`] says; a tolerance that is none; a section too rough for it.
    pub fn curve(&self, turned_rad: f64, tolerance_mm: f64) -> Result<SectionCurve, RakeSectionError> {
        let length = self.to_mm - self.from_mm;
        if !(tolerance_mm > 0.0 && length > 0.0) {
            let (what, allowed) = ("the tolerance of a section, or its length,", "above 0");
            return Err(RakeSectionError::BadNumber { what, value: tolerance_mm.min(length), allowed });
        }
        let mut pieces = PIECES.0;
        loop {
            let step = length / f64::from(pieces);
            let at = |k: f64| self.from_mm + k * step;
            let mut knots = Vec::with_capacity(pieces as usize + 1);
            for k in 0..=pieces {
                let point = self.point(turned_rad, at(f64::from(k)))?;
                knots.push([point.x_mm, point.by_z, point.by_z_twice]);
            }
            let Ok(spline) = UniformHermite::new(self.from_mm, step, knots) else {
                let (what, value) = ("a point of the section", f64::NAN);
                return Err(RakeSectionError::BadNumber { what, value, allowed: "finite" });
            };
            let mut error_mm = 0.0_f64;
            for k in 0..pieces {
                let z = at(f64::from(k) + 0.5);
                error_mm = error_mm.max((spline.sample(z).value - self.point(turned_rad, z)?.x_mm).abs());
            }
            if error_mm <= tolerance_mm {
                return Ok(SectionCurve { spline, error_mm });
            }
            if pieces >= PIECES.1 {
                let (turned_deg, knots) = (deg_from_rad(turned_rad), pieces as usize + 1);
                return Err(RakeSectionError::Unresolved { turned_deg, knots, error_mm, bound_mm: tolerance_mm });
            }
            pieces *= 2;
        }
    }
}

/// The surface seen at an angle ψ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SectionPosition {
    lead_rad: f64,
    surface: SurfacePoint,
}

impl SectionPosition {
    /// Section at a slightly smaller angle, to first order in the derivatives and to second in the radius.
    pub(crate) fn moved(self, by_rad: f64) -> Self {
        let s = self.surface;
        Self {
            lead_rad: self.lead_rad - by_rad,
            surface: SurfacePoint {
                radius_mm: s.radius_mm - by_rad * (s.by_azimuth - 0.5 * by_rad * s.by_azimuth_twice),
                by_azimuth: s.by_azimuth - by_rad * s.by_azimuth_twice,
                by_z: s.by_z - by_rad * s.by_azimuth_and_z,
                ..s
            },
        }
    }

    /// The point of the section, if this lies on the plane.
    #[inline]
    pub(crate) fn section(self, y: f64, z_mm: f64) -> SectionPoint {
        let s = self.surface;
        let r = s.radius_mm;
        // x from the plane, not from the cosine: then x² + y₀² = r² to the last digit.
        let x = libm::sqrt((r - y) * (r + y));
        let (q, r3) = (1.0 / (r * r), r * r * r);
        // ψ over x, and ρ = √(x² + y²) over x.
        let (turn, turn_twice) = (-y * q, 2.0 * y * x * q * q);
        let gx = s.by_azimuth * turn - x / r;
        let gxx = s.by_azimuth_twice * turn * turn + s.by_azimuth * turn_twice - y * y / r3;
        let (gxz, gxt) = (s.by_azimuth_and_z * turn, s.by_azimuth_twice * turn);
        let per = -1.0 / gx;
        let (by_z, by_turn) = (s.by_z * per, s.by_azimuth * per);
        SectionPoint {
            z_mm,
            x_mm: x,
            lead_rad: self.lead_rad,
            by_z,
            by_turn,
            by_z_twice: per * (s.by_z_twice + by_z * (2.0 * gxz + gxx * by_z)),
            by_z_and_turn: per * (s.by_azimuth_and_z + gxz * by_turn + gxt * by_z + gxx * by_z * by_turn),
            by_turn_twice: per * (s.by_azimuth_twice + by_turn * (2.0 * gxt + gxx * by_turn)),
            surface: s,
        }
    }
}
