// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cases of a study: the points of its design, each with its replicates, random values and seeds.

use super::results::as_number;
use super::sobol;
use camwright::math::noise::Noise;
use camwright_files::study_file::{FactorValues, Study, StudyDesign, StudyFactor, StudySetting};
use camwright_files::yaml::YamlValue;
use sha2::{Digest, Sha256};

/// Hexadecimal digits of the name of a case.
const HASH_DIGITS: usize = 16;

/// Bits of a seed, so that every reader takes it as a whole number.
const SEED_BITS: u32 = 31;

/// One case of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyCase {
    /// Number from 1.
    pub number: u32,
    /// Point of the design from 1.
    pub point: u32,
    /// Replicate of the point from 1.
    pub replicate: u32,
    /// Keys that the case sets on top of those that every case has.
    pub settings: Vec<StudySetting>,
    /// Hash of everything that the results depend on.
    pub hash: String,
}

/// All cases of a study in their order.
#[must_use]
pub fn cases(study: &Study) -> Vec<StudyCase> {
    let points = points(study);
    let numbered = (1..).zip(&points);
    numbered.flat_map(|(point, values)| replicates(study, values, point, point)).collect()
}

/// Cases of a point that no design has. Its random values and seeds are those of the first point of a design, so that points compare.
pub(crate) fn point_cases(study: &Study, values: &[YamlValue], point: u32) -> Vec<StudyCase> {
    replicates(study, values, point, 1)
}

/// Cases of a point, with the random values of the point `drawn_as`.
fn replicates(study: &Study, values: &[YamlValue], point: u32, drawn_as: u32) -> Vec<StudyCase> {
    let number = |point: u32, replicate: u32| (point - 1) * study.replicates + replicate;
    let case = |replicate: u32| {
        let settings = settings(study, values, number(drawn_as, replicate));
        let hash = hash(study, &settings);
        StudyCase { number: number(point, replicate), point, replicate, settings, hash }
    };
    (1..=study.replicates).map(case).collect()
}

/// Factors that the design sets.
pub(crate) fn controlled(study: &Study) -> impl Iterator<Item = &StudyFactor> {
    study.factors.iter().filter(|factor| !factor.values.is_random())
}

/// Values of the controlled factors at every point of the design.
fn points(study: &Study) -> Vec<Vec<YamlValue>> {
    let all = || controlled(study).map(steps);
    match study.design {
        StudyDesign::Grid {} => all().fold(vec![Vec::new()], |points, steps| {
            let with = |point: &Vec<YamlValue>, step: &YamlValue| {
                point.iter().chain([step]).cloned().collect::<Vec<YamlValue>>()
            };
            points.iter().flat_map(|point| steps.iter().map(move |step| with(point, step))).collect()
        }),
        StudyDesign::OneAtATime {} => {
            let base: Vec<YamlValue> =
                controlled(study).map(|factor| factor.base.clone().unwrap_or(YamlValue::Null)).collect();
            let mut points = vec![base.clone()];
            for (index, steps) in all().enumerate() {
                points.extend(steps.into_iter().map(|step| {
                    let mut point = base.clone();
                    point[index] = step;
                    point
                }));
            }
            points
        }
        StudyDesign::LatinHypercube { samples } => {
            let mut noise = Noise::new(study.seed);
            transposed(samples, controlled(study).map(|factor| (factor, stratified(samples, &mut noise))))
        }
        StudyDesign::Sobol { samples } => {
            let coordinates = controlled(study).enumerate();
            transposed(samples, coordinates.map(|(index, factor)| (factor, sobol::coordinate(index, samples))))
        }
    }
}

/// Points from the shares of every factor.
fn transposed<'a>(samples: u32, factors: impl Iterator<Item = (&'a StudyFactor, Vec<f64>)>) -> Vec<Vec<YamlValue>> {
    let mut points = vec![Vec::new(); samples as usize];
    for (factor, shares) in factors {
        for (point, share) in points.iter_mut().zip(shares) {
            point.push(value_at(factor, share));
        }
    }
    points
}

/// Random shares of a range, one in each of as many strata, in random order.
fn stratified(samples: u32, noise: &mut Noise) -> Vec<f64> {
    let mut strata: Vec<u32> = (0..samples).collect();
    // Fisher and Yates' shuffle; a remainder of 64 bits favours no stratum noticeably.
    for last in (1..strata.len()).rev() {
        #[allow(clippy::cast_possible_truncation, reason = "a remainder of a length")]
        let other = (noise.bits() % (last as u64 + 1)) as usize;
        strata.swap(last, other);
    }
    strata.into_iter().map(|stratum| (f64::from(stratum) + 1.0 - noise.uniform()) / f64::from(samples)).collect()
}

/// Values of a factor that a design varies in steps.
fn steps(factor: &StudyFactor) -> Vec<YamlValue> {
    match &factor.values {
        FactorValues::Levels(levels) => levels.clone(),
        FactorValues::Range { steps, .. } => {
            let last = steps.unwrap_or(2).max(2) - 1;
            (0..=last).map(|step| value_at(factor, f64::from(step) / f64::from(last))).collect()
        }
        FactorValues::Uniform { .. } | FactorValues::Normal { .. } => Vec::new(),
    }
}

/// Value of a factor at a share of its range.
pub(crate) fn value_at(factor: &StudyFactor, share: f64) -> YamlValue {
    match &factor.values {
        FactorValues::Levels(levels) => {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
            let index = (share * levels.len() as f64) as usize;
            levels[index.min(levels.len() - 1)].clone()
        }
        FactorValues::Range { from, to, is_log: false, .. } => factor.number(from + (to - from) * share),
        FactorValues::Range { from, to, is_log: true, .. } => factor.number(from * (to / from).powf(share)),
        FactorValues::Uniform { from, .. } => factor.number(*from),
        FactorValues::Normal { mean, .. } => factor.number(*mean),
    }
}

/// Share of the range at which a factor has a value; the middle where it has no range, or the value is no number.
pub(crate) fn share_of(factor: &StudyFactor, value: &YamlValue) -> f64 {
    match (&factor.values, as_number(value)) {
        (FactorValues::Range { from, to, is_log: false, .. }, Some(value)) => (value - from) / (to - from),
        (FactorValues::Range { from, to, is_log: true, .. }, Some(value)) if value > 0.0 => {
            (value / from).ln() / (to / from).ln()
        }
        _ => 0.5,
    }
}

/// Settings of a case, the factors in the order of the study, then the seeds.
fn settings(study: &Study, point: &[YamlValue], number: u32) -> Vec<StudySetting> {
    let mut noise = Noise::new(Noise::new(study.seed).bits() ^ u64::from(number));
    let mut noise = Noise::new(noise.bits());
    let mut point = point.iter();
    let mut settings = Vec::with_capacity(study.factors.len() + study.seeds.len());
    for factor in &study.factors {
        let value = match &factor.values {
            FactorValues::Uniform { from, to } => factor.number(from + (to - from) * noise.uniform()),
            FactorValues::Normal { mean, deviation } => factor.number(mean + deviation * noise.normal()),
            FactorValues::Levels(_) | FactorValues::Range { .. } => point.next().cloned().unwrap_or(YamlValue::Null),
        };
        settings.push((factor.key.clone(), value));
    }
    for key in &study.seeds {
        settings.push((key.clone(), YamlValue::Integer((noise.bits() >> (64 - SEED_BITS)).cast_signed())));
    }
    settings
}

/// Name of a case: hash of job, machine, settings and version of the program.
fn hash(study: &Study, settings: &[StudySetting]) -> String {
    let mut lines: Vec<String> = Vec::new();
    for (key, value) in settings {
        let line = format!("{key}={}", value.to_flow());
        // A text may name a file.
        let file = study.text_hashes.get(&line).map_or_else(String::new, |hash| format!(" {hash}"));
        lines.push(line + &file);
    }
    lines.sort();
    let mut digest = Sha256::new();
    for line in [concat!("camwright ", env!("CARGO_PKG_VERSION")), &study.base.hash]
        .into_iter()
        .chain(lines.iter().map(String::as_str))
    {
        digest.update((line.len() as u64).to_le_bytes());
        digest.update(line.as_bytes());
    }
    let digits: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    digits.chars().take(HASH_DIGITS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_files::locate::Located;
    use camwright_files::study_file;
    use std::collections::BTreeSet;

    fn study(factors: &str, design: &str) -> Study {
        let text = format!(
            "schema: camwright/study/1\nname: small\njob: eccentric\nfactors: {factors}\ndesign: {design}\nreplicates: 2\nseeds: [raw_part.seed]\n"
        );
        study_file::read(&Located::new("study.yaml", text), &[]).unwrap_or_else(|errors| panic!("{errors:?}"))
    }

    fn number(case: &StudyCase, index: usize) -> f64 {
        match case.settings[index].1 {
            YamlValue::Float(value) => value,
            YamlValue::Integer(value) => value as f64,
            ref other => panic!("{other:?} is no number"),
        }
    }

    #[test]
    fn a_grid_is_the_product_of_the_values() {
        let study = study(
            "{work_speed_rpm: {from: 30, to: 60, steps: 4}, hold_in_cut: [retract, stop_infeed], stock_mm: {from: 0.01, to: 0.1, steps: 3, scale: log}}",
            "{kind: grid}",
        );
        let cases = cases(&study);
        assert_eq!(cases.len(), 4 * 2 * 3 * 2);
        assert_eq!((cases[3].number, cases[3].point, cases[3].replicate), (4, 2, 2));
        let points: BTreeSet<String> = cases.iter().map(|case| format!("{:?}", &case.settings[..3])).collect();
        assert_eq!(points.len(), 24);
        let speeds: BTreeSet<String> = cases.iter().map(|case| case.settings[0].1.to_flow()).collect();
        assert_eq!(speeds.into_iter().collect::<Vec<_>>(), ["30.0", "40.0", "50.0", "60.0"]);
        let stock: BTreeSet<String> = cases.iter().map(|case| case.settings[2].1.to_flow()).collect();
        assert_eq!(stock.into_iter().collect::<Vec<_>>(), ["0.01", "0.0316228", "0.1"]);
        let hashes: BTreeSet<&str> = cases.iter().map(|case| case.hash.as_str()).collect();
        assert_eq!(hashes.len(), 48, "replicates differ by their seed");
    }

    #[test]
    fn a_latin_hypercube_has_one_sample_in_each_stratum() {
        let design = "{kind: latin_hypercube, samples: 50}";
        let study = study("{work_speed_rpm: {from: 0.1, to: 100}, infeed.spark_out_turns: [1, 2]}", design);
        let cases = cases(&study);
        let mut speeds: Vec<f64> = cases.iter().step_by(2).map(|case| number(case, 0)).collect();
        assert!(speeds.windows(2).any(|pair| pair[0] > pair[1]), "in random order");
        speeds.sort_by(f64::total_cmp);
        for (stratum, speed) in speeds.iter().enumerate() {
            let share = (speed - 0.1) / 99.9 * 50.0;
            assert!(share >= stratum as f64 - 1e-3 && share <= stratum as f64 + 1.001, "{stratum}: {share}");
        }
        let ones = cases.iter().step_by(2).filter(|case| number(case, 1) < 1.5).count();
        assert_eq!(ones, 25, "a list is stratified too");
        let mut other = study.clone();
        other.seed = 2;
        assert_ne!(super::cases(&other)[0].settings, cases[0].settings);
        assert_eq!(super::cases(&study), cases);
    }

    #[test]
    fn sobol_points_follow_the_sequence() {
        let study = study(
            "{work_speed_rpm: {from: 0.1, to: 80.1}, stock_mm: {from: 0.1, to: 0.2}}",
            "{kind: sobol, samples: 4}",
        );
        let points: Vec<[f64; 2]> =
            cases(&study).iter().step_by(2).map(|case| [number(case, 0), number(case, 1)]).collect();
        assert_eq!(points, [[0.1, 0.1], [40.1, 0.15], [60.1, 0.125], [20.1, 0.175]]);
    }

    #[test]
    fn one_at_a_time_keeps_the_base_of_the_others() {
        let study = study("{work_speed_rpm: [30.0, 90.0], stock_mm: [0.1]}", "{kind: one_at_a_time}");
        let points: Vec<[f64; 2]> =
            cases(&study).iter().step_by(2).map(|case| [number(case, 0), number(case, 1)]).collect();
        assert_eq!(points, [[60.0, 0.3], [30.0, 0.3], [90.0, 0.3], [60.0, 0.1]]);
    }

    #[test]
    fn random_values_differ_from_case_to_case_and_repeat() {
        let study = study(
            "{stock_mm: {random: uniform, from: 0.1, to: 0.2}, infeed.spark_out_turns: {random: normal, mean: 5, deviation: 1}}",
            "{kind: latin_hypercube, samples: 200}",
        );
        let all = cases(&study);
        assert_eq!(cases(&study), all);
        let stocks: Vec<f64> = all.iter().map(|case| number(case, 0)).collect();
        assert!(stocks.iter().all(|stock| (0.1..=0.2).contains(stock)));
        let mean = stocks.iter().sum::<f64>() / stocks.len() as f64;
        assert!((mean - 0.15).abs() < 4.0 * 0.1 / 12.0_f64.sqrt() / 20.0, "{mean}");
        assert!(all.iter().all(|case| matches!(case.settings[1].1, YamlValue::Integer(_))), "whole turns");
        let seeds: BTreeSet<String> = all.iter().map(|case| case.settings[2].1.to_flow()).collect();
        assert_eq!(seeds.len(), 400);
    }
}
