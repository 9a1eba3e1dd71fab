// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From a contour back to a lift: what an inspection gauge reads that touches the cam with another follower than it was
//! made for.
//!
//! Cams are measured with the tip of the inspection machine and compared with the table of the follower that runs on them.
//! The reading of the gauge's follower is a property of the contour: of all pieces of the contour that it can touch at a
//! cam angle, it rests on the one that holds it farthest out. Where the contour is too concave for the gauge (a flat face
//! on any hollow, a roller on one tighter than itself), it bridges the hollow. The contour in between is not measured,
//! [`Inspection::overlooked`] reports it, and the reading has a corner there.

use crate::cam::contour::Contour;
use crate::cam::follower::frame::rotated;
use crate::cam::follower::mount::Mount;
use crate::cam::follower::touch::ContactMiss;
use crate::cam::follower::{Follower, FollowerError};
use crate::cam::lift::{LiftLaw, LiftLawError};
use crate::math::extremum::Extremum;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;
use thiserror::Error;

/// Why a gauge gives no lift of a contour.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InspectionError {
    /// The gauge's follower cannot lie on the base circle.
    #[error(transparent)]
    Gauge(#[from] FollowerError),
    /// The cam is too large for the gauge.
    #[error("the gauge's follower cannot reach over the cam at cam angle {angle_deg:.3} deg")]
    OutOfReach {
        /// Cam angle (deg).
        angle_deg: f64,
    },
    /// The reading is no smooth lift.
    #[error("the gauge's reading is no lift: {0}")]
    NoLaw(#[from] LiftLawError),
}

/// A contour under the follower of a gauge. Its zero is the base circle of the contour.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    contour: Contour,
    gauge: Follower,
    mount: Mount,
    /// One for each of equal steps of the contour's own cam angle.
    pieces: Vec<ContactMiss>,
    /// Bound on how much the miss changes from one piece to the next, at any cam angle.
    largest_change: f64,
    overlooked: Option<Extremum>,
}

/// Reading of a gauge at one cam angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftReading {
    /// Lift of the gauge's follower (mm, or deg as its [`crate::cam::follower::SwingLift`] says).
    pub lift: f64,
    /// The contour's own cam angle (rad) of the point touched: [`Contour::point`] has it.
    pub contact_rad: f64,
}

/// Steps between two pieces in which the place of contact is closed in on: a dozen do, the rest is for corners.
const STEPS: usize = 100;

impl Inspection {
    /// Puts a gauge on a contour.
    ///
    /// # Errors
    /// A follower that cannot lie on the contour's base circle.
    pub fn new(contour: &Contour, gauge: &Follower) -> Result<Self, InspectionError> {
        let mount = Mount::new(gauge, contour.base_radius_mm())?;
        let count = contour.lift().grid();
        let pieces: Vec<ContactMiss> = (0..count).map(|i| miss_at(contour, &mount, angle_of(i, count))).collect();
        let next = |i: usize| &pieces[(i + 1) % count];
        let largest_change = pieces.iter().enumerate().map(|(i, miss)| miss.change_to(next(i))).fold(0.0, f64::max);
        let overlooked = contour.maximum_concavity().filter(|place| match gauge.tip_radius_mm() {
            Some(radius_mm) => 1.0 + place.value * radius_mm <= 0.0,
            None => true,
        });
        Ok(Self { contour: contour.clone(), gauge: *gauge, mount, pieces, largest_change, overlooked })
    }

    #[must_use]
    pub fn contour(&self) -> &Contour {
        &self.contour
    }

    #[must_use]
    pub fn gauge(&self) -> Follower {
        self.gauge
    }

    /// The most concave place of the contour (cam angle in rad, curvature in 1/mm), if the gauge cannot touch it.
    #[must_use]
    pub fn overlooked(&self) -> Option<Extremum> {
        self.overlooked
    }

    /// Returns the reading of the gauge at a cam angle (rad), exact to rounding; `None` if its arm cannot reach over the
    /// cam there.
    #[must_use]
    pub fn read(&self, cam_angle_rad: f64) -> Option<LiftReading> {
        let (sin, cos) = (libm::sin(cam_angle_rad), libm::cos(cam_angle_rad));
        let count = self.pieces.len();
        let mut highest: Option<LiftReading> = None;
        let mut i = 0;
        while i < count {
            let before = self.pieces[i].at(cos, sin);
            // As many pieces on as the miss needs at least to change its sign.
            #[allow(clippy::cast_possible_truncation, reason = "saturates, and is not negative")]
            let further = (before.abs() / self.largest_change) as usize;
            if further > 1 {
                i = i.saturating_add(further - 1);
                continue;
            }
            let after = self.pieces[(i + 1) % count].at(cos, sin);
            if (before <= 0.0) != (after <= 0.0) {
                let ends = [(angle_of(i, count), before), (angle_of(i + 1, count), after)];
                let contact_rad = self.close_in(ends, cos, sin);
                if let Some(lift) = self.lift_on(contact_rad, cam_angle_rad)
                    && highest.is_none_or(|reading| lift > reading.lift)
                {
                    highest = Some(LiftReading { lift, contact_rad });
                }
            }
            i += 1;
        }
        highest
    }

    /// The readings over the turn as a lift law for the gauge's follower: from it and the same base circle
    /// [`Contour::from_lift`] makes the contour again, if nothing was overlooked.
    ///
    /// # Errors
    /// A cam too large for the gauge's arm; readings with a corner, as they are where something is overlooked.
    pub fn law(&self) -> Result<LiftLaw, InspectionError> {
        let lift = |angle| self.read(angle).map_or(f64::NAN, |reading| reading.lift);
        // The base circle of a printed table is read within half a digit, and so is what is made from it.
        LiftLaw::sampled(lift, f64::INFINITY).map_err(|error| match error {
            LiftLawError::NotFinite { angle_deg } => InspectionError::OutOfReach { angle_deg },
            other => InspectionError::NoLaw(other),
        })
    }

    /// Contact angle between two pieces with misses of opposite sign: regula falsi with the Illinois rule.
    fn close_in(&self, ends: [(f64, f64); 2], cos: f64, sin: f64) -> f64 {
        let [(mut a, mut miss_a), (mut b, mut miss_b)] = ends;
        for _ in 0..STEPS {
            let at = b - miss_b * (b - a) / (miss_b - miss_a);
            if at.is_nan() || (at - b).abs() <= f64::EPSILON * (1.0 + b.abs()) {
                break;
            }
            let miss = miss_at(&self.contour, &self.mount, at).at(cos, sin);
            if (miss <= 0.0) == (miss_b <= 0.0) {
                miss_a *= 0.5;
            } else {
                (a, miss_a) = (b, miss_b);
            }
            (b, miss_b) = (at, miss);
        }
        b
    }

    fn lift_on(&self, contact_rad: f64, cam_angle_rad: f64) -> Option<f64> {
        // Along the gauge's u and n̂: from the frame of the contour's own follower to that of the gauge.
        let frame = self.contour.local(contact_rad);
        let turn = contact_rad - cam_angle_rad;
        let point = rotated(frame.along, frame.across, turn);
        let normal = rotated(frame.normal_along, frame.normal_across, turn);
        self.mount.lift_on((point.x, point.y), (normal.x, normal.y))
    }
}

/// Distance of a follower from the contour at one of its own cam angles.
fn miss_at(contour: &Contour, mount: &Mount, at_rad: f64) -> ContactMiss {
    let frame = contour.local(at_rad);
    let point = rotated(frame.along, frame.across, at_rad);
    mount.miss(point, rotated(frame.normal_along, frame.normal_across, at_rad))
}

fn angle_of(index: usize, count: usize) -> f64 {
    index as f64 * TURN_RAD / count as f64
}
