// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Visits of the wheels of a changer to the lobes of a part.
//!
//! A lobe is ground by one wheel or, where its passes name several, by one after the other. Every run of passes with one wheel is a visit. The
//! lobes of a job are then its visits: first those with the first passes of all lobes, then those with the next. The last visit to a lobe has
//! the name of the lobe; an earlier one has the name of its last pass too.

use super::error::JobError;
use super::grinding::{JobSpec, LobeSpec, PassSpec};
use crate::machine::description::MachineDescription;
use alloc::string::String;
use alloc::vec::Vec;
use core::ops::Range;

/// Largest distance above the material at which a later wheel begins its infeed (mm).
pub const MAX_WHEEL_APPROACH_MM: f64 = 2.0;

/// Passes of one wheel of a changer on a lobe.
#[derive(Debug, Clone, PartialEq)]
pub struct WheelVisit {
    /// Name of the lobe.
    pub lobe: String,
    /// Position of the wheel in the changer.
    pub wheel: usize,
    /// Its first pass among those of the job.
    pub first_pass: usize,
    /// Number of its passes.
    pub pass_count: usize,
    /// The lobe is finished with it.
    pub is_last: bool,
}

impl WheelVisit {
    /// Its passes among those of a job.
    #[must_use]
    pub fn passes(&self) -> Range<usize> {
        self.first_pass..self.first_pass + self.pass_count
    }
}

impl LobeSpec {
    /// Passes of a job, of this count, that grind this.
    #[must_use]
    pub fn passes(&self, count: usize) -> Range<usize> {
        self.visit.as_ref().map_or(0..count, WheelVisit::passes)
    }

    /// Position of the wheel that grinds this; on a machine without a changer, and where the job names none, the mounted one.
    #[must_use]
    pub fn wheel(&self, machine: &MachineDescription) -> usize {
        wheel_of(self.visit.as_ref(), machine)
    }

    /// The lobe is finished with this, or a section of it.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        finishes(self.visit.as_ref())
    }

    /// Both are visits of wheels to one lobe.
    #[must_use]
    pub fn visits_with(&self, other: &Self) -> bool {
        visit_together(self.visit.as_ref(), other.visit.as_ref())
    }
}

/// Position of the wheel that grinds a lobe, or visit to one; the mounted one where the job names none.
pub(crate) fn wheel_of(visit: Option<&WheelVisit>, machine: &MachineDescription) -> usize {
    visit.map_or_else(|| machine.mounted_wheel(), |visit| visit.wheel)
}

/// The lobe is finished with this visit, or with the only one.
pub(crate) fn finishes(visit: Option<&WheelVisit>) -> bool {
    visit.is_none_or(|visit| visit.is_last)
}

/// Both are visits of wheels to one lobe.
pub(crate) fn visit_together(one: Option<&WheelVisit>, other: Option<&WheelVisit>) -> bool {
    matches!((one, other), (Some(one), Some(other)) if one.lobe == other.lobe)
}

impl JobSpec {
    /// Passes that grind the lobe, or visit to one, with this index.
    #[must_use]
    pub fn passes_of(&self, lobe: usize) -> &[PassSpec] {
        let passes = self.lobes.get(lobe).map(|lobe| lobe.passes(self.passes.len()));
        passes.and_then(|passes| self.passes.get(passes)).unwrap_or_default()
    }

    /// Index of a pass of the job among the passes of the lobe, or visit to one, with this index; `None` if another visit grinds it.
    #[must_use]
    pub fn pass_of(&self, lobe: usize, pass: usize) -> Option<usize> {
        let passes = self.lobes.get(lobe)?.passes(self.passes.len());
        passes.contains(&pass).then(|| pass - passes.start)
    }

    /// Indices of all visits to the lobe of the one with this index, in their order; the index alone without visits.
    #[must_use]
    pub fn visits_of(&self, lobe: usize) -> Vec<usize> {
        let here = self.lobes.get(lobe);
        let is_visit = |other: &usize| *other == lobe || here.is_some_and(|here| self.lobes[*other].visits_with(here));
        (0..self.lobes.len()).filter(is_visit).collect()
    }

    /// Index of the visit to the same lobe before the one with this index.
    #[must_use]
    pub fn visit_before(&self, lobe: usize) -> Option<usize> {
        self.visits_of(lobe).into_iter().rfind(|visit| *visit < lobe)
    }

    /// Material above the contour where grinding of the lobe, or visit to one, with this index begins (mm): the stock, or what the passes
    /// before it leave.
    #[must_use]
    pub fn stock_of_mm(&self, lobe: usize) -> f64 {
        self.left_before_mm(lobe).unwrap_or(self.stock_mm)
    }

    /// The same where it is most, with what the raw part deviates by (mm).
    #[must_use]
    pub fn maximum_stock_of_mm(&self, lobe: usize) -> f64 {
        self.left_before_mm(lobe).unwrap_or_else(|| self.maximum_stock_mm())
    }

    /// Material that the passes before a visit leave (mm); `None` where it is the first.
    fn left_before_mm(&self, lobe: usize) -> Option<f64> {
        let first = self.lobes.get(lobe)?.visit.as_ref()?.first_pass;
        (first > 0).then(|| self.left_after_mm(first))
    }

    /// Material that the passes before the one with this index leave, by their infeeds (mm).
    #[must_use]
    pub fn left_after_mm(&self, pass: usize) -> f64 {
        let later = self.passes.get(pass..).unwrap_or_default();
        let beyond_mm = self.size_control().map_or(0.0, |size| size.beyond_mm);
        later.iter().map(|pass| pass.total_infeed_mm - pass.air_mm).sum::<f64>() + self.allowance_mm() - beyond_mm
    }

    /// Puts the visits of several wheels in the place of the lobes. `wheels` has the wheel of every lobe and pass, by lobe. The first pass of
    /// a later wheel begins `approach_mm` above what the pass before it leaves (mm); the approach is part of its infeed.
    ///
    /// # Errors
    /// An approach that is not above 0, too long, or all of the pass.
    pub fn visit_by_wheels(&mut self, wheels: &[Vec<usize>], approach_mm: f64) -> Result<(), JobError> {
        if !(approach_mm > 0.0 && approach_mm <= MAX_WHEEL_APPROACH_MM) {
            return Err(JobError::WheelApproach { approach_mm });
        }
        let mut visits: Vec<LobeSpec> = Vec::new();
        for (lobe, wheels) in self.lobes.iter().zip(wheels) {
            let mut first_pass = 0;
            for of_wheel in wheels.chunk_by(|one, other| one == other) {
                let pass_count = of_wheel.len();
                let is_last = first_pass + pass_count == wheels.len();
                let name = match self.passes.get(first_pass + pass_count - 1) {
                    Some(pass) if !is_last => alloc::format!("{}-{}", lobe.name, pass.name),
                    _ => lobe.name.clone(),
                };
                let visit = WheelVisit { lobe: lobe.name.clone(), wheel: of_wheel[0], first_pass, pass_count, is_last };
                visits.push(LobeSpec { name, visit: Some(visit), ..lobe.clone() });
                first_pass += pass_count;
            }
        }
        // A stable order: lobes stay in theirs.
        visits.sort_by_key(|lobe| lobe.visit.as_ref().map_or(0, |visit| visit.first_pass));
        let is_approached = |pass: usize| {
            pass > 0 && visits.iter().filter_map(|lobe| lobe.visit.as_ref()).any(|visit| visit.first_pass == pass)
        };
        for (_, pass) in self.passes.iter_mut().enumerate().filter(|(index, _)| is_approached(*index)) {
            let (total_mm, name) = (pass.total_infeed_mm, &pass.name);
            if approach_mm >= total_mm {
                return Err(JobError::ApproachBeyondInfeed { pass: name.clone(), approach_mm, total_mm });
            }
            pass.air_mm = approach_mm;
        }
        self.lobes = visits;
        Ok(())
    }

    /// Wheels in the order in which the job mounts them: one more than its changes; empty where it names none.
    #[must_use]
    pub fn wheels_in_order(&self) -> Vec<usize> {
        let mut wheels: Vec<usize> = self.lobes.iter().filter_map(|lobe| Some(lobe.visit.as_ref()?.wheel)).collect();
        wheels.dedup();
        wheels
    }
}
