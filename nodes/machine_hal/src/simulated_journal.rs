// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gauge on a simulated journal, by components of LinuxCNC.
//!
//! ```text
//! x-drive ─► lowest position of the wheel ─► lag ─► radius ───────────┐
//!            untouched? ─► wave of the raw part, or 0 ─► lag ─► wave ─┼─► reading
//! C ─────────────────────────────────────────► cosine ────────────────┘
//! ```
//! Of a deviation a turn of the part leaves λ = kg/(kg + km); both lags leave as much in the time of a turn.

use camwright::machine::description::{Axis, GaugeKind, MachineDescription};
use camwright::math::units::{TURN_RAD, um_from_mm};
use camwright_files::hal_file::HalConfig;
use std::fmt::Write as _;

/// Radius of the finished journal, its stock, and the wave of its raw part (mm): those of the job `journal_runout`.
const RADIUS_MM: f64 = 20.0;
const STOCK_MM: f64 = 0.12;
const WAVE_MM: f64 = 0.02;
/// Width of the journal (mm).
const WIDTH_MM: f64 = 20.0;
/// Time of a turn of the journal (s).
const TURN_S: f64 = 1.0;
/// Distance of the wheel at which the next raw part is there (mm).
const AWAY_MM: f64 = 20.0;

/// A journal that is ground under a gauge.
#[derive(Debug)]
pub(crate) struct SimulatedJournal {
    kind: GaugeKind,
    /// Angle of each gauge behind the wheel (turns).
    behind_turns: [Option<f64>; 2],
    /// Units of the pins of X for one mm.
    x_scale: f64,
    x_start_mm: f64,
    /// Share of a deviation that is gone after a servo period.
    gain: f64,
}

/// The journal under the gauge of a machine that has one.
pub(crate) fn simulated_journal(hal: &HalConfig, machine: &MachineDescription) -> Option<SimulatedJournal> {
    let gauge = machine.gauge.filter(|_| hal.gauge.is_some())?;
    let law = machine.stations.first().and_then(|station| machine.contact_law(&station.switch, WIDTH_MM));
    let kept = law.map_or(0.0, |law| law.decay());
    Some(SimulatedJournal {
        kind: gauge.kind,
        behind_turns: [Some(gauge.behind_wheel_rad), gauge.second_behind_wheel_rad].map(|rad| Some(rad? / TURN_RAD)),
        x_scale: hal.axes[Axis::X.index()].scale,
        x_start_mm: machine.axis(Axis::X).power_up_position,
        gain: 1.0 - kept.powf(machine.cycle_time_s() / TURN_S),
    })
}

impl SimulatedJournal {
    /// Names of the components of each gauge.
    fn gauges(&self) -> impl Iterator<Item = (&'static str, f64)> {
        ["gauge", "gauge-second"].into_iter().zip(self.behind_turns).filter_map(|(name, turns)| Some((name, turns?)))
    }

    /// Waves of the raw part: a single contact sees it eccentric, two opposed ones only oval.
    fn waves(&self) -> f64 {
        match self.kind {
            GaugeKind::Radius => 1.0,
            GaugeKind::Diameter => 2.0,
        }
    }

    /// Components in the order of their execution: type and name.
    pub(crate) fn components(&self) -> Vec<(&'static str, String)> {
        let part = [
            ("scale", "slide"),
            ("comp", "away"),
            ("minmax", "wheel"),
            ("comp", "untouched"),
            ("mux2", "to-radius"),
            ("mux2", "to-wave"),
            ("lowpass", "radius"),
            ("lowpass", "wave"),
            ("or2", "valid"),
        ];
        let part = part.into_iter().map(|(kind, of)| (kind, format!("gauge-{of}")));
        let each = self.gauges().flat_map(|(name, _)| {
            [("scale", "angle"), ("clarkeinv", "turned"), ("sum2", "reading")]
                .map(|(kind, of)| (kind, format!("{name}-{of}")))
        });
        part.chain(each).collect()
    }

    /// Connects them to X and C.
    pub(crate) fn connect(&self, text: &mut String) {
        let Self { kind, x_scale, x_start_mm, gain, .. } = self;
        let mut line = |line: String| {
            // A string takes everything.
            let _infallible = writeln!(text, "{line}");
        };
        let (raw_mm, waves) = (RADIUS_MM + STOCK_MM, self.waves());
        let shape = if waves > 1.0 { "oval" } else { "eccentric" };
        line(format!(
            "# Gauge on a raw journal of radius {raw_mm} mm, {shape} by {} um; a turn takes {TURN_S} s.",
            um_from_mm(WAVE_MM)
        ));
        line(format!(
            "# The next raw journal is there when X is {AWAY_MM} mm clear. gauge-valid.in0 to 0: the gauge is lifted off."
        ));
        line("net x-from-drive => gauge-slide.in".to_owned());
        line(format!("setp gauge-slide.gain {}", 1.0 / x_scale));
        line(format!("setp gauge-slide.offset {x_start_mm}"));
        line("net gauge-of-slide gauge-slide.out => gauge-away.in1 gauge-wheel.in".to_owned());
        line(format!("setp gauge-away.in0 {}", raw_mm + AWAY_MM));
        line("net gauge-new-part gauge-away.out => gauge-wheel.reset".to_owned());
        line("net gauge-lowest gauge-wheel.min => gauge-untouched.in1 gauge-to-radius.in0".to_owned());
        line(format!("setp gauge-untouched.in0 {raw_mm}"));
        line(
            "net gauge-is-raw gauge-untouched.out => gauge-to-radius.sel gauge-to-wave.sel gauge-radius.load gauge-wave.load"
                .to_owned(),
        );
        line(format!("setp gauge-to-radius.in1 {raw_mm}"));
        line("setp gauge-to-wave.in0 0".to_owned());
        line(format!("setp gauge-to-wave.in1 {WAVE_MM}"));
        for of in ["radius", "wave"] {
            line(format!("net gauge-goal-{of} gauge-to-{of}.out => gauge-{of}.in"));
            line(format!("setp gauge-{of}.gain {gain}"));
        }
        let each = |pin: &str| self.gauges().map(|(name, _)| format!("{name}-{pin}")).collect::<Vec<_>>().join(" ");
        line(format!("net gauge-radius-now gauge-radius.out => {}", each("reading.in0")));
        line(format!("net gauge-wave-now gauge-wave.out => {}", each("turned.x")));
        line(format!("net c-of-turn => {}", each("angle.in")));
        let contacts = if *kind == GaugeKind::Diameter { 2.0 } else { 1.0 };
        for (name, behind_turns) in self.gauges() {
            line(format!("setp {name}-angle.gain {waves}"));
            line(format!("setp {name}-angle.offset {}", -waves * behind_turns));
            line(format!("net {name}-at {name}-angle.out => {name}-turned.theta"));
            line(format!("net {name}-wave-here {name}-turned.a => {name}-reading.in1"));
            line(format!("setp {name}-reading.gain0 {contacts}"));
            line(format!("setp {name}-reading.gain1 {contacts}"));
        }
        line("setp gauge-valid.in0 1".to_owned());
    }
}
