// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Effects that leave an error on the part.

/// Effect that leaves an error on the part. A simulation without it shows how much.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// Axes lag behind their setpoints.
    Servo,
    /// Wheel and part deflect each other.
    Deflection,
    /// The wheel loses radius.
    Wear,
    Thermal,
    /// The centre of the wheel runs out.
    Unbalance,
    /// Drives read their axes with the steps and the noise of encoders.
    Quantisation,
}

impl Effect {
    pub const ALL: [Effect; 6] =
        [Effect::Servo, Effect::Deflection, Effect::Wear, Effect::Thermal, Effect::Unbalance, Effect::Quantisation];

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Effect::Servo => "servo",
            Effect::Deflection => "deflection",
            Effect::Wear => "wear",
            Effect::Thermal => "thermal",
            Effect::Unbalance => "unbalance",
            Effect::Quantisation => "quantisation",
        }
    }
}
