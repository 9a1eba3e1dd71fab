// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Whole jobs: grinding campaigns, milling, turning.

mod milling_job;
mod random_cams;
mod supported_shaft;
mod turned_program;
mod turning_drives;
mod turning_job;
