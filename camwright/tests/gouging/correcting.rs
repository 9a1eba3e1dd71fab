// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random journals whose runout is corrected, by both modes, with one gauge and two, quiet and noisy; held at any tick.

use super::JobEnd;
use super::drive::{Tick, drive, requests};
use crate::cams::{SplitMix64, journal};
use camwright::cam::form_tolerance::FormTolerance;
use camwright::gauging::GaugingMode;
use camwright::gauging::gauged_tick::GaugedTick;
use camwright::gauging::published::PublishedWindow;
use camwright::interpolator::{Interpolator, MotionOutcome, MotionRequest};
use camwright::job::grinding::{
    BetweenLobes, CorrectionSpec, InfeedCourse, InfeedDirection, JobSpec, LobeSpec, PassSpec, SpeedLaw, StiffnessSource,
};
use camwright::job::raw_part::{RawPart, Wave};
use camwright::machine::description::{
    ContactDescription, DriveSettings, GaugeDescription, GaugeKind, MachineDescription, StiffnessAt,
};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::reference::cam_grinder;
use camwright::math::units::{TURN_RAD, rad_s_from_rpm};
use camwright::motion::plan::Plan;
use camwright::planner::{JournalReadings, decide_corrections, plan_corrections, plan_job};
use camwright::simulation::Machine;
use camwright::simulation::workpiece::DEFAULT_AZIMUTHS;

const WIDTH_MM: f64 = 20.0;
/// Depth to which a journal may come out below its radius (mm): as the acceptance of runout correction has it, by a quiet gauge, and by one of 0.2 µm.
const QUIET_MM: f64 = 3e-4;
const NOISY_MM: f64 = 1.5e-3;
const NOISE_MM: f64 = 2e-4;

fn machine(random: &mut SplitMix64, mode: GaugingMode) -> MachineDescription {
    let grinding_n_mm = random.within(2e4, 5e4);
    let ratio = random.within(0.05, 0.5);
    let stiffness = vec![
        StiffnessAt { z_mm: 60.0, n_mm: ratio * grinding_n_mm },
        StiffnessAt { z_mm: 210.0, n_mm: random.within(0.7, 1.3) * ratio * grinding_n_mm },
    ];
    let contact = ContactDescription {
        stiffness,
        grinding_n_mm2: grinding_n_mm / WIDTH_MM,
        threshold_n_mm: random.within(0.0, 1.0),
        part_share: 0.7,
        modes: Vec::new(),
    };
    let two = mode == GaugingMode::Exact && random.next().is_multiple_of(4);
    let first_deg: f64 = if two { 300.0 } else { random.one_of(&[270.0, 270.0, 90.0, 135.0, 225.0, 315.0]) };
    let noisy = random.next().is_multiple_of(2);
    let gauge = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: first_deg.to_radians(),
        second_behind_wheel_rad: two.then(|| 60.0_f64.to_radians()),
        resolution_mm: if noisy { 1e-4 } else { 0.0 },
        noise_mm: if noisy { NOISE_MM } else { 0.0 },
        bandwidth_rad_s: None,
        seed: random.next() % 1000,
    };
    let machine = cam_grinder().with_drives(DriveSettings::IDEAL);
    let rotation_sense = random.one_of(&[1, 1, -1]);
    MachineDescription { contact: Some(contact), gauge: Some(gauge), rotation_sense, ..machine }
}

fn job(random: &mut SplitMix64, mode: GaugingMode) -> JobSpec {
    let radius_mm = random.within(12.0, 30.0);
    let wave = |random: &mut SplitMix64, max_mm: f64| Wave {
        mm: random.within(0.0, max_mm),
        at_rad: random.within(0.0, TURN_RAD),
    };
    let passes = vec![PassSpec {
        name: "grind".into(),
        total_infeed_mm: 0.18,
        infeed_per_block_mm: random.one_of(&[0.000_005, 0.000_002]),
        infeed_of_turns_mm: Vec::new(),
        air_mm: 0.0,
        infeed_course: InfeedCourse::PerAngle,
        infeed_direction: InfeedDirection::X,
        spark_out_turns: 1 + u32::try_from(random.next() % 4).expect("0 to 3"),
        spark_out_until_n: None,
        gauge_size: None,
        speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(random.within(30.0, 80.0)) },
    }];
    let raw_part = RawPart {
        clamped_at_rad: 0.0,
        eccentric: wave(random, 0.03),
        bend: None,
        lobes: vec![(3, wave(random, 0.005)), (2, wave(random, 0.004))],
        unknown_mm: 0.0,
    };
    let correction = CorrectionSpec {
        mode,
        harmonics: 15,
        published: PublishedWindow::default(),
        finishing: None,
        allowance_mm: random.one_of(&[0.02, 0.02, 0.005, 0.0]),
        stiffness: StiffnessSource::Best,
        contacts: Vec::new(),
    };
    let lobe = LobeSpec {
        name: "J1".into(),
        station: "LS2".into(),
        phase_rad: 0.0,
        profile: 0,
        width_mm: WIDTH_MM,
        tolerance: FormTolerance::default(),
        plunge: None,
        visit: None,
        axial: None,
    };
    JobSpec {
        profiles: vec![journal(radius_mm)],
        lobes: vec![lobe],
        passes,
        stock_mm: 0.1,
        raw_part,
        correction: Some(correction),
        c_between_lobes: BetweenLobes::Stops,
        rotary_indexing: false,
        rapid_advance_mm: 40.0,
        ..super::grinding::job(random)
    }
}

/// Share of their spacing by which places of the journal stand beside round angles, where ticks may end: each is passed once a turn.
const BESIDE: f64 = 0.381_966_011_25;

/// The journal turn by turn, by the contact law as the text has it: km T = F0 + kg U, T = r − U − L.
struct Journal {
    radii_mm: Vec<f64>,
    before: Option<(f64, f64)>,
    law: (f64, f64, f64),
}

impl Journal {
    fn meet(&mut self, line_rad: f64, x_mm: f64) {
        let count = self.radii_mm.len();
        let step = TURN_RAD / count as f64;
        if let Some((from_rad, from_mm)) = self.before
            && (line_rad - from_rad).abs() > 0.0
            && (line_rad - from_rad).abs() < 1.0
        {
            let (km, kg, f0) = self.law;
            let (low, high) = (from_rad.min(line_rad), from_rad.max(line_rad));
            let mut place = (low / step - BESIDE).floor() + 1.0;
            while (place + BESIDE) * step <= high {
                let share = ((place + BESIDE) * step - from_rad) / (line_rad - from_rad);
                let wheel_mm = from_mm + share * (x_mm - from_mm);
                let radius_mm = &mut self.radii_mm[(place as i64).rem_euclid(count as i64) as usize];
                let pressing_n = km * (*radius_mm - wheel_mm) - f0;
                *radius_mm -= (pressing_n / (kg + km)).max(0.0);
                place += 1.0;
            }
        }
        self.before = Some((line_rad, x_mm));
    }

    fn min_mm(&self) -> f64 {
        self.radii_mm.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

struct Shop {
    machine: Machine,
    interpolator: Interpolator,
    journal: Journal,
    station_mm: f64,
}

impl Shop {
    fn run(&mut self, plan: &Plan, requests: &[(u64, MotionRequest)]) -> Result<Vec<JournalReadings>, String> {
        let mut logs = vec![JournalReadings::default(); plan.lobes.len()];
        let sense = f64::from(self.machine.description().rotation_sense);
        let (journal, station_mm) = (&mut self.journal, self.station_mm);
        let each = |tick: &Tick<'_>| {
            if let Some(c_rad) = tick.c_rad.filter(|_| (tick.z_mm - station_mm).abs() < 0.5 * WIDTH_MM) {
                journal.meet(sense * c_rad, tick.x_mm);
            }
            let report = tick.report;
            let (Some(lobe), Some(value_mm)) = (report.lobe, report.gauge_mm[0]) else { return };
            let (c_rad, x_mm, motor_n) = (report.axes[0].position, report.axes[1].position, report.axes[1].effort);
            let second_mm = report.gauge_mm[1];
            logs[lobe].gauged.push(GaugedTick { tick: report.tick, c_rad, x_mm, value_mm, second_mm, motor_n });
        };
        match drive(plan, &mut self.interpolator, &mut self.machine, requests, each)? {
            MotionOutcome::Completed => Ok(logs),
            other => Err(format!("{other:?}")),
        }
    }
}

/// One job, from its seed.
pub(crate) fn judge(seed: u64) -> JobEnd {
    let mut random = SplitMix64(seed);
    let mode = random.one_of(&[GaugingMode::Exact, GaugingMode::Published, GaugingMode::Published]);
    let (machine, job) = (machine(&mut random, mode), job(&mut random, mode));
    let first = match plan_job(&job, &machine, 60.0, None) {
        Ok(first) => first,
        Err(error) => return JobEnd::Refused(error.to_string()),
    };
    let radius_mm = job.profiles[0].base_radius_mm;
    let station_mm = machine.station("LS2").expect("it is there").position_mm;
    let job_of = &job;
    let raw = |count: usize| {
        let azimuth = move |i: usize, beside: f64| (i as f64 + beside) * TURN_RAD / count as f64;
        move |beside: f64| {
            let raw_mm = |azimuth| radius_mm + job_of.stock_mm + job_of.raw_part.above_mm(azimuth, station_mm);
            (0..count).map(|i| raw_mm(azimuth(i, beside))).collect::<Vec<_>>()
        }
    };
    let law = machine.contact_law("LS2", WIDTH_MM).expect("a contact");
    let mut simulated = Machine::new(machine.clone(), PersistentState::new(&machine)).expect("a machine");
    simulated.load_lobe("J1", "LS2", WIDTH_MM, raw(DEFAULT_AZIMUTHS)(0.0)).expect("a raw journal");
    let journal = Journal {
        radii_mm: raw(3600)(BESIDE),
        before: None,
        law: (law.machine_n_mm(), law.grinding_n_mm(), law.threshold_n()),
    };
    let interpolator = Interpolator::new(&machine);
    let mut shop = Shop { machine: simulated, interpolator, journal, station_mm };
    let ticks = |plan: &Plan| plan.segments.iter().map(|segment| segment.ticks).sum::<u64>();
    let mut disturbed = |plan: &Plan| {
        let mut asked = if random.next().is_multiple_of(3) { requests(&mut random, ticks(plan)) } else { Vec::new() };
        asked.retain(|(_, request)| *request != MotionRequest::Cancel);
        asked
    };
    let asked = disturbed(&first.plan);
    let logs = match shop.run(&first.plan, &asked) {
        Ok(logs) => logs,
        Err(error) => return JobEnd::Gouge(format!("first half: {error}; {asked:?}")),
    };
    let noisy = machine.gauge.as_ref().is_some_and(|gauge| gauge.noise_mm > 0.0);
    let allowed_mm = if noisy { NOISY_MM } else { QUIET_MM };
    let before_mm = radius_mm - shop.journal.min_mm();
    if before_mm > allowed_mm {
        return JobEnd::Gouge(format!("the first half goes {:.3} um below the design", 1e3 * before_mm));
    }
    let decided = match decide_corrections(&job, &machine, &first, &logs, &[]) {
        Ok(decided) => decided,
        Err(error) => return JobEnd::Refused(error.to_string()),
    };
    let second = match plan_corrections(&job, &machine, &first, &decided) {
        Ok(second) => second,
        Err(error) => return JobEnd::Refused(error.to_string()),
    };
    let asked = disturbed(&second.plan);
    let mut fault = shop.run(&second.plan, &asked).err();
    let depth_mm = radius_mm - shop.journal.min_mm();
    let radii = shop.machine.part().lobe("J1").expect("it was loaded").radii_mm();
    let on_machine_mm = radius_mm - radii.iter().copied().fold(f64::INFINITY, f64::min);
    if depth_mm.max(on_machine_mm) > allowed_mm {
        let depths = format!("{:.3} um, on the machine {:.3} um", 1e3 * depth_mm, 1e3 * on_machine_mm);
        fault = Some(format!("{mode:?}: {depths} below the design; {}; {asked:?}", decided[0]));
    }
    fault.map_or(JobEnd::Clean { deepest_mm: depth_mm }, JobEnd::Gouge)
}
