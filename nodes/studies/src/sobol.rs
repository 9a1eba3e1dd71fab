// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sobol sequence with the direction numbers of S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional
//! projections", SIAM J. Sci. Comput. 30 (2008), file `new-joe-kuo-6.21201`, in the order of Gray's code.

/// Bits of a coordinate.
const BITS: usize = 32;

/// Primitive polynomials (inner coefficients) and first direction numbers of the dimensions after the first.
const DIRECTIONS: [(u32, &[u32]); 19] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
    (19, &[1, 1, 1, 15, 7, 5]),
    (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]),
    (1, &[1, 3, 7, 11, 23, 15, 103]),
];

/// Dimensions that the sequence has.
#[cfg(test)]
pub(crate) const DIMENSIONS: usize = DIRECTIONS.len() + 1;

/// Direction numbers of a dimension.
fn directions(dimension: usize) -> [u32; BITS] {
    let mut v = [0_u32; BITS];
    let Some((a, first)) = dimension.checked_sub(1).and_then(|index| DIRECTIONS.get(index)) else {
        v.iter_mut().enumerate().for_each(|(bit, v)| *v = 1 << (BITS - 1 - bit));
        return v;
    };
    let degree = first.len();
    for (bit, m) in first.iter().enumerate() {
        v[bit] = m << (BITS - 1 - bit);
    }
    for bit in degree..BITS {
        v[bit] = v[bit - degree] ^ (v[bit - degree] >> degree);
        for k in 1..degree {
            if a >> (degree - 1 - k) & 1 == 1 {
                v[bit] ^= v[bit - k];
            }
        }
    }
    v
}

/// One coordinate of the first points, in 0..1. The first point is 0.
pub(crate) fn coordinate(dimension: usize, points: u32) -> Vec<f64> {
    let v = directions(dimension);
    let value = |index: u32| {
        let gray = index ^ index >> 1;
        let bits = (0..BITS).filter(|bit| gray >> bit & 1 == 1).fold(0_u32, |bits, bit| bits ^ v[bit]);
        f64::from(bits) / (1_u64 << BITS) as f64
    };
    (0..points).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_files::study_file::MAX_FACTORS;

    fn point(index: u32) -> Vec<f64> {
        (0..DIMENSIONS).map(|dimension| coordinate(dimension, index + 1)[index as usize]).collect()
    }

    #[test]
    fn there_is_a_dimension_for_each_factor() {
        assert_eq!(DIMENSIONS, MAX_FACTORS as usize);
    }

    /// Points of the published sequence; `SciPy` 1.x (`scipy.stats.qmc.Sobol`, not scrambled) has the same.
    #[test]
    fn points_are_those_of_the_published_sequence() {
        assert_eq!(point(0), [0.0; DIMENSIONS]);
        assert_eq!(point(1), [0.5; DIMENSIONS]);
        assert_eq!(point(2)[..8], [0.75, 0.25, 0.25, 0.25, 0.75, 0.75, 0.25, 0.75]);
        assert_eq!(point(7)[..8], [0.125, 0.625, 0.375, 0.125, 0.125, 0.375, 0.625, 0.625]);
        let bits: Vec<u32> = vec![
            2973761536, 4022337536, 700448768, 1178599424, 2730491904, 1530920960, 817889280, 3275751424, 1497366528,
            1388314624, 3200253952, 2990538752, 1648361472, 2034237440, 2445279232, 2210398208, 1732247552, 3711959040,
            1589641216, 3233808384,
        ];
        let expected: Vec<f64> = bits.into_iter().map(|bits| f64::from(bits) / 4_294_967_296.0).collect();
        assert_eq!(point(777), expected);
    }

    /// The first 2^k points have one in each of 2^k strata of every coordinate.
    #[test]
    fn a_power_of_two_of_points_fills_every_stratum() {
        for dimension in 0..DIMENSIONS {
            let mut points = coordinate(dimension, 256);
            points.sort_by(f64::total_cmp);
            let strata = points.iter().enumerate().all(|(stratum, x)| (x * 256.0 - stratum as f64).abs() < 1.0);
            assert!(strata, "{dimension}");
        }
    }
}
