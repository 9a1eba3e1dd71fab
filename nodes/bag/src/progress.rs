// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A bar of progress for people who look on.

use super::Bag;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicBool, Ordering};

/// Refresh rate of the display (1/s).
const DRAWN_HZ: u8 = 10;

/// Set by [`hide_all`].
static HIDDEN: AtomicBool = AtomicBool::new(false);

/// Hides every bar of this process that is made afterwards.
pub fn hide_all() {
    HIDDEN.store(true, Ordering::Relaxed);
}

/// A bar of so many things, on standard error, drawn as a template of indicatif says; hidden where that is no terminal.
pub fn bar(length: u64, template: &str) -> ProgressBar {
    let target = match HIDDEN.load(Ordering::Relaxed) {
        true => ProgressDrawTarget::hidden(),
        false => ProgressDrawTarget::stderr_with_hz(DRAWN_HZ),
    };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// A bar over the messages of a bag that is read this many times.
pub(crate) fn bar_over(bag: &Bag, times: u64) -> ProgressBar {
    let messages = bag.message_counts().iter().fold(0, |sum: u64, count| sum.saturating_add(*count));
    bar(messages.saturating_mul(times), "{bar:40} {human_pos} of {human_len} messages (eta {eta})")
}
