// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sends and receives chunks of setpoints over DDS or Zenoh, for `figures.py`.
//!
//! ```text
//! zenoh_spike router CONFIG
//! zenoh_spike send|receive dds|CONFIG COUNT [latched]
//! ```
//!
//! `CONFIG` is a configuration of Zenoh (JSON5); the domain is `ROS_DOMAIN_ID`. A router and a sender end with their standard input. A sender
//! sends `COUNT` chunks for each line that it reads. A receiver prints number, sent (ns) and received (ns) of each chunk.

mod chunk;
#[cfg(feature = "dds")]
mod dds;
#[cfg(feature = "zenoh")]
mod format;
#[cfg(feature = "zenoh")]
mod over_zenoh;

use std::process::ExitCode;

/// Settings of a role.
pub struct Task {
    pub config: String,
    pub count: usize,
    /// Late joiners get the last chunks.
    pub latched: bool,
}

pub type Outcome = Result<(), Box<dyn std::error::Error + Send + Sync>>;

fn run(words: &[&str]) -> Outcome {
    let task = |config: &str, count: &str, more: &[&str]| -> Result<Task, String> {
        let count = count.parse().map_err(|_| format!("count `{count}` is not a whole number"))?;
        Ok(Task { config: config.into(), count, latched: more == ["latched"] })
    };
    match words {
        #[cfg(feature = "zenoh")]
        ["router", config] => over_zenoh::route(config),
        #[cfg(feature = "dds")]
        ["send", "dds", count, more @ ..] => dds::send(&task("dds", count, more)?),
        #[cfg(feature = "dds")]
        ["receive", "dds", count, more @ ..] => dds::receive(&task("dds", count, more)?),
        #[cfg(feature = "zenoh")]
        ["send", config, count, more @ ..] => over_zenoh::send(&task(config, count, more)?),
        #[cfg(feature = "zenoh")]
        ["receive", config, count, more @ ..] => over_zenoh::receive(&task(config, count, more)?),
        _ => Err("usage: zenoh_spike router CONFIG | send|receive dds|CONFIG COUNT [latched]".into()),
    }
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match run(&words.iter().map(String::as_str).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
