//! Why a job cannot be made, before any path is known.

use crate::math::units::um_from_mm;
use alloc::string::String;
use thiserror::Error;

/// What a job cannot ask for, whatever its paths look like.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum JobError {
    /// There is nothing to machine.
    #[error("the job has no lobes; it needs at least 1")]
    NoLobes,
    /// Spark-out cannot end by force.
    #[error("pass {pass}: spark-out is to end by force, but {why}")]
    SparkOutByForce {
        /// Name of the pass.
        pass: String,
        /// Why not.
        why: &'static str,
    },
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
        /// Their name.
        name: String,
    },
    /// The wheel reaches a neighbouring lobe.
    #[error(
        "lobe {lobe}: the wheel, {wheel_mm} mm wide, would also grind lobe {other}, {other_mm} mm wide and {apart_mm} mm \
         away; at least {least_mm} mm are needed"
    )]
    NeighbourInReach {
        /// The lobe being machined.
        lobe: String,
        /// Width of the wheel.
        wheel_mm: f64,
        /// The lobe it would touch.
        other: String,
        /// Its width.
        other_mm: f64,
        /// Distance between their stations.
        apart_mm: f64,
        /// Smallest distance allowed.
        least_mm: f64,
    },
    /// Two lobes stand at one station.
    #[error("lobes {first} and {second} both stand at station {station}; a station holds one lobe")]
    SameStation {
        /// The first lobe.
        first: String,
        /// The second lobe.
        second: String,
        /// Switch of the station.
        station: String,
    },
    /// A station has no switch on this machine.
    #[error("lobe {lobe}: station {station} has no limit switch on machine {machine}, which has {known}")]
    UnknownStation {
        /// The lobe.
        lobe: String,
        /// The switch asked for.
        station: String,
        /// The machine.
        machine: String,
        /// The switches it has.
        known: String,
    },
    /// A profile index is too large.
    #[error("lobe {lobe}: profile {profile} does not exist; the job has {count} (counted from 0)")]
    UnknownProfile {
        /// The lobe.
        lobe: String,
        /// Index asked for.
        profile: usize,
        /// Number of profiles.
        count: usize,
    },
    /// The wheel does not cover the lobe.
    #[error("lobe {lobe}: width {width_mm} mm is more than the wheel's {wheel_mm} mm")]
    WiderThanWheel {
        /// The lobe.
        lobe: String,
        /// Its width.
        width_mm: f64,
        /// The wheel's width.
        wheel_mm: f64,
    },
    /// A pass has no turn without infeed.
    #[error("pass {pass}: 0 spark-out turns; at least 1 is needed to remove the step that the infeed leaves")]
    NoSparkOut {
        /// The pass.
        pass: String,
    },
    /// Passes whose infeed is measured along different things do not join.
    #[error("pass {pass} measures its infeed along {other}, pass {first} along {one}; all passes need the same")]
    MixedDirections {
        /// The first pass.
        first: String,
        /// What it measures along.
        one: &'static str,
        /// The other pass.
        pass: String,
        /// What that measures along.
        other: &'static str,
    },
    /// No pass, or more than make sense.
    #[error("the job has {count} passes; it needs 1 to {most}")]
    PassCount {
        /// Number of passes.
        count: usize,
        /// Most allowed.
        most: usize,
    },
    /// No blocks.
    #[error("{blocks} blocks per turn; at least {least} are needed")]
    TooFewBlocks {
        /// Blocks asked for.
        blocks: u32,
        /// Fewest allowed.
        least: u32,
    },
    /// An obstacle that takes no room.
    #[error(
        "obstacle {name} reaches from {from_mm} to {to_mm} mm with a radius of {radius_mm} mm; it must begin before it ends \
         and have a radius above 0"
    )]
    NoBody {
        /// Its name.
        name: String,
        /// Its beginning.
        from_mm: f64,
        /// Its end.
        to_mm: f64,
        /// Its radius.
        radius_mm: f64,
    },
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
    CannotCorrect {
        /// The machine.
        machine: String,
        /// What it lacks.
        what: &'static str,
    },
    /// The gauge stands where it cannot tell a depth of cut.
    #[error("the runout of journals cannot be corrected on machine {machine}: {source}")]
    GaugeSeesNoCut {
        /// The machine.
        machine: String,
        /// Why.
        source: crate::gauging::gauge::GaugeError,
    },
    /// The published method takes the difference of two diameters for a depth of cut.
    #[error(
        "runout_correction.mode is published, which needs one gauge that reads a diameter; machine {machine} has {gauge}: set          runout_correction.mode to exact"
    )]
    PublishedGauge {
        /// The machine.
        machine: String,
        /// What it has.
        gauge: &'static str,
    },
    /// What is measured is for the correction.
    #[error("the stiffness is measured for the correction of runout, and the job has none")]
    IdentifiesForNothing,
    /// One feed tells the stiffness of the cut and its threshold together.
    #[error(
        "the stiffness is measured at two feeds, and those of the passes lie between {least_mm} and {most_mm} mm per turn; the largest \
         must be twice the least"
    )]
    OneFeed {
        /// Least feed per turn (mm).
        least_mm: f64,
        /// Largest (mm).
        most_mm: f64,
    },
    /// No turn in the air to know friction by.
    #[error(
        "the infeed begins {air_mm:.4} mm above the raw part; to measure the stiffness it must begin {needed_mm:.4} mm above it, for \
         a turn in the air tells the friction of x_axis"
    )]
    NoAir {
        /// What there is (mm).
        air_mm: f64,
        /// What is needed (mm).
        needed_mm: f64,
    },
    /// What was kept is of another job.
    #[error("runout_correction has a contact of lobe {lobe}, which the job has not")]
    KeptElsewhere {
        /// The lobe.
        lobe: String,
    },
    /// The job insists on what is not there.
    #[error(
        "the runout of lobe {lobe} is to be corrected by the stiffness that is kept for the machine (runout_correction.stiffness: kept), and \
         nothing is kept for where it stands: measure it (identification), or take what is known (stiffness: best)"
    )]
    NothingKept {
        /// The lobe.
        lobe: String,
    },
    /// The stock cannot be measured.
    #[error("the stock cannot be measured before it is ground (measure_stock): {why}")]
    MeasuresNoStock {
        /// Why.
        why: &'static str,
    },
    /// A gauge tells the stock of what is round.
    #[error("lobe {lobe} is not round; the stock is measured (measure_stock) only where all lobes are journals")]
    StockNotRound {
        /// The lobe.
        lobe: String,
    },
    /// The job itself knows of more than its margin.
    #[error(
        "measure_stock.margin_um is {:.1}, and the raw part may be off by {:.1} um in ways that two opposed contacts do not see \
         (eccentricity, bend, waves of an odd count): the wheel would meet it in rapid",
        um_from_mm(*.margin_mm), um_from_mm(*.unseen_mm)
    )]
    MarginTooSmall {
        /// The margin (mm).
        margin_mm: f64,
        /// What is not seen (mm).
        unseen_mm: f64,
    },
    /// What is not round has no runout.
    #[error("lobe {lobe} is not round; the runout of a job is corrected only where all of it are journals")]
    NotRound {
        /// The lobe.
        lobe: String,
    },
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
    /// What was learned is of another job.
    #[error("form_compensation has learned of lobe {lobe}, which the job has not")]
    LearnedElsewhere {
        /// The lobe.
        lobe: String,
    },
    /// What was learned is more than the job allows now.
    #[error(
        "lobe {lobe}: the learned correction goes to {:.3} um and {:.3} um/deg; form_compensation allows {:.3} um and {:.3} um/deg: \
         allow more, or learn afresh (form_compensation.afresh)",
        1e3 * .size_mm, um_per_deg(*.slope_mm_rad), 1e3 * .most_mm, um_per_deg(*.most_slope_mm_rad)
    )]
    LearnedTooMuch {
        /// The lobe.
        lobe: String,
        /// Its largest correction (mm).
        size_mm: f64,
        /// Its steepest (mm/rad).
        slope_mm_rad: f64,
        /// What is allowed (mm).
        most_mm: f64,
        /// What is allowed (mm/rad).
        most_slope_mm_rad: f64,
    },
    /// A number is outside its range.
    #[error("{place}{key} is {value}; it must be {wanted}")]
    OutOfRange {
        /// `lobe I1: `, `pass finish: ` or nothing.
        place: String,
        /// Name of the setting, with its unit.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        wanted: &'static str,
    },
}

/// A slope for people.
fn um_per_deg(slope_mm_rad: f64) -> f64 {
    1e3 * slope_mm_rad * crate::math::units::rad_from_deg(1.0)
}
