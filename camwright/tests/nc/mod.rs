// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs for controls that are not ours: what is written, what is read, and what is refused.

mod mutated;
mod read;
mod read_refused;
mod refused;
mod sample;
mod written;
