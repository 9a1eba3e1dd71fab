// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parts, their programs and the machine that grinds them.

use crate::cams::reference_contour;
use crate::post::setup::{Shop, lobe_path_of};
use camwright::cam::form::Form;
use camwright::gcode::post::{Lead, PostedProgram, ProgramTurnSpeed, post};
use camwright::gcode::{self, Dialect, ProgramFile, XValues, read};
use camwright::interpolator::{Motion, MotionOutcome, Prepared};
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::math::periodic_spline::PeriodicSpline;
use camwright::math::units::{TURN_RAD, rad_from_deg, rad_s_from_rpm};
use camwright::planner::program_motion::ProgramSetup;
use camwright::planner::{PlanStart, PlannedProgram, ProgramLobe, ProgramPlanError, ProgramRequest, plan_program};
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::workpiece::DEFAULT_AZIMUTHS;
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath, Travel};
use std::sync::Arc;

/// The table before the first station, and the program's Z there (mm).
pub(crate) const STATION_MM: f64 = 60.0;
const PROGRAM_Z_MM: f64 = 20.0;
const BLANK_MM: f64 = 23.5;
/// Rounding tolerance of the control: a piece within 2 um of the path makes corners that axes pass at speed only by cutting
/// them.
pub(crate) const TOLERANCE_MM: f64 = 0.005;
const ROUGH_RPM: f64 = 25.0;

/// The eccentric: radius, and how far from the axis (mm).
const DISC: (f64, f64) = (19.0, 4.2);

/// Ground part.
pub(crate) struct Part {
    pub(crate) name: &'static str,
    path: CutterPath,
}

impl Part {
    pub(crate) fn lobe() -> Self {
        Self { name: "reference lobe", path: lobe_path_of(cam_grinder().wheel.new_radius_mm) }
    }

    /// X = E cos θ + √((r+R)² − E² sin² θ) for the wheel's centre.
    pub(crate) fn eccentric() -> Self {
        let (e, l) = (DISC.1, DISC.0 + cam_grinder().wheel.new_radius_mm);
        let x = |theta: f64| e * theta.cos() + (l * l - e * e * theta.sin() * theta.sin()).sqrt();
        let values: Vec<f64> = (0..720).map(|i| x(f64::from(i) * TURN_RAD / 720.0)).collect();
        let position = PeriodicSpline::interpolate(&values).expect("a spline");
        let travels = vec![Travel { axis: CarriageAxis::X, position: position.into() }];
        Self { name: "eccentric", path: CutterPath { name: "contour".into(), travels, infeed: CarriageAxis::X } }
    }

    pub(crate) fn wheel_mm(&self) -> f64 {
        cam_grinder().wheel.new_radius_mm
    }

    /// Lowest and highest place against the design (mm).
    pub(crate) fn deviation(&self, radii: &[f64]) -> (f64, f64) {
        let range = |all: &[f64]| all.iter().fold((f64::MAX, f64::MIN), |(low, high), d| (low.min(*d), high.max(*d)));
        if self.name == "reference lobe" {
            return range(&Form::measure(radii, &reference_contour(), 0.0).expect("radii").deviations_mm);
        }
        let off = |(index, radius): (usize, &f64)| {
            let (s, c) = (index as f64 * TURN_RAD / radii.len() as f64).sin_cos();
            // The distance of the point from the disc's centre.
            ((radius * c - DISC.1).hypot(radius * s)) - DISC.0
        };
        range(&radii.iter().enumerate().map(off).collect::<Vec<f64>>())
    }
}

/// A program that was read, and its files.
pub(crate) struct Read {
    pub(crate) motion: gcode::ProgramMotion,
    pub(crate) files: Vec<ProgramFile>,
}

/// The program of a part, written and read.
pub(crate) fn program(part: &Part, dialect: Dialect, rpm: f64) -> (PostedProgram, Read) {
    let shop = Shop { dialect, rpm, max_blocks_s: 1000.0, ..Shop::default() };
    let mut request = shop.cam(&part.path);
    request.tool.radius_mm = part.wheel_mm();
    request.control.path_tolerance_mm = Some(TOLERANCE_MM);
    let of = &mut request.features[0];
    (of.stands_mm, of.clear_mm) = (vec![(CarriageAxis::Z, PROGRAM_Z_MM)], part.wheel_mm() + 40.0);
    (of.passes[0].tolerance_mm, of.passes[0].widest_tolerance_mm) = (0.002, 0.002);
    // Its larger corners are for a slower C.
    of.passes[0].speed = ProgramTurnSpeed::WorkSpeed(rad_s_from_rpm(rpm.min(ROUGH_RPM)));
    // Higher than the nose, so that C runs up off the part.
    of.lead = Lead { height_mm: 9.0, angle_rad: rad_from_deg(90.0), leaves_turning: true };
    let posted = post(&request).unwrap_or_else(|error| panic!("{error}"));
    let files = dialect.write(&posted.program).expect("it can be written");
    let read = read_files(dialect, files);
    (posted, read)
}

fn read_files(dialect: Dialect, files: Vec<ProgramFile>) -> Read {
    let motion = read(dialect, XValues::Radius, &files).unwrap_or_else(|error| panic!("{error}"));
    Read { motion, files }
}

/// A program of blocks for LinuxCNC, with the head that it asks for.
pub(crate) fn blocks(text: &str) -> Read {
    let text = format!("G21 G17 G90 G94\n{text}\nM2\n");
    read_files(Dialect::LinuxCnc, vec![ProgramFile { name: "short.ngc".into(), text }])
}

pub(crate) fn setup() -> ProgramSetup {
    ProgramSetup {
        cutter_radius_mm: cam_grinder().wheel.new_radius_mm,
        x_of_edge: false,
        z_zero_mm: STATION_MM - PROGRAM_Z_MM,
        rotation_sense: 1,
        path_tolerance_mm: TOLERANCE_MM,
    }
}

/// X clear of the part, C unhomed.
pub(crate) fn start(machine: &MachineDescription) -> PlanStart {
    PlanStart {
        counts: Axis::ALL.map(|axis| machine.axis(axis).scale.counts(machine.axis(axis).power_up_position)),
        c_homed: false,
    }
}

pub(crate) fn plan(
    read: &Read,
    setup: ProgramSetup,
    machine: &MachineDescription,
) -> Result<PlannedProgram, ProgramPlanError> {
    // A lathe's part is one, wherever it is cut.
    let lobes = [("I1", STATION_MM), ("E1", STATION_MM + 50.0)];
    let lobes = lobes.map(|(name, z_mm)| ProgramLobe { name, z_mm, width_mm: 15.0 });
    let lobes = if machine.is_lathe() { &[][..] } else { &lobes[..] };
    let request =
        ProgramRequest { name: "cam", motion: &read.motion, files: &read.files, setup, x_clear_mm: None, lobes };
    plan_program(&request, machine, start(machine))
}

pub(crate) fn planned(read: &Read, machine: &MachineDescription) -> PlannedProgram {
    plan(read, setup(), machine).unwrap_or_else(|error| panic!("{error}"))
}

/// Radii of the part after the program on a machine that has just been switched on.
pub(crate) fn lobe_on_the_machine(planned: &PlannedProgram, part: &Part, machine: &MachineDescription) -> Vec<f64> {
    let mut grinder = Machine::new(machine.clone(), PersistentState::new(machine)).expect("a machine");
    grinder.load_lobe(part.name, "LS1", 15.0, vec![BLANK_MM; DEFAULT_AZIMUTHS]).expect("a round blank");
    let motion = Prepared::new(Motion::Plan(Arc::new(planned.plan.clone())), machine);
    let motion = motion.unwrap_or_else(|error| panic!("{error}"));
    let mut closed_loop = ClosedLoop::direct(grinder);
    let done = closed_loop.simulate(Box::new(motion), |_, _| {});
    assert_eq!(done.unwrap_or_else(|error| panic!("{error}")).outcome, MotionOutcome::Completed);
    closed_loop.machine().part().lobe(part.name).expect("it was loaded").radii_mm().to_vec()
}

/// Lowest and highest place of the part after the program (mm).
pub(crate) fn ground(planned: &PlannedProgram, part: &Part, machine: &MachineDescription) -> (f64, f64) {
    part.deviation(&lobe_on_the_machine(planned, part, machine))
}
