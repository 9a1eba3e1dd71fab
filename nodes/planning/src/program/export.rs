// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A program on the disk, and read back from there.
//!
//! | file | holds |
//! |---|---|
//! | the control's own | main program and subprograms |
//! | `summary.json` | what is known of it |
//! | `<feature>/<pass>_segments.csv` | every knot: angle of C in the part's frame, the axes that move, the slope to the next one |
//! | `<feature>/tool_path.svg`, `.png` | the shape, the cutter along its path, the segments in turn in two colours |
//! | `<feature>/<pass>_segments.svg`, `.png` | travels over the angle with their knots, slopes, errors with the tolerance |
//!
//! Paths between the walls of a groove have no drawings, and neither have turned parts.

use super::super::files::Files;
use super::super::finding::{CheckReport, Finding, Severity};
use super::super::plan;
use super::super::plan_turned;
use super::super::plots::nc::program_plots;
use super::request::ToPost;
use super::summary::{self, ProgramSummary};
use super::{ground, milled, turned};
use camwright::gcode::post::{NcControl, PostError, ProgramComparison, ProgramRun, compare, post};
use camwright::gcode::{MotionAction, NcAxis, ProgramFile, ProgramMotion, ProgramPose, read};
use camwright::math::units::{deg_from_rad, um_from_mm};
use camwright_files::any_job::{self, AnyJob};
use camwright_files::milling_file::MilledJob;
use camwright_files::nc_file::NcSettings;
use camwright_files::yaml::Document;
use camwright_files::{ConfigError, FileLocation};
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// Displayed digits of a hash.
pub(super) const HASH_DIGITS: usize = 16;

/// Makes the program of a job, writes it into a folder with its summary, reads it back and compares; calls `progress` for every file.
///
/// # Errors
/// Everything that cannot be made, one sentence with the file and the line that causes it.
pub fn write_program(
    job: &str,
    overrides: &[String],
    out: &Path,
    progress: impl FnMut(&Path),
) -> Result<ProgramSummary, ConfigError> {
    match any_job::load(job, overrides)? {
        AnyJob::Turned(job) => turned::write(&plan_turned(*job, None)?, out, progress),
        job => with_request(job, |to_post| write(to_post, out, progress)),
    }
}

/// Compares what a control drives of the program of a job with the paths that it was made for.
///
/// # Errors
/// What [`write_program`] says; another number of calls; a rapid that is not clear of the part.
pub fn compare_program(
    job: &str,
    overrides: &[String],
    driven: &[ProgramRun],
) -> Result<ProgramComparison, ConfigError> {
    let job = match any_job::load(job, overrides)? {
        AnyJob::Turned(job) => return turned::compare(&plan_turned(*job, None)?, driven),
        job => job,
    };
    with_request(job, |to_post| {
        let blamed = |error: PostError| to_post.document.error(key(&error), error.to_string());
        let posted = post(&to_post.request).map_err(blamed)?;
        compare(&to_post.request, &posted, driven).map_err(blamed)
    })
}

/// Report of a milling job before anything is written.
pub(crate) fn check_milled(path: &Path, job: &MilledJob) -> CheckReport {
    let posted = milled::with_request(job, |to_post| {
        let posted = post(&to_post.request).map_err(|error| to_post.document.error(key(&error), error.to_string()))?;
        let blocks: usize = posted.calls.iter().map(|call| posted.turns[call.0].blocks).sum();
        let name = to_post.job;
        let (calls, feeds_s) = (posted.calls.len(), posted.feed_time_s);
        Ok((format!("{name}: {calls} calls, {blocks} blocks, {feeds_s:.2} s of feeds"), to_post.notes))
    });
    let warnings = job.lifts.iter().flat_map(|(_, lift)| &lift.warnings);
    let warnings = warnings.map(|warning| Finding { severity: Severity::Warning, error: warning.clone() }).collect();
    match posted {
        Ok((summary, notes)) => {
            CheckReport { file: path.to_path_buf(), findings: warnings, summary: Some(summary), notes }
        }
        Err(error) => {
            let mut report = CheckReport::refused(path, vec![error]);
            report.findings.extend(warnings);
            report
        }
    }
}

/// Makes the request of a job whose cutter goes in turns and hands it on.
fn with_request<R>(job: AnyJob, done: impl FnOnce(ToPost<'_>) -> Result<R, ConfigError>) -> Result<R, ConfigError> {
    match job {
        AnyJob::Ground(job) => {
            let settings = job.nc;
            ground::with_request(&plan(*job, None)?, &settings, done)
        }
        AnyJob::Milled(job) => milled::with_request(&job, done),
        AnyJob::Turned(job) => {
            let message =
                format!("{} is turned along a spiral; its program has no subprogram for a turn", job.spec.name);
            Err(job.document.error("schema", message))
        }
    }
}

fn write(mut to_post: ToPost<'_>, out: &Path, progress: impl FnMut(&Path)) -> Result<ProgramSummary, ConfigError> {
    to_post.request.header = header(&to_post);
    let blamed = |error: &PostError| to_post.document.error(key(error), error.to_string());
    let posted = post(&to_post.request).map_err(|error| blamed(&error))?;
    let dialect = to_post.request.control.dialect;
    let files = dialect.write(&posted.program);
    let files = files.map_err(|error| to_post.document.error("nc", error.to_string()))?;
    let mut to = Files::new(progress);
    for file in &files {
        to.write(&out.join(&file.name), &|to| to.write_all(file.text.as_bytes()))?;
    }
    let motion = read_back(to_post.document, &to_post.request.control, out, &files)?;
    let found = runs(&motion);
    let compared = compare(&to_post.request, &posted, &found).map_err(|error| blamed(&error))?;
    for turn in &posted.turns {
        let of = &to_post.request.features[turn.feature];
        let path =
            out.join(file_name(&of.name)).join(format!("{}_segments.csv", file_name(&of.passes[turn.pass].name)));
        let letters: Vec<char> = turn.axes.iter().map(|axis| axis.letter().to_ascii_lowercase()).collect();
        to.write(&path, &|to| write_segments(&letters, &turn.knots, to))?;
    }
    for (folder, plot) in program_plots(&to_post, &posted) {
        to.plot(&out.join(file_name(folder)), &plot)?;
    }
    let summary = summary::summary(&to_post, &posted, &compared, &files);
    to.json(&out.join("summary.json"), &summary)?;
    Ok(summary)
}

/// A name as part of a path: letters, digits, `-` and `_`.
pub(super) fn file_name(name: &str) -> String {
    let fit = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().map(fit).collect()
}

/// Header comments: contents and sources of the program. Nothing in them depends on the date.
fn header(to_post: &ToPost<'_>) -> Vec<String> {
    let (request, settings) = (&to_post.request, &to_post.settings);
    let mut tolerances: Vec<String> = Vec::new();
    for pass in request.features.iter().flat_map(|of| &of.passes) {
        let tolerance = format!("{} {} um", pass.name, rounded_um(pass.tolerance_mm));
        if !tolerances.contains(&tolerance) {
            tolerances.push(tolerance);
        }
    }
    vec![
        format!("{} - {}", to_post.job, request.tool.text),
        format!("camwright {}, job {:.HASH_DIGITS$}", env!("CARGO_PKG_VERSION"), to_post.job_hash),
        format!("tolerances: {}", tolerances.join(", ")),
        x_line(settings, "cutter"),
        c_line(settings),
    ]
}

/// Meaning of X, as a comment.
pub(super) fn x_line(settings: &NcSettings, tool: &str) -> String {
    let factor = match settings.control.format.x_values() {
        camwright::gcode::XValues::Radius => "",
        camwright::gcode::XValues::Diameter => "twice ",
    };
    let point = if settings.x_of_edge { "cutting edge".to_owned() } else { format!("centre of the {tool}") };
    format!("X is {factor}the distance of the {point} from the axis of C")
}

/// Meaning of a positive C, as a comment.
pub(super) fn c_line(settings: &NcSettings) -> String {
    let way = if settings.control.rotation_sense > 0 { "clockwise" } else { "counterclockwise" };
    format!("positive C turns the part {way} seen from +Z")
}

/// A tolerance for people, without the digits of its conversion.
pub(super) fn rounded_um(mm: f64) -> f64 {
    (um_from_mm(mm) * 1e6).round() / 1e6
}

/// The key of the job that is behind a refusal.
pub(super) fn key(error: &PostError) -> &'static str {
    match error {
        PostError::Of { source, .. } => key(source),
        PostError::TooManyBlocks { .. } => "nc.most_blocks_s",
        PostError::Chain(_) | PostError::OffThePath { .. } | PostError::TooLongPass { .. } => "nc.finish_tolerance_um",
        PostError::TooManyTurns { .. } => "nc.rotary_decimals",
        PostError::Format(_) => "nc.linear_decimals",
        _ => "nc",
    }
}

/// The files as they are on the disk, as a control would drive them.
pub(super) fn read_back(
    document: &Document,
    control: &NcControl,
    out: &Path,
    written: &[ProgramFile],
) -> Result<ProgramMotion, ConfigError> {
    let mut files = Vec::with_capacity(written.len());
    for file in written {
        let path = out.join(&file.name);
        let text = fs::read_to_string(&path)
            .map_err(|error| ConfigError::at(FileLocation::file(&path), format!("cannot be read back: {error}")))?;
        files.push(ProgramFile { name: file.name.clone(), text });
    }
    read(control.dialect, control.format.x_values(), &files)
        .map_err(|error| document.error("nc", format!("the written program cannot be read back: {error}")))
}

/// Motions of a program that was read.
pub(super) fn runs(motion: &ProgramMotion) -> Vec<ProgramRun> {
    let place = |pose: ProgramPose| NcAxis::ALL.map(|axis| pose.position(axis).unwrap_or(f64::NAN));
    let ran = motion.done.iter().filter_map(|done| match done.action {
        MotionAction::Rapid(pose) => Some(ProgramRun { pose: place(pose), time_s: None }),
        MotionAction::Feed { pose, time_s } => Some(ProgramRun { pose: place(pose), time_s: Some(time_s) }),
        _ => None,
    });
    ran.collect()
}

/// Writes knots with the slopes of the segments behind them; the letters are those of the axes.
pub(super) fn write_segments<P: AsRef<[f64]>>(
    letters: &[char],
    knots: &[(f64, P)],
    to: &mut dyn Write,
) -> io::Result<()> {
    write!(to, "c_deg")?;
    for letter in letters {
        write!(to, ",{letter}_mm")?;
    }
    for letter in letters {
        write!(to, ",{letter}_slope_mm_deg")?;
    }
    writeln!(to)?;
    for (index, (u_rad, positions)) in knots.iter().enumerate() {
        let positions = positions.as_ref();
        write!(to, "{}", deg_from_rad(*u_rad))?;
        for position in positions {
            write!(to, ",{position}")?;
        }
        for (axis, position) in positions.iter().enumerate() {
            match knots.get(index + 1) {
                Some((next_rad, next)) => {
                    write!(to, ",{}", (next.as_ref()[axis] - position) / deg_from_rad(next_rad - u_rad))?;
                }
                None => write!(to, ",")?,
            }
        }
        writeln!(to)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drawings of the programs of all shipped jobs that have one: no text is cut, overlaps another or is too small.
    #[test]
    fn every_text_on_the_drawings_of_a_program_can_be_read() {
        for job in [
            "plate_groove",
            "barrel_groove",
            "barrel_indexer",
            "level_wind",
            "eccentric_disc",
            "four_lobe_camshaft",
            "rough_and_finish",
            "eccentric",
            "plate_cam",
            "brake_cam",
        ] {
            let count = with_request(any_job::load(job, &[]).expect("a job"), |to_post| {
                let posted = post(&to_post.request).map_err(|error| to_post.document.error("nc", error.to_string()))?;
                let plots = program_plots(&to_post, &posted);
                for (folder, plot) in &plots {
                    assert_eq!(plot.drawing.text_faults(), [""; 0], "{job} {folder} {}", plot.name);
                    assert!(plot.caption.ends_with('.'), "{job} {folder} {}", plot.name);
                }
                Ok(plots.len())
            });
            assert!(count.unwrap_or_else(|error| panic!("{job}: {error}")) >= 2, "{job}");
        }
    }

    /// A wide groove for a small mill has many paths: only those of its walls are drawn.
    #[test]
    fn paths_between_the_walls_have_no_drawings() {
        let wide = ["profiles.two_dwells.follower.radius_mm=30".to_owned()];
        let drawn = with_request(any_job::load("plate_groove", &wide).expect("a job"), |to_post| {
            let posted = post(&to_post.request).map_err(|error| to_post.document.error("nc", error.to_string()))?;
            assert!(to_post.request.features.iter().any(|feature| feature.name == "G between 1"));
            let plots = program_plots(&to_post, &posted);
            Ok(plots.iter().map(|(folder, _)| (*folder).to_owned()).collect::<std::collections::BTreeSet<_>>())
        });
        assert_eq!(drawn.expect("a program"), ["G inner wall".to_owned(), "G outer wall".to_owned()].into());
    }
}
