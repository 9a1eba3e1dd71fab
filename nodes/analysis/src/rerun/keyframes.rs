// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Keyframes of a bag: where a run can be computed from the middle, and what the machine's state is held against on its way.

use super::error::RerunError;
use super::topics::{ReplayTopics, read};
use camwright_bag::Bag;
use camwright_files::convert::keyframes::check;
use camwright_machine_cycle::keyframes::FORM as KEYFRAME_FORM;
use camwright_msgs::camwright_msgs::msg::MachineKeyframe;

/// The last keyframe up to a tick that this program can read.
///
/// # Errors
/// There is none, and why.
pub(super) fn last_before(heads: &[MachineKeyframe], tick: u64) -> Result<&MachineKeyframe, String> {
    let instead = "without --from-tick a run is computed from its beginning";
    let Some(first) = heads.first() else {
        return Err(format!(
            "it has no keyframe: machine/keyframes was not recorded, or the machine wrote none (keyframe_period_s); {instead}"
        ));
    };
    let readable = || heads.iter().filter(|head| head.form == KEYFRAME_FORM);
    let Some(first_readable) = readable().next() else {
        return Err(format!(
            "its keyframes are of form {}, this program reads form {KEYFRAME_FORM}; {instead}",
            first.form
        ));
    };
    let before = readable().rfind(|head| head.tick <= tick);
    before.ok_or_else(|| format!("its first keyframe is of tick {}, after tick {tick}; {instead}", first_readable.tick))
}

/// The state of a keyframe.
///
/// # Errors
/// A bag that cannot be read, a keyframe that is not as it was made.
pub(super) fn state(bag: &Bag, topics: &ReplayTopics, head: &MachineKeyframe) -> Result<Vec<u8>, RerunError> {
    let mut messages = bag.messages();
    let mut state: Vec<u8> = Vec::new();
    while let Some(message) = messages.next_message()? {
        if Some(message.topic) != topics.keyframes {
            continue;
        }
        let page: MachineKeyframe = read(bag, &message)?;
        if page.tick == head.tick && page.check == head.check {
            if page.page == 0 {
                state.clear();
            }
            state.extend(&page.data);
            if page.page + 1 == page.page_count {
                break;
            }
        }
    }
    if check(head, &state) != head.check {
        let reason = format!("the keyframe of tick {} is not as it was recorded: its check does not fit", head.tick);
        return Err(RerunError::Cannot(reason));
    }
    Ok(state)
}
