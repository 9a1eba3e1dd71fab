// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A spindle whose speed varies along the path: no axis exceeds a limit, and it is sooner at its end than at constant speed.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

use crate::cams;
use crate::solids;

use cams::SplitMix64;
use camwright::cam::surface::Surface;
use camwright::cam::surface::grid::SurfaceGrid;
use camwright::machine::description::MotionLimits;
use camwright::toolpath::insert_path::{
    AxisLimits, InsertFeed, InsertPath, InsertPathError, PathRequest, SpeedBound, SpindleLaw,
};
use solids::{cam_along_z, low_and_high_cam, random_lobed, solid};

const fn motion(velocity: f64, acceleration: f64, jerk: f64) -> MotionLimits {
    MotionLimits { velocity, acceleration, jerk }
}

const LIMITS: AxisLimits = AxisLimits { x: motion(500.0, 2e4, 2e6), z: motion(200.0, 5e3, 5e5), spindle_rad_s: 300.0 };

const SPINDLE: MotionLimits = motion(60.0, 600.0, 6e4);

fn request(from_mm: f64, to_mm: f64) -> PathRequest {
    PathRequest {
        insert_radius_mm: 6.0,
        plane_y_mm: -14.0,
        from_mm,
        to_mm,
        feed: InsertFeed::AlongZ(0.4),
        angles: 360,
        start_rad: 0.3,
        stock_mm: 0.0,
    }
}

/// A position over time.
type Function<'a> = &'a dyn Fn(f64) -> f64;

/// Walks a law by differences of positions over steps eight times finer than the path's knots where it stands; the largest share of a limit.
fn walk(law: &SpindleLaw, path: &InsertPath, limits: &AxisLimits, c: MotionLimits, what: &str) -> f64 {
    let (x, z) = path.laws().expect("the laws of a path");
    let law = &law.law;
    let at = |t: f64| law.sample(t).value;
    let functions: [(_, Function<'_>, _); 3] =
        [("C", &at, c), ("X", &|t| x.sample(at(t)).value, limits.x), ("Z", &|t| z.sample(at(t)).value, limits.z)];
    let (mut t, end, mut max) = (0.0, law.end(), 0.0_f64);
    while t < end {
        // Neither a standstill nor a knot of the law is stepped over.
        let h = (path.x().step() / 8.0 / law.sample(t).first.max(0.5)).min(1e-3);
        for (axis, f, limits) in functions {
            let [p, q, r, s] = [f(t), f(t + h), f(t + 2.0 * h), f(t + 3.0 * h)];
            let found = [(q - p) / h, (r - 2.0 * q + p) / (h * h), (s - 3.0 * r + 3.0 * q - p) / (h * h * h)];
            for (order, (found, limit)) in
                (1..).zip(found.into_iter().zip([limits.velocity, limits.acceleration, limits.jerk]))
            {
                let noise = 8.0 * f64::EPSILON * 200.0 / h.powi(order);
                assert!(found.abs() <= limit + noise, "{what}, {axis} at {t} s of {end}: {order}. {found} {limit}");
                max = max.max((found.abs() - noise) / limit);
            }
        }
        t += h;
    }
    max
}

/// From rest to rest, on to the path's end, and never back.
fn begins_and_ends(law: &SpindleLaw, path: &InsertPath) {
    let (first, last) = (law.law.knots()[0], law.law.knots()[law.law.knots().len() - 1]);
    assert_eq!((first.at, first.value, first.first, first.second), (0.0, 0.0, 0.0, 0.0));
    assert_eq!((last.first, last.second), (0.0, 0.0));
    assert!((last.value - (path.x().end() - path.x().start())).abs() < 1e-9);
    assert!(law.law.knots().windows(2).all(|pair| pair[0].value < pair[1].value));
    let (low, high) = law.range_rad_s;
    assert!(law.rad_s.to_bits() == low.to_bits() && low > 0.0 && low <= high, "{low} {high}");
    let shares: f64 = law.bounds.iter().map(|bound| bound.share).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{:?}", law.bounds);
}

#[test]
fn random_parts_are_turned_within_all_limits_and_no_slower_than_at_constant_speed() {
    let mut random = SplitMix64(711);
    let (mut planned, mut sooner) = (0, 0);
    for round in 0..40 {
        let surface = solid(random_lobed(|low, high| random.within(low, high)));
        let from_mm = random.within(0.0, 8.0);
        let ask = PathRequest {
            insert_radius_mm: random.within(2.0, 8.0),
            plane_y_mm: random.within(-14.0, 5.0),
            feed: if round % 4 == 0 { InsertFeed::AlongCurve(0.7) } else { InsertFeed::AlongZ(0.7) },
            angles: [180, 250, 360, 720][round % 4],
            ..request(from_mm, from_mm + random.within(0.3, 11.0))
        };
        let mut limits = |v: f64, a: f64, j: f64| {
            motion(v * random.within(0.3, 3.0), a * random.within(0.1, 10.0), j * random.within(0.02, 50.0))
        };
        let (x, z, c) = (limits(300.0, 1e4, 1e6), limits(100.0, 3e3, 3e5), limits(60.0, 300.0, 3e4));
        let limits = AxisLimits { x, z, spindle_rad_s: 100.0 };
        let path = match InsertPath::new(&surface, &ask) {
            Ok(path) => path,
            Err(InsertPathError::Section(_)) => continue,
            Err(error) => panic!("seed 711, {round}: {error}"),
        };
        let (constant, law) =
            (path.spindle_law(c.velocity, &limits, c).unwrap(), path.varied_spindle_law(&limits, c).unwrap());
        planned += 1;
        let what = format!("seed 711, {round}");
        begins_and_ends(&law, &path);
        let gain = constant.law.end() / law.law.end();
        assert!(gain >= 1.0, "{what}: {gain}");
        sooner += usize::from(gain > 1.01);
        let max = walk(&law, &path, &limits, c, &what);
        println!(
            "{what}: {:.2} s instead of {:.2}, {:.1} times as fast, {:.2} to {:.2} rad/s, up to {:.3} of a limit; {:?}",
            law.law.end(),
            constant.law.end(),
            gain,
            law.range_rad_s.0,
            law.range_rad_s.1,
            max,
            law.bounds[0]
        );
        // Ranges are wider than what is reached, but not by much.
        assert!(gain < 1.01 || max > 0.7, "{what}: only {max} of a limit is used");
    }
    assert!(planned > 25 && sooner > 10, "{planned} planned, {sooner} sooner");
}

/// Round up to 40 mm, off centre from 50 mm on: r = 20 + e cos a. With a rake face at centre height X = r, and X″ is e at most.
fn cylinder_then_off_centre(e: f64) -> InsertPath {
    let off = |z: f64| {
        let u = ((z - 40.0) / 10.0).clamp(0.0, 1.0);
        e * u * u * u * (10.0 + u * (6.0 * u - 15.0))
    };
    let rows = (0..=360).map(|row| f64::from(row) * 0.25).collect();
    let surface =
        Surface::grid(&SurfaceGrid::sampled(360, rows, |azimuth, z| 20.0 + off(z) * azimuth.cos())).expect("a grid");
    InsertPath::new(&surface, &PathRequest { plane_y_mm: 0.0, ..request(0.0, 90.0) }).expect("a path")
}

/// C that changes its speed slowly turns a whole turn alike: as fast as it may on the cylinder, where it is off centre by the constant law's
/// speed √(a/e). C that is quick is as fast there only where X″ is largest, and faster in between.
#[test]
fn it_turns_at_the_spindles_limit_on_a_cylinder_and_at_the_slides_where_the_part_is_off_centre() {
    let (e, acceleration) = (2.0, 800.0);
    let path = cylinder_then_off_centre(e);
    let limits = AxisLimits { x: motion(1e3, acceleration, 1e9), ..LIMITS };
    let fastest = (acceleration / e).sqrt();
    for (what, c, slow) in [("slow", motion(60.0, 12.0, 1e4), true), ("quick", motion(60.0, 400.0, 1e5), false)] {
        let constant = path.spindle_law(c.velocity, &limits, c).unwrap();
        assert!((constant.rad_s / 0.98 - fastest).abs() < 1e-3 * fastest, "{} {fastest}", constant.rad_s);
        let law = path.varied_spindle_law(&limits, c).unwrap();
        begins_and_ends(&law, &path);
        walk(&law, &path, &limits, c, what);
        let speeds = |from_mm: f64, to_mm: f64| {
            let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
            for k in 0..40_000 {
                let sample = law.law.sample(law.law.end() * f64::from(k) / 40_000.0);
                if (from_mm..to_mm).contains(&path.z_at(path.x().start() + sample.value).value) {
                    (low, high) = (low.min(sample.first), high.max(sample.first));
                }
            }
            (low, high)
        };
        let (round, off) = (speeds(0.0, 40.0), speeds(52.0, 80.0));
        println!("{what}: {round:?} rad/s on the cylinder, {off:?} off centre, constant {:.2}", constant.rad_s);
        assert!((round.1 - c.velocity).abs() < 2e-3 * c.velocity, "{what}: {round:?}");
        assert!(off.0 > 0.97 * fastest && off.0 < 1.001 * fastest, "{what}: {off:?} {fastest}");
        if slow {
            assert!(off.1 < 1.06 * fastest, "{what}: {off:?} {fastest}");
        } else {
            assert!(off.1 > 1.15 * fastest, "{what}: {off:?} {fastest}");
            assert!(law.law.end() < 0.7 * constant.law.end(), "{} {}", law.law.end(), constant.law.end());
        }
    }
}

/// The spindle is slow only at the crests of X.
#[test]
fn a_low_and_a_high_cam_are_turned_several_times_as_fast_as_at_constant_speed() {
    let ask = PathRequest { insert_radius_mm: 8.0, ..request(0.5, 12.5) };
    let path = InsertPath::new(&low_and_high_cam(), &ask).unwrap();
    let (constant, law) =
        (path.spindle_law(60.0, &LIMITS, SPINDLE).unwrap(), path.varied_spindle_law(&LIMITS, SPINDLE).unwrap());
    walk(&law, &path, &LIMITS, SPINDLE, "two cams");
    let (constant_s, varied_s) = (constant.law.end(), law.law.end());
    println!("{varied_s:.2} s instead of {constant_s:.2}, {:?} rad/s, {:?}", law.range_rad_s, law.bounds);
    assert!(varied_s < 0.15 * constant_s, "{varied_s} {constant_s}");
    assert_eq!(law.fastest, constant.fastest);
    assert!(law.bounds.windows(2).all(|pair| pair[0].share >= pair[1].share));
    assert!(law.bounds.iter().any(|bound| bound.bound == SpeedBound::Jerk("x_axis")));
}

/// A few degrees of a part have no room for a constant speed at both ends: the constant law is taken as it is.
#[test]
fn a_path_too_short_to_vary_on_has_the_constant_law() {
    let path = InsertPath::new(&cam_along_z(), &request(11.0, 11.02)).unwrap();
    let constant = path.spindle_law(60.0, &LIMITS, SPINDLE).unwrap();
    assert_eq!(path.varied_spindle_law(&LIMITS, SPINDLE).unwrap(), constant);
    assert_eq!(constant.range_rad_s, (constant.rad_s, constant.rad_s));
    assert_eq!(constant.bounds.len(), 1);
}

#[test]
fn limits_that_are_none_are_refused() {
    let path = InsertPath::new(&cam_along_z(), &request(1.0, 2.0)).unwrap();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for c in [motion(bad, 600.0, 6e4), motion(60.0, bad, 6e4), motion(60.0, 600.0, bad)] {
            assert!(matches!(path.varied_spindle_law(&LIMITS, c), Err(InsertPathError::BadNumber { .. })), "{c:?}");
        }
        let limits = AxisLimits { x: motion(500.0, bad, 2e6), ..LIMITS };
        assert!(matches!(path.varied_spindle_law(&limits, SPINDLE), Err(InsertPathError::BadNumber { .. })));
    }
}
