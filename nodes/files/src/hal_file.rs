// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Connection of a machine to the HAL of LinuxCNC: its pins, their scale, and the queue of setpoints.

use super::ConfigError;
use super::yaml::Document;
use camwright::machine::description::{AXIS_COUNT, Axis, HomingKind, MachineDescription};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Most stations: their switches share a word of 16 bits.
pub const MAX_STATIONS: usize = 16;

/// Section `hal` of a machine file.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct HalFile {
    /// HAL thread that executes `streamer` and `sampler`. Its period is `cycle_time_us`.
    #[schemars(schema_with = "pin")]
    thread: String,
    /// Setpoints in the queue of HAL. More tolerates longer pauses of the computer, fewer react sooner. At most half of
    /// `feedback_delay_ticks`.
    #[schemars(range(min = 10, max = 500))]
    fifo_ticks: u32,
    /// Following error at which an axis counts as at rest on its setpoint: resolution and noise of the encoder.
    #[schemars(range(min = 0.6, max = 1e4))]
    rest_window_counts: f64,
    /// Headstock; positions in degrees times `scale`.
    c_axis: HalAxisFile,
    /// Wheelhead; positions in mm times `scale`.
    x_axis: HalAxisFile,
    /// Table; positions in mm times `scale`.
    z_axis: HalAxisFile,
    /// Wheel spindle.
    wheel: HalWheelFile,
    /// Bit pin that is true while the emergency stop chain is open.
    #[schemars(schema_with = "pin")]
    estop: String,
    /// Bit pin of the origin detector of C; true at its mark.
    #[schemars(schema_with = "pin")]
    origin: String,
    /// Bit pin of the limit switch of every station, by the name of the switch.
    #[serde(default)]
    stations: BTreeMap<String, String>,
    /// In-process gauge. Required with the machine's `gauge`. Default: none.
    gauge: Option<HalGaugeFile>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct HalGaugeFile {
    /// Float pin with the reading (mm): the diameter or the radius, as `gauge.kind` says.
    #[schemars(schema_with = "pin")]
    reading: String,
    /// Float pin with the reading of the second gauge (mm). Required with `gauge.second_behind_wheel_deg`.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    second_reading: Option<String>,
    /// Bit pin that is true while the gauge, or both, measure; what is read otherwise is dropped. Default: they always measure.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    valid: Option<String>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct HalAxisFile {
    /// Float pin that takes the position of every period.
    #[schemars(schema_with = "pin")]
    command: String,
    /// Float pin with the position of the encoder.
    #[schemars(schema_with = "pin")]
    feedback: String,
    /// Units of these pins for one mm or degree. Default: 1.
    #[schemars(range(min = -1e6, max = 1e6))]
    scale: Option<f64>,
    /// Bit pin that switches the drive on; it goes off 0.5 s after the last setpoint. Several drives on one line: join them in HAL.
    #[schemars(schema_with = "pin")]
    enable: String,
    /// Bit pin that is true while the drive reports a fault. Default: none.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    fault: Option<String>,
    /// Bit pin of the home switch. Required with `home`.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    home: Option<String>,
    /// Bit pin of the limit switches, both ends on one line. Default: none.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    limit: Option<String>,
    /// Bit pin `index-enable` of the encoder component, which clears it at an index mark. Required with `home.use_index`.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    index_enable: Option<String>,
    /// Float pin with the position of the encoder since its last index mark, in the units of `feedback`. Required with
    /// `home.use_index`.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    index_position: Option<String>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct HalWheelFile {
    /// Bit pin that lets the wheel run.
    #[schemars(schema_with = "pin")]
    run: String,
    /// Float pin that takes the speed of the wheel (rpm). Default: none.
    #[schemars(schema_with = "pin")]
    #[serde(default)]
    speed_rpm: Option<String>,
    /// Bit pin that is true while the wheel has its speed.
    #[schemars(schema_with = "pin")]
    at_speed: String,
}

/// A HAL name.
fn pin(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "string",
        "pattern": "^[A-Za-z][A-Za-z0-9._-]{0,46}$",
        "x-allowed": "a HAL name: 1 to 47 letters, digits, '.', '_' and '-'",
    })
}

/// Pins of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct HalAxis {
    pub command: String,
    pub feedback: String,
    /// Units of these pins for one mm or degree.
    pub scale: f64,
    pub enable: String,
    pub fault: Option<String>,
    pub home: Option<String>,
    pub limit: Option<String>,
    pub index: Option<HalIndex>,
}

/// Pins of an encoder with index marks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HalIndex {
    /// Set by this side; cleared by the encoder at a mark.
    pub enable: String,
    /// Position since the last mark.
    pub position: String,
}

/// Pins of an in-process gauge.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HalGauge {
    /// Reading (mm), in HAL as here.
    pub reading: String,
    /// Reading of a second gauge (mm).
    pub second_reading: Option<String>,
    /// True while they measure; `None`: always.
    pub valid: Option<String>,
}

/// Connection of a machine to the HAL of LinuxCNC.
#[derive(Debug, Clone, PartialEq)]
pub struct HalConfig {
    /// HAL thread of the servo period.
    pub thread: String,
    /// Setpoints in the queue of HAL.
    pub fifo_ticks: u32,
    /// Following error at which an axis counts as at rest (counts).
    pub rest_window_counts: f64,
    /// Pins of the axes, in the order of [`Axis::ALL`].
    pub axes: [HalAxis; AXIS_COUNT],
    pub wheel_run: String,
    pub wheel_speed_rpm: Option<String>,
    pub wheel_at_speed: String,
    pub estop: String,
    pub origin: String,
    /// Limit switches in the order of the stations: name and pin.
    pub stations: Vec<(String, String)>,
    pub gauge: Option<HalGauge>,
}

impl HalFile {
    pub(super) fn config(&self, machine: &MachineDescription) -> HalConfig {
        let axis = |file: &HalAxisFile| HalAxis {
            command: file.command.clone(),
            feedback: file.feedback.clone(),
            scale: file.scale.unwrap_or(1.0),
            enable: file.enable.clone(),
            fault: file.fault.clone(),
            home: file.home.clone(),
            limit: file.limit.clone(),
            index: file
                .index_enable
                .clone()
                .zip(file.index_position.clone())
                .map(|(enable, position)| HalIndex { enable, position }),
        };
        HalConfig {
            thread: self.thread.clone(),
            fifo_ticks: self.fifo_ticks,
            rest_window_counts: self.rest_window_counts,
            axes: [axis(&self.c_axis), axis(&self.x_axis), axis(&self.z_axis)],
            wheel_run: self.wheel.run.clone(),
            wheel_speed_rpm: self.wheel.speed_rpm.clone(),
            wheel_at_speed: self.wheel.at_speed.clone(),
            estop: self.estop.clone(),
            origin: self.origin.clone(),
            stations: machine
                .stations
                .iter()
                .filter_map(|station| self.stations.get_key_value(&station.switch))
                .map(|(name, pin)| (name.clone(), pin.clone()))
                .collect(),
            gauge: self.gauge.as_ref().map(|gauge| HalGauge {
                reading: gauge.reading.clone(),
                second_reading: gauge.second_reading.clone(),
                valid: gauge.valid.clone(),
            }),
        }
    }

    /// Findings about the connection itself and what HAL does not provide.
    pub(super) fn check(&self, document: &Document, machine: &MachineDescription) -> Vec<ConfigError> {
        let mut findings = Vec::new();
        let mut find = |key: &str, text: String| findings.push(document.error(key, text));
        let half = machine.feedback_delay_ticks / 2;
        if self.fifo_ticks > half {
            let text = format!(
                "{} ticks; allowed: 10 to {half}, half of feedback_delay_ticks ({}), so that setpoints arrive in time",
                self.fifo_ticks, machine.feedback_delay_ticks
            );
            find("hal.fifo_ticks", text);
        }
        for (axis, file) in Axis::ALL.into_iter().zip([&self.c_axis, &self.x_axis, &self.z_axis]) {
            let key = |key: &str| format!("hal.{}.{key}", axis.joint());
            if file.scale == Some(0.0) {
                find(&key("scale"), "0; allowed: units of the pin for one mm or degree, not 0".to_owned());
            }
            let homing = machine.axis(axis).homing;
            let has_switch = homing.and_then(|homing| homing.kind()).is_some_and(HomingKind::has_switch);
            if has_switch && file.home.is_none() {
                find(&format!("hal.{}", axis.joint()), "`home` is missing: the axis is homed at a switch".to_owned());
            }
            let uses_index = homing.is_some_and(|homing| homing.use_index);
            for (name, pin) in [("index_enable", &file.index_enable), ("index_position", &file.index_position)] {
                match pin {
                    None if uses_index => {
                        let text = format!("`{name}` is missing: the axis is homed at an index mark");
                        find(&format!("hal.{}", axis.joint()), text);
                    }
                    Some(_) if axis == Axis::C => {
                        find(&key(name), "C is homed at the mark of `origin`; take this pin out".to_owned());
                    }
                    Some(_) if !uses_index => {
                        let text = format!("not used; set {}.home.use_index, or take this pin out", axis.joint());
                        find(&key(name), text);
                    }
                    None | Some(_) => {}
                }
            }
            if file.index_position.as_ref() == Some(&file.feedback) {
                let text = format!(
                    "{}, as `feedback`; the feedback must not jump at a mark: take it from the raw counts of the encoder",
                    file.feedback
                );
                find(&key("index_position"), text);
            }
        }
        for station in machine.stations.iter().filter(|station| !self.stations.contains_key(&station.switch)) {
            find("hal.stations", format!("the pin of switch {} is missing", station.switch));
        }
        let is_known = |name: &String| machine.stations.iter().any(|station| station.switch == *name);
        for name in self.stations.keys().filter(|name| !is_known(name)) {
            find("hal.stations", format!("{name} is not a switch of `stations`"));
        }
        if machine.stations.len() > MAX_STATIONS {
            find("stations", format!("{} stations; HAL takes at most {MAX_STATIONS}", machine.stations.len()));
        }
        match (&self.gauge, &machine.gauge) {
            (None, Some(_)) => find("gauge", "`hal.gauge` is missing: name the pin of its reading there".to_owned()),
            (Some(_), None) => {
                find("hal.gauge", "not used; describe the gauge under `gauge`, or take these pins out".to_owned());
            }
            (Some(pins), Some(gauge)) => match (&pins.second_reading, gauge.second_behind_wheel_rad) {
                (None, Some(_)) => {
                    find("hal.gauge", "`second_reading` is missing: the machine has a second gauge".to_owned());
                }
                (Some(_), None) => find(
                    "hal.gauge.second_reading",
                    "not used; set gauge.second_behind_wheel_deg, or take this pin out".to_owned(),
                ),
                _ => {}
            },
            (None, None) => {}
        }
        let unread = [
            ("gap_detector", machine.gap_detector.is_some()),
            ("key_way_probe", machine.key_way_probe.is_some()),
            ("loading", machine.loading.is_some()),
        ];
        for (key, _) in unread.into_iter().filter(|(_, is_there)| *is_there) {
            find(key, "not possible with `hal`: it is not read from HAL pins; take it out of the file".to_owned());
        }
        findings
    }
}

#[cfg(test)]
mod tests {
    use crate::{locate, machine_file};

    const HOME: &str = "x_axis.home={search_velocity_mm_s: 5, latch_velocity_mm_s: -2, switch_mm: 164, home_mm: 150, \
                        use_index: true, index_pitch_mm: 8}";
    const SWITCH: &str = "hal.x_axis.home=x-home.out";
    const ENABLE: &str = "hal.x_axis.index_enable=x-index.index-enable";
    const POSITION: &str = "hal.x_axis.index_position=x-since-mark.out";

    fn read(overrides: &[&str]) -> Result<machine_file::MachineConfig, String> {
        let located = locate::locate("machines", "cam_grinder_hal", "yaml", None).expect("a shipped machine");
        let overrides: Vec<String> = overrides.iter().map(|key| (*key).to_owned()).collect();
        machine_file::parse(&located.path, &located.text, &overrides).map_err(|error| error.to_string())
    }

    #[test]
    fn index_marks_need_their_pins_and_are_needed_for_them() {
        let hal = read(&[HOME, SWITCH, ENABLE, POSITION]).expect("a machine").hal.expect("drives");
        let index = hal.axes[1].index.as_ref().expect("it has marks");
        assert_eq!((index.enable.as_str(), index.position.as_str()), ("x-index.index-enable", "x-since-mark.out"));
        for (overrides, expected) in [
            (&[HOME, SWITCH][..], "`index_enable` is missing: the axis is homed at an index mark"),
            (&[HOME, SWITCH, ENABLE], "`index_position` is missing"),
            (&[HOME, ENABLE, POSITION], "`home` is missing"),
            (&[ENABLE, POSITION], "not used; set x_axis.home.use_index"),
            (&["hal.c_axis.index_enable=c.index-enable"], "C is homed at the mark of `origin`"),
            (
                &[HOME, SWITCH, ENABLE, "hal.x_axis.index_position=x-encoder.out"],
                "the feedback must not jump at a mark",
            ),
        ] {
            let refused = read(overrides).expect_err(expected);
            assert!(refused.contains(expected), "{refused}");
        }
    }

    const GAUGE: &str = "gauge={kind: diameter, behind_wheel_deg: 270, resolution_um: 0.1, noise_um: 0.2}";
    const SECOND: &str = "gauge.second_behind_wheel_deg=210";
    const PINS: &str = "hal.gauge={reading: gauge.position, valid: gauge.ok}";
    const NO_GAUGE: &str = "gauge=null";
    const NO_PINS: &str = "hal.gauge=null";

    #[test]
    fn a_gauge_needs_its_pins_and_is_needed_for_them() {
        let hal = read(&[GAUGE, PINS]).expect("a machine").hal.expect("drives");
        let pins = hal.gauge.expect("a gauge");
        assert_eq!((pins.reading.as_str(), pins.valid.as_deref()), ("gauge.position", Some("gauge.ok")));
        let without = read(&[NO_GAUGE, NO_PINS]).expect("a machine without a gauge");
        assert!(without.description.gauge.is_none() && without.hal.expect("drives").gauge.is_none());
        let both = read(&[GAUGE, SECOND, PINS, "hal.gauge.second_reading=gauge.other"]).expect("two gauges");
        assert_eq!(both.hal.expect("drives").gauge.expect("gauges").second_reading.as_deref(), Some("gauge.other"));
        for (overrides, expected) in [
            (&[GAUGE, NO_PINS][..], "`hal.gauge` is missing: name the pin of its reading there"),
            (&[NO_GAUGE, PINS], "not used; describe the gauge under `gauge`, or take these pins out"),
            (&[GAUGE, SECOND, PINS], "`second_reading` is missing: the machine has a second gauge"),
            (&[GAUGE, PINS, "hal.gauge.second_reading=gauge.other"], "not used; set gauge.second_behind_wheel_deg"),
            (&[GAUGE, "hal.gauge={valid: gauge.ok}"], "hal.gauge.reading is missing: Float pin with the reading"),
            (&[GAUGE, "hal.gauge={reading: 2.position}"], "hal.gauge.reading"),
        ] {
            let refused = read(overrides).expect_err(expected);
            assert!(refused.contains(expected), "{refused}");
        }
    }

    /// A refusal names the line of the file.
    #[test]
    fn a_gauge_without_pins_is_refused_at_its_line() {
        let located = locate::locate("machines", "cam_grinder_hal", "yaml", None).expect("a shipped machine");
        let pins = located.text.lines().find(|line| line.starts_with("  gauge: {reading")).expect("its pins");
        let text = located.text.replace(pins, "");
        // A section is where its first key is.
        let line = 2 + text.lines().position(|line| line.starts_with("gauge:")).expect("its gauge");
        let refused = machine_file::parse(&located.path, &text, &[]).expect_err("no pins").to_string();
        assert!(refused.contains(&format!("cam_grinder_hal.yaml:{line}: ")), "{refused}");
        assert!(refused.contains("`hal.gauge` is missing"), "{refused}");
    }

    #[test]
    fn every_axis_has_a_gate() {
        let refused = read(&["hal.z_axis={command: z-command.in0, feedback: z-encoder.out}"]).expect_err("no gate");
        assert!(refused.contains("hal.z_axis.enable is missing: Bit pin that switches the drive on"), "{refused}");
    }
}
