// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Points of a contour read as a lift: closed forms, either way round, and every refusal with its line.

use crate::cams;

use cams::SplitMix64;
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::points::{ContourPoint, rows_of};
use camwright::cam::lift::{AngleUnit, LengthUnit, LiftDeclaration, LiftError, LiftForm, LiftLaw, LiftRow, LiftTable};
use camwright::math::units::{TURN_RAD, rad_from_deg};

const DIGIT_MM: f64 = 1e-4;

/// A disc of radius 19 mm, 4.2 mm beside the axis, at so many uneven places round its middle, printed to a tenth of a micrometre.
fn disc(count: usize, seed: u64) -> Vec<ContourPoint> {
    let mut random = SplitMix64(seed);
    let print = |mm: f64| (mm / DIGIT_MM).round() * DIGIT_MM;
    (0..count)
        .map(|i| {
            let angle = TURN_RAD * (i as f64 + random.within(-0.3, 0.3)) / count as f64;
            ContourPoint { line: i + 2, x_mm: print(4.2 + 19.0 * angle.cos()), y_mm: print(19.0 * angle.sin()) }
        })
        .collect()
}

/// The radius of that disc at an azimuth.
fn radius(azimuth: f64) -> f64 {
    4.2 * azimuth.cos() + (19.0_f64.powi(2) - (4.2 * azimuth.sin()).powi(2)).sqrt()
}

fn law(rows: &[LiftRow]) -> (LiftLaw, f64) {
    let base = rows.iter().map(|row| row.value_mm).fold(f64::INFINITY, f64::min);
    let lifts: Vec<LiftRow> = rows.iter().map(|row| LiftRow { value_mm: row.value_mm - base, ..*row }).collect();
    let declaration = LiftDeclaration {
        form: LiftForm::Absolute,
        angle_unit: AngleUnit::CamDegrees,
        resolution_mm: DIGIT_MM,
        unit: LengthUnit::Millimetre,
        smooth_within_mm: 0.0,
        lowest_mm: 0.0,
        blocks: None,
    };
    (LiftLaw::from_table(&LiftTable::from_rows(&lifts, &declaration).expect("a clean table")).expect("a curve"), base)
}

/// The points of a disc are the disc again, within two of their digits, whichever way round they are listed and from wherever.
#[test]
fn points_of_a_disc_are_the_disc() {
    for (seed, count) in [(1, 300), (2, 720), (3, 97)] {
        let mut points = disc(count, seed);
        let forwards = rows_of(&points).unwrap();
        assert!(forwards.len() >= 2 * count && forwards.len().is_multiple_of(360), "{}", forwards.len());
        points.rotate_left(count / 3);
        points.reverse();
        let backwards = rows_of(&points).unwrap();
        points.push(points[0]);
        assert_eq!(rows_of(&points).unwrap(), backwards, "a last point that repeats the first");
        for (row, other) in forwards.iter().zip(&backwards) {
            let azimuth = rad_from_deg(row.angle_deg.unwrap());
            assert!((row.value_mm - other.value_mm).abs() < 1e-9, "{azimuth}");
            let bound = if count > 100 { 2.0 * DIGIT_MM } else { 5.0 * DIGIT_MM };
            assert!((row.value_mm - radius(azimuth)).abs() < bound, "{count}, {azimuth}: {}", row.value_mm);
        }
        let (law, base) = law(&forwards);
        let contour = Contour::from_lift(&law, &Follower::KnifeEdge { offset_mm: 0.0 }, base).unwrap();
        for point in &points {
            let off = contour.radius_at(point.y_mm.atan2(point.x_mm)) - point.x_mm.hypot(point.y_mm);
            assert!(off.abs() < 1.5 * DIGIT_MM, "{count}: {off} at {point:?}");
        }
    }
}

#[test]
fn every_row_names_the_point_before_it() {
    let points = disc(300, 7);
    for row in rows_of(&points).unwrap().iter().step_by(7) {
        let at = row.angle_deg.unwrap();
        let point = points.iter().find(|point| point.line == row.line).expect("a line of the file");
        let behind = (at - point.y_mm.atan2(point.x_mm).to_degrees()).rem_euclid(360.0);
        assert!(behind < 4.0, "{at}: {behind}");
    }
}

fn refusals(points: &[ContourPoint]) -> Vec<String> {
    rows_of(points).expect_err("no contour").iter().map(LiftError::to_string).collect()
}

#[test]
fn points_that_make_no_contour_are_refused_with_their_lines() {
    let good = disc(120, 5);
    let edited = |edit: &dyn Fn(&mut Vec<ContourPoint>)| {
        let mut points = good.clone();
        edit(&mut points);
        refusals(&points)
    };
    assert_eq!(refusals(&good[..11]), ["11 rows are too few, at least 12 are needed for one turn"]);
    assert!(refusals(&disc(36_001, 1))[0].starts_with("36001 rows are too many"));
    // Two points the wrong way round: forwards over one, and back.
    let swapped = edited(&|points| {
        let (a, b) = (points[40], points[41]);
        points[40] = ContourPoint { line: a.line, ..b };
        points[41] = ContourPoint { line: b.line, ..a };
    });
    assert_eq!(swapped.len(), 1);
    assert!(swapped[0].starts_with("line 43: the point lies at azimuth 1"), "{swapped:?}");
    assert!(swapped[0].ends_with("deg in line 42 the way the points began"), "{swapped:?}");
    let twice = edited(&|points| points[50] = ContourPoint { line: 52, ..points[49] });
    assert!(twice[0].starts_with("line 52: ") && twice.len() == 1, "{twice:?}");
    let gap = edited(&|points| drop(points.drain(20..33)));
    assert!(
        gap[0].starts_with("line 35: the point lies 3") && gap[0].ends_with("at most 30 deg are read over"),
        "{gap:?}"
    );
    let axis = edited(&|points| points[3] = ContourPoint { line: 5, x_mm: 0.0, y_mm: -1e-9 });
    assert_eq!(axis, ["line 5: the point lies on the axis"]);
    let none = edited(&|points| (points[3].x_mm, points[9].y_mm) = (f64::NAN, f64::INFINITY));
    assert_eq!(none, ["line 5: x is NaN, not a finite number", "line 11: y is inf, not a finite number"]);
    let far = edited(&|points| points[3].x_mm = 1e9);
    assert_eq!(far, ["line 5: 1000000000 mm is beyond the largest lift of 1000 mm"]);
    // Twice round, and a ring beside the axis.
    let round = edited(&|points| {
        points.extend(disc(120, 5).iter().map(|point| ContourPoint { line: point.line + 120, ..*point }));
    });
    assert!(
        round[0].contains("up to here and back to the first the points go 720.0000 deg round the axis"),
        "{round:?}"
    );
    let beside = edited(&|points| points.iter_mut().for_each(|point| point.x_mm += 100.0));
    assert!(
        beside.iter().all(|error| error.contains("the way the points began")) && beside.len() > 40,
        "{}",
        beside.len()
    );
}

/// Anything in, an answer out.
#[test]
fn no_points_make_it_panic() {
    for seed in 0..300 {
        let mut random = SplitMix64(seed);
        let mut points = disc(12 + usize::try_from(random.next() % 60).unwrap(), seed);
        for _ in 0..random.next() % 6 {
            let at = usize::try_from(random.next()).unwrap() % points.len();
            let value = random.one_of(&[0.0, -0.0, f64::NAN, f64::INFINITY, 1e308, -1e-308, 4.2, -19.0]);
            if random.next().is_multiple_of(2) { points[at].x_mm = value } else { points[at].y_mm = value }
        }
        if let Ok(rows) = rows_of(&points) {
            assert!(rows.iter().all(|row| row.value_mm.is_finite()), "seed {seed}");
        }
    }
}
