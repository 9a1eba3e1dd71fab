//! NC programs of jobs, for machines whose controls read text: what `camwright post` makes.
//!
//! ```text
//! PreparedJob ─► ground ─┐
//! MilledJob ───► milled ─┴► ProgramRequest ─► camwright::gcode::post ─► Program ─► files ─► read back from the disk ─► compared with the paths
//! ```

mod export;
mod ground;
mod milled;
mod summary;

pub(super) use export::check_milled;
pub(super) use export::error_mm;
pub use export::{compare_program, write_program};
pub(super) use ground::refuse_what_needs_the_machine;
pub use summary::{ProgramSummary, TurnSummary as ProgrammedTurn};

use super::plots::nc::Outline;
use camwright::gcode::post::ProgramRequest;
use camwright_files::nc_file::NcSettings;
use camwright_files::yaml::Document;

/// A program that is to be made, and what is told of it.
pub(super) struct ToPost<'a> {
    /// What is asked for.
    pub(super) request: ProgramRequest<'a>,
    pub(super) settings: NcSettings,
    /// The job file, for messages that point into it.
    pub(super) document: &'a Document,
    /// Name of the job.
    pub(super) job: &'a str,
    /// Hash of the job, 64 hexadecimal digits.
    pub(super) job_hash: &'a str,
    /// Shapes to draw, one for each feature.
    pub(super) outlines: Vec<Outline>,
    /// What is worth knowing about it, in sentences.
    pub(super) notes: Vec<String>,
}
