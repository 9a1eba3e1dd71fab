//! Machine files: what is written, and the description it means.

use super::contact_file::ContactFile;
use super::drive_file::{SlideDriveFile, SpindleDriveFile};
use super::fault_file::AlarmRetractFile;
use super::gauge_file::GaugeFile;
use super::homing_file::{self, HomingFile};
use super::insert_file::InsertFile;
use super::job_files::MACHINES;
use super::loading_file::LoadingFile;
use super::names;
use super::probe_file::{GapDetectorFile, KeyWayProbeFile};
use super::process_file::ProcessFile;
use super::wheel_file::{DresserFile, ExtentFile, ThermalFile};
use super::yaml::Document;
use super::{ConfigError, Place};
use camwright::machine::description::{
    Axis, AxisDescription, InsertDescription, MachineDescription, MotionLimits, Scale, Station, WheelDescription,
};
use camwright::math::units::{mm_from_um, rad_from_deg, rad_s_from_rpm};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// Newest version of the machine file's schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MachineFile {
    #[serde(rename = "schema")]
    _schema: String,
    name: String,
    cycle_time_us: u32,
    feedback_delay_ticks: u32,
    servo_steps_per_tick: u32,
    rotation_sense: i8,
    c_axis: RotaryFile,
    x_axis: LinearFile,
    z_axis: LinearFile,
    /// A lathe may have none.
    #[serde(default)]
    stations: Vec<StationFile>,
    dog_length_mm: Option<f64>,
    switch_hysteresis_mm: f64,
    origin_window_deg: f64,
    wheel: Option<WheelFile>,
    insert: Option<InsertFile>,
    contact: Option<ContactFile>,
    thermal: Option<ThermalFile>,
    gauge: Option<GaugeFile>,
    gap_detector: Option<GapDetectorFile>,
    key_way_probe: Option<KeyWayProbeFile>,
    loading: Option<LoadingFile>,
    process: Option<ProcessFile>,
    #[serde(default)]
    alarm_retract: AlarmRetractFile,
    dresser: Option<DresserFile>,
    headstock: Option<ExtentFile>,
    tailstock: Option<ExtentFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RotaryFile {
    counts_per_turn: i64,
    max_speed_rpm: f64,
    max_acceleration_rad_s2: f64,
    max_jerk_rad_s3: f64,
    max_following_error_deg: f64,
    min_following_error_deg: f64,
    search_speed_rpm: f64,
    power_up_position_deg: f64,
    inertia_kg_m2: f64,
    drive: SpindleDriveFile,
    good_drive: Option<SpindleDriveFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LinearFile {
    counts_per_mm: i64,
    soft_min_mm: f64,
    soft_max_mm: f64,
    overtravel_min_mm: f64,
    overtravel_max_mm: f64,
    max_speed_mm_s: f64,
    max_acceleration_mm_s2: f64,
    max_jerk_mm_s3: f64,
    max_following_error_mm: f64,
    min_following_error_mm: f64,
    search_speed_mm_s: f64,
    power_up_position_mm: f64,
    home: Option<HomingFile>,
    mass_kg: f64,
    drive: SlideDriveFile,
    good_drive: Option<SlideDriveFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StationFile {
    switch: String,
    position_mm: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WheelFile {
    new_radius_mm: f64,
    min_radius_mm: f64,
    width_mm: f64,
    surface_speed_m_s: f64,
    max_surface_speed_m_s: Option<f64>,
    max_speed_rpm: Option<f64>,
    spin_up_s: f64,
    grinding_ratio: Option<f64>,
    #[serde(default)]
    unbalance_um: f64,
}

impl WheelFile {
    fn wheel(&self) -> WheelDescription {
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
        }
    }

    fn check(&self, document: &Document, within: &RangeCheck<'_>) -> Result<(), ConfigError> {
        within("wheel.min_radius_mm", self.min_radius_mm, 1.0, 1e3)?;
        within("wheel.new_radius_mm", self.new_radius_mm, self.min_radius_mm, 1e3)?;
        within("wheel.width_mm", self.width_mm, 0.1, 1e3)?;
        within("wheel.surface_speed_m_s", self.surface_speed_m_s, 1.0, 300.0)?;
        within("wheel.spin_up_s", self.spin_up_s, 0.0, 600.0)?;
        within("wheel.unbalance_um", self.unbalance_um, 0.0, 100.0)?;
        for (key, value, low, high) in [
            ("wheel.max_surface_speed_m_s", self.max_surface_speed_m_s, 1.0, 300.0),
            ("wheel.max_speed_rpm", self.max_speed_rpm, 1.0, 1e6),
            ("wheel.grinding_ratio", self.grinding_ratio, 1e-3, 1e9),
        ] {
            value.map_or(Ok(()), |value| within(key, value, low, high))?;
        }
        if let Some(most) = self.max_surface_speed_m_s.filter(|most| self.surface_speed_m_s > *most) {
            let message = format!(
                "wheel.surface_speed_m_s is {}; the wheel's strength allows wheel.max_surface_speed_m_s, {most}",
                self.surface_speed_m_s
            );
            return Err(document.error("wheel.surface_speed_m_s", message));
        }
        Ok(())
    }
}

/// A machine as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// What the file means.
    pub description: MachineDescription,
    /// What it says, with overrides written in.
    pub source: String,
    /// Where it was read from.
    pub path: PathBuf,
}

impl Machine {
    /// This machine with `key=value` overrides over its file.
    ///
    /// # Errors
    /// See [`parse`].
    pub fn with_overrides(&self, overrides: &[String]) -> Result<Self, ConfigError> {
        parse(Path::new(&self.description.name), &self.source, overrides)
    }

    /// Where a key of its file stands.
    #[must_use]
    pub fn place(&self, key: &str) -> Place {
        match Document::parse(&self.path, &self.source, &[]) {
            Ok(document) => document.place(key),
            Err(_) => Place::file(&self.path),
        }
    }
}

/// Reads a machine file with `key=value` overrides.
///
/// # Errors
/// Anything that is not a machine: unknown keys, values out of their range, with file and line.
pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Machine, ConfigError> {
    let document = Document::parse(path, text, overrides)?;
    document.require_schema("machine", SCHEMA_VERSION)?;
    let file: MachineFile = document.read()?;
    let hash = Sha256::digest(document.text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    let (wheel, insert) = tool(&document, &file)?;
    let description = describe(&file, hash, wheel, insert);
    check(&document, &file)?;
    homing_file::check(&document, &description)?;
    description.validate().map_err(|error| ConfigError::at(Place::file(path), error.to_string()))?;
    Ok(Machine { description, source: document.text, path: path.to_path_buf() })
}

/// The machine that a job names under `machine`.
pub(super) fn named(job: &Document, name: &str) -> Result<Machine, ConfigError> {
    let found = job.locate(MACHINES, name, "yaml").map_err(|error| job.error("machine", error.to_string()))?;
    parse(&found.path, &found.text, &[])
}

/// What the machine works with: a wheel, or an insert with the wheel that it is to its spindle.
fn tool(document: &Document, file: &MachineFile) -> Result<(WheelDescription, Option<InsertDescription>), ConfigError> {
    match (&file.wheel, &file.insert) {
        (Some(wheel), None) => Ok((wheel.wheel(), None)),
        (None, Some(insert)) => Ok((insert.insert().tool(), Some(insert.insert()))),
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
        contact: file.contact.as_ref().map(ContactFile::contact),
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
        scale: Scale::Rotary { counts_per_turn: file.counts_per_turn },
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
        scale: Scale::Linear { counts_per_mm: file.counts_per_mm },
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

/// What types cannot say: ranges, and values that must fit each other.
fn check(document: &Document, file: &MachineFile) -> Result<(), ConfigError> {
    let within = |key: &str, value: f64, low: f64, high: f64| {
        if value.is_finite() && (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(document.error(key, format!("{key} is {value}, allowed is {low} to {high}")))
        }
    };
    let stations = file.stations.iter().enumerate();
    let stations = stations.map(|(index, station)| (format!("stations.{index}.switch"), "station", &station.switch));
    for (key, what, name) in [("name".to_owned(), "machine", &file.name)].into_iter().chain(stations) {
        names::fault(what, name).map_or(Ok(()), |message| Err(document.error(&key, message)))?;
    }
    within("cycle_time_us", f64::from(file.cycle_time_us), 100.0, 20_000.0)?;
    within("feedback_delay_ticks", f64::from(file.feedback_delay_ticks), 8.0, 1000.0)?;
    within("servo_steps_per_tick", f64::from(file.servo_steps_per_tick), 1.0, 32.0)?;
    if file.rotation_sense.abs() != 1 {
        return Err(
            document.error("rotation_sense", format!("rotation_sense is {}, allowed is 1 or -1", file.rotation_sense))
        );
    }
    let c = &file.c_axis;
    within("c_axis.counts_per_turn", c.counts_per_turn as f64, 1000.0, 1e9)?;
    within("c_axis.max_speed_rpm", c.max_speed_rpm, 1e-3, 10_000.0)?;
    within("c_axis.max_acceleration_rad_s2", c.max_acceleration_rad_s2, 1e-3, 1e6)?;
    within("c_axis.max_jerk_rad_s3", c.max_jerk_rad_s3, 1e-3, 1e9)?;
    within("c_axis.search_speed_rpm", c.search_speed_rpm, 1e-3, c.max_speed_rpm)?;
    within("c_axis.min_following_error_deg", c.min_following_error_deg, 1e-6, 360.0)?;
    within("c_axis.max_following_error_deg", c.max_following_error_deg, c.min_following_error_deg, 360.0)?;
    within("c_axis.power_up_position_deg", c.power_up_position_deg, -360.0, 360.0)?;
    within("c_axis.inertia_kg_m2", c.inertia_kg_m2, 1e-6, 1e4)?;
    c.drive.check("c_axis.drive", &within)?;
    c.good_drive.as_ref().map_or(Ok(()), |drive| drive.check("c_axis.good_drive", &within))?;
    for (name, axis) in [("x_axis", &file.x_axis), ("z_axis", &file.z_axis)] {
        let within = |key: &str, value: f64, low: f64, high: f64| within(&format!("{name}.{key}"), value, low, high);
        within("counts_per_mm", axis.counts_per_mm as f64, 100.0, 1e7)?;
        within("soft_min_mm", axis.soft_min_mm, -1e5, 1e5)?;
        within("soft_max_mm", axis.soft_max_mm, axis.soft_min_mm, 1e5)?;
        within("overtravel_min_mm", axis.overtravel_min_mm, -1e5, axis.soft_min_mm)?;
        within("overtravel_max_mm", axis.overtravel_max_mm, axis.soft_max_mm, 1e5)?;
        within("max_speed_mm_s", axis.max_speed_mm_s, 1e-3, 1e4)?;
        within("max_acceleration_mm_s2", axis.max_acceleration_mm_s2, 1e-3, 1e6)?;
        within("max_jerk_mm_s3", axis.max_jerk_mm_s3, 1e-3, 1e9)?;
        within("search_speed_mm_s", axis.search_speed_mm_s, 1e-3, axis.max_speed_mm_s)?;
        within("min_following_error_mm", axis.min_following_error_mm, 1e-6, 1e3)?;
        within("max_following_error_mm", axis.max_following_error_mm, axis.min_following_error_mm, 1e3)?;
        within("power_up_position_mm", axis.power_up_position_mm, axis.soft_min_mm, axis.soft_max_mm)?;
        within("mass_kg", axis.mass_kg, 1e-3, 1e6)?;
        axis.drive.check("drive", &within)?;
        axis.good_drive.as_ref().map_or(Ok(()), |drive| drive.check("good_drive", &within))?;
    }
    let dog_length_mm = file.dog_length_mm.unwrap_or(NO_DOG_MM);
    within("dog_length_mm", dog_length_mm, 0.1, 1e3)?;
    within("switch_hysteresis_mm", file.switch_hysteresis_mm, 0.0, dog_length_mm)?;
    within("origin_window_deg", file.origin_window_deg, 1e-3, 90.0)?;
    file.wheel.as_ref().map_or(Ok(()), |wheel| wheel.check(document, &within))?;
    file.insert.as_ref().map_or(Ok(()), |insert| insert.check(&within))?;
    file.alarm_retract.check(&within)?;
    if let Some(contact) = &file.contact {
        contact.check(document, &within, (file.z_axis.soft_min_mm, file.z_axis.soft_max_mm))?;
    }
    if let Some(thermal) = &file.thermal {
        within("thermal.growth_um", thermal.growth_um, -1000.0, 1000.0)?;
        within("thermal.time_constant_s", thermal.time_constant_s, 1.0, 1e6)?;
    }
    let probes = file.gap_detector.iter().flat_map(GapDetectorFile::ranges);
    let probes = probes.chain(file.key_way_probe.iter().flat_map(KeyWayProbeFile::ranges));
    let probes = probes.chain(file.process.iter().flat_map(ProcessFile::ranges));
    let x_mm = (file.x_axis.soft_min_mm, file.x_axis.soft_max_mm);
    let probes = probes.chain(file.loading.iter().flat_map(|loading| loading.ranges(x_mm)));
    for (key, value, low, high) in file.gauge.iter().flat_map(GaugeFile::ranges).chain(probes) {
        within(key, value, low, high)?;
    }
    if let Some(dresser) = &file.dresser {
        let (x, z) = (&file.x_axis, &file.z_axis);
        for (key, value, low, high) in dresser.ranges((z.soft_min_mm, z.soft_max_mm), (x.soft_min_mm, x.soft_max_mm)) {
            within(key, value, low, high)?;
        }
    }
    for (key, extent) in [("headstock", &file.headstock), ("tailstock", &file.tailstock)] {
        extent.as_ref().map_or(Ok(()), |extent| extent.check(document, key))?;
    }
    check_stations(document, file)
}

/// Checks a value under a key against a range.
pub(super) type RangeCheck<'a> = dyn Fn(&str, f64, f64, f64) -> Result<(), ConfigError> + 'a;

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
