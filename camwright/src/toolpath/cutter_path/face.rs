// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A cam by the flat face of an end mill whose axis is radial: the face is a tangent of the contour, so X over the azimuth of the axis is
//! the contour's support function, X(θ) = h(θ), and the face touches at h′(θ) beside its middle. A face lies across a hollow, so the
//! contour must be convex throughout; and what touches beside the face's rim is not cut, so the face must reach as far as h′ does.

use super::{CarriageAxis, CutterPath, Travel};
use crate::cam::contour::Contour;
use crate::math::extremum::smallest_over_turn;
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::units::{deg_from_rad, wrap_turn};
use crate::toolpath::wheel_path::{CHECK_DENSITY, CONTOUR_ERROR_MM, ToolPathError, angle_of, resample};
use alloc::string::String;
use thiserror::Error;

/// Why the face of a mill cannot make a contour.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FaceError {
    /// The radius of the face is not a positive number.
    #[error("the face of the mill has a radius of {face_radius_mm} mm; it must be a positive number")]
    BadRadius {
        /// Given value (mm).
        face_radius_mm: f64,
    },
    /// The stock left on the contour is not valid.
    #[error("{leaves_mm} mm cannot be left on a contour; it must be 0 or more")]
    BadStock {
        /// Given value (mm).
        leaves_mm: f64,
    },
    /// The contour has a hollow.
    #[error(
        "the contour is hollow at cam angle {angle_deg:.2} deg, where its curvature is {curvature_1_mm:.6} 1/mm; the face of a mill needs \
         more than {bound_1_mm} everywhere, its periphery does not"
    )]
    Hollow {
        /// Cam angle (deg).
        angle_deg: f64,
        /// Curvature there (1/mm).
        curvature_1_mm: f64,
        /// Lower bound, exclusive (1/mm).
        bound_1_mm: f64,
    },
    /// The face does not reach to where it would have to cut.
    #[error(
        "a face of radius {face_radius_mm} mm touches the contour {offset_mm:.3} mm beside its middle at azimuth {azimuth_deg:.2} deg; it must \
         stay below the radius"
    )]
    FaceTooSmall {
        /// Radius of the face (mm).
        face_radius_mm: f64,
        /// Distance of the contact from the mill's axis (mm).
        offset_mm: f64,
        /// Azimuth of the mill's axis there (deg).
        azimuth_deg: f64,
    },
    #[error(transparent)]
    Path(#[from] ToolPathError),
}

/// The path of an end mill that cuts with its face.
#[derive(Debug, Clone, PartialEq)]
pub struct FacePath {
    path: CutterPath,
    reach: FaceReach,
}

/// Required reach of a face on a contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceReach {
    /// Maximum distance of the contact from the middle of the face (mm).
    pub beside_mm: f64,
    /// Azimuth of the mill's axis there (rad).
    pub azimuth_rad: f64,
    /// Width along Z that a turn cuts everywhere (mm): the chord of the face there.
    pub width_mm: f64,
}

impl FacePath {
    /// The path on which a face makes a contour, or leaves so much on it along its normal.
    ///
    /// # Errors
    /// A hollow contour, a face that is too small, with figures and place; a path that is not smooth enough, or that the way back does
    /// not confirm.
    pub fn new(contour: &Contour, face_radius_mm: f64, leaves_mm: f64) -> Result<Self, FaceError> {
        let reach = Self::fits(contour, face_radius_mm, leaves_mm)?;
        let (support, _) = resample(|azimuth, guess| {
            let cam_angle = contour.cam_angle_of_normal(azimuth, azimuth + *guess);
            *guess = cam_angle - azimuth;
            contour.local(cam_angle).support() + leaves_mm
        })?;
        returns(&support, contour, leaves_mm)?;
        let travels = [Travel { axis: CarriageAxis::X, position: support.into() }].into();
        let path = CutterPath { name: String::from("contour"), travels, infeed: CarriageAxis::X };
        Ok(Self { path, reach })
    }

    /// Checks that a face can make a contour, and returns the required reach.
    ///
    /// # Errors
    /// A hollow contour, a face that is too small, with figures and place.
    pub fn fits(contour: &Contour, face_radius_mm: f64, leaves_mm: f64) -> Result<FaceReach, FaceError> {
        if !face_radius_mm.is_finite() || face_radius_mm <= 0.0 {
            return Err(FaceError::BadRadius { face_radius_mm });
        }
        if !leaves_mm.is_finite() || leaves_mm < 0.0 {
            return Err(FaceError::BadStock { leaves_mm });
        }
        let (grid, breaks) = (contour.lift().grid(), contour.lift().breaks());
        let flattest = smallest_over_turn(grid, &breaks, |angle| contour.local(angle).turning);
        if flattest.value.is_nan() || flattest.value <= MIN_TURNING {
            let (angle_deg, curvature_1_mm) = (deg_from_rad(flattest.angle_rad), contour.curvature(flattest.angle_rad));
            return Err(FaceError::Hollow { angle_deg, curvature_1_mm, bound_1_mm: 0.0 });
        }
        let farthest = smallest_over_turn(grid, &breaks, |angle| -contour.local(angle).beside().abs());
        let (beside_mm, azimuth_rad) = (-farthest.value, wrap_turn(contour.normal_angle(farthest.angle_rad)));
        if beside_mm.is_nan() || beside_mm >= face_radius_mm {
            let azimuth_deg = deg_from_rad(azimuth_rad);
            return Err(FaceError::FaceTooSmall { face_radius_mm, offset_mm: beside_mm, azimuth_deg });
        }
        let width_mm = 2.0 * libm::sqrt((face_radius_mm - beside_mm) * (face_radius_mm + beside_mm));
        Ok(FaceReach { beside_mm, azimuth_rad, width_mm })
    }

    /// The path: X of the face.
    #[must_use]
    pub fn path(&self) -> &CutterPath {
        &self.path
    }

    /// Required reach of the face.
    #[must_use]
    pub fn reach(&self) -> FaceReach {
        self.reach
    }
}

/// Rate dω/dφ at which a contour is as good as straight: its contact would run along it without the mill moving.
const MIN_TURNING: f64 = 1e-6;

/// Goes back from the path to the contour: the face touches at (X, X′), along and square to the mill's axis.
fn returns(support: &PeriodicSpline, contour: &Contour, leaves_mm: f64) -> Result<(), ToolPathError> {
    let count = CHECK_DENSITY * support.coefficients().len();
    for i in 0..count {
        let azimuth = angle_of(i, count);
        let x = support.sample(azimuth);
        let (off_mm, _) = contour.distance(libm::hypot(x.value, x.first), azimuth + libm::atan2(x.first, x.value));
        let error_mm = (off_mm - leaves_mm).abs();
        if error_mm.is_nan() || error_mm > CONTOUR_ERROR_MM {
            let angle_deg = deg_from_rad(azimuth);
            return Err(ToolPathError::LeavesContour { error_mm, angle_deg, bound_mm: CONTOUR_ERROR_MM });
        }
    }
    Ok(())
}
