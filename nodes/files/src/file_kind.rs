// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Kinds of files that users write.

use super::job_file::JobFile;
use super::machine_file::MachineFile;
use super::milling_file::MillingFile;
use super::schema;
use super::study_file::StudyFile;
use super::turning_file::TurningFile;
use serde_json::Value as Json;

/// Kind of a file that users write, as its key `schema` names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    Job,
    TurningJob,
    MillingJob,
    Machine,
    Study,
}

impl FileKind {
    pub const ALL: [Self; 5] = [Self::Job, Self::TurningJob, Self::MillingJob, Self::Machine, Self::Study];

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Job => "job",
            Self::TurningJob => "turning_job",
            Self::MillingJob => "milling_job",
            Self::Machine => "machine",
            Self::Study => "study",
        }
    }

    /// JSON Schema of the files.
    #[must_use]
    pub fn schema(self) -> Json {
        match self {
            Self::Job => schema::for_type::<JobFile>(),
            Self::TurningJob => schema::for_type::<TurningFile>(),
            Self::MillingJob => schema::for_type::<MillingFile>(),
            Self::Machine => schema::for_type::<MachineFile>(),
            Self::Study => schema::for_type::<StudyFile>(),
        }
    }
}
