// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sections of the rake plane and paths of the insert against closed forms, and against sections found by other arithmetic.
#![allow(clippy::print_stdout, reason = "the figures of what must be shown")]

use crate::cams;
use crate::solids;

use cams::SplitMix64;
use camwright::cam::surface::Surface;
use camwright::cam::surface::mesh::surface_of;
use camwright::cam::surface::solid::{Harmonic, LinearInZ, Solid};
use camwright::machine::description::MotionLimits;
use camwright::math::units::TURN_RAD;
use camwright::toolpath::insert_path::{
    AxisLimits, InsertFeed, InsertPath, InsertPathError, Passes, PathRequest, SpeedBound, ZLaw,
};
use camwright::toolpath::rake_section::{RakeSection, RakeSectionError};
use solids::{CYLINDER, ECCENTRIC, ELLIPTIC_CONE, cam_along_z, mesh_of, random_lobed, solid};

/// H at 45° of a base radius of 20 mm.
const Y: f64 = -14.142_135_623_730_951;

fn request(from_mm: f64, to_mm: f64) -> PathRequest {
    PathRequest {
        insert_radius_mm: 6.0,
        plane_y_mm: Y,
        from_mm,
        to_mm,
        feed: InsertFeed::AlongZ(0.4),
        angles: 360,
        start_rad: 0.3,
        stock_mm: 0.0,
    }
}

/// x of the section as a formula of (θ, z, y₀), written for each solid by itself.
type Formula = fn(f64, f64, f64) -> f64;

fn cylinder(_: f64, _: f64, y: f64) -> f64 {
    (400.0 - y * y).sqrt()
}

/// The disc's centre stands at azimuth 0.7 − θ.
fn eccentric(turned: f64, _: f64, y: f64) -> f64 {
    let (x0, y0) = (2.5 * (0.7 - turned).cos(), 2.5 * (0.7 - turned).sin());
    x0 + (441.0 - (y - y0) * (y - y0)).sqrt()
}

/// (x cos δ − y sin δ)²/a² + (x sin δ + y cos δ)²/b² = 1 with δ = θ − 0.3, solved for x.
fn elliptic_cone(turned: f64, z: f64, y: f64) -> f64 {
    let (sin, cos) = (turned - 0.3).sin_cos();
    let (a, b) = ((24.0 - 0.1 * z).powi(-2), (21.0 - 0.06 * z).powi(-2));
    let (p, q, r) =
        (a * cos * cos + b * sin * sin, 2.0 * y * sin * cos * (b - a), y * y * (a * sin * sin + b * cos * cos) - 1.0);
    (-q + (q * q - 4.0 * p * r).sqrt()) / (2.0 * p)
}

/// The two raised cosines with their blend, and x from outside by steps of 0.25 mm and bisection.
fn cam(turned: f64, z: f64, y: f64) -> f64 {
    let u = ((z - 6.0) / 10.0).clamp(0.0, 1.0);
    let w = u * u * u * (10.0 + u * (6.0 * u - 15.0));
    let radius = |azimuth: f64| {
        let (a, b) = (2.25 * (1.0 + azimuth.cos()), 1.5 * (1.0 + (azimuth - 25.0_f64.to_radians()).cos()));
        20.0 + (1.0 - w) * a + w * b
    };
    let inside = |x: f64| x.hypot(y) < radius(y.atan2(x) + turned);
    let mut high = 25.0;
    while !inside(high - 0.25) {
        high -= 0.25;
    }
    let mut low = high - 0.25;
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if inside(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Least distance of the section from a point: all z within 1.5 R by steps, then by thirds around the nearest.
fn distance(section: impl Fn(f64) -> f64, x: f64, z: f64, reach: f64) -> f64 {
    let at = |k: u32| z + reach * 1.5 * (f64::from(k) / 75.0 - 1.0);
    let far = |z1: f64| (section(z1) - x).hypot(z1 - z);
    let nearest = (0..=150).min_by(|a, b| far(at(*a)).total_cmp(&far(at(*b)))).expect("a range that is not empty");
    let (mut low, mut high) = (at(nearest) - 0.02 * reach, at(nearest) + 0.02 * reach);
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if far(low + third) < far(high - third) { high -= third } else { low += third }
    }
    far(0.5 * (low + high))
}

/// At angles that are not knots, all over the path.
fn keeps_its_distance(surface: &Surface, formula: Formula, request: &PathRequest, what: &str) -> InsertPath {
    let path = InsertPath::new(surface, request).unwrap_or_else(|error| panic!("{what}: {error}"));
    let reach = request.insert_radius_mm + request.stock_mm;
    let mut random = SplitMix64(2012);
    let mut worst = 0.0_f64;
    for _ in 0..250 {
        let turned = random.within(path.x().start(), path.x().end());
        let (x, z) = (path.x().sample(turned).value, path.z_at(turned).value);
        let off = distance(|z| formula(turned, z, request.plane_y_mm), x, z, reach) - reach;
        worst = worst.max(off.abs());
        assert!(off.abs() < 1e-5, "{what}, seed 2012, at {turned}, z {z}: {off}");
    }
    println!("{what}: distance from the section is R within {worst:.1e} mm ({:?})", path.accuracy());
    path
}

#[test]
fn the_centre_of_the_insert_is_its_radius_away_from_the_section_everywhere() {
    let ask = request(0.0, 20.0);
    keeps_its_distance(&solid(CYLINDER), cylinder, &ask, "cylinder");
    keeps_its_distance(&solid(ECCENTRIC), eccentric, &ask, "eccentric");
    let cone = solid(ELLIPTIC_CONE);
    keeps_its_distance(&cone, elliptic_cone, &ask, "elliptic cone");
    keeps_its_distance(&cam_along_z(), cam, &request(-1.0, 23.0), "3-D cam");
    let (mesh, reading) = surface_of(&mesh_of(&cone, 180, 20, 0.0)).unwrap();
    println!("{reading:?}");
    keeps_its_distance(&mesh, elliptic_cone, &ask, "mesh of the elliptic cone");
    let (mesh, reading) = surface_of(&mesh_of(&cam_along_z(), 360, 176, 0.0)).unwrap();
    println!("{reading:?}");
    keeps_its_distance(&mesh, cam, &request(1.0, 21.0), "mesh of the 3-D cam");
    // Coarser and finer steps, above centre and at centre, backwards, with stock, along the curve.
    for (what, ask) in [
        ("2° steps", PathRequest { angles: 180, ..ask }),
        ("0.25° steps", PathRequest { angles: 1440, to_mm: 4.0, ..ask }),
        ("above centre", PathRequest { plane_y_mm: 8.0, ..ask }),
        ("at centre", PathRequest { plane_y_mm: 0.0, ..ask }),
        ("backwards", PathRequest { from_mm: 20.0, to_mm: 0.0, ..ask }),
        ("with stock", PathRequest { stock_mm: 1.5, ..ask }),
        ("along the curve", PathRequest { feed: InsertFeed::AlongCurve(0.4), ..ask }),
        (
            "along the curve backwards",
            PathRequest { feed: InsertFeed::AlongCurve(0.4), from_mm: 20.0, to_mm: 0.0, ..ask },
        ),
    ] {
        keeps_its_distance(&cone, elliptic_cone, &ask, what);
    }
    let along = PathRequest { feed: InsertFeed::AlongCurve(0.4), from_mm: 1.0, to_mm: 21.0, ..ask };
    keeps_its_distance(&cam_along_z(), cam, &along, "3-D cam along the curve");
}

#[test]
fn a_cylinder_has_a_path_that_stands_still() {
    let path = InsertPath::new(&solid(CYLINDER), &request(0.0, 20.0)).unwrap();
    let wanted = (400.0 - Y * Y).sqrt() + 6.0;
    assert!(path.x().knots().iter().all(|[x, v, a]| (x - wanted).abs() < 1e-12 && *v == 0.0 && *a == 0.0));
    assert!(path.stroke_mm() < 1e-12);
    assert_eq!(path.x().knots().len(), 50 * 360 + 1);
    assert!((path.z_at(path.x().end()).value - 20.0).abs() < 1e-9);
    // f²/8R
    assert!((path.cusp_mm() - 0.16 / 48.0).abs() < 1e-5);
}

/// The plan contains the same curve: X and Z of the insert's centre over the angle since the start.
#[test]
fn the_laws_of_a_plan_are_the_path() {
    for feed in [InsertFeed::AlongZ(0.4), InsertFeed::AlongCurve(0.4)] {
        let path = InsertPath::new(&cam_along_z(), &PathRequest { feed, ..request(14.0, 8.0) }).unwrap();
        let (x, z) = path.laws().unwrap();
        let (start, way) = (path.x().start(), path.x().end() - path.x().start());
        assert!(x.start() == 0.0 && (x.end() - way).abs() < 1e-9 && (z.end() - way).abs() < 1e-9);
        for k in 0..2000_u32 {
            let since = way * f64::from(k) / 2000.0;
            assert!((x.sample(since).value - path.x().sample(start + since).value).abs() < 1e-9);
            assert!((z.sample(since).value - path.z_at(start + since).value).abs() < 1e-9);
        }
    }
}

#[test]
fn sections_of_solids_are_their_closed_forms() {
    for y in [Y, -3.0, 0.0, 9.0] {
        for (surface, formula) in [
            (solid(CYLINDER), cylinder as Formula),
            (solid(ECCENTRIC), eccentric),
            (solid(ELLIPTIC_CONE), elliptic_cone),
        ] {
            let section = RakeSection::new(&surface, y, -6.0, 26.0).unwrap();
            assert!(section.is_single());
            let h = 1e-4;
            for k in 0..400_u32 {
                let (turned, z) = (f64::from(k) * 0.0471, f64::from(k % 33) - 6.0);
                let point = section.point(turned, z).unwrap();
                let x = |dt: f64, dz: f64| formula(turned + dt, z + dz, y);
                assert!((point.x_mm - x(0.0, 0.0)).abs() < 1e-12, "{turned} {z}");
                for (found, wanted) in [
                    (point.by_z, (x(0.0, h) - x(0.0, -h)) / (2.0 * h)),
                    (point.by_turn, (x(h, 0.0) - x(-h, 0.0)) / (2.0 * h)),
                    (point.by_z_twice, (x(0.0, h) - 2.0 * x(0.0, 0.0) + x(0.0, -h)) / (h * h)),
                    (point.by_turn_twice, (x(h, 0.0) - 2.0 * x(0.0, 0.0) + x(-h, 0.0)) / (h * h)),
                    (point.by_z_and_turn, (x(h, h) - x(h, -h) - x(-h, h) + x(-h, -h)) / (4.0 * h * h)),
                ] {
                    assert!((found - wanted).abs() < 3e-6, "{turned} {z}: {found} {wanted}");
                }
            }
            let curve = section.curve(1.1, 1e-7).unwrap();
            for k in 0..=1000_u32 {
                let z = -6.0 + 0.032 * f64::from(k);
                assert!((curve.spline.sample(z).value - formula(1.1, z, y)).abs() < 1e-7);
            }
        }
    }
}

/// A cone r = 20 + kz has dx/dz = k·r/√(r² − y₀²).
#[test]
fn a_cone_is_steeper_below_centre_than_at_centre() {
    let cone = Solid::Lobed { mean_mm: LinearInZ { at_zero: 20.0, per_mm: 0.2 }, harmonics: Vec::new() };
    let surface = Surface::solid(cone, 0.0, 30.0).unwrap();
    let section = RakeSection::new(&surface, Y, 0.0, 30.0).unwrap();
    for k in 0..=30_u32 {
        let r = 20.0 + 0.2 * f64::from(k);
        let point = section.point(0.8, f64::from(k)).unwrap();
        assert!((point.by_z - 0.2 * r / (r * r - Y * Y).sqrt()).abs() < 1e-13);
    }
}

/// Error of a calculation that takes the radius at ψ = 0, or at one ψ for all angles.
#[test]
fn shortcuts_are_wrong_by_what_the_literature_of_this_house_says() {
    for (lift, ignored, constant, stroke) in [(4.5, 2.09, 0.35, 5.86), (3.0, 1.45, 0.17, 4.00)] {
        let contour = solids::raised_cosine(lift);
        let cams =
            [camwright::cam::surface::cams::CamAlong { contour: &contour, phase_rad: 0.0, from_mm: 0.0, to_mm: 5.0 }];
        let surface = Surface::cams(&cams).unwrap();
        let found = RakeSection::new(&surface, -14.14, 0.0, 5.0).unwrap().shortcuts().unwrap();
        println!("lift {lift} mm: shift ignored {:.3} mm, constant {:.3} mm", found.ignored_mm, found.constant_mm);
        assert!((found.ignored_mm - ignored).abs() < 5e-3, "{found:?}");
        assert!((found.constant_mm - constant).abs() < 6e-3, "{found:?}");
        let path = InsertPath::new(&surface, &PathRequest { plane_y_mm: -14.14, ..request(0.0, 5.0) }).unwrap();
        assert!((path.stroke_mm() - stroke).abs() < 5e-3, "{}", path.stroke_mm());
    }
}

/// Derivatives of X are exact: the spline through them is C², and its pieces agree with differences of the exact path.
#[test]
fn rates_are_those_of_the_path_and_the_fastest_spindle_keeps_the_limits() {
    let surface = cam_along_z();
    for feed in [InsertFeed::AlongZ(0.4), InsertFeed::AlongCurve(0.4)] {
        let path = InsertPath::new(&surface, &PathRequest { feed, ..request(1.0, 21.0) }).unwrap();
        let limits = AxisLimits {
            x: MotionLimits { velocity: 500.0, acceleration: 2e4, jerk: 2e6 },
            z: MotionLimits { velocity: 200.0, acceleration: 5e3, jerk: 5e5 },
            spindle_rad_s: 300.0,
        };
        let fastest = path.fastest_spindle(&limits).unwrap();
        let used = path.keeps(fastest.rad_s, &limits).unwrap();
        let bounds = path.at_speed(fastest.rad_s);
        println!("{feed:?}: {fastest:?}");
        // Differences find what the hulls say, a little less.
        for (found, bound) in [
            (used.x.velocity, bounds.x.velocity),
            (used.x.acceleration, bounds.x.acceleration),
            (used.x.jerk, bounds.x.jerk),
        ] {
            assert!(
                found.value <= bound.value * (1.0 + 1e-5) && found.value > 0.97 * bound.value,
                "{found:?} {bound:?}"
            );
        }
        assert!(matches!(fastest.bound, SpeedBound::Acceleration(_) | SpeedBound::Jerk(_)), "{fastest:?}");
        let error = path.keeps(1.05 * fastest.rad_s, &limits).unwrap_err();
        assert!(matches!(error, InsertPathError::ExceedsLimit { .. }), "{error}");
        // Half the speed takes a quarter of the acceleration.
        let half = path.at_speed(0.5 * fastest.rad_s);
        assert!(
            (half.x.acceleration.value * 4.0 - bounds.x.acceleration.value).abs() < 1e-9 * bounds.x.acceleration.value
        );
        let slow = AxisLimits { spindle_rad_s: 1.0, ..limits };
        assert_eq!(path.fastest_spindle(&slow).unwrap().bound, SpeedBound::Spindle);
    }
}

/// A position over steps of time.
type Function<'a> = &'a dyn Fn(u32) -> f64;

/// From rest to rest, at the end of the path when it ends, and no slide exceeds a limit on the way, by differences over time.
#[test]
fn the_spindle_runs_up_and_stops_within_the_limits_of_all_axes() {
    let limits = AxisLimits {
        x: MotionLimits { velocity: 500.0, acceleration: 2e4, jerk: 2e6 },
        z: MotionLimits { velocity: 200.0, acceleration: 5e3, jerk: 5e5 },
        spindle_rad_s: 300.0,
    };
    let c = MotionLimits { velocity: 200.0, acceleration: 600.0, jerk: 6e4 };
    let surface = cam_along_z();
    for (what, asked, ask) in [
        ("all it can", 1e3, request(1.0, 21.0)),
        ("slowly", 5.0, request(1.0, 3.0)),
        ("along the curve", 1e3, PathRequest { feed: InsertFeed::AlongCurve(0.5), ..request(1.0, 21.0) }),
        ("a turn", 1e3, request(11.0, 11.4)),
    ] {
        let path = InsertPath::new(&surface, &ask).unwrap();
        let law = path.spindle_law(asked, &limits, c).unwrap();
        let (x, z) = path.laws().unwrap();
        println!("{what}: {:.2} rad/s, ramp {:.3} s, whole {:.2} s", law.rad_s, law.ramp_s, law.law.end());
        assert!(law.rad_s <= asked && law.rad_s > 0.0);
        assert!((law.law.sample(law.law.end()).value - x.end()).abs() < 1e-9 && law.law.start() == 0.0);
        let h = 1e-4;
        let steps = (0_u32..).take_while(|k| f64::from(*k) * h < law.law.end()).count();
        let steps = u32::try_from(steps).unwrap();
        let at = |k: u32| law.law.sample(f64::from(k) * h).value;
        let functions: [(_, Function<'_>, _); 3] =
            [("C", &at, c), ("X", &|k| x.sample(at(k)).value, limits.x), ("Z", &|k| z.sample(at(k)).value, limits.z)];
        for (axis, f, limits) in functions {
            let mut worst = [0.0_f64; 3];
            // The ends, and some of the middle.
            for k in (0..steps - 4).filter(|k| *k < 8000 || *k + 8000 > steps || k % 7 == 0) {
                let [a, b, c, d] = [f(k), f(k + 1), f(k + 2), f(k + 3)];
                worst[0] = worst[0].max((b - a).abs() / h);
                worst[1] = worst[1].max((c - 2.0 * b + a).abs() / (h * h));
                worst[2] = worst[2].max((d - 3.0 * c + 3.0 * b - a).abs() / (h * h * h));
            }
            // Angles of a thousand rad are rounded, which the third difference sees.
            let noise = [1e-6, 1e-2, 50.0];
            for ((worst, limit), noise) in
                worst.iter().zip([limits.velocity, limits.acceleration, limits.jerk]).zip(noise)
            {
                assert!(*worst <= limit + noise, "{what}, {axis}: {worst} {limit}");
            }
        }
    }
    let path = InsertPath::new(&surface, &request(1.0, 2.0)).unwrap();
    for bad in [0.0, -1.0, f64::NAN] {
        assert!(path.spindle_law(bad, &limits, c).is_err());
        assert!(path.spindle_law(1.0, &limits, MotionLimits { jerk: bad, ..c }).is_err());
    }
}

/// At constant feed along the curve the contact goes the same way each turn at each angle, and Z goes to and fro within a turn.
#[test]
fn feed_along_the_curve_is_constant_along_the_curve() {
    let surface = cam_along_z();
    let ask = PathRequest { feed: InsertFeed::AlongCurve(0.5), ..request(1.0, 21.0) };
    let path = InsertPath::new(&surface, &ask).unwrap();
    let ZLaw::Spline(z) = path.z() else { panic!("Z is not straight") };
    let contact = |knot: usize| {
        // From the centre to the nearest point of the section.
        let (turned, x, z) = (path.x().at(knot), path.x().knots()[knot][0], z.knots()[knot][0]);
        let far = |z1: f64| (cam(turned, z1, Y) - x).hypot(z1 - z);
        let (mut low, mut high) = (z - 5.9, z + 5.9);
        for _ in 0..80 {
            let third = (high - low) / 3.0;
            if far(low + third) < far(high - third) { high -= third } else { low += third }
        }
        0.5 * (low + high)
    };
    for angle in [0, 90, 200] {
        let length = |knot: usize| {
            let (from, to) = (contact(knot), contact(knot + 360));
            let at = |k: u32| from + (to - from) * f64::from(k) / 40.0;
            let x = |k: u32| cam(path.x().at(knot), at(k), Y);
            (0..40).map(|k| (x(k + 1) - x(k)).hypot(at(k + 1) - at(k))).sum::<f64>()
        };
        let ways: Vec<f64> = (0..8).map(|turn| length(angle + 360 * 4 * turn)).collect();
        assert!(ways.iter().all(|way| (way - ways[0]).abs() < 1e-3 && *way <= 0.5 + 1e-3), "{ways:?}");
    }
    assert!(z.knots().iter().any(|[_, v, _]| *v < 0.0));
}

/// A hollow of 4 mm radius under an insert of 6 mm: the insert bridges it, cuts nothing, and the material left is reported. The groove is
/// r = 24 − a(1 + cos(πz/ℓ)): its bottom has the radius ℓ²/(aπ²).
#[test]
fn hollows_too_tight_for_the_insert_are_bridged_and_reported() {
    let (a, half) = (0.6, 5.0);
    let z: Vec<f64> = (0..=400).map(|k| -20.0 + 0.1 * f64::from(k)).collect();
    let groove =
        |_: f64, z: f64| if z.abs() < half { 24.0 - a * (1.0 + (std::f64::consts::PI * z / half).cos()) } else { 24.0 };
    let surface = Surface::grid(&camwright::cam::surface::grid::SurfaceGrid::sampled(36, z, groove)).unwrap();
    let ask = PathRequest { plane_y_mm: 0.0, ..request(-10.0, 10.0) };
    let tightest = half * half / (a * std::f64::consts::PI.powi(2));
    assert!(InsertPath::new(&surface, &PathRequest { insert_radius_mm: 3.0, ..ask }).unwrap().hollow().is_none());
    let path = InsertPath::new(&surface, &ask).unwrap();
    let hollow = path.hollow().expect("it is too tight");
    assert!((hollow.radius_mm - tightest).abs() < 0.05 && hollow.z_mm.abs() < 0.2, "{hollow:?} {tightest}");
    // The bridge: the insert rests on both flanks; what is left below it.
    let lowest =
        (0..=2000).map(|k| -5.0 + 0.005 * f64::from(k)).map(|z| groove(0.0, z) + (36.0 - z * z).max(0.0).sqrt());
    let centre = lowest.fold(0.0, f64::max);
    let left = centre - 6.0 - groove(0.0, 0.0);
    assert!(left > 0.02 && (hollow.left_mm - left).abs() < 2e-3, "{hollow:?} {left}");
    for knot in (0..path.x().knots().len()).step_by(37) {
        let (x, z) = (path.x().knots()[knot][0], path.z_at(path.x().at(knot)).value);
        let nearest = distance(|z| groove(0.0, z), x, z, 6.0);
        // The spline through the grid is not the groove where its bend jumps.
        assert!((nearest - 6.0).abs() < 1e-4, "{z}: {nearest}");
    }
    let error = InsertPath::new(&surface, &PathRequest { feed: InsertFeed::AlongCurve(0.4), ..ask }).unwrap_err();
    assert!(matches!(error, InsertPathError::TooHollow { .. }), "{error}");
}

/// A deep square has flanks whose rake section is not proven to be single; the outermost point is found, with nothing in front.
#[test]
fn nothing_stands_in_front_of_a_point_of_the_section() {
    let mut random = SplitMix64(31);
    let (mut met, mut refused, mut proven) = (0, 0, 0);
    for round in 0..120 {
        let waves = 2 + u32::try_from(random.next() % 6).unwrap();
        let depth = random.within(2.0, 8.0);
        let harmonic = Harmonic {
            waves,
            amplitude_mm: LinearInZ { at_zero: depth, per_mm: 0.02 },
            phase_rad: LinearInZ { at_zero: random.within(0.0, 6.0), per_mm: 0.03 },
        };
        let lobed = Solid::Lobed { mean_mm: LinearInZ::constant(28.0), harmonics: vec![harmonic] };
        let surface = Surface::solid(lobed, 0.0, 20.0).unwrap();
        let y = -random.within(6.0, 19.4);
        let Ok(section) = RakeSection::new(&surface, y, 0.0, 20.0) else { continue };
        proven += u32::from(section.is_single());
        for _ in 0..40 {
            let (turned, z) = (random.within(0.0, TURN_RAD), random.within(0.0, 20.0));
            let inside = |x: f64| x.hypot(y) < surface.radius(y.atan2(x) + turned, z);
            let outermost = (0..40_000).map(|k| 40.0 - f64::from(k) * 1e-3).find(|x| inside(*x));
            match section.point(turned, z) {
                Ok(point) => {
                    met += 1;
                    let outermost = outermost.unwrap();
                    assert!((point.x_mm - outermost).abs() < 1.1e-3, "seed 31, {round}: {} {outermost}", point.x_mm);
                }
                Err(RakeSectionError::Grazes { .. }) => refused += 1,
                Err(error) => panic!("seed 31, {round}: {error}"),
            }
        }
    }
    assert!(met > 4000 && (10..110).contains(&proven), "{met} {refused} {proven}");
}

/// Six deep waves below which the rake plane passes so low that one stands before the next: X would have to jump.
#[test]
fn what_stands_behind_something_else_is_refused() {
    let harmonic = Harmonic { waves: 6, amplitude_mm: LinearInZ::constant(5.0), phase_rad: LinearInZ::constant(0.0) };
    let lobed = Solid::Lobed { mean_mm: LinearInZ::constant(28.0), harmonics: vec![harmonic] };
    let surface = Surface::solid(lobed, 0.0, 20.0).unwrap();
    let plan = |plane_y_mm| InsertPath::new(&surface, &PathRequest { plane_y_mm, ..request(5.0, 7.0) });
    assert!(plan(-2.0).is_ok());
    for y in [-19.0, -20.0, -21.0] {
        let error = plan(y).map(|_| ()).unwrap_err();
        println!("{error}");
        assert!(
            matches!(
                error,
                InsertPathError::Overhang { .. } | InsertPathError::Section(RakeSectionError::Grazes { .. })
            ),
            "{error}"
        );
    }
}

#[test]
fn random_solids_keep_their_distance_or_are_refused() {
    let mut random = SplitMix64(404);
    let mut planned = 0;
    for round in 0..40 {
        let surface = solid(random_lobed(|low, high| random.within(low, high)));
        let ask = PathRequest {
            insert_radius_mm: random.within(2.0, 10.0),
            plane_y_mm: random.within(-14.0, 5.0),
            from_mm: random.within(0.0, 10.0),
            to_mm: random.within(0.0, 20.0),
            feed: if round % 3 == 0 { InsertFeed::AlongCurve(0.7) } else { InsertFeed::AlongZ(0.7) },
            angles: 360,
            start_rad: random.within(-7.0, 7.0),
            stock_mm: if round % 2 == 0 { 0.0 } else { random.within(0.0, 2.0) },
        };
        let path = match InsertPath::new(&surface, &ask) {
            Ok(path) => path,
            Err(InsertPathError::Section(_)) => continue,
            Err(error) => panic!("seed 404, {round}: {error}"),
        };
        planned += 1;
        let reach = ask.insert_radius_mm + ask.stock_mm;
        for _ in 0..25 {
            let turned = random.within(path.x().start(), path.x().end());
            let (x, z) = (path.x().sample(turned).value, path.z_at(turned).value);
            let section = |z: f64| {
                let inside = |x: f64| x.hypot(ask.plane_y_mm) < surface.radius(ask.plane_y_mm.atan2(x) + turned, z);
                let (mut low, mut high) = (0.0, 40.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if inside(middle) { low = middle } else { high = middle }
                }
                low
            };
            let off = distance(section, x, z, reach) - reach;
            assert!(off.abs() < 1e-5, "seed 404, {round} at {turned}: {off}");
        }
    }
    assert!(planned > 25, "{planned}");
}

#[test]
fn passes_take_equal_depths_and_the_last_one_what_finishing_was_left() {
    let passes = Passes { stock_mm: 3.3, finish_mm: 0.3, deepest_mm: 0.8, rough_feed: InsertFeed::AlongZ(1.0) };
    let paths = passes.paths(&cam_along_z(), &request(2.0, 8.0)).unwrap();
    let depths: Vec<f64> = paths.iter().map(|pass| pass.depth_mm).collect();
    assert_eq!(depths.len(), 5);
    assert!(
        depths[..4].iter().all(|depth| (depth - 0.75).abs() < 1e-12) && (depths[4] - 0.3).abs() < 1e-12,
        "{depths:?}"
    );
    assert!(paths.windows(2).all(|pair| pair[0].path.x_range_mm().0 > pair[1].path.x_range_mm().0));
    assert_eq!(paths[4].path.request().feed, InsertFeed::AlongZ(0.4));
    assert_eq!(paths[0].path.request().feed, InsertFeed::AlongZ(1.0));
    let only = Passes { stock_mm: 0.0, finish_mm: 0.0, ..passes };
    assert_eq!(only.stocks_mm().unwrap(), vec![0.0]);
    for bad in [
        Passes { stock_mm: f64::NAN, ..passes },
        Passes { finish_mm: 4.0, ..passes },
        Passes { deepest_mm: 0.0, ..passes },
        Passes { deepest_mm: 1e-6, ..passes },
    ] {
        assert!(matches!(bad.stocks_mm(), Err(InsertPathError::BadNumber { .. })));
    }
}

#[test]
fn what_cannot_be_planned_is_refused() {
    let surface = cam_along_z();
    let good = request(0.0, 10.0);
    let refused = |ask: PathRequest| InsertPath::new(&surface, &ask).map(|_| ()).unwrap_err();
    for ask in [
        PathRequest { insert_radius_mm: 0.0, ..good },
        PathRequest { insert_radius_mm: f64::NAN, ..good },
        PathRequest { feed: InsertFeed::AlongZ(0.0), ..good },
        PathRequest { feed: InsertFeed::AlongCurve(-1.0), ..good },
        PathRequest { feed: InsertFeed::AlongZ(7.0), ..good },
        PathRequest { angles: 10, ..good },
        PathRequest { angles: 10_000, ..good },
        PathRequest { stock_mm: -0.1, ..good },
        PathRequest { stock_mm: f64::INFINITY, ..good },
        PathRequest { from_mm: f64::NAN, ..good },
        PathRequest { start_rad: f64::NAN, ..good },
        PathRequest { start_rad: 1e300, ..good },
    ] {
        assert!(matches!(refused(ask), InsertPathError::BadNumber { .. }), "{ask:?}");
    }
    let error = refused(PathRequest { feed: InsertFeed::AlongZ(1e-6), ..good });
    assert!(matches!(error, InsertPathError::TooLong { .. }), "{error}");
    let error = refused(PathRequest { plane_y_mm: f64::NAN, ..good });
    assert!(matches!(error, InsertPathError::Section(RakeSectionError::BadNumber { .. })), "{error}");
    let error = refused(PathRequest { plane_y_mm: -20.5, ..good });
    let InsertPathError::Section(RakeSectionError::Misses { azimuth_deg, bound_mm, .. }) = error else {
        panic!("{error}")
    };
    assert!((azimuth_deg - 180.0).abs() < 1.0 && (bound_mm - 20.0).abs() < 0.01);
    let path = InsertPath::new(&surface, &good).unwrap();
    let limits = MotionLimits { velocity: 1.0, acceleration: 1.0, jerk: 1.0 };
    for bad in [
        AxisLimits { x: MotionLimits { jerk: 0.0, ..limits }, z: limits, spindle_rad_s: 1.0 },
        AxisLimits { x: limits, z: MotionLimits { velocity: f64::NAN, ..limits }, spindle_rad_s: 1.0 },
        AxisLimits { x: limits, z: limits, spindle_rad_s: -1.0 },
    ] {
        assert!(matches!(path.fastest_spindle(&bad), Err(InsertPathError::BadNumber { .. })));
    }
    assert!(path.keeps(f64::NAN, &AxisLimits { x: limits, z: limits, spindle_rad_s: 1.0 }).is_err());
}

/// On a cylinder it is f²/8R, and the surface's normal leans by asin(H/r) out of the rake plane. A cone is as steep along z as its section
/// in a plane through the axis, where nothing leans.
#[test]
fn the_highest_cusp_is_that_of_its_section_seen_along_the_normal() {
    let on = |solid: Solid, plane_y_mm: f64| {
        let surface = Surface::solid(solid, -40.0, 40.0).expect("a solid");
        let path = InsertPath::new(&surface, &PathRequest { plane_y_mm, ..request(20.0, 10.0) }).expect("a path");
        path.highest_cusp(&surface, 0.0, 10.0).expect("a cusp").height_mm
    };
    let flat = 0.4 * 0.4 / 8.0 / 6.0;
    let cylinder = on(CYLINDER, Y);
    assert!((cylinder - flat * (1.0 - Y * Y / 400.0).sqrt()).abs() < 1e-12, "{cylinder}");
    let slope = LinearInZ { per_mm: 0.25, ..LinearInZ::constant(20.0) };
    let cone = Solid::EllipticCone { first_mm: slope, second_mm: slope, azimuth_rad: 0.0 };
    let cone = on(cone, 0.0);
    assert!((cone - flat * 1.0625).abs() < 1e-12, "{cone}");
    // The eccentric: its centre stands farthest from the rake plane where the disc leans least, 21 mm in radius.
    let min = on(ECCENTRIC, Y);
    let lean = |azimuth: f64| (1.0 - ((Y - 2.5 * azimuth.sin()) / 21.0).powi(2)).sqrt();
    let wanted = (0..3600).map(|i| flat * lean(f64::from(i) / 3600.0 * TURN_RAD)).fold(0.0, f64::max);
    assert!((min / wanted - 1.0).abs() < 1e-3, "{min} {wanted}");
}
