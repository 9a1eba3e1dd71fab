// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Valid lift tables, and every defect with its line, value and bound.

use crate::cams;

use cams::{SplitMix64, absolute, camshaft_segments, lobe_value, printed_rows, printed_values, program};
use camwright::cam::lift::{AngleUnit, LiftDeclaration, LiftError, LiftForm, LiftRow, LiftTable};
use camwright::cam::motion_law::MotionLaw;

fn increments(rows: &[LiftRow]) -> Vec<LiftRow> {
    (0..rows.len())
        .map(|k| {
            let units = |row: &LiftRow| (row.value_mm * 1000.0).round();
            let value_mm = (units(&rows[(k + 1) % rows.len()]) - units(&rows[k])) / 1000.0;
            LiftRow { value_mm, ..rows[k] }
        })
        .collect()
}

fn rows() -> Vec<LiftRow> {
    printed_rows(&program(0.0, &camshaft_segments()), 3600, 1e-3)
}

fn only_finding(rows: &[LiftRow], declaration: &LiftDeclaration) -> LiftError {
    let findings = LiftTable::findings(rows, declaration);
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(LiftTable::from_rows(rows, declaration).err().as_ref(), findings.first());
    findings[0].clone()
}

#[test]
fn increments_and_absolute_lifts_are_the_same_table() {
    for blocks in [3600, 360, 37, 12, 1001] {
        let rows = printed_rows(&program(0.0, &camshaft_segments()), blocks, 1e-3);
        let table = LiftTable::from_rows(&rows, &absolute(1e-3)).unwrap();
        let declaration = LiftDeclaration { form: LiftForm::Increments, ..absolute(1e-3) };
        assert_eq!(LiftTable::from_rows(&increments(&rows), &declaration).unwrap(), table);
        // And without an angle column.
        let bare: Vec<LiftRow> = increments(&rows).iter().map(|row| LiftRow { angle_deg: None, ..*row }).collect();
        assert_eq!(LiftTable::from_rows(&bare, &declaration).unwrap(), table);
        for (block, row) in rows.iter().enumerate() {
            assert_eq!(table.lift_mm(block).to_bits(), (row.value_mm + 0.0).to_bits(), "the printed figure itself");
            assert_eq!(table.increment_units(block), table.lift_units(block + 1) - table.lift_units(block));
        }
    }
}

#[test]
fn crank_degrees_declared_as_such_are_a_table() {
    let cam = rows();
    let crank: Vec<LiftRow> =
        cam.iter().map(|row| LiftRow { angle_deg: row.angle_deg.map(|angle| 2.0 * angle), ..*row }).collect();
    let declaration = LiftDeclaration { angle_unit: AngleUnit::CrankDegrees, ..absolute(1e-3) };
    assert_eq!(
        LiftTable::from_rows(&crank, &declaration).unwrap(),
        LiftTable::from_rows(&cam, &absolute(1e-3)).unwrap()
    );
}

/// Angles from −180°, and a last row that repeats the first.
#[test]
fn a_table_may_begin_anywhere_and_close_itself() {
    let rows = rows();
    let plain = LiftTable::from_rows(&rows, &absolute(1e-3)).unwrap();
    let mut turned: Vec<LiftRow> = rows[1800..].iter().chain(&rows[..1800]).copied().collect();
    for (k, row) in turned.iter_mut().enumerate() {
        row.angle_deg = Some(-180.0 + k as f64 * 0.1);
    }
    assert_eq!(LiftTable::from_rows(&turned, &absolute(1e-3)).unwrap(), plain);
    let mut closed = rows.clone();
    closed.push(LiftRow { line: 3602, angle_deg: Some(360.0), value_mm: rows[0].value_mm });
    assert_eq!(LiftTable::from_rows(&closed, &absolute(1e-3)).unwrap(), plain);
    closed[3600].value_mm += 0.002;
    assert!(matches!(
        only_finding(&closed, &absolute(1e-3)),
        LiftError::Misclosure { line: 3602, units: 2, bound_mm, .. } if (bound_mm - 5e-4).abs() < 1e-12
    ));
}

#[test]
fn angles_rounded_by_the_printer_pass() {
    for (blocks, digits) in [(7000, 4), (700, 3), (7, 0)] {
        let mut rows = printed_rows(&program(0.0, &camshaft_segments()), blocks.max(12), 1e-3);
        let scale = 10_f64.powi(digits);
        for row in &mut rows {
            row.angle_deg = row.angle_deg.map(|angle| (angle * scale).round() / scale);
        }
        assert_eq!(LiftTable::findings(&rows, &absolute(1e-3)), []);
    }
}

#[test]
fn duplicate_angle_is_refused() {
    let mut rows = rows();
    rows[1000].angle_deg = rows[999].angle_deg;
    let findings = LiftTable::findings(&rows, &absolute(1e-3));
    assert!(
        matches!(findings[0], LiftError::DuplicateAngle { line: 1002, angle_deg, previous_line: 1001 }
            if (angle_deg - 99.9).abs() < 1e-9),
        "{findings:?}"
    );
    // A row that stands twice.
    let mut rows = self::rows();
    rows.insert(1000, rows[999]);
    assert!(matches!(LiftTable::from_rows(&rows, &absolute(1e-3)), Err(LiftError::DuplicateAngle { .. })));
}

#[test]
fn angle_that_goes_back_is_refused() {
    let mut rows = rows();
    rows.swap(2000, 2001);
    let findings = LiftTable::findings(&rows, &absolute(1e-3));
    assert!(
        findings.iter().any(|finding| matches!(finding, LiftError::AngleNotIncreasing { line: 2002, .. })),
        "{findings:?}"
    );
}

#[test]
fn missing_block_is_refused() {
    let mut rows = rows();
    rows.remove(1234);
    assert!(matches!(
        only_finding(&rows, &absolute(1e-3)),
        LiftError::MissingBlock { line: 1237, count: 1, expected_deg, angle_deg }
            if (expected_deg - 123.4).abs() < 1e-9 && (angle_deg - 123.5).abs() < 1e-9
    ));
    let mut rows = self::rows();
    rows.truncate(3598);
    assert!(matches!(only_finding(&rows, &absolute(1e-3)), LiftError::MissingBlock { line: 3599, count: 2, .. }));
    // Without angles the number of rows must be declared.
    let bare: Vec<LiftRow> = rows.iter().map(|row| LiftRow { angle_deg: None, ..*row }).collect();
    let declaration = LiftDeclaration { blocks: Some(3600), ..absolute(1e-3) };
    assert_eq!(only_finding(&bare, &declaration), LiftError::BlockCount { line: 3599, count: 3598, declared: 3600 });
    let mut half = self::rows();
    half[17].angle_deg = None;
    assert_eq!(only_finding(&half, &absolute(1e-3)), LiftError::AngleMissing { line: 19 });
}

#[test]
fn what_is_no_number_is_refused() {
    let mut rows = rows();
    rows[5].value_mm = f64::NAN;
    rows[7].angle_deg = Some(f64::INFINITY);
    let findings = LiftTable::findings(&rows, &absolute(1e-3));
    assert!(matches!(
        findings[..],
        [
            LiftError::NotFinite { line: 7, what: "the lift", .. },
            LiftError::NotFinite { line: 9, what: "the angle", .. }
        ]
    ));
}

#[test]
fn crank_degrees_declared_as_cam_degrees_are_refused() {
    let mut rows = rows();
    for row in &mut rows {
        row.angle_deg = row.angle_deg.map(|angle| 2.0 * angle);
    }
    let error = only_finding(&rows, &absolute(1e-3));
    assert!(
        matches!(error, LiftError::CrankDegrees { line: 1802, covered_deg } if (covered_deg - 720.0).abs() < 1e-6),
        "{error:?}"
    );
    assert!(error.to_string().contains("720.00 deg") && error.to_string().contains("crank"), "{error}");
    let declaration = LiftDeclaration { angle_unit: AngleUnit::CrankDegrees, ..absolute(1e-3) };
    let error = only_finding(&self::rows(), &declaration);
    assert!(
        matches!(error, LiftError::CamDegrees { line: 3601, covered_deg } if (covered_deg - 360.0).abs() < 1e-6),
        "{error:?}"
    );
}

#[test]
fn sum_that_does_not_close_is_refused() {
    let declaration = LiftDeclaration { form: LiftForm::Increments, ..absolute(1e-3) };
    let mut rows = increments(&rows());
    rows[1500].value_mm += 0.001;
    let error = only_finding(&rows, &declaration);
    assert!(matches!(error, LiftError::Misclosure { units: 1, .. }), "{error:?}");
    assert!(error.to_string().contains("0.001 mm"), "{error}");
}

/// In steep places and in flat ones, one row off or everything after it off, in tables fine and coarse.
#[test]
fn steps_are_refused_where_they_are() {
    for (blocks, size_mm) in [(3600_u32, 0.05), (3600, 0.02), (360, 0.3), (72, 2.0)] {
        let clean = printed_rows(&program(0.0, &camshaft_segments()), blocks, 1e-3);
        assert_eq!(LiftTable::findings(&clean, &absolute(1e-3)), []);
        for at in [3, blocks as usize / 4, blocks as usize * 35 / 100, blocks as usize / 2, blocks as usize - 3] {
            let mut stray = clean.clone();
            stray[at].value_mm += size_mm;
            let error = only_finding(&stray, &absolute(1e-3));
            assert!(
                matches!(error, LiftError::Outlier { line, off_mm, .. } if line == at + 2
                    && (off_mm - size_mm).abs() < 0.2 * size_mm),
                "{blocks}, {at}: {error:?}"
            );
            let mut raised = clean.clone();
            let end = (at + blocks as usize / 10).min(blocks as usize);
            for row in &mut raised[at..end] {
                row.value_mm += size_mm;
            }
            let findings = LiftTable::findings(&raised, &absolute(1e-3));
            assert!(
                findings.iter().any(|finding| matches!(finding, LiftError::Step { line, .. } if *line == at + 2)),
                "{blocks}, {at}: {findings:?}"
            );
        }
    }
}

/// No sound table is taken for a broken one: every law, any number of blocks, any digit.
#[test]
fn sound_tables_pass() {
    let mut random = SplitMix64(41);
    for law in [
        MotionLaw::Harmonic,
        MotionLaw::Cycloidal,
        MotionLaw::Polynomial345,
        MotionLaw::Polynomial4567,
        MotionLaw::ModifiedSine,
        MotionLaw::ModifiedTrapezoid,
    ] {
        for _ in 0..20 {
            let (lift_mm, half_angle_deg) = (random.within(0.05, 12.0), random.within(40.0, 170.0));
            let resolution_mm = random.one_of(&[1e-2, 1e-3, 1e-4, 1e-6]);
            let blocks = random.one_of(&[72, 360, 719, 1440, 3600]);
            let rows = printed_values(lobe_value(law, lift_mm, half_angle_deg), blocks, resolution_mm);
            assert_eq!(
                LiftTable::findings(&rows, &absolute(resolution_mm)),
                [],
                "{law:?} {lift_mm} mm over {half_angle_deg} deg, {blocks} blocks of {resolution_mm} mm"
            );
        }
    }
}

#[test]
fn other_findings() {
    let rows = rows();
    assert_eq!(
        only_finding(&rows[..11], &LiftDeclaration { blocks: Some(11), ..absolute(1e-3) }),
        LiftError::TooFewRows { count: 11, min: 12 }
    );
    assert!(matches!(only_finding(&rows, &absolute(0.0)), LiftError::BadResolution { .. }));
    assert!(matches!(only_finding(&rows, &absolute(f64::INFINITY)), LiftError::BadResolution { .. }));
    let mut below = rows.clone();
    for row in &mut below {
        row.value_mm -= 0.001;
    }
    let findings = LiftTable::findings(&below, &absolute(1e-3));
    assert!(matches!(findings[0], LiftError::BelowBase { line: 2, .. }), "{findings:?}");
    let mut uneven = rows.clone();
    uneven[100].angle_deg = Some(10.03);
    assert!(matches!(
        only_finding(&uneven, &absolute(1e-3)),
        LiftError::UnevenAngle { line: 102, off_deg, bound_deg, .. }
            if (off_deg - 0.03).abs() < 1e-9 && (bound_deg - 0.0005).abs() < 1e-9
    ));
    let mut huge = rows.clone();
    huge[3].value_mm = 1e6;
    assert!(matches!(only_finding(&huge, &absolute(1e-3)), LiftError::TooLarge { line: 5, .. }));
    let mut irrational = rows.clone();
    irrational[3].value_mm = 1e-3 * core::f64::consts::SQRT_2;
    assert!(matches!(only_finding(&irrational, &absolute(1e-3)), LiftError::OffDigit { line: 5, .. }));
    let declaration = LiftDeclaration { blocks: Some(1800), ..absolute(1e-3) };
    assert!(matches!(LiftTable::from_rows(&rows, &declaration), Err(LiftError::UnevenAngle { line: 3, .. })));
}
