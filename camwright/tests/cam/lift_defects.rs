// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Seeded defects in random tables: each is found at its line and as what it is, all of them at once, and a table without
//! defects is never refused.

use crate::cams;

use cams::{SplitMix64, absolute, printed_rows, program, random_segments};
use camwright::cam::lift::halves::{check_flank, whole_turn};
use camwright::cam::lift::{AngleUnit, LengthUnit, LiftDeclaration, LiftError, LiftForm, LiftRow, LiftTable};

const SEED: u64 = 20_260_003;

/// A table of a random cam: its rows and its digit (mm).
fn random_table(random: &mut SplitMix64) -> (Vec<LiftRow>, f64) {
    let law = program(0.0, &random_segments(random));
    let resolution_mm = random.one_of(&[1e-2, 1e-3, 1e-4, 1e-5]);
    let blocks = random.one_of(&[180, 360, 719, 1440, 3600]);
    (printed_rows(&law, blocks, resolution_mm), resolution_mm)
}

/// An offset that no rounding and no curvature of the table explains: the largest second difference and 15 digits.
fn conspicuous_mm(rows: &[LiftRow], digit_mm: f64) -> f64 {
    let n = rows.len();
    let y = |k: usize| rows[k % n].value_mm;
    let second = (0..n).map(|k| (y(k + 1) - 2.0 * y(k) + y(k + n - 1)).abs()).fold(0.0, f64::max);
    ((second + 15.0 * digit_mm) / digit_mm).ceil() * digit_mm
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Defect {
    Duplicate,
    Gap,
    NotANumber,
    Outlier,
    Uneven,
    NoAngle,
    Backwards,
}

const DEFECTS: [Defect; 7] = [
    Defect::Duplicate,
    Defect::Gap,
    Defect::NotANumber,
    Defect::Outlier,
    Defect::Uneven,
    Defect::NoAngle,
    Defect::Backwards,
];

/// Returns whether a finding names this defect at this row (line = row + 2).
fn reports(finding: &LiftError, defect: Defect, row: usize) -> bool {
    let line = row + 2;
    match *finding {
        LiftError::DuplicateAngle { line: at, previous_line, .. } => {
            defect == Defect::Duplicate && at == line && previous_line == line - 1
        }
        LiftError::MissingBlock { line: at, count, .. } => defect == Defect::Gap && at == line + 1 && count == 1,
        LiftError::NotFinite { line: at, what, .. } => defect == Defect::NotANumber && at == line && what == "the lift",
        LiftError::Outlier { line: at, .. } => defect == Defect::Outlier && at == line,
        LiftError::UnevenAngle { line: at, .. } => defect == Defect::Uneven && at == line,
        LiftError::AngleMissing { line: at } => defect == Defect::NoAngle && at == line,
        LiftError::AngleNotIncreasing { line: at, .. } => defect == Defect::Backwards && at == line,
        _ => false,
    }
}

#[test]
fn every_seeded_defect_is_found_at_its_line_and_nothing_else() {
    eprintln!("seed {SEED}");
    let mut random = SplitMix64(SEED);
    for case in 0..400 {
        let (clean, digit_mm) = random_table(&mut random);
        let (n, offset_mm) = (clean.len(), conspicuous_mm(&clean, digit_mm));
        let step_deg = 360.0 / n as f64;
        let mut rows: Vec<Option<LiftRow>> = clean.iter().copied().map(Some).collect();
        let mut planted: Vec<(Defect, usize)> = Vec::new();
        for _ in 0..1 + random.next() % 6 {
            let row = 8 + usize::try_from(random.next() % (n as u64 - 16)).expect("small");
            if planted.iter().any(|(_, at)| at.abs_diff(row) < 12) {
                continue;
            }
            let defect = random.one_of(&DEFECTS);
            let here = rows[row].as_mut().expect("defects keep their distance");
            match defect {
                Defect::Duplicate => *here = LiftRow { line: row + 2, ..clean[row - 1] },
                Defect::Gap => rows[row] = None,
                Defect::NotANumber => here.value_mm = f64::NAN,
                Defect::Outlier => here.value_mm += random.one_of(&[-1.0, 1.0]) * offset_mm,
                Defect::Uneven => here.angle_deg = here.angle_deg.map(|angle| angle + 0.2 * step_deg),
                Defect::NoAngle => here.angle_deg = None,
                Defect::Backwards => {
                    let (a, b) = (clean[row - 1], clean[row]);
                    rows[row - 1] = Some(LiftRow { line: a.line, ..b });
                    rows[row] = Some(LiftRow { line: b.line, ..a });
                }
            }
            planted.push((defect, row));
        }
        let rows: Vec<LiftRow> = rows.into_iter().flatten().collect();
        let findings = LiftTable::findings(&rows, &absolute(digit_mm));
        for &(defect, row) in &planted {
            assert!(
                findings.iter().any(|finding| reports(finding, defect, row)),
                "seed {SEED}, case {case}, {n} rows of {digit_mm}: {defect:?} in line {} is not reported: {findings:?}",
                row + 2
            );
        }
        for finding in &findings {
            let at = finding.line().expect("all are about rows");
            assert!(
                planted.iter().any(|(_, row)| at.abs_diff(row + 2) <= 2),
                "seed {SEED}, case {case}, {n} rows of {digit_mm}: nothing is wrong at {finding}; planted {planted:?}"
            );
            assert!(finding.to_string().contains(&format!("line {at}")), "{finding}");
        }
        assert!(findings.is_sorted_by_key(LiftError::line), "row by row: {findings:?}");
    }
}

#[test]
fn random_tables_without_defects_never_trip() {
    eprintln!("seed {SEED}");
    let mut random = SplitMix64(SEED ^ 1);
    for case in 0..1500 {
        let (rows, digit_mm) = random_table(&mut random);
        let read = LiftTable::read(&rows, &absolute(digit_mm));
        let Ok((table, doubts)) = read else { panic!("seed {SEED}, case {case}: {read:?}") };
        assert_eq!(table.blocks(), rows.len());
        let doubted =
            doubts.iter().any(|doubt| !matches!(doubt, camwright::cam::lift::LiftWarning::MaybeInches { .. }));
        assert!(!doubted, "seed {SEED}, case {case}: {doubts:?}");
    }
}

/// A mistyped increment is reported at its own line, and the open turn with it.
#[test]
fn a_wrong_increment_is_found_at_its_line() {
    eprintln!("seed {SEED}");
    let mut random = SplitMix64(SEED ^ 2);
    for case in 0..200 {
        let (lifts, digit_mm) = random_table(&mut random);
        let (n, offset_mm) = (lifts.len(), conspicuous_mm(&lifts, digit_mm));
        let per_mm = (1.0 / digit_mm).round();
        let mut rows: Vec<LiftRow> = (0..n)
            .map(|k| {
                let increment = lifts[(k + 1) % n].value_mm - lifts[k].value_mm;
                LiftRow { value_mm: (increment * per_mm).round() / per_mm, ..lifts[k] }
            })
            .collect();
        let declaration = LiftDeclaration { form: LiftForm::Increments, ..absolute(digit_mm) };
        assert_eq!(LiftTable::findings(&rows, &declaration), [], "case {case}");
        let row = 8 + usize::try_from(random.next() % (n as u64 - 16)).expect("small");
        rows[row].value_mm += 2.0 * offset_mm;
        let findings = LiftTable::findings(&rows, &declaration);
        assert!(
            matches!(findings[..], [LiftError::Step { line, .. }, LiftError::Misclosure { .. }] if line == row + 2),
            "seed {SEED}, case {case}, line {}: {findings:?}",
            row + 2
        );
    }
}

/// Noise of a measured table sets the scale for its outliers: outliers are found, noise is not.
#[test]
fn noise_raises_the_allowance_of_its_own_table() {
    eprintln!("seed {SEED}");
    let mut random = SplitMix64(SEED ^ 3);
    let (mut found, cases) = (0, 60);
    for case in 0..cases {
        let law = program(0.0, &random_segments(&mut random));
        let mut rows = printed_rows(&law, 720, 1e-4);
        for row in &mut rows {
            // Roughly normal, 1 um.
            let noise: f64 = (0..12).map(|_| random.within(-0.5, 0.5)).sum();
            row.value_mm = ((row.value_mm + 0.02 + 1e-3 * noise) * 1e4).round() / 1e4;
        }
        assert_eq!(LiftTable::findings(&rows, &absolute(1e-4)), [], "seed {SEED}, case {case}");
        let at = usize::try_from(random.next() % 720).expect("small");
        rows[at].value_mm += 0.05;
        let findings = LiftTable::findings(&rows, &absolute(1e-4));
        found += usize::from(matches!(findings[..], [LiftError::Outlier { line, .. }] if line == at + 2));
    }
    assert_eq!(found, cases, "outliers of 50 um in noise of 1 um");
}

/// Rows of anything: what comes out is a table or findings, never a panic, and the first finding is the refusal.
#[test]
fn no_rows_make_the_checks_panic() {
    eprintln!("seed {SEED}");
    let mut random = SplitMix64(SEED ^ 4);
    let mut tables = 0;
    for case in 0..3000 {
        let any_count = usize::try_from(random.next() % 60).expect("small");
        let count = random.one_of(&[40, 41, 20, any_count]);
        let step = random.one_of(&[0.0, 1e-7, 1e-3, 0.1, 9.0, 9.0, 9.0, 18.0, 10.0, 1e9]);
        let wild = random.one_of(&[0.0, 0.02, 0.5]);
        let any = |random: &mut SplitMix64, plain: f64| {
            if random.within(0.0, 1.0) < wild {
                random.one_of(&[f64::NAN, f64::INFINITY, -1e308, 1e308, 1e-300, -1.0, 0.0, 999.0, 1e15])
            } else {
                plain
            }
        };
        let rows: Vec<LiftRow> = (0..count)
            .map(|k| LiftRow {
                line: k,
                angle_deg: (random.within(0.0, 1.0) > 0.1 * wild).then(|| any(&mut random, k as f64 * step)),
                value_mm: any(
                    &mut random,
                    0.001 * (3000.0 * (1.0 - (k as f64 * std::f64::consts::TAU / 40.0).cos())).round(),
                ),
            })
            .collect();
        let declaration = LiftDeclaration {
            form: random.one_of(&[LiftForm::Absolute, LiftForm::Increments]),
            angle_unit: random.one_of(&[AngleUnit::CamDegrees, AngleUnit::CrankDegrees]),
            resolution_mm: random.one_of(&[1e-3, 1e-3, 1e-2, 1e-9, 1.0, 0.0, f64::NAN]),
            unit: random.one_of(&[LengthUnit::Millimetre, LengthUnit::Inch]),
            smooth_within_mm: random.one_of(&[0.0, 0.01, f64::NAN]),
            lowest_mm: random.one_of(&[0.0, 0.0, -5.0, f64::NAN]),
            blocks: random.one_of(&[None, None, None, Some(0), Some(40), Some(usize::MAX)]),
        };
        let findings = LiftTable::findings(&rows, &declaration);
        match LiftTable::from_rows(&rows, &declaration) {
            Ok(table) => {
                assert_eq!(findings, [], "case {case}");
                assert!(table.lifts_mm().iter().all(|lift| lift.is_finite()));
                tables += 1;
            }
            Err(error) => assert_eq!(error.to_string(), findings[0].to_string(), "case {case}"),
        }
        let (flank, _) = check_flank(&rows, &declaration);
        let nose = random.one_of(&[180.0, 0.0, -1e300, f64::NAN, 7.0]);
        if let Ok((whole, _)) = whole_turn(&rows, None, nose, &declaration) {
            assert!(flank.is_empty(), "case {case}: {flank:?}");
            let _table_or_findings = LiftTable::read(&whole, &declaration);
        }
    }
    assert!(tables > 20, "{tables} of the cases are tables");
}
