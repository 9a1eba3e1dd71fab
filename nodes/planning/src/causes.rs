// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Causes of a form error: the same job simulated on a machine that lacks one effect at a time.

use super::{PreparedJob, SimulationFailed, simulate_job_on, simulate_learned};
use camwright::machine::description::{Effect, MachineDescription};
use camwright_msgs::camwright_msgs::msg::LobeResult;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Form error of a job on a machine without some effects.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectRemoved {
    /// The effects that are omitted.
    pub effects: Vec<Effect>,
    pub lobes: Vec<LobeResult>,
}

impl EffectRemoved {
    /// For people: "servo", or "servo, deflection".
    #[must_use]
    pub fn name(&self) -> String {
        self.effects.iter().map(|effect| effect.name()).collect::<Vec<_>>().join(", ")
    }
}

/// Form error of a job on a different machine.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherMachine {
    /// Name of the difference: "good drives".
    pub name: &'static str,
    pub lobes: Vec<LobeResult>,
}

/// Form error of the same job on machines that differ from its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Causes {
    /// Without each effect that the machine has, and last without all of them.
    pub without: Vec<EffectRemoved>,
    /// With what could be better.
    pub with: Vec<OtherMachine>,
}

/// Number of learned parts before the reported one.
const LEARNED_PARTS: u32 = 3;

/// The effects that this machine has.
fn effects(machine: &MachineDescription) -> Vec<Effect> {
    let has = |effect: &Effect| machine.clone().without(*effect) != *machine;
    Effect::ALL.into_iter().filter(has).collect()
}

/// Sets of removed effects: each of some effects, and last all of them.
fn each_and_all(all: Vec<Effect>) -> Vec<Vec<Effect>> {
    let mut left_out: Vec<Vec<Effect>> = all.iter().map(|effect| vec![*effect]).collect();
    // One alone is all of them already.
    if all.len() > 1 {
        left_out.push(all);
    }
    left_out
}

/// Effects removed from a machine: each effect that it has, and last all of them.
pub(super) fn left_out(machine: &MachineDescription) -> Vec<Vec<Effect>> {
    each_and_all(effects(machine))
}

/// Simulates a job without each effect of its machine, and last without all of them: the remaining error comes from the counts of the
/// setpoints and the grid of the part. It also simulates the good drives of the machine file, at once and after some learned parts. The
/// simulations run in parallel, one thread a processor. `on_done` receives how many are done, of how many.
///
/// # Errors
/// See [`simulate_job_on`].
pub fn causes(prepared: &PreparedJob, on_done: &(dyn Fn(usize, usize) + Sync)) -> Result<Causes, SimulationFailed> {
    let mut all = effects(&prepared.machine);
    // What a gauge finds by how the machine deflects cannot be found on one that does not.
    all.retain(|effect| *effect != Effect::Deflection || prepared.expected_correction.is_none());
    let left_out = each_and_all(all);
    let own = || prepared.machine.clone();
    let lacking = |effects: &Vec<Effect>| effects.iter().fold(own(), |machine, effect| machine.without(*effect));
    let good = own().with_good_drives();
    let count = left_out.len();
    // The parts that learn take longest, one after the other: they begin first.
    let learns = prepared.expected_correction.is_none();
    let mut simulations: Vec<(u32, MachineDescription)> = Vec::new();
    simulations.extend(good.iter().filter(|_| learns).map(|machine| (LEARNED_PARTS, machine.clone())));
    simulations.extend(left_out.iter().map(lacking).chain(good.clone()).map(|machine| (0, machine)));
    let one = |(parts, machine): &(u32, MachineDescription)| match parts {
        0 => Ok(simulate_job_on(prepared, machine, |_, _| {})?.1),
        parts => simulate_learned(prepared, machine, *parts, |_, _| {}),
    };
    let mut lobes = beside_each_other(&simulations, one, on_done)?.into_iter();
    let learned = if good.is_some() && learns { lobes.next() } else { None };
    let without: Vec<EffectRemoved> = left_out
        .into_iter()
        .zip(lobes.by_ref().take(count))
        .map(|(effects, lobes)| EffectRemoved { effects, lobes })
        .collect();
    let at_once = lobes.next().map(|lobes| OtherMachine { name: "good drives", lobes });
    let learned = learned.map(|lobes| OtherMachine { name: "good drives, after 3 learned parts", lobes });
    Ok(Causes { without, with: at_once.into_iter().chain(learned).collect() })
}

/// One result per input, in their order, on as many threads as there are processors.
pub(super) fn beside_each_other<I: Sync, O: Send, E: Send>(
    inputs: &[I],
    work: impl Fn(&I) -> Result<O, E> + Sync,
    on_done: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<O>, E> {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get).min(inputs.len());
    let (next, ended) = (AtomicUsize::new(0), AtomicUsize::new(0));
    on_done(0, inputs.len());
    let one = || {
        let mut done = Vec::new();
        while let Some((index, input)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            inputs.get(index).map(|input| (index, input))
        } {
            done.push((index, work(input)));
            on_done(ended.fetch_add(1, Ordering::Relaxed) + 1, inputs.len());
        }
        done
    };
    let mut done: Vec<(usize, Result<O, E>)> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(one)).collect();
        running.into_iter().flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    });
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare;
    use camwright::math::units::um_from_mm;
    use camwright_files::convert::mm_from_m;

    /// The default machine lags, deflects and counts; without any of it it grinds within 0.05 µm. Drives and stiffness leave more each,
    /// counts hardly anything; good drives less than the ordinary ones.
    #[test]
    fn every_effect_of_the_machine_has_its_share_of_the_error() {
        let short = ["infeed.total_mm=0.072".to_owned(), "stock_mm=0.06".to_owned()];
        let prepared = prepare("four_lobe_camshaft", &short, None).unwrap();
        let causes = causes(&prepared, &|_, _| {}).unwrap();
        let names: Vec<String> = causes.without.iter().map(EffectRemoved::name).collect();
        let all = "servo, deflection, thermal, unbalance, quantisation";
        assert_eq!(names, ["servo", "deflection", "thermal", "unbalance", "quantisation", all]);
        let worst = |lobes: &[LobeResult]| {
            lobes.iter().map(|lobe| um_from_mm(mm_from_m(lobe.form_error_max.abs()))).fold(0.0, f64::max)
        };
        let without: Vec<f64> = causes.without.iter().map(|without| worst(&without.lobes)).collect();
        let good = worst(&causes.with[0].lobes);
        assert_eq!(causes.with[1].name, "good drives, after 3 learned parts");
        let learned = worst(&causes.with[1].lobes);
        assert!(learned < 0.6 * good, "{learned} {good}");
        let (_, own) = simulate_job_on(&prepared, &prepared.machine, |_, _| {}).unwrap();
        let own = worst(&own);
        let [servo, deflection, thermal, unbalance, quantisation, none] = without[..] else {
            panic!("six machines: {without:?}")
        };
        eprintln!("own {own} um, without {without:?}, good drives {good}");
        assert!(none < 0.05 && servo > 2.0 * none && deflection > 2.0 * none, "{without:?}");
        // A machine that is warm grows no more; its wheel is dressed smaller by what it has grown.
        assert!((thermal - own).abs() < 0.1 && (unbalance - own).abs() < 0.2, "{without:?} {own}");
        assert!((quantisation - own).abs() < 0.2 * own, "{quantisation} {own}");
        assert!(own > 1.0 && own < 4.0 && good < own, "{good} {own}");
    }

    #[test]
    fn an_effect_that_the_machine_has_not_is_not_left_out() {
        let machine = camwright::machine::reference::cam_grinder();
        assert_eq!(effects(&machine), [Effect::Servo]);
        assert_eq!(effects(&machine.without(Effect::Servo)), []);
    }
}
