// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Mill, cams and grooves of a milling job.

use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::LiftLaw;
use camwright::job::milling::{CutsWith, GrooveKind, MillAxis, MilledCam, MilledGroove, MillingError, MillingTool};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};
use camwright::toolpath::groove::Coverage;
use camwright::toolpath::groove::barrel::BarrelGroove;
use camwright::toolpath::groove::plate::PlateGroove;

fn tool(cuts_with: CutsWith, radius_mm: f64) -> MillingTool {
    MillingTool { number: 1, cuts_with, radius_mm, spindle_speed_rad_s: 300.0, text: "end mill".into() }
}

fn cam(width_mm: Option<f64>) -> MilledCam {
    let contour = Contour::eccentric(4.2, 19.0).expect("a good one");
    MilledCam { name: "A".into(), contour, phase_rad: 0.0, z_mm: 20.0, width_mm }
}

fn groove(kind: GrooveKind, step_mm: f64) -> MilledGroove {
    MilledGroove { name: "G".into(), kind, phase_rad: 0.0, step_mm }
}

fn plate(depth_mm: f64, step_mm: f64) -> MilledGroove {
    let lift = LiftLaw::eccentric_round(6.0, 50.0, 0.0).expect("a good one");
    let follower = Follower::Roller { radius_mm: 8.0, offset_mm: 0.0 };
    groove(
        GrooveKind::Plate {
            groove: PlateGroove::new(&lift, &follower, 36.0).expect("a good one"),
            top_mm: 0.0,
            depth_mm,
        },
        step_mm,
    )
}

fn barrel() -> MilledGroove {
    let lift = LiftLaw::eccentric_flat(10.0, 0.0).expect("a good one");
    let groove = BarrelGroove::new(&lift, 8.0, 45.0, 35.0).expect("a good one");
    self::groove(GrooveKind::Barrel { groove, z_mm: 40.0, y_axis: true }, 3.0)
}

fn x(path: &CutterPath) -> f64 {
    path.sample(CarriageAxis::X, 0.0).expect("it moves along X").value
}

/// On the line of the eccentricity: 19 + 4.2 mm, what is left, and the radius of a mill that cuts with its periphery.
#[test]
fn a_cam_is_made_by_what_the_mill_cuts_with() {
    let round = tool(CutsWith::Periphery, 15.0).cam_path(&cam(None), 0.3).unwrap();
    assert!((x(&round) - 38.5).abs() < 1e-9, "{}", x(&round));
    let face = tool(CutsWith::Face, 15.0).cam_path(&cam(Some(28.0)), 0.3).unwrap();
    assert!((x(&face) - 23.5).abs() < 1e-9, "{}", x(&face));
    assert_eq!((CutsWith::Periphery.axis(), CutsWith::Face.axis()), (MillAxis::Parallel, MillAxis::Radial));
}

#[test]
fn a_face_must_be_as_wide_as_the_cam() {
    let refusal = tool(CutsWith::Face, 15.0).cam_path(&cam(Some(29.0)), 0.0).unwrap_err();
    assert_eq!(refusal.to_string(), "a turn of the face of 15 mm cuts 28.800 mm along Z; the cam is 29 mm wide");
    assert!(matches!(tool(CutsWith::Face, 4.0).cam_path(&cam(None), 0.0), Err(MillingError::Face(_))));
    assert!(matches!(tool(CutsWith::Periphery, -1.0).cam_path(&cam(None), 0.0), Err(MillingError::Periphery(_))));
}

#[test]
fn a_groove_is_cut_down_in_steps_that_are_alike() {
    assert_eq!(plate(8.0, 2.0).steps_mm(), [6.0, 4.0, 2.0, 0.0]);
    assert_eq!(plate(8.0, 3.0).steps_mm().len(), 3);
    assert_eq!(plate(8.0, 100.0).steps_mm(), [0.0]);
    // 0.7 is not a whole number of tenths in binary.
    assert_eq!(plate(0.7, 0.1).steps_mm().len(), 7);
    assert_eq!(plate(1e9, 1e-9).steps_mm().len(), 1000, "bounded whatever stands in it");
    assert!((barrel().depth_mm() - 10.0).abs() < 1e-12 && barrel().steps_mm().len() == 4);
    assert_eq!((plate(1.0, 1.0).axis(), barrel().axis()), (MillAxis::Parallel, MillAxis::Radial));
}

#[test]
fn paths_of_grooves_are_those_of_their_kind() {
    for (groove, infeed, axes) in [(plate(8.0, 2.0), CarriageAxis::Z, 1), (barrel(), CarriageAxis::X, 2)] {
        let mill = tool(CutsWith::Periphery, 5.0);
        mill.fits_groove(&groove, 0.2, Coverage::Slot).unwrap();
        for path in mill.groove_paths(&groove, 0.2, Coverage::Slot).unwrap() {
            assert_eq!((path.infeed, path.travels.len()), (infeed, axes));
        }
        let large = tool(CutsWith::Periphery, 8.0);
        let refusal = large.fits_groove(&groove, 0.2, Coverage::Slot).unwrap_err();
        assert_eq!(large.groove_paths(&groove, 0.2, Coverage::Slot), Err(refusal.clone()));
        assert!(refusal.to_string().contains("whose half width is 7.8 mm"), "{refusal}");
    }
}
