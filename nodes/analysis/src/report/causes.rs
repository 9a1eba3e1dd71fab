// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Causes of the worst deviation, in words.

use super::edge::{AxisShare, ErrorSplit};
use super::lag::{Lag, Residual};
use super::text::{fixed, signed, um};
use camwright::machine::description::Axis;
use camwright_msgs::camwright_msgs::msg::TurnedResult;

/// An error is said to come from one source if that explains all of it but this share.
const UNNAMED: f64 = 0.35;

/// The source that leaves most towards an error, and what each leaves (µm); of each its name alone and in a row.
pub(super) fn causes_of(error_um: f64, sources: &[(f64, &str, &str)]) -> Vec<String> {
    let towards = |source: &f64| source * error_um.signum();
    let first = sources.iter().max_by(|a, b| towards(&a.0).total_cmp(&towards(&b.0)));
    let whole = first.is_some_and(|(share, _, _)| towards(share) >= (1.0 - UNNAMED) * error_um.abs());
    let named = first.map_or("", |(_, name, _)| name);
    let mostly = format!("{} {named}.", if whole { "Mostly" } else { "Several sources, mainly" });
    let shares: Vec<String> =
        sources.iter().map(|(share, _, name)| format!("{} µm {name}", signed(*share, 2))).collect();
    vec![mostly, format!("At that place: {}.", shares.join(", "))]
}

/// The causes of the worst place, the short answer first.
pub(super) fn causes_of_turned(
    part: &TurnedResult,
    split: Result<&ErrorSplit, &String>,
    lag: Option<&Lag>,
) -> Vec<String> {
    let mut causes = match split {
        Ok(split) => sources(split),
        Err(reason) => vec![format!("Not known: {reason}.")],
    };
    let range = |left: &Residual| format!("{} to {} µm", signed(left.lowest_um, 2), signed(left.highest_um, 2));
    let over_c = lag.map_or_else(String::new, |lag| {
        let swing = lag.tool.as_ref().map_or_else(String::new, |tool| format!(", with the structures {}", range(tool)));
        format!("In the last pass X was {} off its path over C by the encoders{swing}. ", range(&lag.encoders))
    });
    let cusps = fixed(um(part.cusp_height_theory), 2);
    let together = split.map_or_else(
        |_| String::new(),
        |split| format!("Lags of the three axes together leave {} µm there. ", signed(split.lag_um(), 2)),
    );
    causes.push(format!("{together}{over_c}Feed, insert and design cause cusps of up to {cusps} µm."));
    causes
}

fn sources(split: &ErrorSplit) -> Vec<String> {
    let [c, x, z] = split.axes;
    let swings = swings(split);
    let mut sources = vec![
        (x.lag_um, "X off its setpoint by its encoder", "X off its setpoint"),
        (c.lag_um, "C off its setpoint where the surface rises or falls", "C off its setpoint, by the slope there"),
        (z.lag_um, "Z off its setpoint where the surface is inclined along it", "Z off its setpoint"),
    ];
    if split.has_swing() {
        sources.push((split.swing_um(), &swings, "swing of the structures"));
    }
    sources.push((split.cusp_um, "the cusp that the feed leaves between two turns", "cusp of the feed"));
    sources.push((split.rest_um, "effects without a sensor: deflection of insert and part, wear, heat", "the rest"));
    causes_of(split.error_um, &sources)
}

/// The structure that leaves most towards the error.
fn swings(split: &ErrorSplit) -> String {
    let towards = |axis: &&AxisShare| axis.swing_um * split.error_um.signum();
    let max = split.axes.iter().max_by(|a, b| towards(a).total_cmp(&towards(b)));
    let name = max.map_or("", |axis| name(axis.axis));
    format!("the structure of {name}, which swings behind its encoder when {name} is accelerated")
}

fn name(axis: Axis) -> &'static str {
    match axis {
        Axis::C => "C",
        Axis::X => "X",
        Axis::Z => "Z",
    }
}
