// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Stiffness of a slender part at every lobe, and the spark-out and the order that its supports ask for.

use super::PreparedJob;
use super::deflection;
use super::summary::LobeSummary;
use camwright::job::supported_shaft::SupportedShaft;
use camwright::math::units::um_from_mm;
use serde::Serialize;

/// N/mm to N/µm.
const N_UM_PER_N_MM: f64 = 1e-3;

/// Stiffness of the part at a lobe in `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LobeSupport {
    /// Position of the table at the lobe.
    pub z_mm: f64,
    /// Deflection of the part on its supports per force.
    pub part_compliance_um_n: f64,
    pub part_stiffness_n_um: f64,
    /// Stiffness of part and machine in series.
    pub stiffness_n_um: f64,
    /// Motion of the part here per form error of the seat of the steady rest; none without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seat_share: Option<f64>,
    /// Turns of the last pass without infeed after which the deflection leaves less than the tolerance; none where no number does, or
    /// where a correction or a gauge decides the size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spark_out_turns_needed: Option<u32>,
    pub tolerance_um: f64,
}

impl std::fmt::Display for LobeSupport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "part {:.4} um/N ({:.1} N/um) at {:.3} mm, {:.1} N/um with the machine",
            self.part_compliance_um_n, self.part_stiffness_n_um, self.z_mm, self.stiffness_n_um
        )?;
        match self.spark_out_turns_needed {
            Some(turns) => {
                let plural = if turns == 1 { "" } else { "s" };
                write!(f, "; {turns} spark-out turn{plural} for the tolerance of {} um", self.tolerance_um)?;
            }
            None => f.write_str("; no number of spark-out turns decides the size")?,
        }
        match self.seat_share {
            Some(share) => write!(f, "; 1 um of form error of the seat moves the part {share:.2} um"),
            None => Ok(()),
        }
    }
}

/// Shaft of a job on its supports; `None` of a job without `part_support`.
pub(super) fn shaft(prepared: &PreparedJob) -> Option<SupportedShaft> {
    prepared.job.spec.part_support.as_ref()?.shaft(&prepared.machine)
}

/// Stiffness at one lobe; `None` of a job without `part_support`.
pub(super) fn at_lobe(prepared: &PreparedJob, lobe: usize) -> Option<LobeSupport> {
    let (shaft, design) = (shaft(prepared)?, &prepared.planned.lobes.get(lobe)?.design);
    let z_mm = design.z_mm(&prepared.machine)?;
    let compliance_mm_n = shaft.compliance_mm_n(z_mm);
    Some(LobeSupport {
        z_mm,
        part_compliance_um_n: um_from_mm(compliance_mm_n),
        part_stiffness_n_um: N_UM_PER_N_MM / compliance_mm_n,
        stiffness_n_um: N_UM_PER_N_MM * design.contact_law(&prepared.machine)?.machine_n_mm(),
        seat_share: shaft.rest_mm().map(|_| shaft.seat_share(z_mm)),
        spark_out_turns_needed: deflection::spark_out_needed(prepared, lobe),
        tolerance_um: um_from_mm(design.tolerance.smallest_mm()),
    })
}

/// Remarks on the order of grinding that the supports ask for; empty for a job without `part_support`.
pub(super) fn order_lines(prepared: &PreparedJob, lobes: &[LobeSummary]) -> Vec<String> {
    let Some(shaft) = shaft(prepared) else { return Vec::new() };
    let supports = || lobes.iter().filter_map(|lobe| Some((&lobe.name, lobe.part_support.as_ref()?)));
    let mut lines = Vec::new();
    if let Some(rest_mm) = shaft.rest_mm() {
        let moved = supports().filter_map(|(lobe, support)| Some((lobe, support, support.seat_share?)));
        let most = moved.max_by(|a, b| (a.2.abs() / a.1.tolerance_um).total_cmp(&(b.2.abs() / b.1.tolerance_um)));
        if let Some((lobe, support, share)) = most {
            lines.push(format!(
                "grind the seat of the steady rest at {rest_mm} mm before this job, with the rest retracted: a form error of the seat of \
                 {:.1} um alone takes lobe {lobe} to its tolerance of {} um",
                support.tolerance_um / share.abs(),
                support.tolerance_um
            ));
        }
    } else if let Some((lobe, support)) =
        supports().max_by(|a, b| a.1.part_compliance_um_n.total_cmp(&b.1.part_compliance_um_n))
    {
        lines.push(format!(
            "the part is softest at lobe {lobe}, {:.1} N/um without a steady rest",
            support.part_stiffness_n_um
        ));
    }
    if lobes.len() > 1 {
        lines.push(String::from(
            "the supports ask for no order of the lobes: the deflection at a lobe does not depend on those ground before",
        ));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{prepare, simulate_job, summary};
    use camwright::machine::description::Effect;
    use camwright::planner::PlannedLobe;
    use camwright_files::convert::um_from_m;
    use std::collections::BTreeMap;

    fn job(set: &[&str]) -> PreparedJob {
        prepare("long_camshaft", &set.iter().map(ToString::to_string).collect::<Vec<_>>(), None).unwrap()
    }

    const WITHOUT_REST: &str = "part_support.steady_rest_z_mm=null";
    /// A short job.
    const SHORT: [&str; 3] = ["stock_mm=0.03", "roughing=[]", "infeed.total_mm=0.036"];

    /// The shipped job on its machine: with everything else ideal, what each lobe has above its contour is the forecast of its own
    /// stiffness, with and without steady rest; without it the part is softer and the error larger.
    #[test]
    fn the_error_on_every_lobe_is_that_of_its_own_stiffness() {
        let ideal: Vec<Effect> = Effect::ALL.into_iter().filter(|effect| *effect != Effect::Deflection).collect();
        let errors_um = |set: &[&str]| -> Vec<(f64, f64)> {
            let prepared = job(&[&SHORT, set].concat());
            let (_, results) = simulate_job(&prepared, &ideal, |_, _| {}).unwrap();
            let forecasts = summary(&prepared).lobes.into_iter().map(|lobe| lobe.giving_way.unwrap().left_um);
            results.iter().map(|result| um_from_m(result.form_error_max)).zip(forecasts).collect()
        };
        let (rested, alone) = (errors_um(&[]), errors_um(&[WITHOUT_REST]));
        eprintln!("with rest {rested:?}\nwithout {alone:?}");
        assert_eq!(rested.len(), 6);
        for (found_um, forecast_um) in rested.iter().chain(&alone) {
            assert!(
                (found_um - forecast_um).abs() < 0.2 + 0.03 * forecast_um,
                "{found_um} um, forecast {forecast_um} um"
            );
        }
        // The rest helps most beside it.
        assert!(rested[2].0 < 0.6 * alone[2].0 && rested[3].0 < 0.6 * alone[3].0);
    }

    /// The number of turns that is stated is enough, and one less is not.
    #[test]
    fn the_spark_out_that_is_stated_is_the_least_that_is_enough() {
        for set in [&[][..], &[WITHOUT_REST]] {
            let prepared = job(set);
            let lobes = prepared.planned.lobes.len();
            let mut found = BTreeMap::new();
            let mut left_um = |turns: u32, lobe: usize| -> f64 {
                let of_lobes = found.entry(turns).or_insert_with(|| {
                    let turns = format!("infeed.spark_out_turns={turns}");
                    let prepared = job(&[&[turns.as_str()], set].concat());
                    Vec::from_iter((0..lobes).map(|lobe| deflection::from_lobe(&prepared, lobe).unwrap().left_um))
                });
                of_lobes[lobe]
            };
            for lobe in 0..lobes {
                let support = at_lobe(&prepared, lobe).unwrap();
                let needed = support.spark_out_turns_needed.unwrap();
                assert!(needed > 1, "{needed}");
                assert!(left_um(needed, lobe) <= support.tolerance_um, "{lobe}: {needed}");
                assert!(left_um(needed - 1, lobe) > support.tolerance_um, "{lobe}: {needed}");
            }
        }
        let hopeless = job(&[WITHOUT_REST, "form_tolerance={all_um: 0.5}"]);
        assert_eq!(at_lobe(&hopeless, 2).unwrap().spark_out_turns_needed, None, "the rubbing force alone leaves more");
    }

    /// The shipped jobs state enough spark-out; less is a warning that names the number.
    #[test]
    fn too_little_spark_out_on_a_slender_part_is_a_warning() {
        assert_eq!(deflection::too_little_spark_out(&job(&[])), None);
        assert_eq!(deflection::too_little_spark_out(&prepare("long_camshaft_seat", &[], None).unwrap()), None);
        let prepared = job(&[WITHOUT_REST]);
        let message = deflection::too_little_spark_out(&prepared).expect("the rest is missed");
        let worst = (0..6).filter_map(|lobe| at_lobe(&prepared, lobe)?.spark_out_turns_needed).max().unwrap();
        assert!(message.contains(&format!("; {worst} leave")), "{message}: {worst}");
    }

    /// Order: the seat first with a figure for its roundness, and no order of the lobes; nothing for other jobs.
    #[test]
    fn the_order_that_the_supports_ask_for_is_stated() {
        let prepared = job(&[]);
        let lines = summary(&prepared).support_order;
        assert!(lines[0].starts_with("grind the seat of the steady rest at 225 mm before this job"), "{lines:?}");
        assert!(lines[1].starts_with("the supports ask for no order of the lobes"), "{lines:?}");
        let shares: Vec<f64> = (0..6).map(|lobe| at_lobe(&prepared, lobe).unwrap().seat_share.unwrap()).collect();
        assert!(shares[2] > shares[0] && shares.iter().all(|share| (0.0..1.0).contains(share)), "{shares:?}");
        let alone = summary(&job(&[WITHOUT_REST])).support_order;
        assert!(alone[0].starts_with("the part is softest at lobe "), "{alone:?}");
        let rigid = prepare("four_lobe_camshaft", &[], None).unwrap();
        assert!(summary(&rigid).support_order.is_empty() && at_lobe(&rigid, 0).is_none());
    }

    /// The planned lobes take their stiffness from the shaft of the job file: steel of 28 mm between two centres.
    #[test]
    fn the_keys_of_the_files_are_the_shaft_of_the_core() {
        let prepared = job(&[WITHOUT_REST]);
        let bending = 2.1e5 * std::f64::consts::PI * 28.0_f64.powi(4) / 64.0;
        for (lobe, PlannedLobe { design, .. }) in prepared.planned.lobes.iter().enumerate() {
            let (a, length) = (design.z_mm(&prepared.machine).unwrap() - 30.0, 390.0);
            let b: f64 = length - a;
            let springs = (b / length).powi(2) / 1.5e5 + (a / length).powi(2) / 1e5;
            let wanted_um_n = 1e3 * (springs + a * a * b * b / (3.0 * bending * length));
            let found = at_lobe(&prepared, lobe).unwrap();
            assert!((found.part_compliance_um_n / wanted_um_n - 1.0).abs() < 1e-12, "{found:?}, {wanted_um_n}");
            let series = 1.0 / (1.0 / 45.0 + wanted_um_n);
            assert!((found.stiffness_n_um / series - 1.0).abs() < 1e-12, "{found:?}, {series}");
        }
    }
}
