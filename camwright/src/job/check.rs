// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Validates a job before path planning.

use super::grinding::{
    BetweenLobes, CorrectionSpec, JobError, JobSpec, LobeSpec, MAX_ALLOWANCE_MM, MAX_BEYOND_MM, MAX_MARGIN_MM,
    MAX_PASSES, MAX_SIZE_ABOVE_MM, MAX_SPARK_OUT_TURNS, MAX_VARIATION_N, MIN_BLOCKS, PassSpec, ProfileSpec,
    SLOWER_SHARES, SpeedLaw, StiffnessSource, VARIATION_PERIODS_TURNS,
};
use super::key::{JobKey, Subject};
use super::plunges::MAX_SECTIONS;
use crate::cam::compensation::{MAX_CORRECTION_MM, MAX_HARMONICS as MAX_LEARNED_HARMONICS, MAX_SLOPE_MM_RAD};
use crate::gauging::GaugingMode;
use crate::gauging::finishing::{
    FinishingSpec, MAX_FINISHING_MM, MAX_FINISHING_N, MAX_FINISHING_STOCK_MM, MAX_FINISHING_TURNS,
};
use crate::gauging::gauge::Gauge;
use crate::gauging::journal::DWELL_LEAVES_RAD;
use crate::gauging::published::PublishedWindow;
use crate::gauging::runout::FEWEST_PHASES;
use crate::gauging::state::{MAX_HARMONICS, MAX_PHASES};
use crate::machine::description::{GaugeKind, MachineDescription};
use crate::machine::fixture::Extent;
use crate::math::range::minimum_and_maximum;
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::string::String;
use alloc::vec::Vec;

/// Relative rounding tolerance of a bound.
const ROUNDING: f64 = 1e-3;

/// Slowest and fastest work speed that a job may ask for (rad/s).
const WORK_SPEEDS_RAD_S: (f64, f64) = (1e-3, 1e4);

/// Largest length (mm), depth of a pass (mm) and azimuth (rad) of a job, and smallest and largest speed of X (mm/s): positions then stay far
/// inside what counts can hold, and times inside what ticks can.
const MAX_LENGTH_MM: f64 = 1e4;
const MAX_INFEED_MM: f64 = 100.0;
const MAX_PHASE_RAD: f64 = 1e3;
const RAPID_SPEEDS_MM_S: (f64, f64) = (1e-2, 1e5);

impl JobSpec {
    /// Validates names, stations, widths and ranges, before path planning.
    ///
    /// # Errors
    /// The first thing found that cannot be made on this machine.
    pub fn check(&self, machine: &MachineDescription) -> Result<(), JobError> {
        self.check_counts()?;
        for (index, lobe) in self.lobes.iter().enumerate() {
            self.check_lobe(index, lobe, machine)?;
        }
        self.check_reach(machine)?;
        self.check_sections()?;
        self.check_wheels(machine)?;
        self.check_axial(machine)?;
        for pass in &self.passes {
            self.check_pass(pass, machine)?;
        }
        self.check_moves()?;
        self.check_between_lobes()?;
        self.check_wheel_power()?;
        self.check_speed_variation()?;
        self.check_room()?;
        self.check_bores()?;
        self.check_raw_part()?;
        self.check_part_support(machine)?;
        self.check_correction(machine)?;
        self.check_stock(machine)?;
        self.check_compensation()?;
        for wish in &self.wheels {
            length(|| wish.of.clone(), JobKey::WheelRadius, wish.radius_mm)?;
        }
        self.check_home()
    }

    fn check_counts(&self) -> Result<(), JobError> {
        if self.lobes.is_empty() {
            return Err(JobError::NoLobes);
        }
        if self.passes.is_empty() || self.passes.len() > MAX_PASSES {
            return Err(JobError::PassCount { count: self.passes.len(), max: MAX_PASSES });
        }
        if self.blocks_per_turn < MIN_BLOCKS {
            return Err(JobError::TooFewBlocks { blocks: self.blocks_per_turn, min: MIN_BLOCKS });
        }
        Ok(())
    }

    fn check_pass(&self, pass: &PassSpec, machine: &MachineDescription) -> Result<(), JobError> {
        let place = || Subject::Pass(pass.name.clone());
        positive(place, JobKey::TotalInfeed, pass.total_infeed_mm)?;
        within(place, JobKey::TotalInfeed, pass.total_infeed_mm, (0.0, MAX_INFEED_MM), "above 0 and at most 100")?;
        positive(place, JobKey::InfeedPerBlock, pass.infeed_per_block_mm)?;
        for value in &pass.infeed_of_turns_mm {
            positive(place, JobKey::InfeedOfTurns, *value)?;
        }
        for (key, value) in pass.speed.settings() {
            positive(place, key, value)?;
            if key == JobKey::WorkSpeed {
                within(place, key, value, WORK_SPEEDS_RAD_S, "0.001 to 10000 (0.01 to 95000 rpm)")?;
            }
        }
        let turns = (0.0, f64::from(MAX_SPARK_OUT_TURNS));
        within(place, JobKey::SparkOutTurns, f64::from(pass.spark_out_turns), turns, "0 to 1000")?;
        self.check_least_spark_out(pass)?;
        self.check_spark_out(pass, machine)?;
        self.check_size(pass, machine)?;
        self.check_radial_law(pass)?;
        let first = &self.passes[0];
        if pass.infeed_direction == first.infeed_direction {
            return Ok(());
        }
        Err(JobError::MixedDirections {
            first: first.name.clone(),
            one: first.infeed_direction.name(),
            pass: pass.name.clone(),
            other: pass.infeed_direction.name(),
        })
    }

    /// Refuses a pass that ends or measures in more spark-out than it has.
    fn check_least_spark_out(&self, pass: &PassSpec) -> Result<(), JobError> {
        let is_last = self.passes.last().is_some_and(|last| last.name == pass.name);
        let needs = [
            (pass.spark_out_until_n.is_some(), 1, "for spark_out_until_n"),
            (pass.gauge_size.is_some(), 1, "after the infeed that the gauge ends (gauge_size)"),
            (self.correction.is_some() && is_last, 1, "for the gauge to read in (runout_correction)"),
            (self.identification.is_some() && is_last, 2, "to measure how the deflection decays (identification)"),
        ];
        let turns = pass.spark_out_turns;
        match needs.into_iter().find(|(is_given, least, _)| *is_given && turns < *least) {
            Some((_, least, purpose)) => {
                Err(JobError::TooLittleSparkOut { pass: pass.name.clone(), turns, least, purpose })
            }
            None => Ok(()),
        }
    }

    /// The law of radial stock needs a contour about the spindle axis.
    fn check_radial_law(&self, pass: &PassSpec) -> Result<(), JobError> {
        let is_pin = |lobe: &&LobeSpec| self.profiles.get(lobe.profile).is_some_and(ProfileSpec::is_pin);
        match (pass.speed, self.lobes.iter().find(is_pin)) {
            (SpeedLaw::ConstantRadialRemovalRate { .. }, Some(lobe)) => {
                Err(JobError::RadialLawOnPin { lobe: lobe.name.clone(), pass: pass.name.clone() })
            }
            _ => Ok(()),
        }
    }

    fn check_moves(&self) -> Result<(), JobError> {
        let of_job = || Subject::Job;
        length(of_job, JobKey::RapidAdvance, self.rapid_advance_mm)?;
        positive(of_job, JobKey::RapidSpeed, self.rapid_speed_mm_s)?;
        within(of_job, JobKey::RapidSpeed, self.rapid_speed_mm_s, RAPID_SPEEDS_MM_S, "0.01 to 100000")?;
        length(of_job, JobKey::RetractClearance, self.retract_clearance_mm)?;
        length(of_job, JobKey::Stock, self.stock_mm)
    }

    fn check_between_lobes(&self) -> Result<(), JobError> {
        let BetweenLobes::TurnsOn { margin_s } = self.c_between_lobes else { return Ok(()) };
        within(|| Subject::Job, JobKey::CBetweenLobesMargin, margin_s, (0.0, 1.0), "0 to 1")?;
        if self.rotary_indexing { Err(JobError::TurnsAndIndexes) } else { Ok(()) }
    }

    fn check_speed_variation(&self) -> Result<(), JobError> {
        let Some(variation) = &self.speed_variation else { return Ok(()) };
        let of_job = || Subject::Job;
        within(of_job, JobKey::SpeedVariationSlower, variation.slower, SLOWER_SHARES, "0.01 to 0.75 (1 to 75 %)")?;
        let periods = VARIATION_PERIODS_TURNS;
        within(of_job, JobKey::SpeedVariationPeriod, variation.period_turns, periods, "1.5 to 3")
    }

    fn check_wheel_power(&self) -> Result<(), JobError> {
        let Some(power) = &self.wheel_power else { return Ok(()) };
        positive(|| Subject::Job, JobKey::WheelPowerMax, power.max_w)?;
        positive(|| Subject::Job, JobKey::WheelPowerSpecificEnergy, power.specific_energy_j_mm3)?;
        positive(|| Subject::Job, JobKey::WheelPowerRubbing, power.rubbing_n_mm2)
    }

    /// A job grinds bores or outer contours, and what measures or changes an outer contour is not for bores.
    fn check_bores(&self) -> Result<(), JobError> {
        let is_bore = |lobe: &&LobeSpec| self.profiles.get(lobe.profile).is_some_and(|profile| profile.is_bore);
        let Some(bore) = self.lobes.iter().find(is_bore) else { return Ok(()) };
        if let Some(lobe) = self.lobes.iter().find(|lobe| !is_bore(lobe)) {
            return Err(JobError::BoreBesideLobe { bore: bore.name.clone(), lobe: lobe.name.clone() });
        }
        let of_lobe = |lobe: &LobeSpec, what, key| Err(JobError::NotInBore { lobe: lobe.name.clone(), what, key });
        if let Some(wide) = self.lobes.iter().find(|lobe| lobe.plunge.is_some()) {
            return of_lobe(wide, "a width above that of the wheel", "lobes");
        }
        if let Some(shaped) = self.lobes.iter().find(|lobe| lobe.axial.is_some()) {
            return of_lobe(shaped, "taper or crown", "lobes");
        }
        let keys = [
            (self.correction.is_some(), "runout_correction"),
            (self.measure_stock.is_some(), "measure_stock"),
            (self.compensation.is_some(), "form_compensation"),
            (self.passes.iter().any(|pass| pass.gauge_size.is_some()), "infeed.gauge_size"),
        ];
        match keys.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, key)) => of_lobe(bore, key, key),
            None => Ok(()),
        }
    }

    /// Clearance, stand-off of a dry run, and obstacles.
    fn check_room(&self) -> Result<(), JobError> {
        within(|| Subject::Job, JobKey::Clearance, self.clearance_mm, (0.0, MAX_LENGTH_MM), "0 to 10000")?;
        if let Some(stand_off_mm) = self.dry_run_mm {
            length(|| Subject::Job, JobKey::DryRunStandOff, stand_off_mm)?;
        }
        match self.obstacles.iter().find(|obstacle| !obstacle.extent.is_body()) {
            Some(obstacle) => {
                let Extent { from_mm, to_mm, radius_mm } = obstacle.extent;
                Err(JobError::NoBody { name: obstacle.name.clone(), from_mm, to_mm, radius_mm })
            }
            None => Ok(()),
        }
    }

    fn check_raw_part(&self) -> Result<(), JobError> {
        if let Some(bend) = self.raw_part.bend
            && bend.between_mm.0.partial_cmp(&bend.between_mm.1) != Some(core::cmp::Ordering::Less)
        {
            let (from_mm, to_mm) = bend.between_mm;
            return Err(JobError::BentNowhere { from_mm, to_mm });
        }
        let reach_mm = self.raw_part.reach_mm();
        if reach_mm.is_finite() {
            return Ok(());
        }
        let (key, wanted) = (JobKey::RawPart, "made of finite numbers");
        Err(JobError::OutOfRange { place: Subject::Job, key, value: reach_mm, wanted })
    }

    fn check_home(&self) -> Result<(), JobError> {
        let of_job = || Subject::Job;
        for (key, value) in [(JobKey::HomeX, self.home.x_mm), (JobKey::HomeZ, self.home.z_mm)] {
            finite(of_job, key, value)?;
            within(of_job, key, value, (-MAX_LENGTH_MM, MAX_LENGTH_MM), "-10000 to 10000")?;
        }
        finite(of_job, JobKey::PartPhase, self.part_phase_rad)
    }

    /// A spark-out that ends by force needs a force, and turns whose number is not used.
    fn check_spark_out(&self, pass: &PassSpec, machine: &MachineDescription) -> Result<(), JobError> {
        let Some(max_n) = pass.spark_out_until_n else { return Ok(()) };
        let refused = |why| Err(JobError::SparkOutByForce { pass: pass.name.clone(), why });
        if !(1..=MAX_VARIATION_N).contains(&max_n) {
            let (key, value) = (JobKey::SparkOutUntil, f64::from(max_n));
            let place = Subject::Pass(pass.name.clone());
            return Err(JobError::OutOfRange { place, key, value, wanted: "1 to 10000" });
        }
        if machine.contact.is_none() {
            return refused("this machine has no contact model, so there is no force to monitor");
        }
        if self.correction.is_some() {
            return refused(
                "the gauge reads in the turns of spark-out of a job that corrects runout, so all of them are needed",
            );
        }
        if self.rotary_indexing {
            return refused("rotary indexing turns c_axis to where it would be after all turns");
        }
        Ok(())
    }

    /// Checks the requirements of a gauge-controlled size on machine and job.
    fn check_size(&self, pass: &PassSpec, machine: &MachineDescription) -> Result<(), JobError> {
        let Some(size) = pass.gauge_size else { return Ok(()) };
        let place = || Subject::Pass(pass.name.clone());
        let above = (0.0, MAX_SIZE_ABOVE_MM);
        within(place, JobKey::GaugeSizeAbove, size.ends_above_mm, above, "0 to 10 (0 is the finished diameter)")?;
        within(place, JobKey::GaugeSizeBeyond, size.beyond_mm, (0.0, MAX_BEYOND_MM), "0 to 1")?;
        let refused = |why| Err(JobError::NoGaugeSize { pass: pass.name.clone(), why });
        if self.passes.last().is_none_or(|last| last.name != pass.name) {
            return refused("a pass follows that begins where this one ends; give the size to the last pass");
        }
        match machine.gauge.map(|gauge| gauge.kind) {
            Some(GaugeKind::Diameter) => {}
            Some(GaugeKind::Radius) => {
                return refused(
                    "the gauge has a single contact, which reads the deflection of the part as size; use one of two contacts (gauge.kind: diameter)",
                );
            }
            None => return refused("the machine has no in-process gauge"),
        }
        if self.correction.is_some() {
            return refused(
                "runout_correction brings the journal to its size with a turn of its own; leave out one of them",
            );
        }
        if self.c_between_lobes != BetweenLobes::Stops || self.rotary_indexing {
            return refused(
                "c_axis must rest where a cut ends and begin from there: not with c_between_lobes: turns_on or rotary_indexing",
            );
        }
        self.check_gauged("gauge_size")?;
        let is_round = |lobe: &LobeSpec| self.profiles.get(lobe.profile).is_none_or(ProfileSpec::is_round);
        if let Some(lobe) = self.lobes.iter().find(|lobe| !is_round(lobe)) {
            return Err(JobError::SizeNotRound { lobe: lobe.name.clone() });
        }
        if pass.total_infeed_mm <= size.beyond_mm {
            return refused(
                "its total infeed is not more than what it may go beyond the size, which is part of it; raise infeed.total_mm",
            );
        }
        // Passes before it leave what this one takes, but for its infeed beyond the size.
        let left_mm = if self.passes.len() > 1 { pass.total_infeed_mm - size.beyond_mm } else { self.stock_mm };
        let before_mm = 2.0 * left_mm.min(self.stock_mm);
        if size.ends_above_mm >= before_mm {
            let (pass, above_mm) = (pass.name.clone(), size.ends_above_mm);
            return Err(JobError::SizeAboveRaw { pass, above_mm, before_mm });
        }
        Ok(())
    }

    /// Checks the requirements of a runout correction on machine and job.
    fn check_correction(&self, machine: &MachineDescription) -> Result<(), JobError> {
        let Some(correction) = &self.correction else {
            return if self.identification.is_none() { Ok(()) } else { Err(JobError::IdentifiesForNothing) };
        };
        let lacks = |what| Err(JobError::CannotCorrect { machine: machine.name.clone(), what });
        let Some(gauge) = &machine.gauge else { return lacks("in-process gauge") };
        let Some(contact) = &machine.contact else { return lacks("known stiffness (contact)") };
        let seen = (gauge.seen(contact.part_share, machine.cycle_time_s()))
            .map_err(|source| JobError::GaugeSeesNoCut { machine: machine.name.clone(), source })?;
        if correction.mode == GaugingMode::Published && !seen.gauge.fits_published() {
            return Err(JobError::PublishedGauge {
                machine: machine.name.clone(),
                gauge: if seen.gauge.is_two() {
                    "two gauges"
                } else {
                    "a gauge that measures the deflection of the part"
                },
            });
        }
        self.check_published(correction, &seen.gauge)?;
        if let BetweenLobes::TurnsOn { .. } = self.c_between_lobes {
            return Err(JobError::CorrectsAndTurnsOn);
        }
        self.check_gauged("runout_correction")?;
        for lobe in &self.lobes {
            if self.profiles.get(lobe.profile).is_some_and(|profile| !profile.is_round()) {
                return Err(JobError::NotRound { lobe: lobe.name.clone() });
            }
        }
        self.check_identification()?;
        let range = |key, value, wanted| Err(JobError::OutOfRange { place: Subject::Job, key, value, wanted });
        if !(1..=MAX_HARMONICS).contains(&correction.harmonics) {
            return range(JobKey::RunoutCorrectionHarmonics, f64::from(correction.harmonics), "1 to 100");
        }
        if !(correction.allowance_mm >= 0.0 && correction.allowance_mm <= MAX_ALLOWANCE_MM) {
            return range(JobKey::RunoutCorrectionAllowance, correction.allowance_mm, "0 to 0.1");
        }
        if let Some(finishing) = correction.finishing {
            check_finishing(finishing, correction.mode)?;
        }
        if let Some(contact) = correction.contacts.iter().find(|contact| !self.has_lobe(&contact.lobe)) {
            return Err(JobError::KeptElsewhere { lobe: contact.lobe.clone() });
        }
        let is_kept = |lobe: &&LobeSpec| correction.contacts.iter().any(|contact| contact.lobe == lobe.name);
        match self.lobes.iter().find(|lobe| !is_kept(lobe)) {
            Some(lobe) if correction.stiffness == StiffnessSource::Kept && self.identification.is_none() => {
                Err(JobError::NothingKept { lobe: lobe.name.clone() })
            }
            _ => Ok(()),
        }
    }

    /// Checks window and step of the published measurement: a whole turn of depths must lie in the dwell and the turn before it.
    fn check_published(&self, correction: &CorrectionSpec, gauge: &Gauge) -> Result<(), JobError> {
        let PublishedWindow { turned_rad, phases } = correction.published;
        if !(FEWEST_PHASES..=MAX_PHASES).contains(&(phases as usize)) {
            let (key, wanted) = (JobKey::PublishedStep, "8 to 7200 steps in a turn");
            return Err(JobError::OutOfRange { place: Subject::Job, key, value: f64::from(phases), wanted });
        }
        let Some(window_rad) = turned_rad else { return Ok(()) };
        let spark_out_turns = self.passes.last().map_or(0, |pass| pass.spark_out_turns);
        let min_rad = TURN_RAD + gauge.span_rad();
        let max_rad = f64::from(spark_out_turns + 1) * TURN_RAD - DWELL_LEAVES_RAD.0 + gauge.known_after_rad();
        if window_rad >= min_rad * (1.0 - 1e-12) && window_rad <= max_rad {
            return Ok(());
        }
        let [window_deg, min_deg, max_deg] = [window_rad, min_rad, max_rad].map(deg_from_rad);
        Err(JobError::PublishedWindow { window_deg, min_deg, max_deg, spark_out_turns })
    }

    /// Refuses crank pins, wide lobes and lobes with taper or crown under a gauge, which measures about the spindle axis at one position of Z.
    fn check_gauged(&self, key: &'static str) -> Result<(), JobError> {
        if let Some(plunge) = self.lobes.iter().find_map(|lobe| lobe.plunge.as_ref()) {
            return Err(JobError::WideUnderGauge { lobe: plunge.lobe.clone(), key });
        }
        if let Some(lobe) = self.lobes.iter().find(|lobe| lobe.axial.is_some()) {
            return Err(JobError::ShapeUnderGauge { lobe: lobe.name.clone(), key });
        }
        let is_pin = |lobe: &&LobeSpec| self.profiles.get(lobe.profile).is_some_and(ProfileSpec::is_pin);
        match self.lobes.iter().find(is_pin) {
            Some(lobe) => Err(JobError::PinUnderGauge { lobe: lobe.name.clone(), key }),
            None => Ok(()),
        }
    }

    fn has_lobe(&self, name: &str) -> bool {
        self.lobes.iter().any(|lobe| lobe.name == name)
    }

    /// Checks the requirements of the stock measurement on machine and job.
    fn check_stock(&self, machine: &MachineDescription) -> Result<(), JobError> {
        let Some(stock) = &self.measure_stock else { return Ok(()) };
        let lacks = |why| Err(JobError::MeasuresNoStock { why });
        let Some(gauge) = &machine.gauge else { return lacks("the machine has no in-process gauge") };
        if self.c_between_lobes != BetweenLobes::Stops || self.rotary_indexing {
            return lacks(
                "every lobe begins where c_axis stands, so it neither turns on between them nor is turned to them",
            );
        }
        self.check_gauged("measure_stock")?;
        let is_round = |lobe: &LobeSpec| self.profiles.get(lobe.profile).is_none_or(ProfileSpec::is_round);
        if let Some(lobe) = self.lobes.iter().find(|lobe| !is_round(lobe)) {
            return Err(JobError::StockNotRound { lobe: lobe.name.clone() });
        }
        positive(|| Subject::Job, JobKey::MeasureStockSpeed, stock.speed_rad_s)?;
        let wanted = "0.001 to 10000 (0.01 to 95000 rpm)";
        within(|| Subject::Job, JobKey::MeasureStockSpeed, stock.speed_rad_s, WORK_SPEEDS_RAD_S, wanted)?;
        if !(stock.margin_mm > 0.0 && stock.margin_mm <= MAX_MARGIN_MM) {
            let (key, value) = (JobKey::MeasureStockMargin, stock.margin_mm);
            return Err(JobError::OutOfRange { place: Subject::Job, key, value, wanted: "above 0 and at most 2" });
        }
        let unseen_mm = match gauge.kind {
            GaugeKind::Diameter => self.raw_part.unseen_mm(),
            GaugeKind::Radius => 0.0,
        };
        if stock.margin_mm < unseen_mm {
            return Err(JobError::MarginTooSmall { margin_mm: stock.margin_mm, unseen_mm });
        }
        Ok(())
    }

    /// Checks that the learned corrections belong to this job and stay within its limits.
    fn check_compensation(&self) -> Result<(), JobError> {
        let Some(compensation) = &self.compensation else { return Ok(()) };
        if self.correction.is_some() {
            return Err(JobError::LearnsAndCorrects);
        }
        let spec = &compensation.spec;
        let range = |key, value, wanted| Err(JobError::OutOfRange { place: Subject::Job, key, value, wanted });
        if !(spec.gain > 0.0 && spec.gain <= 1.0) {
            return range(JobKey::FormCompensationGain, spec.gain, "above 0 and at most 1");
        }
        if !(1..=MAX_LEARNED_HARMONICS).contains(&spec.harmonics) {
            return range(JobKey::FormCompensationHarmonics, f64::from(spec.harmonics), "1 to 180");
        }
        if !(spec.max_mm > 0.0 && spec.max_mm <= MAX_CORRECTION_MM) {
            return range(JobKey::FormCompensationMax, spec.max_mm, "above 0 and at most 0.1");
        }
        if !(spec.max_slope_mm_rad > 0.0 && spec.max_slope_mm_rad <= MAX_SLOPE_MM_RAD) {
            return range(JobKey::FormCompensationMaxSlope, spec.max_slope_mm_rad, "above 0 and at most 1.146");
        }
        for learned in &compensation.learned {
            if !self.has_lobe(&learned.lobe) {
                return Err(JobError::LearnedElsewhere { lobe: learned.lobe.clone() });
            }
            let (size_mm, slope_mm_rad) = learned.correction.largest();
            // What was bounded lies on the bound, but for rounding on its way through a file.
            if size_mm > spec.max_mm * (1.0 + ROUNDING) || slope_mm_rad > spec.max_slope_mm_rad * (1.0 + ROUNDING) {
                return Err(JobError::LearnedTooMuch {
                    lobe: learned.lobe.clone(),
                    size_mm,
                    slope_mm_rad,
                    max_mm: spec.max_mm,
                    max_slope_mm_rad: spec.max_slope_mm_rad,
                });
            }
        }
        Ok(())
    }

    /// Checks the requirements of the stiffness measurement: two feeds, and a turn in the air before.
    fn check_identification(&self) -> Result<(), JobError> {
        let Some(identification) = &self.identification else { return Ok(()) };
        let feed_mm = |pass: &PassSpec| pass.infeed_per_block_mm * f64::from(self.blocks_per_turn);
        if let Some(pass) = self.passes.iter().find(|pass| !pass.infeed_of_turns_mm.is_empty()) {
            return Err(JobError::FeedsOfTurns { pass: pass.name.clone() });
        }
        let feeds = || self.passes.iter().map(feed_mm);
        let (min_mm, max_mm) = minimum_and_maximum(feeds());
        if max_mm.is_nan() || max_mm < 2.0 * min_mm {
            return Err(JobError::OneFeed { min_mm, max_mm });
        }
        let total_mm: f64 = self.passes.iter().map(|pass| pass.total_infeed_mm).sum();
        let allowance_mm = self.allowance_mm();
        let (air_mm, needed_mm) =
            (total_mm + allowance_mm - self.maximum_stock_mm(), 1.5 * feeds().next().unwrap_or(0.0));
        if air_mm < needed_mm {
            return Err(JobError::NoAir { air_mm, needed_mm });
        }
        length(|| Subject::Job, JobKey::IdentificationPush, identification.push_mm)?;
        positive(|| Subject::Job, JobKey::IdentificationPushSpeed, identification.push_speed_mm_s)?;
        let (key, value) = (JobKey::IdentificationPushSpeed, identification.push_speed_mm_s);
        within(|| Subject::Job, key, value, (1e-6, RAPID_SPEEDS_MM_S.1), "0.000001 to 100000")?;
        positive(|| Subject::Job, JobKey::IdentificationMaxForce, identification.max_n as f64)
    }

    fn check_lobe(&self, index: usize, lobe: &LobeSpec, machine: &MachineDescription) -> Result<(), JobError> {
        for (other_index, other) in self.lobes[..index].iter().enumerate() {
            if other.name == lobe.name {
                let name = lobe.name.clone();
                return Err(JobError::SameName { first: other_index + 1, second: index + 1, name });
            }
            if other.station == lobe.station && !lobe.is_of_one_lobe(other) {
                return Err(JobError::SameStation {
                    first: other.name.clone(),
                    second: lobe.name.clone(),
                    station: lobe.station.clone(),
                });
            }
        }
        if machine.station(&lobe.station).is_none() {
            let known: Vec<&str> = machine.stations.iter().map(|station| station.switch.as_str()).collect();
            return Err(JobError::UnknownStation {
                lobe: lobe.name.clone(),
                station: lobe.station.clone(),
                machine: machine.name.clone(),
                known: if known.is_empty() { String::from("none") } else { known.join(", ") },
            });
        }
        if lobe.profile >= self.profiles.len() {
            return Err(JobError::UnknownProfile {
                lobe: lobe.name.clone(),
                profile: lobe.profile,
                count: self.profiles.len(),
            });
        }
        let place = || Subject::Lobe(lobe.name.clone());
        finite(place, JobKey::Phase, lobe.phase_rad)?;
        within(place, JobKey::Phase, lobe.phase_rad, (-MAX_PHASE_RAD, MAX_PHASE_RAD), "-1000 to 1000")?;
        positive(place, JobKey::Width, lobe.width_mm)?;
        let wheel_mm = machine.wheel_at(lobe.wheel(machine)).width_mm;
        if lobe.width_mm > wheel_mm {
            return Err(JobError::WiderThanWheel { lobe: lobe.name.clone(), width_mm: lobe.width_mm, wheel_mm });
        }
        Ok(())
    }

    /// Lobes stand far enough apart for the wheel to grind one at a time. Both are centred on their stations. Plunges of one lobe overlap.
    fn check_reach(&self, machine: &MachineDescription) -> Result<(), JobError> {
        let place =
            |lobe: &LobeSpec| machine.station(&lobe.station).map(|station| station.position_mm + lobe.offset_mm());
        for (index, lobe) in self.lobes.iter().enumerate() {
            let wheel_mm = machine.wheel_at(lobe.wheel(machine)).width_mm;
            for (other_index, other) in self.lobes.iter().enumerate() {
                let (Some(here), Some(there)) = (place(lobe), place(other)) else { continue };
                let (apart_mm, min_mm) = ((here - there).abs(), 0.5 * (wheel_mm + other.width_mm));
                if index != other_index && apart_mm < min_mm && !lobe.is_of_one_lobe(other) {
                    return Err(JobError::NeighbourInReach {
                        lobe: lobe.name.clone(),
                        wheel_mm,
                        other: other.name.clone(),
                        other_mm: other.width_mm,
                        apart_mm,
                        min_mm,
                    });
                }
            }
        }
        Ok(())
    }

    /// Refuses what does not go with wheels that the job mounts, and wheels that the machine does not mount.
    fn check_wheels(&self, machine: &MachineDescription) -> Result<(), JobError> {
        let wheels = self.wheels_in_order();
        if wheels.is_empty() {
            return Ok(());
        }
        let Some(changer) = &machine.wheel_changer else {
            return Err(JobError::NoWheelChanger { machine: machine.name.clone() });
        };
        if let Some(index) = wheels.iter().copied().find(|index| *index >= changer.wheels.len()) {
            let (machine, count) = (machine.name.clone(), changer.wheels.len());
            return Err(JobError::UnknownWheel { index, machine, count });
        }
        let has_plunge_in_visits = self
            .lobes
            .iter()
            .any(|lobe| lobe.plunge.is_some() && lobe.passes(self.passes.len()).len() < self.passes.len());
        let with = [
            (self.correction.is_some(), "runout_correction"),
            (self.identification.is_some(), "a stiffness measurement"),
            (self.measure_stock.is_some(), "measure_stock"),
            (matches!(self.c_between_lobes, BetweenLobes::TurnsOn { .. }), "c_between_lobes: turns_on"),
            (has_plunge_in_visits, "a lobe wider than the wheel whose passes have different wheels"),
        ];
        if let Some((_, with)) = with.into_iter().find(|(is_set, _)| *is_set) {
            return Err(JobError::NotWithWheels { with });
        }
        if self.home.x_mm < changer.min_x_mm {
            let (home_mm, min_mm, machine) = (self.home.x_mm, changer.min_x_mm, machine.name.clone());
            return Err(JobError::ChangeTooNear { home_mm, min_mm, machine });
        }
        Ok(())
    }

    /// Refuses lobes of several sections with more of them than a machine reports, or with the name of another lobe.
    fn check_sections(&self) -> Result<(), JobError> {
        let count = self.lobes.iter().map(LobeSpec::section_count).sum();
        if count > MAX_SECTIONS && self.lobes.iter().any(|lobe| lobe.plunge.is_some() || lobe.axial.is_some()) {
            return Err(JobError::SectionCount { count, max: MAX_SECTIONS });
        }
        self.check_section_names()
    }
}

/// Checks ranges of finishing turns. Their number by force depends on the contact of a journal, which is known later.
fn check_finishing(finishing: FinishingSpec, mode: GaugingMode) -> Result<(), JobError> {
    let job = || Subject::Job;
    let turns_within =
        |key, turns: u32| within(job, key, f64::from(turns), (1.0, f64::from(MAX_FINISHING_TURNS)), "1 to 20");
    match finishing {
        FinishingSpec::PerTurn { per_turn_mm, turns } => {
            let wanted = "above 0 and at most 0.05";
            within(job, JobKey::FinishingDepth, per_turn_mm, (f64::MIN_POSITIVE, MAX_FINISHING_MM), wanted)?;
            turns_within(JobKey::FinishingTurns, turns)
        }
        FinishingSpec::ByForce { stock_mm, force_n, max_turns } => {
            if mode == GaugingMode::Published {
                return Err(JobError::FinishingByForcePublished);
            }
            turns_within(JobKey::FinishingMaxTurns, max_turns)?;
            let wanted = "above 0 and at most 20000";
            within(job, JobKey::FinishingForce, force_n, (f64::MIN_POSITIVE, MAX_FINISHING_N), wanted)?;
            let wanted = "above 0 and at most 1";
            within(job, JobKey::FinishingStock, stock_mm, (f64::MIN_POSITIVE, MAX_FINISHING_STOCK_MM), wanted)?;
            let max_mm = f64::from(max_turns) * MAX_FINISHING_MM;
            match stock_mm <= max_mm * (1.0 + 1e-12) {
                true => Ok(()),
                false => Err(JobError::FinishingStock { stock_mm, max_mm, max_turns }),
            }
        }
    }
}

fn positive(place: impl Fn() -> Subject, key: JobKey, value: f64) -> Result<(), JobError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(JobError::OutOfRange { place: place(), key, value, wanted: "a number above 0" })
}

fn length(place: impl Fn() -> Subject, key: JobKey, value: f64) -> Result<(), JobError> {
    positive(&place, key, value)?;
    within(place, key, value, (0.0, MAX_LENGTH_MM), "above 0 and at most 10000")
}

pub(super) fn within(
    place: impl Fn() -> Subject,
    key: JobKey,
    value: f64,
    (min, max): (f64, f64),
    wanted: &'static str,
) -> Result<(), JobError> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(JobError::OutOfRange { place: place(), key, value, wanted })
}

fn finite(place: impl Fn() -> Subject, key: JobKey, value: f64) -> Result<(), JobError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(JobError::OutOfRange { place: place(), key, value, wanted: "a finite number" })
}
