//! The planner's parameters: the settings of the digital switches DS0 … DS7 of JPS6156064B2 and others, laid over the job
//! file. One that is not set leaves the file's value.

use crate::ros::{Parameter, ParameterValue, Parameters};

/// Job that runs when a goal names none and none is loaded.
pub(super) const JOB: &str = "job";
/// Where what was learned is kept.
pub(super) const LEARNED_DIR: &str = "learned_dir";
/// Parts of a run of the cell where START says none.
pub(super) const CELL_PARTS: &str = "cell_parts";
/// Longest silence of the loader (s).
pub(super) const LOADER_TIMEOUT: &str = "loader_timeout_s";
/// Longest times of the steps of loading (s).
pub(super) const LOADING_MACHINE: &str = "loading_machine_s";
pub(super) const LOADING_ENTER: &str = "loading_enter_s";
pub(super) const LOADING_INSIDE: &str = "loading_inside_s";
const PHASES: &str = "phases_deg";
const OVERRIDES: &str = "overrides";

/// What a number may be; anything, where nothing is said.
type Range = Option<(f64, f64)>;

/// A number above 0 that is not absurd.
const ABOVE_0: Range = Some((1e-6, 1e6));

/// Parameters that carry the name of the key they override: type, range, text.
const KEYS: [(&str, ParameterValue, Range, &str); 23] = [
    ("rapid_advance_mm", ParameterValue::Double(0.0), None, "R0, rapid advance (mm)"),
    ("rapid_speed_mm_s", ParameterValue::Double(0.0), None, "F0, speed of the rapid advance (mm/s)"),
    ("infeed.total_mm", ParameterValue::Double(0.0), None, "RT, total infeed (mm)"),
    ("infeed.per_block_um", ParameterValue::Double(0.0), None, "delta R, infeed per block (um)"),
    ("infeed.spark_out_turns", ParameterValue::Integer(0), None, "turns without infeed"),
    (
        "work_speed_rpm",
        ParameterValue::Double(0.0),
        None,
        "speed of the headstock in the cut, its largest with another speed law (rpm)",
    ),
    (
        "speed.law",
        ParameterValue::String(String::new()),
        None,
        "constant_work_speed, constant_footprint_speed, constant_removal_rate, constant_power, constant_temperature or \
         time_optimal",
    ),
    (
        "speed.footprint_speed_mm_s",
        ParameterValue::Double(0.0),
        None,
        "speed of the contact along the contour (mm/s), with its law",
    ),
    ("speed.removal_rate_mm2_s", ParameterValue::Double(0.0), None, "specific removal rate (mm2/s), with its law"),
    (
        "speed.power_w_mm",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "with constant_power: power of the wheel spindle per width (W/mm)",
    ),
    (
        "speed.specific_energy_j_mm3",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "with constant_power: energy that a removed volume takes (J/mm3)",
    ),
    (
        "speed.rubbing_n_mm2",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "with constant_power: force of rubbing per area of contact (N/mm2)",
    ),
    (
        "speed.reference_footprint_speed_mm_s",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "with constant_temperature: speed of the contact in a cut that just does not burn (mm/s)",
    ),
    (
        "speed.reference_depth_um",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "with constant_temperature: depth of that cut along the normal (um)",
    ),
    (
        "speed.reference_equivalent_diameter_mm",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "with constant_temperature: its equivalent diameter 2/(1/R + curvature) (mm)",
    ),
    ("dressing.every_lobes", ParameterValue::Integer(0), Some((1.0, 1e6)), "lobes from dress to dress"),
    ("dressing.every_parts", ParameterValue::Integer(0), Some((1.0, 1e6)), "parts from dress to dress"),
    (
        "dressing.predicted_error_um",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "largest form error by wear that a lobe may be ground with (um)",
    ),
    ("dressing.depth_um", ParameterValue::Double(0.0), ABOVE_0, "what a dress takes off the wheel's radius (um)"),
    (
        "clearance_mm",
        ParameterValue::Double(0.0),
        Some((0.0, 1e3)),
        "how far the wheel keeps from everything but the lobe it grinds (mm)",
    ),
    (
        "c_between_lobes",
        ParameterValue::String(String::new()),
        None,
        "stops, or turns_on: the next cut begins at the phase with which C is predicted to arrive",
    ),
    (
        "arrival_margin_ms",
        ParameterValue::Double(0.0),
        Some((0.0, 1e3)),
        "how much later than predicted the table may arrive without the phase being missed (ms)",
    ),
    (
        "rotary_indexing",
        ParameterValue::Bool(false),
        None,
        "the conventional way: the part is turned to each lobe's base first",
    ),
];

/// A key as a parameter that is not set at first.
fn declared(name: &str, example: &ParameterValue, range: Range, text: &str) -> Parameter {
    let parameter = Parameter::optional(name, example.clone()).describe(&format!("{text}; not set: the job file's"));
    match (range, example) {
        #[allow(clippy::cast_possible_truncation, reason = "the bounds above are small whole numbers")]
        (Some((low, high)), ParameterValue::Integer(_)) => parameter.integer_range(low as i64, high as i64),
        (Some((low, high)), _) => parameter.range(low, high),
        (None, _) => parameter,
    }
}

/// What the node declares.
pub(super) fn parameters() -> Vec<Parameter> {
    let mut parameters = vec![
        Parameter::string(JOB, "four_lobe_camshaft").describe("job that runs when a goal names none, by name or path"),
    ];
    parameters.extend(KEYS.iter().map(|(name, example, range, text)| declared(name, example, *range, text)));
    parameters.push(
        Parameter::optional(PHASES, ParameterValue::DoubleArray(Vec::new()))
            .describe("phase angles alpha 1 ... alpha n of the lobes in their order (deg); not set: the job file's"),
    );
    parameters.push(
        Parameter::string(LEARNED_DIR, "")
            .describe("directory of what jobs with form_compensation learned and of the stiffness that was measured; empty: the user's state \
                 directory; 'none': nowhere, it lasts as long as the node")
            .read_only(),
    );
    parameters.push(
        Parameter::string_array(OVERRIDES, &[])
            .describe("key=value pairs over any key of the job file")
            .constraints("each element has the form key=value"),
    );
    parameters.extend(of_the_cell());
    parameters
}

/// What the cell as a whole declares.
fn of_the_cell() -> [Parameter; 5] {
    let seconds =
        |name: &str, default: f64, text: &str| Parameter::double(name, default).describe(text).range(0.1, 1e5);
    [
        Parameter::integer(CELL_PARTS, 1)
            .describe("parts of a run where START says none; 0: until it is stopped")
            .integer_range(0, 1_000_000),
        seconds(LOADER_TIMEOUT, 1.0, "longest silence of the loader on loader/state (s)"),
        seconds(LOADING_MACHINE, 60.0, "longest time until wheel, axes and door are ready to be loaded (s)"),
        seconds(LOADING_ENTER, 120.0, "longest time from the leave to enter until the loader is inside (s)"),
        seconds(LOADING_INSIDE, 300.0, "longest time for its work, until the loader has left (s)"),
    ]
}

/// Refuses what could never be an override.
pub(super) fn validate(changes: &[(String, ParameterValue)]) -> Result<(), String> {
    for (name, value) in changes {
        match value {
            ParameterValue::StringArray(pairs) if name == OVERRIDES => {
                if let Some(pair) = pairs.iter().find(|pair| !pair.contains('=')) {
                    return Err(format!("override {pair:?} has no '='"));
                }
            }
            ParameterValue::Double(value) if !value.is_finite() => {
                return Err(format!("{name} is {value}, not a number"));
            }
            ParameterValue::DoubleArray(values) if values.iter().any(|value| !value.is_finite()) => {
                return Err(format!("{name} has an element that is not a number"));
            }
            _ => {}
        }
    }
    Ok(())
}

/// The parameters as overrides of a job file, those of a goal after them: later ones win.
pub(super) fn overrides(parameters: &Parameters, of_goal: &[String]) -> Vec<String> {
    let mut overrides = Vec::new();
    for (name, _, _, _) in &KEYS {
        match parameters.get(name) {
            // The debug form keeps the point that makes a YAML number a float.
            Some(ParameterValue::Double(value)) => overrides.push(format!("{name}={value:?}")),
            Some(ParameterValue::Integer(value)) => overrides.push(format!("{name}={value}")),
            Some(ParameterValue::Bool(value)) => overrides.push(format!("{name}={value}")),
            _ => {}
        }
    }
    if let Some(ParameterValue::DoubleArray(phases)) = parameters.get(PHASES) {
        overrides.extend(phases.iter().enumerate().map(|(index, phase)| format!("lobes.{index}.phase_deg={phase:?}")));
    }
    overrides.extend(parameters.string_array(OVERRIDES));
    overrides.extend_from_slice(of_goal);
    overrides
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::job_file;

    /// Every key that a parameter lays over a job file is one of its keys.
    #[test]
    fn every_parameter_is_a_key_of_the_job_file() {
        let laws = [
            ("speed.power", "constant_power"),
            ("speed.specific", "constant_power"),
            ("speed.rubbing", "constant_power"),
            ("speed.reference", "constant_temperature"),
            ("speed.footprint", "constant_footprint_speed"),
            ("speed.removal", "constant_removal_rate"),
        ];
        for (name, example, _, _) in KEYS {
            let law = laws.iter().find(|(prefix, _)| name.starts_with(prefix)).map(|(_, law)| *law);
            let same_law = |other: &&(&str, ParameterValue, Range, &str)| {
                law.is_some_and(|law| laws.iter().any(|(prefix, of)| other.0.starts_with(prefix) && *of == law))
            };
            let mut set: Vec<String> = KEYS.iter().filter(same_law).map(|key| format!("{}=1.5", key.0)).collect();
            set.extend(law.map(|law| format!("speed.law={law}")));
            if name.starts_with("dressing") {
                set.push("dressing.depth_um=3.0".into());
            }
            match example {
                ParameterValue::Double(_) => set.push(format!("{name}=1.5")),
                ParameterValue::Integer(_) => set.push(format!("{name}=2")),
                ParameterValue::Bool(_) => set.push(format!("{name}=true")),
                _ => set.push("speed.law=time_optimal".into()),
            }
            job_file::load("four_lobe_camshaft", &set).unwrap_or_else(|error| panic!("{name}: {error}"));
        }
    }
}
