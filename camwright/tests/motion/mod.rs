// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Speed planning.

mod fastest_turn;
mod point_to_point;
mod random_turns;
mod run_up;
mod varied_spindle;
