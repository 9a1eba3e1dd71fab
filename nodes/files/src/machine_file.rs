// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Machine files: what is written, and the description it means.

use super::contact_file::ContactFile;
use super::drive_file::{SlideDriveFile, SpindleDriveFile};
use super::gauge_file::GaugeFile;
use super::hal_file::{HalConfig, HalFile};
use super::homing_file::{self, HomingFile};
use super::insert_file::InsertFile;
use super::loading_file::LoadingFile;
use super::names;
use super::probe_file::{GapDetectorFile, KeyWayProbeFile};
use super::process_file::ProcessFile;
use super::recorded_files::MACHINES;
use super::retract_file::AlarmRetractFile;
use super::schema;
use super::wheel_changer_file::{self, WheelChangerFile};
use super::wheel_file::{DresserFile, ExtentFile, RimFile, ThermalFile};
use super::workholding_file::WorkholdingFile;
use super::yaml::Document;
use super::{ConfigError, FileLocation};
use camwright::machine::description::{
    Axis, AxisDescription, AxisScale, InsertDescription, MachineDescription, MotionLimits, Station, WheelDescription,
};
use camwright::math::units::{mm_from_um, rad_from_deg, rad_s_from_rpm};
use schemars::JsonSchema;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// Newest version of the machine file's schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MachineFile {
    /// Kind and version of the file.
    #[schemars(extend("const" = "camwright/machine/1"))]
    #[serde(rename = "schema")]
    _schema: String,
    /// Name of the machine, also of its state file.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// Interpolation period.
    #[schemars(range(min = 100, max = 20000))]
    cycle_time_us: u32,
    /// D: a setpoint for tick k uses feedback up to tick k - D; also the maximum lead of setpoints.
    #[schemars(range(min = 8, max = 1000))]
    feedback_delay_ticks: u32,
    /// Servo steps of an interpolation period.
    #[schemars(range(min = 1, max = 32))]
    servo_steps_per_tick: u32,
    /// 1: positive C turns the part clockwise seen from +Z, -1: against it.
    #[schemars(extend("enum" = [1, -1]))]
    rotation_sense: i8,
    /// Headstock.
    c_axis: RotaryFile,
    /// Wheelhead, positive away from the part.
    x_axis: LinearFile,
    /// Table.
    z_axis: LinearFile,
    /// A lathe may have none.
    /// Stations of the table with their limit switches. A lathe needs none.
    #[schemars(length(max = 100))]
    #[serde(default)]
    stations: Vec<StationFile>,
    /// Length of a dog of a limit switch. Required with stations.
    #[schemars(range(min = 0.1, max = 1e3))]
    dog_length_mm: Option<f64>,
    /// Travel by which a switch opens later than it closed.
    #[schemars(range(min = 0.0, max = 1e3))]
    switch_hysteresis_mm: f64,
    /// Window in which the origin detector sees its mark.
    #[schemars(range(min = 1e-3, max = 90.0))]
    origin_window_deg: f64,
    /// Grinding wheel. A machine has a wheel or an insert.
    wheel: Option<WheelFile>,
    /// Changer with further wheels. Default: one wheel.
    wheel_changer: Option<WheelChangerFile>,
    /// Round insert of a lathe, driven or clamped. A lathe has no contact, workholding, thermal, gauge, `gap_detector`, process and
    /// dresser.
    insert: Option<InsertFile>,
    /// Contact of wheel and part. Default: rigid.
    contact: Option<ContactFile>,
    /// Stiffness of the supports of the part. A job with `part_support` adds the compliance of its part to
    /// `contact.machine_stiffness`, which then is that of the machine alone. Default: unknown.
    workholding: Option<WorkholdingFile>,
    /// Growth of the wheelhead. Default: none.
    thermal: Option<ThermalFile>,
    /// In-process gauge; it reads every tick in which C turns with a lobe in front of the wheel. Default: none.
    gauge: Option<GaugeFile>,
    /// Gap detector (acoustic emission): closes `wheel_contact` and latches X when the wheel touches. Default:
    /// none.
    gap_detector: Option<GapDetectorFile>,
    /// Switch at the part's keyway (input `key_way`, latches C). Default: none.
    key_way_probe: Option<KeyWayProbeFile>,
    /// Door and chuck. With them no job starts while one is open or a person is inside. Default: none.
    loading: Option<LoadingFile>,
    /// Energy and burn limit of the wheel on its material, reported for every degree of a lobe. Default: not
    /// reported.
    process: Option<ProcessFile>,
    /// Retract of the wheel on an alarm.
    #[serde(default)]
    alarm_retract: AlarmRetractFile,
    /// Rotating dresser on the table. Default: none.
    dresser: Option<DresserFile>,
    /// Body of the headstock, which the wheel must not touch. Default: unknown.
    headstock: Option<ExtentFile>,
    /// Body of the tailstock, which the wheel must not touch. Default: unknown.
    tailstock: Option<ExtentFile>,
    /// Real drives behind the HAL of LinuxCNC; the node `machine_hal` runs such a machine. Default: simulated.
    hal: Option<HalFile>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RotaryFile {
    /// Encoder counts of a turn.
    #[schemars(range(min = 1000, max = 1000000000_i64))]
    counts_per_turn: i64,
    /// Speed limit.
    #[schemars(range(min = 1e-3, max = 1e4))]
    max_speed_rpm: f64,
    /// Acceleration limit.
    #[schemars(range(min = 1e-3, max = 1e6))]
    max_acceleration_rad_s2: f64,
    /// Jerk limit.
    #[schemars(range(min = 1e-3, max = 1e9))]
    max_jerk_rad_s3: f64,
    /// Trip level of the following error at maximum speed; proportional below.
    #[schemars(range(min = 1e-6, max = 360.0))]
    max_following_error_deg: f64,
    /// Trip level of the following error at standstill.
    #[schemars(range(min = 1e-6, max = 360.0))]
    min_following_error_deg: f64,
    /// Speed of the search for the origin; at most `max_speed_rpm`.
    #[schemars(range(min = 1e-3, max = 1e4))]
    search_speed_rpm: f64,
    /// Position at power-up, unknown to the incremental encoder until it is homed.
    #[schemars(range(min = -360.0, max = 360.0))]
    power_up_position_deg: f64,
    /// Inertia that the motor accelerates.
    #[schemars(range(min = 1e-6, max = 1e4))]
    inertia_kg_m2: f64,
    /// Servo drive.
    drive: SpindleDriveFile,
    /// A better tuned drive; runs report the form error that it would leave. Default: not reported.
    good_drive: Option<SpindleDriveFile>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LinearFile {
    /// Encoder counts of a millimetre.
    #[schemars(range(min = 100, max = 10000000_i64))]
    counts_per_mm: i64,
    /// Lower soft limit.
    #[schemars(range(min = -1e5, max = 1e5))]
    soft_min_mm: f64,
    /// Upper soft limit.
    #[schemars(range(min = -1e5, max = 1e5))]
    soft_max_mm: f64,
    /// Lower hard limit switch, outside the soft limits.
    #[schemars(range(min = -1e5, max = 1e5))]
    overtravel_min_mm: f64,
    /// Upper hard limit switch, outside the soft limits.
    #[schemars(range(min = -1e5, max = 1e5))]
    overtravel_max_mm: f64,
    /// Speed limit.
    #[schemars(range(min = 1e-3, max = 1e4))]
    max_speed_mm_s: f64,
    /// Acceleration limit.
    #[schemars(range(min = 1e-3, max = 1e6))]
    max_acceleration_mm_s2: f64,
    /// Jerk limit.
    #[schemars(range(min = 1e-3, max = 1e9))]
    max_jerk_mm_s3: f64,
    /// Trip level of the following error at maximum speed; proportional below.
    #[schemars(range(min = 1e-6, max = 1e3))]
    max_following_error_mm: f64,
    /// Trip level of the following error at standstill.
    #[schemars(range(min = 1e-6, max = 1e3))]
    min_following_error_mm: f64,
    /// Speed of searches; at most `max_speed_mm_s`.
    #[schemars(range(min = 1e-3, max = 1e4))]
    search_speed_mm_s: f64,
    /// Position at power-up; within the soft limits.
    #[schemars(range(min = -1e5, max = 1e5))]
    power_up_position_mm: f64,
    /// Homing of the slide; its encoder then starts at 0. Default: the position is known.
    home: Option<HomingFile>,
    /// Mass that the motor accelerates.
    #[schemars(range(min = 1e-3, max = 1e6))]
    mass_kg: f64,
    /// Servo drive.
    drive: SlideDriveFile,
    /// A better tuned drive on a better slide; runs report the form error that it would leave. Default: not
    /// reported.
    good_drive: Option<SlideDriveFile>,
}

impl LinearFile {
    fn soft_limits_mm(&self) -> (f64, f64) {
        (self.soft_min_mm, self.soft_max_mm)
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StationFile {
    /// Name of the limit switch.
    #[schemars(schema_with = "names::schema")]
    switch: String,
    /// Position of `z_axis` at which the switch closes; within the soft limits of Z.
    #[schemars(range(min = -1e5, max = 1e5))]
    position_mm: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WheelFile {
    /// Name by which jobs ask for the wheel; every wheel of a changer has its own. Default: `wheel`; required in
    /// `wheel_changer.wheels`.
    #[schemars(schema_with = "names::schema")]
    #[serde(default)]
    pub(super) name: Option<String>,
    /// Distance by which the cutting point is nearer to the part than `x_axis` says, until the wheel is first dressed. Needs
    /// `wheel_changer`.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    #[serde(default)]
    pub(super) setting_error_um: f64,
    /// Radius of a new wheel.
    #[schemars(range(min = 1.0, max = 1e3))]
    new_radius_mm: f64,
    /// Minimum radius of a worn wheel.
    #[schemars(range(min = 1.0, max = 1e3))]
    min_radius_mm: f64,
    /// Width of the wheel.
    #[schemars(range(min = 0.1, max = 1e3))]
    width_mm: f64,
    /// Profile of the rim over the width, as every dress makes it. Default: straight.
    #[serde(default)]
    rim: RimFile,
    /// Speed at the rim.
    #[schemars(range(min = 1.0, max = 300.0))]
    surface_speed_m_s: f64,
    /// Speed that the strength of the wheel allows. Default: unknown.
    #[schemars(range(min = 1.0, max = 300.0))]
    max_surface_speed_m_s: Option<f64>,
    /// Speed that the spindle allows; a wheel too small for it is refused. Default: unknown.
    #[schemars(range(min = 1.0, max = 1e6))]
    max_speed_rpm: Option<f64>,
    /// Time to reach the speed.
    #[schemars(range(min = 0.0, max = 600.0))]
    spin_up_s: f64,
    /// G, ground volume per worn volume of the wheel. Default: no wear.
    #[schemars(range(min = 1e-3, max = 1e9))]
    grinding_ratio: Option<f64>,
    /// Amplitude of the wheel's centre by unbalance, once a turn.
    #[schemars(range(min = 0.0, max = 100.0))]
    #[serde(default)]
    unbalance_um: f64,
}

impl WheelFile {
    pub(super) fn wheel(&self) -> WheelDescription {
        WheelDescription {
            new_radius_mm: self.new_radius_mm,
            min_radius_mm: self.min_radius_mm,
            width_mm: self.width_mm,
            surface_speed_m_s: self.surface_speed_m_s,
            spin_up_s: self.spin_up_s,
            max_surface_speed_m_s: self.max_surface_speed_m_s,
            max_speed_rad_s: self.max_speed_rpm.map(rad_s_from_rpm),
            grinding_ratio: self.grinding_ratio,
            unbalance_mm: mm_from_um(self.unbalance_um),
            rim: self.rim.profile(),
        }
    }
}

/// A machine as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineConfig {
    /// Machine that the file describes.
    pub description: MachineDescription,
    /// Text of the file, with overrides applied.
    pub source: String,
    /// Path of the file.
    pub path: PathBuf,
    /// Real drives; `None`: the machine is simulated.
    pub hal: Option<HalConfig>,
}

impl MachineConfig {
    /// This machine with `key=value` overrides over its file.
    ///
    /// # Errors
    /// See [`parse`].
    pub fn with_overrides(&self, overrides: &[String]) -> Result<Self, ConfigError> {
        parse(Path::new(&self.description.name), &self.source, overrides)
    }

    /// `grinder` or `lathe`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        if self.description.is_lathe() { "lathe" } else { "grinder" }
    }

    /// Travel of the linear axes within their soft limits.
    #[must_use]
    pub fn travel(&self) -> String {
        let axes = self.description.axes.iter();
        let travels = axes.filter_map(|axis| {
            let (low, high) = axis.soft_limits?;
            Some(format!("{} {low} to {high} mm", axis.axis.joint()))
        });
        travels.collect::<Vec<_>>().join(", ")
    }

    /// Position of a key in its file.
    #[must_use]
    pub fn place(&self, key: &str) -> FileLocation {
        match Document::parse(&self.path, &self.source, &[]) {
            Ok(document) => document.place(key),
            Err(_) => FileLocation::file(&self.path),
        }
    }
}

/// Reads a machine file with `key=value` overrides.
///
/// # Errors
/// The first finding of [`read`].
pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<MachineConfig, ConfigError> {
    read(path, text, overrides).map_err(|mut findings| findings.swap_remove(0))
}

/// Reads a machine file with `key=value` overrides.
///
/// # Errors
/// Everything that is wrong with it: unknown keys, values out of their range, values that do not fit each other, each with its line.
pub fn read(path: &Path, text: &str, overrides: &[String]) -> Result<MachineConfig, Vec<ConfigError>> {
    let one = |error| vec![error];
    let document = Document::parse(path, text, overrides).map_err(one)?;
    document.require_schema("machine", SCHEMA_VERSION).map_err(one)?;
    let file: MachineFile = schema::read(&document)?;
    let tool = tool(&document, &file);
    let mut findings: Vec<ConfigError> = tool.as_ref().err().cloned().into_iter().collect();
    findings.extend(check(&document, &file));
    let (Ok((wheel, insert)), true) = (tool, findings.is_empty()) else { return Err(findings) };
    let hash = Sha256::digest(document.text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    let description = describe(&file, hash, wheel, insert);
    homing_file::check(&document, &description).map_err(one)?;
    description.validate().map_err(|error| one(ConfigError::at(FileLocation::file(path), error.to_string())))?;
    let findings = file.hal.as_ref().map_or_else(Vec::new, |hal| hal.check(&document, &description));
    if !findings.is_empty() {
        return Err(findings);
    }
    let hal = file.hal.map(|hal| hal.config(&description));
    Ok(MachineConfig { description, source: document.text, path: path.to_path_buf(), hal })
}

/// The machine that a job names under `machine`.
pub(super) fn named(job: &Document, name: &str) -> Result<MachineConfig, Vec<ConfigError>> {
    let found = job.locate(MACHINES, name, "yaml").map_err(|error| vec![job.error("machine", error.to_string())])?;
    read(&found.path, &found.text, &[])
}

/// Tool of the machine: a wheel, or an insert with its equivalent wheel for the spindle.
fn tool(document: &Document, file: &MachineFile) -> Result<(WheelDescription, Option<InsertDescription>), ConfigError> {
    match (&file.wheel, &file.insert) {
        (Some(wheel), None) => Ok((wheel.wheel(), None)),
        (None, Some(insert)) => {
            let insert = insert.insert(document)?;
            Ok((insert.tool(), Some(insert)))
        }
        (Some(_), Some(_)) => {
            Err(document.error("insert", "a machine has a wheel, or an insert: this one has both".to_owned()))
        }
        (None, None) => {
            Err(document.error("name", "a machine has a wheel, or an insert: this one has neither".to_owned()))
        }
    }
}

/// Length of a dog where there is no station to have one.
const NO_DOG_MM: f64 = 8.0;

fn describe(
    file: &MachineFile,
    hash: String,
    wheel: WheelDescription,
    insert: Option<InsertDescription>,
) -> MachineDescription {
    MachineDescription {
        name: file.name.clone(),
        hash,
        cycle_time_ns: file.cycle_time_us.saturating_mul(1000),
        feedback_delay_ticks: file.feedback_delay_ticks,
        servo_steps_per_tick: file.servo_steps_per_tick,
        axes: [rotary(&file.c_axis), linear(Axis::X, &file.x_axis), linear(Axis::Z, &file.z_axis)],
        stations: file
            .stations
            .iter()
            .map(|station| Station { switch: station.switch.clone(), position_mm: station.position_mm })
            .collect(),
        dog_length_mm: file.dog_length_mm.unwrap_or(NO_DOG_MM),
        switch_hysteresis_mm: file.switch_hysteresis_mm,
        origin_half_window_rad: rad_from_deg(file.origin_window_deg) / 2.0,
        wheel,
        insert,
        wheel_changer: file
            .wheel_changer
            .as_ref()
            .zip(file.wheel.as_ref())
            .map(|(changer, first)| changer.changer(first)),
        contact: file.contact.as_ref().map(ContactFile::contact),
        workholding: file.workholding.as_ref().map(WorkholdingFile::workholding),
        thermal: file.thermal.as_ref().map(ThermalFile::thermal),
        gauge: file.gauge.as_ref().map(GaugeFile::gauge),
        gap_detector: file.gap_detector.as_ref().map(GapDetectorFile::detector),
        key_way_probe: file.key_way_probe.as_ref().map(KeyWayProbeFile::probe),
        loading: file.loading.as_ref().map(LoadingFile::loading),
        process: file.process.as_ref().map(ProcessFile::process),
        retract: file.alarm_retract.retract(),
        dresser: file.dresser.as_ref().map(DresserFile::dresser),
        headstock: file.headstock.as_ref().map(ExtentFile::extent),
        tailstock: file.tailstock.as_ref().map(ExtentFile::extent),
        rotation_sense: file.rotation_sense,
    }
}

fn rotary(file: &RotaryFile) -> AxisDescription {
    AxisDescription {
        axis: Axis::C,
        scale: AxisScale::Rotary { counts_per_turn: file.counts_per_turn },
        limits: MotionLimits {
            velocity: rad_s_from_rpm(file.max_speed_rpm),
            acceleration: file.max_acceleration_rad_s2,
            jerk: file.max_jerk_rad_s3,
        },
        soft_limits: None,
        overtravel: None,
        max_following_error: rad_from_deg(file.max_following_error_deg),
        min_following_error: rad_from_deg(file.min_following_error_deg),
        needs_homing: true,
        homing: None,
        search_velocity: rad_s_from_rpm(file.search_speed_rpm),
        drive: file.drive.settings(),
        good_drive: file.good_drive.as_ref().map(SpindleDriveFile::settings),
        inertia: file.inertia_kg_m2,
        power_up_position: rad_from_deg(file.power_up_position_deg),
    }
}

fn linear(axis: Axis, file: &LinearFile) -> AxisDescription {
    AxisDescription {
        axis,
        scale: AxisScale::Linear { counts_per_mm: file.counts_per_mm },
        limits: MotionLimits {
            velocity: file.max_speed_mm_s,
            acceleration: file.max_acceleration_mm_s2,
            jerk: file.max_jerk_mm_s3,
        },
        soft_limits: Some((file.soft_min_mm, file.soft_max_mm)),
        overtravel: Some((file.overtravel_min_mm, file.overtravel_max_mm)),
        max_following_error: file.max_following_error_mm,
        min_following_error: file.min_following_error_mm,
        needs_homing: file.home.is_some(),
        homing: file.home.map(|home| home.homing(file.max_speed_mm_s)),
        search_velocity: file.search_speed_mm_s,
        drive: file.drive.settings(),
        good_drive: file.good_drive.as_ref().map(SlideDriveFile::settings),
        inertia: file.mass_kg,
        power_up_position: file.power_up_position_mm,
    }
}

fn wheels(file: &MachineFile) -> impl Iterator<Item = (String, &WheelFile)> {
    wheel_changer_file::wheels(file.wheel.as_ref(), file.wheel_changer.as_ref())
}

/// Values that must fit each other.
fn check(document: &Document, file: &MachineFile) -> Vec<ConfigError> {
    let mut findings = Vec::new();
    let (x_mm, z_mm) = (file.x_axis.soft_limits_mm(), file.z_axis.soft_limits_mm());
    for (key, value, (low, high)) in bounded(file, x_mm, z_mm) {
        if !(low..=high).contains(&value) {
            findings.push(document.error(&key, format!("{key} is {value}; it must be {low} to {high}")));
        }
    }
    for (of, wheel) in wheels(file) {
        let speed = wheel.surface_speed_m_s;
        if let Some(max) = wheel.max_surface_speed_m_s.filter(|max| speed > *max) {
            let key = format!("{of}.surface_speed_m_s");
            let message = format!("{key} is {speed}; it must be at most {of}.max_surface_speed_m_s, {max}");
            findings.push(document.error(&key, message));
        }
    }
    findings.extend(wheel_changer_file::check(document, file.wheel.as_ref(), file.wheel_changer.as_ref()));
    for (key, extent) in [("headstock", &file.headstock), ("tailstock", &file.tailstock)] {
        findings.extend(extent.as_ref().and_then(|extent| extent.check(document, key).err()));
    }
    findings.extend(file.contact.iter().filter_map(|contact| contact.check(document).err()));
    let has_contact = file.contact.is_some();
    findings.extend(file.workholding.iter().filter_map(|workholding| workholding.check(document, has_contact).err()));
    findings.extend(check_stations(document, file).err());
    findings
}

/// Values whose range other values of the file set: key, value, range.
fn bounded(file: &MachineFile, x_mm: (f64, f64), z_mm: (f64, f64)) -> Vec<(String, f64, (f64, f64))> {
    let c = &file.c_axis;
    let mut bounded = vec![
        ("c_axis.search_speed_rpm".to_owned(), c.search_speed_rpm, (0.0, c.max_speed_rpm)),
        (
            "c_axis.max_following_error_deg".to_owned(),
            c.max_following_error_deg,
            (c.min_following_error_deg, f64::INFINITY),
        ),
        ("switch_hysteresis_mm".to_owned(), file.switch_hysteresis_mm, (0.0, file.dog_length_mm.unwrap_or(NO_DOG_MM))),
    ];
    for (name, axis) in [("x_axis", &file.x_axis), ("z_axis", &file.z_axis)] {
        let (low, high) = axis.soft_limits_mm();
        let keys = [
            ("soft_max_mm", high, (low, f64::INFINITY)),
            ("overtravel_min_mm", axis.overtravel_min_mm, (f64::NEG_INFINITY, low)),
            ("overtravel_max_mm", axis.overtravel_max_mm, (high, f64::INFINITY)),
            ("search_speed_mm_s", axis.search_speed_mm_s, (0.0, axis.max_speed_mm_s)),
            ("max_following_error_mm", axis.max_following_error_mm, (axis.min_following_error_mm, f64::INFINITY)),
            ("power_up_position_mm", axis.power_up_position_mm, (low, high)),
        ];
        bounded.extend(keys.map(|(key, value, range)| (format!("{name}.{key}"), value, range)));
    }
    for (of, wheel) in wheels(file) {
        bounded.push((format!("{of}.new_radius_mm"), wheel.new_radius_mm, (wheel.min_radius_mm, f64::INFINITY)));
    }
    if let Some(changer) = &file.wheel_changer {
        bounded.push(("wheel_changer.min_x_mm".to_owned(), changer.min_x_mm, x_mm));
    }
    if let Some(insert) = &file.insert {
        bounded.push(("insert.height_mm".to_owned(), insert.height_mm, (insert.height_min_mm, insert.height_max_mm)));
        if let Some(edge) = &insert.edge {
            bounded.push(("insert.edge.to_deg".to_owned(), edge.to_deg, (edge.from_deg, f64::INFINITY)));
        }
    }
    if let Some(dresser) = &file.dresser {
        bounded.push(("dresser.x_mm".to_owned(), dresser.x_mm, x_mm));
        bounded.push(("dresser.z_mm".to_owned(), dresser.z_mm, z_mm));
    }
    if let Some(loading) = &file.loading {
        bounded.push(("loading.safe_x_mm".to_owned(), loading.safe_x_mm, x_mm));
    }
    for (index, point) in file.contact.iter().flat_map(|contact| contact.positions_mm()).enumerate() {
        bounded.push((format!("contact.machine_stiffness.{index}.z_mm"), point, z_mm));
    }
    bounded
}

fn check_stations(document: &Document, file: &MachineFile) -> Result<(), ConfigError> {
    if file.stations.is_empty() && file.insert.is_some() {
        return Ok(());
    }
    let Some(dog_length_mm) = file.dog_length_mm else {
        return Err(document.error("stations", "dog_length_mm is missing: stations have dogs".to_owned()));
    };
    if file.stations.is_empty() {
        return Err(document.error("stations", "stations is empty, at least one is needed"));
    }
    for (index, station) in file.stations.iter().enumerate() {
        let key = format!("stations.{index}.position_mm");
        let (low, high) = (file.z_axis.soft_min_mm, file.z_axis.soft_max_mm);
        if !(station.position_mm > low && station.position_mm < high) {
            return Err(document.error(
                &key,
                format!(
                    "station {} is at {} mm, the table reaches {low} to {high} mm",
                    station.switch, station.position_mm
                ),
            ));
        }
        let Some(previous) = index.checked_sub(1).map(|index| &file.stations[index]) else { continue };
        if file.stations[..index].iter().any(|other| other.switch == station.switch) {
            return Err(document.error(&key, format!("station {} is named twice", station.switch)));
        }
        // Two dogs on one switch would make an edge ambiguous.
        let room = station.position_mm - previous.position_mm;
        let needed = dog_length_mm + file.switch_hysteresis_mm;
        if room <= needed {
            return Err(document.error(
                &key,
                format!(
                    "station {} stands {room} mm after {}, more than {needed} mm is needed",
                    station.switch, previous.switch
                ),
            ));
        }
    }
    Ok(())
}
