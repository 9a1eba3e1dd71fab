//! What a machine file says about the in-process gauge.

use camwright::machine::description::{GaugeDescription, GaugeKind};
use camwright::math::units::{TURN_RAD, mm_from_um, rad_from_deg};
use serde::Deserialize;

/// The gauge of a machine.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GaugeFile {
    kind: KindFile,
    behind_wheel_deg: f64,
    second_behind_wheel_deg: Option<f64>,
    resolution_um: f64,
    noise_um: f64,
    bandwidth_hz: Option<f64>,
    #[serde(default)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum KindFile {
    Diameter,
    Radius,
}

impl GaugeFile {
    pub(super) fn gauge(&self) -> GaugeDescription {
        GaugeDescription {
            kind: match self.kind {
                KindFile::Diameter => GaugeKind::Diameter,
                KindFile::Radius => GaugeKind::Radius,
            },
            behind_wheel_rad: rad_from_deg(self.behind_wheel_deg),
            second_behind_wheel_rad: self.second_behind_wheel_deg.map(rad_from_deg),
            resolution_mm: mm_from_um(self.resolution_um),
            noise_mm: mm_from_um(self.noise_um),
            bandwidth_rad_s: self.bandwidth_hz.map(|hz| hz * TURN_RAD),
            seed: self.seed,
        }
    }

    /// Its values with their ranges, by key.
    pub(super) fn ranges(&self) -> impl Iterator<Item = (&'static str, f64, f64, f64)> {
        [
            ("gauge.behind_wheel_deg", Some(self.behind_wheel_deg), 0.0, 360.0),
            ("gauge.second_behind_wheel_deg", self.second_behind_wheel_deg, 0.0, 360.0),
            ("gauge.resolution_um", Some(self.resolution_um), 0.0, 1e3),
            ("gauge.noise_um", Some(self.noise_um), 0.0, 1e3),
            ("gauge.bandwidth_hz", self.bandwidth_hz, 1e-3, 1e6),
        ]
        .into_iter()
        .filter_map(|(key, value, low, high)| value.map(|value| (key, value, low, high)))
    }
}
