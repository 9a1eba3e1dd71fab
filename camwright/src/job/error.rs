// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why a job cannot be made, before any path is known.

use super::key::{JobKey, Subject};
use crate::machine::axial_profile::{AXIAL_TOLERANCE_MM, AxialProfile};
use crate::math::units::um_from_mm;
use alloc::boxed::Box;
use alloc::string::String;
use thiserror::Error;

/// Invalid job settings, independent of the paths.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum JobError {
    /// There is nothing to machine.
    #[error("the job has no lobes; it needs at least 1")]
    NoLobes,
    /// Bores and outer contours in one job.
    #[error(
        "lobe {bore} is a bore and lobe {lobe} is not: the wheel would have to leave the part between them; make two jobs of them"
    )]
    BoreBesideLobe { bore: String, lobe: String },
    /// Something that a bore cannot have.
    #[error("lobe {lobe} is a bore: {what} works on outer contours only; remove it")]
    NotInBore {
        lobe: String,
        what: &'static str,
        /// Key of the job.
        key: &'static str,
    },
    /// Spark-out cannot end by force.
    #[error("pass {pass}: spark-out is to end by force, but {why}")]
    SparkOutByForce {
        /// Name of the pass.
        pass: String,
        why: &'static str,
    },
    /// The infeed cannot end at a size.
    #[error("pass {pass}: the infeed is to end at a size on the gauge (gauge_size), but {why}")]
    NoGaugeSize {
        /// Name of the pass.
        pass: String,
        why: &'static str,
    },
    /// The size is above what the pass begins with.
    #[error(
        "pass {pass}: gauge_size.ends_above_um is {:.1}, and the journal has {:.1} um on the diameter before the pass: its infeed would end \
         before it begins; set less than that",
        um_from_mm(*.above_mm), um_from_mm(*.before_mm)
    )]
    SizeAboveRaw {
        /// Name of the pass.
        pass: String,
        /// Diameter above the finished one at which the infeed ends (mm).
        above_mm: f64,
        /// Diameter above the finished one before the pass (mm).
        before_mm: f64,
    },
    /// A gauge reads the size of round parts only.
    #[error(
        "lobe {lobe} is not round; the infeed ends at a size on the gauge (gauge_size) only where all lobes are journals"
    )]
    SizeNotRound { lobe: String },
    /// The approach of a later wheel is out of its range.
    #[error(
        "wheel_approach_mm is {approach_mm}; it must be above 0 and at most {}",
        super::wheel_visit::MAX_WHEEL_APPROACH_MM
    )]
    WheelApproach { approach_mm: f64 },
    /// The approach of a later wheel leaves nothing of its first pass.
    #[error(
        "pass {pass}: its infeed of {total_mm} mm must be more than wheel_approach_mm, {approach_mm}, which is the part of it in air after a wheel \
         change"
    )]
    ApproachBeyondInfeed { pass: String, approach_mm: f64, total_mm: f64 },
    /// The machine has no wheel changer.
    #[error(
        "the job names a wheel (wheel), but machine {machine} has no wheel changer: remove the key, or make a job for each wheel"
    )]
    NoWheelChanger { machine: String },
    /// The changer has no such wheel.
    #[error("the job mounts the wheel with index {index}; the changer of machine {machine} has {count} wheels")]
    UnknownWheel { index: usize, machine: String, count: usize },
    /// A setting that does not go with several wheels.
    #[error("the job has several wheels (wheel); {with} is not possible with them")]
    NotWithWheels { with: &'static str },
    /// The wheel is changed nearer to the part than the changer allows.
    #[error(
        "home.x_mm is {home_mm}, where the wheels are changed; the changer of machine {machine} needs at least {min_mm} mm"
    )]
    ChangeTooNear { home_mm: f64, min_mm: f64, machine: String },
    /// C cannot turn on and be turned to a lobe.
    #[error("c_between_lobes is turns_on and rotary_indexing is true; with rotary indexing C stops before each lobe")]
    TurnsAndIndexes,
    /// Two lobes have one name.
    #[error("lobes {first} and {second} are both named {name}; names must differ")]
    SameName {
        /// Position of the first in the job, from 1.
        first: usize,
        /// Position of the second, from 1.
        second: usize,
        name: String,
    },
    /// The wheel reaches a neighbouring lobe.
    #[error(
        "lobe {lobe}: the wheel, {wheel_mm} mm wide, would also grind lobe {other}, {other_mm} mm wide and {apart_mm} mm \
         away; at least {min_mm} mm are needed"
    )]
    NeighbourInReach {
        /// The lobe being machined.
        lobe: String,
        /// Width of the wheel.
        wheel_mm: f64,
        /// The lobe it would touch.
        other: String,
        other_mm: f64,
        /// Distance between their stations.
        apart_mm: f64,
        min_mm: f64,
    },
    /// Two lobes stand at one station.
    #[error("lobes {first} and {second} are both at station {station}; a station holds one lobe")]
    SameStation {
        first: String,
        second: String,
        /// Switch of the station.
        station: String,
    },
    /// A station has no switch on this machine.
    #[error("lobe {lobe}: station {station} has no limit switch on machine {machine}, which has {known}")]
    UnknownStation {
        lobe: String,
        /// The switch asked for.
        station: String,
        machine: String,
        /// The switches it has.
        known: String,
    },
    /// A profile index is too large.
    #[error("lobe {lobe}: profile {profile} does not exist; the job has {count} (counted from 0)")]
    UnknownProfile { lobe: String, profile: usize, count: usize },
    /// The wheel does not cover the lobe.
    #[error(
        "lobe {lobe}: width {width_mm} mm is more than the wheel's {wheel_mm} mm; to grind it by plunges side by side, state their overlap \
         (plunge_overlap_mm)"
    )]
    WiderThanWheel { lobe: String, width_mm: f64, wheel_mm: f64 },
    /// Plunges that do not overlap, or too much.
    #[error(
        "lobe {lobe}: plunge_overlap_mm is {overlap_mm}; it must be above 0 and at most {max_mm:.3}, a third of the wheel's {wheel_mm} mm"
    )]
    PlungeOverlap {
        lobe: String,
        /// The overlap asked for (mm).
        overlap_mm: f64,
        max_mm: f64,
        /// Width of the wheel (mm).
        wheel_mm: f64,
    },
    /// More sections than a machine reports at once.
    #[error(
        "wide lobes and lobes with taper or crown divide the part into {count} sections; a machine reports at most {max}: grind the lobes in \
         several jobs, or lower plunge_overlap_mm"
    )]
    SectionCount { count: usize, max: usize },
    /// The gauge stands at one position of Z.
    #[error(
        "lobe {lobe} is wider than the wheel: the in-process gauge measures one place of its width; leave out {key}, or grind the lobe in a \
         job of its own"
    )]
    WideUnderGauge {
        lobe: String,
        /// Key that asks for the gauge.
        key: &'static str,
    },
    /// The gauge does not see taper and crown.
    #[error(
        "lobe {lobe} has taper or crown, or the wheel's rim has: the in-process gauge measures one place of its width; leave out {key}, or \
         grind the lobe in a job of its own"
    )]
    ShapeUnderGauge {
        lobe: String,
        /// Key that asks for the gauge.
        key: &'static str,
    },
    /// Plunges side by side leave a straight lobe.
    #[error(
        "lobe {lobe} is wider than the wheel of {wheel_mm} mm: plunges side by side need a straight rim and leave a straight lobe; remove \
         taper_um, crown_um and {rim_key}, or take a wheel as wide as the lobe"
    )]
    WideWithShape {
        lobe: String,
        /// Width of the wheel (mm).
        wheel_mm: f64,
        /// Key of the wheel's rim in the machine file.
        rim_key: String,
    },
    /// The wheel that finishes a lobe grinds another shape.
    #[error(transparent)]
    OtherRim(Box<OtherRim>),
    /// The shape of a lobe reaches above its raw surface.
    #[error(
        "lobe {lobe}: taper_um and crown_um put a section {:.3} um above the contour, and the blank has {:.3} um; it must be more (stock_mm)",
        um_from_mm(*.above_mm), um_from_mm(*.stock_mm)
    )]
    ShapeAboveStock {
        lobe: String,
        /// Largest height of a section above the contour (mm).
        above_mm: f64,
        stock_mm: f64,
    },
    /// A wheel before the last cuts below the design of a section.
    #[error(
        "lobe {lobe}: the rim of its wheel cuts {:.3} um deeper than its middle, and the passes leave {:.3} um for the next wheel; leave more, or \
         give both wheels rims that differ less",
        um_from_mm(*.below_mm), um_from_mm(*.left_mm)
    )]
    RoughedBelow {
        /// Name of the visit.
        lobe: String,
        below_mm: f64,
        left_mm: f64,
    },
    /// The rim of a later wheel meets the lobe in rapid.
    #[error(
        "lobe {lobe}: the rim of its wheel is {:.3} um higher than its middle above what the wheel before it left, and wheel_approach_mm is {:.3} um; \
         it must be more",
        um_from_mm(*.above_mm), um_from_mm(*.approach_mm)
    )]
    RimBeyondApproach { lobe: String, above_mm: f64, approach_mm: f64 },
    /// Two sections have one name.
    #[error(
        "lobe {lobe} has taper or crown, and its section {section} has the name of lobe {other} or of a section of it; rename one of the lobes"
    )]
    SectionName { lobe: String, section: String, other: String },
    /// A pass with less spark-out than is needed for what follows it or is measured in it.
    #[error("pass {pass}: spark_out_turns is {turns}; it must be at least {least} {purpose}")]
    TooLittleSparkOut {
        pass: String,
        turns: u32,
        least: u32,
        /// Purpose of the turns, as the message ends.
        purpose: &'static str,
    },
    /// Passes whose infeed is measured along different things do not join.
    #[error("pass {pass} measures its infeed along {other}, pass {first} along {one}; all passes need the same")]
    MixedDirections {
        first: String,
        /// Base of the first one's infeed.
        one: &'static str,
        pass: String,
        /// Base of the other one's infeed.
        other: &'static str,
    },
    /// No pass, or more than make sense.
    #[error("the job has {count} passes; it needs 1 to {max}")]
    PassCount { count: usize, max: usize },
    #[error("{blocks} blocks per turn; at least {min} are needed")]
    TooFewBlocks { blocks: u32, min: u32 },
    /// An obstacle that takes no room.
    #[error(
        "obstacle {name} reaches from {from_mm} to {to_mm} mm with a radius of {radius_mm} mm; it must begin before it ends \
         and have a radius above 0"
    )]
    NoBody { name: String, from_mm: f64, to_mm: f64, radius_mm: f64 },
    /// A bend that is nowhere.
    #[error(
        "the raw part is bent between {from_mm} and {to_mm} mm; it must be bent from a smaller to a larger position"
    )]
    BentNowhere {
        /// Its beginning (mm).
        from_mm: f64,
        /// Its end (mm).
        to_mm: f64,
    },
    /// The machine cannot correct runout.
    #[error("the runout of journals cannot be corrected on machine {machine}: it has no {what}")]
    CannotCorrect { machine: String, what: &'static str },
    /// The gauge is at an angle where it cannot measure a depth of cut.
    #[error("the runout of journals cannot be corrected on machine {machine}: {source}")]
    GaugeSeesNoCut { machine: String, source: crate::gauging::gauge::GaugeError },
    /// The published method takes the difference of two diameters for a depth of cut.
    #[error(
        "runout_correction.mode is published, which needs one gauge that reads a diameter; machine {machine} has {gauge}: set          runout_correction.mode to exact"
    )]
    PublishedGauge { machine: String, gauge: &'static str },
    /// The published method does not know the depth of a finishing turn.
    #[error(
        "runout_correction.finishing.force_n needs mode: exact; by mode: published the depth of a turn is not known: set \
         runout_correction.mode to exact, or per_turn_um and turns"
    )]
    FinishingByForcePublished,
    /// More stock than the permitted turns may take.
    #[error(
        "runout_correction.finishing.stock_um is {:.1}; with max_turns {max_turns} it must be at most {:.0}, 50 um per turn",
        um_from_mm(*.stock_mm), um_from_mm(*.max_mm)
    )]
    FinishingStock { stock_mm: f64, max_mm: f64, max_turns: u32 },
    /// The dwell is too short, or the window, for the published measurement.
    #[error(
        "runout_correction.published_window_deg is {window_deg:.1}; it must be {min_deg:.0} to {max_deg:.0} with this gauge and \
         {spark_out_turns} spark-out turns of the last pass"
    )]
    PublishedWindow { window_deg: f64, min_deg: f64, max_deg: f64, spark_out_turns: u32 },
    /// The measured stiffness would only be used by a correction, which the job lacks.
    #[error("the stiffness is measured for the correction of runout, and the job has none")]
    IdentifiesForNothing,
    /// A single feed cannot separate the stiffness of the cut from its threshold.
    #[error(
        "the stiffness is measured at two feeds, and those of the passes lie between {min_mm} and {max_mm} mm per turn; the largest \
         must be twice the least"
    )]
    OneFeed {
        /// Least feed per turn (mm).
        min_mm: f64,
        /// Largest (mm).
        max_mm: f64,
    },
    /// The measurement of stiffness needs a steady feed.
    #[error(
        "pass {pass} has an infeed of its own for every turn, and the stiffness is measured at one steady feed per pass; set one infeed per \
         turn, or remove the measurement"
    )]
    FeedsOfTurns { pass: String },
    /// No turn in the air to know friction by.
    #[error(
        "the infeed begins {air_mm:.4} mm above the raw part; to measure the stiffness it must begin {needed_mm:.4} mm above it, for \
         a turn in the air measures the friction of x_axis"
    )]
    NoAir {
        /// Available height (mm).
        air_mm: f64,
        /// Required height (mm).
        needed_mm: f64,
    },
    /// The stored stiffness belongs to another job.
    #[error("runout_correction has a contact of lobe {lobe}, which is not in the job")]
    KeptElsewhere { lobe: String },
    /// The job insists on what is not there.
    #[error(
        "lobe {lobe}: runout_correction.stiffness is kept, but no stiffness is stored for its station; measure it (identification) or use stiffness: best"
    )]
    NothingKept { lobe: String },
    /// The stock cannot be measured.
    #[error("the stock cannot be measured before it is ground (measure_stock): {why}")]
    MeasuresNoStock { why: &'static str },
    /// A gauge measures the stock of round parts only.
    #[error("lobe {lobe} is not round; the stock is measured (measure_stock) only where all lobes are journals")]
    StockNotRound { lobe: String },
    /// The job itself knows of more than its margin.
    #[error(
        "measure_stock.margin_um is {:.1}, and the raw part may be off by {:.1} um in ways that two opposed contacts do not see \
         (eccentricity, bend, waves of an odd count): the wheel would meet it in rapid",
        um_from_mm(*.margin_mm), um_from_mm(*.unseen_mm)
    )]
    MarginTooSmall {
        /// The margin (mm).
        margin_mm: f64,
        /// Amplitude that the gauge does not see (mm).
        unseen_mm: f64,
    },
    /// The gauge cannot follow a pin.
    #[error(
        "lobe {lobe} is a crank pin: the in-process gauge measures about the spindle axis, which the pin goes round; leave out {key}, or \
         grind the pins in a job of their own"
    )]
    PinUnderGauge {
        lobe: String,
        /// Key that asks for the gauge.
        key: &'static str,
    },
    /// The radius of a pin about the spindle axis does not describe its contour.
    #[error(
        "lobe {lobe} is a crank pin, whose radius about the spindle axis is no contour of one value per angle; in pass {pass} use the law \
         constant_removal_rate"
    )]
    RadialLawOnPin { lobe: String, pass: String },
    /// Only round parts have a runout.
    #[error("lobe {lobe} is not round; the runout of a job is corrected only where all of it are journals")]
    NotRound { lobe: String },
    /// Between measuring and correcting C stops.
    #[error(
        "c_axis cannot turn on between the journals of a job whose runout is corrected: every one is measured to its end"
    )]
    CorrectsAndTurnsOn,
    /// Two ways to correct the same lobes.
    #[error(
        "a job whose runout is corrected while it is ground (runout_correction) cannot be corrected from part to part as well \
         (form_compensation)"
    )]
    LearnsAndCorrects,
    /// The learned correction belongs to another job.
    #[error("form_compensation has learned of lobe {lobe}, which is not in the job")]
    LearnedElsewhere { lobe: String },
    /// The learned correction exceeds the present limits of the job.
    #[error(
        "lobe {lobe}: the learned correction goes to {:.3} um and {:.3} um/deg; form_compensation allows {:.3} um and {:.3} um/deg; raise these limits, or learn again (form_compensation.afresh)",
        1e3 * .size_mm, um_per_deg(*.slope_mm_rad), 1e3 * .max_mm, um_per_deg(*.max_slope_mm_rad)
    )]
    LearnedTooMuch {
        lobe: String,
        /// Its largest correction (mm).
        size_mm: f64,
        /// Its steepest (mm/rad).
        slope_mm_rad: f64,
        /// Allowed shift (mm).
        max_mm: f64,
        /// Allowed slope (mm/rad).
        max_slope_mm_rad: f64,
    },
    /// The machine lacks a support that the part needs.
    #[error(
        "part_support: machine {machine} states no {what}; add {key} to the machine file, or leave that support out of the job"
    )]
    NoSupport {
        machine: String,
        what: &'static str,
        /// Key of the machine file.
        key: &'static str,
    },
    /// Nothing holds the other end.
    #[error(
        "part_support: a part on the centre of the headstock needs the tailstock; set tailstock to true, or headstock to chuck"
    )]
    LoosePart,
    /// The steady rest does not stand between the ends of the part.
    #[error(
        "part_support.steady_rest_z_mm is {z_mm}; it must be {low_mm} to {high_mm}, with the whole jaws between the ends of the part"
    )]
    RestOutside { z_mm: f64, low_mm: f64, high_mm: f64 },
    /// A lobe overhangs its supports.
    #[error(
        "lobe {lobe} reaches from {from_mm} to {to_mm} mm; part_support holds the part from {low_mm} to {high_mm} mm \
         (headstock_z_mm and length_mm), and a lobe must stand between"
    )]
    OutsideSupports { lobe: String, from_mm: f64, to_mm: f64, low_mm: f64, high_mm: f64 },
    /// The jaws of the steady rest bear on the lobe.
    #[error(
        "lobe {lobe} reaches from {from_mm} to {to_mm} mm, under the jaws of the steady rest from {jaws_from_mm} to {jaws_to_mm} mm; move \
         part_support.steady_rest_z_mm, or grind the lobe first in a job without it"
    )]
    UnderSteadyRest { lobe: String, from_mm: f64, to_mm: f64, jaws_from_mm: f64, jaws_to_mm: f64 },
    /// A number is outside its range.
    #[error("{}{key} is {value}; it must be {wanted}", place.prefix())]
    OutOfRange { place: Subject, key: JobKey, value: f64, wanted: &'static str },
}

/// A wheel that grinds another shape than that of the lobe that it finishes.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "lobe {lobe}: taper_um is {:.3} and crown_um {:.3}; wheel{wheel} grinds {:.3} and {:.3} over the width of {width_mm} mm, {:.3} um off \
     where {:.1} um are allowed; with {rim_key}.taper_um {:.3} and {rim_key}.crown_um {:.3} in the machine file it grinds the lobe, or \
     give the lobe the shape that the wheel grinds",
    unsigned_zero_um(.design.taper_mm), unsigned_zero_um(.design.crown_mm), unsigned_zero_um(.ground.taper_mm),
    unsigned_zero_um(.ground.crown_mm), um_from_mm(*.off_mm), um_from_mm(AXIAL_TOLERANCE_MM), unsigned_zero_um(.fits.taper_mm),
    unsigned_zero_um(.fits.crown_mm)
)]
pub struct OtherRim {
    pub lobe: String,
    /// Width of the lobe (mm).
    pub width_mm: f64,
    /// Name of the wheel after a space; empty without a changer.
    pub wheel: String,
    /// Shape of the lobe.
    pub design: AxialProfile,
    /// Shape that the wheel grinds.
    pub ground: AxialProfile,
    /// Largest difference of both (mm).
    pub off_mm: f64,
    /// Rim that grinds the lobe.
    pub fits: AxialProfile,
    /// Key of the wheel's rim in the machine file.
    pub rim_key: String,
}

/// A length in micrometres, without the sign of a zero.
fn unsigned_zero_um(mm: f64) -> f64 {
    um_from_mm(mm) + 0.0
}

/// A slope for people.
fn um_per_deg(slope_mm_rad: f64) -> f64 {
    1e3 * slope_mm_rad * crate::math::units::rad_from_deg(1.0)
}
