// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Deflection of wheel and part at every lobe, and the required turns of spark-out.

use super::{PreparedJob, tolerance_text};
use camwright::machine::contact_law::ContactLaw;
use camwright::math::units::um_from_mm;
use camwright::planner::deflection::{Deflections, SizeForecast};
use serde::Serialize;

/// Most spark-out turns that are proposed: a job that needs more needs another infeed.
const MAX_TURNS: u32 = 30;

/// Deflection of a lobe in `summary.json`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LobeDeflection {
    /// Share of a deviation that a turn without infeed leaves, kg/(kg + km).
    pub left_by_a_turn: f64,
    pub largest_um: f64,
    pub largest_n: f64,
    /// Largest material above the contour at the end.
    pub left_um: f64,
    /// Turns of all passes until then: fewer than planned where spark-out ends when the force is steady.
    pub turns: u32,
    /// Turns of all passes, as planned.
    pub most_turns: u32,
    /// Turn of the last pass in which the gauge reads the size that ends its infeed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_read_at_turn: Option<f64>,
}

impl std::fmt::Display for LobeDeflection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = 100.0 * self.left_by_a_turn;
        write!(
            f,
            "{:.1} um at {:.0} N; a turn without infeed leaves {percent:.0} % of it, the last turn {:.2} um",
            self.largest_um, self.largest_n, self.left_um
        )?;
        if let Some(turn) = self.size_read_at_turn {
            write!(f, "; the gauge reads the size in turn {turn:.1} of the last pass")?;
        } else if self.turns < self.most_turns {
            write!(f, "; the force is steady after {} of {} turns", self.turns, self.most_turns)?;
        }
        Ok(())
    }
}

fn law_of(prepared: &PreparedJob, lobe: usize) -> Option<ContactLaw> {
    prepared.planned.lobes.get(lobe)?.design.contact_law(&prepared.machine)
}

fn forecast(prepared: &PreparedJob, lobe: usize, law: &ContactLaw) -> Option<Deflections> {
    let (plan, spec) = (&prepared.planned.plan, &prepared.job.spec);
    // A wheel begins on what the one before it left.
    let before = spec.visit_before(lobe);
    let left_mm = before.and_then(|before| Some(forecast(prepared, before, &law_of(prepared, before)?)?.left_mm));
    let stock_mm = left_mm.unwrap_or_else(|| spec.stock_of_mm(lobe));
    Deflections::from_lobe(plan, lobe, stock_mm, law, &prepared.machine)
}

/// Deflection at one lobe; `None` on a rigid machine.
pub(super) fn from_lobe(prepared: &PreparedJob, lobe: usize) -> Option<LobeDeflection> {
    let law = law_of(prepared, lobe)?;
    let found = forecast(prepared, lobe, &law)?;
    Some(LobeDeflection {
        left_by_a_turn: law.decay(),
        largest_um: um_from_mm(found.largest_mm),
        largest_n: found.largest_n,
        left_um: um_from_mm(found.left_mm),
        turns: found.turns,
        most_turns: prepared.planned.plan.cuts_of(lobe).map(|cut| cut.turns).sum(),
        size_read_at_turn: match found.size {
            Some(SizeForecast::Reached { turn, .. }) => Some(turn),
            Some(SizeForecast::Missed { .. }) | None => None,
        },
    })
}

/// Number of turns without infeed in the last pass after which the deflection leaves the tolerance of a lobe; `None` on a rigid machine,
/// where the rubbing force alone leaves more, and where a correction or the gauge decides the size.
pub(super) fn spark_out_needed(prepared: &PreparedJob, lobe: usize) -> Option<u32> {
    let spec = &prepared.job.spec;
    if spec.correction.is_some() || spec.size_control().is_some() || !spec.lobes.get(lobe)?.is_finished() {
        return None;
    }
    let (law, way) = (law_of(prepared, lobe)?, from_lobe(prepared, lobe)?);
    let tolerance_um = um_from_mm(prepared.planned.lobes.get(lobe)?.design.tolerance.smallest_mm());
    let rests_um = um_from_mm(law.threshold_n() / law.machine_n_mm());
    let turned = spec.passes.last()?.spark_out_turns.saturating_sub(way.most_turns - way.turns);
    let (left_um, allowed_um) = (way.left_um - rests_um, tolerance_um - rests_um);
    if allowed_um <= 0.0 {
        return None;
    }
    // Every turn leaves the same share of what the infeed left; the first one takes its step.
    let more = if left_um > 0.0 { (allowed_um / left_um).ln() / way.left_by_a_turn.ln() } else { f64::NEG_INFINITY };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and the largest u32")]
    let needed = (f64::from(turned) + more).ceil().clamp(1.0, f64::from(u32::MAX)) as u32;
    Some(needed)
}

/// Warning for the lobe on which spark-out leaves most of the tolerance used, if it exceeds the tolerance.
pub(super) fn too_little_spark_out(prepared: &PreparedJob) -> Option<String> {
    let finished = (0..prepared.planned.lobes.len()).filter(|lobe| prepared.job.spec.lobes[*lobe].is_finished());
    let lobes = finished.filter_map(|lobe| Some((lobe, from_lobe(prepared, lobe)?)));
    // What is left before the turn that corrects is not what is left of the job.
    if prepared.job.spec.correction.is_some() || prepared.job.spec.size_control().is_some() {
        return None;
    }
    let tolerance_mm = |lobe: usize| prepared.planned.lobes[lobe].design.tolerance.smallest_mm();
    let used = |(lobe, way): &(usize, LobeDeflection)| way.left_um / tolerance_mm(*lobe);
    let (lobe, way) = lobes.max_by(|a, b| used(a).total_cmp(&used(b)))?;
    let (tolerance_um, tolerance) = (um_from_mm(tolerance_mm(lobe)), tolerance_text(tolerance_mm(lobe)));
    if way.left_um <= tolerance_um {
        return None;
    }
    let law = law_of(prepared, lobe)?;
    let rests_um = um_from_mm(law.threshold_n() / law.machine_n_mm());
    let after = |more: u32| rests_um + (way.left_um - rests_um) * way.left_by_a_turn.powf(f64::from(more));
    let name = &prepared.planned.lobes[lobe].design.name;
    let (turns, until_n) =
        prepared.job.spec.passes.last().map(|pass| (pass.spark_out_turns, pass.spark_out_until_n))?;
    if let Some(until_n) = until_n.filter(|_| way.turns < way.most_turns) {
        // What is left above what the threshold keeps goes with the force.
        let enough_n = f64::from(until_n) * (tolerance_um - rests_um) / (way.left_um - rests_um);
        return Some(format!(
            "lobe {name}: spark-out that ends when the force is steady within {until_n} N leaves {:.2} um on it, above the tolerance of \
             {tolerance} um; {} N are enough",
            way.left_um,
            enough_n.floor().max(1.0)
        ));
    }
    let remedy = match (1..=MAX_TURNS).find(|more| after(*more) <= tolerance_um) {
        Some(more) => format!("{} leave {:.2} um", turns + more, after(more)),
        None => String::from("more turns do not help: the machine is too compliant"),
    };
    Some(format!(
        "lobe {name}: wheel and part deflect, and {turns} spark-out turns leave {:.2} um on it, above the tolerance \
         of {tolerance} um; {remedy}",
        way.left_um
    ))
}

/// Share of the form tolerance by which the size may differ from part to part without a warning.
const SIZE_SHARE: f64 = 0.1;

/// Warnings about a gauge-controlled size, each with its key: a size that the infeed does not reach, a finished size out of tolerance, a
/// spark-out so short that the size depends on where in the turn it was read.
pub(super) fn size_warnings(prepared: &PreparedJob) -> Vec<(&'static str, String)> {
    let Some(size) = prepared.job.spec.size_control() else { return Vec::new() };
    let (Some(pass), Some(schedule)) =
        (prepared.job.spec.passes.last(), prepared.planned.lobes.first().and_then(|lobe| lobe.passes.last()))
    else {
        return Vec::new();
    };
    let per_turn_um = um_from_mm(schedule.infeed().schedule().max_per_turn_mm());
    let above_um = um_from_mm(size.ends_above_mm);
    let mut warnings = Vec::new();
    for (index, lobe) in prepared.planned.lobes.iter().enumerate().filter(|(_, lobe)| lobe.design.is_finished()) {
        let Some((law, found)) = law_of(prepared, index).and_then(|law| Some((law, forecast(prepared, index, &law)?)))
        else {
            continue;
        };
        let (name, tolerance_mm) = (&lobe.design.name, lobe.design.tolerance.smallest_mm());
        if let Some(SizeForecast::Missed { above_mm }) = found.size {
            let (missed_um, needed_um) = (um_from_mm(above_mm), um_from_mm(size.beyond_mm + 0.5 * above_mm));
            let message = format!(
                "lobe {name}: with a wheel as planned the gauge still reads {missed_um:.1} um more than the size when the infeed is over; \
                 alarm 142 will stop the machine: raise gauge_size.beyond_um to {:.0} or more, and infeed.total_mm with it",
                (needed_um + per_turn_um).ceil()
            );
            warnings.push(("infeed.gauge_size.beyond_um", message));
            continue;
        }
        let left_um = um_from_mm(found.left_mm);
        if left_um.abs() > um_from_mm(tolerance_mm) {
            let message = format!(
                "lobe {name}: an infeed that ends {above_um} um above the finished diameter leaves the journal {left_um:+.1} um off its finished \
                 radius, tolerance {}; {:.1} um would bring it there",
                tolerance_text(tolerance_mm),
                (above_um - 2.0 * left_um).max(0.0)
            );
            warnings.push(("infeed.gauge_size.ends_above_um", message));
        }
        // The turn under way is finished, so up to a turn more sparks out.
        let differs_um = |turns: u32| per_turn_um * law.decay().powf(f64::from(turns) + 1.0);
        let (turns, allowed_um) = (pass.spark_out_turns, SIZE_SHARE * um_from_mm(tolerance_mm));
        if differs_um(turns) > allowed_um {
            let enough = (turns..=turns + MAX_TURNS).find(|more| differs_um(*more) <= allowed_um);
            let remedy = enough
                .map_or_else(|| "reduce the infeed per turn".to_owned(), |enough| format!("{enough} turns are enough"));
            let message = format!(
                "lobe {name}: after {turns} spark-out turns the size depends by up to {:.2} um of the radius on where in a turn the gauge reads \
                 it, more than {allowed_um:.2} um; {remedy}",
                differs_um(turns)
            );
            warnings.push(("infeed.spark_out_turns", message));
        }
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare;

    /// After two turns the default job would be off by 6.6 µm; the number that is proposed is enough, and one less is not.
    #[test]
    fn too_few_spark_out_turns_are_reported_with_the_needed_number() {
        let forecast = |turns: u32| {
            let prepared = prepare("four_lobe_camshaft", &[format!("infeed.spark_out_turns={turns}")], None).unwrap();
            let worst = (0..4).filter_map(|lobe| from_lobe(&prepared, lobe)).map(|way| way.left_um).fold(0.0, f64::max);
            (too_little_spark_out(&prepared), worst)
        };
        let (message, left_um) = forecast(2);
        let message = message.expect("it is above the tolerance");
        assert!((left_um - 6.64).abs() < 0.05, "{left_um}");
        let (enough, less_um) = forecast(3);
        assert_eq!(enough, None);
        assert!(message.ends_with(&format!("3 leave {less_um:.2} um")), "{message}, {less_um}");
    }

    #[test]
    fn an_unreachable_tolerance_is_reported() {
        let set = ["infeed.spark_out_turns=5".to_owned()];
        let mut prepared = prepare("four_lobe_camshaft", &set, None).unwrap();
        prepared.machine.contact.as_mut().unwrap().threshold_n_mm = 50.0;
        assert!(too_little_spark_out(&prepared).unwrap().contains("more turns do not help"));
        prepared.machine.contact = None;
        assert_eq!((too_little_spark_out(&prepared), from_lobe(&prepared, 0)), (None, None));
    }
}
