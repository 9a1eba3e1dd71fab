//! In-process gauging and runout correction: what the wheel really took, what that says of the part, and the turn that makes it round.
//!
//! ```text
//! gauge ─► record ──┐                    ┌─► correction (exact)  ─► a turn of x_axis over C
//!  Gauge  Reading   ├─► state ─► phases ─┤
//!        wheel_log ─┤   PartState        └─► spark_out: turns that it saves
//!      contact law ─┘─► published (U, ΔU, IR) ─► correction (published)
//!                 ▲
//! stiffness, decay: km, kg, F0 and λ measured on the machine
//! ```
//! The method is JTEKT's (method of measuring the actual depth of cut, machining method and machine tool): the depth of cut U at a
//! phase is the difference of two diameters, and as the wheel's force bends the part by (kg/km) U + F0/km, U tells the radius itself.
//! It is kept in two forms. [`Mode::Published`] is the text to the letter. It corrects by ΔV = IR (1 + kg/km), which leaves
//! −km/(kg + km) of the runout with its sign reversed, for it takes the change of the cut for more than it is: where IR more stands
//! before the wheel, IR of the motion is already there, and IR·kg/km is to be added. [`Mode::Exact`] follows every phase through the
//! contact law with the wheel position that was logged, and leaves nothing but what the gauge did not know.
//!
//! Everything here is a function of readings and positions; who collects them, and who turns a [`correction::Correction`] into a cut,
//! is elsewhere. Angles are those of the headstock and grow with time; a phase of the part is the angle, modulo a turn, at which it
//! stands at the wheel.

pub mod correction;
pub mod decay;
pub mod fit;
pub mod gauge;
mod harmonics;
mod known;
pub mod phases;
pub mod published;
pub mod record;
pub mod sensitivity;
pub mod spark_out;
pub mod state;
pub mod stiffness;
pub mod wheel_log;

/// How a runout is measured and corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Radii by phase, propagated with the logged wheel position; the exact one-turn law.
    #[default]
    Exact,
    /// The formulas and the measuring window of the published method, to the letter.
    Published,
}
