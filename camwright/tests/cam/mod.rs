// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lift, contour, surface and form error.

mod compensation;
mod contour;
mod form;
mod inspection;
mod lift_defects;
mod lift_halves;
mod lift_law;
mod lift_points;
mod lift_reading;
mod lift_table;
mod oscillating;
mod shipped_tables;
mod surface;
