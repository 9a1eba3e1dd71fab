// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Least values and means over a window that slides along a row of values, in time that does not grow with the window.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

/// The least of every value and its neighbours up to `radius` away.
#[must_use]
pub fn minimum_around(values: &[f64], radius: usize) -> Vec<f64> {
    // Places whose values rise: the first is the least of the window, and who comes after a smaller one is never asked for.
    let mut rising: VecDeque<usize> = VecDeque::new();
    let mut min = Vec::with_capacity(values.len());
    let mut next = 0;
    for place in 0..values.len() {
        while next < values.len() && next <= place + radius {
            while rising.back().is_some_and(|last| values[*last] >= values[next]) {
                rising.pop_back();
            }
            rising.push_back(next);
            next += 1;
        }
        while rising.front().is_some_and(|first| first + radius < place) {
            rising.pop_front();
        }
        min.push(rising.front().map_or(values[place], |first| values[*first]));
    }
    min
}

/// The mean of every value and its neighbours up to `radius` away; beyond its ends the row goes on as it ends.
///
/// Sums are taken of differences from the first value, so that a row of equal values stays what it is to the last bit.
#[must_use]
pub fn mean_around(values: &[f64], radius: usize) -> Vec<f64> {
    let (Some(first), Some(last)) = (values.first().copied(), values.len().checked_sub(1)) else { return Vec::new() };
    let off = |place: usize| values[place.min(last)] - first;
    let count = (2 * radius + 1) as f64;
    // Before the first value there is no difference from it.
    let mut sum: f64 = (0..=radius).map(off).sum();
    let mut means = Vec::with_capacity(values.len());
    for place in 0..values.len() {
        means.push(first + sum / count);
        sum += off(place + radius + 1) - if place >= radius { off(place - radius) } else { 0.0 };
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::noise::Noise;

    fn row() -> Vec<f64> {
        let mut noise = Noise::new(11);
        (0..200).map(|_| noise.normal()).collect()
    }

    #[test]
    fn windows_are_those_of_the_definition() {
        let values = row();
        for radius in [0_usize, 1, 7, 300] {
            let (min, means) = (minimum_around(&values, radius), mean_around(&values, radius));
            for place in 0..values.len() {
                let (low, high) = (place.saturating_sub(radius), (place + radius).min(values.len() - 1));
                let wanted = values[low..=high].iter().copied().fold(f64::INFINITY, f64::min);
                assert_eq!(min[place].to_bits(), wanted.to_bits(), "seed 11, {radius} {place}");
                let at = |offset: usize| values[(place + offset).saturating_sub(radius).min(values.len() - 1)];
                let wanted: f64 = (0..=2 * radius).map(at).sum::<f64>() / (2 * radius + 1) as f64;
                assert!((means[place] - wanted).abs() < 1e-12, "seed 11, {radius} {place}");
            }
        }
    }

    #[test]
    fn no_values_give_no_windows() {
        assert!(minimum_around(&[], 3).is_empty() && mean_around(&[], 3).is_empty());
    }
}
