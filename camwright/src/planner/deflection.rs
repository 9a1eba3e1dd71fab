// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Deflection of wheel and part on a lobe: the contact law walked through all turns of all passes, phase by phase.

use crate::machine::contact_law::ContactLaw;
use crate::machine::description::MachineDescription;
use crate::machine::wheel_state::mm_from_nm;
use crate::math::hermite::HermiteSpline;
use crate::math::range::minimum_and_maximum;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{CutSegment, Plan, SegmentKind};

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
    /// Turns of all passes: fewer than planned where spark-out ends when the force is steady, or the infeed at a size.
    pub turns: u32,
    /// End of the infeed at a size on the gauge; `None` if no cut of the lobe has one.
    pub size: Option<SizeForecast>,
}

/// Forecast of an infeed that ends at a size on the gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SizeForecast {
    /// The size is reached.
    Reached {
        /// Turns of the cut until then.
        turn: f64,
        /// Position of the wheel at the end of the infeed, above the finished size (mm).
        wheel_mm: f64,
    },
    /// The infeed is over before.
    Missed {
        /// Diameter that the gauge reads more than the size when the infeed is over (mm).
        above_mm: f64,
    },
}

/// Gauge and size of a cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugedSize {
    /// Diameter above the finished one (mm).
    ends_above_mm: f64,
    /// Phases after which a cut comes under the first contact.
    behind: usize,
    /// Phases from the reading to the end of the infeed.
    delay: u32,
}

impl GaugedSize {
    /// Size of the cut in a segment of a plan; `None` where its infeed does not end at one.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, reason = "phases of a turn, and of the delay of feedback")]
    pub fn from_plan(plan: &Plan, segment: usize, machine: &MachineDescription) -> Option<Self> {
        let SegmentKind::Cut(cut) = &plan.segments.get(segment)?.kind else { return None };
        let size = plan.size_of(segment).filter(|size| size.diameter_nm > 0)?;
        let gauge = machine.gauge?;
        // The path of a journal is its radius.
        let radius_mm = plan.paths.get(cut.path)?.sample(0.0).value;
        let phases = f64::from(PHASES);
        let delay_s = f64::from(machine.feedback_delay_ticks) * machine.cycle_time_s();
        let delay = libm::ceil(delay_s / cut.turn_s * phases).clamp(0.0, 1e6);
        Some(Self {
            ends_above_mm: mm_from_nm(size.diameter_nm) - 2.0 * radius_mm,
            behind: (libm::round(gauge.behind_wheel_rad / TURN_RAD * phases) as usize) % PHASES as usize,
            delay: delay as u32,
        })
    }
}

impl Deflections {
    /// Computes the deflection on a lobe of a plan with stock (mm) along the contour's normal; `None` if the plan has no cut of it.
    ///
    /// As on the base circle. An infeed along X closes in on a flank by its cosine, so that everything is less there.
    #[must_use]
    pub fn from_lobe(
        plan: &Plan,
        lobe: usize,
        stock_mm: f64,
        law: &ContactLaw,
        machine: &MachineDescription,
    ) -> Option<Self> {
        let mut surface = GroundLobe::new(stock_mm, law);
        let mut turns = 0;
        for (number, segment) in plan.segments.iter().enumerate().filter(|(_, segment)| segment.lobe == Some(lobe)) {
            let SegmentKind::Cut(cut) = &segment.kind else { continue };
            let size = GaugedSize::from_plan(plan, number, machine);
            turns += surface.after(cut, plan.angle_laws.get(cut.infeed)?, size.as_ref());
        }
        let left_mm = surface.above_mm.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let (largest_mm, size) = (surface.largest_mm, surface.size);
        (turns > 0).then(|| Self { largest_mm, largest_n: law.force_n(largest_mm), left_mm, turns, size })
    }
}

/// A lobe while it is ground, phase by phase.
#[derive(Debug, Clone)]
pub struct GroundLobe<'a> {
    law: &'a ContactLaw,
    above_mm: [f64; PHASES as usize],
    largest_mm: f64,
    size: Option<SizeForecast>,
}

impl<'a> GroundLobe<'a> {
    /// With stock all round (mm).
    #[must_use]
    pub fn new(stock_mm: f64, law: &'a ContactLaw) -> Self {
        Self { law, above_mm: [stock_mm; PHASES as usize], largest_mm: 0.0, size: None }
    }

    /// After a cut with this law of its infeed (mm over rad); how many turns it takes, which are fewer than planned where its infeed ends
    /// at a size, or its spark-out when the force is steady.
    pub fn after(&mut self, cut: &CutSegment, infeed: &HermiteSpline, size: Option<&GaugedSize>) -> u32 {
        let (mut last_turn, mut infeed_turns) = (cut.turns, cut.infeed_turns);
        let mut deflection_mm = [0.0; PHASES as usize];
        let mut read = ReadSize::default();
        let mut turn = 0;
        while turn < last_turn {
            for phase in 0..PHASES {
                let seen = turn * PHASES + phase + 1;
                let wheel_mm = match read.level_mm {
                    Some(level_mm) => level_mm,
                    None => infeed.sample(f64::from(seen - 1) / f64::from(PHASES) * TURN_RAD).value,
                };
                let above_mm = &mut self.above_mm[phase as usize];
                deflection_mm[phase as usize] = self.law.deflection_mm(*above_mm - wheel_mm);
                *above_mm = self.law.radius_after_mm(*above_mm, wheel_mm);
                if let Some(size) = size
                    && seen <= infeed_turns * PHASES
                    && read.ends(size, &self.above_mm, seen)
                {
                    read.level_mm = Some(wheel_mm);
                    // The turn under way is finished.
                    last_turn -= infeed_turns - (turn + 1);
                    infeed_turns = turn + 1;
                    let turn = f64::from(seen) / f64::from(PHASES);
                    self.size = Some(SizeForecast::Reached { turn, wheel_mm });
                }
                if seen >= (infeed_turns + 1) * PHASES && is_steady(cut, self.law, &deflection_mm) {
                    // The turn in which that is known is finished.
                    last_turn = last_turn.min((seen + UNTIL_KNOWN) / PHASES + 1);
                }
            }
            self.largest_mm = deflection_mm.iter().copied().fold(self.largest_mm, f64::max);
            turn += 1;
            if let Some(size) = size.filter(|_| turn == cut.infeed_turns && read.level_mm.is_none()) {
                self.size = Some(SizeForecast::Missed { above_mm: read.mean_mm() - size.ends_above_mm });
            }
        }
        last_turn
    }
}

/// Diameters above the finished one that the gauge reads over a turn.
#[derive(Debug, Clone)]
struct ReadSize {
    diameter_mm: [f64; PHASES as usize],
    reached: Option<u32>,
    /// Position of the wheel where the infeed ended (mm).
    level_mm: Option<f64>,
}

impl Default for ReadSize {
    fn default() -> Self {
        Self { diameter_mm: [f64::INFINITY; PHASES as usize], reached: None, level_mm: None }
    }
}

impl ReadSize {
    fn mean_mm(&self) -> f64 {
        self.diameter_mm.iter().sum::<f64>() / f64::from(PHASES)
    }

    /// Reads the diameter after so many phases, of a surface as it is; true in the phase in which the infeed ends.
    fn ends(&mut self, size: &GaugedSize, above_mm: &[f64; PHASES as usize], seen: u32) -> bool {
        let (turn, at) = (PHASES as usize, seen as usize - 1);
        let contact = (at + turn - size.behind) % turn;
        self.diameter_mm[at % turn] = above_mm[contact] + above_mm[(contact + turn / 2) % turn];
        if self.reached.is_none() && self.mean_mm() <= size.ends_above_mm {
            self.reached = Some(seen);
        }
        self.level_mm.is_none() && self.reached.is_some_and(|reached| seen == reached + size.delay)
    }
}

/// The force was the same over the last turn, as far as the cut asks for it.
fn is_steady(cut: &CutSegment, law: &ContactLaw, deflection_mm: &[f64]) -> bool {
    let Some(max_n) = cut.until_steady_n else { return false };
    let force_n = deflection_mm.iter().map(|mm| law.force_n(*mm));
    let (low_n, high_n) = minimum_and_maximum(force_n);
    high_n - low_n <= f64::from(max_n)
}
