// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine as others see it: description, transforms, markers, and the outline of the part while it is cut.

use super::CycleInlet;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::process_monitor::{Engaged, ProcessMonitor, ProcessValues};
use camwright::simulation::tick_report::TickReport;
use camwright_files::convert::machine_description::WHEEL_JOINT;
use camwright_files::convert::time::TickClock;
use camwright_files::convert::{centre_values, m_from_mm, section_centre_values, si_from_core, si_from_counts};
use camwright_machine_cycle::messages::Inbound;
use camwright_machine_cycle::outline::PartOutline;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::PartLobe;
use camwright_msgs::control_msgs::msg::{DynamicJointState, InterfaceValue};
use camwright_msgs::std_msgs::msg::{Header, String as Text};
use camwright_msgs::tf2_msgs::msg::TFMessage;
use camwright_msgs::visualization_msgs::msg::{Marker, MarkerArray};
use camwright_ros::running::NodeError;
use camwright_ros::{Node, Parameter, Publisher, Qos, RosError, Telemetry};
use camwright_scene::{self as scene, MarkerPose, Rgba, Tree, UrdfVersion};
use camwright_threads::drops::DropCounter;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// Machine time between two sets of transforms (ns): 50 in a second, as a screen shows them.
const TRANSFORM_PERIOD_NS: u64 = 20_000_000;
/// Real time between two outlines of a part that is cut: a faster rate is invisible, at any pace.
const OUTLINE_PERIOD: Duration = Duration::from_millis(250);
/// The same for a turned part, of which every slice is a marker.
const SLICED_PERIOD: Duration = Duration::from_secs(1);
/// Messages of markers that a late viewer still gets, one marker in each.
const MARKER_DEPTH: u32 = 256;
/// Number of changed markers after which all markers are published again: frequent changes would push the others out of the
/// queue.
const TOLD_AGAIN: u32 = MARKER_DEPTH / 2;

const PUBLISH_TF: &str = "publish_tf";
const EXTENDED_LIMITS: &str = "urdf_extended_limits";
const STOCK: Rgba = [0.72, 0.74, 0.78, 1.0];
const GRIT: Rgba = [0.62, 0.45, 0.30, 0.45];
const LETTERS: f64 = 0.012;

/// Publishers for viewers.
#[derive(Debug)]
pub(super) struct SceneOutlet {
    node: Node,
    inlet: CycleInlet,
    machine: MachineDescription,
    tree: Tree,
    urdf_version: UrdfVersion,
    period_ticks: u64,
    description: Publisher<Text>,
    published_description: String,
    transforms: Option<Telemetry<TFMessage>>,
    states: Telemetry<DynamicJointState>,
    /// Process values of the states; none for a rigid contact.
    process: Option<ProcessMonitor>,
    wheel_radius_mm: f64,
    /// Station and width of the lobes, in the order of the machine (mm).
    widths_mm: Vec<(String, f64)>,
    _fixed: Option<Publisher<TFMessage>>,
    markers: Telemetry<MarkerArray>,
    outline: Telemetry<PartLobe>,
    /// Markers by namespace and number, and the number of messages since all were published.
    drawn: BTreeMap<(String, i32), Marker>,
    since: u32,
    /// When an outline was asked for last, and whether it is still under way.
    asked: Instant,
    is_asked: bool,
    /// Lobe that was cut since its outline was asked for.
    cut_since: Option<usize>,
    /// Lobe that was cut and is still in front of the wheel.
    in_work: Option<usize>,
    /// Lobes that were cut, and that the wheel has left.
    left: BTreeSet<usize>,
}

/// The parameters that it goes by.
pub(super) fn parameters() -> [Parameter; 3] {
    let publish_tf = Parameter::bool(PUBLISH_TF, true)
        .describe("publishes /tf and /tf_static; false: leaves it to robot_state_publisher")
        .read_only();
    let extended_limits = Parameter::bool(EXTENDED_LIMITS, false)
        .describe(
            "robot_description is URDF 1.2 with limits of acceleration and jerk, which ROS 2 Lyrical reads; \
             false: URDF 1.0, which Jazzy and Kilted read too",
        )
        .read_only();
    [scene::parameter(), publish_tf, extended_limits]
}

impl SceneOutlet {
    pub(super) fn new(
        node: &Node,
        machine: &MachineDescription,
        lasting: &PersistentState,
        inlet: CycleInlet,
        drops: &DropCounter,
    ) -> Result<Self, NodeError> {
        let wheel_radius_mm = lasting.wheel_radius_mm;
        let tree = Tree::new(machine, wheel_radius_mm, scene::frames_of(node, machine)?);
        let publishes_tf = node.parameters().bool(PUBLISH_TF);
        let transforms = || node.telemetry("/tf", &Qos::default_topic().keep_last(100), drops);
        let fixed = || node.publisher("/tf_static", &Qos::latched(1));
        let (transforms, fixed) = (publishes_tf.then(transforms).transpose()?, publishes_tf.then(fixed).transpose()?);
        if let Some(fixed) = &fixed {
            fixed.publish(&TFMessage { transforms: tree.fixed(&node.now()) })?;
        }
        let mut outlet = Self {
            node: node.clone(),
            inlet,
            urdf_version: UrdfVersion::with_extended_limits(node.parameters().bool(EXTENDED_LIMITS)),
            period_ticks: (TRANSFORM_PERIOD_NS / u64::from(machine.cycle_time_ns).max(1)).max(1),
            description: node.publisher("robot_description", &Qos::latched(1))?,
            published_description: String::new(),
            transforms,
            states: node.telemetry("dynamic_joint_states", &Qos::default_topic().keep_last(100), drops)?,
            process: ProcessMonitor::new(machine),
            wheel_radius_mm,
            widths_mm: Vec::new(),
            _fixed: fixed,
            markers: node.telemetry("machine/markers", &Qos::latched(MARKER_DEPTH), drops)?,
            outline: node.telemetry("machine/outline", &Qos::latched(1), drops)?,
            drawn: BTreeMap::new(),
            since: 0,
            asked: Instant::now(),
            is_asked: false,
            cut_since: None,
            in_work: None,
            left: BTreeSet::new(),
            machine: machine.clone(),
            tree,
        };
        outlet.mount(lasting)?;
        Ok(outlet)
    }

    /// Header of what is measured on the part.
    pub(super) fn part_header(&self, stamp: Time) -> Header {
        self.tree.frames.part_header(stamp)
    }

    /// Frame of reported axis positions.
    pub(super) fn base_frame(&self) -> &str {
        &self.tree.frames.base
    }

    /// The wheel of this state is mounted. A wheel that the machine does not have is not shown.
    pub(super) fn mount(&mut self, lasting: &PersistentState) -> Result<(), RosError> {
        let wheel_radius_mm = lasting.wheel_radius_mm;
        self.wheel_radius_mm = wheel_radius_mm;
        if lasting.mounted_wheel() != self.machine.mounted_wheel()
            && self.machine.mount_wheel(lasting.mounted_wheel()).is_ok()
            && let Some(process) = &mut self.process
        {
            process.mount(&self.machine.wheel);
        }
        let tree = Tree::new(&self.machine, wheel_radius_mm, self.tree.frames.clone());
        let urdf = tree.urdf(self.urdf_version);
        if urdf == self.published_description {
            return Ok(());
        }
        (self.tree, self.published_description) = (tree, urdf);
        self.description.publish(&Text { data: self.published_description.clone() })?;
        if self.machine.is_lathe() {
            return Ok(());
        }
        let place = MarkerPose { frame: &self.tree.frames.wheel, ns: "wheel", id: 0 };
        let (radius, width) = (m_from_mm(wheel_radius_mm), m_from_mm(self.machine.wheel.width_mm));
        let wheel = scene::wheel(place, radius, width, GRIT);
        self.draw(wheel)
    }

    /// Publishes the transforms and states of a tick, and now and then the part. `rest_ticks` is the period of a machine at rest.
    pub(super) fn tick(&mut self, report: &TickReport, stamp: &Time, rest_ticks: Option<u64>) -> Result<(), RosError> {
        let lobe_width_mm = report.lobe.and_then(|lobe| self.engaged_width_mm(lobe));
        let engaged =
            lobe_width_mm.map(|lobe_width_mm| Engaged { wheel_radius_mm: self.wheel_radius_mm, lobe_width_mm });
        if let Some(process) = &mut self.process {
            process.add(report, engaged);
        }
        let cuts = report.removal.area_mm2 > 0.0 || report.turned.volume_mm3 > 0.0;
        let period = if self.machine.is_lathe() { SLICED_PERIOD } else { OUTLINE_PERIOD };
        let lobe = report.lobe.unwrap_or(0);
        if cuts {
            (self.cut_since, self.in_work) = (Some(lobe), Some(lobe));
            self.left.remove(&lobe);
        }
        if let Some(cut) = self.in_work.filter(|cut| !self.machine.is_lathe() && report.lobe != Some(*cut)) {
            self.ask(cut);
            if self.is_asked {
                (self.cut_since, self.in_work) = (None, None);
                self.left.insert(cut);
            }
        } else if let Some(cut) = self.cut_since.filter(|_| !self.is_asked && self.asked.elapsed() >= period) {
            self.cut_since = None;
            self.ask(cut);
        }
        let period_ticks = rest_ticks.map_or(self.period_ticks, |rest_ticks| rest_ticks.max(self.period_ticks));
        if !report.tick.is_multiple_of(period_ticks) {
            return Ok(());
        }
        let position = |joint: &str| match Axis::from_joint(joint) {
            Some(axis) => si_from_counts(self.machine.axis(axis).scale, report.axes[axis.index()].counts),
            // The wheel's angle means nothing.
            None => 0.0,
        };
        if let Some(transforms) = &self.transforms {
            transforms.publish(&TFMessage { transforms: self.tree.moved(stamp, position) })?;
        }
        let process = self.process.as_mut().map(ProcessMonitor::take);
        self.states.publish(&self.state(report, process, stamp, position))
    }

    /// State without a field in joint states: following errors of the axes, process values of the wheel.
    fn state(
        &self,
        report: &TickReport,
        process: Option<ProcessValues>,
        stamp: &Time,
        position: impl Fn(&str) -> f64,
    ) -> DynamicJointState {
        let of_axis = |axis: Axis| {
            let own = &report.axes[axis.index()];
            let si = |value: f64| si_from_core(axis, value);
            let values = vec![position(axis.joint()), si(own.velocity), own.effort, si(own.following_error)];
            let names = ["position", "velocity", "effort", "following_error"];
            InterfaceValue { interface_names: names.map(str::to_owned).into(), values }
        };
        let mut state = DynamicJointState {
            header: Header { stamp: stamp.clone(), frame_id: self.base_frame().to_owned() },
            joint_names: Axis::ALL.map(|axis| axis.joint().to_owned()).into(),
            interface_values: Axis::ALL.map(of_axis).into(),
        };
        if let Some(process) = process {
            state.joint_names.push(WHEEL_JOINT.to_owned());
            state.interface_values.push(wheel_values(report.wheel_rad_s, process));
        }
        state
    }

    /// Width that the wheel grinds at a lobe: that of all sections at its station where the wheel covers them, else its own (mm).
    fn engaged_width_mm(&self, lobe: usize) -> Option<f64> {
        let (station, width_mm) = self.widths_mm.get(lobe)?;
        let sections = self.widths_mm.iter().filter(|(other, _)| other == station);
        let whole_mm: f64 = sections.map(|(_, width_mm)| width_mm).sum();
        Some(if whole_mm <= self.machine.wheel.width_mm { whole_mm } else { *width_mm })
    }

    /// Station and width of a lobe that was loaded.
    pub(super) fn set_width(&mut self, lobe: usize, station: &str, width_mm: f64) {
        if self.widths_mm.len() <= lobe {
            self.widths_mm.resize(lobe + 1, (String::new(), 0.0));
        }
        self.widths_mm[lobe] = (station.to_owned(), width_mm);
        self.left.remove(&lobe);
    }

    /// Asks the cyclic thread what a lobe, or the part of a lathe, looks like.
    pub(super) fn ask(&mut self, lobe: usize) {
        self.asked = Instant::now();
        self.is_asked = self.inlet.send(Inbound::Outline(PartOutline::for_lobe(lobe, self.machine.is_lathe())));
    }

    /// The part was taken out.
    pub(super) fn clear(&mut self) -> Result<(), RosError> {
        self.widths_mm.clear();
        (self.in_work, self.left) = (None, BTreeSet::new());
        let is_part = |ns: &str| matches!(ns, "stock" | "lobe");
        let part: Vec<(String, i32)> = self.drawn.keys().filter(|(ns, _)| is_part(ns)).cloned().collect();
        let frame = self.tree.frames.part.clone();
        part.iter().try_for_each(|(ns, id)| self.draw(scene::gone(MarkerPose { frame: &frame, ns, id: *id })))
    }

    /// The part as the cyclic thread saw it; `name` is that of the lobe.
    pub(super) fn show(
        &mut self,
        outline: &PartOutline,
        name: Option<&String>,
        clock: TickClock,
    ) -> Result<(), RosError> {
        self.is_asked = false;
        let sections = outline.sections();
        // A part that was taken out meanwhile.
        let Some((middle, radii)) = sections.get(sections.len() / 2) else { return Ok(()) };
        let station = self.machine.stations.get(outline.station).filter(|_| !self.machine.is_lathe());
        self.outline.publish(&PartLobe {
            header: self.part_header(clock.stamp(outline.tick)),
            tick: outline.tick,
            name: name.cloned().unwrap_or_default(),
            station: station.map_or_else(String::new, |station| station.switch.clone()),
            width: m_from_mm(outline.width_mm),
            finished: self.left.contains(&outline.lobe),
            key_way: outline.key_way_rad,
            radius: radii.clone(),
            centre: section_centre_values(outline.centre, outline.offset_mm),
            ..PartLobe::default()
        })?;
        let half = 0.5 * m_from_mm(outline.width_mm);
        let slices: Vec<(f64, &[f64])> = match sections.len() {
            1 => vec![(middle - half, radii), (middle + half, radii)],
            _ => sections.iter().map(|(z, radii)| (*z, radii.as_slice())).collect(),
        };
        let [part, table] = [&self.tree.frames.part, &self.tree.frames.table].map(Clone::clone);
        let id = |index: usize| i32::try_from(index).unwrap_or(i32::MAX);
        // Slice by slice: a part of one piece would be larger than a message should be.
        for (slice, sides) in slices.windows(2).enumerate() {
            let place = MarkerPose { frame: &part, ns: "stock", id: id(outline.lobe + slice) };
            self.draw(scene::about(scene::solid(place, sides, STOCK), &centre_values(outline.centre)))?;
        }
        let place = MarkerPose { frame: &table, ns: "lobe", id: id(outline.lobe) };
        match name.filter(|_| !self.drawn.contains_key(&(place.ns.to_owned(), place.id))) {
            Some(name) => {
                // The table does not turn: the name of a pin stands above all of its swing.
                let throw = outline.centre.map_or(0.0, |centre| m_from_mm(centre.distance_mm));
                let above = throw + radii.iter().copied().fold(0.0, f64::max) + 2.0 * LETTERS;
                self.draw(scene::text(place, [0.0, above, *middle], LETTERS, name.clone()))
            }
            None => Ok(()),
        }
    }

    fn draw(&mut self, marker: Marker) -> Result<(), RosError> {
        let key = (marker.ns.clone(), marker.id);
        match marker.action {
            Marker::DELETE => drop(self.drawn.remove(&key)),
            _ => drop(self.drawn.insert(key, marker.clone())),
        }
        self.markers.publish(&MarkerArray { markers: vec![marker] })?;
        self.since += 1;
        if self.since >= TOLD_AGAIN {
            self.since = 0;
            let mut drawn = self.drawn.values();
            drawn.try_for_each(|marker| self.markers.publish(&MarkerArray { markers: vec![marker.clone()] }))?;
        }
        Ok(())
    }

    /// Says what could not be published.
    pub(super) fn log_failure(&self, outcome: Result<(), RosError>) {
        if let Err(error) = outcome {
            self.node.logger().warn(&format!("the markers for viewers cannot be published: {error}"));
        }
    }
}

/// Interfaces of the wheel spindle: speed (rad/s), normal force (N) and, with process data, power (W) and burn index (1).
fn wheel_values(wheel_rad_s: f64, process: ProcessValues) -> InterfaceValue {
    let mut named = vec![("velocity", wheel_rad_s), ("normal_force", process.normal_force_n)];
    if let Some(heat) = process.heat {
        named.extend([("power", heat.power_w), ("burn_index", heat.burn_index)]);
    }
    let (names, values): (Vec<&str>, Vec<f64>) = named.into_iter().unzip();
    InterfaceValue { interface_names: names.into_iter().map(str::to_owned).collect(), values }
}
