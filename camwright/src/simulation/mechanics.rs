// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Load of a motor: a slide with friction and an oscillating structure on it; integrated exactly for a force held over the step.
//!
//! ```text
//! motor ── F ──► [ slide (1 − μ) m ]──/\/\/──[ structure μ m ]── tool
//!                  friction  b v, Fc     k, c
//!  (1 − μ) v̇ = F − b v + μ (ω² q + 2 ζ ω p) ∓ Fc        q: structure ahead of the slide, p = q̇
//!          q̈ = −ω² q − 2 ζ ω p − v̇
//! ```
//! Per unit of mass: forces are accelerations here (counts/s²). Coulomb's friction is an impulse of the step (Moreau's time stepping):
//! it takes away what of the speed it can and never reverses it, so the slide comes to rest exactly, without chatter and without a
//! speed below which something else holds. A resting slide stays where it is while the force on it is within the friction.

use crate::machine::drive::Structure;

/// Slide and structure as they move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mechanics {
    /// Rows: way, v, q, p at the end of a step; columns: v, q, p at its beginning, and the force.
    free: [[f64; 4]; 4],
    /// Rows: q, p at the end; columns: q, p, and the acceleration of the slide, which is led.
    led: [[f64; 3]; 2],
    /// Force of the structure on the slide, per q and p.
    pull: (f64, f64),
    /// ω of the structure (rad/s); none: it is rigid.
    swings: Option<f64>,
    step_s: f64,
    coulomb: f64,
    half_play: f64,
    velocity: f64,
    /// q (counts) and p (counts/s).
    swing: (f64, f64),
    /// Tool ahead of the slide by play (counts), and how fast that grows (counts/s).
    play: (f64, f64),
}

crate::snapshot!(Mechanics { velocity, swing, play } on { free, led, pull, swings, step_s, coulomb, half_play });

impl Mechanics {
    /// At rest. `coulomb` is Fc over the mass (counts/s²), `viscous` is b over the mass (1/s), `backlash` is in counts.
    pub(super) fn new(structure: Option<Structure>, coulomb: f64, viscous: f64, backlash: f64, step_s: f64) -> Self {
        let rigid = Structure { frequency_rad_s: 0.0, damping: 0.0, mass_share: 0.0 };
        let Structure { frequency_rad_s: w, damping, mass_share } = structure.unwrap_or(rigid);
        let (spring, damper) = (w * w, 2.0 * damping * w);
        let light = 1.0 / (1.0 - mass_share);
        // State: way, v, q, p, and the force, which does not change.
        let slide = [0.0, -viscous * light, mass_share * spring * light, mass_share * damper * light, light];
        let mut rates = [[0.0; 5]; 5];
        rates[0][1] = 1.0;
        rates[1] = slide;
        if structure.is_some() {
            rates[2][3] = 1.0;
            rates[3] = slide.map(|rate| -rate);
            rates[3][2] -= spring;
            rates[3][3] -= damper;
        }
        let whole = exponential(rates, step_s);
        let led = exponential([[0.0, 1.0, 0.0], [-spring, -damper, -1.0], [0.0; 3]], step_s);
        Self {
            free: core::array::from_fn(|row| core::array::from_fn(|column| whole[row][column + 1])),
            led: [led[0], led[1]],
            pull: (mass_share * spring, mass_share * damper),
            swings: structure.map(|structure| structure.frequency_rad_s),
            step_s,
            coulomb,
            half_play: 0.5 * backlash,
            velocity: 0.0,
            swing: (0.0, 0.0),
            play: (0.0, 0.0),
        }
    }

    /// Speed of the slide (counts/s).
    pub(super) fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Lead of the tool over the slide (counts).
    pub(super) fn tool_ahead(&self) -> f64 {
        self.play.0 + self.swing.0
    }

    /// Lead of the structure over the slide (counts), and its rate (counts/s).
    pub(super) fn swing(&self) -> (f64, f64) {
        self.swing
    }

    /// Speed of the tool (counts/s).
    pub(super) fn tool_velocity(&self) -> f64 {
        self.velocity + self.play.1 + self.swing.1
    }

    /// The structure stands within a window (counts) of its rest, and will stay there.
    pub(super) fn is_quiet(&self, window: f64) -> bool {
        self.swings.is_none_or(|w| self.swing.0.abs() < window && self.swing.1.abs() < window * w)
    }

    /// At rest; play stays as it was taken up.
    pub(super) fn rest(&mut self) {
        self.velocity = 0.0;
        self.swing = (0.0, 0.0);
        self.play.1 = 0.0;
    }

    /// At rest, with play to both sides alike.
    pub(super) fn place(&mut self) {
        self.rest();
        self.play.0 = 0.0;
    }

    /// One servo step under a force; returns the way of the slide (counts).
    pub(super) fn step(&mut self, force: f64) -> f64 {
        if self.velocity == 0.0 {
            let pulled = self.pull.0 * self.swing.0 + self.pull.1 * self.swing.1;
            if (force + pulled).abs() <= self.coulomb {
                self.swing_along(0.0);
                self.play.1 = 0.0;
                return 0.0;
            }
        }
        let (v, (q, p)) = (self.velocity, self.swing);
        let [way, speed, ahead, growth] = &self.free;
        let row = |row: &[f64; 4]| {
            if self.swings.is_some() { row[0] * v + row[1] * q + row[2] * p } else { row[0] * v }
        };
        let without = row(speed) + speed[3] * force;
        let friction = (without / speed[3]).clamp(-self.coulomb, self.coulomb);
        let rests = without.abs() <= self.coulomb * speed[3];
        let force = force - friction;
        let distance = row(way) + way[3] * force;
        if self.swings.is_some() {
            self.swing = (row(ahead) + ahead[3] * force, row(growth) + growth[3] * force);
        }
        self.velocity = if rests { 0.0 } else { row(speed) + speed[3] * force };
        self.take_up(distance);
        distance
    }

    /// One servo step in which something else leads the slide to a speed; returns its way (counts).
    pub(super) fn lead(&mut self, after: f64) -> f64 {
        let distance = 0.5 * (self.velocity + after) * self.step_s;
        self.swing_along((after - self.velocity) / self.step_s);
        self.velocity = after;
        self.take_up(distance);
        distance
    }

    fn swing_along(&mut self, acceleration: f64) {
        if self.swings.is_some() {
            let (q, p) = self.swing;
            let next = |row: &[f64; 3]| row[0] * q + row[1] * p + row[2] * acceleration;
            self.swing = (next(&self.led[0]), next(&self.led[1]));
        }
    }

    /// The tool stays where it is until the play is taken up.
    fn take_up(&mut self, distance: f64) {
        if self.half_play > 0.0 {
            let loose = self.play.0 - distance;
            self.play.0 = loose.clamp(-self.half_play, self.half_play);
            self.play.1 = if loose.abs() < self.half_play { -self.velocity } else { 0.0 };
        }
    }
}

/// e to the power of a matrix times `step`: the series on a 2⁻ⁿ of it whose largest row sum is below 1/2, squared n times. Sixteen terms
/// leave less than 1e-19.
fn exponential<const N: usize>(rates: [[f64; N]; N], step: f64) -> [[f64; N]; N] {
    let norm = rates.iter().map(|row| row.iter().map(|rate| rate.abs()).sum::<f64>()).fold(0.0, f64::max) * step;
    let mut squarings = 0;
    let mut scale = step;
    while norm / step * scale > 0.5 && squarings < 60 {
        scale *= 0.5;
        squarings += 1;
    }
    let mut sum = identity();
    let mut term = identity();
    for k in 1..=16_u32 {
        term = product(&term, &rates).map(|row| row.map(|value| value * scale / f64::from(k)));
        for (row, more) in sum.iter_mut().zip(&term) {
            for (value, more) in row.iter_mut().zip(more) {
                *value += more;
            }
        }
    }
    for _ in 0..squarings {
        sum = product(&sum, &sum);
    }
    sum
}

fn identity<const N: usize>() -> [[f64; N]; N] {
    core::array::from_fn(|row| core::array::from_fn(|column| if row == column { 1.0 } else { 0.0 }))
}

fn product<const N: usize>(a: &[[f64; N]; N], b: &[[f64; N]; N]) -> [[f64; N]; N] {
    core::array::from_fn(|row| core::array::from_fn(|column| (0..N).map(|k| a[row][k] * b[k][column]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::units::TURN_RAD;

    const STEP_S: f64 = 0.25e-3;

    fn swinging(mass_share: f64) -> Structure {
        Structure { frequency_rad_s: 110.0 * TURN_RAD, damping: 0.04, mass_share }
    }

    #[test]
    fn the_exponential_of_a_rotation_is_the_rotation() {
        let angle = 7.3;
        let turned = exponential([[0.0, -angle], [angle, 0.0]], 1.0);
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        for (found, wanted) in turned.iter().flatten().zip([cos, -sin, sin, cos]) {
            assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
        }
    }

    /// Under a constant force a rigid slide goes F t²/2, and with friction per speed alone its speed is F/b (1 − exp(−b t)).
    #[test]
    fn a_rigid_slide_follows_newton() {
        let mut free = Mechanics::new(None, 0.0, 0.0, 0.0, STEP_S);
        let mut braked = Mechanics::new(None, 0.0, 30.0, 0.0, STEP_S);
        let mut way = 0.0;
        for k in 1..=1000 {
            way += free.step(5.0e6);
            braked.step(5.0e6);
            let t = f64::from(k) * STEP_S;
            assert!((way - 2.5e6 * t * t).abs() < 1e-9 * way);
            let speed = 5.0e6 / 30.0 * (1.0 - libm::exp(-30.0 * t));
            assert!((braked.velocity() - speed).abs() < 1e-11 * speed, "{k}");
        }
    }

    /// Between a thrown slide and its rest lies v/Fc, and v²/(2 Fc) of way to within the step in which it ends; then it stays.
    #[test]
    fn coulombs_friction_brings_a_slide_to_rest_and_holds_it() {
        let (speed, friction) = (1.0e5, 2.0e6);
        let mut slide = Mechanics::new(None, friction, 0.0, 0.0, STEP_S);
        slide.velocity = speed;
        let mut way = 0.0;
        let mut steps = 0;
        while slide.velocity() != 0.0 {
            way += slide.step(0.0);
            steps += 1;
        }
        assert_eq!(steps, 200, "v/Fc in steps");
        assert!((way - speed * speed / (2.0 * friction)).abs() < 1e-6 * way, "{way}");
        for force in [friction, -friction, 0.5 * friction, 0.0] {
            assert_eq!((slide.step(force).to_bits(), slide.velocity().to_bits()), (0, 0));
        }
        assert!(slide.step(1.01 * friction) > 0.0);
    }

    /// With the slide held by friction the structure rings as a damped oscillator: frequency ω √(1 − ζ²), and from one maximum to the
    /// next smaller by exp(−2πζ/√(1 − ζ²)).
    #[test]
    fn a_released_structure_decays_with_its_frequency_and_damping() {
        let structure = swinging(0.2);
        let mut slide = Mechanics::new(Some(structure), 1e12, 0.0, 0.0, STEP_S);
        slide.swing = (500.0, 0.0);
        let (w, zeta) = (structure.frequency_rad_s, structure.damping);
        let damped = w * libm::sqrt(1.0 - zeta * zeta);
        for k in 1..=2000 {
            slide.step(0.0);
            let t = f64::from(k) * STEP_S;
            let wanted =
                500.0 * libm::exp(-zeta * w * t) * (libm::cos(damped * t) + zeta * w / damped * libm::sin(damped * t));
            assert!((slide.tool_ahead() - wanted).abs() < 1e-9, "{k}: {} {wanted}", slide.tool_ahead());
        }
        assert!(slide.is_quiet(1.0) && !slide.is_quiet(1e-9));
    }

    /// A free slide swings against its structure, faster than when it is held: ω/√(1 − μ); the common centre of mass stays.
    #[test]
    fn slide_and_structure_swing_about_their_centre_of_mass() {
        let structure = Structure { damping: 0.0, ..swinging(0.3) };
        let mut slide = Mechanics::new(Some(structure), 0.0, 0.0, 0.0, STEP_S);
        slide.swing = (1000.0, 0.0);
        let w = structure.frequency_rad_s / libm::sqrt(0.7);
        let mut at = 0.0;
        for k in 1..=4000 {
            at += slide.step(0.0);
            let wanted = 1000.0 * libm::cos(w * f64::from(k) * STEP_S);
            assert!((slide.swing.0 - wanted).abs() < 1e-6, "{k}: {} {wanted}", slide.swing.0);
            assert!((at + 0.3 * slide.swing.0 - 300.0).abs() < 1e-6, "{k}: {at}");
        }
    }

    /// While it accelerates steadily the structure hangs back by a/ω².
    #[test]
    fn an_accelerated_structure_hangs_back() {
        let structure = swinging(0.2);
        let mut slide = Mechanics::new(Some(structure), 0.0, 0.0, 0.0, STEP_S);
        for _ in 0..8000 {
            slide.step(1.0e6);
        }
        let wanted = -1.0e6 / (structure.frequency_rad_s * structure.frequency_rad_s);
        assert!((slide.tool_ahead() - wanted).abs() < 1e-6, "{} {wanted}", slide.tool_ahead());
    }

    /// After a reversal the tool waits for the play.
    #[test]
    fn play_is_lost_at_every_reversal() {
        let mut slide = Mechanics::new(None, 0.0, 0.0, 200.0, STEP_S);
        let mut at = 0.0;
        for (target, wanted) in
            [(1000.0_f64, 900.0), (850.0, 900.0), (700.0, 800.0), (-400.0, -300.0), (-250.0, -300.0)]
        {
            while (at - target).abs() > 1e-9 {
                let speed = libm::copysign(1e4, target - at);
                slide.velocity = speed;
                at += slide.lead(speed);
            }
            assert!((at + slide.tool_ahead() - wanted).abs() < 1e-9, "{at}: {}", at + slide.tool_ahead());
        }
    }
}
