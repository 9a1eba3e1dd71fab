//! Where a form error comes from: the same job rehearsed on a machine that lacks one effect after the other.

use super::{PreparedJob, RehearsalFailed, rehearse_job};
use camwright::machine::description::{Effect, MachineDescription};
use camwright_msgs::camwright_msgs::msg::LobeResult;

/// What a job leaves on a machine without some effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Without {
    /// The effects that are left out.
    pub effects: Vec<Effect>,
    /// The lobes.
    pub lobes: Vec<LobeResult>,
}

impl Without {
    /// For people: "servo", or "servo, deflection".
    #[must_use]
    pub fn name(&self) -> String {
        self.effects.iter().map(|effect| effect.name()).collect::<Vec<_>>().join(", ")
    }
}

/// The effects that this machine has.
fn effects(machine: &MachineDescription) -> Vec<Effect> {
    let has = |effect: &Effect| machine.clone().without(*effect) != *machine;
    Effect::ALL.into_iter().filter(has).collect()
}

/// What a job leaves without each effect that its machine has, and last without all of them: what is left then are the counts of the
/// encoders and the grid of the part.
///
/// # Errors
/// See [`rehearse_job`].
pub fn causes(prepared: &PreparedJob) -> Result<Vec<Without>, RehearsalFailed> {
    let all = effects(&prepared.machine);
    let mut left_out: Vec<Vec<Effect>> = all.iter().map(|effect| vec![*effect]).collect();
    // One alone is all of them already.
    if all.len() > 1 {
        left_out.push(all);
    }
    left_out
        .into_iter()
        .map(|effects| {
            let (_, lobes) = rehearse_job(prepared, &effects, |_, _| {})?;
            Ok(Without { effects, lobes })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::mm_from_m;
    use crate::planning::prepare;
    use camwright::units::um_from_mm;

    /// The default machine lags and gives way; without either it grinds within 0.05 µm, and each alone leaves more.
    #[test]
    fn every_effect_of_the_machine_has_its_share_of_the_error() {
        let short = ["infeed.total_mm=0.072".to_owned(), "stock_mm=0.06".to_owned()];
        let prepared = prepare("four_lobe_camshaft", &short, None).unwrap();
        let causes = causes(&prepared).unwrap();
        let names: Vec<String> = causes.iter().map(Without::name).collect();
        assert_eq!(names, ["servo", "deflection", "servo, deflection"]);
        let worst = |lobes: &[LobeResult]| {
            lobes.iter().map(|lobe| um_from_mm(mm_from_m(lobe.form_error_max.abs()))).fold(0.0, f64::max)
        };
        let [servo, deflection, neither] = [0, 1, 2].map(|i| worst(&causes[i].lobes));
        assert!(
            neither < 0.05 && servo > 2.0 * neither && deflection > 2.0 * neither,
            "{servo} {deflection} {neither}"
        );
    }

    #[test]
    fn an_effect_that_the_machine_has_not_is_not_left_out() {
        let machine = camwright::machine::reference::cam_grinder();
        assert_eq!(effects(&machine), [Effect::Servo]);
        assert_eq!(effects(&machine.without(Effect::Servo)), []);
    }
}
