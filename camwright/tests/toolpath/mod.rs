// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Paths of wheel, cutter and insert.

mod archimedean;
mod bore;
mod crank_pin;
mod cutter_path;
mod groove_barrel;
mod groove_course;
mod groove_plate;
mod insert_clearance;
mod insert_path;
mod tool_path;
