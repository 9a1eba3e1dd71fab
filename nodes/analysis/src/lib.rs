// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Analysis of recorded runs, from bags alone: report, replay to the bit, and planning again.

pub mod replan;
pub mod report;
pub mod rerun;
