// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The planner's parameters: the settings of the digital switches DS0 … DS7 of JPS6156064B2 and others, laid over the job
//! file. One that is not set leaves the file's value.

use camwright_files::file_kind::FileKind;
use camwright_files::schema::{self, Key, Range};
use camwright_files::{any_job, job_file};
use camwright_ros::{Parameter, ParameterValue, Parameters};

/// Job that runs when a goal names none and none is loaded.
pub(super) const JOB: &str = "job";
/// Folder of learned corrections.
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
/// Folders of files that jobs and overrides over ROS may name in addition to their own.
pub(super) const FILE_FOLDERS: &str = "file_folders";

/// Keys of a job file that a parameter of the same name overrides.
const KEYS: [&str; 24] = [
    "rapid_advance_mm",
    "rapid_speed_mm_s",
    "infeed.total_mm",
    "infeed.per_block_um",
    "infeed.per_turn_um",
    "infeed.spark_out_turns",
    "work_speed_rpm",
    "speed.law",
    "speed.footprint_speed_mm_s",
    "speed.removal_rate_mm2_s",
    "speed.power_w_mm",
    "speed.specific_energy_j_mm3",
    "speed.rubbing_n_mm2",
    "speed.reference_footprint_speed_mm_s",
    "speed.reference_depth_um",
    "speed.reference_equivalent_diameter_mm",
    "dressing.every_lobes",
    "dressing.every_parts",
    "dressing.predicted_error_um",
    "dressing.depth_um",
    "clearance_mm",
    "c_between_lobes",
    "arrival_margin_ms",
    "rotary_indexing",
];

/// A key of the job file as a parameter without a value: type, range, choices and text are those of the key.
fn declared(key: &Key) -> Parameter {
    let example = match key.kind.as_str() {
        "a whole number" => ParameterValue::Integer(0),
        // A list is set by a parameter of its own, `overrides`.
        "a number" | schema::NUMBER_OR_LIST => ParameterValue::Double(0.0),
        "true or false" => ParameterValue::Bool(false),
        _ => ParameterValue::String(String::new()),
    };
    let unit = if key.unit().is_empty() { String::new() } else { format!(" ({})", key.unit()) };
    let text = format!("{}{unit}; not set: the value of the job file", key.description.trim_end_matches('.'));
    let parameter = Parameter::optional(&key.path, example.clone()).describe(&text);
    match (example, key.range) {
        #[allow(clippy::cast_possible_truncation, reason = "ranges of whole numbers are whole and small")]
        (ParameterValue::Integer(_), Range { min: Some(low), max: Some(high) }) => {
            parameter.integer_range(low as i64, high as i64)
        }
        (ParameterValue::Double(_), Range { min: Some(low), max: Some(high) }) => parameter.range(low, high),
        (ParameterValue::String(_), _) => parameter.choices(&key.words.iter().map(String::as_str).collect::<Vec<_>>()),
        _ => parameter,
    }
}

/// Parameters of the node.
pub(super) fn parameters() -> Vec<Parameter> {
    let mut parameters =
        vec![Parameter::string(JOB, "four_lobe_camshaft").describe("job of a goal without a job, by name or path")];
    let keys = schema::keys(&FileKind::Job.schema());
    parameters.extend(keys.iter().filter(|key| KEYS.contains(&key.path.as_str())).map(declared));
    parameters.push(
        Parameter::optional(PHASES, ParameterValue::DoubleArray(Vec::new()))
            .describe("phase angles alpha 1 ... alpha n of the lobes in their order (deg); not set: the value of the job file")
            .constraints("one angle for each lobe of the job")
            .range(-360.0, 360.0),
    );
    parameters.push(
        Parameter::string(LEARNED_DIR, "")
            .describe("directory for learned form compensation and measured stiffness; empty: the user's state directory; 'none': memory only")
            .read_only(),
    );
    parameters.push(
        Parameter::string_array(OVERRIDES, &[])
            .describe("key=value pairs over any key of the job file")
            .constraints("each element has the form key=value"),
    );
    parameters.push(
        Parameter::string_array(FILE_FOLDERS, &[])
            .describe(
                "folders of files that overrides over ROS may name, in addition to those of the job and of params",
            )
            .read_only(),
    );
    parameters.extend(cell_parameters());
    parameters
}

/// Parameters of the cell.
fn cell_parameters() -> [Parameter; 5] {
    let seconds =
        |name: &str, default: f64, text: &str| Parameter::double(name, default).describe(text).range(0.1, 1e5);
    [
        Parameter::integer(CELL_PARTS, 1)
            .describe("default number of parts for START; 0: until stopped")
            .integer_range(0, 1_000_000),
        seconds(LOADER_TIMEOUT, 1.0, "maximum silence of the loader on loader/state (s)"),
        seconds(LOADING_MACHINE, 60.0, "maximum time until wheel, axes and door are ready for loading (s)"),
        seconds(LOADING_ENTER, 120.0, "maximum time from permission to entry of the loader (s)"),
        seconds(LOADING_INSIDE, 300.0, "maximum time of the loader in the work area (s)"),
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

/// Overrides from parameters that have the name of a key.
fn overrides_by_key(value_of: impl Fn(&str) -> Option<ParameterValue>) -> Vec<String> {
    let mut overrides = Vec::new();
    for name in &KEYS {
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

    #[test]
    fn every_parameter_is_a_key_of_the_job_file() {
        let keys = schema::keys(&FileKind::Job.schema());
        for name in KEYS {
            let key = keys.iter().find(|key| key.path == name).unwrap_or_else(|| panic!("{name} is not a key"));
            assert!(!key.description.is_empty(), "{name}");
            let has_range = key.range.min.is_some() && key.range.max.is_some();
            assert!(has_range || !key.words.is_empty() || key.kind == "true or false", "{name} has no range");
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
        let set = overrides_by_key(|name| match name {
            "speed.law" => Some(ParameterValue::String("time_optimal".into())),
            "c_between_lobes" => Some(ParameterValue::String("turns_on".into())),
            "rotary_indexing" => Some(ParameterValue::Bool(false)),
            _ => Some(ParameterValue::Double(1.5)),
        });
        for name in KEYS {
            assert!(set.iter().any(|pair| pair.starts_with(&format!("{name}="))), "{name} is not in {set:?}");
        }
        let job = ["speed.law=time_optimal", "c_between_lobes=turns_on"];
        assert!(job.iter().all(|pair| set.iter().any(|found| found == pair)), "{set:?}");
        job_file::load("four_lobe_camshaft", &job.map(str::to_owned)).expect("the job takes them");
    }
}
