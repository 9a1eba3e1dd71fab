// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A writer and a reader of one participant are not matched.

use super::common::{Checked, Verdict, participant, reader, take, text, writer};
use std::time::Duration;

const ROUNDS: usize = 3;

pub(crate) fn check() -> Checked {
    let participant = participant()?;
    let mut missed = [0; 2];
    for round in 0..2 * ROUNDS {
        let name = format!("one_participant_{round}");
        let (writer, mut reader) = if round % 2 == 0 {
            let first = writer(&participant, &name, 1)?;
            (first, reader(&participant, &name, 1)?)
        } else {
            let first = reader(&participant, &name, 1)?;
            (writer(&participant, &name, 1)?, first)
        };
        let mut arrived = false;
        for _ in 0..10 {
            writer.write(vec![0], None).map_err(text)?;
            arrived |= take(&mut reader, Duration::from_millis(40))?.is_some();
            if arrived {
                break;
            }
        }
        missed[round % 2] += usize::from(!arrived);
    }
    let [second, first] = missed;
    Ok(Verdict::pass_if(missed == [0, 0], || {
        format!(
            "of {ROUNDS} readers each, {second} created after and {first} created before their writer received nothing"
        )
    }))
}
