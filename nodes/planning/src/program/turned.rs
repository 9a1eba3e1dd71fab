// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The program of a turning job: its passes along their spirals, in inverse time.

use super::super::PreparedTurning;
use super::super::files::Files;
use super::super::programmed::turning_program_shares;
use super::export::{HASH_DIGITS, c_line, file_name, key, read_back, rounded_um, runs, write_segments, x_line};
use super::ground::spindle_rpm;
use super::summary::{ProgramSummary, ReadBackSummary, TurnSummary};
use camwright::gcode::post::{
    InsertPassRequest, InsertPostRequest, PostError, PostedInsertPass, PostedInsertProgram, ProgramComparison,
    ProgramRun, compare_insert, post_insert,
};
use camwright::gcode::{Direction, MotionAction, NcAxis, ProgramFile, ProgramMotion, Tool};
use camwright::machine::description::InsertDescription;
use camwright::math::units::{deg_from_rad, rpm_from_rad_s, um_from_mm};
use camwright::planner::TurningError;
use camwright::toolpath::insert_clearance::beside_centre;
use camwright_files::ConfigError;
use std::path::Path;

/// Makes the program of a planned turning job, writes it into a folder with its summary, reads it back and compares it with the paths.
///
/// # Errors
/// Everything that cannot be made or written, one sentence with the file and the line that causes it.
pub(super) fn write(
    prepared: &PreparedTurning,
    out: &Path,
    progress: impl FnMut(&Path),
) -> Result<ProgramSummary, ConfigError> {
    let document = &prepared.job.document;
    let blamed = |error: PostError| document.error(key(&error), error.to_string());
    let drivable = Drivable::new(prepared)?;
    let (request, posted) = (&drivable.request, &drivable.posted);
    let files = request.control.dialect.write(&posted.program);
    let files = files.map_err(|error| document.error("nc", error.to_string()))?;
    let mut to = Files::new(progress);
    for file in &files {
        to.write(&out.join(&file.name), &|to| to.write_all(file.text.as_bytes()))?;
    }
    let motion = read_back(document, &request.control, out, &files)?;
    check_spindle(request, &motion).map_err(|message| document.error("nc", message))?;
    let compared = compare_insert(request, posted, &runs(&motion)).map_err(blamed)?;
    for (pass, posted) in request.passes.iter().zip(&posted.passes) {
        let path = out.join(file_name(&request.name)).join(format!("{}_segments.csv", file_name(&pass.name)));
        to.write(&path, &|to| write_segments(&['x', 'z'], &posted.knots, to))?;
    }
    let summary = summary(prepared, &drivable, &compared, &files);
    to.json(&out.join("summary.json"), &summary)?;
    Ok(summary)
}

/// Compares the spindle of the program that was read back with the one requested.
fn check_spindle(request: &InsertPostRequest<'_>, motion: &ProgramMotion) -> Result<(), String> {
    let found: Vec<_> = (motion.done.iter())
        .filter_map(|done| match done.action {
            MotionAction::SpindleOn { direction, rpm } => Some((direction, rpm)),
            _ => None,
        })
        .collect();
    let expected: Vec<_> = request.spindle.iter().map(|(direction, rpm)| (*direction, f64::from(*rpm))).collect();
    match found == expected {
        true => Ok(()),
        false => Err(format!("the program read back turns the insert's spindle {found:?} instead of {expected:?}")),
    }
}

/// Compares what a control drives of the program of a planned turning job with its paths.
///
/// # Errors
/// As [`write`]; another number of passes; a rapid that is not clear of the part.
pub(super) fn compare(prepared: &PreparedTurning, driven: &[ProgramRun]) -> Result<ProgramComparison, ConfigError> {
    let blamed = |error: PostError| prepared.job.document.error(key(&error), error.to_string());
    let drivable = Drivable::new(prepared)?;
    compare_insert(&drivable.request, &drivable.posted, driven).map_err(blamed)
}

/// Largest number of attempts: a slower pass may get a finer tolerance, which may have to be slower again.
const ATTEMPTS: u32 = 24;

/// Share of the speed that counts as all of it: F is rounded. A block rate is kept with a thousandth to spare.
const ALL: f64 = 0.9999;
const SPARE: f64 = 0.999;

/// Why a pass turns more slowly than its plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SlowedBy {
    BlockRate,
    AxisLimits,
}

/// A program that the axes of the job's machine drive, corners rounded as its path tolerance allows.
struct Drivable<'a> {
    request: InsertPostRequest<'a>,
    posted: PostedInsertProgram,
    /// Why a pass is slower than its plan, if it is.
    slowed_by: Vec<Option<SlowedBy>>,
}

impl<'a> Drivable<'a> {
    /// Slows passes down until the control reads their blocks and the axes keep their limits.
    fn new(prepared: &'a PreparedTurning) -> Result<Self, ConfigError> {
        let document = &prepared.job.document;
        let is_stated = prepared.job.spec.speed.is_stated();
        let mut request = request(prepared)?;
        let mut slowed_by = vec![None; request.passes.len()];
        for _ in 0..ATTEMPTS {
            let posted = match post_insert(&request) {
                Ok(posted) => posted,
                Err(PostError::TooManyBlocks { pass, blocks_s, max_s, .. }) if !is_stated => {
                    let passes = request.passes.iter_mut().zip(&mut slowed_by);
                    for (slow, by) in passes.filter(|(other, _)| other.name == pass) {
                        (slow.speed_share, *by) =
                            (slow.speed_share * SPARE * max_s / blocks_s, Some(SlowedBy::BlockRate));
                    }
                    continue;
                }
                Err(error) => return Err(document.error(key(&error), error.to_string())),
            };
            let shares = turning_program_shares(prepared, &request.control, &posted.program)?;
            if shares.iter().all(|share| *share >= ALL) {
                return Ok(Self { request, posted, slowed_by });
            }
            if is_stated {
                return Err(too_fast(prepared, &request, &shares));
            }
            let passes = request.passes.iter_mut().zip(&mut slowed_by).zip(shares);
            for ((slow, by), share) in passes.filter(|(_, share)| *share < ALL) {
                (slow.speed_share, *by) = (slow.speed_share * share, Some(SlowedBy::AxisLimits));
            }
        }
        let message =
            format!("no speed of C was found in {ATTEMPTS} attempts: state a slower one with spindle.law constant");
        Err(document.error("spindle", message))
    }
}

/// Why a stated speed has no program.
fn too_fast(prepared: &PreparedTurning, request: &InsertPostRequest<'_>, shares: &[f64]) -> ConfigError {
    let slowest = request.passes.iter().zip(shares).min_by(|(_, a), (_, b)| a.total_cmp(b));
    let message = slowest.map_or_else(String::new, |(pass, share)| {
        let stated_rpm = rpm_from_rad_s(pass.spindle.range_rad_s.1);
        format!(
            "{}: at {stated_rpm:.2} rpm the axes exceed their limits where blocks meet; they keep {:.2} rpm, or more with a larger \
             nc.path_tolerance_um",
            pass.name,
            (share * stated_rpm * 100.0).floor() / 100.0
        )
    });
    prepared.job.document.error("spindle.rpm", message)
}

fn request(prepared: &PreparedTurning) -> Result<InsertPostRequest<'_>, ConfigError> {
    let (job, settings) = (&prepared.job, &prepared.job.nc);
    let insert = prepared.machine.insert;
    let insert = insert.ok_or_else(|| job.document.error("machine", TurningError::NotALathe.to_string()))?;
    let radius_mm = insert.radius_mm;
    if let (None, Some(_)) = (insert.spindle, settings.spindle_rpm) {
        let message =
            "nc.spindle_rpm is for an insert that rotates; the machine's does not (insert.rotates: false): remove it";
        return Err(job.document.error("nc.spindle_rpm", message));
    }
    let spindle = insert.spindle.map(|spindle| {
        let by_surface = || spindle_rpm(spindle.surface_speed_m_s, radius_mm);
        (Direction::from(spindle.rotation), settings.spindle_rpm.unwrap_or_else(by_surface))
    });
    Ok(InsertPostRequest {
        name: job.spec.name.clone(),
        number: settings.program_number,
        header: header(prepared, &insert),
        tool: Tool {
            number: settings.tool_number,
            radius_mm,
            text: format!("round insert, rake face {}", beside_centre(-insert.height_mm)),
        },
        spindle,
        coolant: settings.coolant,
        control: settings.control,
        x_shift_mm: if settings.x_of_edge { -radius_mm } else { 0.0 },
        clear_mm: job.spec.clear_mm(radius_mm),
        passes: passes(prepared),
    })
}

fn passes(prepared: &PreparedTurning) -> Vec<InsertPassRequest<'_>> {
    let settings = &prepared.job.nc;
    let last = prepared.planned.passes.len().saturating_sub(1);
    let requests = prepared.planned.passes.iter().enumerate().map(|(index, planned)| {
        let (name, tolerance_mm) = if index == last {
            ("finishing".to_owned(), settings.finish_tolerance_mm)
        } else {
            (format!("roughing {}", index + 1), settings.rough_tolerance_mm)
        };
        InsertPassRequest {
            name,
            path: &planned.path,
            spindle: &planned.spindle,
            speed_share: 1.0,
            tolerance_mm,
            widest_tolerance_mm: settings.widest_tolerance_mm.max(tolerance_mm),
            knots: settings.knots,
        }
    });
    requests.collect()
}

/// Header comments: contents and sources of the program. Nothing in them depends on the date.
fn header(prepared: &PreparedTurning, insert: &InsertDescription) -> Vec<String> {
    let (job, settings) = (&prepared.job, &prepared.job.nc);
    let mut tolerances = vec![format!("finishing {} um", rounded_um(settings.finish_tolerance_mm))];
    if prepared.planned.passes.len() > 1 {
        tolerances.insert(0, format!("roughing {} um", rounded_um(settings.rough_tolerance_mm)));
    }
    vec![
        format!("{} - turned with a round insert, radius {:.3} mm", job.spec.name, insert.radius_mm),
        format!("camwright {}, job {:.HASH_DIGITS$}", env!("CARGO_PKG_VERSION"), job.hash),
        format!("tolerances: {}", tolerances.join(", ")),
        "lengths in mm, angles in degrees, F in 1/min, G93".to_owned(),
        x_line(settings, "insert"),
        "Z is z of the part in front of the centre of the insert".to_owned(),
        c_line(settings),
    ]
}

fn summary(
    prepared: &PreparedTurning,
    drivable: &Drivable<'_>,
    compared: &ProgramComparison,
    files: &[ProgramFile],
) -> ProgramSummary {
    let (request, posted) = (&drivable.request, &drivable.posted);
    let of_pass = |(pass, posted): (&InsertPassRequest<'_>, &PostedInsertPass)| {
        let letter =
            |axis: usize| [NcAxis::X, NcAxis::Z].get(axis).map_or_else(String::new, |axis| axis.letter().into());
        let deviation = &posted.deviation;
        TurnSummary {
            feature: request.name.clone(),
            pass: pass.name.clone(),
            calls: 1,
            blocks: posted.blocks,
            segments: posted.blocks,
            theoretical_segments: posted.theoretical_blocks,
            tolerance_um: um_from_mm(posted.tolerance_mm),
            error_um: um_from_mm(deviation.error_mm),
            error_axis: letter(deviation.error_axis),
            error_at_deg: deg_from_rad(deviation.error_at_rad),
            // A slope per radian is smaller per degree.
            slope_step_mm_deg: deviation.slope_jump_mm_rad / deg_from_rad(1.0),
            slope_axis: letter(deviation.slope_axis),
            slope_at_deg: deg_from_rad(deviation.slope_at_rad),
            velocity_step_mm_s: posted.velocity_step_mm_s,
            blocks_s: posted.blocks_s,
            time_s: posted.time_s,
        }
    };
    ProgramSummary {
        job: request.name.clone(),
        job_hash: prepared.job.hash.clone(),
        files: files.iter().map(|file| file.name.clone()).collect(),
        lines: files.iter().map(|file| file.text.lines().count()).sum(),
        turns: request.passes.iter().zip(&posted.passes).map(of_pass).collect(),
        calls: posted.passes.len(),
        feed_time_s: posted.feed_time_s,
        read_back: ReadBackSummary {
            moves: compared.moves,
            error_um: compared.error_um(),
            share_of_tolerance: compared.share_of_tolerance,
            time_error_s: compared.time_error_s,
        },
        notes: notes(drivable),
    }
}

/// Notes on passes with another tolerance or speed than the job asks for.
fn notes(drivable: &Drivable<'_>) -> Vec<String> {
    let control = &drivable.request.control;
    let shortest_s = control.dialect.shortest_block_s();
    let mut notes = Vec::new();
    let passes = drivable.request.passes.iter().zip(&drivable.posted.passes);
    for ((pass, posted), slowed_by) in passes.zip(&drivable.slowed_by) {
        if posted.tolerance_mm > pass.tolerance_mm {
            notes.push(format!(
                "{}: a tolerance of {:.3} um instead of {:.3}, so that the control reads no more than {:.0} blocks a second",
                pass.name,
                um_from_mm(posted.tolerance_mm),
                um_from_mm(pass.tolerance_mm),
                control.max_blocks_s.min(1.0 / shortest_s),
            ));
        }
        if let Some(by) = slowed_by {
            let fastest_rpm = rpm_from_rad_s(pass.spindle.range_rad_s.1);
            let why = match by {
                SlowedBy::BlockRate => format!(
                    "the control reads {:.0} blocks a second; a larger tolerance takes fewer",
                    control.max_blocks_s.min(1.0 / shortest_s)
                ),
                SlowedBy::AxisLimits => "the axes keep their limits where blocks meet".to_owned(),
            };
            notes.push(format!(
                "{}: C turns at {:.1} rpm at most instead of {fastest_rpm:.1}: {why}",
                pass.name,
                pass.speed_share * fastest_rpm,
            ));
        }
        if posted.lengthened > 0 {
            notes.push(format!(
                "{}: {} of {} blocks take {shortest_s:.4} s, the minimum of F on this control; C is slower in them",
                pass.name, posted.lengthened, posted.blocks,
            ));
        }
    }
    notes
}
