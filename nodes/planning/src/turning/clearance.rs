// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Clearance between insert and surface.

use camwright::machine::description::InsertDescription;
use camwright::toolpath::insert_clearance::{ClearanceMap, Flank, InsertClearanceError};
use camwright_files::turning_file::TurnedJob;

/// Clearance of insert and surface of a job, at every height of the insert.
pub(super) fn clearance_map(job: &TurnedJob, insert: &InsertDescription) -> Result<ClearanceMap, InsertClearanceError> {
    let (from_mm, to_mm) = job.spec.range_mm();
    ClearanceMap::new(&job.spec.surface, from_mm, to_mm, Flank::from_insert(insert))
}
