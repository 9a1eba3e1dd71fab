//! Jobs of the benchmarks: `params/jobs/four_lobe_camshaft` on `cam_grinder` and `params/jobs/turned_cam` on `lathe`, without the files'
//! reader, so that the core runs them alone. Change them together with those files.
#![allow(dead_code, reason = "each program uses its part")]

use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::{
    AngleUnit, LengthUnit, LiftDeclaration, LiftForm, LiftLaw, LiftRow, LiftTable, MotionProgram, MotionSegment,
};
use camwright::cam::motion_law::MotionLaw;
use camwright::cam::surface::Surface;
use camwright::cam::surface::cams::CamAlong;
use camwright::interpolator::{Motion, Prepared};
use camwright::job::grinding::{
    BetweenLobes, HoldInCut, HomePosition, InfeedCourse, InfeedDirection, JobSpec, LobeSpec, PassSpec, ProfileSpec,
    SpeedLaw,
};
use camwright::job::raw_part::RawPart;
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::description::{
    AlarmRetract, Axis, AxisDescription, AxisScale, ContactDescription, DriveSettings, GrindingProcess,
    InsertDescription, MachineDescription, MotionLimits, ReferenceCut, Station, StiffnessAt, Structure,
    ThermalDescription, WheelDescription,
};
use camwright::machine::persistent_state::PersistentState;
use camwright::math::units::{TURN_RAD, mm_from_um, rad_from_deg, rad_s_from_rpm};
use camwright::motion::plan::Plan;
use camwright::planner::{plan_job, plan_turning};
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::turned_part::{PartGrid, TurnedPart};
use camwright::toolpath::insert_path::{InsertFeed, Passes};
use std::error::Error;
use std::sync::Arc;

/// Azimuths of a raw lobe.
const AZIMUTHS: u32 = 3600;

/// Grid of the turned part: ten columns in a finishing feed.
pub(crate) const TURNED_GRID: PartGrid = PartGrid { azimuths: 720, columns: 1201, from_mm: 0.0, to_mm: 24.0 };

/// A planned job and its raw part.
pub(crate) enum Benchmark {
    Ground { job: Box<JobSpec>, plan: Arc<Plan>, raw_mm: Vec<Vec<f64>> },
    Turned { job: Box<TurningJob>, plan: Arc<Plan> },
}

impl Benchmark {
    /// The default job of the grinder.
    pub(crate) fn ground() -> Result<Self, Box<dyn Error>> {
        let (job, machine) = (camshaft()?, cam_grinder());
        let planned = plan_job(&job, &machine, machine.wheel.new_radius_mm, None)?;
        let azimuth = |i: u32| f64::from(i) * TURN_RAD / f64::from(AZIMUTHS);
        let raw = planned.lobes.iter().map(|lobe| {
            // Stock along the ray.
            (0..AZIMUTHS).map(|i| lobe.design.radius_at(azimuth(i)) + job.stock_mm).collect()
        });
        let raw_mm = raw.collect();
        Ok(Self::Ground { job: Box::new(job), plan: Arc::new(planned.plan), raw_mm })
    }

    /// The 3-D cam of the lathe.
    pub(crate) fn turned() -> Result<Self, Box<dyn Error>> {
        let (job, machine) = (turned_cam()?, lathe());
        let plan = Arc::new(plan_turning(&job, &machine, None)?.plan);
        Ok(Self::Turned { job: Box::new(job), plan })
    }

    /// Its machine with all effects.
    pub(crate) fn machine(&self) -> MachineDescription {
        match self {
            Self::Ground { .. } => cam_grinder(),
            Self::Turned { .. } => lathe(),
        }
    }

    /// The machine with the raw part, and the job's motion started.
    pub(crate) fn start(&self, description: &MachineDescription) -> Result<ClosedLoop, Box<dyn Error>> {
        let mut machine = Machine::new(description.clone(), PersistentState::new(description))?;
        let plan = match self {
            Self::Ground { job, plan, raw_mm } => {
                for (lobe, radii) in job.lobes.iter().zip(raw_mm) {
                    machine.load_lobe(&lobe.name, &lobe.station, lobe.width_mm, radii.clone())?;
                }
                plan
            }
            Self::Turned { job, plan } => {
                let bar = TurnedPart::round(job.name.clone(), TURNED_GRID, job.bar_radius_mm)?;
                machine.load_turned_part(bar, job.part_zero_mm)?;
                plan
            }
        };
        let motion = Prepared::new(Motion::Plan(plan.clone()), description)?;
        machine.begin_job();
        let mut closed_loop = ClosedLoop::direct(machine);
        closed_loop.start(Box::new(motion))?;
        Ok(closed_loop)
    }
}

fn structure(frequency_hz: f64, damping: f64, mass_share: f64) -> Option<Structure> {
    Some(Structure { frequency_rad_s: frequency_hz * TURN_RAD, damping, mass_share })
}

/// Gains, loops and encoder of a drive on a linear or torque motor. Friction is per mm/s or rad/s.
fn drive(
    [kv_1_s, velocity_feed_forward, acceleration_feed_forward]: [f64; 3],
    [loop_hz, integral_ms]: [f64; 2],
    max_force: f64,
    [coulomb_friction, viscous_friction]: [f64; 2],
) -> DriveSettings {
    DriveSettings {
        kv_1_s,
        velocity_feed_forward,
        acceleration_feed_forward,
        velocity_loop_rad_s: Some(loop_hz * TURN_RAD),
        velocity_integral_s: Some(1e-3 * integral_ms),
        max_force: Some(max_force),
        coulomb_friction,
        viscous_friction,
        encoder_step_counts: 1.0,
        encoder_noise_counts: 0.3,
        ..DriveSettings::IDEAL
    }
}

/// A ball screw.
fn screw(coulomb_friction: f64, viscous_n_s_m: f64, frequency_hz: f64) -> DriveSettings {
    DriveSettings {
        max_force: None,
        backlash: mm_from_um(2.0),
        structure: structure(frequency_hz, 0.05, 0.2),
        encoder_noise_counts: 0.0,
        ..drive([60.0, 0.98, 0.8], [60.0, 20.0], 0.0, [coulomb_friction, 1e-3 * viscous_n_s_m])
    }
}

/// The machine of `params/machines/cam_grinder.yaml`, without its name, its hash and its better drives.
pub(crate) fn cam_grinder() -> MachineDescription {
    let station = |(switch, position_mm): (&str, f64)| Station { switch: switch.to_owned(), position_mm };
    let c = AxisDescription {
        axis: Axis::C,
        scale: AxisScale::Rotary { counts_per_turn: 3_600_000 },
        limits: MotionLimits { velocity: rad_s_from_rpm(300.0), acceleration: 300.0, jerk: 3e4 },
        soft_limits: None,
        overtravel: None,
        max_following_error: rad_from_deg(5.0),
        min_following_error: rad_from_deg(0.5),
        needs_homing: true,
        homing: None,
        search_velocity: rad_s_from_rpm(20.0),
        drive: DriveSettings {
            gain_error: 0.01 * 1.0,
            structure: structure(140.0, 0.04, 0.2),
            ..drive([200.0, 0.99, 0.97], [120.0, 10.0], 80.0, [1.0, 0.05])
        },
        good_drive: None,
        inertia: 0.05,
        power_up_position: rad_from_deg(137.25),
    };
    let x = AxisDescription {
        axis: Axis::X,
        scale: AxisScale::Linear { counts_per_mm: 100_000 },
        limits: MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 },
        soft_limits: Some((5.0, 180.0)),
        overtravel: Some((3.0, 182.0)),
        max_following_error: 2.0,
        min_following_error: 0.2,
        needs_homing: false,
        homing: None,
        search_velocity: 5.0,
        drive: DriveSettings {
            structure: structure(150.0, 0.04, 0.2),
            ..drive([200.0, 0.99, 0.97], [120.0, 10.0], 6000.0, [20.0, 1e-3 * 200.0])
        },
        good_drive: None,
        inertia: 250.0,
        power_up_position: 150.0,
    };
    let stiffness = [(80.0, 45.0), (150.0, 38.0), (225.0, 45.0)];
    MachineDescription {
        name: String::from("cam_grinder"),
        hash: String::new(),
        cycle_time_ns: 1_000_000,
        feedback_delay_ticks: 100,
        servo_steps_per_tick: 4,
        axes: [c, x, table((-20.0, 600.0), 600.0, screw(150.0, 1000.0, 70.0))],
        stations: [("LS1", 80.0), ("LS2", 125.0), ("LS3", 180.0), ("LS4", 225.0)].map(station).to_vec(),
        dog_length_mm: 8.0,
        switch_hysteresis_mm: 0.05,
        origin_half_window_rad: rad_from_deg(0.5 * 2.0),
        wheel: WheelDescription {
            new_radius_mm: 60.0,
            min_radius_mm: 40.0,
            width_mm: 25.0,
            surface_speed_m_s: 80.0,
            spin_up_s: 2.0,
            max_surface_speed_m_s: None,
            max_speed_rad_s: None,
            grinding_ratio: None,
            unbalance_mm: mm_from_um(0.1),
        },
        insert: None,
        contact: Some(ContactDescription {
            stiffness: stiffness.map(|(z_mm, n_um)| StiffnessAt { z_mm, n_mm: 1e3 * n_um }).to_vec(),
            grinding_n_mm2: 1e3 * 1.5,
            threshold_n_mm: 0.8,
            part_share: 0.5,
        }),
        thermal: Some(ThermalDescription { growth_mm: mm_from_um(8.0), time_constant_s: 1200.0, start_share: 1.0 }),
        gauge: None,
        gap_detector: None,
        key_way_probe: None,
        loading: None,
        process: Some(GrindingProcess {
            specific_energy_j_mm3: 40.0,
            rubbing_n_mm2: 0.2,
            safe_cut: ReferenceCut {
                footprint_speed_mm_s: 200.0,
                depth_mm: mm_from_um(50.0),
                equivalent_diameter_mm: 30.0,
            },
        }),
        retract: AlarmRetract::default(),
        dresser: None,
        headstock: None,
        tailstock: None,
        rotation_sense: 1,
    }
}

/// Z on a ball screw.
fn table((soft_min_mm, soft_max_mm): (f64, f64), inertia: f64, drive: DriveSettings) -> AxisDescription {
    AxisDescription {
        axis: Axis::Z,
        scale: AxisScale::Linear { counts_per_mm: 10_000 },
        limits: MotionLimits { velocity: 250.0, acceleration: 2e3, jerk: 5e4 },
        soft_limits: Some((soft_min_mm, soft_max_mm)),
        overtravel: Some((soft_min_mm - 2.0, soft_max_mm + 2.0)),
        max_following_error: 5.0,
        min_following_error: 0.5,
        needs_homing: false,
        homing: None,
        search_velocity: 40.0,
        drive,
        good_drive: None,
        inertia,
        power_up_position: 0.0,
    }
}

/// The machine of `params/machines/lathe.yaml`, without its name, its hash and its better drives.
pub(crate) fn lathe() -> MachineDescription {
    let grinder = cam_grinder();
    let [c, x, _] = grinder.axes;
    let insert = InsertDescription {
        radius_mm: 8.0,
        height_mm: -14.0,
        height_range_mm: (-30.0, 30.0),
        relief_rad: rad_from_deg(7.0),
        surface_speed_m_s: 2.0,
        spin_up_s: 1.0,
        max_speed_rad_s: Some(rad_s_from_rpm(6000.0)),
    };
    let c = AxisDescription {
        limits: MotionLimits { velocity: rad_s_from_rpm(600.0), acceleration: 600.0, jerk: 6e4 },
        drive: DriveSettings {
            gain_error: 0.01 * 1.0,
            structure: structure(180.0, 0.04, 0.2),
            ..drive([200.0, 0.99, 0.97], [120.0, 10.0], 40.0, [0.6, 0.02])
        },
        inertia: 0.02,
        power_up_position: rad_from_deg(211.0),
        ..c
    };
    let x = AxisDescription {
        limits: MotionLimits { velocity: 1000.0, acceleration: 2e4, jerk: 4e6 },
        soft_limits: Some((8.5, 120.0)),
        overtravel: Some((8.2, 122.0)),
        search_velocity: 10.0,
        drive: DriveSettings {
            structure: structure(220.0, 0.04, 0.15),
            ..drive([250.0, 0.99, 0.97], [150.0, 8.0], 1500.0, [15.0, 1e-3 * 60.0])
        },
        inertia: 25.0,
        power_up_position: 100.0,
        ..x
    };
    MachineDescription {
        name: String::from("lathe"),
        axes: [c, x, table((-20.0, 300.0), 200.0, screw(80.0, 600.0, 80.0))],
        stations: Vec::new(),
        wheel: insert.tool(),
        insert: Some(insert),
        contact: None,
        thermal: None,
        process: None,
        ..grinder
    }
}

/// A table of `params/lifts`: absolute lifts in thousandths of a millimetre over cam degrees.
fn lift_law(text: &str) -> Result<LiftLaw, Box<dyn Error>> {
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if let Some((angle, lift)) = line.split_once(',')
            && let (Ok(angle_deg), Ok(value_mm)) = (angle.parse::<f64>(), lift.parse::<f64>())
        {
            rows.push(LiftRow { line: index + 1, angle_deg: Some(angle_deg), value_mm });
        }
    }
    let declaration = LiftDeclaration {
        form: LiftForm::Absolute,
        angle_unit: AngleUnit::CamDegrees,
        resolution_mm: 0.001,
        unit: LengthUnit::Millimetre,
        smooth_within_mm: 0.0,
        blocks: None,
    };
    Ok(LiftLaw::from_table(&LiftTable::from_rows(&rows, &declaration)?)?)
}

/// The job of `params/jobs/four_lobe_camshaft.yaml`.
pub(crate) fn camshaft() -> Result<JobSpec, Box<dyn Error>> {
    let profile = |name: &str, base_radius_mm, table| {
        Ok::<_, Box<dyn Error>>(ProfileSpec {
            name: name.to_owned(),
            lift: lift_law(table)?,
            follower: Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 },
            base_radius_mm,
        })
    };
    let lobe = |name: &str, station: &str, profile, phase_deg| LobeSpec {
        name: name.to_owned(),
        station: station.to_owned(),
        phase_rad: rad_from_deg(phase_deg),
        profile,
        width_mm: 14.0,
    };
    Ok(JobSpec {
        name: String::from("four_lobe_camshaft"),
        profiles: vec![
            profile("intake", 16.0, include_str!("../../../params/lifts/intake.csv"))?,
            profile("exhaust", 15.5, include_str!("../../../params/lifts/exhaust.csv"))?,
        ],
        lobes: vec![
            lobe("I1", "LS1", 0, 210.0),
            lobe("E1", "LS2", 1, 312.0),
            lobe("I2", "LS3", 0, 30.0),
            lobe("E2", "LS4", 1, 72.0),
        ],
        blocks_per_turn: 3600,
        rapid_advance_mm: 40.0,
        rapid_speed_mm_s: 100.0,
        stock_mm: 0.3,
        passes: vec![PassSpec {
            name: String::from("grind"),
            total_infeed_mm: 0.36,
            infeed_per_block_mm: mm_from_um(0.01),
            infeed_course: InfeedCourse::PerAngle,
            infeed_direction: InfeedDirection::X,
            spark_out_turns: 4,
            spark_out_until_n: None,
            speed: SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: rad_s_from_rpm(60.0) },
        }],
        retract_clearance_mm: 2.0,
        hold_in_cut: HoldInCut::Retract,
        wheel_power: None,
        c_between_lobes: BetweenLobes::Stops,
        rotary_indexing: false,
        home: HomePosition { x_mm: 150.0, z_mm: 0.0 },
        dressing: None,
        obstacles: Vec::new(),
        clearance_mm: 1.0,
        wheels: Vec::new(),
        raw_part: RawPart::default(),
        correction: None,
        compensation: None,
        identification: None,
        dry_run_mm: None,
        part_phase_rad: 0.0,
        measure_stock: None,
    })
}

/// The job of `params/jobs/turned_cam.yaml`.
pub(crate) fn turned_cam() -> Result<TurningJob, Box<dyn Error>> {
    let contour = |segments: &[(MotionLaw, f64, f64)]| {
        let segment = |(law, deg, rise_mm): &(MotionLaw, f64, f64)| MotionSegment {
            law: *law,
            angle_rad: rad_from_deg(*deg),
            rise_mm: *rise_mm,
        };
        let segments = segments.iter().map(segment).collect::<Vec<_>>();
        let law = LiftLaw::from_program(MotionProgram::new(0.0, &segments)?)?;
        Ok::<_, Box<dyn Error>>(Contour::from_lift(&law, &Follower::KnifeEdge { offset_mm: 0.0 }, 20.0)?)
    };
    let (eased, dwell) = (MotionLaw::Polynomial4567, MotionLaw::Dwell);
    let high = contour(&[(eased, 130.0, 4.5), (dwell, 20.0, 0.0), (eased, 130.0, -4.5), (dwell, 80.0, 0.0)])?;
    let low = contour(&[(eased, 120.0, 3.0), (eased, 120.0, -3.0), (dwell, 120.0, 0.0)])?;
    let surface = Surface::cams(&[
        CamAlong { contour: &high, phase_rad: 0.0, from_mm: 0.0, to_mm: 4.0 },
        CamAlong { contour: &low, phase_rad: rad_from_deg(20.0), from_mm: 20.0, to_mm: 24.0 },
    ])?;
    let in_plane = |radius_mm: f64| (radius_mm * radius_mm - 14.0 * 14.0).max(0.0).sqrt();
    let stock_mm = (in_plane(24.6) - in_plane(surface.bounds(0.0, 24.0).min_mm)).max(0.0);
    Ok(TurningJob {
        name: String::from("turned_cam"),
        surface,
        turned_mm: (24.0, 0.0),
        bar_radius_mm: 24.6,
        part_zero_mm: 2.0,
        passes: Passes { stock_mm, finish_mm: 0.3, deepest_mm: 3.0, rough_feed: InsertFeed::AlongZ(0.5) },
        feed: InsertFeed::AlongZ(0.2),
        angles: 360,
        speed: TurningSpeed::Fastest,
        clearance_mm: 1.0,
        rapid_speed_mm_s: 200.0,
    })
}
