// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Dressing: when the wheel is trued within a job, what radius it has then, and what it would cost to keep the old path.
//!
//! ```text
//! R_n+1 = R_n − depth − wear since the last dress        path of R_n+1 for every lobe after it
//! ```
//! A wheel that wears by w on an unchanged path leaves w on the part, along the normal and everywhere alike (the curves of
//! its centre and of its rim are parallel): that is the predicted error. A wheel that is dressed by ΔR on an unchanged path
//! keeps the position of its cutting point, and leaves ΔR·(1 − cos β) on the flanks, β between the contour's normal and the
//! wheel line. The path is therefore computed anew for every radius, and that error is only reported.

use crate::cam::contour::Contour;
use crate::machine::description::{MAX_WHEELS, MachineDescription, WheelsNow};
use crate::machine::wheel_state::{WheelNow, mm_from_nm, nm_from_mm};
use crate::math::extremum::Extremum;
use crate::math::units::{TURN_RAD, um_from_mm, wrap_turn};
use crate::toolpath::wheel_path::ToolPath;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use thiserror::Error;

/// When the wheel is dressed, and by how much.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DressingSpec {
    /// Dressed before a lobe once so many have been ground since the last dress.
    pub every_lobes: Option<u32>,
    /// Dressed before a part once so many have been finished since the last dress.
    pub every_parts: Option<u32>,
    /// Dressed before a lobe whose form error by wear since the last dress would be larger (mm).
    pub predicted_error_mm: Option<f64>,
    /// Taken off the worn wheel's radius (mm).
    pub depth_mm: f64,
}

/// Why the wheel is dressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DressReason {
    /// Number of lobes ground with it.
    Lobes(u32),
    /// Number of parts finished with it.
    Parts(u32),
    /// The next lobe would be further off than allowed.
    PredictedError,
    /// Requested by a client.
    Asked,
}

impl fmt::Display for DressReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DressReason::Lobes(count) => write!(f, "{count} lobes ground"),
            DressReason::Parts(count) => write!(f, "{count} parts finished"),
            DressReason::PredictedError => f.write_str("predicted error"),
            DressReason::Asked => f.write_str("asked for"),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dress {
    /// Index of the lobe it comes before.
    pub before_lobe: usize,
    pub reason: DressReason,
    /// Radius the wheel had at the dress before (mm).
    pub old_radius_mm: f64,
    /// Predicted to be worn off since (mm).
    pub wear_mm: f64,
    /// Taken off by the dresser (mm).
    pub depth_mm: f64,
    /// Radius after it (nm).
    pub radius_nm: i64,
}

impl Dress {
    /// Radius after it (mm).
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        mm_from_nm(self.radius_nm)
    }
}

/// Why a job cannot be dressed as it says.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DressError {
    /// There is nothing to dress with.
    #[error("machine {machine} has no dresser; a job with dressing needs one")]
    NoDresser { machine: String },
    #[error("dressing has no interval: add every_lobes, every_parts or predicted_error_um")]
    NoReason,
    /// A setting is no number above 0.
    #[error("dressing.{key} is {value}; it must be above 0")]
    OutOfRange { key: &'static str, value: f64 },
    /// Wear cannot be predicted.
    #[error("dressing.predicted_error_um needs wheel.grinding_ratio of machine {machine}, which is missing")]
    NoWear { machine: String },
    /// One lobe wears a freshly dressed wheel too much.
    #[error(
        "lobe {lobe}: its {area_mm2:.2} mm2 of stock wear a dressed wheel of radius {radius_mm:.4} mm by {:.3} um at a \
         grinding ratio of {grinding_ratio}; dressing.predicted_error_um allows {:.3} um", um_from_mm(*.error_mm),
        um_from_mm(*.allowed_mm)
    )]
    WearsTooMuch {
        lobe: String,
        /// Stock removed per width.
        area_mm2: f64,
        /// Radius of the wheel.
        radius_mm: f64,
        /// Volume removed over volume lost.
        grinding_ratio: f64,
        /// Error at its end (mm).
        error_mm: f64,
        /// Allowed (mm).
        allowed_mm: f64,
    },
    /// More is to come off than the dresser may take.
    #[error(
        "lobe {lobe}: the dress before it takes {:.3} um off the wheel's radius ({:.3} um of wear with it); the dresser is \
         allowed {:.3} um", um_from_mm(*.depth_mm), um_from_mm(*.wear_mm), um_from_mm(*.allowed_mm)
    )]
    TooDeep {
        lobe: String,
        /// Depth and wear (mm).
        depth_mm: f64,
        /// Wear in it (mm).
        wear_mm: f64,
        /// Most allowed (mm).
        allowed_mm: f64,
    },
    /// The wheel is used up.
    #[error(
        "lobe {lobe}: the dress before it leaves a wheel of radius {radius_mm:.4} mm; wheel.min_radius_mm is {min_mm:.4} mm: mount a new wheel"
    )]
    WornOut {
        lobe: String,
        /// Radius after the dress (mm).
        radius_mm: f64,
        /// Smallest allowed (mm).
        min_mm: f64,
    },
}

impl DressingSpec {
    /// Checks that a machine can do it.
    fn check(&self, machine: &MachineDescription) -> Result<(), DressError> {
        let name = || machine.name.clone();
        if machine.dresser.is_none() {
            return Err(DressError::NoDresser { machine: name() });
        }
        if self.every_lobes.is_none() && self.every_parts.is_none() && self.predicted_error_mm.is_none() {
            return Err(DressError::NoReason);
        }
        let counts = [("every_lobes", self.every_lobes), ("every_parts", self.every_parts)];
        if let Some((key, _)) = counts.into_iter().find(|(_, count)| *count == Some(0)) {
            return Err(DressError::OutOfRange { key, value: 0.0 });
        }
        for (key, mm) in
            [("depth_um", Some(self.depth_mm)), ("predicted_error_um", self.predicted_error_mm)].into_iter()
        {
            if let Some(mm) = mm.filter(|mm| !(mm.is_finite() && *mm > 0.0)) {
                return Err(DressError::OutOfRange { key, value: um_from_mm(mm) });
            }
        }
        if self.predicted_error_mm.is_some() && machine.wheel.grinding_ratio.is_none() {
            return Err(DressError::NoWear { machine: name() });
        }
        Ok(())
    }
}

/// A lobe to be ground, as the wheel sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LobeStock<'a> {
    /// Name of the lobe.
    pub name: &'a str,
    /// Stock along the normal (mm).
    pub stock_mm: f64,
    /// Its area per width (mm²).
    pub area_mm2: f64,
    /// Position of the wheel that grinds it, of a job that mounts its wheels; `None`: the mounted one.
    pub wheel: Option<usize>,
}

impl LobeStock<'_> {
    fn wheel_index(&self, machine: &MachineDescription) -> usize {
        self.wheel.unwrap_or_else(|| machine.mounted_wheel())
    }

    /// Wear of the wheel since its last dress at the end of the lobe (mm). What a worn wheel leaves it does not remove:
    /// w₁ = w₀ + k (stock − w₁), with k what the whole stock would wear, over the stock.
    fn wear_at_end_mm(&self, machine: &MachineDescription, now: &WheelNow) -> f64 {
        let wheel = machine.wheel_at(self.wheel_index(machine));
        let k = wheel.wear_mm(now.radius_mm - now.wear_mm, self.area_mm2) / self.stock_mm;
        now.wear_mm + (k * (self.stock_mm - now.wear_mm) / (1.0 + k)).max(0.0)
    }
}

/// The wheel over a job: what each lobe is ground with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WheelCourse {
    /// Radius that the path of each lobe is made for (mm).
    pub radii_mm: Vec<f64>,
    /// Wear since the last dress at the end of each lobe, predicted (mm): what it leaves on the lobe.
    pub wear_mm: Vec<f64>,
    /// The dresses, in their order.
    pub dresses: Vec<Dress>,
    /// The wheels that a job mounts, in their order; empty where it names none.
    pub mounts: Vec<WheelMount>,
}

/// A wheel that a job mounts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelMount {
    /// Index of the lobe it comes before.
    pub before_lobe: usize,
    /// Position in the changer.
    pub wheel: usize,
    /// Radius of the wheel then (mm).
    pub radius_mm: f64,
}

impl WheelCourse {
    /// Follows the wheel through lobes in the order in which they are ground.
    ///
    /// # Errors
    /// A dress that cannot be made; see [`DressError`].
    pub fn new(
        spec: Option<&DressingSpec>,
        machine: &MachineDescription,
        wheels: &WheelsNow,
        lobes: &[LobeStock<'_>],
    ) -> Result<Self, DressError> {
        if let Some(spec) = spec {
            spec.check(machine)?;
        }
        let mut course = Self::default();
        let mut of_wheel: [Option<WheelNow>; MAX_WHEELS] = [None; MAX_WHEELS];
        for (index, lobe) in lobes.iter().enumerate() {
            let wheel = lobe.wheel_index(machine).min(MAX_WHEELS - 1);
            let is_first = of_wheel[wheel].is_none();
            let now = of_wheel[wheel].get_or_insert_with(|| wheels.wheel(machine, wheel));
            if lobe.wheel.is_some() && course.mounts.last().is_none_or(|last| last.wheel != wheel) {
                course.mounts.push(WheelMount { before_lobe: index, wheel, radius_mm: now.radius_mm });
            }
            if let Some(spec) = spec
                && let Some(reason) = spec.reason(now, lobe.wear_at_end_mm(machine, now), is_first)
            {
                let dress = spec.dress(index, lobe, reason, now, machine)?;
                *now = WheelNow::dressed(dress.radius_mm());
                course.dresses.push(dress);
            }
            now.wear_mm = lobe.wear_at_end_mm(machine, now);
            let allowed = spec.and_then(|spec| spec.predicted_error_mm);
            if let Some(allowed_mm) = allowed.filter(|allowed_mm| now.wear_mm > *allowed_mm) {
                return Err(DressError::WearsTooMuch {
                    lobe: String::from(lobe.name),
                    area_mm2: lobe.area_mm2,
                    radius_mm: now.radius_mm,
                    grinding_ratio: machine.wheel_at(wheel).grinding_ratio.unwrap_or(f64::INFINITY),
                    error_mm: now.wear_mm,
                    allowed_mm,
                });
            }
            now.lobes_since_dress += 1;
            course.radii_mm.push(now.radius_mm);
            course.wear_mm.push(now.wear_mm);
        }
        Ok(course)
    }
}

impl DressingSpec {
    /// Why the wheel must be dressed before a lobe that would end with this wear (mm).
    fn reason(&self, now: &WheelNow, worn_mm: f64, is_first: bool) -> Option<DressReason> {
        if is_first && self.every_parts.is_some_and(|max| now.parts_since_dress >= max) {
            return Some(DressReason::Parts(now.parts_since_dress));
        }
        if self.every_lobes.is_some_and(|max| now.lobes_since_dress >= max) {
            return Some(DressReason::Lobes(now.lobes_since_dress));
        }
        // A wheel without wear is not made better by a dress.
        let beyond = self.predicted_error_mm.is_some_and(|max| worn_mm > max) && now.wear_mm > 0.0;
        beyond.then_some(DressReason::PredictedError)
    }

    fn dress(
        &self,
        before_lobe: usize,
        lobe: &LobeStock<'_>,
        reason: DressReason,
        now: &WheelNow,
        machine: &MachineDescription,
    ) -> Result<Dress, DressError> {
        let dress = Dress {
            before_lobe,
            reason,
            old_radius_mm: now.radius_mm,
            wear_mm: now.wear_mm,
            depth_mm: self.depth_mm,
            radius_nm: nm_from_mm(now.radius_mm - self.depth_mm - now.wear_mm),
        };
        let min_mm = machine.wheel_at(lobe.wheel_index(machine)).min_radius_mm;
        let lobe = || String::from(lobe.name);
        let radius_mm = dress.radius_mm();
        if radius_mm < min_mm {
            return Err(DressError::WornOut { lobe: lobe(), radius_mm, min_mm });
        }
        let depth_mm = self.depth_mm + now.wear_mm;
        match machine.dresser.map(|dresser| dresser.max_depth_mm) {
            Some(allowed_mm) if depth_mm > allowed_mm => {
                Err(DressError::TooDeep { lobe: lobe(), depth_mm, wear_mm: now.wear_mm, allowed_mm })
            }
            _ => Ok(dress),
        }
    }
}

/// Area between a contour and its blank, per width (mm²): by Steiner's formula length times stock and the area of a circle
/// of the stock; exact while the stock is less than the radius of every hollow.
#[must_use]
pub fn stock_area_mm2(contour: &Contour, stock_mm: f64) -> f64 {
    // The trapezoidal rule over a period: more exact than any digit that is printed.
    const STEPS: u32 = 3600;
    let step = TURN_RAD / f64::from(STEPS);
    // Negative in a bore: parallel curves inside of it become shorter.
    let length_mm: f64 = (0..STEPS).map(|i| contour.local(f64::from(i) * step).arc * step).sum();
    stock_mm * (length_mm + 0.5 * TURN_RAD * stock_mm).abs()
}

/// Largest distance from the contour, along its normal, of what a wheel of another radius grinds along a path (mm, positive
/// where material is left), and the cam angle there: what not making the path anew would cost.
///
/// The wheel is held with its cutting point on the path, as after a dress; the points it grinds are found backwards from the
/// path's direction, so it is the form error to all orders.
#[must_use]
pub fn kept_path_error(contour: &Contour, kept: &ToolPath, radius_mm: f64) -> Extremum {
    const STEPS: u32 = 3600;
    let wrong = kept.with_other_wheel(radius_mm);
    let mut worst = Extremum { value: 0.0, angle_rad: 0.0 };
    for i in 0..STEPS {
        let angle = f64::from(i) * TURN_RAD / f64::from(STEPS);
        let ground = wrong.contact(angle);
        let (error_mm, cam_angle) = contour.distance(ground.norm(), wrong.contact_azimuth(angle));
        if error_mm.abs() > worst.value.abs() {
            worst = Extremum { value: error_mm, angle_rad: wrap_turn(cam_angle) };
        }
    }
    worst
}

/// Error of keeping a path over a dress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetainedPath {
    /// Index of the profile on which the error is largest.
    pub profile: usize,
    /// The error along the contour's normal, positive where material would be left (mm), and its cam angle.
    pub error: Extremum,
}

/// A dress of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedDress {
    pub dress: Dress,
    /// The form error that the path of the radius before it would leave; `None` if there is none for a profile.
    pub kept_path: Option<RetainedPath>,
    /// The same for the path that the job began with.
    pub first_path: Option<RetainedPath>,
}

#[cfg(test)]
mod tests;
