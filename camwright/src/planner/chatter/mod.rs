// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Regenerative chatter: forecast of the stability of a plunge cut.
//!
//! A wave that the wheel left a turn ago changes the depth of cut now; the force bends the structure and leaves the next wave. With the
//! cutting stiffness kg (force per depth of cut of a turn), the compliance G(s) between wheel and part and the time T of a turn,
//!
//! ```text
//!  1/(kg (1 − e^(−sT))) + 1/(ks (1 − e^(−sTs))) + G(s) = 0
//! ```
//! after R. Snoeys and D. Brown, "Dominating parameters in grinding wheel and workpiece regenerative chatter" (1969), and I. Inasaki,
//! B. Karpuschewski and H.-S. Lee, "Grinding chatter: origin and suppression" (CIRP Annals, 2001). The second term is the wheel that
//! wears into waves: ks = kg G vs/vw, with its time Ts of a turn. Without it a turn multiplies a wave of the frequency ω by
//!
//! ```text
//!  Λ(jω) = kg G(jω)/(1 + kg G(jω))
//! ```
//! which is kg/(kg + km) on a spring, as in the contact law. No wave grows at any work speed while Re G ≥ −1/(2 kg); a single mode
//! allows kg = 2 k ζ (1 + ζ). The lobes over the work speed are those of J. Tlusty and of Y. Altintas, "Manufacturing Automation".
//!
//! The delay is the time since the same place of the part was last in front of the wheel. That is the time of a turn for every speed
//! law that repeats from turn to turn, so the forecast holds for a cam too; a variation of the speed acts only if successive turns differ
//! ([`SpeedVariation`](crate::job::speed_variation::SpeedVariation)).
//! The cut is taken where the normal lies along X: on flanks the drive of the wheelhead gets less of the force.

mod compliance;
mod drive_compliance;
mod forecast;
mod regeneration;
mod stability_lobes;
#[cfg(test)]
mod tests;

pub use compliance::{ContactCompliance, VibrationMode};
pub use drive_compliance::DriveCompliance;
pub use forecast::{ChatterForecast, ChatterRequest, SpeedRange};
pub use regeneration::{RegenerativeCut, WaveGrowth, WheelRegeneration};
pub use stability_lobes::{LobePoint, StabilityLobes};
