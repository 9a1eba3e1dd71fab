// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Specification of a grinding job: the lobes of a part, their profiles, and the settings of the grinding cycle. Pure data; files are read
//! elsewhere.
//!
//! The settings are those of the digital switches of JPS6156064B2 (rapid advance R0, total infeed RT, rapid speed F0,
//! infeed per block ΔR, phase angles α1…αn) and what the patent leaves out: spark-out, stock, work speed.
//!
//! Angles. C = 0 is where the origin signal comes: the centre of the keyway faces the wheel. With the machine's
//! rotation sense σ, the azimuth of the wheel line seen from the part is σ·C, measured from the keyway, and in the
//! frame of lobe j it is θ = σ·C − αj. Block k of a table of N blocks begins at θ = k·2π/N.

use crate::cam::compensation::Compensation;
use crate::cam::contour::{Contour, ContourError};
use crate::cam::follower::Follower;
use crate::cam::form_tolerance::FormTolerance;
use crate::cam::lift::LiftLaw;
use crate::gauging::GaugingMode;
use crate::gauging::finishing::FinishingSpec;
use crate::gauging::published::PublishedWindow;
use crate::job::dressing::DressingSpec;
use crate::job::part_support::PartSupport;
use crate::job::plunges::Plunge;
use crate::job::raw_part::RawPart;
use crate::job::speed_variation::SpeedVariation;
use crate::job::wheel_visit::WheelVisit;
use crate::machine::axial_profile::AxialProfile;
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::ReferenceCut;
use crate::machine::fixture::Extent;
use alloc::string::String;
use alloc::vec::Vec;

pub use crate::job::error::{JobError, OtherRim};
pub use crate::job::key::{JobKey, Subject};

/// One profile: the shape that one or more lobes of the part have.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileSpec {
    pub name: String,
    /// Lift law: follower displacement above the base circle over the cam angle.
    pub lift: LiftLaw,
    /// The follower for which the lift is given.
    pub follower: Follower,
    /// Radius of the base circle (mm).
    pub base_radius_mm: f64,
    /// Distance of the centre of a crank pin from the spindle axis, in the direction of cam angle 0 (mm); 0 for every other profile.
    pub throw_mm: f64,
    /// It is the wall of a bore: the part is outside of it, and the wheel inside.
    pub is_bore: bool,
}

impl ProfileSpec {
    /// It has no lift, about the spindle axis, and the part inside: a journal.
    #[must_use]
    pub fn is_round(&self) -> bool {
        self.lift.max_lift_mm() - self.lift.min_lift_mm() < ROUND_MM && !self.is_pin() && !self.is_bore
    }

    /// It is a crank pin, or a disc that misses the spindle axis.
    #[must_use]
    pub fn is_pin(&self) -> bool {
        self.throw_mm != 0.0
    }

    /// Outline of the finished lobe.
    ///
    /// # Errors
    /// See [`Contour::from_lift`], [`Contour::pin`] and [`Contour::bore`]; a throw with a lift.
    pub fn contour(&self) -> Result<Contour, ContourError> {
        let contour = self.outer_contour()?;
        if self.is_bore { contour.bore() } else { Ok(contour) }
    }

    fn outer_contour(&self) -> Result<Contour, ContourError> {
        if !self.is_pin() {
            return Contour::from_lift(&self.lift, &self.follower, self.base_radius_mm);
        }
        let max_lift_mm = self.lift.max_lift_mm().max(-self.lift.min_lift_mm());
        if max_lift_mm >= ROUND_MM {
            return Err(ContourError::PinWithLift { throw_mm: self.throw_mm, max_lift_mm });
        }
        Contour::pin(self.throw_mm, self.base_radius_mm)
    }
}

/// A lift below this is none (mm): what a formula of no lift rounds to.
const ROUND_MM: f64 = 1e-9;

/// Stiffness used to correct the runout of a journal on which it is not measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StiffnessSource {
    /// The stored stiffness of the machine if it covers the journal; otherwise that of the machine's description.
    #[default]
    Best,
    /// The stored stiffness of the machine; without it the job is refused.
    Kept,
    /// That of the machine's description.
    Nominal,
}

/// The contact of a journal as it was kept for the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownContact {
    /// Name of the journal.
    pub lobe: String,
    pub law: ContactLaw,
}

/// Runout correction of journals.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionSpec {
    pub mode: GaugingMode,
    /// Number of harmonics of the part resolved in the gauge readings.
    pub harmonics: u32,
    /// Window and step of the published measurement.
    pub published: PublishedWindow,
    /// Turns after the correction, which then leaves their depth.
    pub finishing: Option<FinishingSpec>,
    /// Material that the passes leave for the turn that corrects (mm): more than what the part may be smaller than where X stands.
    pub allowance_mm: f64,
    /// Source of the stiffness where it is not measured.
    pub stiffness: StiffnessSource,
    /// Stored contacts of the machine at the time of planning.
    pub contacts: Vec<KnownContact>,
}

/// Measurement of the stiffness of machine and cut on every journal, before its correction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdentificationSpec {
    /// Distance by which the stopped wheel pushes the ground journal (mm).
    pub push_mm: f64,
    /// Speed of the push (mm/s).
    pub push_speed_mm_s: f64,
    /// Force at which the machine stops (N).
    pub max_n: i64,
    /// It is measured and no more: the journals stay as the passes leave them.
    pub only: bool,
    /// Replaces the stored values of the machine.
    pub afresh: bool,
}

/// Measurement of the stock of every journal before anything is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StockSpec {
    /// Minimum start of the infeed above the measured stock (mm). Two opposed contacts do not see eccentricity, nor waves of an odd count;
    /// the margin covers them.
    pub margin_mm: f64,
    /// Speed of a journal under the gauge (rad/s).
    pub speed_rad_s: f64,
}

/// Most that the infeed may begin above the measured stock (mm): what is more is no measurement's to save.
pub const MAX_MARGIN_MM: f64 = 2.0;

/// Most that may be left for the turn that corrects (mm): it is cut in a single turn.
pub const MAX_ALLOWANCE_MM: f64 = 0.1;

/// One lobe of the part.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeSpec {
    /// Name, for example `I1`.
    pub name: String,
    /// Limit switch of the station at which the lobe stands in front of the wheel.
    pub station: String,
    /// Phase angle α: from the keyway to cam angle 0 of the lobe (block 0 of its table, with the patent the centre of its
    /// base), positive in the direction in which the table is read (rad). The patent's own α counts the other way.
    pub phase_rad: f64,
    /// Index of its profile in [`JobSpec::profiles`].
    pub profile: usize,
    /// Width along the part's axis (mm); of a plunge the width of the wheel.
    pub width_mm: f64,
    /// Allowed form error.
    pub tolerance: FormTolerance,
    /// Plunge of a lobe wider than the wheel that this is; `None`: the wheel covers the lobe.
    pub plunge: Option<Plunge>,
    /// Visit of one wheel of a changer that this is; `None`: all passes are ground by the mounted wheel.
    pub visit: Option<WheelVisit>,
    /// Taper and crown over its width, of a lobe that is ground and measured in three sections; `None`: it is straight.
    pub axial: Option<AxialProfile>,
}

/// Speed law of the headstock over the lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpeedLaw {
    /// One work speed for the whole pass, between bounded ramps.
    ConstantWorkSpeed {
        /// Headstock speed (rad/s).
        work_speed_rad_s: f64,
    },
    /// The contact runs along the contour at one speed wherever the axes can follow.
    ConstantFootprintSpeed {
        /// Speed of the contact along the contour (mm/s).
        footprint_speed_mm_s: f64,
        /// Largest headstock speed (rad/s).
        max_rad_s: f64,
    },
    /// One specific removal rate Q′ wherever the axes can follow, for the infeed of a whole turn.
    ConstantRemovalRate {
        /// Q′, volume removed per time and wheel width (mm²/s, that is mm³/(mm s)).
        removal_rate_mm2_s: f64,
        /// Largest headstock speed (rad/s).
        max_rad_s: f64,
    },
    /// One specific removal rate Q′ by the published law of radial stock, ω = k/(ρ dφ/dC): the same depth along every radius of the
    /// contour, in polar coordinates ρ(φ) about the spindle axis.
    ConstantRadialRemovalRate {
        /// Q′ of the radial stock (mm²/s).
        removal_rate_mm2_s: f64,
        /// Largest headstock speed (rad/s).
        max_rad_s: f64,
    },
    /// One power of the wheel spindle per width: what chips take and what rubbing takes, P′ = e·Q′ + p·l·v.
    ConstantPower {
        /// P′ (W/mm).
        power_w_mm: f64,
        /// e, energy that a removed volume takes (J/mm³).
        specific_energy_j_mm3: f64,
        /// p, force of rubbing per area of contact (N/mm²).
        rubbing_n_mm2: f64,
        /// Largest headstock speed (rad/s).
        max_rad_s: f64,
    },
    /// One largest temperature in the contact, by comparison with a cut that is known to be good.
    ConstantTemperature {
        reference: ReferenceCut,
        /// Largest headstock speed (rad/s).
        max_rad_s: f64,
    },
    /// The fastest speed that the axes allow.
    TimeOptimal {
        /// Largest headstock speed (rad/s).
        max_rad_s: f64,
    },
}

/// Power of the wheel's spindle and power demand of grinding. It bounds every pass, for any speed law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelPower {
    /// Most that the spindle may give to the cut (W).
    pub max_w: f64,
    /// Energy that a removed volume takes (J/mm³).
    pub specific_energy_j_mm3: f64,
    /// Force of rubbing per area of contact (N/mm²).
    pub rubbing_n_mm2: f64,
}

impl WheelPower {
    /// The law that uses all of it on a lobe of this width (mm).
    #[must_use]
    pub fn as_law(&self, width_mm: f64) -> SpeedLaw {
        SpeedLaw::ConstantPower {
            power_w_mm: self.max_w / width_mm,
            specific_energy_j_mm3: self.specific_energy_j_mm3,
            rubbing_n_mm2: self.rubbing_n_mm2,
            max_rad_s: f64::INFINITY,
        }
    }
}

impl SpeedLaw {
    /// The work speed, or the largest one that the law may use (rad/s).
    #[must_use]
    pub const fn maximum_rad_s(&self) -> f64 {
        match *self {
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s } => work_speed_rad_s,
            SpeedLaw::ConstantFootprintSpeed { max_rad_s, .. }
            | SpeedLaw::ConstantRemovalRate { max_rad_s, .. }
            | SpeedLaw::ConstantRadialRemovalRate { max_rad_s, .. }
            | SpeedLaw::ConstantPower { max_rad_s, .. }
            | SpeedLaw::ConstantTemperature { max_rad_s, .. }
            | SpeedLaw::TimeOptimal { max_rad_s } => max_rad_s,
        }
    }

    /// Its settings by name, for checks.
    pub(crate) fn settings(&self) -> Vec<(JobKey, f64)> {
        match *self {
            SpeedLaw::ConstantWorkSpeed { work_speed_rad_s } => alloc::vec![(JobKey::WorkSpeed, work_speed_rad_s)],
            SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s, max_rad_s } => {
                alloc::vec![(JobKey::FootprintSpeed, footprint_speed_mm_s), (JobKey::WorkSpeed, max_rad_s)]
            }
            SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, max_rad_s }
            | SpeedLaw::ConstantRadialRemovalRate { removal_rate_mm2_s, max_rad_s } => {
                alloc::vec![(JobKey::RemovalRate, removal_rate_mm2_s), (JobKey::WorkSpeed, max_rad_s)]
            }
            SpeedLaw::ConstantPower { power_w_mm, specific_energy_j_mm3, rubbing_n_mm2, max_rad_s } => alloc::vec![
                (JobKey::Power, power_w_mm),
                (JobKey::SpecificEnergy, specific_energy_j_mm3),
                (JobKey::Rubbing, rubbing_n_mm2),
                (JobKey::WorkSpeed, max_rad_s)
            ],
            SpeedLaw::ConstantTemperature { reference, max_rad_s } => alloc::vec![
                (JobKey::ReferenceFootprintSpeed, reference.footprint_speed_mm_s),
                (JobKey::ReferenceDepth, reference.depth_mm),
                (JobKey::ReferenceEquivalentDiameter, reference.equivalent_diameter_mm),
                (JobKey::WorkSpeed, max_rad_s)
            ],
            SpeedLaw::TimeOptimal { max_rad_s } => alloc::vec![(JobKey::WorkSpeed, max_rad_s)],
        }
    }
}

/// Over what the wheel comes closer to the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InfeedCourse {
    /// The same amount in every block: a spiral, as in JPS6156064B2.
    #[default]
    PerAngle,
    /// Once per turn, on the base circle, by the amount of a whole turn; between two steps the depth stays.
    PerTurn,
}

/// Along what the infeed is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InfeedDirection {
    /// Along X, as JPS6156064B2 has it: on a flank the depth of cut is the infeed times the cosine of the contour angle.
    #[default]
    X,
    /// Along the contour's normal: the depth of cut is the same all round, and X moves more where the normal lies askew.
    Normal,
}

impl InfeedDirection {
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            InfeedDirection::X => "x_axis",
            InfeedDirection::Normal => "the contour's normal",
        }
    }
}

/// Effect of a hold in the cut. A cancel always retracts the wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HoldInCut {
    /// The wheel leaves the part while C keeps turning.
    #[default]
    Retract,
    /// The infeed stops while C keeps turning: the wheel sparks out where it is.
    StopInfeed,
}

/// Motion of C between two lobes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum BetweenLobes {
    /// It stops: every lobe is ground from rest to rest.
    #[default]
    Stops,
    /// It turns on: the next cut begins at the phase with which C is predicted to arrive.
    TurnsOn {
        /// Permitted delay of the table against the prediction before the phase is missed (s).
        margin_s: f64,
    },
}

/// Gauge-controlled size: the infeed of a pass ends when the gauge reads a diameter. The planned infeed is its upper bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeControl {
    /// Diameter above the finished one, as the mean of a turn (mm).
    pub ends_above_mm: f64,
    /// Infeed of X beyond the finished size (mm): for a wheel that is smaller than it should be.
    pub beyond_mm: f64,
}

/// One pass over a lobe: turns with infeed, then turns without.
#[derive(Debug, Clone, PartialEq)]
pub struct PassSpec {
    pub name: String,
    /// RT, total infeed (mm).
    pub total_infeed_mm: f64,
    /// Part of it before the wheel meets what the pass before it left (mm): that of a wheel that is mounted for this pass.
    pub air_mm: f64,
    /// ΔR, infeed per block (mm); N blocks of it are the infeed of a turn, however that is spread.
    pub infeed_per_block_mm: f64,
    /// Infeed of each turn (mm), of which `infeed_per_block_mm` is the mean; empty: the same in every turn.
    pub infeed_of_turns_mm: Vec<f64>,
    /// Over what the wheel comes closer.
    pub infeed_course: InfeedCourse,
    /// Along what the infeed is measured; the same in all passes.
    pub infeed_direction: InfeedDirection,
    /// Turns without infeed at the end, at least 1: the spiral infeed leaves a step that only they remove.
    pub spark_out_turns: u32,
    /// Variation of the normal force over a turn (N) at which they end; `None`: all of them are turned.
    pub spark_out_until_n: Option<u32>,
    /// Size on the gauge that ends the infeed, of the last pass; `None`: all of the infeed is driven.
    pub gauge_size: Option<SizeControl>,
    /// Speed of the headstock.
    pub speed: SpeedLaw,
}

/// Position of the axes before and after a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HomePosition {
    /// `x_axis` (mm): the wheel is clear of every lobe here.
    pub x_mm: f64,
    /// `z_axis` (mm).
    pub z_mm: f64,
}

/// A job: one part.
#[derive(Debug, Clone, PartialEq)]
pub struct JobSpec {
    pub name: String,
    /// Profiles, used by the lobes by index.
    pub profiles: Vec<ProfileSpec>,
    /// Lobes, in the order of machining.
    pub lobes: Vec<LobeSpec>,
    /// N, blocks in one turn: the unit angle Δθ of the infeed and of the read start is 2π/N.
    pub blocks_per_turn: u32,
    /// R0, rapid advance from the retracted position to just before the blank (mm).
    pub rapid_advance_mm: f64,
    /// F0, speed of rapid advance and retract (mm/s).
    pub rapid_speed_mm_s: f64,
    /// Stock of the blank: material above the contour, along its normal (mm).
    pub stock_mm: f64,
    /// Passes over each lobe, in order, each from rest to rest at the same phase and from where the one before ended.
    pub passes: Vec<PassSpec>,
    /// Distance by which a hold or a cancel takes the wheel off the part (mm).
    pub retract_clearance_mm: f64,
    /// Effect of a hold in the cut.
    pub hold_in_cut: HoldInCut,
    /// Work speed that differs from turn to turn, in all passes; `None`: it does not.
    pub speed_variation: Option<SpeedVariation>,
    /// Bound on the power of the wheel's spindle, if there is one.
    pub wheel_power: Option<WheelPower>,
    /// Motion of C between two lobes.
    pub c_between_lobes: BetweenLobes,
    /// The conventional way: C is turned to each lobe's base centre before it is machined.
    pub rotary_indexing: bool,
    /// Position of the axes before and after the part.
    pub home: HomePosition,
    /// When the wheel is dressed; `None`: never in this job.
    pub dressing: Option<DressingSpec>,
    /// Features of the part in addition to its lobes: shoulders, journals.
    pub obstacles: Vec<ObstacleSpec>,
    /// Clearance of the wheel from everything but the lobe it grinds (mm).
    pub clearance_mm: f64,
    /// Wheels that single lobes or passes ask for. The machine has one.
    pub wheels: Vec<WheelRequirement>,
    /// Deviation of the raw part from the design.
    pub raw_part: RawPart,
    /// Elastic support of the part; `None`: the part is as stiff as the machine's contact says.
    pub part_support: Option<PartSupport>,
    /// Runout correction of its journals; `None`: off. With it every lobe is a journal.
    pub correction: Option<CorrectionSpec>,
    /// Form compensation from part to part, with the learned corrections; `None`: every part is ground as designed.
    pub compensation: Option<Compensation>,
    /// Stand-off of the wheel (mm) in a dry run, which cuts nothing; `None`: it grinds.
    pub dry_run_mm: Option<f64>,
    /// Azimuth of the part's keyway as it is clamped, where it was found (rad). The phases of the lobes have it in them.
    pub part_phase_rad: f64,
    /// Stiffness measurement before that; `None`: that of the machine's description counts.
    pub identification: Option<IdentificationSpec>,
    /// Stock measurement of its journals before anything is cut, to skip turns in the air; `None`: the stock is that of the job.
    pub measure_stock: Option<StockSpec>,
}

/// A body of revolution on the part that is not ground.
#[derive(Debug, Clone, PartialEq)]
pub struct ObstacleSpec {
    pub name: String,
    /// Position and size, in the positions of the stations.
    pub extent: Extent,
}

/// A wheel that a lobe or a pass asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct WheelRequirement {
    /// The lobe or the pass.
    pub of: Subject,
    /// Its radius (mm).
    pub radius_mm: f64,
}

/// Maximum number of turns without infeed of a pass; more is a typing error.
pub const MAX_SPARK_OUT_TURNS: u32 = 1000;

/// Least and largest part of the work speed that a variation takes off, and turns of its period. In a period of one turn every place would
/// be ground at one speed always; in a long one the waves of each speed have time to grow.
pub const SLOWER_SHARES: (f64, f64) = (0.01, 0.75);
pub const VARIATION_PERIODS_TURNS: (f64, f64) = (1.5, 3.0);

/// Largest variation of the force at which spark-out may end (N): more is no spark-out.
pub const MAX_VARIATION_N: u32 = 10_000;

/// Largest diameter above the finished one at which an infeed may end, and largest infeed beyond the finished size (mm).
pub const MAX_SIZE_ABOVE_MM: f64 = 10.0;
pub const MAX_BEYOND_MM: f64 = 1.0;

/// Most passes over a lobe: roughing, finishing and some between; more is likelier a mistake.
pub const MAX_PASSES: usize = 16;

/// Fewest blocks per turn: below this a block is a tenth of a turn and no table of a lift.
pub const MIN_BLOCKS: u32 = 36;

impl JobSpec {
    /// A job that grinds nothing, for what a machine does without a part: with the wheel clear at a place of X (mm), and its rapid speed
    /// (mm/s).
    #[must_use]
    pub fn without_lobes(name: &str, clear_x_mm: f64, rapid_speed_mm_s: f64) -> Self {
        Self {
            name: String::from(name),
            profiles: Vec::new(),
            lobes: Vec::new(),
            blocks_per_turn: MIN_BLOCKS,
            rapid_advance_mm: 0.0,
            rapid_speed_mm_s,
            stock_mm: 0.0,
            passes: Vec::new(),
            retract_clearance_mm: 0.0,
            hold_in_cut: HoldInCut::Retract,
            speed_variation: None,
            wheel_power: None,
            c_between_lobes: BetweenLobes::Stops,
            rotary_indexing: false,
            home: HomePosition { x_mm: clear_x_mm, z_mm: 0.0 },
            dressing: None,
            obstacles: Vec::new(),
            clearance_mm: 1.0,
            wheels: Vec::new(),
            raw_part: RawPart::default(),
            part_support: None,
            correction: None,
            compensation: None,
            dry_run_mm: None,
            part_phase_rad: 0.0,
            identification: None,
            measure_stock: None,
        }
    }

    /// Size on the gauge that ends the infeed of the last pass. A dry run cuts nothing, so the gauge reads no size.
    #[must_use]
    pub fn size_control(&self) -> Option<SizeControl> {
        self.passes.last().and_then(|pass| pass.gauge_size).filter(|_| self.dry_run_mm.is_none())
    }

    /// Infeed of all passes together (mm).
    #[must_use]
    pub fn passes_infeed_mm(&self) -> f64 {
        self.passes.iter().map(|pass| pass.total_infeed_mm - pass.air_mm).sum()
    }

    /// Material of the raw part above the contour where it has most (mm).
    #[must_use]
    pub fn maximum_stock_mm(&self) -> f64 {
        self.stock_mm + self.raw_part.reach_mm()
    }

    /// Correction of the runout in a separate plan after the passes.
    #[must_use]
    pub fn is_corrected(&self) -> Option<&CorrectionSpec> {
        let only = self.identification.is_some_and(|identification| identification.only);
        self.correction.as_ref().filter(|_| !only)
    }

    /// Leaves out the lobes before this one, and what was learned or kept of them.
    pub fn begin_with(&mut self, lobe: usize) {
        self.lobes.drain(..lobe.min(self.lobes.len()));
        let lobes = &self.lobes;
        let is_left = |name: &str| lobes.iter().any(|lobe| lobe.name == name);
        if let Some(compensation) = &mut self.compensation {
            compensation.learned.retain(|learned| is_left(&learned.lobe));
        }
        if let Some(correction) = &mut self.correction {
            correction.contacts.retain(|contact| is_left(&contact.lobe));
        }
    }

    /// Material that the passes leave for the correction and the finishing turns (mm).
    #[must_use]
    pub fn allowance_mm(&self) -> f64 {
        let finishing_mm = |spec: &CorrectionSpec| spec.finishing.map_or(0.0, |finishing| finishing.depth_mm());
        self.correction.as_ref().map_or(0.0, |spec| spec.allowance_mm + finishing_mm(spec))
    }

    /// Retraction by a hold in the cut (mm); 0: it stops the infeed.
    #[must_use]
    pub const fn hold_mm(&self) -> f64 {
        match self.hold_in_cut {
            HoldInCut::Retract => self.retract_clearance_mm,
            HoldInCut::StopInfeed => 0.0,
        }
    }
}
