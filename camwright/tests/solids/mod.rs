// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Surfaces of parts for tests: the closed forms, a cam along z, meshes of them, and seeded random ones.
#![allow(dead_code, reason = "each test binary uses its part")]

use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::LiftLaw;
use camwright::cam::surface::Surface;
use camwright::cam::surface::cams::CamAlong;
use camwright::cam::surface::mesh::Triangle;
use camwright::cam::surface::solid::{Harmonic, LinearInZ, Solid};
use camwright::math::units::TURN_RAD;

pub(crate) const CYLINDER: Solid = Solid::Cylinder { radius_mm: 20.0 };
pub(crate) const ECCENTRIC: Solid = Solid::Eccentric { radius_mm: 21.0, eccentricity_mm: 2.5, azimuth_rad: 0.7 };
pub(crate) const ELLIPTIC_CONE: Solid = Solid::EllipticCone {
    first_mm: LinearInZ { at_zero: 24.0, per_mm: -0.1 },
    second_mm: LinearInZ { at_zero: 21.0, per_mm: -0.06 },
    azimuth_rad: 0.3,
};

pub(crate) fn solid(solid: Solid) -> Surface {
    Surface::solid(solid, 0.0, 20.0).expect("a solid of a workshop")
}

/// Base radius 20, lift h/2·(1 + cos a) under a knife edge: the raised cosine as the radius itself.
pub(crate) fn raised_cosine(lift_mm: f64) -> Contour {
    let lift = LiftLaw::eccentric_flat(0.5 * lift_mm, 0.0).expect("a lift");
    Contour::from_lift(&lift, &Follower::KnifeEdge { offset_mm: 0.0 }, 20.0).expect("a contour")
}

/// The three-dimensional cam of the comparison: lift 4.5 mm from 0 to 6 mm, 3 mm and 25° on from 16 to 22 mm.
pub(crate) fn cam_along_z() -> Surface {
    let (first, second) = (raised_cosine(4.5), raised_cosine(3.0));
    let cams = [
        CamAlong { contour: &first, phase_rad: 0.0, from_mm: 0.0, to_mm: 6.0 },
        CamAlong { contour: &second, phase_rad: 25.0_f64.to_radians(), from_mm: 16.0, to_mm: 22.0 },
    ];
    Surface::cams(&cams).expect("two cams")
}

/// Lift 1 mm from 0 to 4 mm, 4.5 mm and 17° on from 9 to 13 mm: the blend is hollower than an insert of 8 mm, which goes over a crest there.
pub(crate) fn low_and_high_cam() -> Surface {
    let (low, high) = (raised_cosine(1.0), raised_cosine(4.5));
    let cams = [
        CamAlong { contour: &low, phase_rad: 0.5, from_mm: 0.0, to_mm: 4.0 },
        CamAlong { contour: &high, phase_rad: 0.8, from_mm: 9.0, to_mm: 13.0 },
    ];
    Surface::cams(&cams).expect("two cams")
}

/// Triangles with their corners on a surface, `angles` a turn from `phase_rad` on, in `bands` along z, with both end faces.
pub(crate) fn mesh_of(surface: &Surface, angles: u32, bands: u32, phase_rad: f64) -> Vec<Triangle> {
    let (from, to) = surface.ends_mm();
    let corner = |i: u32, k: u32| {
        let azimuth = phase_rad + f64::from(i % angles) * TURN_RAD / f64::from(angles);
        let z = from + (to - from) * f64::from(k) / f64::from(bands);
        let radius = surface.radius(azimuth, z);
        [radius * azimuth.cos(), radius * azimuth.sin(), z]
    };
    let mut triangles = Vec::new();
    for i in 0..angles {
        for k in 0..bands {
            let (a, b, c, d) = (corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([[0.0, 0.0, from], corner(i + 1, 0), corner(i, 0)]);
        triangles.push([[0.0, 0.0, to], corner(i, bands), corner(i + 1, bands)]);
    }
    triangles
}

/// Waves that leave a radius of at least some 15 mm and slopes that a tool at 45° cuts.
pub(crate) fn random_lobed(mut within: impl FnMut(f64, f64) -> f64) -> Solid {
    let harmonics = (1..=4).map(|waves| Harmonic {
        waves,
        amplitude_mm: LinearInZ { at_zero: within(-1.0, 1.0) / f64::from(waves), per_mm: within(-0.01, 0.01) },
        phase_rad: LinearInZ { at_zero: within(-3.0, 3.0), per_mm: within(-0.02, 0.02) },
    });
    let harmonics = harmonics.collect();
    Solid::Lobed { mean_mm: LinearInZ { at_zero: within(19.0, 24.0), per_mm: within(-0.05, 0.05) }, harmonics }
}
