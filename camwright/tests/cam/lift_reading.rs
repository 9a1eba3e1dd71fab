// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cost of each reading of a table: its jerk, and the distance of a smoothed curve from the values.

use crate::cams;

use cams::{SplitMix64, absolute, lobe, printed, printed_rows, segment};
use camwright::cam::lift::law::alternatives;
use camwright::cam::lift::{
    LengthUnit, LiftDeclaration, LiftLaw, LiftLawError, LiftTable, LiftWarning, MotionProgram, ProgramError,
    TableMethod,
};
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, rad_from_deg};

/// The figures of 1 µm at 0.1° have hundreds of times the jerk of the law; at 1 nm both readings have the law's own.
#[test]
fn the_cubic_spline_shows_the_jerk_of_rounding() {
    let law = lobe(MotionLaw::Polynomial4567, 8.0, 62.0);
    let truth = 52.5 * 8.0 / rad_from_deg(62.0).powi(3);
    assert!((law.peak_jerk_mm_rad3() - truth).abs() < 1e-6 * truth, "{}", law.peak_jerk_mm_rad3());
    let table = printed(&law, 3600, 1e-3);
    let read = |table: &LiftTable, reading| LiftLaw::read_table(table, reading).unwrap().reading().unwrap();
    let (smooth, cubic) = (read(&table, TableMethod::Smoothest), read(&table, TableMethod::CubicSpline));
    assert!(smooth.peak_jerk_mm_rad3 < 1.01 * truth, "{smooth:?}");
    assert!(cubic.peak_jerk_mm_rad3 > 300.0 * truth, "{cubic:?}");
    assert!(cubic.max_deviation_mm < 1e-12 && smooth.max_deviation_mm > 1e-4);
    let fine = read(&printed(&law, 720, 1e-7), TableMethod::CubicSpline);
    assert!((fine.peak_jerk_mm_rad3 / truth - 1.0).abs() < 0.05, "{fine:?}");
    // Every alternative reading is listed beside the chosen one.
    let names =
        |chosen| alternatives(&table, chosen).unwrap().iter().map(|other| other.reading.name()).collect::<Vec<_>>();
    assert_eq!(names(TableMethod::Smoothest), ["cubic_spline"]);
    assert_eq!(names(TableMethod::CubicSpline), ["smoothest"]);
    assert_eq!(names(TableMethod::SmoothWithin { tolerance_mm: 0.01 }), ["smoothest", "cubic_spline"]);
}

#[test]
fn the_cubic_spline_goes_through_every_figure_with_continuous_acceleration() {
    let table = printed(&lobe(MotionLaw::Cycloidal, 6.0, 70.0), 361, 1e-3);
    let law = LiftLaw::read_table(&table, TableMethod::CubicSpline).unwrap();
    for block in 0..table.blocks() {
        let angle = block as f64 * table.block_rad();
        assert!((law.sample(angle).value - table.lift_mm(block)).abs() < 1e-12, "{block}");
        let jump = law.sample(angle + 1e-9).second - law.sample(angle - 1e-9).second;
        assert!(jump.abs() < 1e-3, "{block}: {jump}");
    }
    assert!((law.max_lift_mm() - 6.0).abs() < 1e-2);
}

/// Noise of ±4 µm on every row: smoothing to 5 µm keeps every point within them and takes the jerk of the noise away; the
/// wider the tolerance the less jerk.
#[test]
fn smoothing_stays_within_its_tolerance_and_lowers_the_jerk() {
    let mut random = SplitMix64(77);
    let law = lobe(MotionLaw::Polynomial4567, 8.0, 62.0);
    let truth = law.peak_jerk_mm_rad3();
    let mut rows = printed_rows(&law, 720, 1e-3);
    for row in &mut rows {
        row.value_mm = ((row.value_mm + random.within(-0.004, 0.004)) * 1e3).round() / 1e3;
    }
    let declaration = LiftDeclaration { smooth_within_mm: 0.005, ..absolute(1e-3) };
    let (table, doubts) = LiftTable::read(&rows, &declaration).unwrap();
    assert_eq!(doubts, []);
    let mut jerks = Vec::new();
    for tolerance_mm in [0.0005, 0.001, 0.002, 0.005, 0.02] {
        let smooth = LiftLaw::read_table(&table, TableMethod::SmoothWithin { tolerance_mm }).unwrap();
        let reading = smooth.reading().unwrap();
        let (mut largest, mut squares) = (0.0_f64, 0.0);
        for block in 0..table.blocks() {
            let off = (smooth.sample(block as f64 * table.block_rad()).value - table.lift_mm(block)).abs();
            assert!(off <= tolerance_mm * (1.0 + 1e-9), "{block}: {off}");
            largest = largest.max(off);
            squares += off * off;
        }
        assert!((reading.max_deviation_mm - largest).abs() < 1e-12, "{reading:?} {largest}");
        assert!((reading.rms_deviation_mm - (squares / 720.0).sqrt()).abs() < 1e-12, "{reading:?}");
        let at = (reading.max_deviation_rad / table.block_rad()).round();
        #[allow(clippy::cast_possible_truncation, reason = "a block")]
        let off = (smooth.sample(reading.max_deviation_rad).value - table.lift_mm(at as usize)).abs();
        assert!((off - largest).abs() < 1e-9, "where it says");
        jerks.push(reading.peak_jerk_mm_rad3);
    }
    assert!(jerks.is_sorted_by(|a, b| a >= b), "{jerks:?}");
    assert!(jerks[0] > 50.0 * truth && jerks[3] < 1.2 * truth, "{jerks:?}, truly {truth}");
}

/// A tolerance of 0.2 mm, 200 times the noise: the flanks use it, the base circle keeps its place within a digit, between the rows too.
#[test]
fn smoothing_keeps_the_base_circle() {
    let mut random = SplitMix64(78);
    let law = lobe(MotionLaw::Polynomial4567, 8.0, 62.0);
    let mut rows = printed_rows(&law, 720, 1e-3);
    for row in &mut rows {
        row.value_mm = ((row.value_mm + random.within(-0.001, 0.001)) * 1e3).round() / 1e3;
    }
    let declaration = LiftDeclaration { smooth_within_mm: 0.2, ..absolute(1e-3) };
    let (table, _) = LiftTable::read(&rows, &declaration).unwrap();
    let smooth = LiftLaw::read_table(&table, TableMethod::SmoothWithin { tolerance_mm: 0.2 }).unwrap();
    let mut lowest = f64::INFINITY;
    for i in 0..7200 {
        let angle = f64::from(i) * TURN_RAD / 7200.0;
        let value = smooth.sample(angle).value;
        lowest = lowest.min(value);
        // Flanks and nose of the lobe lie within 62° of 180°; the ramp needs a little more.
        if (angle - TURN_RAD / 2.0).abs() > rad_from_deg(66.0) {
            assert!(value < 0.005, "{value} mm at {angle} rad");
        }
    }
    assert!(lowest > -0.001, "{lowest}");
    let reading = smooth.reading().unwrap();
    assert!(reading.max_deviation_mm > 0.05 && reading.max_deviation_mm <= 0.2 * (1.0 + 1e-9), "{reading:?}");
    let noisy = LiftLaw::from_table(&table).unwrap().peak_jerk_mm_rad3();
    assert!(reading.peak_jerk_mm_rad3 < 0.2 * noisy, "{reading:?}, {noisy}");
}

#[test]
fn a_tolerance_below_half_a_digit_is_refused() {
    let table = printed(&lobe(MotionLaw::Cycloidal, 6.0, 70.0), 360, 1e-3);
    for tolerance_mm in [0.0004, -1.0, 0.0, f64::NAN] {
        let error = LiftLaw::read_table(&table, TableMethod::SmoothWithin { tolerance_mm }).unwrap_err();
        assert!(
            matches!(error, LiftLawError::ToleranceTooSmall { half_digit_mm, .. } if half_digit_mm < 6e-4),
            "{error}"
        );
    }
}

/// All digits of a formula, at any spacing: read to the resolution the job declares.
#[test]
fn a_formula_printed_with_all_digits_is_a_table() {
    let law = lobe(MotionLaw::Polynomial4567, 6.0, 65.0);
    for blocks in [97_u32, 360, 1000] {
        let mut rows = printed_rows(&law, blocks, 1e-3);
        for (k, row) in rows.iter_mut().enumerate() {
            row.value_mm = law.sample(TURN_RAD * k as f64 / f64::from(blocks)).value;
        }
        let table = LiftTable::from_rows(&rows, &absolute(1e-6)).unwrap();
        let read = LiftLaw::from_table(&table).unwrap();
        assert!((read.peak_jerk_mm_rad3() / law.peak_jerk_mm_rad3() - 1.0).abs() < 0.05, "{blocks}");
    }
}

/// Arcs of an arm printed in thousandths of a degree are no decimal part of a millimetre; even a short lobe is a table.
#[test]
fn any_resolution_may_be_the_last_digit() {
    let digit_mm = 1e-3 * 42.0 * std::f64::consts::PI / 180.0;
    let law = lobe(MotionLaw::Polynomial4567, 6.0, 15.0);
    let mut rows = printed_rows(&law, 720, 1e-3);
    for (k, row) in rows.iter_mut().enumerate() {
        row.value_mm = (law.sample(TURN_RAD * k as f64 / 720.0).value / digit_mm).round() * digit_mm;
    }
    let table = LiftTable::from_rows(&rows, &absolute(digit_mm)).unwrap();
    assert!((table.digit_mm() - digit_mm).abs() < 1e-15);
    for (block, row) in rows.iter().enumerate() {
        assert!((table.lift_mm(block) - row.value_mm).abs() < 1e-12);
    }
}

/// Ten-thousandths of an inch are the digits of an inch table: 0.00254 mm each, and the printed figures come back exactly.
#[test]
fn inches_keep_their_digits() {
    let law = lobe(MotionLaw::Polynomial345, 8.89, 60.0);
    let inch = LengthUnit::Inch.mm();
    let mut rows = printed_rows(&law, 360, 1e-3);
    for (k, row) in rows.iter_mut().enumerate() {
        row.value_mm = (law.sample(TURN_RAD * k as f64 / 360.0).value / inch * 1e4).round() / 1e4 * inch;
    }
    let declaration = LiftDeclaration { unit: LengthUnit::Inch, ..absolute(1e-4 * inch) };
    let (table, doubts) = LiftTable::read(&rows, &declaration).unwrap();
    assert_eq!(doubts, []);
    assert!((table.digit_mm() - 0.00254).abs() < 1e-12, "{}", table.digit_mm());
    for (block, row) in rows.iter().enumerate() {
        assert!((table.lift_mm(block) - row.value_mm).abs() < 1e-12);
    }
    // Read as millimetres the same figures are a cam of a third of a millimetre; millimetres read as inches a giant.
    let as_mm: Vec<_> =
        rows.iter().map(|row| camwright::cam::lift::LiftRow { value_mm: row.value_mm / inch, ..*row }).collect();
    let (_, doubts) = LiftTable::read(&as_mm, &absolute(1e-4)).unwrap();
    assert!(matches!(doubts[..], [LiftWarning::MaybeInches { line: 180..=184, .. }]), "{doubts:?}");
    let mut as_inch = printed_rows(&law, 360, 1e-3);
    as_inch.iter_mut().for_each(|row| row.value_mm *= inch);
    let (_, doubts) =
        LiftTable::read(&as_inch, &LiftDeclaration { unit: LengthUnit::Inch, ..absolute(1e-3 * inch) }).unwrap();
    assert!(matches!(doubts[..], [LiftWarning::MaybeMillimetres { line: 180..=184, .. }]), "{doubts:?}");
}

#[test]
fn a_base_circle_that_is_none_is_doubted_at_its_row() {
    let rows = printed_rows(&lobe(MotionLaw::Polynomial345, 6.0, 60.0), 360, 1e-3);
    let doubts = |change: &dyn Fn(&mut Vec<camwright::cam::lift::LiftRow>)| {
        let mut rows = rows.clone();
        change(&mut rows);
        LiftTable::read(&rows, &absolute(1e-3)).unwrap().1
    };
    assert_eq!(doubts(&|_| {}), []);
    let hump = doubts(&|rows| {
        for (k, um) in [(28, 1), (29, 2), (30, 3), (31, 4), (32, 4), (33, 3), (34, 2), (35, 1)] {
            rows[k].value_mm = f64::from(um) / 1e3;
        }
    });
    assert!(
        matches!(hump[..], [LiftWarning::BaseNotFlat { line: 33 | 34, height_mm, .. }] if (height_mm - 0.004).abs() < 1e-9),
        "{hump:?}"
    );
    let raised = doubts(&|rows| rows.iter_mut().for_each(|row| row.value_mm += 0.05));
    assert!(
        matches!(raised[..], [LiftWarning::AboveBase { lift_mm, bound_mm, .. }]
            if (lift_mm - 0.05).abs() < 1e-9 && bound_mm < 6e-4),
        "{raised:?}"
    );
}

/// Harmonic motion beside a dwell has no X jerk; between its like, or blended in, it has.
#[test]
fn an_acceleration_that_jumps_is_refused_with_the_reason() {
    use MotionLaw::{Dwell, Harmonic, QuinticBlend, SepticBlend};
    let make = |segments: &[(MotionLaw, f64, f64)]| {
        let segments: Vec<_> = segments.iter().map(|&(law, deg, rise)| segment(law, rad_from_deg(deg), rise)).collect();
        MotionProgram::new(0.0, &segments)
    };
    let error = make(&[(Dwell, 200.0, 0.0), (Harmonic, 80.0, 5.0), (Harmonic, 80.0, -5.0)]).unwrap_err();
    let expected = 0.5 * 5.0 * (std::f64::consts::PI / rad_from_deg(80.0)).powi(2);
    assert!(
        matches!(error, ProgramError::AccelerationJump { segment: 1, law: "dwell", law_before: "harmonic", ends_mm_rad2, .. }
            if (ends_mm_rad2 - expected).abs() < 1e-9),
        "{error:?}"
    );
    assert!(error.to_string().contains("the jerk of the X axis would be unbounded"), "{error}");
    let error = make(&[(Harmonic, 100.0, 5.0), (Harmonic, 260.0, -5.0)]).unwrap_err();
    assert!(matches!(error, ProgramError::AccelerationJump { .. }), "the nose: 100 deg up, 260 deg down: {error:?}");
    assert!(make(&[(Harmonic, 180.0, 5.0), (Harmonic, 180.0, -5.0)]).is_ok());
    for blend in [QuinticBlend, SepticBlend] {
        let blended = [
            (Dwell, 160.0, 0.0),
            (blend, 30.0, 0.3),
            (Harmonic, 70.0, 4.7),
            (Harmonic, 70.0, -4.7),
            (blend, 30.0, -0.3),
        ];
        let law = LiftLaw::from_program(make(&blended).unwrap()).unwrap();
        assert!(law.peak_jerk_mm_rad3().is_finite());
    }
}
