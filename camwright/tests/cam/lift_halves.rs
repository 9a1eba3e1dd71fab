// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Half tables: the nose first, one flank, mirrored or with another; and everything that makes none.

use crate::cams;

use cams::{absolute, lobe, printed_rows, program, segment};
use camwright::cam::lift::halves::whole_turn;
use camwright::cam::lift::{AngleUnit, LiftDeclaration, LiftError, LiftRow, LiftTable, LiftWarning};
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, rad_from_deg};

/// The closing flank of a whole table with the nose at 180°, as a designer prints it; `rows` rows from line 2 on.
fn closing(whole: &[LiftRow], rows: usize) -> Vec<LiftRow> {
    let (n, step) = (whole.len(), 360.0 / whole.len() as f64);
    (0..rows)
        .map(|k| LiftRow { line: k + 2, angle_deg: Some(k as f64 * step), value_mm: whole[(n / 2 + k) % n].value_mm })
        .collect()
}

fn opening(whole: &[LiftRow], rows: usize) -> Vec<LiftRow> {
    let (n, step) = (whole.len(), 360.0 / whole.len() as f64);
    (0..rows)
        .map(|k| LiftRow {
            line: k + 2,
            angle_deg: Some(k as f64 * step),
            value_mm: whole[(n + n / 2 - k) % n].value_mm,
        })
        .collect()
}

fn joined(closing: &[LiftRow], opening: Option<&[LiftRow]>, declaration: &LiftDeclaration) -> LiftTable {
    let (rows, doubts) = whole_turn(closing, opening, 180.0, declaration).expect("flanks without fault");
    assert_eq!(doubts, []);
    LiftTable::from_rows(&rows, declaration).expect("a table without fault")
}

/// Full, just long enough, or down to one row on the base circle; with an odd number of blocks no row is opposite.
#[test]
fn a_mirrored_flank_is_the_symmetric_table() {
    let law = lobe(MotionLaw::Polynomial4567, 6.0, 60.0);
    for (blocks, rows) in [(360_u32, 181_usize), (360, 62), (360, 120), (3600, 700)] {
        let whole = printed_rows(&law, blocks, 1e-3);
        let table = joined(&closing(&whole, rows), None, &absolute(1e-3));
        assert_eq!(table, LiftTable::from_rows(&whole, &absolute(1e-3)).unwrap(), "{blocks} {rows}");
    }
}

/// Two different flanks in two tables of different length.
#[test]
fn opening_and_closing_may_differ() {
    let deg = |angle, law, rise| segment(law, rad_from_deg(angle), rise);
    let law = program(
        0.0,
        &[
            deg(110.0, MotionLaw::Dwell, 0.0),
            deg(70.0, MotionLaw::Polynomial4567, 5.0),
            deg(55.0, MotionLaw::Cycloidal, -5.0),
            deg(125.0, MotionLaw::Dwell, 0.0),
        ],
    );
    let whole = printed_rows(&law, 720, 1e-3);
    let table = joined(&closing(&whole, 130), Some(&opening(&whole, 150)), &absolute(1e-3));
    assert_eq!(table, LiftTable::from_rows(&whole, &absolute(1e-3)).unwrap());
}

#[test]
fn crank_degrees_of_a_half_table_are_halved() {
    let whole = printed_rows(&lobe(MotionLaw::Polynomial345, 6.0, 60.0), 720, 1e-3);
    let mut flank = closing(&whole, 140);
    for row in &mut flank {
        row.angle_deg = row.angle_deg.map(|angle| 2.0 * angle);
    }
    let declaration = LiftDeclaration { angle_unit: AngleUnit::CrankDegrees, ..absolute(1e-3) };
    assert_eq!(joined(&flank, None, &declaration), LiftTable::from_rows(&whole, &absolute(1e-3)).unwrap());
    // Declared as cam degrees the same file is suspicious, not wrong.
    let (_, doubts) = whole_turn(&flank, None, 180.0, &absolute(1e-3)).unwrap();
    assert!(matches!(doubts[..], [LiftWarning::MaybeOtherDegrees { other: "crank", .. }]), "{doubts:?}");
    let cam = closing(&whole, 140);
    let short = LiftDeclaration { angle_unit: AngleUnit::CrankDegrees, ..absolute(1e-3) };
    let (_, doubts) = whole_turn(&cam, None, 180.0, &short).unwrap();
    assert!(matches!(doubts[..], [LiftWarning::MaybeOtherDegrees { other: "cam", .. }]), "{doubts:?}");
}

#[test]
fn the_nose_is_at_its_declared_angle() {
    let law = lobe(MotionLaw::Polynomial4567, 6.0, 60.0);
    let flank = closing(&printed_rows(&law, 360, 1e-3), 70);
    let (rows, _) = whole_turn(&flank, None, 25.0, &absolute(1e-3)).unwrap();
    let table = LiftTable::from_rows(&rows, &absolute(1e-3)).unwrap();
    for block in 0..360 {
        let angle = (block as f64 - 25.0 + 180.0) * TURN_RAD / 360.0;
        assert!((table.lift_mm(block) - law.sample(angle).value).abs() <= 0.5e-3 * (1.0 + 1e-9), "{block}");
    }
    assert!(matches!(
        whole_turn(&flank, None, 25.3, &absolute(1e-3)).unwrap_err()[..],
        [LiftError::ZeroOffStep { zero_deg, .. }] if (zero_deg - 25.3).abs() < 1e-12
    ));
}

#[test]
fn what_is_no_flank_is_refused_with_its_line() {
    let whole = printed_rows(&lobe(MotionLaw::Polynomial345, 6.0, 60.0), 360, 1e-3);
    let refused = |change: &dyn Fn(&mut Vec<LiftRow>)| {
        let mut flank = closing(&whole, 90);
        change(&mut flank);
        whole_turn(&flank, None, 180.0, &absolute(1e-3)).unwrap_err()
    };
    assert!(matches!(
        refused(&|rows| rows.reverse())[0],
        LiftError::NoseNotFirst { .. } | LiftError::HalfStart { .. } | LiftError::AngleNotIncreasing { .. }
    ));
    assert!(matches!(
        refused(&|rows| rows.iter_mut().for_each(|row| row.angle_deg = row.angle_deg.map(|angle| angle + 1.0)))[..],
        [LiftError::HalfStart { line: 2, angle_deg }] if (angle_deg - 1.0).abs() < 1e-12
    ));
    assert!(matches!(
        refused(&|rows| rows.truncate(40))[..],
        [LiftError::FlankEndsHigh { line: 41, bound_mm, .. }] if (bound_mm - 5e-4).abs() < 1e-12
    ));
    assert!(matches!(
        refused(&|rows| rows[0].value_mm -= 0.01)[..],
        [LiftError::NoseNotFirst { line: 3, nose_line: 2, .. }, ..]
    ));
    assert!(matches!(
        refused(&|rows| rows[30].angle_deg = Some(29.0))[..],
        [LiftError::DuplicateAngle { line: 32, previous_line: 31, .. }, LiftError::MissingBlock { line: 33, .. }]
    ));
    let long: Vec<LiftRow> = (0..200)
        .map(|k| LiftRow { line: k + 2, angle_deg: Some(k as f64), value_mm: whole[(180 + k) % 360].value_mm })
        .collect();
    assert!(
        whole_turn(&long, None, 180.0, &absolute(1e-3))
            .unwrap_err()
            .iter()
            .any(|finding| matches!(finding, LiftError::HalfSpan { line: 183, .. }))
    );
    // Two faults at once, one in the angles and one in the lifts.
    let both = refused(&|rows| {
        rows[60].angle_deg = Some(60.3);
        rows[20].value_mm += 0.4;
    });
    assert!(
        matches!(both[..], [LiftError::Outlier { line: 22, .. }, LiftError::UnevenAngle { line: 62, .. }]),
        "{both:?}"
    );
}

/// A stray row of a mirrored flank is one finding, at its line.
#[test]
fn a_fault_of_a_mirrored_flank_is_reported_once() {
    let whole = printed_rows(&lobe(MotionLaw::Polynomial345, 6.0, 60.0), 360, 1e-3);
    let mut flank = closing(&whole, 90);
    flank[25].value_mm += 0.3;
    let (rows, _) = whole_turn(&flank, None, 180.0, &absolute(1e-3)).unwrap();
    let findings = LiftTable::findings(&rows, &absolute(1e-3));
    assert!(matches!(findings[..], [LiftError::Outlier { line: 27, .. }]), "{findings:?}");
}

#[test]
fn flanks_that_do_not_meet_are_refused() {
    let whole = printed_rows(&lobe(MotionLaw::Polynomial345, 6.0, 60.0), 360, 1e-3);
    let (first, second) = (opening(&whole, 90), closing(&whole, 90));
    let mut higher = first.clone();
    higher[0].value_mm += 0.005;
    assert!(matches!(
        whole_turn(&second, Some(&higher), 180.0, &absolute(1e-3)).unwrap_err()[..],
        [LiftError::HalvesDisagree { line: 2, opening_mm, closing_mm, .. }]
            if (opening_mm - 6.005).abs() < 1e-9 && (closing_mm - 6.0).abs() < 1e-9
    ));
    let fine = opening(&printed_rows(&lobe(MotionLaw::Polynomial345, 6.0, 60.0), 720, 1e-3), 180);
    assert!(matches!(
        whole_turn(&second, Some(&fine), 180.0, &absolute(1e-3)).unwrap_err()[..],
        [LiftError::HalvesStep { .. }]
    ));
}
