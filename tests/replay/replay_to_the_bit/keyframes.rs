// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From the middle: every keyframe begins a run that is the same to the bit, and none is trusted.

use crate::changed_bag::{Original, as_it_was};
use camwright_analysis::rerun::{ReplayVerdict, Window, rerun, within};
use camwright_msgs::camwright_msgs::msg::{MachineInput, MachineKeyframe};
use std::path::Path;

fn from_tick(tick: u64) -> Window {
    Window { from_tick: Some(tick), to_tick: None }
}

pub(super) fn all(path: &Path, original: &Original, whole: &ReplayVerdict) {
    let heads = original.keyframes();
    assert_eq!(whole.keyframes, heads.len(), "{}", whole.to_text());
    every_keyframe_begins_the_same_run(path, &heads, whole);
    a_window_is_the_same(path, &heads);
    before_the_first_is_the_beginning(path, &heads);
    a_late_recorder_has_the_rest(original, &heads);
    no_keyframe_is_trusted(original, &heads);
}

fn every_keyframe_begins_the_same_run(path: &Path, heads: &[MachineKeyframe], whole: &ReplayVerdict) {
    assert!(heads.len() > 8, "{} keyframes", heads.len());
    let during_jobs = heads.iter().filter(|head| head.job_tick > 0).count();
    assert!(during_jobs > 3, "{during_jobs} of {} keyframes in jobs", heads.len());
    let step = heads.len().div_ceil(9);
    for (index, head) in heads.iter().enumerate().step_by(step) {
        let verdict = within(path, from_tick(head.tick + 3)).unwrap_or_else(|error| panic!("{}: {error}", head.tick));
        println!("{}", verdict.to_text());
        assert!(verdict.is_identical(), "from tick {}: {}", head.tick, verdict.to_text());
        assert_eq!((verdict.begun, verdict.keyframes), (head.tick, heads.len() - 1 - index));
        assert_eq!(verdict.ticks + head.tick, whole.ticks);
        assert_eq!(verdict.digests.1, whole.digests.1);
    }
}

fn a_window_is_the_same(path: &Path, heads: &[MachineKeyframe]) {
    let (from, to) = (heads[heads.len() / 2].tick, heads[heads.len() / 2].tick + 700);
    let verdict = within(path, Window { from_tick: Some(from), to_tick: Some(to) }).expect("a window");
    assert!(verdict.is_identical() && verdict.ticks == 700, "{}", verdict.to_text());
    let nothing =
        within(path, Window { from_tick: Some(to), to_tick: Some(from) }).expect_err("it ends before it begins");
    assert!(nothing.to_string().contains("there is no tick between "), "{nothing}");
}

fn before_the_first_is_the_beginning(path: &Path, heads: &[MachineKeyframe]) {
    let verdict = within(path, Window { from_tick: Some(heads[0].tick - 1), to_tick: Some(heads[0].tick + 5) });
    let verdict = verdict.expect("the beginning was recorded");
    assert!(verdict.is_identical() && verdict.begun == 0 && verdict.keyframes == 1, "{}", verdict.to_text());
}

/// A recorder that comes late has no beginning, but what comes after the first keyframe that it hears.
fn a_late_recorder_has_the_rest(original: &Original, heads: &[MachineKeyframe]) {
    let first = heads[3].tick;
    let inputs = original.places::<MachineInput>();
    let is_early = |place: usize| {
        inputs.binary_search(&place).is_ok() && original.decoded::<MachineInput>(place).tick + 40 < first
    };
    let to = original.rewritten(|index, message| as_it_was(message).filter(|_| !is_early(index)));
    let text = rerun(to).expect_err("it has no beginning").to_string();
    assert!(text.contains("of before the recorder listened"), "{text}");
    assert!(text.ends_with(&format!("; from a keyframe on it is whole: --from-tick {first}")), "{text}");
    let verdict = within(to, from_tick(first)).expect("it is whole from there");
    assert!(verdict.is_identical() && verdict.begun == first, "{}", verdict.to_text());
    let text = within(to, from_tick(first - 1)).expect_err("the keyframe before").to_string();
    assert!(text.contains("machine/inputs is not whole: "), "{text}");
}

fn no_keyframe_is_trusted(original: &Original, heads: &[MachineKeyframe]) {
    let head = &heads[heads.len() / 2];
    let state = original.state(head);
    let other = |change: fn(&mut Vec<u8>)| {
        let mut state = state.clone();
        change(&mut state);
        state
    };
    // A bit of it, by accident.
    let to = original.with_state(head, &other(|state| state[9] ^= 4), false);
    let text = within(to, from_tick(head.tick)).expect_err("its check does not fit").to_string();
    assert!(text.contains(&format!("the keyframe of tick {} is not as it was recorded", head.tick)), "{text}");
    // The lowest bit of the wheel's radius, on purpose: the first number after the tick.
    let to = original.with_state(head, &other(|state| state[8] ^= 1), true);
    let verdict = rerun(to).expect("it can be computed");
    let first = verdict.differences.first().expect("the state is another");
    let text = first.to_string();
    assert!(first.tick == head.tick && text.contains("state of the machine"), "{text}");
    assert!(text.contains("machine.lasting.wheel_radius_mm: it was "), "{text}");
    // What is no machine at all.
    let to = original.with_state(head, &other(|state| state.truncate(state.len() - 3)), true);
    let text = within(to, from_tick(head.tick)).expect_err("it ends too early").to_string();
    assert!(text.contains("its octets end there"), "{text}");
    let to = original.with_state(head, &other(|state| state[8..16].copy_from_slice(&f64::NAN.to_le_bytes())), true);
    let text = within(to, from_tick(head.tick)).expect_err("no radius").to_string();
    assert!(text.contains("machine.lasting.wheel_radius_mm: a number is larger than it can be, or none"), "{text}");
}
