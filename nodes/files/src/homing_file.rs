//! What a machine file says about how a slide finds its zero.

use super::ConfigError;
use super::yaml::Document;
use camwright::machine::description::{DescriptionError, Homing, MachineDescription};
use serde::Deserialize;

/// The homing of a slide; see [`Homing`].
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HomingFile {
    #[serde(default)]
    search_velocity_mm_s: f64,
    #[serde(default)]
    latch_velocity_mm_s: f64,
    final_velocity_mm_s: Option<f64>,
    #[serde(default)]
    use_index: bool,
    offset_mm: Option<f64>,
    home_mm: f64,
    #[serde(default)]
    ignore_limits: bool,
    #[serde(default)]
    sequence: u32,
    #[serde(default)]
    switch_mm: f64,
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
        Err(error @ DescriptionError::Homing { joint, .. }) => {
            Err(document.error(&format!("{joint}.home"), error.to_string()))
        }
        // What else may be wrong is told by those who know its key.
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use crate::{locate, machine_file};

    fn read(home: &str) -> Result<machine_file::Machine, String> {
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
        for (home, told) in [
            (
                "{search_velocity_mm_s: 20, switch_mm: 175, home_mm: 150}",
                "search and latch velocity and use_index must be",
            ),
            ("{latch_velocity_mm_s: 1, home_mm: 150}", "search and latch velocity and use_index must be"),
            ("{home_mm: 1500}", "its home position is beyond the soft limits"),
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
            assert!(refused.contains(told) && refused.contains("x_axis"), "{home}: {refused}");
        }
    }
}
