// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Compliance of a shaft on its supports: closed forms of text books, and a beam of finite elements.

use camwright::job::supported_shaft::{ShaftLayout, SupportedShaft, round_bending_n_mm2};
use camwright::machine::description::{SteadyRest, WorkholdingDescription};
use nalgebra::{DMatrix, DVector};

/// Supports that do not deflect: far stiffer than the shafts here, and soft enough for the arithmetic.
const RIGID_N_MM: f64 = 1e15;
const RIGID_N_MM_RAD: f64 = 1e18;

fn rigid() -> WorkholdingDescription {
    WorkholdingDescription {
        headstock_n_mm: RIGID_N_MM,
        chuck_tilt_n_mm_rad: Some(RIGID_N_MM_RAD),
        tailstock_n_mm: Some(RIGID_N_MM),
        steady_rest: Some(SteadyRest { n_mm: RIGID_N_MM, jaw_width_mm: 20.0 }),
    }
}

fn elastic() -> WorkholdingDescription {
    WorkholdingDescription {
        headstock_n_mm: 1.2e5,
        chuck_tilt_n_mm_rad: Some(4e9),
        tailstock_n_mm: Some(7e4),
        steady_rest: Some(SteadyRest { n_mm: 5e4, jaw_width_mm: 20.0 }),
    }
}

/// 400 mm of steel, 30 mm thick, from 50 mm on.
fn layout(is_chucked: bool, has_tailstock: bool, steady_rest_z_mm: Option<f64>) -> ShaftLayout {
    let bending_n_mm2 = round_bending_n_mm2(2.1e5, 30.0);
    ShaftLayout { headstock_z_mm: 50.0, length_mm: 400.0, bending_n_mm2, is_chucked, has_tailstock, steady_rest_z_mm }
}

#[track_caller]
fn near(found: f64, wanted: f64, relative: f64) {
    assert!((found - wanted).abs() <= relative * wanted.abs(), "{found}, wanted {wanted}");
}

#[test]
fn a_round_bar_has_the_second_moment_of_its_circle() {
    near(round_bending_n_mm2(2.1e5, 30.0), 2.1e5 * std::f64::consts::PI * 15.0_f64.powi(4) / 4.0, 1e-14);
}

/// F a³/(3 E I) of a cantilever, F a² b²/(3 E I L) between two rigid supports, and F a³ b² (4 L − a)/(12 E I L³) of a propped cantilever
/// with a the distance from its fixed end (Roark, table 8.1, cases 1a, 1e and 1c).
#[test]
fn rigid_supports_give_the_closed_forms() {
    let length: f64 = 400.0;
    let shaft = |is_chucked, has_tailstock| {
        let layout = layout(is_chucked, has_tailstock, None);
        (SupportedShaft::new(&layout, &rigid()).expect("supports"), layout.bending_n_mm2)
    };
    for a in [40.0_f64, 123.0, 200.0, 371.0] {
        let (z_mm, b) = (50.0 + a, length - a);
        let (cantilever, bending) = shaft(true, false);
        near(cantilever.compliance_mm_n(z_mm), a.powi(3) / (3.0 * bending), 1e-8);
        let (between, _) = shaft(false, true);
        near(between.compliance_mm_n(z_mm), a * a * b * b / (3.0 * bending * length), 1e-8);
        let (propped, _) = shaft(true, true);
        let wanted = a.powi(3) * b * b * (4.0 * length - a) / (12.0 * bending * length.powi(3));
        near(propped.compliance_mm_n(z_mm), wanted, 1e-7);
    }
}

/// A bar that does not bend moves on its springs alone: (1 − s)²/kh + s²/kt between centres, 1/kh + a²/kφ in a chuck.
#[test]
fn a_stiff_bar_moves_on_its_springs() {
    let springs = elastic();
    for (is_chucked, a) in [(false, 0.0_f64), (false, 130.0), (false, 400.0), (true, 0.0), (true, 250.0)] {
        let stiff = ShaftLayout { bending_n_mm2: 1e24, ..layout(is_chucked, !is_chucked, None) };
        let found = SupportedShaft::new(&stiff, &springs).expect("supports").compliance_mm_n(50.0 + a);
        let s = a / 400.0;
        let wanted = match is_chucked {
            true => 1.0 / 1.2e5 + a * a / 4e9,
            false => (1.0 - s).powi(2) / 1.2e5 + s * s / 7e4,
        };
        near(found, wanted, 1e-9);
    }
}

/// At a rigid steady rest nothing deflects, and a quarter of the way between rigid supports its part is that of a two-span beam.
#[test]
fn a_steady_rest_makes_two_spans() {
    let shaft = SupportedShaft::new(&layout(false, true, Some(250.0)), &rigid()).expect("supports");
    let bending = layout(false, true, None).bending_n_mm2;
    assert!(shaft.compliance_mm_n(250.0) < 1e-14);
    // Two equal spans l under a force in the middle of one: 23 F l³/(1536 E I).
    near(shaft.compliance_mm_n(150.0), 23.0 * 200.0_f64.powi(3) / (1536.0 * bending), 1e-7);
    let alone = SupportedShaft::new(&layout(false, true, None), &rigid()).expect("supports");
    assert_eq!(shaft.without_rest(), alone);
}

/// The softest support decides at its own place: a rest of no stiffness is none.
#[test]
fn a_rest_without_stiffness_is_none() {
    let mut springs = elastic();
    springs.steady_rest = Some(SteadyRest { n_mm: 1e-9, jaw_width_mm: 20.0 });
    let with = SupportedShaft::new(&layout(true, true, Some(200.0)), &springs).expect("supports");
    for z_mm in [60.0, 200.0, 300.0, 440.0] {
        near(with.compliance_mm_n(z_mm), with.without_rest().compliance_mm_n(z_mm), 1e-12);
    }
}

#[test]
fn a_support_that_the_machine_lacks_makes_no_shaft() {
    let springs = elastic();
    let none = |layout: ShaftLayout, springs: WorkholdingDescription| SupportedShaft::new(&layout, &springs).is_none();
    assert!(none(layout(false, false, None), springs), "a centre alone holds nothing");
    assert!(none(layout(true, false, None), WorkholdingDescription { chuck_tilt_n_mm_rad: None, ..springs }));
    assert!(none(layout(false, true, None), WorkholdingDescription { tailstock_n_mm: None, ..springs }));
    assert!(none(layout(false, true, Some(200.0)), WorkholdingDescription { steady_rest: None, ..springs }));
}

/// A beam of elements with cubic shape functions, which are exact at their nodes: deflection at one place under a force at another and a
/// motion of the steady rest's seat (mm).
fn elements_mm(
    layout: &ShaftLayout,
    springs: &WorkholdingDescription,
    (at_mm, force_mm): (f64, f64),
    (force_n, seat_mm): (f64, f64),
) -> f64 {
    let rest_mm = layout.steady_rest_z_mm.map(|z_mm| z_mm - layout.headstock_z_mm);
    let (at_mm, force_mm) = (at_mm - layout.headstock_z_mm, force_mm - layout.headstock_z_mm);
    let mut nodes = vec![0.0, layout.length_mm, at_mm, force_mm];
    nodes.extend(rest_mm);
    nodes.sort_by(f64::total_cmp);
    nodes.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let node = |x: f64| nodes.iter().position(|node| (node - x).abs() < 1e-9).expect("a node stands there");
    let size = 2 * nodes.len();
    let (mut stiffness, mut load) = (DMatrix::<f64>::zeros(size, size), DVector::<f64>::zeros(size));
    for (first, pair) in nodes.windows(2).enumerate() {
        let l = pair[1] - pair[0];
        let element = [
            [12.0, 6.0 * l, -12.0, 6.0 * l],
            [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
            [-12.0, -6.0 * l, 12.0, -6.0 * l],
            [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
        ];
        for (row, values) in element.iter().enumerate() {
            for (column, value) in values.iter().enumerate() {
                stiffness[(2 * first + row, 2 * first + column)] += layout.bending_n_mm2 / l.powi(3) * value;
            }
        }
    }
    stiffness[(0, 0)] += springs.headstock_n_mm;
    if layout.is_chucked {
        stiffness[(1, 1)] += springs.chuck_tilt_n_mm_rad.expect("a chuck");
    }
    if layout.has_tailstock {
        stiffness[(size - 2, size - 2)] += springs.tailstock_n_mm.expect("a tailstock");
    }
    if let Some(rest_mm) = rest_mm {
        let n_mm = springs.steady_rest.expect("a steady rest").n_mm;
        stiffness[(2 * node(rest_mm), 2 * node(rest_mm))] += n_mm;
        load[2 * node(rest_mm)] += n_mm * seat_mm;
    }
    load[2 * node(force_mm)] += force_n;
    let solved = stiffness.lu().solve(&load).expect("supports hold it");
    solved[2 * node(at_mm)]
}

/// Every support, every pair of places: the superposition is the beam of elements within 1e-9; forces are reciprocal, and the seat of the
/// rest moves the part by its share.
#[test]
fn superposition_equals_a_beam_of_finite_elements() {
    let springs = elastic();
    let places = [50.0, 71.3, 150.0, 203.0, 280.0, 333.3, 450.0];
    for (is_chucked, has_tailstock, rest) in [
        (false, true, None),
        (false, true, Some(203.0)),
        (false, true, Some(290.0)),
        (true, false, None),
        (true, false, Some(333.3)),
        (true, true, None),
        (true, true, Some(160.0)),
    ] {
        for thin in [1.0, 0.05] {
            let base = layout(is_chucked, has_tailstock, rest);
            let layout = ShaftLayout { bending_n_mm2: thin * base.bending_n_mm2, ..base };
            let shaft = SupportedShaft::new(&layout, &springs).expect("supports");
            let soft = places.iter().map(|z_mm| shaft.compliance_mm_n(*z_mm)).fold(0.0, f64::max);
            for at_mm in places {
                for force_mm in places {
                    let wanted = elements_mm(&layout, &springs, (at_mm, force_mm), (1.0, 0.0));
                    let found = shaft.influence_mm_n(at_mm, force_mm);
                    assert!((found - wanted).abs() < 1e-9 * soft, "{layout:?}, {at_mm}, {force_mm}: {found}, {wanted}");
                    near(
                        found,
                        shaft.influence_mm_n(force_mm, at_mm),
                        1e-12 * soft / found.abs().max(1e-3 * soft) + 1e-9,
                    );
                }
                near(shaft.compliance_mm_n(at_mm), elements_mm(&layout, &springs, (at_mm, at_mm), (1.0, 0.0)), 1e-9);
                let share = elements_mm(&layout, &springs, (at_mm, at_mm), (0.0, 1.0));
                assert!((shaft.seat_share(at_mm) - share).abs() < 1e-9, "{layout:?}, {at_mm}");
            }
        }
    }
}
