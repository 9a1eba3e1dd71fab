//! Control of the cell from the page, for viewers with its token.

use super::operation::{Answer, Operation};
use super::operator::Operator;
use std::fs::File;
use std::io::{self, Read as _};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A jog ends after this time without a sign of life from the button.
const DEAD_MAN: Duration = Duration::from_millis(500);

/// Performs operations of viewers that present the token.
#[derive(Debug)]
pub(super) struct Control {
    token: String,
    operator: Operator,
    /// Last sign of life of a held jog button; `None`: released.
    held: Mutex<Option<Instant>>,
}

impl Control {
    /// Control with a random token of 128 bits.
    pub(super) fn new(operator: Operator) -> io::Result<Self> {
        let mut random = [0; 16];
        File::open("/dev/urandom")?.read_exact(&mut random)?;
        let token = random.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { token, operator, held: Mutex::new(None) })
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
        {
            let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
            if is_alive(*held) {
                return Answer::refused("another jog is in execution; release its button first");
            }
            *held = Some(Instant::now());
        }
        let answer =
            self.operator.perform(operation, &|| is_alive(*self.held.lock().unwrap_or_else(PoisonError::into_inner)));
        self.release();
        answer
    }

    /// Sign of life of a held button. A released button stays released.
    pub(super) fn hold(&self) {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if is_alive(*held) {
            *held = Some(Instant::now());
        }
    }

    pub(super) fn release(&self) {
        *self.held.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

fn is_alive(held: Option<Instant>) -> bool {
    held.is_some_and(|last| last.elapsed() < DEAD_MAN)
}
