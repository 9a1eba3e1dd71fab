// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Errors of a lift table, each with the line of its file.

use thiserror::Error;

/// Lowest lift (mm) as errors name it.
pub(super) struct LowestLift(pub(super) f64);

impl core::fmt::Display for LowestLift {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if self.0 < 0.0 { write!(f, "the lowest lift, {} mm,", self.0) } else { f.write_str("the base circle") }
    }
}

/// One finding in a lift table. Angles are those of the file (cam or crank degrees), lengths mm.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LiftError {
    /// Too few rows to be a lift table.
    #[error("{count} rows are too few, at least {min} are needed for one turn")]
    TooFewRows { count: usize, min: usize },
    /// More rows than the arithmetic is made for.
    #[error("{count} rows are too many, at most {max} are allowed for one turn")]
    TooManyRows { count: usize, max: usize },
    /// The declared resolution is not usable.
    #[error("resolution {resolution_mm} mm is not within {min_mm} mm to {max_mm} mm")]
    BadResolution {
        /// Declared resolution (mm).
        resolution_mm: f64,
        /// Smallest (mm).
        min_mm: f64,
        /// Largest (mm).
        max_mm: f64,
    },
    /// A number that is not finite.
    #[error("line {line}: {what} is {value}, not a finite number")]
    NotFinite {
        /// Line of the file.
        line: usize,
        what: &'static str,
        value: f64,
    },
    /// A value too large to be a lift.
    #[error("line {line}: {value_mm} mm is beyond the largest lift of {max_mm} mm")]
    TooLarge {
        /// Line of the file.
        line: usize,
        /// Value (mm).
        value_mm: f64,
        /// Largest (mm).
        max_mm: f64,
    },
    /// A value that is no multiple of the table's last digit.
    #[error("line {line}: {value_mm} mm is no multiple of the last digit {digit_mm} mm")]
    OffDigit {
        /// Line of the file.
        line: usize,
        /// Value (mm).
        value_mm: f64,
        /// The finest digit looked for (mm).
        digit_mm: f64,
    },
    /// A row without its angle, while others have one.
    #[error("line {line}: the angle is missing")]
    AngleMissing {
        /// Line of the file.
        line: usize,
    },
    /// The same angle twice.
    #[error("line {line}: angle {angle_deg:.4} deg stands already in line {previous_line}")]
    DuplicateAngle {
        /// Line of the file.
        line: usize,
        /// The angle (deg).
        angle_deg: f64,
        /// Line of the first occurrence.
        previous_line: usize,
    },
    /// An angle that goes backwards.
    #[error("line {line}: angle {angle_deg:.4} deg does not increase (previous {previous_deg:.4} deg)")]
    AngleNotIncreasing {
        /// Line of the file.
        line: usize,
        /// The angle (deg).
        angle_deg: f64,
        /// The one before (deg).
        previous_deg: f64,
    },
    /// Blocks are missing before a row, or after the last.
    #[error(
        "line {line}: {count} block(s) missing, the next should be at {expected_deg:.4} deg, not {angle_deg:.4} deg"
    )]
    MissingBlock {
        /// Line of the file: the row after the gap, or the last row.
        line: usize,
        /// Number of blocks missing.
        count: usize,
        /// Angle of the first missing one (deg).
        expected_deg: f64,
        /// Angle found instead, or the end of the turn (deg).
        angle_deg: f64,
    },
    /// The number of rows is not the declared number of blocks.
    #[error("line {line}: the table has {count} blocks, declared are {declared}")]
    BlockCount {
        /// Last line of the table.
        line: usize,
        count: usize,
        declared: usize,
    },
    /// An angle off the even division of the turn.
    #[error(
        "line {line}: angle {angle_deg:.4} deg is {off_deg:.4} deg off the even division; allowed: {bound_deg:.4} deg"
    )]
    UnevenAngle {
        /// Line of the file.
        line: usize,
        /// The angle (deg).
        angle_deg: f64,
        /// Distance from where it should be (deg).
        off_deg: f64,
        /// Allowed (deg).
        bound_deg: f64,
    },
    /// The table covers two turns where it declares cam degrees.
    #[error(
        "line {line}: the table covers {covered_deg:.2} deg where one turn of the cam is 360 deg: \
         these are crank degrees, declared are cam degrees"
    )]
    CrankDegrees {
        /// First line beyond one turn.
        line: usize,
        /// Angle covered (deg).
        covered_deg: f64,
    },
    /// The table covers half a turn of the crank where it declares crank degrees.
    #[error(
        "line {line}: the table covers {covered_deg:.2} deg where one turn of the cam is 720 deg of the crank: \
         these are cam degrees, declared are crank degrees"
    )]
    CamDegrees {
        /// Last line of the table.
        line: usize,
        /// Angle covered (deg).
        covered_deg: f64,
    },
    /// The table covers something else than one turn.
    #[error("line {line}: the table covers {covered_deg:.4} deg, one turn is {turn_deg} deg")]
    AngleSpan {
        /// First line beyond one turn, or the last.
        line: usize,
        /// Angle covered (deg).
        covered_deg: f64,
        /// One turn of the cam in the declared unit (deg).
        turn_deg: f64,
    },
    /// The lift after one turn is not the lift before.
    #[error(
        "line {line}: after one turn {misclosure_mm} mm of lift remain ({units} units of {digit_mm} mm); allowed: less than {bound_mm} mm"
    )]
    Misclosure {
        /// Last line of the table.
        line: usize,
        /// Remaining lift (mm).
        misclosure_mm: f64,
        /// The same in units of the last digit.
        units: i64,
        /// The last digit (mm).
        digit_mm: f64,
        /// Half the resolution (mm).
        bound_mm: f64,
    },
    /// Lift below the lowest that is declared.
    #[error("line {line}: lift {lift_mm} mm is below {} by more than half a digit ({bound_mm} mm)", LowestLift(*.lowest_mm))]
    BelowBase {
        /// Line of the file.
        line: usize,
        /// Lift (mm).
        lift_mm: f64,
        /// Lowest lift (mm); 0 is the base circle.
        lowest_mm: f64,
        /// Half the resolution (mm).
        bound_mm: f64,
    },
    /// A single row that its neighbours do not bear out.
    #[error("line {line}: the lift lies {off_mm:.6} mm off the trend of the rows around it; allowed: {bound_mm:.6} mm")]
    Outlier {
        /// Line of the row.
        line: usize,
        /// Distance from the cubic through the two rows on either side (mm).
        off_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// A jump that the lift around it does not announce.
    #[error("line {line}: the lift jumps {jump_mm:.6} mm away from its neighbours' trend; allowed: {bound_mm:.6} mm")]
    Step {
        /// Line of the row after the jump.
        line: usize,
        /// Height of the jump (mm).
        jump_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// A half table whose first row is not the nose.
    #[error("line {line}: a half table begins at the nose, at 0 deg, not at {angle_deg:.4} deg")]
    HalfStart {
        line: usize,
        /// Angle there (deg).
        angle_deg: f64,
    },
    /// A half table beyond half a turn.
    #[error("line {line}: a half table covers at most {max_deg} deg, this angle is {angle_deg:.4} deg")]
    HalfSpan {
        line: usize,
        /// Angle there (deg).
        angle_deg: f64,
        /// Half a turn of the cam in the declared unit (deg).
        max_deg: f64,
    },
    /// A half table with a lift above that of its nose.
    #[error(
        "line {line}: lift {lift_mm:.6} mm is above the {nose_mm:.6} mm of line {nose_line}; \
         a half table begins with its largest lift"
    )]
    NoseNotFirst {
        /// Line of the largest lift.
        line: usize,
        /// The largest lift (mm).
        lift_mm: f64,
        /// Line of the first row.
        nose_line: usize,
        /// Lift there (mm).
        nose_mm: f64,
    },
    /// A half table that ends above the base circle.
    #[error(
        "line {line}: the flank ends at a lift of {lift_mm:.6} mm; on the base circle at most {bound_mm} mm remain"
    )]
    FlankEndsHigh {
        line: usize,
        /// Lift there (mm).
        lift_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// Two half tables that differ where they meet.
    #[error(
        "line {line}: opening and closing flank meet here with {opening_mm:.6} mm and {closing_mm:.6} mm; \
         they may differ by at most {bound_mm} mm"
    )]
    HalvesDisagree {
        /// Line of the closing flank.
        line: usize,
        /// Lift of the opening flank (mm).
        opening_mm: f64,
        /// Lift of the closing flank (mm).
        closing_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// Two half tables with different steps.
    #[error("line {line}: the step is {closing_deg:.6} deg, that of the opening flank {opening_deg:.6} deg")]
    HalvesStep {
        /// First line of the closing flank.
        line: usize,
        /// Step of the opening flank (deg).
        opening_deg: f64,
        /// Step of the closing flank (deg).
        closing_deg: f64,
    },
    /// A point of a contour without an azimuth.
    #[error("line {line}: the point lies on the axis")]
    PointOnAxis {
        /// Line of the file.
        line: usize,
    },
    /// A point of a contour that goes back, or nowhere.
    #[error(
        "line {line}: the point lies at azimuth {azimuth_deg:.4} deg, which does not go on from {previous_deg:.4} deg in line {previous_line} \
         the way the points began"
    )]
    AzimuthTurnsBack {
        /// Line of the file.
        line: usize,
        /// Its azimuth (deg).
        azimuth_deg: f64,
        /// That of the point before (deg).
        previous_deg: f64,
        previous_line: usize,
    },
    /// Points of a contour that are far apart.
    #[error(
        "line {line}: the point lies {gap_deg:.4} deg of azimuth beyond that in line {previous_line}, at most {max_deg} deg are read over"
    )]
    PointGap {
        /// Line of the file.
        line: usize,
        /// Azimuth between the two (deg).
        gap_deg: f64,
        /// Allowed (deg).
        max_deg: f64,
        /// Line of the previous row.
        previous_line: usize,
    },
    /// Rows at uneven angles that are far apart.
    #[error(
        "line {line}: the row lies {gap_deg:.4} deg beyond that in line {previous_line}, at most {max_deg} deg are read over"
    )]
    RowGap {
        /// Line of the file.
        line: usize,
        /// Angle between the two (deg).
        gap_deg: f64,
        /// Allowed (deg).
        max_deg: f64,
        /// Line of the previous row.
        previous_line: usize,
    },
    /// Points that go round more often than once, or not at all.
    #[error(
        "line {line}: up to here and back to the first the points go {covered_deg:.4} deg round the axis; it must be 360 deg"
    )]
    NotOnceRound {
        line: usize,
        /// Azimuth covered (deg).
        covered_deg: f64,
    },
    /// Angle 0 of the file falls between two blocks of the turn.
    #[error(
        "the file's angle 0 stands at {zero_deg} cam deg, {off_deg:.6} deg off a multiple of the step of {step_deg:.6} deg"
    )]
    ZeroOffStep {
        /// Cam angle of the file's angle 0 (deg).
        zero_deg: f64,
        /// Distance from a multiple (cam deg).
        off_deg: f64,
        /// Step (cam deg).
        step_deg: f64,
    },
}

impl LiftError {
    /// Line of the file at fault, where one row is; none for a row that was not read but mirrored or filled in.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.row_line().filter(|line| *line > 0)
    }

    /// Line of the row at fault, 0 for one that was not read.
    pub(super) fn row_line(&self) -> Option<usize> {
        match *self {
            Self::TooFewRows { .. }
            | Self::TooManyRows { .. }
            | Self::BadResolution { .. }
            | Self::ZeroOffStep { .. } => None,
            Self::NotFinite { line, .. }
            | Self::TooLarge { line, .. }
            | Self::OffDigit { line, .. }
            | Self::AngleMissing { line }
            | Self::DuplicateAngle { line, .. }
            | Self::AngleNotIncreasing { line, .. }
            | Self::MissingBlock { line, .. }
            | Self::BlockCount { line, .. }
            | Self::UnevenAngle { line, .. }
            | Self::CrankDegrees { line, .. }
            | Self::CamDegrees { line, .. }
            | Self::AngleSpan { line, .. }
            | Self::Misclosure { line, .. }
            | Self::BelowBase { line, .. }
            | Self::Outlier { line, .. }
            | Self::Step { line, .. }
            | Self::HalfStart { line, .. }
            | Self::HalfSpan { line, .. }
            | Self::NoseNotFirst { line, .. }
            | Self::FlankEndsHigh { line, .. }
            | Self::HalvesDisagree { line, .. }
            | Self::HalvesStep { line, .. }
            | Self::PointOnAxis { line }
            | Self::AzimuthTurnsBack { line, .. }
            | Self::PointGap { line, .. }
            | Self::RowGap { line, .. }
            | Self::NotOnceRound { line, .. } => Some(line),
        }
    }
}
