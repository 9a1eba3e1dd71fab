// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The lift of a profile: what a job writes under `lift`, and the law it means.
//!
//! ```text
//! table, half_table, opening_table + closing_table ─► lift_text ─► rows ─► LiftTable ─► reading ─┐
//! segments ─────────────────────────────────────────────────────────────► MotionProgram ─────────┼─► LiftLaw
//! eccentric, s_cam, conjugate_of, round ───────────────────────────────────────────────► formula ──────────────┘
//! ```

use super::contour_table::{self, Orientation, PointsInCam};
use super::job_files::JobFiles;
use super::lift_context::LiftContext;
use super::lift_formula::{self, CrankPinFile, EccentricFile, SCamFile, SegmentFile};
use super::lift_preset::LiftPreset;
use super::lift_text::{self, AngleUnitFile, Content, Printed, TextFormat};
use super::locate::Located;
use super::outline_file::{self, OutlineFile, PolygonFile};
use super::schema;
use super::table_files::TableFiles;
use super::yaml::Document;
use super::{ConfigError, FileLocation};
use camwright::cam::follower::Follower;
use camwright::cam::lift::halves::{check_flank, whole_turn};
use camwright::cam::lift::law::alternatives;
use camwright::cam::lift::uneven::{evenly_spaced, with_base_circle};
use camwright::cam::lift::{
    LiftDeclaration, LiftError, LiftForm, LiftLaw, LiftRow, LiftTable, MotionProgram, TableMethod, TableReading,
};
use camwright::cam::outline::fit::FittedOutline;
use camwright::math::units::mm_from_um;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Finest resolution a table is read to where the job declares none (mm): all the digits of a double say no more.
const FINEST_RESOLUTION_MM: f64 = 1e-9;

/// The same of a table at uneven angles (mm): the spline between its rows is not better than that.
const UNEVEN_RESOLUTION_MM: f64 = 1e-4;

/// Default position of the nose of a half table (cam deg): opposite the centre of the base circle.
const NOSE_DEG: f64 = 180.0;

/// A lift larger than this many base radii is no cam that can be ground (a flat follower of 1 mm on 0.5 mm is).
const LIFT_PER_BASE_RADIUS: f64 = 2.0;

/// `lift` of a profile as written. Exactly one source: a table in one of its three forms, segments, an eccentric,
/// the arms of a brake, the other cam of a pair, or none: round.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiftFile {
    /// Table with one turn of the cam, by name or path.
    table: Option<String>,
    /// Table with one flank, from the nose (angle 0) down to lift 0; it is mirrored.
    half_table: Option<String>,
    /// Table with the opening flank, nose first. Needs `closing_table`.
    opening_table: Option<String>,
    /// Table with the closing flank, nose first. Needs `opening_table`.
    closing_table: Option<String>,
    /// Motion laws one after the other.
    #[schemars(length(min = 1, max = 1000))]
    segments: Option<Vec<SegmentFile>>,
    /// Repetitions of the segments per turn. Default: 1.
    #[schemars(range(min = 1, max = 1000))]
    repeat: Option<usize>,
    /// Eccentric disc as a formula.
    eccentric: Option<EccentricFile>,
    /// Crank pin by its throw and diameter, in grinding jobs.
    crank_pin: Option<CrankPinFile>,
    /// Lines and arcs of the part's outline, instead of a follower and a base circle.
    outline: Option<OutlineFile>,
    /// Regular polygon with rounded corners, instead of a follower and a base circle.
    polygon: Option<PolygonFile>,
    /// S-cam of a drum brake: two equal arms, half a turn apart, for a roller with `offset_mm`.
    s_cam: Option<SCamFile>,
    /// Profile before this one whose follower is joined to this one, so that both cams hold it without play: the lift is the
    /// largest lift of that profile less its lift.
    conjugate_of: Option<String>,
    /// Azimuth of this follower seen from the follower of `conjugate_of`. Default: 180, of oscillating followers 0 (one pivot).
    #[schemars(range(min = -36000.0, max = 36000.0))]
    conjugate_at_deg: Option<f64>,
    /// A journal: no lift.
    round: Option<bool>,
    /// Format of a control or program that wrote the table. Default: none.
    preset: Option<LiftPreset>,
    /// Names of the columns of a table. Default: the header of the file, or those of the preset.
    #[schemars(length(min = 1, max = 20))]
    columns: Option<Vec<String>>,
    /// Meaning of a column of angles. Default: cam, or as named by the columns.
    angle: Option<AngleUnitFile>,
    /// Lines to skip. Default: the lines before the first number.
    header_lines: Option<usize>,
    /// Numbers have a decimal comma; columns are then separated by semicolons, tabs or blanks. Default: false.
    decimal_comma: Option<bool>,
    /// Lift of the largest value in a column `lift_share`.
    #[schemars(range(min = 1e-3, max = 1000.0))]
    scale_mm: Option<f64>,
    /// The rows of a whole table stand at uneven angles: a periodic cubic spline through them gives the rows at even angles.
    /// Default: false, or as the preset has it.
    uneven: Option<bool>,
    /// A whole table holds the lift event only: the rest of the turn is the base circle. Default: false, or as the preset has it.
    event_only: Option<bool>,
    /// Cam angle from row to row of a table without angles. Default: the rows divide the turn.
    #[schemars(range(min = 1e-6, max = 360.0))]
    step_cam_deg: Option<f64>,
    /// Crank angle from row to row of a table without angles.
    #[schemars(range(min = 1e-6, max = 720.0))]
    step_crank_deg: Option<f64>,
    /// The angles of a whole table count against the cam angle: lift at angle a belongs to cam angle -a. Default: false.
    mirrored: Option<bool>,
    /// Cam angle of the file's angle 0; of a half table: of the nose. Default: 0, of half tables 180.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    zero_deg: Option<f64>,
    /// Resolution of the figures; the lift law stays within half of it. Default: the last printed digit, of uneven tables at
    /// least 0.0001.
    #[schemars(range(min = 1e-9, max = 1.0))]
    resolution_mm: Option<f64>,
    /// Curve through the table. Default: smoothest.
    reading: Option<ReadingFile>,
    /// Tolerance of the smoothest curve, at least half the resolution. Default: half the resolution; of lines and arcs the resolution.
    #[schemars(range(min = 1e-6, max = 1e4))]
    smooth_within_um: Option<f64>,
    /// Lowest lift of segments or a whole table: lifts below 0 are pockets in the base circle. Default: 0.
    #[schemars(range(min = -1e4, max = 0.0))]
    lowest_lift_mm: Option<f64>,
    /// Cam angle at which the first segment begins, with lift 0. Default: 0.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    start_deg: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum ReadingFile {
    /// Smoothest closed curve within half the resolution of every row.
    Smoothest,
    /// Cubic spline through the figures.
    CubicSpline,
    /// Tangent lines and arcs through the points of a contour: flats stay flat.
    LinesAndArcs,
}

/// The lift of a profile as understood.
#[derive(Debug, Clone)]
pub struct ProfileLift {
    pub law: LiftLaw,
    /// The table it was read from; none for a formula.
    pub table: Option<LiftTable>,
    /// Files of that table.
    pub files: Vec<PathBuf>,
    /// Cost of the other readings of the table.
    pub others: Vec<TableReading>,
    /// Lines and arcs that were found through the points of a table.
    pub outline: Option<FittedOutline>,
    /// Valid but suspicious content.
    pub warnings: Vec<ConfigError>,
    /// Follower and radius of the base circle (mm), where the lift says the cam itself and the profile must not.
    pub own: Option<(Follower, f64)>,
    /// Distance of the centre of a crank pin from the axis (mm); 0 for every other lift.
    pub throw_mm: f64,
}

impl ProfileLift {
    /// One that is no table.
    pub(super) fn formula(law: LiftLaw, own: Option<(Follower, f64)>) -> Self {
        Self {
            law,
            table: None,
            files: Vec::new(),
            others: Vec::new(),
            outline: None,
            warnings: Vec::new(),
            own,
            throw_mm: 0.0,
        }
    }
}

/// Reads the lift of a profile; every file that it names is added to `files`.
///
/// # Errors
/// Everything that is wrong with it, in the order of its files.
pub(super) fn read(
    file: &LiftFile,
    profile: LiftContext<'_>,
    files: &mut JobFiles,
) -> Result<ProfileLift, Vec<ConfigError>> {
    check_sources(file, &profile)?;
    if profile.turns() > 1 && file.segments.is_none() {
        let message = format!(
            "turns is {}; a lift over several turns is stated by segments, every other lift is that of one turn",
            profile.turns()
        );
        return Err(profile.refuse("", message));
    }
    if let Some(formula) = read_formula(file, &profile) {
        return formula;
    }
    let mut found = |key: &str, name: &str| -> Result<Located, Vec<ConfigError>> {
        let located = (profile.document.locate("lifts", name, "csv"))
            .map_err(|error| vec![profile.document.error(&profile.key(key), error.to_string())])?;
        files.add("lifts", name, located.text.as_bytes());
        Ok(located)
    };
    let source = match (&file.table, &file.half_table, &file.closing_table, &file.opening_table) {
        (Some(table), ..) => LiftSource::Whole(found("table", table)?),
        (_, Some(half), ..) => LiftSource::Half(found("half_table", half)?),
        (_, _, Some(closing), Some(opening)) => {
            LiftSource::Halves { closing: found("closing_table", closing)?, opening: found("opening_table", opening)? }
        }
        (.., None, _) => return Err(profile.refuse("opening_table", "opening_table needs a closing_table")),
        (.., None) => return Err(profile.refuse("closing_table", "closing_table needs an opening_table")),
    };
    read_table(file, &profile, &source)
}

/// Refuses a lift with no source or several, and keys that mean nothing for the one it has.
fn check_sources(file: &LiftFile, profile: &LiftContext<'_>) -> Result<(), Vec<ConfigError>> {
    let halves = file.opening_table.is_some() || file.closing_table.is_some();
    let is_round = file.round.unwrap_or(false);
    let sources = [
        file.table.is_some(),
        file.half_table.is_some(),
        halves,
        file.segments.is_some(),
        file.eccentric.is_some(),
        file.crank_pin.is_some(),
        file.outline.is_some(),
        file.polygon.is_some(),
        file.s_cam.is_some(),
        file.conjugate_of.is_some(),
        is_round,
    ];
    if sources.iter().filter(|given| **given).count() != 1 {
        let message = "lift needs exactly one of: table, half_table, opening_table with closing_table, segments, eccentric, crank_pin, \
                       outline, polygon, s_cam, conjugate_of, round: true";
        return Err(profile.refuse("", message));
    }
    refuse_misplaced(file, profile)
}

/// Reads the lift of an open groove, which segments alone can state.
///
/// # Errors
/// Another source; segments that are no motion from one end to the other.
pub(super) fn read_open(file: &LiftFile, groove: LiftContext<'_>) -> Result<MotionProgram, Vec<ConfigError>> {
    check_sources(file, &groove)?;
    let Some(segments) = &file.segments else {
        return Err(groove.refuse("", "the lift of an open groove is stated by segments; every other lift closes"));
    };
    if let Some(start_deg) = file.start_deg {
        let message = format!(
            "start_deg is {start_deg}; an open groove begins with its first segment, and phase_deg of the groove turns it"
        );
        return Err(groove.refuse("start_deg", message));
    }
    lift_formula::open_program(segments, file.lowest_lift_mm.unwrap_or(0.0), file.repeat.unwrap_or(1), &groove)
}

/// A lift that is no table.
fn read_formula(file: &LiftFile, profile: &LiftContext<'_>) -> Option<Result<ProfileLift, Vec<ConfigError>>> {
    let law = if let Some(segments) = &file.segments {
        lift_formula::program(
            segments,
            file.lowest_lift_mm.unwrap_or(0.0),
            file.start_deg.unwrap_or(0.0),
            file.repeat.unwrap_or(1),
            profile,
        )
    } else if let Some(eccentric) = &file.eccentric {
        if eccentric.is_disc() {
            return Some(lift_formula::disc(eccentric, profile));
        }
        lift_formula::eccentric(eccentric, profile)
    } else if let Some(pin) = &file.crank_pin {
        return Some(lift_formula::crank_pin(pin, profile));
    } else if let Some(outline) = &file.outline {
        return Some(outline_file::outline(outline, profile));
    } else if let Some(polygon) = &file.polygon {
        return Some(outline_file::polygon(polygon, profile));
    } else if let Some(s_cam) = &file.s_cam {
        lift_formula::s_cam(s_cam, profile)
    } else if let Some(name) = &file.conjugate_of {
        lift_formula::conjugate(name, file.conjugate_at_deg, profile)
    } else if file.round == Some(true) {
        lift_formula::round(profile)
    } else {
        return None;
    };
    Some(law.map(|law| ProfileLift::formula(law, None)))
}

/// Keys that mean nothing for the source that is given.
fn refuse_misplaced(file: &LiftFile, profile: &LiftContext<'_>) -> Result<(), Vec<ConfigError>> {
    let for_tables = [
        ("preset", file.preset.is_some()),
        ("columns", file.columns.is_some()),
        ("angle", file.angle.is_some()),
        ("header_lines", file.header_lines.is_some()),
        ("decimal_comma", file.decimal_comma.is_some()),
        ("step_cam_deg", file.step_cam_deg.is_some()),
        ("step_crank_deg", file.step_crank_deg.is_some()),
        ("scale_mm", file.scale_mm.is_some()),
        ("uneven", file.uneven.is_some()),
        ("event_only", file.event_only.is_some()),
        ("mirrored", file.mirrored.is_some()),
        ("zero_deg", file.zero_deg.is_some()),
        ("resolution_mm", file.resolution_mm.is_some()),
        ("reading", file.reading.is_some()),
        ("smooth_within_um", file.smooth_within_um.is_some()),
    ];
    let mut errors = Vec::new();
    let is_formula = file.segments.is_some()
        || file.eccentric.is_some()
        || file.crank_pin.is_some()
        || file.outline.is_some()
        || file.polygon.is_some()
        || file.s_cam.is_some()
        || file.conjugate_of.is_some()
        || file.round == Some(true);
    for (key, _) in for_tables.iter().filter(|(_, given)| is_formula && *given) {
        errors.extend(profile.refuse(key, format!("{key} is about a table; this lift is a formula")));
    }
    let for_whole_tables = [
        ("lowest_lift_mm", file.lowest_lift_mm.is_some(), "a half table ends on the base circle, its lowest lift"),
        ("mirrored", file.mirrored.is_some(), "a half table has its direction by its nose"),
        ("uneven", file.uneven.is_some(), "the rows of a half table stand at even angles"),
        ("event_only", file.event_only.is_some(), "a half table ends on the base circle"),
        ("preset", file.preset.is_some(), "declare the columns of a half table"),
    ];
    let is_half = file.table.is_none() && !is_formula;
    for (key, _, why) in for_whole_tables.iter().filter(|(_, given, _)| *given && is_half) {
        errors.extend(profile.refuse(key, format!("{key} is about a whole table; {why}")));
    }
    let for_segments = [("start_deg", file.start_deg.is_some()), ("repeat", file.repeat.is_some())];
    for (key, _) in for_segments.iter().filter(|(_, given)| *given && file.segments.is_none()) {
        errors.extend(profile.refuse(key, format!("{key} is about segments; this lift has none")));
    }
    if file.lowest_lift_mm.is_some() && is_formula && file.segments.is_none() {
        let message = "lowest_lift_mm is about segments and whole tables; this lift has its own lowest";
        errors.extend(profile.refuse("lowest_lift_mm", message));
    }
    if file.lowest_lift_mm.is_some() && file.reading == Some(ReadingFile::LinesAndArcs) {
        let message = "lowest_lift_mm is about lifts; lines and arcs go through points of a contour";
        errors.extend(profile.refuse("lowest_lift_mm", message));
    }
    if file.conjugate_at_deg.is_some() && file.conjugate_of.is_none() {
        let message = "conjugate_at_deg is about conjugate_of; this lift has none";
        errors.extend(profile.refuse("conjugate_at_deg", message));
    }
    if file.reading == Some(ReadingFile::CubicSpline) && file.smooth_within_um.is_some() {
        let message = "a cubic spline passes through every point; remove smooth_within_um, or the cubic spline";
        errors.extend(profile.refuse("smooth_within_um", message));
    }
    let step = match (file.step_cam_deg, file.step_crank_deg) {
        (Some(_), Some(_)) => Some("both"),
        (Some(_), None) if file.angle == Some(AngleUnitFile::Crank) => Some("step_cam_deg and angle: crank"),
        (None, Some(_)) if file.angle == Some(AngleUnitFile::Cam) => Some("step_crank_deg and angle: cam"),
        _ => None,
    };
    if let Some(both) = step {
        let message = format!("the step is declared in cam and in crank degrees ({both}); one is needed");
        errors.extend(profile.refuse("step_cam_deg", message));
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// Files of a table.
enum LiftSource {
    Whole(Located),
    /// One flank, for both.
    Half(Located),
    Halves {
        closing: Located,
        opening: Located,
    },
}

impl LiftFile {
    fn format(&self, mm_per_deg: Option<f64>) -> TextFormat {
        let angle = match (self.step_cam_deg, self.step_crank_deg) {
            (Some(_), _) => Some(AngleUnitFile::Cam),
            (_, Some(_)) => Some(AngleUnitFile::Crank),
            _ => self.angle,
        };
        TextFormat {
            columns: self.columns.clone(),
            angle,
            header_lines: self.header_lines,
            decimal_comma: self.decimal_comma.unwrap_or(false),
            step_deg: self.step_cam_deg.or(self.step_crank_deg),
            mm_per_deg,
            preset: self.preset,
            scale_mm: self.scale_mm,
        }
    }

    fn is_uneven(&self) -> bool {
        self.uneven.unwrap_or(self.preset.is_some_and(LiftPreset::uneven))
    }

    fn is_event_only(&self) -> bool {
        self.event_only.unwrap_or(self.preset.is_some_and(LiftPreset::event_only))
    }

    fn declaration(&self, printed: &Printed) -> LiftDeclaration {
        let finest_mm = if self.is_uneven() { UNEVEN_RESOLUTION_MM } else { FINEST_RESOLUTION_MM };
        LiftDeclaration {
            form: printed.form,
            angle_unit: printed.angle.core(),
            resolution_mm: self.resolution_mm.unwrap_or(printed.last_digit_mm.max(finest_mm)),
            unit: printed.unit,
            smooth_within_mm: self.smooth_within_um.map_or(0.0, mm_from_um),
            lowest_mm: self.lowest_lift_mm.unwrap_or(0.0),
            blocks: None,
        }
    }

    fn reading(&self) -> TableMethod {
        match (self.smooth_within_um, self.reading) {
            (Some(um), _) => TableMethod::SmoothWithin { tolerance_mm: mm_from_um(um) },
            (None, Some(ReadingFile::CubicSpline)) => TableMethod::CubicSpline,
            (None, _) => TableMethod::Smoothest,
        }
    }
}

fn read_table(
    file: &LiftFile,
    profile: &LiftContext<'_>,
    source: &LiftSource,
) -> Result<ProfileLift, Vec<ConfigError>> {
    let format = file.format(profile.mm_per_deg());
    lift_text::check_columns(&format).map_err(|error| profile.refuse("columns", error))?;
    if file.reading == Some(ReadingFile::LinesAndArcs) {
        return read_outline(file, profile, source, &format);
    }
    let mut warnings = Vec::new();
    let base_mm;
    let (table, files) = match source {
        LiftSource::Whole(located) => {
            let mut printed = lift_text::read(located, &format)?;
            base_mm = contour_table::make_lifts(&mut [(located.path.as_path(), &mut printed)], Orientation::Whole)?;
            if printed.form == LiftForm::Absolute && angles_descend(&printed.rows) {
                printed.rows.reverse();
            }
            (whole_table(file, profile, &located.path, printed, &mut warnings)?, vec![located.path.clone()])
        }
        LiftSource::Half(located) => {
            let mut printed = lift_text::read(located, &format)?;
            base_mm = contour_table::make_lifts(&mut [(located.path.as_path(), &mut printed)], Orientation::Half)?;
            let places = TableFiles::of_flanks(vec![(located.path.as_path(), &printed)]);
            (flanks(file, profile, &places, &mut warnings)?, vec![located.path.clone()])
        }
        LiftSource::Halves { closing, opening } => {
            let (first, second) = (lift_text::read(closing, &format), lift_text::read(opening, &format));
            let (mut first, mut second) = match (first, second) {
                (Ok(first), Ok(second)) => (first, second),
                (first, second) => {
                    return Err([first.err(), second.err()].into_iter().flatten().flatten().collect());
                }
            };
            let files = &mut [(closing.path.as_path(), &mut first), (opening.path.as_path(), &mut second)];
            base_mm = contour_table::make_lifts(files, Orientation::Half)?;
            let places =
                TableFiles::of_flanks(vec![(closing.path.as_path(), &first), (opening.path.as_path(), &second)]);
            (flanks(file, profile, &places, &mut warnings)?, vec![closing.path.clone(), opening.path.clone()])
        }
    };
    let reading = file.reading();
    let whole_file =
        |error: &dyn std::fmt::Display| vec![ConfigError::at(FileLocation::file(&files[0]), error.to_string())];
    let law = LiftLaw::read_table(&table, reading).map_err(|error| match reading {
        TableMethod::SmoothWithin { .. } => profile.refuse("smooth_within_um", error),
        _ => whole_file(&error),
    })?;
    let own = base_mm.map(|base_mm| (Follower::KnifeEdge { offset_mm: 0.0 }, base_mm));
    let others = alternatives(&table, reading).map_err(|error| whole_file(&error))?;
    if law.max_lift_mm() <= 0.0 && law.min_lift_mm() >= 0.0 {
        let message = "every lift is 0: the profile is round; `lift: {round: true}` says so without a table";
        warnings.push(ConfigError::at(FileLocation::file(&files[0]), message));
    }
    if let Some((_, base_mm)) = profile.follower.filter(|(_, base)| law.max_lift_mm() > LIFT_PER_BASE_RADIUS * base) {
        let message = format!(
            "the largest lift is {:.3} mm on a base circle of {base_mm} mm, more than {LIFT_PER_BASE_RADIUS} times its \
             radius; is the unit of the table right?",
            law.max_lift_mm()
        );
        warnings.extend(profile.refuse("", message));
    }
    Ok(ProfileLift { law, table: Some(table), files, others, outline: None, warnings, own, throw_mm: 0.0 })
}

/// Lines and arcs through the points of a table.
fn read_outline(
    file: &LiftFile,
    profile: &LiftContext<'_>,
    source: &LiftSource,
    format: &TextFormat,
) -> Result<ProfileLift, Vec<ConfigError>> {
    let (located, orientation, nose_deg) = match source {
        LiftSource::Whole(located) => (located, Orientation::Whole, 0.0),
        LiftSource::Half(located) => (located, Orientation::Half, NOSE_DEG),
        LiftSource::Halves { .. } => {
            return Err(profile.refuse("reading", "lines_and_arcs needs the points of one table; these are two"));
        }
    };
    let printed = lift_text::read(located, format)?;
    if printed.content != Content::Points {
        let message = "lines_and_arcs needs points (columns x_mm and y_mm); this table holds something else";
        return Err(profile.refuse("reading", message));
    }
    let turned = PointsInCam {
        orientation,
        turned_deg: file.zero_deg.unwrap_or(nose_deg),
        mirrored: file.mirrored == Some(true),
        tolerance_mm: file.smooth_within_um.map_or_else(|| file.declaration(&printed).resolution_mm, mm_from_um),
    };
    let fitted = contour_table::lines_and_arcs(&located.path, &printed, &turned)?;
    let lift = outline_file::fitted(&fitted, profile)?;
    Ok(ProfileLift { files: vec![located.path.clone()], outline: Some(fitted), ..lift })
}

/// One table with a whole turn, or with the lift event of one.
fn whole_table(
    file: &LiftFile,
    profile: &LiftContext<'_>,
    path: &Path,
    mut printed: Printed,
    warnings: &mut Vec<ConfigError>,
) -> Result<LiftTable, Vec<ConfigError>> {
    let declaration = file.declaration(&printed);
    let is_lift = printed.content == Content::Lift && printed.form == LiftForm::Absolute;
    for (key, given) in [("event_only", file.is_event_only()), ("uneven", file.is_uneven())] {
        if given && !is_lift {
            return Err(profile.refuse(key, format!("{key} is about a table of lifts; this one holds something else")));
        }
        if given && !printed.findings.is_empty() {
            return Err(TableFiles::of_whole(path, &printed).errors(Vec::new()));
        }
    }
    if file.is_event_only() {
        let rows = with_base_circle(&printed.rows, &declaration);
        printed.rows = rows.map_err(|findings| TableFiles::of_whole(path, &printed).errors(findings))?;
    }
    let zero_deg = file.zero_deg.unwrap_or(0.0);
    if !file.is_uneven() {
        let files = TableFiles::of_whole(path, &printed);
        let table = files.table(LiftTable::read(&printed.rows, &declaration), warnings)?;
        let table = if file.mirrored == Some(true) { table.mirrored() } else { table };
        return table.turned_by(zero_deg).map_err(|error| profile.refuse("zero_deg", error));
    }
    // Between even angles every zero is as good as another: the rows are placed before the spline.
    let per_cam_deg = declaration.angle_unit.turn_deg() / 360.0;
    let sense = if file.mirrored == Some(true) { -1.0 } else { 1.0 };
    for row in &mut printed.rows {
        row.angle_deg = row.angle_deg.map(|angle| sense * angle + zero_deg * per_cam_deg);
    }
    if sense < 0.0 {
        printed.rows.reverse();
    }
    let rows = evenly_spaced(&printed.rows, &declaration);
    let rows = rows.map_err(|findings| TableFiles::of_whole(path, &printed).errors(findings))?;
    printed.rows = rows;
    printed.round_resampled();
    TableFiles::of_whole(path, &printed).table(LiftTable::read(&printed.rows, &declaration), warnings)
}

/// Returns true for rows from the largest angle down to the smallest. A lift stands beside its angle, so their order is free.
fn angles_descend(rows: &[LiftRow]) -> bool {
    let descends = |pair: &[LiftRow]| pair[0].angle_deg.zip(pair[1].angle_deg).is_some_and(|(a, b)| a > b);
    rows.len() > 1 && rows.windows(2).all(descends)
}

/// One or two flanks made a whole turn.
fn flanks(
    file: &LiftFile,
    profile: &LiftContext<'_>,
    places: &TableFiles<'_>,
    warnings: &mut Vec<ConfigError>,
) -> Result<LiftTable, Vec<ConfigError>> {
    let mut errors = Vec::new();
    let declaration = file.declaration(places.files[0].1);
    for (path, printed) in &places.files {
        if printed.form != LiftForm::Absolute {
            let message = "a half table holds lifts, not increments";
            return Err(vec![ConfigError::at(FileLocation::file(path), message)]);
        }
        if printed.rows.iter().all(|row| row.angle_deg.is_none()) {
            let message = "a half table without angles needs its step declared: step_cam_deg or step_crank_deg";
            return Err(vec![ConfigError::at(FileLocation::file(path), message)]);
        }
        let alone = TableFiles::of_flanks(vec![(path, printed)]);
        let (findings, doubts) = check_flank(&printed.rows, &file.declaration(printed));
        if findings.is_empty() {
            warnings.extend(doubts.iter().map(|doubt| alone.doubt(doubt)));
        } else {
            errors.extend(alone.errors(findings));
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let closing = &places.files[0].1.rows;
    // Lines of the second file go on where the first ends.
    let opening = places.files.get(1).map(|(_, printed)| {
        let mut rows = printed.rows.clone();
        rows.iter_mut().for_each(|row| row.line += places.files[0].1.lines);
        rows
    });
    let nose_deg = file.zero_deg.unwrap_or(NOSE_DEG);
    let (rows, _) =
        whole_turn(closing, opening.as_deref(), nose_deg, &declaration).map_err(|findings| match findings.first() {
            Some(error @ LiftError::ZeroOffStep { .. }) => profile.refuse("zero_deg", error),
            _ => places.errors(findings),
        })?;
    places.table(LiftTable::read(&rows, &declaration), warnings)
}

/// A lift table alone, with keys of a profile's `lift` laid over (`columns=[cam_angle_deg, lift_inch]`, …).
///
/// # Errors
/// Everything that is wrong with it.
pub fn read_alone(located: &Located, overrides: &[String]) -> Result<ProfileLift, Vec<ConfigError>> {
    let gives = |key: &str| overrides.iter().any(|over| over.split('=').next().is_some_and(|name| name.trim() == key));
    let mut keys = Vec::new();
    if !["half_table", "opening_table", "closing_table"].into_iter().any(gives) {
        keys.push(format!("table={:?}", located.path.display().to_string()));
    }
    // What the header says its angles are is what they are, where no job declares them.
    let header = located.text.lines().map(str::trim).find(|line| line.contains(AngleUnitFile::Crank.column()));
    if header.is_some_and(|line| !line.starts_with('#')) && !gives("angle") && !gives("columns") && !gives("preset") {
        keys.push("angle=crank".into());
    }
    keys.extend(overrides.iter().cloned());
    let document = Document::parse(&located.path, "{}", &keys).map_err(|error| vec![error])?;
    let file: LiftFile = schema::read(&document)?;
    read(
        &file,
        LiftContext { document: &document, key: "", name: "", follower: None, before: &[], groove: None },
        &mut JobFiles::from_document(&document),
    )
}

#[cfg(test)]
mod tests;
