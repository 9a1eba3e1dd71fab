// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Phases of a plan by number, and in the words of the shop.

use camwright::motion::plan::Phase;

/// The phase with this number.
#[must_use]
pub fn phase_from(number: u8) -> Option<Phase> {
    use Phase::{Approach, Cut, Dress, Home, Index, Position, Retract, Return, RotaryIndex, SparkOut, WheelChange};
    [Home, Index, Position, Approach, Cut, SparkOut, Retract, Return, RotaryIndex, Dress, WheelChange]
        .into_iter()
        .find(|phase| *phase as u8 == number)
}

/// A phase in the words of the shop.
#[must_use]
pub fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Home => "home",
        Phase::Index => "index",
        Phase::Position => "position",
        Phase::Approach => "approach",
        Phase::Cut => "cut",
        Phase::SparkOut => "spark-out",
        Phase::Retract => "retract",
        Phase::Return => "return",
        Phase::RotaryIndex => "rotary index",
        Phase::Dress => "dress",
        Phase::WheelChange => "wheel change",
    }
}
