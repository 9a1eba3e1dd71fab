//! What wheel and part giving way leaves of a lobe: the contact law walked through all turns of all passes, phase by phase.

use crate::contact_law::ContactLaw;
use crate::plan::Plan;
use crate::units::TURN_RAD;

/// Phases of a turn that are looked at: the infeed's spiral makes each of them another case.
const PHASES: u32 = 72;

/// Deflection of wheel and part over the whole of a lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deflections {
    /// Largest (mm).
    pub largest_mm: f64,
    /// Normal force there (N).
    pub largest_n: f64,
    /// Largest material above the contour at the end (mm).
    pub left_mm: f64,
}

impl Deflections {
    /// Of a lobe of a plan, with stock (mm) along the contour's normal; none where the plan has no cut of it.
    ///
    /// As on the base circle. An infeed along X closes in on a flank by its cosine, so that everything is less there.
    #[must_use]
    pub fn of_lobe(plan: &Plan, lobe: usize, stock_mm: f64, law: &ContactLaw) -> Option<Self> {
        let mut of_all: Option<Self> = None;
        for phase in 0..PHASES {
            let mut above_mm = stock_mm;
            let mut largest_mm = 0.0_f64;
            for cut in plan.cuts_of(lobe) {
                let infeed = plan.angle_laws.get(cut.infeed)?;
                for turn in 0..cut.turns {
                    let angle = (f64::from(turn) + f64::from(phase) / f64::from(PHASES)) * TURN_RAD;
                    let wheel_mm = infeed.sample(angle).value;
                    largest_mm = largest_mm.max(law.deflection_mm(above_mm - wheel_mm));
                    above_mm = law.radius_after_mm(above_mm, wheel_mm);
                }
                let so_far = of_all.get_or_insert(Self { largest_mm: 0.0, largest_n: 0.0, left_mm: f64::NEG_INFINITY });
                so_far.largest_mm = so_far.largest_mm.max(largest_mm);
            }
            if let Some(of_all) = &mut of_all {
                of_all.left_mm = of_all.left_mm.max(above_mm);
            }
        }
        of_all.map(|of_all| Self { largest_n: law.force_n(of_all.largest_mm), ..of_all })
    }
}
