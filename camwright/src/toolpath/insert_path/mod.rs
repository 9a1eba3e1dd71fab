// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Path of the centre of a round insert while the part turns: X over the turned angle, along a spiral of many turns.
//!
//! ```text
//!   x      ___ section x(z) at θ        The insert of radius R lies in the rake plane. It touches the section where
//!     \   /                             tan τ = dx/dz, and its centre stands at
//!      \_/  (  )  insert                X = x + R cos τ,   z_R = z − R sin τ.
//! ```
//!
//! If the section is nowhere hollower than the insert (curvature below 1/R), there is one contact for each `z_R`, and the insert cuts
//! nowhere else. Otherwise the centre runs on the envelope X(`z_R`) = max over z of x(z) + √(R² − (z − `z_R`)²), which cuts nothing and
//! leaves material in the hollow; the amount is reported.
//!
//! The path carries X with its exact first and second derivative over θ at equal steps of the turn: X′ = ∂x/∂θ + tan τ·`z_R′`, for the
//! envelope does not feel how the contact moves, and X″ by one derivative more. Between the knots it is the quintic through them, C².
//!
//! Stock for a pass to come is left as a parallel to the section: a path for R + stock, driven with the insert of radius R.

mod along_curve;
mod cells;
mod contact;
mod cusp;
mod edge;
mod hollow;
mod key;
mod passes;
mod rates;
mod spindle;
mod varied;

pub use cusp::Cusp;
pub use edge::{AngleAt, EngagedEdge, UncutBar};
pub use hollow::Hollow;
pub use key::InsertPathKey;
pub use passes::{Pass, PassStep, Passes, cusp_mm};
pub use rates::{AxisLimits, PathRates, PathUse, Rates, SpeedBound, SpindleSpeed};
pub use spindle::{BoundShare, SpindleLaw};

use crate::cam::surface::Surface;
use crate::math::hermite::{HermiteError, HermiteSpline, Knot, Sample};
use crate::math::range::minimum_and_maximum;
use crate::math::uniform_hermite::UniformHermite;
use crate::math::units::{TURN_RAD, deg_from_rad};
use crate::math::work::WorkBudget;
use crate::toolpath::rake_section::{RakeSection, RakeSectionError};
use alloc::vec::Vec;
use contact::Contacts;
use hollow::Hollows;
use thiserror::Error;

/// Why there is no path for an insert.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InsertPathError {
    /// A number that is none, or out of its range.
    #[error("{what} is {value}, it must be {allowed}")]
    BadNumber { what: InsertPathKey, value: f64, allowed: &'static str },
    /// The rake plane does not cut the surface as it must.
    #[error(transparent)]
    Section(#[from] RakeSectionError),
    #[error("the spiral has {turns:.1} turns of {angles} angles, {knots:.0} in all; allowed: {max}")]
    TooLong { turns: f64, angles: u32, knots: f64, max: u32 },
    /// A hollow that the insert does not reach, on a path that would have to.
    #[error(
        "turned to {turned_deg:.2} deg, the section at z = {z_mm:.3} mm is hollow with a radius of {radius_mm:.3} mm, it must be above \
         {bound_mm:.3} mm to be followed at constant feed along the curve"
    )]
    TooHollow {
        /// Turned angle (deg).
        turned_deg: f64,
        /// z (mm).
        z_mm: f64,
        /// Radius of the hollow (mm).
        radius_mm: f64,
        /// Radius of the insert with its stock (mm).
        bound_mm: f64,
    },
    /// Part of the surface stands behind another as seen along the rake plane.
    #[error(
        "turned to {turned_deg:.2} deg at z = {z_mm:.3} mm the insert would have to jump by {jump_mm:.4} mm; allowed: {bound_mm:.4} mm: \
         part of the surface stands behind another and is not reached"
    )]
    Overhang {
        /// Turned angle (deg).
        turned_deg: f64,
        /// z of the insert's centre (mm).
        z_mm: f64,
        /// Change of X from one angle to the next (mm).
        jump_mm: f64,
        /// Value allowed by the slopes on both sides (mm).
        bound_mm: f64,
    },
    /// Steps of the angle that are too long.
    #[error(
        "{angles} angles a turn leave {error_mm:e} mm between them at {turned_deg:.2} deg, z = {z_mm:.3} mm; allowed: {bound_mm:e} mm: \
         more angles, or a smoother surface"
    )]
    Unresolved {
        angles: u32,
        /// Remaining error (mm).
        error_mm: f64,
        /// Turned angle (deg).
        turned_deg: f64,
        /// z of the insert's centre (mm).
        z_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// The finished path does not pass its forward check.
    #[error(
        "at {turned_deg:.2} deg, z = {z_mm:.3} mm the section comes within {distance_mm:.6} mm of the insert's centre; allowed: \
         {bound_mm:.6} mm"
    )]
    Gouges {
        /// Turned angle (deg).
        turned_deg: f64,
        /// z of the insert's centre (mm).
        z_mm: f64,
        /// Distance (mm).
        distance_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// An axis would exceed a limit.
    #[error(
        "{axis} needs {quantity} {value:.4}, its limit is {bound:.4}, at {turned_deg:.2} deg (spindle at {spindle_rad_s:.4} rad/s)"
    )]
    ExceedsLimit {
        axis: &'static str,
        /// Quantity with its unit.
        quantity: &'static str,
        /// Required value.
        value: f64,
        bound: f64,
        /// Turned angle (deg).
        turned_deg: f64,
        /// Speed of the spindle (rad/s).
        spindle_rad_s: f64,
    },
}

/// Feed of the insert along the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InsertFeed {
    /// Z at constant speed: the same way every turn (mm), and all the time.
    AlongZ(f64),
    /// The contact at constant speed along each section: at every angle it goes the same way along that section's curve each turn, at
    /// most so much (mm), and reaches the end together with all others. Z goes to and fro with the angle.
    AlongCurve(f64),
}

/// Requested path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathRequest {
    /// Radius of the round insert R (mm).
    pub insert_radius_mm: f64,
    /// Height of the rake plane above the axis (mm): −H for a tool H below centre.
    pub plane_y_mm: f64,
    /// Start of the insert's centre along z (mm); with [`InsertFeed::AlongCurve`] start of the contact.
    pub from_mm: f64,
    /// End (mm), in either direction.
    pub to_mm: f64,
    pub feed: InsertFeed,
    /// Angles a turn: 180 to 3600, a step of 2° to 0.1°.
    pub angles: u32,
    /// Turned angle θ = σ·C at which it begins (rad).
    pub start_rad: f64,
    /// Stock that is left on the section, along its normal in the rake plane (mm).
    pub stock_mm: f64,
}

/// Accuracy of a path between its knots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsertPathAccuracy {
    /// Largest difference of X from the exact one midway between knots (mm).
    pub interpolation_error_mm: f64,
    /// Maximum amount by which the distance of the centre from the section falls below R (mm), found by testing all points.
    pub gouge_mm: f64,
    /// Places that were looked at.
    pub places: u32,
}

/// Z of the insert's centre over the turned angle.
#[derive(Debug, Clone, PartialEq)]
pub enum ZLaw {
    /// At constant speed: from a z (mm) at the path's first angle on, by so much per rad (mm/rad).
    Straight {
        /// Start (mm).
        from_mm: f64,
        /// Rate (mm/rad).
        per_rad: f64,
    },
    Spline(UniformHermite),
}

/// X and Z of the insert's centre over the turned angle θ = σ·C.
#[derive(Debug, Clone, PartialEq)]
pub struct InsertPath {
    request: PathRequest,
    x: UniformHermite,
    z: ZLaw,
    /// Place of the contact on the insert's edge at each knot (rad).
    edge_rad: Vec<f64>,
    hollow: Option<Hollow>,
    accuracy: InsertPathAccuracy,
}

/// Most knots of a path: 360 angles of 13,000 turns.
const MAX_KNOTS: u32 = 5_000_000;

/// Largest insert (mm).
const LARGEST_INSERT_MM: f64 = 1000.0;

/// Error of X between knots that is still accepted (mm): what the plan promises of the distance from the section.
const ALLOWED_ERROR_MM: f64 = 1e-5;

/// Maximum addition to X, in addition to its slopes, by a contact that changes the flank of a hollow (mm).
const CONTINUOUS_MM: f64 = 5e-3;

/// Places at which a path is looked at again.
const CHECKED_PLACES: u32 = 1200;

/// Points of the section that are tried from one edge of the insert to the other.
const TRIED: u32 = 48;

impl PathRequest {
    fn check(&self) -> Result<(), InsertPathError> {
        let bad = |what, value, allowed| Err(InsertPathError::BadNumber { what, value, allowed });
        let r = self.insert_radius_mm;
        if !(r > 0.0 && r <= LARGEST_INSERT_MM) {
            return bad(InsertPathKey::InsertRadius, r, "above 0 and up to 1000 mm");
        }
        let (InsertFeed::AlongZ(feed) | InsertFeed::AlongCurve(feed)) = self.feed;
        if !(feed > 0.0 && feed <= r) {
            return bad(InsertPathKey::Feed, feed, "above 0 and no more than the radius of the insert");
        }
        if !(self.stock_mm >= 0.0 && self.stock_mm <= LARGEST_INSERT_MM) {
            return bad(InsertPathKey::Stock, self.stock_mm, "0 to 1000 mm");
        }
        if !(180..=3600).contains(&self.angles) {
            return bad(InsertPathKey::Angles, f64::from(self.angles), "180 to 3600");
        }
        if !self.start_rad.is_finite() || self.start_rad.abs() > 1e6 {
            return bad(InsertPathKey::StartAngle, self.start_rad, "within ±1e6 rad");
        }
        for (what, value) in [(InsertPathKey::Begin, self.from_mm), (InsertPathKey::End, self.to_mm)] {
            if !value.is_finite() || value.abs() > 1e6 {
                return bad(what, value, "within ±1e6 mm");
            }
        }
        Ok(())
    }

    /// Radius with the stock that is left (mm).
    fn reach_mm(&self) -> f64 {
        self.insert_radius_mm + self.stock_mm
    }

    fn step_rad(&self) -> f64 {
        TURN_RAD / f64::from(self.angles)
    }

    /// Steps of a spiral of so many turns, at least one.
    fn steps(&self, turns: f64) -> Result<u32, InsertPathError> {
        let knots = libm::ceil(turns * f64::from(self.angles) - 1e-9).max(1.0);
        if knots.is_nan() || knots >= f64::from(MAX_KNOTS) {
            return Err(InsertPathError::TooLong { turns, angles: self.angles, knots, max: MAX_KNOTS });
        }
        #[allow(clippy::cast_possible_truncation, reason = "it was bounded")]
        Ok(knots as u32)
    }
}

impl InsertPath {
    /// The path of an insert along a surface.
    ///
    /// # Errors
    /// Numbers out of range, a plane that does not cut the surface, a surface too rough for the angles, a result that the forward check
    /// does not confirm.
    pub fn new(surface: &Surface, request: &PathRequest) -> Result<Self, InsertPathError> {
        Self::within(surface, request, &WorkBudget::new(u64::MAX))
    }

    /// The same path within a budget of looks at the surface.
    ///
    /// # Errors
    /// As [`Self::new`]; a budget that is used up.
    pub fn within(surface: &Surface, request: &PathRequest, budget: &WorkBudget) -> Result<Self, InsertPathError> {
        request.check()?;
        let reach = request.reach_mm();
        let (low, high) = (request.from_mm.min(request.to_mm), request.from_mm.max(request.to_mm));
        // The centre lies up to a radius beyond the contact, and what it touches may, up to another beyond that.
        let room = if matches!(request.feed, InsertFeed::AlongZ(_)) { reach } else { 2.0 * reach };
        let section = RakeSection::new(surface, request.plane_y_mm, low - room, high + room)?.within(budget);
        let hollows = Hollows::find(&section, reach)?;
        let contacts = Contacts::new(&section, reach, &hollows);
        let (x, z, edge_rad) = match request.feed {
            InsertFeed::AlongZ(feed) => Self::along_z(&contacts, request, feed)?,
            InsertFeed::AlongCurve(feed) => along_curve::spiral(&contacts, request, feed)?,
        };
        let hollow = contacts.bridged_hollow()?;
        let accuracy = InsertPathAccuracy { interpolation_error_mm: 0.0, gouge_mm: 0.0, places: 0 };
        let mut path = Self { request: *request, x, z, edge_rad, hollow, accuracy };
        path.accuracy = path.check(&contacts)?;
        Ok(path)
    }

    fn along_z(
        contacts: &Contacts<'_>,
        request: &PathRequest,
        feed: f64,
    ) -> Result<(UniformHermite, ZLaw, Vec<f64>), InsertPathError> {
        let way = request.to_mm - request.from_mm;
        let steps = request.steps(way.abs() / feed)?;
        let step = request.step_rad();
        let per_rad = if way < 0.0 { -feed } else { feed } / TURN_RAD;
        let z_at = |k: f64| request.from_mm + k * step * per_rad;
        let turned = |k: f64| request.start_rad + k * step;
        let mut knots: Vec<[f64; 3]> = Vec::with_capacity(steps as usize + 1);
        let mut edge_rad = Vec::with_capacity(steps as usize + 1);
        let mut follow = contacts.follow();
        for k in 0..=steps {
            let k = f64::from(k);
            let contact = follow.next(turned(k), z_at(k))?;
            edge_rad.push(contact.edge_rad(z_at(k)));
            if follow.jumped() {
                let next = contact.knot(per_rad, 0.0);
                if let Some(before) = knots.last() {
                    let (jump_mm, slope) = ((next[0] - before[0]).abs(), next[1].abs().max(before[1].abs()));
                    let bound_mm = CONTINUOUS_MM + 2.0 * slope * step;
                    if jump_mm > bound_mm {
                        let (turned_deg, z_mm) = (deg_from_rad(turned(k)), z_at(k));
                        return Err(InsertPathError::Overhang { turned_deg, z_mm, jump_mm, bound_mm });
                    }
                }
                // Between the two the higher of both contacts counts, and the quintic would cut the corner.
                raise(&mut knots, next, step, |u| {
                    contacts.envelope(turned(k - 1.0 + u), z_at(k - 1.0 + u)).map(|contact| contact.x_mm)
                })?;
            } else {
                knots.push(contact.knot(per_rad, 0.0));
            }
        }
        let x = spline(request.start_rad, step, knots)?;
        Ok((x, ZLaw::Straight { from_mm: request.from_mm, per_rad }, edge_rad))
    }

    /// Requested path.
    #[must_use]
    pub fn request(&self) -> &PathRequest {
        &self.request
    }

    /// X of the insert's centre over the turned angle (mm over rad).
    #[must_use]
    pub fn x(&self) -> &UniformHermite {
        &self.x
    }

    /// Z of the insert's centre over the turned angle.
    #[must_use]
    pub fn z(&self) -> &ZLaw {
        &self.z
    }

    /// Z of the insert's centre and its derivatives at a turned angle (rad).
    #[must_use]
    pub fn z_at(&self, turned_rad: f64) -> Sample {
        match &self.z {
            ZLaw::Straight { from_mm, per_rad } => {
                let since = turned_rad.clamp(self.x.start(), self.x.end()) - self.x.start();
                Sample { value: from_mm + since * per_rad, first: *per_rad, second: 0.0, third: 0.0 }
            }
            ZLaw::Spline(spline) => spline.sample(turned_rad),
        }
    }

    /// X and Z of the insert's centre over the angle since the path begins (mm over rad), in the form in which plans carry motion.
    ///
    /// # Errors
    /// None for a path that was made here: its step is positive and its knots are finite.
    pub fn laws(&self) -> Result<(HermiteSpline, HermiteSpline), HermiteError> {
        let since =
            |spline: &UniformHermite| UniformHermite::new(0.0, spline.step(), spline.knots().to_vec())?.to_hermite();
        let z = match &self.z {
            ZLaw::Straight { from_mm, per_rad } => {
                let end = self.x.end() - self.x.start();
                let knot = |at: f64| Knot { at, value: from_mm + at * per_rad, first: *per_rad, second: 0.0 };
                HermiteSpline::new([knot(0.0), knot(end)].to_vec())?
            }
            ZLaw::Spline(spline) => since(spline)?,
        };
        Ok((since(&self.x)?, z))
    }

    /// The tightest hollow that the insert does not reach into, `None` if it reaches everywhere.
    #[must_use]
    pub fn hollow(&self) -> Option<Hollow> {
        self.hollow
    }

    /// Accuracy of the path.
    #[must_use]
    pub fn accuracy(&self) -> InsertPathAccuracy {
        self.accuracy
    }

    /// Least and largest X of the insert's centre at the knots (mm).
    #[must_use]
    pub fn x_range_mm(&self) -> (f64, f64) {
        minimum_and_maximum(self.x.knots().iter().map(|[x, ..]| *x))
    }

    /// Stroke of X over the whole spiral (mm).
    #[must_use]
    pub fn stroke_mm(&self) -> f64 {
        let (low, high) = self.x_range_mm();
        high - low
    }

    /// Height of the cusps that its feed leaves (mm), see [`cusp_mm`].
    #[must_use]
    pub fn cusp_mm(&self) -> f64 {
        let (InsertFeed::AlongZ(feed) | InsertFeed::AlongCurve(feed)) = self.request.feed;
        cusp_mm(self.request.insert_radius_mm, feed)
    }

    /// Looks at places spread over the whole path: between knots against the exact contact, and against the section itself, all of whose
    /// points within the insert's reach are tried.
    fn check(&self, contacts: &Contacts<'_>) -> Result<InsertPathAccuracy, InsertPathError> {
        let steps = u32::try_from(self.x.knots().len() - 1).unwrap_or(u32::MAX);
        let places = CHECKED_PLACES.min(steps);
        let mut found = InsertPathAccuracy { interpolation_error_mm: 0.0, gouge_mm: 0.0, places };
        let reach = contacts.reach_mm();
        for place in 0..places {
            // Spread evenly, and at all angles of the turn.
            let knot = (u64::from(place) * u64::from(steps) / u64::from(places)) as f64;
            let turned = self.x.start() + (knot + 0.5) * self.x.step();
            let (x, z) = (self.x.sample(turned).value, self.z_at(turned).value);
            let place = |error_mm: f64| (deg_from_rad(turned), z, error_mm);
            let exact = contacts.envelope(turned, z)?;
            let error_mm = if exact.hollow { (exact.x_mm - x).max(0.0) } else { (exact.x_mm - x).abs() };
            if error_mm > ALLOWED_ERROR_MM || error_mm.is_nan() {
                let ((turned_deg, z_mm, error_mm), angles) = (place(error_mm), self.request.angles);
                return Err(InsertPathError::Unresolved {
                    angles,
                    error_mm,
                    turned_deg,
                    z_mm,
                    bound_mm: ALLOWED_ERROR_MM,
                });
            }
            let nearest = contacts.nearest(turned, x, z, TRIED)?;
            let gouge_mm = reach - nearest;
            if gouge_mm > ALLOWED_ERROR_MM || gouge_mm.is_nan() {
                let ((turned_deg, z_mm, distance_mm), bound_mm) = (place(nearest), reach - ALLOWED_ERROR_MM);
                return Err(InsertPathError::Gouges { turned_deg, z_mm, distance_mm, bound_mm });
            }
            found.interpolation_error_mm = found.interpolation_error_mm.max(error_mm);
            found.gouge_mm = found.gouge_mm.max(gouge_mm);
        }
        Ok(found)
    }
}

fn spline(start: f64, step: f64, knots: Vec<[f64; 3]>) -> Result<UniformHermite, InsertPathError> {
    UniformHermite::new(start, step, knots).map_err(|_| InsertPathError::BadNumber {
        what: InsertPathKey::Knot,
        value: f64::NAN,
        allowed: "finite",
    })
}

/// Puts a knot behind others where the contact jumped in between, and raises both by what the quintic would cut there.
fn raise(
    knots: &mut Vec<[f64; 3]>,
    mut next: [f64; 3],
    step: f64,
    exact: impl Fn(f64) -> Result<f64, InsertPathError>,
) -> Result<(), InsertPathError> {
    if let Some(before) = knots.last_mut() {
        let piece = spline(0.0, 1.0, [*before, next].map(|[x, v, a]| [x, v * step, a * step * step]).to_vec())?;
        let mut lack = 0.0_f64;
        for part in 1..16_u32 {
            let u = f64::from(part) / 16.0;
            lack = lack.max(exact(u)? - piece.sample(u).value);
        }
        before[0] += lack;
        next[0] += lack;
    }
    knots.push(next);
    Ok(())
}
