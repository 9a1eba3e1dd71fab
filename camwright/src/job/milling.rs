// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Milling job for a foreign machine: cams and grooves of one part by one mill.

use crate::cam::contour::Contour;
use crate::toolpath::cutter_path::CutterPath;
use crate::toolpath::cutter_path::face::{FaceError, FacePath};
use crate::toolpath::groove::barrel::{BarrelCutter, BarrelGroove};
use crate::toolpath::groove::plate::PlateGroove;
use crate::toolpath::groove::{Coverage, GrooveError};
use crate::toolpath::wheel_path::{ToolPath, ToolPathError};
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

/// Part of a mill that makes cams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutsWith {
    Periphery,
    Face,
}

/// Direction of a mill's axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MillAxis {
    /// Parallel to the part's: for cams by the periphery, and grooves in plates.
    Parallel,
    /// Along X: for cams by the face, and grooves round a cylinder.
    Radial,
}

impl MillAxis {
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            MillAxis::Parallel => "parallel to the part's",
            MillAxis::Radial => "radial",
        }
    }
}

impl CutsWith {
    /// Direction of the mill's axis when it makes a cam.
    #[must_use]
    pub const fn axis(self) -> MillAxis {
        match self {
            CutsWith::Periphery => MillAxis::Parallel,
            CutsWith::Face => MillAxis::Radial,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct MillingTool {
    /// Its number in the control.
    pub number: u32,
    /// Part of it that makes cams.
    pub cuts_with: CutsWith,
    /// Radius (mm).
    pub radius_mm: f64,
    /// Speed of its spindle (rad/s).
    pub spindle_speed_rad_s: f64,
    /// Description for the operator.
    pub text: String,
}

/// A cam on the part.
#[derive(Debug, Clone, PartialEq)]
pub struct MilledCam {
    pub name: String,
    pub contour: Contour,
    /// Phase α: from the keyway to cam angle 0 (rad).
    pub phase_rad: f64,
    /// Position of the mill along the part (mm).
    pub z_mm: f64,
    /// Width along the part (mm), where the job says it: a face must reach over it.
    pub width_mm: Option<f64>,
}

/// Kind of groove.
#[allow(clippy::large_enum_variant, reason = "a job has a handful of them")]
#[derive(Debug, Clone, PartialEq)]
pub enum GrooveKind {
    /// In the face of a plate.
    Plate {
        groove: PlateGroove,
        /// z of that face, from which it goes down along −Z (mm).
        top_mm: f64,
        /// Depth (mm).
        depth_mm: f64,
    },
    Barrel {
        /// Its walls, surface and floor.
        groove: BarrelGroove,
        /// z of the roller at lift 0 (mm).
        z_mm: f64,
        /// The machine can shift the mill across.
        y_axis: bool,
    },
}

/// A groove on the part.
#[derive(Debug, Clone, PartialEq)]
pub struct MilledGroove {
    pub name: String,
    pub kind: GrooveKind,
    /// Phase α: from the keyway to cam angle 0 (rad).
    pub phase_rad: f64,
    /// Most that the mill goes down at a time (mm).
    pub step_mm: f64,
}

/// A time round everything.
#[derive(Debug, Clone, PartialEq)]
pub struct MillingPass {
    pub name: String,
    /// Stock left on contours and walls, along their normals (mm).
    pub leaves_mm: f64,
    /// Speed of the part (rad/s).
    pub work_speed_rad_s: f64,
    /// Most that a program may be off the path (mm).
    pub tolerance_mm: f64,
    /// Turns at each depth.
    pub turns: u32,
}

/// A part to be milled.
#[derive(Debug, Clone, PartialEq)]
pub struct MillingJob {
    pub name: String,
    pub tool: MillingTool,
    /// Cams, in the order in which they are made.
    pub cams: Vec<MilledCam>,
    /// Grooves, in the order in which they are made.
    pub grooves: Vec<MilledGroove>,
    /// Passes, in their order.
    pub passes: Vec<MillingPass>,
    /// Clearance of the mill from the part in its moves (mm).
    pub clearance_mm: f64,
    /// Radius of the blank where cams are milled (mm); `None`: turned to the largest radius of each.
    pub blank_radius_mm: Option<f64>,
}

/// Why a mill cannot make a cam or a groove.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MillingError {
    #[error(transparent)]
    Periphery(#[from] ToolPathError),
    #[error(transparent)]
    Face(#[from] FaceError),
    /// A face that is too narrow where it touches far from its middle.
    #[error("a turn of the face of {face_radius_mm} mm cuts {cuts_mm:.3} mm along Z; the cam is {width_mm} mm wide")]
    FaceTooNarrow {
        /// Radius of the face (mm).
        face_radius_mm: f64,
        /// Smallest depth of cut (mm).
        cuts_mm: f64,
        /// Width of the cam (mm).
        width_mm: f64,
    },
    #[error(transparent)]
    Groove(#[from] GrooveError),
}

impl MillingTool {
    /// Checks that it can make a cam, without computing its path.
    ///
    /// # Errors
    /// What stands against it, with figures and place.
    pub fn fits_cam(&self, cam: &MilledCam, leaves_mm: f64) -> Result<(), MillingError> {
        match self.cuts_with {
            CutsWith::Periphery => Ok(ToolPath::fits(&cam.contour, self.radius_mm + leaves_mm)?),
            CutsWith::Face => {
                let cuts_mm = FacePath::fits(&cam.contour, self.radius_mm, leaves_mm)?.width_mm;
                match cam.width_mm {
                    Some(width_mm) if width_mm > cuts_mm => {
                        Err(MillingError::FaceTooNarrow { face_radius_mm: self.radius_mm, cuts_mm, width_mm })
                    }
                    _ => Ok(()),
                }
            }
        }
    }

    /// Its path round a cam, with so much left along the contour's normal.
    ///
    /// # Errors
    /// A contour that it cannot make, with figures and place.
    pub fn cam_path(&self, cam: &MilledCam, leaves_mm: f64) -> Result<CutterPath, MillingError> {
        self.fits_cam(cam, leaves_mm)?;
        match self.cuts_with {
            CutsWith::Periphery => {
                Ok(CutterPath::from_periphery(&ToolPath::for_wheel(&cam.contour, self.radius_mm + leaves_mm)?))
            }
            CutsWith::Face => Ok(FacePath::new(&cam.contour, self.radius_mm, leaves_mm)?.path().clone()),
        }
    }

    /// Checks that it fits into a groove, without computing its paths.
    ///
    /// # Errors
    /// What stands against it, with figures.
    pub fn fits_groove(&self, groove: &MilledGroove, leaves_mm: f64, coverage: Coverage) -> Result<(), MillingError> {
        Ok(match &groove.kind {
            GrooveKind::Plate { groove, .. } => groove.fits(self.radius_mm, leaves_mm, coverage),
            GrooveKind::Barrel { groove, .. } => groove.fits(self.radius_mm, leaves_mm, coverage),
        }?)
    }

    /// Its paths in a groove at full depth, with so much left on each wall.
    ///
    /// # Errors
    /// A groove that it cannot make, with figures and place.
    pub fn groove_paths(
        &self,
        groove: &MilledGroove,
        leaves_mm: f64,
        coverage: Coverage,
    ) -> Result<Vec<CutterPath>, MillingError> {
        Ok(match &groove.kind {
            GrooveKind::Plate { groove, .. } => groove.paths(self.radius_mm, leaves_mm, coverage),
            GrooveKind::Barrel { groove, y_axis, .. } => {
                groove.paths(BarrelCutter { radius_mm: self.radius_mm, y_axis: *y_axis }, leaves_mm, coverage)
            }
        }?)
    }
}

impl MilledGroove {
    /// Direction of the mill's axis.
    #[must_use]
    pub const fn axis(&self) -> MillAxis {
        match self.kind {
            GrooveKind::Plate { .. } => MillAxis::Parallel,
            GrooveKind::Barrel { .. } => MillAxis::Radial,
        }
    }

    /// Its depth (mm).
    #[must_use]
    pub fn depth_mm(&self) -> f64 {
        match &self.kind {
            GrooveKind::Plate { depth_mm, .. } => *depth_mm,
            GrooveKind::Barrel { groove, .. } => groove.outer_radius_mm() - groove.floor_radius_mm(),
        }
    }

    /// Remaining depth after every step down (mm): equal steps no larger than the job allows; the last is 0.
    #[must_use]
    pub fn steps_mm(&self) -> Vec<f64> {
        let depth_mm = self.depth_mm();
        // A step that fits but for rounding fits.
        let steps = libm::ceil(depth_mm / self.step_mm - 1e-9).clamp(1.0, f64::from(MAX_STEPS));
        (1..=MAX_STEPS)
            .map(f64::from)
            .take_while(|step| *step <= steps)
            .map(|step| depth_mm * (steps - step) / steps)
            .collect()
    }
}

pub const MAX_STEPS: u32 = 1000;
