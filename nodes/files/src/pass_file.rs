// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The passes of a job file: infeed and speed, roughing first.

use super::names;
use camwright::job::grinding::{
    InfeedCourse, InfeedDirection, MAX_SPARK_OUT_TURNS, MAX_VARIATION_N, PassSpec, SizeControl, SpeedLaw,
    VARIATION_PERIODS_TURNS,
};
use camwright::job::infeed::MAX_TURNS;
use camwright::job::speed_variation::SpeedVariation;
use camwright::machine::description::ReferenceCut;
use camwright::math::units::{mm_from_um, rad_s_from_rpm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name of the pass that every job has, the last one.
const LAST_PASS: &str = "grind";

/// Infeed of a pass.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct InfeedFile {
    /// RT (DS1), total infeed of the pass: infeed per turn times whole turns.
    #[schemars(range(min = 1e-6, max = 100.0))]
    total_mm: f64,
    /// Delta R (DS3), infeed per block: the infeed per turn divided by the blocks of a turn. Instead of `per_turn_um`.
    #[schemars(range(min = 1e-6, max = 1e5))]
    per_block_um: Option<f64>,
    /// Infeed per turn, the same in every turn, or a list with the infeed of each turn, whose sum is `total_mm` within half a count of X.
    /// Instead of `per_block_um`.
    per_turn_um: Option<TurnInfeedFile>,
    /// Turns without infeed. At least one removes the step that the infeed leaves; 0 leaves it to the next pass.
    #[schemars(range(min = 0, max = MAX_SPARK_OUT_TURNS))]
    pub(super) spark_out_turns: u32,
    /// Ends the spark-out as soon as the normal force varies by no more than this over a turn; `spark_out_turns`
    /// is then the maximum. Not with `runout_correction` or `rotary_indexing`. Default: all turns.
    #[schemars(range(min = 1, max = MAX_VARIATION_N))]
    spark_out_until_n: Option<u32>,
    /// Gauge-controlled size: the infeed ends as soon as the gauge reads a size; spark-out follows. The planned infeed is the upper
    /// bound: if it does not reach the size, alarm 142 stops the machine. Only in the last pass of a job of journals, with a gauge of two
    /// contacts; not with `runout_correction`, `rotary_indexing` or `c_between_lobes: turns_on`. Default: all of the infeed.
    gauge_size: Option<GaugeSizeFile>,
    /// Distribution of the infeed over a turn.
    #[serde(default)]
    course: CourseFile,
    /// Direction in which the infeed is measured; the same for all passes.
    #[serde(default)]
    along: AlongFile,
}

/// Infeed per turn: one value, or one for each turn.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
enum TurnInfeedFile {
    /// The same in every turn.
    Each(#[schemars(range(min = 1e-6, max = 1e5))] f64),
    /// One value for each turn.
    List(#[schemars(length(min = 1, max = MAX_TURNS), inner(range(min = 1e-6, max = 1e5)))] Vec<f64>),
}

/// Size on the gauge that ends an infeed.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GaugeSizeFile {
    /// Diameter above the finished one at which the infeed ends, as the mean of a turn of the gauge.
    #[schemars(range(min = 0.0, max = 1e4))]
    ends_above_um: f64,
    /// Infeed of X that may go beyond the finished size, for a wheel that is smaller than X is counted with. It is part of `total_mm`.
    #[serde(default = "default_beyond_um")]
    #[schemars(range(min = 0.0, max = 1000.0))]
    beyond_um: f64,
}

const fn default_beyond_um() -> f64 {
    50.0
}

impl InfeedFile {
    /// Infeed per block (µm), of a list the mean of all blocks; the infeed of a turn is the same in each of its blocks.
    fn per_block_um(&self, blocks_per_turn: u32) -> f64 {
        let per_turn_um = self.per_turn_um.as_ref().map(|infeed| match infeed {
            TurnInfeedFile::Each(um) => *um,
            TurnInfeedFile::List(list) => list.iter().sum::<f64>() / list.len() as f64,
        });
        self.per_block_um.or(per_turn_um.map(|um| um / f64::from(blocks_per_turn))).unwrap_or_default()
    }

    /// Infeed of each turn (mm); empty where it is the same in all.
    fn of_turns_mm(&self) -> Vec<f64> {
        match &self.per_turn_um {
            Some(TurnInfeedFile::List(list)) => list.iter().copied().map(mm_from_um).collect(),
            _ => Vec::new(),
        }
    }

    /// Error where not exactly one of infeed per block and per turn is given.
    fn finding(&self) -> Option<&'static str> {
        match (self.per_block_um, &self.per_turn_um) {
            (None, None) => {
                Some("infeed needs per_turn_um, the infeed per turn, or per_block_um, the infeed per block")
            }
            (Some(_), Some(_)) => Some(
                "infeed has both per_turn_um and per_block_um; remove one, with --set for example infeed.per_block_um=null",
            ),
            _ => None,
        }
    }
}

/// Over what the wheel comes closer.
#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum CourseFile {
    #[default]
    /// Delta R in every block: a spiral.
    PerAngle,
    /// The infeed of a whole turn on the base circle, then constant depth.
    PerTurn,
}

/// Along what the infeed is measured.
#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum AlongFile {
    #[default]
    /// Along X: flanks are cut less deep by the cosine of the contour angle.
    XAxis,
    /// Along the contour's normal: the same depth all round.
    Normal,
}

/// Speed law of the headstock over the lobe.
#[derive(Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(tag = "law", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum SpeedFile {
    /// Constant speed of the headstock, `work_speed_rpm`.
    #[default]
    ConstantWorkSpeed,
    /// Fastest turn with a constant speed of the contact along the contour, within all limits.
    ConstantFootprintSpeed {
        /// Speed of the contact along the contour.
        #[schemars(range(min = 1e-6, max = 1e6))]
        footprint_speed_mm_s: f64,
    },
    /// Fastest turn with at most this specific removal rate, within all limits.
    ConstantRemovalRate {
        /// Q', removed volume per width and time, for the infeed of a turn.
        #[schemars(range(min = 1e-6, max = 1e6))]
        removal_rate_mm2_s: f64,
    },
    /// Fastest turn with at most this specific removal rate by the published law ω = k/(ρ dφ/dC), which counts the infeed along the radius of
    /// the contour, within all limits. Not for crank pins.
    ConstantRadialRemovalRate {
        /// Q', removed volume per width and time, for the infeed of a turn.
        #[schemars(range(min = 1e-6, max = 1e6))]
        removal_rate_mm2_s: f64,
    },
    /// Fastest turn with at most this spindle power, within all limits.
    ConstantPower {
        /// Spindle power per width: specific energy * Q' + rubbing * contact length * wheel speed.
        #[schemars(range(min = 1e-6, max = 1e6))]
        power_w_mm: f64,
        /// Energy per removed volume.
        #[schemars(range(min = 1e-6, max = 1e6))]
        specific_energy_j_mm3: f64,
        /// Force of rubbing per contact area.
        #[schemars(range(min = 1e-6, max = 1e6))]
        rubbing_n_mm2: f64,
    },
    /// Fastest turn with at most the temperature of a reference cut that just does not burn, within all limits.
    ConstantTemperature {
        /// Speed of the contact in the reference cut.
        #[schemars(range(min = 1e-6, max = 1e6))]
        reference_footprint_speed_mm_s: f64,
        /// Depth of the reference cut along the normal.
        #[schemars(range(min = 1e-6, max = 1e6))]
        reference_depth_um: f64,
        /// Equivalent diameter 2/(1/R + curvature) of the reference cut.
        #[schemars(range(min = 1e-6, max = 1e6))]
        reference_equivalent_diameter_mm: f64,
    },
    /// Fastest turn within all limits of both axes.
    TimeOptimal,
}

/// Work speed that differs from turn to turn.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpeedVariationFile {
    /// Part of the work speed that is missing in the slower half of each period.
    #[schemars(range(min = 1.0, max = 75.0))]
    slower_percent: f64,
    /// Turns of the part in a period: half of it at the speed of the pass, half of it slower.
    #[schemars(range(min = VARIATION_PERIODS_TURNS.0, max = VARIATION_PERIODS_TURNS.1))]
    period_turns: f64,
}

impl SpeedVariationFile {
    pub(super) fn variation(self) -> SpeedVariation {
        SpeedVariation { slower: 0.01 * self.slower_percent, period_turns: self.period_turns }
    }
}

impl SpeedFile {
    fn law(&self, work_speed_rpm: f64) -> SpeedLaw {
        let max_rad_s = rad_s_from_rpm(work_speed_rpm);
        match *self {
            SpeedFile::ConstantWorkSpeed => SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: max_rad_s },
            SpeedFile::ConstantFootprintSpeed { footprint_speed_mm_s } => {
                SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s, max_rad_s }
            }
            SpeedFile::ConstantRemovalRate { removal_rate_mm2_s } => {
                SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, max_rad_s }
            }
            SpeedFile::ConstantRadialRemovalRate { removal_rate_mm2_s } => {
                SpeedLaw::ConstantRadialRemovalRate { removal_rate_mm2_s, max_rad_s }
            }
            SpeedFile::ConstantPower { power_w_mm, specific_energy_j_mm3, rubbing_n_mm2 } => {
                SpeedLaw::ConstantPower { power_w_mm, specific_energy_j_mm3, rubbing_n_mm2, max_rad_s }
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
                max_rad_s,
            },
            SpeedFile::TimeOptimal => SpeedLaw::TimeOptimal { max_rad_s },
        }
    }
}

/// A pass before the last one.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RoughingFile {
    /// Name of the pass.
    #[schemars(schema_with = "names::schema")]
    name: String,
    /// Infeed of the pass.
    infeed: InfeedFile,
    /// Speed of the headstock in the cut.
    #[schemars(range(min = 0.01, max = 95000.0))]
    work_speed_rpm: f64,
    /// Law of the headstock's speed over the lobe.
    #[serde(default)]
    speed: SpeedFile,
    /// Radius of the wheel that the pass needs. Default: the job's.
    #[schemars(range(min = 1e-6, max = 1e4))]
    wheel_radius_mm: Option<f64>,
    /// Name of the wheel of the machine's changer that grinds the pass. Default: the job's.
    wheel: Option<String>,
}

impl RoughingFile {
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Name of the wheel that grinds it.
    pub(super) fn wheel(&self) -> Option<&str> {
        self.wheel.as_deref()
    }

    /// The wheel it asks for, if it does.
    pub(super) fn wheel_radius_mm(&self) -> Option<f64> {
        self.wheel_radius_mm
    }
}

fn pass((name, infeed): (&str, &InfeedFile), work_speed_rpm: f64, speed: &SpeedFile, blocks_per_turn: u32) -> PassSpec {
    PassSpec {
        name: name.into(),
        total_infeed_mm: infeed.total_mm,
        infeed_per_block_mm: mm_from_um(infeed.per_block_um(blocks_per_turn)),
        infeed_of_turns_mm: infeed.of_turns_mm(),
        air_mm: 0.0,
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
        gauge_size: infeed.gauge_size.map(|size| SizeControl {
            ends_above_mm: mm_from_um(size.ends_above_um),
            beyond_mm: mm_from_um(size.beyond_um),
        }),
        speed: speed.law(work_speed_rpm),
    }
}

/// All passes in their order.
pub(super) fn passes(
    roughing: &[RoughingFile],
    infeed: &InfeedFile,
    work_speed_rpm: f64,
    speed: &SpeedFile,
    blocks_per_turn: u32,
) -> Vec<PassSpec> {
    let rough = roughing
        .iter()
        .map(|rough| pass((&rough.name, &rough.infeed), rough.work_speed_rpm, &rough.speed, blocks_per_turn));
    rough.chain([pass((LAST_PASS, infeed), work_speed_rpm, speed, blocks_per_turn)]).collect()
}

/// Errors of the passes: key and message.
pub(super) fn findings(roughing: &[RoughingFile], infeed: &InfeedFile) -> Vec<(String, String)> {
    let key = |index: usize| format!("roughing.{index}.infeed");
    let infeeds = roughing.iter().enumerate().map(|(index, rough)| (key(index), &rough.infeed));
    let infeeds = infeeds.chain([("infeed".to_owned(), infeed)]);
    let infeeds = infeeds.filter_map(|(key, infeed)| infeed.finding().map(|message| (key, message.to_owned())));
    pass_names(roughing).into_iter().chain(infeeds).collect()
}

/// Names of passes that are not unique: key and message.
fn pass_names(roughing: &[RoughingFile]) -> Vec<(String, String)> {
    let is_taken =
        |index: usize, name: &str| name == LAST_PASS || roughing[..index].iter().any(|other| other.name == name);
    let taken = roughing.iter().enumerate().filter(|(index, rough)| is_taken(*index, &rough.name));
    taken
        .map(|(index, RoughingFile { name, .. })| {
            let message = format!("there are two passes named {name}; names must differ (the last is {LAST_PASS})");
            (format!("roughing.{index}.name"), message)
        })
        .collect()
}
