// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Derivatives by differencing values: the other arithmetic with which motion is checked after it was planned.

use super::twofold::Twofold;

/// A largest magnitude and where it was met.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extreme {
    pub value: f64,
    /// Abscissa at which it was met.
    pub at: f64,
}

impl Extreme {
    /// Keeps the larger of this and another magnitude. Not a number counts as infinitely large, so that it cannot hide.
    pub fn add(&mut self, value: f64, at: f64) {
        let magnitude = if value.is_nan() { f64::INFINITY } else { value.abs() };
        if magnitude > self.value {
            *self = Self { value: magnitude, at };
        }
    }
}

/// Largest magnitudes of the first three derivatives of `f` between two abscissae, by differences over a fixed step.
///
/// Differences are means of the derivative over one to three steps, so they never exceed its largest value but for the
/// rounding of `f`: 8 ε |f| / step³ in the third.
pub fn largest_derivatives(f: impl Fn(f64) -> f64, from: f64, to: f64, step: f64) -> [Extreme; 3] {
    let mut found = [Extreme::default(); 3];
    #[allow(clippy::cast_possible_truncation, reason = "counts of steps are small and positive")]
    let count = libm::ceil((to - from) / step).max(0.0) as u64;
    let (mut a, mut b, mut c) = (f(from), f(from + step), f(from + 2.0 * step));
    found[0].add((b - a) / step, from);
    found[0].add((c - b) / step, from);
    found[1].add((c - 2.0 * b + a) / (step * step), from + step);
    for k in 3..=count.max(3) {
        let at = from + k as f64 * step;
        let d = f(at);
        found[0].add((d - c) / step, at - 0.5 * step);
        found[1].add((d - 2.0 * c + b) / (step * step), at - step);
        found[2].add((d - 3.0 * c + 3.0 * b - a) / (step * step * step), at - 1.5 * step);
        (a, b, c) = (b, c, d);
    }
    found
}

/// Same as [`largest_derivatives`], of several functions at once, for values and abscissae with twice the digits of a float: their rounding
/// does not grow with either.
pub fn largest_exact_derivatives<const N: usize>(
    mut f: impl FnMut(Twofold) -> [Twofold; N],
    from: Twofold,
    to: Twofold,
    step: f64,
) -> [[Extreme; 3]; N] {
    let mut found = [[Extreme::default(); 3]; N];
    #[allow(clippy::cast_possible_truncation, reason = "counts of steps are small and positive")]
    let count = libm::ceil(to.minus(from) / step).max(0.0) as u64;
    // Steps of the same length to the last digit.
    let place = |k: u64| from.plus(Twofold::product(k as f64, step));
    let mut before = f(from);
    let mut last = [(0.0, 0.0); N];
    for k in 1..=count.max(3) {
        let at = place(k);
        let here = f(at);
        for (i, found) in found.iter_mut().enumerate() {
            let (last1, last2) = last[i];
            let d1 = here[i].minus(before[i]);
            let d2 = d1 - last1;
            found[0].add(d1 / step, at.value() - 0.5 * step);
            if k >= 2 {
                found[1].add(d2 / (step * step), at.value() - step);
            }
            if k >= 3 {
                found[2].add((d2 - last2) / (step * step * step), at.value() - 1.5 * step);
            }
            last[i] = (d1, d2);
        }
        before = here;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sin(3t) has derivatives of magnitude 3, 9 and 27.
    #[test]
    fn a_sine_has_the_derivatives_of_a_sine() {
        let found = largest_derivatives(|t| libm::sin(3.0 * t), 0.0, 4.0, 1e-4);
        for (extreme, wanted) in found.iter().zip([3.0, 9.0, 27.0]) {
            assert!((extreme.value - wanted).abs() < 1e-3 * wanted, "{extreme:?} {wanted}");
        }
    }

    /// A parabola behind 2,000 turns, at the steps of the finest check. As floats its second derivative would be off by some 5, its
    /// third by more than 1e4.
    #[test]
    fn rounding_does_not_grow_with_the_value() {
        let parabola = |t: Twofold| [Twofold::from(12_566.370_614).plus(t.times(t)).plus(t.times(Twofold::from(20.0)))];
        let from = Twofold::from(900.0);
        let [found] = largest_exact_derivatives(parabola, from, from.plus_float(0.01), 5e-6);
        assert!(found[2].value < 0.1, "{found:?}");
        assert!((found[1].value - 2.0).abs() < 1e-6, "{found:?}");
        let rounded = largest_derivatives(|t| 12_566.370_614 + t * (20.0 + t), 900.0, 900.01, 5e-6);
        assert!(rounded[2].value > 1e4, "{rounded:?}");
    }

    #[test]
    fn what_is_not_a_number_does_not_hide() {
        let found = largest_derivatives(|t| if t > 0.5 { f64::NAN } else { t }, 0.0, 1.0, 0.01);
        assert!(found.iter().all(|extreme| extreme.value.is_infinite()));
    }
}
