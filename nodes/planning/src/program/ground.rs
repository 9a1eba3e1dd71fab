// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The program of a grinding job: every lobe by passes of whole turns, each a little deeper, then some that take nothing.

use super::super::PreparedJob;
use super::request::{Plane, ProgramOutline, ToPost};
use camwright::gcode::post::{FeatureRequest, Lead, PassRequest, PostRequest, ProgramTurnSpeed};
use camwright::gcode::{Direction, Tool};
use camwright::job::grinding::PassSpec;
use camwright::math::units::{TURN_RAD, rpm_from_rad_s};
use camwright::motion::speed_plan::SpeedPlan;
use camwright::planner::PlannedLobe;
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath, Travel};
use camwright_files::ConfigError;
use camwright_files::job_file::Job;
use camwright_files::nc_file::NcSettings;

/// Points of a drawn contour.
const OUTLINE_POINTS: u32 = 720;

/// A lobe's path and what bounds it.
struct LobePath {
    path: CutterPath,
    highest_mm: f64,
    speeds: Vec<Speed>,
}

/// Speed of C in a pass.
enum Speed {
    Constant(f64),
    Law(Box<dyn Fn(f64) -> f64>),
}

impl Speed {
    fn from_speed_plan(plan: &SpeedPlan, start_rad: f64) -> Self {
        let (slowest, fastest) = plan.speed_range_rad_s();
        if fastest - slowest < 1e-9 {
            return Self::Constant(fastest);
        }
        // The cut begins at an angle of its own; the law starts there.
        let plan = plan.clone();
        Self::Law(Box::new(move |u_rad| plan.speed_in_turn_rad_s(u_rad - start_rad)))
    }

    fn turn(&self) -> ProgramTurnSpeed<'_> {
        match self {
            Self::Constant(speed) => ProgramTurnSpeed::WorkSpeed(*speed),
            Self::Law(law) => ProgramTurnSpeed::Law(law.as_ref()),
        }
    }
}

/// Makes the request of a grinding job and hands it on.
///
/// # Errors
/// What a program cannot do: dress, wait for a gauge, cut air by a dry run.
pub(super) fn with_request<R>(
    prepared: &PreparedJob,
    settings: &NcSettings,
    done: impl FnOnce(ToPost<'_>) -> Result<R, ConfigError>,
) -> Result<R, ConfigError> {
    let (spec, document) = (&prepared.job.spec, &prepared.job.document);
    refuse_what_needs_the_machine(&prepared.job)?;
    let lobes = lobes(prepared, settings);
    let per_turn_mm = |pass: &PassSpec, plan: &SpeedPlan| {
        let even_mm = pass.total_infeed_mm / f64::from(infeed_turns(pass, plan));
        pass.infeed_of_turns_mm.iter().copied().reduce(f64::max).unwrap_or(even_mm)
    };
    let deepest_mm = prepared.planned.lobes.iter().flat_map(|lobe| spec.passes.iter().zip(&lobe.passes));
    let deepest_mm = deepest_mm.map(|(pass, plan)| per_turn_mm(pass, plan)).fold(0.0, f64::max);
    let height_mm = spec.retract_clearance_mm + deepest_mm;
    let mut features = Vec::new();
    for (lobe, planned) in lobes.iter().zip(&prepared.planned.lobes) {
        let z_mm = planned.design.z_mm(&prepared.machine);
        features.push(FeatureRequest {
            name: planned.design.name.clone(),
            phase_rad: planned.design.phase_rad,
            path: &lobe.path,
            stands_mm: z_mm.map(|z_mm| (CarriageAxis::Z, z_mm)).into_iter().collect(),
            clear_mm: lobe.highest_mm + spec.maximum_stock_mm() + height_mm,
            lead: Lead { height_mm, angle_rad: settings.lead_rad, leaves_turning: true },
            passes: passes(prepared, planned, lobe, settings),
        });
    }
    let radius_mm = prepared.wheel_radius_mm;
    let rim_m_s = prepared.machine.wheel.surface_speed_m_s;
    let request = PostRequest {
        name: spec.name.clone(),
        number: settings.program_number,
        header: Vec::new(),
        tool: Tool { number: settings.tool_number, radius_mm, text: format!("wheel radius {radius_mm:.3} mm") },
        spindle: Some((Direction::Clockwise, settings.spindle_rpm.unwrap_or_else(|| spindle_rpm(rim_m_s, radius_mm)))),
        coolant: settings.coolant,
        control: settings.control,
        features,
    };
    let outline = |lobe: &PlannedLobe| {
        let points = (0..=OUTLINE_POINTS).map(|i| {
            let point = lobe.design.contour.point(f64::from(i) * TURN_RAD / f64::from(OUTLINE_POINTS));
            [point.x, point.y]
        });
        Some(ProgramOutline {
            closed: vec![points.collect()],
            cutter_mm: radius_mm,
            edge_mm: if settings.x_of_edge { radius_mm } else { 0.0 },
            plane: Plane::Across,
        })
    };
    done(ToPost {
        request,
        settings: *settings,
        document,
        job: &spec.name,
        job_hash: &prepared.job.hash,
        outlines: prepared.planned.lobes.iter().map(outline).collect(),
        notes: Vec::new(),
    })
}

/// Speed of a spindle for the speed of its wheel's surface (1/min).
pub(super) fn spindle_rpm(surface_m_s: f64, radius_mm: f64) -> u32 {
    let rad_s = camwright_files::convert::mm_from_m(surface_m_s) / radius_mm;
    #[allow(clippy::cast_possible_truncation, reason = "a spindle's speed")]
    let rpm = rpm_from_rad_s(rad_s).clamp(1.0, 99_999.0).round() as u32;
    rpm
}

/// Refuses features that need the running machine: a program is made beforehand.
pub(crate) fn refuse_what_needs_the_machine(job: &Job) -> Result<(), ConfigError> {
    let (spec, document) = (&job.spec, &job.document);
    let refusals = [
        (spec.correction.is_some(), "runout_correction", "corrects runout by a gauge during the run"),
        (spec.measure_stock.is_some(), "measure_stock", "measures the stock before it cuts"),
        (spec.size_control().is_some(), "infeed.gauge_size", "ends the infeed at the size that a gauge reads"),
        (spec.dry_run_mm.is_some(), "dry_run", "is a dry run"),
        (spec.speed_variation.is_some(), "speed_variation", "varies the work speed from turn to turn"),
        (!spec.wheels_in_order().is_empty(), "wheel", "changes the wheel between its cuts"),
        (spec.dressing.is_some(), "dressing", "dresses the wheel, after which every path is another"),
    ];
    if let Some(index) = spec.profiles.iter().position(|profile| profile.is_bore) {
        let message = "the job grinds an internal contour; an NC program has outer contours only";
        return Err(document.error(&format!("profiles.{index}.internal"), message));
    }
    match refusals.into_iter().find(|(is_so, ..)| *is_so) {
        Some((_, key, what)) => {
            Err(document
                .error(key, format!("the job {what}; an NC program cannot do this; remove it (--set {key}=null)")))
        }
        None => Ok(()),
    }
}

/// The path of the cutter's centre, or of its edge, around every lobe.
fn lobes(prepared: &PreparedJob, settings: &NcSettings) -> Vec<LobePath> {
    let sense = f64::from(settings.control.rotation_sense);
    let lobe = |planned: &PlannedLobe| {
        let mut path = CutterPath::from_periphery(&planned.tool_path);
        if settings.x_of_edge {
            path.travels = vec![Travel { axis: CarriageAxis::X, position: planned.tool_path.spline().clone().into() }];
        }
        let highest_mm =
            path.travels.iter().map(|travel| travel.position.hull_mm().1).fold(f64::NEG_INFINITY, f64::max);
        let start_rad = sense * planned.start_rad;
        LobePath {
            path,
            highest_mm,
            speeds: planned.passes.iter().map(|plan| Speed::from_speed_plan(plan, start_rad)).collect(),
        }
    };
    prepared.planned.lobes.iter().map(lobe).collect()
}

fn infeed_turns(pass: &PassSpec, plan: &SpeedPlan) -> u32 {
    plan.turns().saturating_sub(pass.spark_out_turns).max(1)
}

/// Calls of every pass: a turn deeper each time, then as many as take nothing. Turns above the stock would cut air.
fn passes<'a>(
    prepared: &PreparedJob,
    planned: &PlannedLobe,
    lobe: &'a LobePath,
    settings: &NcSettings,
) -> Vec<PassRequest<'a>> {
    let spec = &prepared.job.spec;
    let mut left_mm = spec.passes_infeed_mm();
    let mut requests = Vec::new();
    for (number, (pass, (plan, speed))) in spec.passes.iter().zip(planned.passes.iter().zip(&lobe.speeds)).enumerate() {
        let turns = infeed_turns(pass, plan);
        let per_turn_mm = pass.total_infeed_mm / f64::from(turns);
        let ends_mm = if number + 1 == spec.passes.len() { 0.0 } else { left_mm - pass.total_infeed_mm };
        let after_mm = |turn: u32| match pass.infeed_of_turns_mm.as_slice() {
            [] => f64::from(turn) * per_turn_mm,
            each_mm => each_mm.iter().take(turn as usize).sum(),
        };
        let deeper = (1..=turns).map(|turn| if turn == turns { ends_mm } else { left_mm - after_mm(turn) });
        let deeper = deeper.filter(|leaves_mm| *leaves_mm < spec.maximum_stock_mm());
        let request = |name: String, leaves_mm: Vec<f64>, tolerance_mm: f64| PassRequest {
            name,
            leaves_mm,
            tolerance_mm,
            widest_tolerance_mm: settings.widest_tolerance_mm.max(tolerance_mm),
            knots: settings.knots,
            speed: speed.turn(),
            turns: 1,
        };
        let dwells = vec![ends_mm; pass.spark_out_turns as usize];
        let finish_mm = if ends_mm > 0.0 { settings.rough_tolerance_mm } else { settings.finish_tolerance_mm };
        requests.push(request(format!("{} infeed", pass.name), deeper.collect(), settings.rough_tolerance_mm));
        requests.push(request(format!("{} spark-out", pass.name), dwells, finish_mm));
        left_mm = ends_mm;
    }
    requests.retain(|request| !request.leaves_mm.is_empty());
    requests
}
