// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Runout as JTEKT's text measures it, step by step (S20 to S27).
//!
//! Readings are taken over 540° while the wheel grinds on (S20 to S24), `U_c` = `D_c` − `D_(c+180)` for a turn of them (S25),
//! `ΔU_c` = `U_c` − min U (S26), and `IR_c` = `ΔU_c` · kg/km (S27). The correction (S30, S31) is
//! [`Correction::published`](super::correction::Correction::published).
//!
//! To the letter the text leaves two things open. It numbers readings by the spindle phase at which they are taken and corrects by the
//! phase at the wheel; here every U belongs to the phase that was cut, by the gauge's geometry. And IR holds where the wheel stood
//! still: with the infeed running on, U grows by what the machine still deflects, and the runout of a phase that is cut again before
//! the correction begins is λ of what was measured. Both are in what is left; the exact mode knows them.

use super::record::GaugeRecord;
use super::runout::{FEWEST_PHASES, PhasesError, RadiusByPhase, phase_rad};
use super::state::MAX_PHASES;
use crate::machine::contact_law::ContactLaw;
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;
use thiserror::Error;

/// Rounding tolerance of an angle (rad).
const ROUNDING_RAD: f64 = 1e-9;

/// Window and step of the published measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedWindow {
    /// Turn of C over which readings are taken (rad); `None`: a turn and the angle between two readings, the 540° of the text.
    pub turned_rad: Option<f64>,
    /// Steps of a turn: 72 are the 5° of the text.
    pub phases: u32,
}

impl Default for PublishedWindow {
    fn default() -> Self {
        Self { turned_rad: None, phases: 72 }
    }
}

/// Why there is no published measurement.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PublishedError {
    /// The window is not full.
    #[error("readings reach {turned_deg:.2} deg from the start of the window, {needed_deg:.2} deg are needed")]
    WindowTooShort {
        /// Available angle (deg).
        turned_deg: f64,
        /// Window: 540° of a diameter (deg).
        needed_deg: f64,
    },
    /// Phases that are too few or too many.
    #[error("{phases} phases: between {min} and {max} are needed")]
    Phases { phases: usize, min: usize, max: usize },
    /// A depth that is no number.
    #[error(transparent)]
    Depth(#[from] PhasesError),
}

/// Result of the published steps.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedRunout {
    /// U by phase (mm).
    pub depths_mm: Vec<f64>,
    /// IR by phase (mm).
    pub runout: RadiusByPhase,
    /// C at the first and last reading of the window (rad): 540° apart of a diameter.
    pub window_rad: (f64, f64),
}

impl PublishedRunout {
    /// From the window that begins at `from_rad`, at `phases` equal steps: 72 are the 5° of the text.
    ///
    /// # Errors
    /// A record that does not fill the window; phases too few or too many.
    pub fn measure(
        record: &GaugeRecord<'_>,
        law: &ContactLaw,
        from_rad: f64,
        phases: usize,
    ) -> Result<Self, PublishedError> {
        if !(FEWEST_PHASES..=MAX_PHASES).contains(&phases) {
            return Err(PublishedError::Phases { phases, min: FEWEST_PHASES, max: MAX_PHASES });
        }
        let gauge = record.gauge();
        let first_rad = gauge.cut_following_rad(from_rad).max(record.first_cut_rad());
        let start_rad = first_rad - gauge.cut_after_rad();
        let needed_rad = TURN_RAD + gauge.span_rad();
        let too_short = PublishedError::WindowTooShort {
            turned_deg: deg_from_rad(record.end_rad() - start_rad),
            needed_deg: deg_from_rad(needed_rad),
        };
        let mut depths_mm = Vec::with_capacity(phases);
        for index in 0..phases {
            let phase_rad = phase_rad(index, phases);
            let turn = libm::ceil((first_rad - ROUNDING_RAD - phase_rad) / TURN_RAD);
            depths_mm.push(record.depth_mm(phase_rad + turn * TURN_RAD).ok_or(too_short)?);
        }
        let min = depths_mm.iter().fold(f64::INFINITY, |min, depth| min.min(*depth));
        let ratio = law.grinding_n_mm() / law.machine_n_mm();
        let runout = RadiusByPhase::new(depths_mm.iter().map(|depth| (depth - min) * ratio).collect())?;
        Ok(Self { depths_mm, runout, window_rad: (start_rad, start_rad + needed_rad) })
    }
}
