//! Deflection of wheel and part on a lobe: the contact law walked through all turns of all passes, phase by phase.

use crate::machine::contact_law::ContactLaw;
use crate::math::hermite::HermiteSpline;
use crate::math::range::minimum_and_maximum;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{CutSegment, Plan};

/// Phases of a turn that are looked at: the infeed's spiral makes each of them another case.
const PHASES: u32 = 72;

/// Phases after which a steady force is known: a sector of the force monitor, and the feedback's delay at some 60 rpm.
const UNTIL_KNOWN: u32 = 2;

/// Deflection of wheel and part over the whole of a lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deflections {
    /// Largest (mm).
    pub largest_mm: f64,
    /// Normal force there (N).
    pub largest_n: f64,
    /// Largest material above the contour at the end (mm).
    pub left_mm: f64,
    /// Turns of all passes: fewer than planned where spark-out ends when the force is steady.
    pub turns: u32,
}

impl Deflections {
    /// Computes the deflection on a lobe of a plan with stock (mm) along the contour's normal; `None` if the plan has no cut of it.
    ///
    /// As on the base circle. An infeed along X closes in on a flank by its cosine, so that everything is less there.
    #[must_use]
    pub fn from_lobe(plan: &Plan, lobe: usize, stock_mm: f64, law: &ContactLaw) -> Option<Self> {
        let mut surface = GroundLobe::new(stock_mm, law);
        let mut turns = 0;
        for cut in plan.cuts_of(lobe) {
            turns += surface.after(cut, plan.angle_laws.get(cut.infeed)?);
        }
        let left_mm = surface.above_mm.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let largest_mm = surface.largest_mm;
        (turns > 0).then(|| Self { largest_mm, largest_n: law.force_n(largest_mm), left_mm, turns })
    }
}

/// A lobe while it is ground, phase by phase.
#[derive(Debug, Clone)]
pub struct GroundLobe<'a> {
    law: &'a ContactLaw,
    above_mm: [f64; PHASES as usize],
    largest_mm: f64,
}

impl<'a> GroundLobe<'a> {
    /// With stock all round (mm).
    #[must_use]
    pub fn new(stock_mm: f64, law: &'a ContactLaw) -> Self {
        Self { law, above_mm: [stock_mm; PHASES as usize], largest_mm: 0.0 }
    }

    /// After a cut with this law of its infeed (mm over rad); how many turns it takes, which are fewer than planned where spark-out ends
    /// when the force is steady.
    pub fn after(&mut self, cut: &CutSegment, infeed: &HermiteSpline) -> u32 {
        let mut last_turn = cut.turns;
        let mut deflection_mm = [0.0; PHASES as usize];
        let mut turn = 0;
        while turn < last_turn {
            for (phase, above_mm) in (0..PHASES).zip(&mut self.above_mm) {
                let angle = (f64::from(turn) + f64::from(phase) / f64::from(PHASES)) * TURN_RAD;
                let wheel_mm = infeed.sample(angle).value;
                deflection_mm[phase as usize] = self.law.deflection_mm(*above_mm - wheel_mm);
                *above_mm = self.law.radius_after_mm(*above_mm, wheel_mm);
                let seen = turn * PHASES + phase + 1;
                if seen >= (cut.infeed_turns + 1) * PHASES && is_steady(cut, self.law, &deflection_mm) {
                    // The turn in which that is known is finished.
                    last_turn = last_turn.min((seen + UNTIL_KNOWN) / PHASES + 1);
                }
            }
            self.largest_mm = deflection_mm.iter().copied().fold(self.largest_mm, f64::max);
            turn += 1;
        }
        last_turn
    }
}

/// The force was the same over the last turn, as far as the cut asks for it.
fn is_steady(cut: &CutSegment, law: &ContactLaw, deflection_mm: &[f64]) -> bool {
    let Some(max_n) = cut.until_steady_n else { return false };
    let force_n = deflection_mm.iter().map(|mm| law.force_n(*mm));
    let (low_n, high_n) = minimum_and_maximum(force_n);
    high_n - low_n <= f64::from(max_n)
}
