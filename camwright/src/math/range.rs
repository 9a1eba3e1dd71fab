// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Least and largest of values.

/// Least and largest; of none, infinity and its negative. What is no number is passed over.
#[must_use]
pub fn minimum_and_maximum(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    values.into_iter().fold(none, |(min, max), value| (min.min(value), max.max(value)))
}

/// Least and largest of the products of two numbers, each within a range.
#[must_use]
pub fn product((a, b): (f64, f64), (c, d): (f64, f64)) -> (f64, f64) {
    let (ac, ad, bc, bd) = (a * c, a * d, b * c, b * d);
    (ac.min(ad).min(bc.min(bd)), ac.max(ad).max(bc.max(bd)))
}

/// The same where the second number is not negative.
#[must_use]
pub fn scaled((a, b): (f64, f64), (c, d): (f64, f64)) -> (f64, f64) {
    (a * if a < 0.0 { d } else { c }, b * if b < 0.0 { c } else { d })
}

/// Largest magnitude of the sum of numbers, each within a range.
#[must_use]
pub fn maximum_of_sum(ranges: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let (min, max) = ranges.into_iter().fold((0.0, 0.0), |(min, max), (a, b)| (min + a, max + b));
    f64::max(-min, max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_values_have_no_range_and_nan_is_skipped() {
        assert_eq!(minimum_and_maximum([]), (f64::INFINITY, f64::NEG_INFINITY));
        assert_eq!(minimum_and_maximum([2.0, f64::NAN, -1.0, 0.5]), (-1.0, 2.0));
    }

    #[test]
    fn products_and_sums_of_ranges_are_those_of_their_ends() {
        assert_eq!(product((-1.0, 2.0), (-3.0, 5.0)), (-6.0, 10.0));
        assert_eq!(product((-4.0, -2.0), (-3.0, -1.0)), (2.0, 12.0));
        for range in [(-1.0, 2.0), (-4.0, -2.0), (3.0, 4.0)] {
            assert_eq!(scaled(range, (0.5, 3.0)), product(range, (0.5, 3.0)));
        }
        assert_eq!(maximum_of_sum([(-1.0, 2.0), (-5.0, 3.0)]).to_bits(), 6.0_f64.to_bits());
        assert_eq!(maximum_of_sum([(1.0, 2.0), (-0.5, 3.0)]).to_bits(), 5.0_f64.to_bits());
    }
}
