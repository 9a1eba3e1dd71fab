//! The planner's parameters: the settings of the digital switches DS0 … DS7 of JPS6156064B2 and others, laid over the job
//! file. One that is not set leaves the file's value.

use camwright_files::{any_job, job_file};
use camwright_ros::{Parameter, ParameterValue, Parameters};

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
/// Folders of files that jobs and overrides over ROS may name besides their own.
pub(super) const FILE_FOLDERS: &str = "file_folders";

/// What a value may be.
#[derive(Debug, Clone, Copy)]
enum Allowed {
    Range(f64, f64),
    OneOf(&'static [&'static str]),
    Any,
}

/// A number above 0 that is not absurd.
const ABOVE_0: Allowed = Allowed::Range(1e-6, 1e6);
/// Work speeds (rpm).
const WORK_SPEED: Allowed = Allowed::Range(1e-3, 1e5);
/// Names of the speed laws of a job file.
const SPEED_LAWS: Allowed = Allowed::OneOf(&[
    "constant_work_speed",
    "constant_footprint_speed",
    "constant_removal_rate",
    "constant_power",
    "constant_temperature",
    "time_optimal",
]);
/// What C does between lobes.
const BETWEEN_LOBES: Allowed = Allowed::OneOf(&["stops", "turns_on"]);

/// Parameters that carry the name of the key they override: type, range, text.
const KEYS: [(&str, ParameterValue, Allowed, &str); 23] = [
    ("rapid_advance_mm", ParameterValue::Double(0.0), ABOVE_0, "R0, rapid advance (mm)"),
    ("rapid_speed_mm_s", ParameterValue::Double(0.0), ABOVE_0, "F0, speed of the rapid advance (mm/s)"),
    ("infeed.total_mm", ParameterValue::Double(0.0), ABOVE_0, "RT, total infeed (mm)"),
    ("infeed.per_block_um", ParameterValue::Double(0.0), ABOVE_0, "delta R, infeed per block (um)"),
    ("infeed.spark_out_turns", ParameterValue::Integer(0), Allowed::Range(1.0, 1e6), "turns without infeed"),
    (
        "work_speed_rpm",
        ParameterValue::Double(0.0),
        WORK_SPEED,
        "speed of the headstock in the cut, its largest with another speed law (rpm)",
    ),
    (
        "speed.law",
        ParameterValue::String(String::new()),
        SPEED_LAWS,
        "how the speed of the headstock follows the contact",
    ),
    (
        "speed.footprint_speed_mm_s",
        ParameterValue::Double(0.0),
        ABOVE_0,
        "speed of the contact along the contour (mm/s), with its law",
    ),
    ("speed.removal_rate_mm2_s", ParameterValue::Double(0.0), ABOVE_0, "specific removal rate (mm2/s), with its law"),
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
    ("dressing.every_lobes", ParameterValue::Integer(0), Allowed::Range(1.0, 1e6), "lobes from dress to dress"),
    ("dressing.every_parts", ParameterValue::Integer(0), Allowed::Range(1.0, 1e6), "parts from dress to dress"),
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
        Allowed::Range(0.0, 1e3),
        "how far the wheel keeps from everything but the lobe it grinds (mm)",
    ),
    (
        "c_between_lobes",
        ParameterValue::String(String::new()),
        BETWEEN_LOBES,
        "stops, or turns_on: the next cut begins at the phase with which C is predicted to arrive",
    ),
    (
        "arrival_margin_ms",
        ParameterValue::Double(0.0),
        Allowed::Range(0.0, 1e3),
        "how much later than predicted the table may arrive without the phase being missed (ms)",
    ),
    (
        "rotary_indexing",
        ParameterValue::Bool(false),
        Allowed::Any,
        "the conventional way: the part is turned to each lobe's base first",
    ),
];

/// A key as a parameter that is not set at first.
fn declared(name: &str, example: &ParameterValue, allowed: Allowed, text: &str) -> Parameter {
    let parameter = Parameter::optional(name, example.clone()).describe(&format!("{text}; not set: the job file's"));
    match (allowed, example) {
        #[allow(clippy::cast_possible_truncation, reason = "the bounds above are small whole numbers")]
        (Allowed::Range(low, high), ParameterValue::Integer(_)) => parameter.integer_range(low as i64, high as i64),
        (Allowed::Range(low, high), _) => parameter.range(low, high),
        (Allowed::OneOf(choices), _) => parameter.choices(choices),
        (Allowed::Any, _) => parameter,
    }
}

/// What the node declares.
pub(super) fn parameters() -> Vec<Parameter> {
    let mut parameters = vec![
        Parameter::string(JOB, "four_lobe_camshaft").describe("job that runs when a goal names none, by name or path"),
    ];
    parameters.extend(KEYS.iter().map(|(name, example, allowed, text)| declared(name, example, *allowed, text)));
    parameters.push(
        Parameter::optional(PHASES, ParameterValue::DoubleArray(Vec::new()))
            .describe("phase angles alpha 1 ... alpha n of the lobes in their order (deg); not set: the job file's")
            .constraints("one angle for each lobe of the job")
            .range(-360.0, 360.0),
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
    parameters.push(
        Parameter::string_array(FILE_FOLDERS, &[])
            .describe("folders of files that overrides over ROS may name, besides those of the job and of params")
            .read_only(),
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

/// Refuses what no job could take.
///
/// The number of phases is compared with the job that the parameters name, as it is now or after the change. The job of a goal is
/// compared when it is planned.
pub(super) fn validate(parameters: &Parameters, changes: &[(String, ParameterValue)]) -> Result<(), String> {
    for (name, value) in changes {
        match value {
            ParameterValue::StringArray(pairs) if name == OVERRIDES => {
                let is_pair = |pair: &String| pair.split_once('=').is_some_and(|(key, _)| !key.trim().is_empty());
                if let Some(pair) = pairs.iter().find(|pair| !is_pair(pair)) {
                    return Err(format!("parameter 'overrides' has the element {pair:?}; each must be key=value"));
                }
            }
            ParameterValue::DoubleArray(phases) if name == PHASES => {
                let changed = changes.iter().rev().find(|(name, _)| name == JOB).map(|(_, job)| job.clone());
                if let Some(ParameterValue::String(job)) = changed.or_else(|| parameters.get(JOB)) {
                    check_phases(phases, &job, &[])?;
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// Refuses phases that are not one for each lobe of a job. A job that cannot be read is judged when it is planned.
fn check_phases(phases: &[f64], job: &str, overrides: &[String]) -> Result<(), String> {
    if phases.is_empty() || any_job::turns(job, overrides) {
        return Ok(());
    }
    let Ok(read) = job_file::load(job, overrides) else { return Ok(()) };
    let (given, lobes) = (phases.len(), read.spec.lobes.len());
    if given == lobes {
        return Ok(());
    }
    Err(format!(
        "parameter 'phases_deg' has {given} angles, and job {job} has {lobes} lobes; give one angle for each lobe"
    ))
}

/// Refuses what the parameters ask of a job that it cannot take.
pub(super) fn check_against_job(parameters: &Parameters, job: &str, of_request: &[String]) -> Result<(), String> {
    let Some(ParameterValue::DoubleArray(phases)) = parameters.get(PHASES) else { return Ok(()) };
    check_phases(&phases, job, of_request)
}

/// The parameters as overrides of a job file, those of a goal after them: later ones win.
pub(super) fn overrides(parameters: &Parameters, of_goal: &[String]) -> Vec<String> {
    let mut overrides = overrides_by_key(|name| parameters.get(name));
    overrides.extend(parameters.string_array(OVERRIDES));
    overrides.extend_from_slice(of_goal);
    overrides
}

/// What the parameters with the name of a key say.
fn overrides_by_key(value_of: impl Fn(&str) -> Option<ParameterValue>) -> Vec<String> {
    let mut overrides = Vec::new();
    for (name, ..) in &KEYS {
        match value_of(name) {
            // The debug form keeps the point that makes a YAML number a float.
            Some(ParameterValue::Double(value)) => overrides.push(format!("{name}={value:?}")),
            Some(ParameterValue::Integer(value)) => overrides.push(format!("{name}={value}")),
            Some(ParameterValue::Bool(value)) => overrides.push(format!("{name}={value}")),
            Some(ParameterValue::String(value)) => overrides.push(format!("{name}={value}")),
            _ => {}
        }
    }
    if let Some(ParameterValue::DoubleArray(phases)) = value_of(PHASES) {
        overrides.extend(phases.iter().enumerate().map(|(index, phase)| format!("lobes.{index}.phase_deg={phase:?}")));
    }
    overrides
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let same_law = |other: &&(&str, ParameterValue, Allowed, &str)| {
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

    #[test]
    fn phases_are_one_for_each_lobe() {
        assert_eq!(check_phases(&[0.0, 90.0, 180.0, 270.0], "four_lobe_camshaft", &[]), Ok(()));
        assert_eq!(check_phases(&[], "four_lobe_camshaft", &[]), Ok(()), "the job file's");
        let refused = check_phases(&[0.0, 90.0], "four_lobe_camshaft", &[]).expect_err("four lobes");
        assert!(refused.contains("2 angles") && refused.contains("4 lobes"), "{refused}");
    }

    /// Every declared key reaches the job, whatever its type.
    #[test]
    fn every_parameter_that_is_set_becomes_an_override() {
        let example = |name: &str| KEYS.iter().find(|key| key.0 == name).map(|key| key.1.clone());
        let set = overrides_by_key(|name| match (name, example(name)?) {
            ("speed.law", _) => Some(ParameterValue::String("time_optimal".into())),
            ("c_between_lobes", _) => Some(ParameterValue::String("turns_on".into())),
            (_, value) => Some(value),
        });
        for (name, ..) in KEYS {
            assert!(set.iter().any(|pair| pair.starts_with(&format!("{name}="))), "{name} is not in {set:?}");
        }
        let job = ["speed.law=time_optimal", "c_between_lobes=turns_on"];
        assert!(job.iter().all(|pair| set.iter().any(|found| found == pair)), "{set:?}");
        job_file::load("four_lobe_camshaft", &job.map(str::to_owned)).expect("the job takes them");
    }
}
