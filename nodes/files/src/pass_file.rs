//! The passes of a job file: infeed and speed, roughing first.

use super::limits::MAX_SPARK_OUT_TURNS;
use super::names;
use camwright::job::grinding::{InfeedCourse, InfeedDirection, PassSpec, SpeedLaw};
use camwright::machine::description::ReferenceCut;
use camwright::math::units::{mm_from_um, rad_s_from_rpm};
use serde::Deserialize;

/// Name of the pass that every job has, the last one.
const LAST_PASS: &str = "grind";

/// Infeed of a pass.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InfeedFile {
    pub(super) total_mm: f64,
    pub(super) per_block_um: f64,
    pub(super) spark_out_turns: u32,
    spark_out_until_n: Option<u32>,
    #[serde(default)]
    course: CourseFile,
    #[serde(default)]
    along: AlongFile,
}

/// Over what the wheel comes closer.
#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum CourseFile {
    #[default]
    PerAngle,
    PerTurn,
}

/// Along what the infeed is measured.
#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum AlongFile {
    #[default]
    XAxis,
    Normal,
}

/// How the headstock's speed over the lobe is chosen.
#[derive(Debug, Default, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum SpeedFile {
    #[default]
    ConstantWorkSpeed,
    ConstantFootprintSpeed {
        footprint_speed_mm_s: f64,
    },
    ConstantRemovalRate {
        removal_rate_mm2_s: f64,
    },
    ConstantPower {
        power_w_mm: f64,
        specific_energy_j_mm3: f64,
        rubbing_n_mm2: f64,
    },
    ConstantTemperature {
        reference_footprint_speed_mm_s: f64,
        reference_depth_um: f64,
        reference_equivalent_diameter_mm: f64,
    },
    TimeOptimal,
}

impl SpeedFile {
    fn law(&self, work_speed_rpm: f64) -> SpeedLaw {
        let most_rad_s = rad_s_from_rpm(work_speed_rpm);
        match *self {
            SpeedFile::ConstantWorkSpeed => SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: most_rad_s },
            SpeedFile::ConstantFootprintSpeed { footprint_speed_mm_s } => {
                SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s, most_rad_s }
            }
            SpeedFile::ConstantRemovalRate { removal_rate_mm2_s } => {
                SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, most_rad_s }
            }
            SpeedFile::ConstantPower { power_w_mm, specific_energy_j_mm3, rubbing_n_mm2 } => {
                SpeedLaw::ConstantPower { power_w_mm, specific_energy_j_mm3, rubbing_n_mm2, most_rad_s }
            }
            SpeedFile::ConstantTemperature {
                reference_footprint_speed_mm_s,
                reference_depth_um,
                reference_equivalent_diameter_mm,
            } => SpeedLaw::ConstantTemperature {
                reference: ReferenceCut {
                    footprint_speed_mm_s: reference_footprint_speed_mm_s,
                    depth_mm: mm_from_um(reference_depth_um),
                    equivalent_diameter_mm: reference_equivalent_diameter_mm,
                },
                most_rad_s,
            },
            SpeedFile::TimeOptimal => SpeedLaw::TimeOptimal { most_rad_s },
        }
    }

    /// What the law is set to, by its keys.
    pub(super) fn settings(&self) -> Vec<(&'static str, f64)> {
        match *self {
            SpeedFile::ConstantFootprintSpeed { footprint_speed_mm_s } => {
                vec![("speed.footprint_speed_mm_s", footprint_speed_mm_s)]
            }
            SpeedFile::ConstantRemovalRate { removal_rate_mm2_s } => {
                vec![("speed.removal_rate_mm2_s", removal_rate_mm2_s)]
            }
            SpeedFile::ConstantPower { power_w_mm, specific_energy_j_mm3, rubbing_n_mm2 } => vec![
                ("speed.power_w_mm", power_w_mm),
                ("speed.specific_energy_j_mm3", specific_energy_j_mm3),
                ("speed.rubbing_n_mm2", rubbing_n_mm2),
            ],
            SpeedFile::ConstantTemperature {
                reference_footprint_speed_mm_s,
                reference_depth_um,
                reference_equivalent_diameter_mm,
            } => vec![
                ("speed.reference_footprint_speed_mm_s", reference_footprint_speed_mm_s),
                ("speed.reference_depth_um", reference_depth_um),
                ("speed.reference_equivalent_diameter_mm", reference_equivalent_diameter_mm),
            ],
            SpeedFile::ConstantWorkSpeed | SpeedFile::TimeOptimal => Vec::new(),
        }
    }
}

/// A pass before the last one.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RoughingFile {
    name: String,
    infeed: InfeedFile,
    work_speed_rpm: f64,
    #[serde(default)]
    speed: SpeedFile,
    wheel_radius_mm: Option<f64>,
}

impl RoughingFile {
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The wheel it asks for, if it does.
    pub(super) fn wheel_radius_mm(&self) -> Option<f64> {
        self.wheel_radius_mm
    }
}

fn pass(name: &str, infeed: &InfeedFile, work_speed_rpm: f64, speed: &SpeedFile) -> PassSpec {
    PassSpec {
        name: name.into(),
        total_infeed_mm: infeed.total_mm,
        infeed_per_block_mm: mm_from_um(infeed.per_block_um),
        infeed_course: match infeed.course {
            CourseFile::PerAngle => InfeedCourse::PerAngle,
            CourseFile::PerTurn => InfeedCourse::PerTurn,
        },
        infeed_direction: match infeed.along {
            AlongFile::XAxis => InfeedDirection::X,
            AlongFile::Normal => InfeedDirection::Normal,
        },
        spark_out_turns: infeed.spark_out_turns,
        spark_out_until_n: infeed.spark_out_until_n,
        speed: speed.law(work_speed_rpm),
    }
}

/// All passes in their order.
pub(super) fn passes(
    roughing: &[RoughingFile],
    infeed: &InfeedFile,
    work_speed_rpm: f64,
    speed: &SpeedFile,
) -> Vec<PassSpec> {
    let rough = roughing.iter().map(|rough| pass(&rough.name, &rough.infeed, rough.work_speed_rpm, &rough.speed));
    rough.chain([pass(LAST_PASS, infeed, work_speed_rpm, speed)]).collect()
}

/// What can be said about single values of the passes before the last: key and message.
pub(super) fn roughing_findings(roughing: &[RoughingFile]) -> Vec<(String, String)> {
    let mut findings = Vec::new();
    for (index, rough) in roughing.iter().enumerate() {
        let name = &rough.name;
        let mut refuse = |key: &str, message: String| {
            findings.push((format!("roughing.{index}.{key}"), format!("roughing {name}: {message}")));
        };
        if let Some(message) = names::fault("pass", name) {
            refuse("name", message);
        }
        let positive = [
            ("infeed.total_mm", rough.infeed.total_mm),
            ("infeed.per_block_um", rough.infeed.per_block_um),
            ("work_speed_rpm", rough.work_speed_rpm),
        ];
        for (key, value) in positive.into_iter().chain(rough.speed.settings()) {
            if !(value.is_finite() && value > 0.0) {
                refuse(key, format!("{key} is {value}; it must be a positive number"));
            }
        }
        if rough.infeed.spark_out_turns == 0 {
            let key = "infeed.spark_out_turns";
            refuse(key, format!("{key} is 0; at least 1 is needed to remove the step that the infeed leaves"));
        }
        if rough.infeed.spark_out_turns > MAX_SPARK_OUT_TURNS {
            let (key, turns) = ("infeed.spark_out_turns", rough.infeed.spark_out_turns);
            refuse(key, format!("{key} is {turns}; at most {MAX_SPARK_OUT_TURNS} are allowed"));
        }
        if name == LAST_PASS || roughing[..index].iter().any(|other| other.name == *name) {
            refuse("name", format!("there are two passes named {name}; names must differ (the last is {LAST_PASS})"));
        }
    }
    findings
}
