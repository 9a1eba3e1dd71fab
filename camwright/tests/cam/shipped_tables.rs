// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The lift tables of the default job, all the way to the wheel's path.

use crate::cams;

use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::{LiftLaw, LiftRow, LiftTable};
use camwright::math::units::deg_from_rad;
use camwright::toolpath::wheel_path::ToolPath;

fn rows(text: &str) -> Vec<LiftRow> {
    (1..)
        .zip(text.lines())
        .filter(|(_, line)| line.starts_with(|first: char| first.is_ascii_digit()))
        .map(|(line, cells)| {
            let (angle, lift) = cells.split_once(',').expect("two columns");
            let number = |cell: &str| cell.parse::<f64>().expect("a number");
            LiftRow { line, angle_deg: Some(number(angle)), value_mm: number(lift) }
        })
        .collect()
}

/// 3600 blocks of 0.1° printed to 1 µm; a wheel of 60 mm fits with a tenth to spare, and the path is exact.
#[test]
fn tables_of_the_default_job_lead_to_exact_paths() {
    for (text, lift_mm, base_mm) in [
        (include_str!("../../../params/lifts/intake.csv"), 6.2, 16.0),
        (include_str!("../../../params/lifts/exhaust.csv"), 5.8, 15.5),
    ] {
        let rows = rows(text);
        assert_eq!(LiftTable::findings(&rows, &cams::absolute(1e-3)), []);
        let table = LiftTable::from_rows(&rows, &cams::absolute(1e-3)).unwrap();
        assert_eq!(table.blocks(), 3600);
        let law = LiftLaw::from_table(&table).unwrap();
        assert!((law.max_lift_mm() - lift_mm).abs() < 1e-3, "{}", law.max_lift_mm());
        let follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };
        let contour = Contour::from_lift(&law, &follower, base_mm).unwrap();
        assert!(deg_from_rad(contour.max_pressure_angle().value).abs() < 30.0);
        let path = ToolPath::for_wheel(&contour, 60.0).unwrap();
        let largest = contour.largest_wheel_radius_mm().unwrap_or(f64::INFINITY);
        assert!(60.0 < 0.9 * largest, "{largest}");
        assert!(path.accuracy().contour_error_mm < 1e-8, "{:?}", path.accuracy());
    }
}
