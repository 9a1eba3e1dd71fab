//! What a file may ask for: bounds on lists, turns and time, each far beyond every real job, so that a mistyped digit is refused with its
//! reason before any work begins. `params/README.md` lists them, with those of the core and of the readers.

/// Most lobes, profiles, passes, obstacles and faults of a job. Each lobe is planned for each pass; a camshaft of 16 cylinders has 64 lobes.
pub(crate) const MAX_LIST: usize = 100;

/// Most turns without infeed of a pass: as many as turns with infeed may be.
pub(crate) const MAX_SPARK_OUT_TURNS: u32 = 1000;

/// Longest job (s): a day. Every 1 ms of it is a setpoint; the shipped jobs take minutes.
pub const MAX_JOB_S: f64 = 86_400.0;

/// Lists of a file that are too long: key and message.
pub(super) fn long_lists<'a>(lists: impl IntoIterator<Item = (&'a str, usize)>) -> Vec<(String, String)> {
    let is_long = |(_, count): &(&str, usize)| *count > MAX_LIST;
    let refuse = |(key, count): (&str, usize)| {
        (key.to_owned(), format!("{key} has {count} entries; at most {MAX_LIST} are allowed"))
    };
    lists.into_iter().filter(is_long).map(refuse).collect()
}

/// What is wrong with the time that cuts take at least, as a sentence; `None`: nothing.
pub(super) fn too_long(least_s: f64) -> Option<String> {
    // NaN is found elsewhere, with the key that brings it.
    (least_s > MAX_JOB_S).then(|| {
        format!(
            "the cuts take at least {least_s:.3e} s; a job may take {MAX_JOB_S} s, a day: a faster work_speed_rpm, or fewer turns"
        )
    })
}
