// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A gauge behind HAL.

use crate::hal::{Hal, NAMESPACE, as_user, integrator, messages, planner_client, recorded_cell, wait_for_recorder};
use crate::support;
use camwright::machine::contact_law::ContactLaw;
use camwright_analysis::rerun;
use camwright_bag::Bag;
use camwright_msgs::camwright_msgs::action::RunJobGoal;
use camwright_msgs::camwright_msgs::msg::GaugeReading;
use camwright_msgs::rcl_interfaces::msg::Log;
use camwright_ros::GoalStatus;
use std::f64::consts::{FRAC_PI_2, TAU};
use support::command::Shared;
use support::processes::fresh_bag;
use support::{Domain, PATIENCE};

/// Contact of the machine in the test of the gauge: five sixths of a runout are left after each turn.
const SOFT: [(&str, &str); 1] = [(
    "machine_stiffness: [{z_mm: 80.0, n_um: 45.0}, {z_mm: 150.0, n_um: 38.0}, {z_mm: 225.0, n_um: 45.0}]",
    "machine_stiffness: [{z_mm: 80.0, n_um: 6.0}, {z_mm: 225.0, n_um: 6.0}]",
)];

/// A journal that is measured, ground and corrected. Behind HAL no drive reports the force of a push.
const GAUGED: [&str; 6] = [
    "machine=cam_grinder_hal",
    "roughing=[{name: rough, infeed: {total_mm: 0.27, per_block_um: 0.005, spark_out_turns: 1}, work_speed_rpm: 60}]",
    "identification=null",
    "runout_correction.stiffness=nominal",
    "measure_stock.margin_um=60",
    "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0, width_mm: 20}]",
];

/// The journal in HAL (mm): the parameters of its components, followed tick by tick with the positions of the bag.
struct PlantedJournal {
    lowest_mm: f64,
    radius_mm: f64,
    wave_mm: f64,
}

impl PlantedJournal {
    const RAW_MM: f64 = 20.12;
    const WAVE_MM: f64 = 0.1;
    /// Angle of the contact behind the wheel.
    const BEHIND_RAD: f64 = FRAC_PI_2;

    fn raw() -> Self {
        Self { lowest_mm: f64::INFINITY, radius_mm: Self::RAW_MM, wave_mm: Self::WAVE_MM }
    }

    fn law() -> ContactLaw {
        ContactLaw::new(6_000.0, 30_000.0, 16.0).expect("a law")
    }

    /// Its reading in the next tick (mm).
    fn read(&mut self, c_rad: f64, x_mm: f64) -> f64 {
        self.lowest_mm = self.lowest_mm.min(x_mm);
        if self.lowest_mm < Self::RAW_MM {
            let gain = 1.0 - Self::law().decay().powf(1e-3);
            self.radius_mm += gain * (self.lowest_mm - self.radius_mm);
            self.wave_mm -= gain * self.wave_mm;
        }
        self.radius_mm + self.wave_mm * (c_rad - Self::BEHIND_RAD).cos()
    }

    /// Runout of the ground journal (mm) from its readings over the angle of C: each phase as it left the wheel before it was withdrawn,
    /// and after that by the law of the contact.
    fn runout_mm(readings: &[(f64, f64, f64)]) -> f64 {
        const WITHDRAWN_RAD: f64 = 0.7 * TAU;
        let at = |c_rad: f64| readings[readings.partition_point(|(at, ..)| *at < c_rad).min(readings.len() - 1)];
        let (rest_rad, law) = (readings[readings.len() - 1].0, Self::law());
        // A phase that leaves the wheel at an angle is under the gauge later; the components know no force below which nothing is cut.
        let left_mm = |c_rad: f64| at(c_rad + Self::BEHIND_RAD).2 + law.threshold_n() / law.machine_n_mm();
        let radii = (1..=720).map(|step| {
            let c_rad = rest_rad - TAU + TAU * f64::from(step) / 720.0;
            match c_rad <= rest_rad - WITHDRAWN_RAD {
                true => left_mm(c_rad),
                false => law.radius_after_mm(left_mm(c_rad - TAU), at(c_rad).1),
            }
        });
        let (low, high) = radii.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mm| (low.min(mm), high.max(mm)));
        high - low
    }
}

/// HAL refuses a machine whose gauge is on a pin that is not there, or of another type.
fn refuse_gauge(hal: &Hal, domain: &Domain) {
    let path = hal.home.path.join("machine.yaml");
    let machine = std::fs::read_to_string(&path).expect("the machine");
    let wrong =
        machine.replace("gauge-reading.out", "gauge-reading.position").replace("gauge-valid.out", "gauge-wave.out");
    std::fs::write(hal.home.path.join("wrong.yaml"), wrong).expect("our folder");
    let mut node = as_user(&hal.home.path.join("bin/machine_hal"), &hal.home.path);
    node.env("ROS_DOMAIN_ID", domain.id().to_string());
    let output = node.args(["--ros-args", "-p", "machine:=wrong.yaml", "-p", "state_file:=none"]).output();
    let output = output.expect("the node starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for finding in [
        "hal.gauge.reading: there is no pin gauge-reading.position",
        "hal.gauge.valid: gauge-wave.out is float; it must be bit",
    ] {
        assert!(text.contains(finding), "{finding} is not in\n{text}");
    }
}

/// A gauge of HAL measures the stock, then the runout of a journal, which the planner corrects: both are those that HAL was given.
#[test]
fn a_journal_is_gauged_over_hal_and_its_runout_is_the_planted_one() {
    let Some(hal) = Hal::start_with(&SOFT, None) else { return };
    let domain = Domain::reserve();
    refuse_gauge(&hal, &domain);
    hal.set("gauge-to-wave.in1", &PlantedJournal::WAVE_MM.to_string());
    let machine = hal.node(&domain);
    let bag = fresh_bag("hal-gauge");
    let (mut recorder, cell) = recorded_cell(&domain, &bag);
    let node = integrator(&domain);
    let (jobs, spin) = planner_client(&node, &machine);
    let command = Shared::for_cell(&domain, NAMESPACE);
    wait_for_recorder(&node);
    let goal = RunJobGoal {
        job: "journal_runout".into(),
        overrides: GAUGED.map(String::from).into(),
        ..RunJobGoal::default()
    };
    let job = jobs.send_goal(goal, drop, PATIENCE).expect("an answer");
    let (status, result) = job.result(3 * PATIENCE).expect("it ends");
    assert_eq!(status, GoalStatus::Succeeded, "{}{}", result.message, machine.stderr());
    recorder.interrupt();
    assert!(recorder.wait(PATIENCE).success(), "{}", recorder.stderr());
    drop((command, spin, cell));

    let opened = Bag::open(&bag).expect("a bag");
    let readings: Vec<GaugeReading> = messages(&opened, &format!("{NAMESPACE}/machine/gauge"));
    let times: Vec<_> = readings.chunk_by(|one, next| next.tick == one.tick + 1).collect();
    let [under_gauge, cut, correction] = times.as_slice() else { panic!("{} times", times.len()) };
    assert!(under_gauge.len() > 900 && cut.len() > 10_000 && correction.len() > 1_000, "a reading in every tick");
    let is_ours =
        |reading: &GaugeReading| reading.lobe == "J1" && reading.kind == GaugeReading::RADIUS && !reading.pushing;
    assert!(readings.iter().all(is_ours));
    // Each reading belongs to the encoders of its own servo period; an edge of the origin is seen within one.
    let mut planted = PlantedJournal::raw();
    let mut followed = Vec::new();
    for reading in under_gauge.iter().chain(*cut) {
        let (c_rad, x_mm, mm) = (reading.spindle_angle, 1e3 * reading.wheel_position, 1e3 * reading.reading);
        let expected_mm = planted.read(c_rad, x_mm);
        assert!((mm - expected_mm).abs() < 2e-4, "tick {}: {mm} mm instead of {expected_mm}", reading.tick);
        followed.push((c_rad, x_mm, expected_mm));
    }
    let (low, high) = under_gauge.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), reading| {
        (low.min(1e3 * reading.reading), high.max(1e3 * reading.reading))
    });
    let eccentric_mm = 0.5 * (high - low);
    assert!((eccentric_mm - PlantedJournal::WAVE_MM).abs() < 1e-5, "eccentric by {eccentric_mm} mm");
    let logs: Vec<Log> = messages(&opened, "/rosout");
    let stock = "lobe J1: 220.0 um of stock by the gauge";
    assert!(logs.iter().any(|log| log.msg.starts_with(stock)), "{stock}: nobody logged it");
    let (measured_mm, planted_mm) =
        (1e3 * result.lobes[0].runout_before, PlantedJournal::runout_mm(&followed[under_gauge.len()..]));
    eprintln!("runout {measured_mm:.6} mm measured, {planted_mm:.6} mm planted");
    assert!((measured_mm - planted_mm).abs() < 0.01 * planted_mm, "{measured_mm} mm, planted {planted_mm} mm");
    let verdict = rerun::rerun(&bag).expect("the bag holds the inputs");
    assert!(verdict.is_identical() && verdict.motions > 2, "{}", verdict.to_text());
    std::fs::remove_dir_all(bag).expect("our bag");
}
