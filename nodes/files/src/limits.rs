// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Limits of the work that a file can request: bounds on lists, turns and time, each far beyond every real job, so that a mistyped digit
//! is refused with its reason before any work begins. `docs/reference/files.md` lists them, with those of the core and of the readers.

/// Longest job (s): a day. Every 1 ms of it is a setpoint; the shipped jobs take minutes.
pub const MAX_JOB_S: f64 = 86_400.0;

/// Error text if the minimum time of the cuts is too long; `None`: it is acceptable.
pub(super) fn too_long(min_s: f64) -> Option<String> {
    // NaN is found elsewhere, with the key that brings it.
    (min_s > MAX_JOB_S).then(|| {
        format!(
            "the cuts take at least {min_s:.3e} s; a job may take {MAX_JOB_S} s, a day: a faster work_speed_rpm, or fewer turns"
        )
    })
}
