// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Surfaces of parts against closed forms and differences, and what is none.

use crate::cams;
use crate::solids;

use cams::SplitMix64;
use camwright::cam::contour::Contour;
use camwright::cam::surface::cams::CamAlong;
use camwright::cam::surface::grid::SurfaceGrid;
use camwright::cam::surface::mesh::{Triangle, cut_by_rake_plane, surface_of};
use camwright::cam::surface::solid::{Harmonic, LinearInZ, Solid};
use camwright::cam::surface::{Surface, SurfaceError};
use camwright::math::units::TURN_RAD;
use solids::{CYLINDER, ECCENTRIC, ELLIPTIC_CONE, cam_along_z, mesh_of, raised_cosine, random_lobed, solid};

fn places(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..397_u32).map(move |i| (f64::from(i) * 0.37 - 40.0, from + (to - from) * f64::from(i * 31 % 397) / 396.0))
}

/// Derivatives against central differences; `step` trades their error h²f‴/6 for rounding.
fn derivatives_agree(surface: &Surface, allowed: f64, what: &str) {
    let h = 1e-4;
    let (from, to) = surface.ends_mm();
    for (a, z) in places(from + h, to - h) {
        let point = surface.point(a, z);
        let (right, left) = (surface.point(a + h, z), surface.point(a - h, z));
        let (up, down) = (surface.point(a, z + h), surface.point(a, z - h));
        for (found, high, low) in [
            (point.by_azimuth, right.radius_mm, left.radius_mm),
            (point.by_z, up.radius_mm, down.radius_mm),
            (point.by_azimuth_twice, right.by_azimuth, left.by_azimuth),
            (point.by_azimuth_and_z, right.by_z, left.by_z),
            (point.by_azimuth_and_z, up.by_azimuth, down.by_azimuth),
            (point.by_z_twice, up.by_z, down.by_z),
        ] {
            let wanted = (high - low) / (2.0 * h);
            assert!((found - wanted).abs() < allowed * (1.0 + wanted.abs()), "{what} at {a} {z}: {found} {wanted}");
        }
    }
}

#[test]
fn solids_have_the_radii_of_their_formulas() {
    let (eccentric, cone) = (solid(ECCENTRIC), solid(ELLIPTIC_CONE));
    for (azimuth, z) in places(0.0, 20.0) {
        assert!((solid(CYLINDER).radius(azimuth, z) - 20.0).abs() < 1e-15);
        // A point of the disc is 21 mm from its centre.
        let (r, at) = (eccentric.radius(azimuth, z), azimuth - 0.7);
        assert!((libm::hypot(r * at.cos() - 2.5, r * at.sin()) - 21.0).abs() < 1e-12, "{azimuth}");
        // (x/a)² + (y/b)² = 1.
        let (r, at) = (cone.radius(azimuth, z), azimuth - 0.3);
        let (a, b) = (24.0 - 0.1 * z, 21.0 - 0.06 * z);
        assert!(((r * at.cos() / a).powi(2) + (r * at.sin() / b).powi(2) - 1.0).abs() < 1e-13, "{azimuth}");
    }
}

#[test]
fn derivatives_of_every_kind_are_those_of_differences() {
    derivatives_agree(&solid(CYLINDER), 1e-6, "cylinder");
    derivatives_agree(&solid(ECCENTRIC), 1e-6, "eccentric");
    derivatives_agree(&solid(ELLIPTIC_CONE), 1e-6, "elliptic cone");
    derivatives_agree(&cam_along_z(), 1e-5, "cams");
    let mut random = SplitMix64(5);
    for _ in 0..20 {
        derivatives_agree(&solid(random_lobed(|low, high| random.within(low, high))), 1e-5, "lobed, seed 5");
    }
    let cone = solid(ELLIPTIC_CONE);
    let z: Vec<f64> = [0.0, 1.0, 2.5, 3.0, 5.0, 6.0, 11.0, 12.5, 20.0].to_vec();
    let grid = Surface::grid(&SurfaceGrid::sampled(72, z, |azimuth, z| cone.radius(azimuth, z))).unwrap();
    // The third derivative along z jumps at a row, where a difference sees its mean.
    derivatives_agree(&grid, 1e-4, "grid");
}

/// Quintics round the turn and cubics along z: r = 20 + cos 2φ · (1 + z − z³/300) comes back but for h⁶ of the cosine.
#[test]
fn a_grid_gives_back_what_it_was_sampled_from() {
    let r = |azimuth: f64, z: f64| 20.0 + (2.0 * azimuth).cos() * (1.0 + 0.1 * z - z * z * z / 3000.0);
    for z in [vec![0.0, 1.0, 4.0, 5.5, 9.0, 12.0], (0..30).map(|k| f64::from(k) * 0.5).collect()] {
        let (from, to) = (z[0], z[z.len() - 1]);
        let surface = Surface::grid(&SurfaceGrid::sampled(180, z, r)).unwrap();
        assert_eq!(surface.ends_mm(), (from, to));
        for (azimuth, z) in places(from, to) {
            assert!((surface.radius(azimuth, z) - r(azimuth, z)).abs() < 1e-9, "{azimuth} {z}");
            assert!((surface.radius(azimuth + TURN_RAD, z) - surface.radius(azimuth, z)).abs() < 1e-11);
        }
        // Beyond its ends it goes on along its tangent.
        let end = surface.point(0.4, to);
        let beyond = surface.point(0.4, to + 2.0);
        assert!((beyond.radius_mm - end.radius_mm - 2.0 * end.by_z).abs() < 1e-12 && beyond.by_z_twice == 0.0);
    }
}

#[test]
fn a_grid_of_a_cylinder_is_exactly_the_cylinder() {
    let grid = SurfaceGrid::sampled(36, vec![-3.0, 0.0, 9.0], |_, _| 17.3);
    let surface = Surface::grid(&grid).unwrap();
    for (azimuth, z) in places(-10.0, 20.0) {
        assert_eq!(surface.radius(azimuth, z).to_bits(), 17.3_f64.to_bits());
    }
}

/// A grid that begins anywhere and repeats its first column after a turn is the same surface.
#[test]
fn a_closing_column_adds_no_data() {
    let cone = solid(ELLIPTIC_CONE);
    let z = vec![0.0, 5.0, 10.0, 20.0];
    let plain = Surface::grid(&SurfaceGrid::sampled(90, z.clone(), |a, z| cone.radius(a, z))).unwrap();
    let azimuths_rad: Vec<f64> = (0..=90).map(|i| (f64::from(i) + 20.0) * TURN_RAD / 90.0).collect();
    let radii_mm = z.iter().flat_map(|z| azimuths_rad.iter().map(|a| cone.radius(*a, *z))).collect();
    let mut closing = SurfaceGrid { azimuths_rad, z_mm: z, radii_mm };
    let surface = Surface::grid(&closing).unwrap();
    for (azimuth, z) in places(0.0, 20.0) {
        assert!((surface.radius(azimuth, z) - plain.radius(azimuth, z)).abs() < 1e-11);
    }
    closing.radii_mm[90] += 0.004;
    assert!(matches!(
        Surface::grid(&closing),
        Err(SurfaceError::NotClosed { row: 0, gap_mm, .. }) if (gap_mm - 0.004).abs() < 1e-9
    ));
}

/// Each cam has its contour, turned to its phase; between them the radius goes from one to the other without a jump in slope or bend.
#[test]
fn cams_along_z_are_their_contours_and_blend_smoothly() {
    let surface = cam_along_z();
    let (first, second) = (raised_cosine(4.5), raised_cosine(3.0));
    let phase = 25.0_f64.to_radians();
    for (azimuth, _) in places(0.0, 1.0) {
        let (a, b) = (first.radius_at(azimuth), second.radius_at(azimuth - phase));
        for z in [-3.0, 0.0, 3.0, 6.0] {
            assert!((surface.radius(azimuth, z) - a).abs() < 1e-8, "{azimuth} {z}");
        }
        for z in [16.0, 22.0, 30.0] {
            assert!((surface.radius(azimuth, z) - b).abs() < 1e-8, "{azimuth} {z}");
        }
        assert!((surface.radius(azimuth, 11.0) - 0.5 * (a + b)).abs() < 1e-8);
        for z in [6.0, 16.0] {
            let (below, above) = (surface.point(azimuth, z - 1e-9), surface.point(azimuth, z + 1e-9));
            assert!((above.by_z - below.by_z).abs() < 1e-7 && (above.by_z_twice - below.by_z_twice).abs() < 1e-7);
        }
    }
}

/// The corners of the mesh lie on the solid, so the surface through them is the solid, within the resolution of the mesh.
#[test]
fn a_mesh_is_read_as_the_solid_its_corners_lie_on() {
    for (kind, solid, phase, allowed) in [
        ("cylinder", solid(CYLINDER), 0.0, 1e-9),
        ("eccentric", solid(ECCENTRIC), 0.0, 1e-8),
        ("elliptic cone", solid(ELLIPTIC_CONE), 0.0, 1e-7),
        ("elliptic cone between the nodes", solid(ELLIPTIC_CONE), 0.011, 1e-5),
        ("cams", cam_along_z(), 0.0, 2e-3),
    ] {
        let triangles = mesh_of(&solid, 180, 20, phase);
        let (surface, reading) = surface_of(&triangles).unwrap();
        assert_eq!((reading.triangles, reading.left_out, reading.grid), (7200, 360, (180, 21)), "{kind}");
        assert!(reading.corners_off_mm < 1e-6, "{kind}: {reading:?}");
        // A chord of 2° on 20 mm cuts off 3 µm, at the middle of a triangle two thirds of it.
        assert!(reading.faces_off_mm > 1e-3 && reading.faces_off_mm < 2e-2, "{kind}: {reading:?}");
        let (from, to) = solid.ends_mm();
        for (azimuth, z) in places(from, to) {
            let off = (surface.radius(azimuth, z) - solid.radius(azimuth, z)).abs();
            assert!(off < allowed, "{kind} at {azimuth} {z}: {off}");
        }
    }
}

/// The flat faces cut by the rake plane lie on the section of the solid but for what their chords cut off.
#[test]
fn triangles_cut_by_the_rake_plane_lie_on_the_section() {
    let cone = solid(ELLIPTIC_CONE);
    let triangles = mesh_of(&cone, 360, 20, 0.0);
    let mut max = 0.0_f64;
    for turned in [0.0, 0.5, 2.0, 4.0] {
        let cuts = cut_by_rake_plane(&triangles, turned, -14.0);
        assert!(cuts.len() >= 40, "{}", cuts.len());
        // End faces are cut too, across the part.
        for [x, z] in cuts.into_iter().flatten().filter(|[x, z]| *x > 0.0 && *z > 1e-6 && *z < 20.0 - 1e-6) {
            max = max.max((cone.radius(libm::atan2(-14.0, x) + turned, z) - libm::hypot(x, 14.0)).abs());
        }
    }
    assert!(max > 1e-4 && max < 5e-3, "{max}");
}

#[test]
fn bounds_hold_everywhere_and_are_near() {
    let mut random = SplitMix64(77);
    for round in 0..40 {
        let surface = solid(random_lobed(|low, high| random.within(low, high)));
        let bounds = surface.bounds(0.0, 20.0);
        let (mut min, mut largest, mut ratio) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for (azimuth, z) in places(0.0, 20.0) {
            let point = surface.point(azimuth, z);
            (min, largest) = (min.min(point.radius_mm), largest.max(point.radius_mm));
            ratio = ratio.max(point.by_azimuth.abs() / point.radius_mm);
            assert!(point.by_azimuth.abs() <= bounds.steepest_mm_rad && point.by_z.abs() <= bounds.steepest_along);
        }
        assert!(min >= bounds.min_mm && min < bounds.min_mm + 0.2, "seed 77, {round}: {min} {bounds:?}");
        assert!(largest <= bounds.largest_mm && largest > bounds.largest_mm - 0.2, "seed 77, {round}");
        assert!(ratio <= bounds.steepest_ratio, "seed 77, {round}");
    }
}

#[test]
fn solids_that_are_none_are_refused() {
    let refused = |solid: Solid| Surface::solid(solid, 0.0, 20.0).unwrap_err();
    let along = LinearInZ::constant;
    for radius_mm in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        assert!(matches!(refused(Solid::Cylinder { radius_mm }), SurfaceError::BadNumber { .. }), "{radius_mm}");
    }
    for eccentricity_mm in [-0.1, 20.0, 25.0, f64::NAN] {
        let error = refused(Solid::Eccentric { radius_mm: 20.0, eccentricity_mm, azimuth_rad: 0.0 });
        assert!(matches!(error, SurfaceError::BadNumber { .. }), "{error}");
    }
    // The cone ends in its tip at z = 15.
    let tip = LinearInZ { at_zero: 15.0, per_mm: -1.0 };
    let error = refused(Solid::EllipticCone { first_mm: tip, second_mm: along(20.0), azimuth_rad: 0.0 });
    assert!(matches!(error, SurfaceError::ReachesAxis { .. }), "{error}");
    let wave = |waves, amplitude| Harmonic { waves, amplitude_mm: along(amplitude), phase_rad: along(0.0) };
    let lobed = |wave| Solid::Lobed { mean_mm: along(10.0), harmonics: vec![wave] };
    assert!(matches!(refused(lobed(wave(0, 1.0))), SurfaceError::BadNumber { .. }));
    assert!(matches!(refused(lobed(wave(100_000, 1.0))), SurfaceError::BadNumber { .. }));
    assert!(matches!(refused(lobed(wave(3, f64::NAN))), SurfaceError::BadNumber { .. }));
    let error = refused(lobed(wave(3, 10.0)));
    assert!(matches!(error, SurfaceError::ReachesAxis { azimuth_deg, .. } if (azimuth_deg % 120.0 - 60.0).abs() < 1.0));
    for (from, to) in [(0.0, 0.0), (5.0, 1.0)] {
        assert!(matches!(Surface::solid(CYLINDER, from, to), Err(SurfaceError::NoLength { .. })));
    }
    for (from, to) in [(f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert!(matches!(Surface::solid(CYLINDER, from, to), Err(SurfaceError::BadNumber { .. })));
    }
}

#[test]
fn grids_that_are_none_are_refused() {
    let good = SurfaceGrid::sampled(36, vec![0.0, 1.0, 2.0, 3.0], |_, _| 10.0);
    let refused = |change: &dyn Fn(&mut SurfaceGrid)| {
        let mut grid = good.clone();
        change(&mut grid);
        Surface::grid(&grid).unwrap_err()
    };
    assert!(matches!(refused(&|g| g.radii_mm.truncate(100)), SurfaceError::GridSize { wanted: 144, count: 100, .. }));
    assert!(matches!(
        refused(&|g| *g = SurfaceGrid::sampled(5, vec![0.0, 1.0], |_, _| 9.0)),
        SurfaceError::Count { .. }
    ));
    assert!(matches!(refused(&|g| *g = SurfaceGrid::sampled(36, vec![0.0], |_, _| 9.0)), SurfaceError::Count { .. }));
    for bad in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        let error = refused(&|g| g.radii_mm[40] = bad);
        assert!(
            matches!(error, SurfaceError::BadRadius { row: 1, azimuth_deg, .. } if (azimuth_deg - 40.0).abs() < 1e-9)
        );
    }
    assert!(matches!(refused(&|g| g.z_mm[2] = 1.0), SurfaceError::ZNotIncreasing { row: 2, .. }));
    assert!(matches!(refused(&|g| g.z_mm[2] = f64::NAN), SurfaceError::BadNumber { .. }));
    assert!(matches!(refused(&|g| g.azimuths_rad[7] += 0.01), SurfaceError::UnevenAzimuth { column: 7, .. }));
    assert!(matches!(refused(&|g| g.azimuths_rad[0] = f64::NAN), SurfaceError::UnevenAzimuth { .. }));
    // Positive figures with a spline between them that is not.
    let error = refused(&|g| g.radii_mm[36..72].fill(1e-3));
    assert!(matches!(error, SurfaceError::ReachesAxis { .. }), "{error}");
}

#[test]
fn cams_that_overlap_are_refused() {
    let contour = raised_cosine(4.5);
    let cam = |contour, from_mm, to_mm| CamAlong { contour, phase_rad: 0.0, from_mm, to_mm };
    let refused = |cams: &[CamAlong<'_>]| Surface::cams(cams).unwrap_err();
    assert!(matches!(refused(&[]), SurfaceError::Count { .. }));
    assert!(matches!(refused(&[cam(&contour, 5.0, 1.0)]), SurfaceError::NoLength { .. }));
    let (a, b): (&Contour, &Contour) = (&contour, &contour);
    assert!(matches!(refused(&[cam(a, 0.0, 5.0), cam(b, 4.0, 9.0)]), SurfaceError::ZNotIncreasing { row: 1, .. }));
    assert!(matches!(refused(&[cam(a, f64::NAN, 5.0)]), SurfaceError::BadNumber { .. }));
}

#[test]
fn meshes_that_are_no_turned_part_are_refused() {
    let cone = solid(ELLIPTIC_CONE);
    let good = mesh_of(&cone, 60, 8, 0.0);
    let refused = |triangles: &[Triangle]| surface_of(triangles).map(|(_, reading)| reading).unwrap_err();
    assert!(matches!(refused(&[]), SurfaceError::Count { count: 0, .. }));
    let mut bad = good.clone();
    bad[17][1][2] = f64::NAN;
    assert!(matches!(refused(&bad), SurfaceError::BadNumber { .. }));
    let mut open = good.clone();
    open.remove(40);
    assert!(matches!(refused(&open), SurfaceError::OpenMesh { share } if (share - 1.0 + 1.0 / 960.0).abs() < 1e-9));
    open.drain(40..80);
    assert!(matches!(refused(&open), SurfaceError::Hole { .. }), "{:?}", refused(&open));
    // A bore.
    let mut bored = good.clone();
    bored.extend(mesh_of(&solid(Solid::Cylinder { radius_mm: 8.0 }), 60, 8, 0.0));
    assert!(matches!(refused(&bored), SurfaceError::TwoRadii { .. }));
    let flat: Vec<Triangle> = good.iter().map(|triangle| triangle.map(|[x, y, _]| [x, y, 1.0])).collect();
    assert!(matches!(refused(&flat), SurfaceError::NoLength { .. }));
    let mut through = good.clone();
    through.push([[0.0, 0.0, 3.0], [5.0, 0.0, 4.0], [0.0, 5.0, 4.0]]);
    assert!(matches!(refused(&through), SurfaceError::ReachesAxis { .. }));
    // Anything at all is answered, not panicked over.
    let mut random = SplitMix64(11);
    for round in 0..300_u32 {
        let triangles: Vec<Triangle> =
            (0..4 + round % 60).map(|_| [(); 3].map(|()| [(); 3].map(|()| random.within(-30.0, 30.0)))).collect();
        assert!(surface_of(&triangles).is_err(), "seed 11, {round}");
    }
}
