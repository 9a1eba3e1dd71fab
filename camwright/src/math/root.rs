// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Root of an increasing function.

/// The angle between `low` and `high` at which a growing function passes zero, to rounding; `function` gives value and rate, and its
/// root lies between the two. Newton's method inside a shrinking bracket, from a guess.
pub(crate) fn growing_root(low: f64, high: f64, guess: f64, function: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut low, mut high) = (low, high);
    let mut angle = guess.clamp(low, high);
    let mut previous = f64::INFINITY;
    for _ in 0..100 {
        let (miss, rate) = function(angle);
        // What rounding leaves of an angle; beyond it Newton's step and the bracket would only play with noise.
        if miss.abs() <= f64::EPSILON * (1.0 + angle.abs()) {
            break;
        }
        if miss > 0.0 {
            high = angle;
        } else {
            low = angle;
        }
        let newton = angle - miss / rate;
        if (newton - angle).abs() <= f64::EPSILON * (1.0 + angle.abs()) {
            break;
        }
        // Strictly inside, and only while it gains: where the function is nearly flat in places Newton's steps would run from one end
        // of the bracket to the other.
        let gains = miss.abs() <= 0.5 * previous;
        previous = miss.abs();
        angle = if gains && newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    angle
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kepler's equation, as flat as it gets: E − e sin E = M.
    #[test]
    fn a_nearly_flat_function_is_solved() {
        for i in 0..100 {
            let mean = f64::from(i) * 0.06;
            let root = growing_root(mean - 1.0, mean + 1.0, mean, |angle| {
                (angle - 0.999_999 * libm::sin(angle) - mean, 1.0 - 0.999_999 * libm::cos(angle))
            });
            assert!((root - 0.999_999 * libm::sin(root) - mean).abs() < 1e-14, "{mean}: {root}");
        }
    }
}
