//! The planner's parameters: the settings of the digital switches DS0 … DS7 of JPS6156064B2 and others, laid over the job
//! file. One that is not set leaves the file's value.

use crate::ros::{Parameter, ParameterValue, Parameters};

/// Job that runs when a goal names none and none is loaded.
pub(super) const JOB: &str = "job";
const PHASES: &str = "phases_deg";
const OVERRIDES: &str = "overrides";

/// Parameters that carry the name of the key they override.
const KEYS: [(&str, ParameterValue, &str); 10] = [
    ("rapid_advance_mm", ParameterValue::Double(0.0), "R0, rapid advance (mm); not set: the job file's"),
    ("rapid_speed_mm_s", ParameterValue::Double(0.0), "F0, speed of the rapid advance (mm/s); not set: the job file's"),
    ("infeed.total_mm", ParameterValue::Double(0.0), "RT, total infeed (mm); not set: the job file's"),
    ("infeed.per_block_um", ParameterValue::Double(0.0), "delta R, infeed per block (um); not set: the job file's"),
    ("infeed.spark_out_turns", ParameterValue::Integer(0), "turns without infeed; not set: the job file's"),
    (
        "work_speed_rpm",
        ParameterValue::Double(0.0),
        "speed of the headstock in the cut, its largest with another speed law (rpm); not set: the job file's",
    ),
    (
        "speed.law",
        ParameterValue::String(String::new()),
        "constant_work_speed, constant_footprint_speed, constant_removal_rate, constant_power, constant_temperature or \
         time_optimal; not set: the job file's",
    ),
    (
        "speed.footprint_speed_mm_s",
        ParameterValue::Double(0.0),
        "speed of the contact along the contour (mm/s), with its law; not set: the job file's",
    ),
    (
        "speed.removal_rate_mm2_s",
        ParameterValue::Double(0.0),
        "specific removal rate (mm2/s), with its law; not set: the job file's",
    ),
    (
        "rotary_indexing",
        ParameterValue::Bool(false),
        "the conventional way: the part is turned to each lobe's base first; not set: the job file's",
    ),
];

/// What the node declares.
pub(super) fn parameters() -> Vec<Parameter> {
    let mut parameters = vec![
        Parameter::string(JOB, "four_lobe_camshaft").describe("job that runs when a goal names none, by name or path"),
    ];
    parameters
        .extend(KEYS.iter().map(|(name, example, text)| Parameter::optional(name, example.clone()).describe(text)));
    parameters.push(
        Parameter::optional(PHASES, ParameterValue::DoubleArray(Vec::new()))
            .describe("phase angles alpha 1 ... alpha n of the lobes in their order (deg); not set: the job file's"),
    );
    parameters.push(
        Parameter::string_array(OVERRIDES, &[])
            .describe("key=value pairs over any key of the job file")
            .constraints("each element has the form key=value"),
    );
    parameters
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
    for (name, _, _) in &KEYS {
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
