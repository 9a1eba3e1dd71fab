//! A bar of progress for people who look on.

use super::Bag;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Refresh rate of the display (1/s).
const DRAWN_HZ: u8 = 10;

/// A bar of so many things, on standard error, drawn as a template of indicatif says; hidden where that is no terminal.
pub fn bar(length: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr_with_hz(DRAWN_HZ));
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
