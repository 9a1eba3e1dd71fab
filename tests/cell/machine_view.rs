// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine as viewers see it: the URDF puts wheel and part where ARCHITECTURE.md, section 2, says that they are; the cell publishes it
//! with transforms, markers and outlines that fit together.

use crate::cell;
use crate::support;

use crate::viewer_files::{Published, PublishedTopic, path_value, rviz_faults};
use camwright::machine::description::{Axis, MachineDescription};
use camwright::math::units::TURN_RAD;
use camwright_files::convert::time::ns_from_time;
use camwright_files::convert::{m_from_mm, mm_from_m, si_from_core};
use camwright_files::{locate, machine_file};
use camwright_msgs::camwright_msgs::msg::{LobeForm, PartLobe};
use camwright_msgs::camwright_msgs::srv::{LoadBar, LoadBarRequest};
use camwright_msgs::geometry_msgs::msg::TransformStamped;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_msgs::tf2_msgs::msg::TFMessage;
use camwright_msgs::visualization_msgs::msg::{Marker, MarkerArray};
use camwright_ros::{GoalStatus, ParameterValue, Qos, Subscription};
use camwright_scene::{Frames, Tree, UrdfVersion};
use cell::{Cell, PATIENCE};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Condvar, Mutex};
use urdf_rs::{Geometry, JointType, Robot};

/// A frame in another: rotation by rows, and where its origin is.
#[derive(Debug, Clone, Copy)]
struct Frame([[f64; 3]; 3], [f64; 3]);

impl Frame {
    const ITSELF: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);

    /// Rotation by the formula of Rodrigues.
    fn about([x, y, z]: [f64; 3], angle: f64) -> Self {
        let (s, c) = angle.sin_cos();
        let v = 1.0 - c;
        let rows = [
            [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
            [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
            [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
        ];
        Self(rows, [0.0; 3])
    }

    fn at(place: [f64; 3]) -> Self {
        Self(Self::ITSELF.0, place)
    }

    fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }

    fn point(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(point);
        [0, 1, 2].map(|i| turned[i] + self.1[i])
    }

    fn then(&self, next: &Self) -> Self {
        let column = |i: usize| self.turned([next.0[0][i], next.0[1][i], next.0[2][i]]);
        let [a, b, c] = [column(0), column(1), column(2)];
        Self([0, 1, 2].map(|row| [a[row], b[row], c[row]]), self.point(next.1))
    }

    fn back(&self) -> Self {
        let rows = [0, 1, 2].map(|i| [self.0[0][i], self.0[1][i], self.0[2][i]]);
        let there = Self(rows, [0.0; 3]).turned(self.1);
        Self(rows, there.map(|value| -value))
    }

    fn from_transform(transform: &TransformStamped) -> Self {
        let (q, t) = (&transform.transform.rotation, &transform.transform.translation);
        let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
        assert!((length - 1.0).abs() < 1e-12, "a rotation has length 1: {q:?}");
        let sine = (q.x * q.x + q.y * q.y + q.z * q.z).sqrt();
        let axis = if sine > 0.0 { [q.x / sine, q.y / sine, q.z / sine] } else { [0.0, 0.0, 1.0] };
        Self(Self::about(axis, 2.0 * sine.atan2(q.w)).0, [t.x, t.y, t.z])
    }

    fn difference(&self, other: &Self) -> f64 {
        let rows = self.0.iter().flatten().zip(other.0.iter().flatten());
        rows.chain(self.1.iter().zip(&other.1)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

/// Pose of a link in the root, according to another library that read the URDF.
fn stands(robot: &Robot, link: &str, position: &dyn Fn(&str) -> f64) -> Frame {
    let Some(joint) = robot.joints.iter().find(|joint| joint.child.link == link) else { return Frame::ITSELF };
    let [roll, pitch, yaw] = joint.origin.rpy.0;
    let origin = Frame::at(joint.origin.xyz.0)
        .then(&Frame::about([0.0, 0.0, 1.0], yaw))
        .then(&Frame::about([0.0, 1.0, 0.0], pitch))
        .then(&Frame::about([1.0, 0.0, 0.0], roll));
    let (axis, at) = (joint.axis.xyz.0, position(&joint.name));
    let moved = match joint.joint_type {
        JointType::Fixed => Frame::ITSELF,
        JointType::Prismatic => Frame::at(axis.map(|value| value * at)),
        JointType::Continuous => Frame::about(axis, at),
        ref other => panic!("no joint of a machine is {other:?}"),
    };
    stands(robot, &joint.parent.link, position).then(&origin).then(&moved)
}

fn machine(name: &str, overrides: &[&str]) -> MachineDescription {
    let located = locate::locate("machines", name, "yaml", None).expect("a machine of ours");
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    machine_file::parse(&located.path, &located.text, &overrides).expect("it is read").description
}

fn robot(machine: &MachineDescription, wheel_radius_mm: f64, prefix: &str) -> Robot {
    let urdf = Tree::new(machine, wheel_radius_mm, Frames::new(prefix, machine)).urdf(UrdfVersion::V1_0);
    urdf_rs::read_from_string(&urdf).unwrap_or_else(|error| panic!("{}: {error}\n{urdf}", machine.name))
}

/// Every machine that is shipped, turning either way.
fn machines() -> Vec<MachineDescription> {
    let names = locate::list("machines");
    assert!(names.len() >= 4, "{names:?}");
    names.iter().flat_map(|name| [1, -1].map(|sense| machine(name, &[&format!("rotation_sense={sense}")]))).collect()
}

#[test]
fn the_wheel_and_the_part_stand_where_the_axes_say() {
    for machine in machines() {
        let wheel = &machine.wheel;
        for wheel_radius_mm in [wheel.new_radius_mm, wheel.min_radius_mm] {
            let robot = robot(&machine, wheel_radius_mm, "");
            let frames = Frames::new("", &machine);
            for (c, x, z) in [(0.0, 0.02, 0.1), (0.7, 0.0173, -0.01), (-400.3, 0.15, 0.22), (2.0 * TURN_RAD, 0.03, 0.0)]
            {
                let position = |joint: &str| match joint {
                    "c_axis" => c,
                    "x_axis" => x,
                    "z_axis" => z,
                    // The wheel turns and its place does not.
                    "wheel_spindle" => 123.4,
                    fixed => panic!("{fixed} is asked for a position"),
                };
                let position = |joint: &str| if joint == "world_to_machine_base" { 0.0 } else { position(joint) };
                let [part, wheel, base] =
                    [&frames.part, &frames.wheel, &frames.base].map(|link| stands(&robot, link, &position));
                let seen = part.back().then(&wheel).1;
                let (distance, azimuth) = (seen[0].hypot(seen[1]), seen[1].atan2(seen[0]));
                let wheel_line = f64::from(machine.rotation_sense) * c;
                let (from_axis, at_azimuth) = match &machine.insert {
                    None => (x + m_from_mm(wheel_radius_mm), wheel_line),
                    Some(insert) => {
                        let height = m_from_mm(insert.height_mm);
                        (x.hypot(height), wheel_line + height.atan2(x))
                    }
                };
                let what = format!("{} sense {} at C {c}, X {x}, Z {z}", machine.name, machine.rotation_sense);
                assert!((distance - from_axis).abs() < 1e-9, "{what}: {distance} m from the axis, not {from_axis}");
                let off = (azimuth - at_azimuth + 0.5 * TURN_RAD).rem_euclid(TURN_RAD) - 0.5 * TURN_RAD;
                assert!(off.abs() < 1e-9, "{what}: at azimuth {azimuth}, not {at_azimuth}");
                assert!((seen[2] - z).abs() < 1e-9, "{what}: at z {} of the part", seen[2]);
                // Y of the machine is up, X goes from the part to the wheel.
                assert!((base.turned([0.0, 1.0, 0.0])[2] - 1.0).abs() < 1e-9, "{what}: {base:?}");
                let in_base = base.back().then(&wheel).1;
                assert!(in_base[0] > 0.0 && in_base[2].abs() < 1e-9, "{what}: {in_base:?}");
            }
        }
    }
}

/// Seen from +Z a part with sense +1 turns clockwise when C grows: what lies on its X goes towards −Y.
#[test]
fn a_positive_c_turns_the_part_as_the_machine_file_says() {
    for machine in machines() {
        let robot = robot(&machine, machine.wheel.new_radius_mm, "");
        let part = |c: f64| stands(&robot, "part", &|joint| if joint == "c_axis" { c } else { 0.0 });
        let base = stands(&robot, "machine_base", &|_| 0.0);
        let key_way = base.back().then(&part(0.1)).point([1.0, 0.0, 0.0]);
        let towards = f64::from(machine.rotation_sense) * key_way[1];
        assert!((towards + 0.1_f64.sin()).abs() < 1e-9, "{}: {key_way:?}", machine.name);
    }
}

#[test]
fn limits_and_sizes_are_those_of_the_machine_file() {
    for machine in machines() {
        let radius_mm = machine.wheel.new_radius_mm;
        let robot = robot(&machine, radius_mm, "cell1_");
        let joint =
            |name: &str| robot.joints.iter().find(|joint| joint.name == name).expect("a joint of every machine");
        for axis in Axis::ALL {
            let (own, joint) = (machine.axis(axis), joint(axis.joint()));
            let unit = |value: f64| if axis == Axis::C { value } else { m_from_mm(value) };
            assert!((joint.limit.velocity - unit(own.limits.velocity)).abs() < 1e-9, "{}", joint.name);
            assert!(joint.limit.effort > 0.0 && joint.limit.effort.is_finite());
            match own.soft_limits {
                Some((low, high)) => {
                    assert!(matches!(joint.joint_type, JointType::Prismatic), "{}", joint.name);
                    assert!((joint.limit.lower - unit(low)).abs() + (joint.limit.upper - unit(high)).abs() < 1e-9);
                }
                None => assert!(matches!(joint.joint_type, JointType::Continuous), "{}", joint.name),
            }
        }
        let wheel = joint("wheel_spindle");
        assert!(matches!(wheel.joint_type, JointType::Continuous) && wheel.limit.velocity > 1.0);
        let link = robot.links.iter().find(|link| link.name == wheel.child.link).expect("its link");
        let Geometry::Cylinder { radius, .. } = link.visual[0].geometry else { panic!("a wheel is round") };
        assert!((radius - m_from_mm(radius_mm)).abs() < 1e-9, "{radius}");
        let mut hanging = BTreeSet::from(["world".to_owned()]);
        for link in &robot.links[1..] {
            assert!(link.name.starts_with("cell1_"), "{}", link.name);
            let above = robot.joints.iter().find(|joint| joint.child.link == link.name).expect("a joint above it");
            assert!(hanging.contains(&above.parent.link), "{} hangs in the air", link.name);
            hanging.insert(link.name.clone());
            if above.parent.link == "world" {
                continue;
            }
            let i = &link.inertial;
            assert!(i.mass.value > 0.0, "{} weighs nothing", link.name);
            let [a, b, c] = [i.inertia.ixx, i.inertia.iyy, i.inertia.izz];
            assert!(a > 0.0 && b > 0.0 && c > 0.0, "{}: {a} {b} {c}", link.name);
            // No body has a moment larger than the sum of the others.
            assert!(a <= b + c + 1e-9 && b <= a + c + 1e-9 && c <= a + b + 1e-9, "{}: {a} {b} {c}", link.name);
        }
    }
}

/// The files that the package installs are what the program makes.
#[test]
fn the_shipped_descriptions_are_up_to_date() {
    for name in locate::list("machines") {
        let machine = machine(&name, &[]);
        let tree = Tree::new(&machine, machine.wheel.new_radius_mm, Frames::new("", &machine));
        let made = tree.urdf(UrdfVersion::V1_0);
        let path = support::repository().join(format!("nodes/urdf/{name}.urdf"));
        let shipped = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(shipped == made, "{} is old: camwright urdf {name} > {}", path.display(), path.display());
    }
}

/// Value of an attribute in a line of XML.
fn attribute(line: &str, name: &str) -> Option<f64> {
    let (_, value) = line.split_once(&format!(" {name}=\""))?;
    value.split_once('"')?.0.parse().ok()
}

/// URDF 1.2 adds the version and the limits of acceleration and jerk, and nothing else.
#[test]
fn urdf_1_2_has_the_limits_of_the_machine() {
    for machine in machines() {
        let tree = Tree::new(&machine, machine.wheel.new_radius_mm, Frames::new("", &machine));
        let [plain, extended] = [UrdfVersion::V1_0, UrdfVersion::V1_2].map(|version| tree.urdf(version));
        urdf_rs::read_from_string(&extended).unwrap_or_else(|error| panic!("{}: {error}\n{extended}", machine.name));
        assert_eq!(plain.lines().count(), extended.lines().count(), "{}", machine.name);
        let mut joint = "";
        let mut compared = 0;
        for (plain, extended) in plain.lines().zip(extended.lines()) {
            if let Some((_, rest)) = extended.split_once("<joint name=\"") {
                joint = rest.split('"').next().unwrap_or_default();
            }
            if extended.contains("<robot ") {
                assert_eq!(extended, plain.replace('>', " version=\"1.2\">"));
                continue;
            }
            let Some(acceleration) = attribute(extended, "acceleration") else {
                assert_eq!(plain, extended);
                continue;
            };
            assert!(extended.starts_with(plain.trim_end_matches("/>")), "{plain}\n{extended}");
            let jerk = attribute(extended, "jerk");
            if let Some(axis) = Axis::from_joint(joint) {
                let limits = &machine.axis(axis).limits;
                let expected = [limits.acceleration, limits.jerk].map(|value| si_from_core(axis, value));
                assert!((acceleration - expected[0]).abs() <= 1e-9 * expected[0], "{joint}: {acceleration}");
                assert!(jerk.is_some_and(|jerk| (jerk - expected[1]).abs() <= 1e-9 * expected[1]), "{joint}: {jerk:?}");
            } else {
                assert!(acceleration > 0.0 && jerk.is_none(), "{joint}: {acceleration}, {jerk:?}");
            }
            compared += 1;
        }
        assert_eq!(compared, 4, "three axes and the wheel of {}", machine.name);
    }
}

/// Messages received by a viewer.
#[derive(Debug, Default)]
struct ReceivedMessages {
    descriptions: Vec<String>,
    fixed: Vec<TransformStamped>,
    /// Transforms by stamp (ns), and joint states.
    moved: BTreeMap<i64, Vec<TransformStamped>>,
    joints: BTreeMap<i64, JointState>,
    markers: Vec<Marker>,
    forms: Vec<LobeForm>,
    outlines: Vec<PartLobe>,
}

struct Viewer {
    received: Arc<(Mutex<ReceivedMessages>, Condvar)>,
    _subscriptions: Vec<Subscription>,
}

impl Viewer {
    fn new(cell: &Cell) -> Self {
        let received: Arc<(Mutex<ReceivedMessages>, Condvar)> = Arc::default();
        let node = &cell.client.node;
        let latched = Qos::latched(64);
        macro_rules! hears {
            ($type:ty, $topic:literal, $qos:expr, $received:ident, $message:ident => $take:expr) => {{
                let to = Arc::clone(&received);
                let take = move |$message: $type, _: &_| {
                    let mut $received = to.0.lock().expect("not poisoned");
                    $take;
                    to.1.notify_all();
                };
                node.subscribe::<$type>($topic, $qos, take).expect("a subscription")
            }};
        }
        let burst = Qos::default_topic().keep_last(2000);
        let subscriptions = vec![
            hears!(Text, "robot_description", &Qos::latched(1), received, m => received.descriptions.push(m.data)),
            hears!(TFMessage, "/tf_static", &Qos::latched(1), received, m => received.fixed.extend(m.transforms)),
            hears!(TFMessage, "/tf", &burst, received, m => {
                received.moved.insert(ns_from_time(&m.transforms[0].header.stamp), m.transforms)
            }),
            hears!(JointState, "joint_states", &burst, received, m => received.joints.insert(ns_from_time(&m.header.stamp), m)),
            hears!(MarkerArray, "machine/markers", &latched, received, m => received.markers.extend(m.markers)),
            hears!(MarkerArray, "job_planner/markers", &latched, received, m => received.markers.extend(m.markers)),
            hears!(LobeForm, "job_planner/lobe_forms", &latched, received, m => received.forms.push(m)),
            hears!(PartLobe, "machine/outline", &latched, received, m => received.outlines.push(m)),
        ];
        Self { received, _subscriptions: subscriptions }
    }

    fn wait(&self, what: &str, there: impl Fn(&ReceivedMessages) -> bool) {
        let (received, changed) = &*self.received;
        let waiting =
            changed.wait_timeout_while(received.lock().expect("not poisoned"), PATIENCE, |received| !there(received));
        assert!(!waiting.expect("not poisoned").1.timed_out(), "{what} was not heard of");
    }
}

#[test]
fn a_running_cell_is_seen() {
    let cell = Cell::start_with(&["wheel.new_radius_mm=55.0"], |args| {
        args.with_parameter(None, "frame_prefix", ParameterValue::String("left_".into())).with_parameter(
            None,
            "urdf_extended_limits",
            ParameterValue::Bool(true),
        )
    });
    let viewer = Viewer::new(&cell);
    let short = ["wheel_radius_mm=55.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];
    let (goal, _) = cell.client.send("eccentric", &short);
    assert!(goal.accepted());
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    viewer
        .wait("the form of the ground lobe", |received| received.forms.iter().any(|form| !form.form_error.is_empty()));
    viewer.wait("the finished outline", |received| received.outlines.iter().any(|part| part.tick >= result.last_tick));
    // Who comes late hears what is latched.
    let late = Viewer::new(&cell);
    late.wait("latched topics", |late| {
        let [ns, form] = [late.markers.iter().any(|m| m.ns == "stock"), !late.forms.is_empty()];
        ns && form
            && !late.descriptions.is_empty()
            && !late.fixed.is_empty()
            && late.markers.iter().any(|m| m.ns == "wheel")
    });
    let received = viewer.received.0.lock().expect("not poisoned");

    let robot = urdf_rs::read_from_string(&received.descriptions[0]).expect("a URDF");
    assert!(received.descriptions[0].contains("version=\"1.2\""), "{}", received.descriptions[0]);
    assert_eq!(received.fixed.len(), 1);
    assert_eq!(
        (received.fixed[0].header.frame_id.as_str(), received.fixed[0].child_frame_id.as_str()),
        ("world", "left_machine_base")
    );
    let moving: BTreeSet<&str> =
        robot.joints.iter().filter(|j| !matches!(j.joint_type, JointType::Fixed)).map(|j| j.name.as_str()).collect();
    let mut compared = 0;
    for (stamp, transforms) in &received.moved {
        let Some(joints) = received.joints.get(stamp) else { continue };
        assert_eq!(
            joints.name.iter().map(String::as_str).collect::<BTreeSet<_>>(),
            moving,
            "every joint that moves has a state"
        );
        assert_eq!(joints.header.frame_id, "left_machine_base");
        assert_eq!(joints.name[..2], ["c_axis", "x_axis"], "the order that the Foxglove layout names by index");
        let position = |name: &str| joints.name.iter().position(|j| j == name).map_or(0.0, |at| joints.position[at]);
        let by_name: BTreeMap<&str, &TransformStamped> =
            transforms.iter().chain(&received.fixed).map(|t| (t.child_frame_id.as_str(), t)).collect();
        for link in &robot.links[1..] {
            let mut by_tf = Frame::ITSELF;
            let mut at = link.name.as_str();
            while at != "world" {
                let step = by_name.get(at).unwrap_or_else(|| panic!("nobody says where {at} is"));
                by_tf = Frame::from_transform(step).then(&by_tf);
                at = &step.header.frame_id;
            }
            let off = by_tf.difference(&stands(&robot, &link.name, &position));
            assert!(off < 1e-8, "{} is {off} off", link.name);
        }
        compared += 1;
    }
    assert!(compared > 100, "{compared} moments of {} s of machine time", result.duration);

    let links: BTreeSet<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    for marker in &received.markers {
        assert!(links.contains(marker.header.frame_id.as_str()), "{} {:?}", marker.ns, marker.header);
        assert!(marker.frame_locked && (marker.pose.orientation.w - 1.0).abs() < 1e-15, "{}", marker.ns);
        assert!(marker.points.iter().all(|p| p.x.is_finite() && p.y.is_finite() && p.z.is_finite()), "{}", marker.ns);
        assert!(marker.points.len() * 24 < 32_768, "{}: {} points", marker.ns, marker.points.len());
    }
    let last = |ns: &str| {
        received
            .markers
            .iter()
            .rev()
            .find(|m| m.ns == ns && m.action == Marker::ADD)
            .unwrap_or_else(|| panic!("no {ns}"))
    };
    let kinds = [
        ("stock", Marker::TRIANGLE_LIST),
        ("wheel", Marker::CYLINDER),
        ("design", Marker::LINE_STRIP),
        ("form_error", Marker::LINE_STRIP),
    ];
    for (ns, kind) in kinds {
        assert_eq!((last(ns).type_, last(ns).id), (kind, 0), "{ns}");
    }
    assert!((last("wheel").scale.x - 0.11).abs() < 1e-12, "{:?}", last("wheel").scale);

    // What is drawn is what was measured.
    let lobe = &result.lobes[0];
    let form = received.forms.iter().find(|form| !form.form_error.is_empty()).expect("waited for");
    let largest = form.form_error.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    assert!((largest - lobe.form_error_max).abs() < 1e-12, "{largest} m drawn, {} m measured", lobe.form_error_max);
    let farthest = |ns: &str| last(ns).points.iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
    let max = form.contour.iter().copied().fold(0.0, f64::max);
    assert!(
        (farthest("design") - max).abs() < 1e-6 && (farthest("stock") - max).abs() < 2e-5,
        "{} {max}",
        farthest("stock")
    );
    let place = form.table_position;
    assert!(
        last("stock").points.iter().all(|p| (p.z - place).abs() < 0.5 * form.width + 1e-9),
        "the lobe stands at its station"
    );
    let outline = received.outlines.last().expect("waited for");
    let (azimuths, scale) = (outline.radius.len(), form.contour.len() / 720);
    assert_eq!((azimuths, scale, outline.name.as_str()), (720, 1, "A"));
    let apart =
        outline.radius.iter().zip(&form.contour).map(|(is, shall)| mm_from_m((is - shall).abs())).fold(0.0, f64::max);
    assert!(apart < 0.01, "the outline lies {apart} mm off the design");
    let blank = received.outlines.first().expect("the blank");
    assert!(blank.tick < outline.tick && blank.radius[0] > outline.radius[0] + 1e-4, "stock was taken");
    assert!(received.outlines.len() > 2, "the lobe was seen while it was cut");
    drop(received);
    every_topic_of_a_viewer_is_there(&cell);
    cell.stop();
}

/// A lathe without a job: its bar is drawn as it is clamped, and transforms are left to another client.
#[test]
fn a_bar_in_a_lathe_is_seen_and_transforms_can_be_left_to_others() {
    let text = |text: &str| ParameterValue::String(text.into());
    let cell = Cell::start_with(&[], |args| {
        let args = args.with_parameter(Some("machine_sim"), "machine", text("lathe"));
        args.with_parameter(Some("machine_sim"), "publish_tf", ParameterValue::Bool(false))
    });
    let viewer = Viewer::new(&cell);
    let bar = LoadBarRequest {
        name: "bar".into(),
        radius: 0.0232,
        azimuths: 360,
        columns: 201,
        from_z: 0.001,
        to_z: 0.025,
        part_zero: 0.002,
    };
    let answer = cell.client.call::<LoadBar>("machine/load_bar", &bar);
    assert!(answer.success, "{}", answer.message);
    viewer.wait("the bar", |received| received.markers.iter().filter(|marker| marker.ns == "stock").count() == 12);
    viewer.wait("its outline", |received| !received.outlines.is_empty());
    viewer.wait("the description", |received| !received.descriptions.is_empty());
    let received = viewer.received.0.lock().expect("not poisoned");
    let robot = urdf_rs::read_from_string(&received.descriptions[0]).expect("a URDF");
    assert!(robot.links.iter().any(|link| link.name == "insert"), "{:?}", robot.links);
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for (slice, stock) in received.markers.iter().enumerate() {
        assert_eq!(
            (stock.header.frame_id.as_str(), stock.ns.as_str(), stock.id),
            ("part", "stock", i32::try_from(slice).expect("a few"))
        );
        assert!(stock.points.len() * 24 < 32_768, "{} points", stock.points.len());
    }
    for point in received.markers.iter().flat_map(|stock| &stock.points) {
        let radius = point.x.hypot(point.y);
        assert!(radius < 1e-12 || (radius - bar.radius).abs() < 1e-9, "{point:?}");
        (low, high) = (low.min(point.z), high.max(point.z));
    }
    // z of the part frame is z_axis as it reads when the insert stands there.
    assert!((low + 0.001).abs() < 1e-12 && (high - 0.023).abs() < 1e-12, "{low} to {high}");
    assert_eq!(received.outlines[0].radius.len(), 90);
    assert!(received.fixed.is_empty() && received.moved.is_empty(), "nobody makes transforms");
    let topics = cell.client.node.discovered_topics();
    assert!(topics.iter().filter(|topic| topic.name.starts_with("/tf")).all(|topic| topic.publishers.is_empty()));
    drop(received);
    cell.stop();
}

/// The cell publishes every topic and field that the display files of `RViz` and Foxglove show.
fn every_topic_of_a_viewer_is_there(cell: &Cell) {
    let topics = cell.client.node.discovered_topics().into_iter().filter(|topic| !topic.publishers.is_empty());
    let published: Published =
        topics.map(|topic| (topic.name, PublishedTopic { type_name: topic.type_name, is_latched: None })).collect();
    let read = |path: &str| std::fs::read_to_string(support::repository().join(path)).expect("a file of the package");
    let rviz = read("nodes/rviz/cell.rviz");
    let namespaces = ["lobe", "stock", "wheel", "design", "form_error", "form_error_text"].map(str::to_owned);
    assert_eq!(rviz_faults(&rviz, &published, &namespaces.into()), [""; 0]);
    let layout: serde_json::Value = serde_json::from_str(&read("nodes/foxglove/cell.json")).expect("JSON");
    for panel in layout["configById"].as_object().expect("panels").values() {
        for series in panel["paths"].as_array().into_iter().flatten() {
            let path = series["value"].as_str().expect("a path");
            assert!(
                path_value(path, &published).is_ok_and(|value| value.is_number),
                "{:?}",
                path_value(path, &published)
            );
        }
        for key in ["path", "topicPath", "topicToRender"] {
            if let Some(path) = panel[key].as_str() {
                assert!(path_value(path, &published).is_ok(), "{:?}", path_value(path, &published));
            }
        }
    }
}
