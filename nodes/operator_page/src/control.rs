// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Control of the cell from the page, for viewers with its token.

use super::operation::{Answer, Operation};
use super::operator::Operator;
use std::fs::File;
use std::io::{self, Read as _};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A jog ends after this time without a sign of life from the button.
const DEAD_MAN: Duration = Duration::from_millis(500);

/// Performs operations of viewers that present the token.
#[derive(Debug)]
pub(super) struct Control {
    token: String,
    operator: Operator,
    jog_button: HeldButton,
}

/// A button that counts as held for [`DEAD_MAN`] after each sign of life.
#[derive(Debug, Default)]
struct HeldButton {
    /// `None`: released.
    last_sign: Mutex<Option<Instant>>,
}

impl HeldButton {
    fn last_sign(&self) -> MutexGuard<'_, Option<Instant>> {
        self.last_sign.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns false if the button is held already.
    fn press(&self, now: Instant) -> bool {
        let mut last_sign = self.last_sign();
        let is_free = !is_alive(*last_sign, now);
        if is_free {
            *last_sign = Some(now);
        }
        is_free
    }

    /// Sign of life. A released button stays released.
    fn renew(&self, now: Instant) {
        let mut last_sign = self.last_sign();
        if is_alive(*last_sign, now) {
            *last_sign = Some(now);
        }
    }

    fn release(&self) {
        *self.last_sign() = None;
    }

    fn is_held(&self, now: Instant) -> bool {
        is_alive(*self.last_sign(), now)
    }
}

fn is_alive(last_sign: Option<Instant>, now: Instant) -> bool {
    last_sign.is_some_and(|last| now.saturating_duration_since(last) < DEAD_MAN)
}

impl Control {
    /// Control with a random token of 128 bits.
    pub(super) fn new(operator: Operator) -> io::Result<Self> {
        let mut random = [0; 16];
        File::open("/dev/urandom")?.read_exact(&mut random)?;
        let token = random.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { token, operator, jog_button: HeldButton::default() })
    }

    pub(super) fn token(&self) -> &str {
        &self.token
    }

    /// Compares in constant time, so that the time of a refusal does not reveal the token.
    pub(super) fn admits(&self, presented: &[u8]) -> bool {
        let token = self.token.as_bytes();
        let differences = token.iter().zip(presented).fold(0, |sum, (a, b)| sum | (a ^ b));
        presented.len() == token.len() && differences == 0
    }

    /// Performs an operation and waits for its answer. A jog without a distance lasts while the button is held.
    pub(super) fn perform(&self, operation: &Operation) -> Answer {
        if !matches!(operation, Operation::Jog { distance: None, .. }) {
            return self.operator.perform(operation, &|| true);
        }
        if !self.jog_button.press(Instant::now()) {
            return Answer::refused("another jog is in execution; release its button first");
        }
        let answer = self.operator.perform(operation, &|| self.jog_button.is_held(Instant::now()));
        self.release();
        answer
    }

    /// Sign of life of a held button.
    pub(super) fn hold(&self) {
        self.jog_button.renew(Instant::now());
    }

    pub(super) fn release(&self) {
        self.jog_button.release();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_button_without_a_sign_of_life_counts_as_released() {
        let (button, start) = (HeldButton::default(), Instant::now());
        let at = |ms: u64| start + Duration::from_millis(ms);
        assert!(button.press(start) && button.is_held(at(499)) && !button.is_held(at(500)));
        assert!(!button.press(at(100)), "two viewers");
        button.renew(at(400));
        assert!(button.is_held(at(899)) && !button.is_held(at(900)));
        button.renew(at(1000));
        assert!(!button.is_held(at(1001)), "too late");
        assert!(button.press(at(1100)));
        button.release();
        button.renew(at(1101));
        assert!(!button.is_held(at(1102)), "released");
    }
}
