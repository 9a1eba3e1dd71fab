// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Set-up work of the planner: dress now, change the wheel, touch off, find the part's phase. Each is a sequence of goals of the axis interpolator, on a
//! thread of its own, and holds the one place that a job has; `~/stop` ends it.

use super::job_slot::{JobEvent, JobSlot};
use super::loading::LoadingFailure;
use super::{MEETING, Shared, lock};
use camwright::interpolator::wheel_change::plan_wheel_change;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::math::units::{TURN_RAD, deg_from_rad, um_from_mm};
use camwright::motion::plan::Plan;
use camwright::planner::plan_dress;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::convert::plan::{Provenance, pages_from_plan};
use camwright_files::convert::{m_from_mm, mm_from_m, si_from_core};
use camwright_msgs::camwright_msgs::action::{
    ExecutePlanGoal, Home, HomeGoal, MoveTo, MoveToGoal, Probe, ProbeGoal, ProbeResult,
};
use camwright_msgs::camwright_msgs::srv::{
    ChangeWheel, ChangeWheelRequest, ChangeWheelResponse, Dress, DressRequest, DressResponse, FindPhase,
    FindPhaseRequest, FindPhaseResponse, TouchOff, TouchOffRequest, TouchOffResponse,
};
use camwright_msgs::{Action, Service};
use camwright_planning::{AnyPrepared, PreparedJob};
use camwright_ros::{ActionClient, GoalStatus, Node, Responder, RosError, ServiceHandle};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// Maximum time of a peer's answer.
const ANSWER: Duration = Duration::from_secs(10);
/// Period of the check during execution, and maximum absence.
const WATCH: Duration = Duration::from_millis(200);
const OUT_OF_SIGHT: Duration = Duration::from_secs(5);

/// Default and maximum correction of the zero of X by a touch-off (mm): a larger one indicates another wheel or another part.
const USUAL_CORRECTION_MM: f64 = 0.2;
const MAX_CORRECTION_MM: f64 = 1.0;
/// Stand-off of the wheel after the touch (mm), in addition to the possible error of the zero.
const STAND_OFF_MM: f64 = 1.0;
/// Searched share of a turn for the keyway: all of it, and a part of it again.
const SEARCHED: f64 = 1.2;
/// Relative tolerance of the keyway's width against the machine file.
const WIDTH_TOLERANCE: f64 = 0.25;

/// Set-up requests of the planner to the interpolator, and the angle at which the part is clamped.
#[derive(Debug)]
pub(super) struct Setup {
    home: ActionClient<Home>,
    move_to: ActionClient<MoveTo>,
    probe: ActionClient<Probe>,
    /// Azimuth of the keyway of the part that is between the centres (rad), once it was found.
    phase_rad: Mutex<Option<f64>>,
}

impl Setup {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        Ok(Self {
            home: node.action_client("axis_interpolator/home")?,
            move_to: node.action_client("axis_interpolator/move_to")?,
            probe: node.action_client("axis_interpolator/probe")?,
            phase_rad: Mutex::default(),
        })
    }

    /// The angle that was found, as an override of a job on that part.
    pub(super) fn phase_override(&self) -> Option<String> {
        lock(&self.phase_rad).map(|phase_rad| format!("part_phase_deg={:?}", deg_from_rad(phase_rad)))
    }

    /// Another part is put in.
    pub(super) fn forget_phase(&self) {
        *lock(&self.phase_rad) = None;
    }
}

/// Why set-up work did not come to its end.
#[derive(Debug)]
struct Failed {
    message: String,
    alarm: u16,
}

impl From<String> for Failed {
    fn from(message: String) -> Self {
        Self { message, alarm: 0 }
    }
}

impl From<&str> for Failed {
    fn from(message: &str) -> Self {
        message.to_owned().into()
    }
}

impl From<RosError> for Failed {
    fn from(error: RosError) -> Self {
        error.to_string().into()
    }
}

pub(super) fn offer(shared: &Arc<Shared>) -> Result<Vec<ServiceHandle>, RosError> {
    let dress = served::<Dress>(shared, "~/dress", "dressing now", SetupWork::dress, |failed| DressResponse {
        message: failed.message,
        alarm: failed.alarm,
        ..DressResponse::default()
    })?;
    let change =
        served::<ChangeWheel>(shared, "~/change_wheel", "changing the wheel", SetupWork::change_wheel, |failed| {
            ChangeWheelResponse { message: failed.message, alarm: failed.alarm, ..ChangeWheelResponse::default() }
        })?;
    let touch = served::<TouchOff>(shared, "~/touch_off", "touching off", SetupWork::touch_off, |failed| {
        TouchOffResponse { message: failed.message, alarm: failed.alarm, ..TouchOffResponse::default() }
    })?;
    let phase =
        served::<FindPhase>(shared, "~/find_phase", "finding the part's phase", SetupWork::find_phase, |failed| {
            FindPhaseResponse { message: failed.message, alarm: failed.alarm, ..FindPhaseResponse::default() }
        })?;
    Ok(vec![dress, change, touch, phase])
}

/// A service that holds the place of a job and answers from a thread of its own.
fn served<S: Service>(
    shared: &Arc<Shared>,
    name: &str,
    what: &'static str,
    work: fn(&SetupWork, &S::Request) -> Result<S::Response, Failed>,
    failed: fn(Failed) -> S::Response,
) -> Result<ServiceHandle, RosError>
where
    S::Request: Send + 'static,
    S::Response: Send + 'static,
{
    let this = Arc::clone(shared);
    shared.node.service_deferred::<S>(name, move |request, responder: Responder<S>| {
        let responder = responder.or_fail(move |reason: String| failed(Failed::from(reason)));
        let (events, inbox) = mpsc::channel();
        {
            let mut course = lock(&this.job_slot);
            let busy = match &*course {
                JobSlot::Idle if this.active.load(Ordering::Acquire) => None,
                JobSlot::Idle => Some("the node is not active".to_owned()),
                other => Some(other.to_string()),
            };
            let busy = busy.or_else(|| this.cell.keeps_set_up_out());
            if let Some(reason) = busy {
                return responder.send(&failed(Failed::from(reason)));
            }
            *course = JobSlot::Running(what.to_owned(), events);
        }
        let work_of = SetupWork { shared: Arc::clone(&this), inbox };
        let thread = this.node.supervisor().spawn("set-up", move || {
            let logger = work_of.shared.node.logger().clone();
            let _current = logger.enter();
            logger.info(&format!("{what} begins"));
            let outcome = work_of.ready().and_then(|()| work(&work_of, &request));
            // Idle before the client hears of the end: it may send the next request at once.
            *lock(&work_of.shared.job_slot) = JobSlot::Idle;
            let response = outcome.unwrap_or_else(|error| {
                logger.error(&format!("{what} failed: {}", error.message));
                failed(error)
            });
            responder.send(&response);
        });
        match thread {
            Ok(thread) => *lock(&this.run) = Some(thread),
            Err(error) => {
                this.node.logger().error(&format!("no thread for {what}: {error}"));
                *lock(&this.job_slot) = JobSlot::Idle;
            }
        }
    })
}

/// One piece of set-up work.
struct SetupWork {
    shared: Arc<Shared>,
    inbox: mpsc::Receiver<JobEvent>,
}

impl SetupWork {
    /// Checks that motion is possible.
    fn ready(&self) -> Result<(), Failed> {
        self.shared.execute.wait_for_server(MEETING)?;
        self.shared.setup.probe.wait_for_server(MEETING)?;
        self.shared.setup.move_to.wait_for_server(MEETING)?;
        match self.shared.stopping_alarm() {
            None => self.shared.cell.hindrance().map_or(Ok(()), |reason| Err(reason.into())),
            Some(alarm) => Err(Failed {
                message: format!("alarm {} needs a reset: {}; {}", alarm.number, alarm.text, alarm.remedy),
                alarm: alarm.number,
            }),
        }
    }

    fn machine(&self) -> Result<MachineNow, Failed> {
        Ok(self.shared.met_machine()?)
    }

    fn is_cancelled(&self) -> bool {
        matches!(self.inbox.try_recv(), Ok(JobEvent::Cancel))
    }

    /// Hands a goal to the interpolator and waits for its end.
    fn execute<A: Action>(&self, client: &ActionClient<A>, goal: A::Goal) -> Result<(GoalStatus, A::Result), Failed>
    where
        A::Result: Send + 'static,
    {
        if self.is_cancelled() {
            return Err("stopped by request".into());
        }
        let goal = client.send_goal(goal, drop, ANSWER)?;
        if !goal.accepted() {
            return Err("the axis interpolator rejected it; its log shows the reason".into());
        }
        let (sender, ended) = mpsc::channel();
        goal.result_with(move |status, result| drop(sender.send((status, result))))?;
        let mut seen = Instant::now();
        let interpolator = self.shared.interpolator.identity();
        loop {
            if let Ok(outcome) = ended.recv_timeout(WATCH) {
                return Ok(outcome);
            }
            if self.is_cancelled() {
                goal.cancel_with(drop)?;
            }
            self.shared.interpolator.check(interpolator, self.shared.stopping_alarm().is_some())?;
            if client.is_ready() {
                seen = Instant::now();
            } else if seen.elapsed() > OUT_OF_SIGHT {
                return Err("the axis interpolator has left; the machine stops by itself".into());
            }
        }
    }

    /// Axes to places (mm or rad), together.
    fn go(&self, to: &[(Axis, f64)]) -> Result<(), Failed> {
        let goal = MoveToGoal {
            joints: to.iter().map(|(axis, _)| axis.joint().to_owned()).collect(),
            positions: to.iter().map(|(axis, position)| si_from_core(*axis, *position)).collect(),
            ..MoveToGoal::default()
        };
        let (status, result) = self.execute(&self.shared.setup.move_to, goal)?;
        if status == GoalStatus::Succeeded {
            Ok(())
        } else {
            Err(Failed { message: result.message, alarm: result.alarm })
        }
    }

    /// The wheel to the far end of its travel: clear of every part and everything on the table.
    fn clear(&self, machine: &MachineDescription) -> Result<(), Failed> {
        match machine.axis(Axis::X).soft_limits {
            Some((_, high_mm)) => self.go(&[(Axis::X, high_mm)]),
            None => Err(
                "x_axis has no soft limits, so no position clear of the part is known; set them in the machine file"
                    .into(),
            ),
        }
    }

    /// A probe; an edge that was not found is a result as well.
    fn probe(&self, goal: ProbeGoal) -> Result<ProbeResult, Failed> {
        let (status, result) = self.execute(&self.shared.setup.probe, goal)?;
        let ran = status == GoalStatus::Succeeded || result.already_there;
        if ran { Ok(result) } else { Err(Failed { message: result.message, alarm: result.alarm }) }
    }

    /// The loaded job, or that of the parameter, for the machine as it is.
    fn job(&self) -> Result<PreparedJob, Failed> {
        match self.shared.prepare_usual(self.machine()?)? {
            AnyPrepared::Ground(prepared) => Ok(*prepared),
            AnyPrepared::Turned(prepared) => {
                Err(format!("job {} turns its part and has no lobes", prepared.job.spec.name).into())
            }
        }
    }

    fn dress(&self, request: &DressRequest) -> Result<DressResponse, Failed> {
        let now = self.machine()?;
        let depth_mm = if request.depth == 0.0 && now.description.dresser.is_some() {
            let of_job = self.job()?.job.spec.dressing.map(|dressing| dressing.depth_mm);
            of_job.ok_or("no depth is given, and the job has none; give a depth or set dressing.depth_um")?
        } else {
            mm_from_m(request.depth)
        };
        let (plan, dress) =
            plan_dress(&now.description, now.wheels.mounted, depth_mm).map_err(|error| error.to_string())?;
        self.execute_plan(&plan, &now.description, "dress")?;
        let message = format!(
            "the wheel is dressed from {:.4} to {:.4} mm, {:.3} um of wear and {:.3} um of depth",
            dress.old_radius_mm,
            dress.radius_mm(),
            um_from_mm(dress.wear_mm),
            um_from_mm(dress.depth_mm)
        );
        self.shared.node.logger().info(&message);
        Ok(DressResponse { success: true, message, alarm: 0, radius: m_from_mm(dress.radius_mm()) })
    }

    /// Publishes a plan of set-up work and has it executed.
    fn execute_plan(&self, plan: &Plan, machine: &MachineDescription, what: &str) -> Result<(), Failed> {
        let provenance = Provenance { job_hash: String::new(), machine_hash: machine.hash.clone() };
        let pages = pages_from_plan(plan, &provenance);
        for page in &pages {
            self.shared.plan.publish(page)?;
        }
        let goal = ExecutePlanGoal {
            plan_hash: pages.first().map_or_else(String::new, |page| page.plan_hash.clone()),
            client: format!("{}, {what}", self.shared.node.fully_qualified_name()),
        };
        let (status, result) = self.execute(&self.shared.execute, goal)?;
        if status == GoalStatus::Succeeded {
            Ok(())
        } else {
            Err(Failed { message: result.message, alarm: result.alarm })
        }
    }

    fn change_wheel(&self, request: &ChangeWheelRequest) -> Result<ChangeWheelResponse, Failed> {
        let now = self.machine()?;
        let plan =
            plan_wheel_change(&now.description, &now.wheels, &request.wheel).map_err(|error| error.to_string())?;
        self.execute_plan(&plan, &now.description, "wheel change")?;
        // A job that is planned from now on is for the new wheel.
        let since = Instant::now();
        let radius_mm = loop {
            let machine = self.machine()?.description;
            let changer = machine.wheel_changer.as_ref();
            if changer.and_then(|changer| changer.position(&request.wheel)) == Some(machine.mounted_wheel()) {
                break self.machine()?.wheels.mounted.radius_mm;
            }
            if since.elapsed() > MEETING {
                return Err("the machine has changed its wheel and does not describe it (machine/description)".into());
            }
            if let Ok(JobEvent::Cancel) = self.inbox.recv_timeout(WATCH) {
                return Err("stopped by request".into());
            }
        };
        let message = format!("wheel {} of radius {radius_mm:.4} mm is mounted", request.wheel);
        self.shared.node.logger().info(&message);
        Ok(ChangeWheelResponse { success: true, message, alarm: 0, radius: m_from_mm(radius_mm) })
    }

    /// Contact of a touch-off: position of the table, radius there and the largest one around it (mm).
    fn place(&self, request: &TouchOffRequest, machine: &MachineDescription) -> Result<(f64, f64, f64), Failed> {
        let given_mm = mm_from_m(request.radius);
        if !(given_mm >= 0.0 && given_mm.is_finite()) {
            return Err(format!("the radius is {} m; it must be a positive number", request.radius).into());
        }
        let table = |station: &str| {
            let known = || machine.stations.iter().map(|s| s.switch.as_str()).collect::<Vec<_>>().join(", ");
            let found = machine.station(station).map(|station| station.position_mm);
            found.ok_or_else(|| Failed::from(format!("there is no station {station:?}; the machine has {}", known())))
        };
        if request.lobe.is_empty() {
            if given_mm == 0.0 {
                return Err("without a lobe, station and radius are required".into());
            }
            return Ok((table(&request.station)?, given_mm, given_mm));
        }
        let job = self.job()?;
        let mut designs = job.planned.lobes.iter().map(|lobe| &lobe.design);
        let design = designs.find(|design| design.name == request.lobe).ok_or_else(|| {
            format!("unknown lobe {}; the lobes are {}", request.lobe, job.planned.plan.lobes.join(", "))
        })?;
        if design.contour.is_bore() {
            return Err(format!("lobe {} is a bore: a touch-off works on outer contours only", design.name).into());
        }
        if !design.is_round() {
            return Err(
                format!("lobe {} is not round: where the wheel touches it depends on its phase", design.name).into()
            );
        }
        let z_mm = table(&design.station)? + design.offset_mm();
        if given_mm > 0.0 {
            return Ok((z_mm, given_mm, given_mm));
        }
        let measured = self.shared.parts.lobe(&request.lobe);
        let outline = measured
            .filter(|lobe| !lobe.radius.is_empty())
            .ok_or_else(|| format!("lobe {} was not measured and no part is clamped; give its radius", request.lobe))?;
        let largest = outline.radius.iter().copied().fold(0.0, f64::max);
        let mean = outline.radius.iter().sum::<f64>() / outline.radius.len() as f64;
        Ok((z_mm, mm_from_m(mean), mm_from_m(largest)))
    }

    fn touch_off(&self, request: &TouchOffRequest) -> Result<TouchOffResponse, Failed> {
        let machine = self.machine()?.description;
        if machine.gap_detector.is_none() {
            return Err(format!("machine {} has no gap detector (gap_detector)", machine.name).into());
        }
        let max_mm =
            if request.most_correction == 0.0 { USUAL_CORRECTION_MM } else { mm_from_m(request.most_correction) };
        if !(max_mm > 0.0 && max_mm <= MAX_CORRECTION_MM) {
            let max_m = m_from_mm(MAX_CORRECTION_MM);
            return Err(format!("most_correction is {} m; it must be 0 to {max_m} m", request.most_correction).into());
        }
        let (z_mm, radius_mm, largest_mm) = self.place(request, &machine)?;
        self.clear(&machine)?;
        self.go(&[(Axis::Z, z_mm)])?;
        self.go(&[(Axis::X, largest_mm + max_mm)])?;
        let probed = self.probe(ProbeGoal {
            joint: Axis::X.joint().to_owned(),
            input: "wheel_contact".to_owned(),
            target: m_from_mm(radius_mm - max_mm),
            speed: request.speed,
            stand_off: m_from_mm(max_mm + STAND_OFF_MM),
            most_force: request.most_force,
            correct_zero: !request.only_measure,
            true_position: m_from_mm(radius_mm),
            most_correction: m_from_mm(max_mm),
            ..ProbeGoal::default()
        });
        let cleared = self.clear(&machine);
        let probed = found(probed?)?;
        cleared?;
        let (radius, off) = (m_from_mm(radius_mm), m_from_mm(radius_mm) - probed.position);
        let um = |m: f64| um_from_mm(mm_from_m(m));
        let corrected = match request.only_measure {
            true => "the zero of x_axis stays".to_owned(),
            false => format!("the zero of x_axis is corrected by {:+.2} um", um(probed.correction)),
        };
        let message = format!(
            "the wheel touched a radius of {radius_mm:.4} mm where x_axis read {:.4} mm, {:+.2} um off; {corrected}",
            mm_from_m(probed.position),
            um(off)
        );
        self.shared.node.logger().info(&message);
        let (position, correction) = (probed.position, probed.correction);
        Ok(TouchOffResponse { success: true, message, alarm: 0, radius, position, off, correction })
    }

    fn find_phase(&self, request: &FindPhaseRequest) -> Result<FindPhaseResponse, Failed> {
        if request.forget {
            self.shared.setup.forget_phase();
            let message = "the part is taken to be clamped as it should be".to_owned();
            return Ok(FindPhaseResponse { success: true, message, ..FindPhaseResponse::default() });
        }
        let machine = self.machine()?.description;
        let switch = machine
            .key_way_probe
            .ok_or_else(|| format!("machine {} has no switch at the keyway (key_way_probe)", machine.name))?;
        if request.load_part {
            let job = self.job()?;
            self.shared.put_in(&job, &|| self.is_cancelled()).map_err(|reason| match reason {
                LoadingFailure::Cancelled => "cancelled before anything moved".to_owned(),
                LoadingFailure::Refused(reason) => reason,
            })?;
        }
        self.clear(&machine)?;
        let home = HomeGoal { joints: vec![Axis::C.joint().to_owned()] };
        let (status, homed) = self.execute(&self.shared.setup.home, home)?;
        if status != GoalStatus::Succeeded {
            return Err(Failed { message: homed.message, alarm: homed.alarm });
        }
        let edge = |until_open: bool, target: f64| {
            self.probe(ProbeGoal {
                joint: Axis::C.joint().to_owned(),
                input: "key_way".to_owned(),
                until_open,
                target,
                speed: request.speed,
                ..ProbeGoal::default()
            })
        };
        let mut closes = edge(false, SEARCHED * TURN_RAD)?;
        if closes.already_there {
            // C stands with the keyway under its switch: out of it first.
            self.go(&[(Axis::C, -2.0 * switch.width_rad)])?;
            closes = edge(false, SEARCHED * TURN_RAD)?;
        }
        let closes = found(closes)?.position;
        // It ran on behind the edge; into the keyway again, and out of it on its other side.
        self.go(&[(Axis::C, closes + 0.25 * switch.width_rad)])?;
        let opens = found(edge(true, closes + 2.0 * switch.width_rad)?)?.position;
        let (width, centre) = (opens - closes, 0.5 * (opens + closes));
        if (width - switch.width_rad).abs() > WIDTH_TOLERANCE * switch.width_rad {
            return Err(format!(
                "the edge pair at the switch is {:.2} deg wide, the keyway has {:.2} deg: remove chips or check the part",
                deg_from_rad(width),
                deg_from_rad(switch.width_rad)
            )
            .into());
        }
        let key_way = switch.key_way_rad(centre, machine.rotation_sense);
        let phase = key_way - (key_way / TURN_RAD).round() * TURN_RAD;
        *lock(&self.shared.setup.phase_rad) = Some(phase);
        let message = format!(
            "the keyway lies {:+.4} deg from where it should be, {:.2} deg wide; jobs on this part (start_lobe) take it into account",
            deg_from_rad(phase),
            deg_from_rad(width)
        );
        self.shared.node.logger().info(&message);
        Ok(FindPhaseResponse { success: true, message, alarm: 0, phase, width })
    }
}

/// A probe that found its edge.
fn found(result: ProbeResult) -> Result<ProbeResult, Failed> {
    if result.found { Ok(result) } else { Err(Failed { message: result.message, alarm: result.alarm }) }
}
