// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Homing of a slide in a machine file.

use super::ConfigError;
use super::yaml::Document;
use camwright::machine::description::{DescriptionError, Homing, MachineDescription};
use schemars::JsonSchema;
use serde::Deserialize;

/// The homing of a slide; see [`Homing`].
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct HomingFile {
    /// Search for the switch, as `HOME_SEARCH_VEL` of LinuxCNC: its sign is the direction; 0: no search.
    #[schemars(range(min = -1e4, max = 1e4))]
    #[serde(default)]
    search_velocity_mm_s: f64,
    /// Latch at the edge, as `HOME_LATCH_VEL` of LinuxCNC. Same sign as the search: back off, then latch where the
    /// switch closes; other sign: latch where it opens.
    #[schemars(range(min = -1e4, max = 1e4))]
    #[serde(default)]
    latch_velocity_mm_s: f64,
    /// Speed of the travel to `home_mm`. Default: the speed limit of the axis.
    #[schemars(range(min = 1e-3, max = 1e4))]
    final_velocity_mm_s: Option<f64>,
    /// Continues to the next index mark of the encoder.
    #[serde(default)]
    use_index: bool,
    /// Reading at the edge or mark. Required for an index without a switch. Default: the position of edge or
    /// mark.
    #[schemars(range(min = -1e5, max = 1e5))]
    offset_mm: Option<f64>,
    /// Position after homing; within the soft limits.
    #[schemars(range(min = -1e5, max = 1e5))]
    home_mm: f64,
    /// Uses the hard limit switch as the home switch.
    #[serde(default)]
    ignore_limits: bool,
    /// Order of homing, smaller numbers first; `c_axis` follows the slides.
    #[serde(default)]
    sequence: u32,
    /// Position at which the simulated switch closes.
    #[schemars(range(min = -1e5, max = 1e5))]
    #[serde(default)]
    switch_mm: f64,
    /// Distance of the index marks.
    #[schemars(range(min = 0.0, max = 1e4))]
    #[serde(default)]
    index_pitch_mm: f64,
}

impl HomingFile {
    /// The homing of an axis whose largest speed this is (mm/s).
    pub(super) fn homing(&self, fastest_mm_s: f64) -> Homing {
        Homing {
            search_mm_s: self.search_velocity_mm_s,
            latch_mm_s: self.latch_velocity_mm_s,
            final_mm_s: self.final_velocity_mm_s.unwrap_or(fastest_mm_s),
            use_index: self.use_index,
            offset_mm: self.offset_mm,
            home_mm: self.home_mm,
            ignore_limits: self.ignore_limits,
            sequence: self.sequence,
            switch_mm: self.switch_mm,
            index_pitch_mm: self.index_pitch_mm,
        }
    }
}

/// Refuses a homing that is none, or that does not fit its axis, at its place in the file.
pub(super) fn check(document: &Document, machine: &MachineDescription) -> Result<(), ConfigError> {
    match machine.validate() {
        Err(error @ (DescriptionError::Homing { joint, .. } | DescriptionError::HomingOutside { joint, .. })) => {
            Err(document.error(&format!("{joint}.home"), error.to_string()))
        }
        // The functions that read the other keys report their errors.
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use crate::{locate, machine_file};

    fn read(home: &str) -> Result<machine_file::MachineConfig, String> {
        let located = locate::locate("machines", "cam_grinder", "yaml", None).expect("a shipped machine");
        let overrides = [format!("x_axis.home={home}")];
        machine_file::parse(&located.path, &located.text, &overrides).map_err(|error| error.to_string())
    }

    #[test]
    fn a_homing_is_read_and_one_that_is_none_is_refused() {
        let good = "{search_velocity_mm_s: 20, latch_velocity_mm_s: -1, switch_mm: 175, home_mm: 150, use_index: true, \
                    index_pitch_mm: 8}";
        let machine = read(good).expect("a homing").description;
        let homing = machine.axes[1].homing.expect("it is homed");
        assert!(
            machine.axes[1].needs_homing && homing.final_mm_s.to_bits() == machine.axes[1].limits.velocity.to_bits()
        );
        for (home, expected) in [
            (
                "{search_velocity_mm_s: 20, switch_mm: 175, home_mm: 150}",
                "search and latch velocity and use_index must be",
            ),
            ("{latch_velocity_mm_s: 1, home_mm: 150}", "search and latch velocity and use_index must be"),
            ("{home_mm: 1500}", "its home position is 1500; the axis allows "),
            (
                "{search_velocity_mm_s: 20, latch_velocity_mm_s: 1, switch_mm: 400, home_mm: 150}",
                "without ignore_limits",
            ),
            (
                "{latch_velocity_mm_s: 1, use_index: true, index_pitch_mm: 8, home_mm: 150}",
                "index only needs an offset",
            ),
        ] {
            let refused = read(home).expect_err("no homing");
            assert!(refused.contains(expected) && refused.contains("x_axis"), "{home}: {refused}");
        }
    }
}
