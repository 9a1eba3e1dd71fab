// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs of cutter paths: what they drive against the paths they were made for.

pub(crate) mod setup;

use camwright::gcode::post::{Lead, PostError, PostRequest, ProgramRun, ProgramTurnSpeed, compare, post};
use camwright::gcode::{Dialect, NcAxis, NumberFormat, XValues, driven};
use camwright::math::periodic_spline::PeriodicSpline;
use camwright::math::units::{TURN_RAD, rad_from_deg, rad_s_from_rpm};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath, Travel};
use setup::{Shop, lobe_path_of};

/// Motion of a program computed from its typed form, independent of a dialect.
fn ran(request: &PostRequest<'_>, program: &camwright::gcode::Program) -> Vec<ProgramRun> {
    let format = request.control.format;
    let place = |axis: NcAxis, count: Option<i64>| count.map_or(f64::NAN, |count| format.value(axis, count));
    let pose = |pose: [Option<i64>; 4]| NcAxis::ALL.map(|axis| place(axis, pose[axis.index()]));
    driven(program).into_iter().map(|driven| ProgramRun { pose: pose(driven.pose), time_s: driven.time_s }).collect()
}

#[test]
fn a_cam_is_driven_within_the_tolerance_of_every_pass_in_every_dialect() {
    let path = lobe_path_of(25.0);
    for dialect in [Dialect::LinuxCnc, Dialect::Fanuc, Dialect::Siemens] {
        for x_values in [XValues::Radius, XValues::Diameter] {
            for (sense, phase_deg) in [(1, 0.0), (-1, 210.0)] {
                let shop = Shop {
                    dialect,
                    format: NumberFormat::new(4, 4, x_values).expect("a format"),
                    sense,
                    ..Shop::default()
                };
                let mut request = shop.cam(&path);
                request.features[0].phase_rad = rad_from_deg(phase_deg);
                let posted = post(&request).expect("a program");
                let compared = compare(&request, &posted, &ran(&request, &posted.program)).expect("the same calls");
                assert_eq!(compared.calls, 4);
                assert!(compared.share_of_tolerance <= 1.0, "{dialect:?}: {compared:?}");
                assert!(compared.error_mm > 0.004, "the roughing passes use their 10 um: {compared:?}");
                assert!(compared.time_error_s < 1e-6, "{}", compared.time_error_s);
                for turn in &posted.turns {
                    assert!(turn.deviation.error_mm <= turn.tolerance_mm);
                }
                let finish = &posted.turns[1];
                assert!((finish.tolerance_mm - 0.0005).abs() < 1e-12);
            }
        }
    }
}

/// Paths that travel on two axes and come down along a third, as grooves do.
fn groove_path(infeed: CarriageAxis) -> CutterPath {
    let wave = |level: f64, amplitude: f64, waves: f64| {
        let values: Vec<f64> =
            (0..720).map(|i| level + amplitude * (waves * f64::from(i) * TURN_RAD / 720.0).sin()).collect();
        PeriodicSpline::interpolate(&values).expect("a spline")
    };
    let travels = match infeed {
        CarriageAxis::Z => vec![Travel { axis: CarriageAxis::X, position: wave(40.0, 6.0, 2.0).into() }],
        _ => vec![
            Travel { axis: CarriageAxis::Y, position: wave(0.0, 0.8, 3.0).into() },
            Travel { axis: CarriageAxis::Z, position: wave(30.0, 9.0, 2.0).into() },
        ],
    };
    CutterPath { name: "inner wall".into(), travels, infeed }
}

#[test]
fn grooves_come_down_along_their_axis_and_travel_on_the_others() {
    for (infeed, stands) in [(CarriageAxis::Z, (CarriageAxis::Z, -8.0)), (CarriageAxis::X, (CarriageAxis::X, 35.0))] {
        let path = groove_path(infeed);
        let shop = Shop { dialect: Dialect::Siemens, ..Shop::default() };
        let mut request = shop.cam(&path);
        let of = &mut request.features[0];
        (of.stands_mm, of.clear_mm) = (vec![stands], stands.1 + 12.0);
        of.lead = Lead { height_mm: 2.0, angle_rad: TURN_RAD, leaves_turning: false };
        of.passes.truncate(1);
        of.passes[0].leaves_mm = vec![6.0, 4.0, 2.0, 0.0];
        let posted = post(&request).expect("a program");
        let moves = ran(&request, &posted.program);
        let compared = compare(&request, &posted, &moves).expect("the same calls");
        assert!(compared.calls == 4 && compared.share_of_tolerance <= 1.0, "{compared:?}");
        let deepest = moves.iter().filter(|ran| ran.time_s.is_some()).map(|ran| ran.pose[NcAxis::from(infeed).index()]);
        let deepest = deepest.fold(f64::INFINITY, f64::min);
        assert!((deepest - stands.1).abs() < 1e-9, "{deepest}");
        // The cutter's axis stays on the travel while it comes down: two turns in every call.
        assert!((posted.turns[0].knots[0].0 + TURN_RAD).abs() < 1e-9);
    }
}

#[test]
fn what_linuxcnc_would_drive_too_fast_goes_in_steps() {
    let path = lobe_path_of(25.0);
    // So slow that much of the flank's foot is below 0.1 mm/min.
    let shop = Shop { rpm: 0.02, ..Shop::default() };
    let request = shop.cam(&path);
    let posted = post(&request).expect("a program");
    assert!(camwright::gcode::raised_feeds(&posted.program).is_empty());
    let compared = compare(&request, &posted, &ran(&request, &posted.program)).expect("the same calls");
    assert!(compared.share_of_tolerance <= 1.0, "{compared:?}");
    let shop = Shop { dialect: Dialect::Fanuc, ..shop };
    let whole = post(&shop.cam(&path)).expect("a program");
    assert!(posted.turns[1].blocks > whole.turns[1].blocks, "{} {}", posted.turns[1].blocks, whole.turns[1].blocks);
    assert!((posted.feed_time_s - whole.feed_time_s).abs() < 1e-6 * whole.feed_time_s);
}

#[test]
fn a_control_that_reads_slowly_gets_a_wider_tolerance_or_none() {
    let path = lobe_path_of(25.0);
    let shop = Shop { rpm: 60.0, max_blocks_s: 250.0, ..Shop::default() };
    let mut request = shop.cam(&path);
    let refused = post(&request).expect_err("too many blocks").to_string();
    assert!(
        refused.contains("A, pass finish: ") && refused.contains("; the control reads 250. It would at "),
        "{refused}"
    );
    let fits: f64 = refused
        .split("It would at ")
        .nth(1)
        .and_then(|text| text.split(' ').next())
        .expect("rpm")
        .parse()
        .expect("a number");
    request.features[0].passes[1].widest_tolerance_mm = 0.01;
    let posted = post(&request).expect("a program");
    let finish = &posted.turns[1];
    assert!(finish.blocks_s <= 250.0 && finish.tolerance_mm > 0.0005 && finish.deviation.error_mm > 0.0005);
    let slower = Shop { rpm: fits, ..shop };
    assert!(post(&slower.cam(&path)).expect("a program").turns[1].deviation.error_mm <= 0.0005);
}

#[test]
fn times_are_those_of_the_speed() {
    let path = lobe_path_of(25.0);
    let shop = Shop::default();
    let mut request = shop.cam(&path);
    let turned = 450.0 / 360.0;
    let constant = post(&request).expect("a program");
    assert!((constant.turns[1].time_s - turned * 60.0 / 4.0).abs() < 1e-9);
    // A law that swings by half: 1/(1 + cos/2) has the mean 1/√(1 − 1/4).
    let law = |u: f64| rad_s_from_rpm(4.0) * (1.0 + 0.5 * u.cos());
    request.features[0].passes[1].speed = ProgramTurnSpeed::Law(&law);
    request.features[0].lead.angle_rad = TURN_RAD;
    let varied = post(&request).expect("a program");
    assert!((varied.turns[1].time_s - 3.0 * 15.0 / 0.75_f64.sqrt()).abs() < 1e-6, "{}", varied.turns[1].time_s);
    // 49.5 mm round the axis on the base circle, no faster.
    request.features[0].passes[1].speed = ProgramTurnSpeed::AlongPath { feed_mm_s: 10.0, max_rad_s: 0.1 };
    let bounded = post(&request).expect("a program");
    assert!((bounded.turns[1].time_s - 3.0 * TURN_RAD / 0.1).abs() < 1e-6);
    request.features[0].passes[1].speed = ProgramTurnSpeed::AlongPath { feed_mm_s: 10.0, max_rad_s: 10.0 };
    let along = post(&request).expect("a program");
    let length = |u: f64| {
        let x = path.sample(CarriageAxis::X, u).expect("X");
        x.value.hypot(x.first)
    };
    let turn_mm: f64 = (0..100_000).map(|i| length((f64::from(i) + 0.5) * TURN_RAD / 1e5) * TURN_RAD / 1e5).sum();
    assert!((along.turns[1].time_s - 0.3 * turn_mm).abs() < 0.05 * along.turns[1].time_s, "{}", along.turns[1].time_s);
}

/// The comparison must see what is wrong.
#[test]
fn a_program_that_drives_something_else_is_found() {
    let path = lobe_path_of(25.0);
    let request = Shop::default().cam(&path);
    let posted = post(&request).expect("a program");
    let good = ran(&request, &posted.program);
    let feeding = good.iter().rposition(|ran| ran.time_s.is_some()).expect("a feed") - 40;
    let mut off = good.clone();
    off[feeding].pose[0] += 0.003;
    let found = compare(&request, &posted, &off).expect("the same calls");
    assert!(found.share_of_tolerance > 4.0 && found.worst_call == 3, "{found:?}");
    let mut late = good.clone();
    late[feeding].time_s = late[feeding].time_s.map(|time_s| time_s + 0.5);
    assert!((compare(&request, &posted, &late).expect("calls").time_error_s - 0.5).abs() < 1e-9);
    let mut short = good.clone();
    short.truncate(feeding - 200);
    assert!(matches!(compare(&request, &posted, &short), Err(PostError::OtherCalls { expected: 4, .. })));
    let mut low = good.clone();
    // The rapid that leaves the part after the first call is omitted: C turns on beside it.
    let leaves =
        good.windows(2).position(|pair| pair[0].time_s.is_some() && pair[1].time_s.is_none()).expect("a rapid") + 1;
    low.remove(leaves);
    assert!(matches!(compare(&request, &posted, &low), Err(PostError::RapidNotClear { .. })));
}

#[test]
fn numbers_that_make_no_program_are_refused() {
    let path = lobe_path_of(25.0);
    let good = Shop::default().cam(&path);
    let refused = |change: &dyn Fn(&mut PostRequest<'_>)| {
        let mut request = good.clone();
        change(&mut request);
        post(&request).expect_err("refused").to_string()
    };
    for (words, found) in [
        ("the program is empty: no cam", refused(&|r| r.features.clear())),
        ("A: it has no pass", refused(&|r| r.features[0].passes.clear())),
        ("the rotation sense is 0; it must be 1 or -1", refused(&|r| r.control.rotation_sense = 0)),
        ("block rate of the control is 0; it must be above 0", refused(&|r| r.control.max_blocks_s = 0.0)),
        ("path tolerance in mm is -1", refused(&|r| r.control.path_tolerance_mm = Some(-1.0))),
        ("within a turn", refused(&|r| r.features[0].lead.angle_rad = 7.0)),
        ("from which the cutter comes is NaN", refused(&|r| r.features[0].lead.height_mm = f64::NAN)),
        ("where the cutter is clear is inf", refused(&|r| r.features[0].clear_mm = f64::INFINITY)),
        ("A: the phase in rad is NaN", refused(&|r| r.features[0].phase_rad = f64::NAN)),
        ("A, pass finish: the tolerance in mm is -1", refused(&|r| r.features[0].passes[1].tolerance_mm = -1.0)),
        ("the widest tolerance in mm is 0", refused(&|r| r.features[0].passes[1].widest_tolerance_mm = 0.0)),
        ("turns of a call is 0; it must be 1 to 100", refused(&|r| r.features[0].passes[1].turns = 0)),
        ("what is left of the depth in mm is -1", refused(&|r| r.features[0].passes[1].leaves_mm = vec![-1.0])),
        ("is 0; it must be above 0", refused(&|r| r.features[0].passes[1].speed = ProgramTurnSpeed::WorkSpeed(0.0))),
        ("at most 100000 are made", refused(&|r| r.features[0].passes[0].leaves_mm = vec![0.0; 100_001])),
        (
            "A, pass finish: a tolerance of 0.05 um leaves nothing beside",
            refused(&|r| {
                (r.features[0].passes[1].tolerance_mm, r.features[0].passes[1].widest_tolerance_mm) = (5e-5, 5e-5);
            }),
        ),
    ] {
        assert!(found.contains(words), "{found}");
    }
}
