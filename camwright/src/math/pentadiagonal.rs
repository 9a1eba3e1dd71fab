// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Symmetric positive definite matrices with two neighbours on either side, closed on themselves, for one right side: factored and
//! solved in a pass forwards and one back, without roots.

use alloc::vec;
use alloc::vec::Vec;

/// The last two unknowns are a border, as in [`super::banded`].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CyclicPentadiagonal {
    rows: Vec<[f64; 3]>,
    /// Per row: both entries of the unit factor left of the diagonal, and the entries of the border over the pivot.
    factor: Vec<FactorRow>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct FactorRow {
    far: f64,
    near: f64,
    border: [f64; 2],
}

/// Data of an eliminated row that later rows use.
#[derive(Debug, Clone, Copy, Default)]
struct Eliminated {
    near: f64,
    inverse: f64,
    border: [f64; 2],
    right: f64,
}

impl CyclicPentadiagonal {
    /// Fewest unknowns.
    const MIN: usize = 5;

    /// A matrix of zeros.
    pub(crate) fn new(unknowns: usize) -> Self {
        let none = FactorRow { far: 0.0, near: 0.0, border: [0.0; 2] };
        Self { rows: vec![[0.0; 3]; unknowns], factor: vec![none; unknowns.saturating_sub(2)] }
    }

    /// Entries (i, i), (i, i + 1) and (i, i + 2) of every row i, round the end.
    pub(crate) fn rows_mut(&mut self) -> &mut [[f64; 3]] {
        &mut self.rows
    }

    /// Replaces the right side, one number per row, by the solution. `None` if the matrix is not positive definite, or has less
    /// than five rows.
    pub(crate) fn solve(&mut self, right: &mut [f64]) -> Option<()> {
        let n = self.rows.len();
        if n < Self::MIN || right.len() != n {
            return None;
        }
        let m = n - 2;
        let (inner, outer) = right.split_at_mut(m);
        let (rows, corner) = self.rows.split_at(m);
        let (first, last) = (corner[0], corner[1]);
        for row in &mut self.factor {
            row.border = [0.0; 2];
        }
        self.factor[0].border = [first[2], last[1]];
        self.factor[1].border[1] = last[2];
        self.factor[m - 2].border[0] += rows[m - 2][2];
        self.factor[m - 1].border[0] += rows[m - 1][1];
        self.factor[m - 1].border[1] += rows[m - 1][2];

        let (mut two_before, mut before) = (Eliminated::default(), Eliminated::default());
        let (mut far_entry, mut near_entry, mut next_far) = (0.0, 0.0, 0.0);
        let mut sums = [0.0; 5];
        for ((row, factor), right) in rows.iter().zip(&mut self.factor).zip(inner.iter_mut()) {
            let far = far_entry * two_before.inverse;
            let near_pivot = near_entry - far_entry * before.near;
            let near = near_pivot * before.inverse;
            let pivot = row[0] - near * near_pivot - far * far_entry;
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            let inverse = 1.0 / pivot;
            let eliminate = |value: f64, before: f64, two_before: f64| value - near * before - far * two_before;
            let p = eliminate(factor.border[0], before.border[0], two_before.border[0]);
            let q = eliminate(factor.border[1], before.border[1], two_before.border[1]);
            let r = eliminate(*right, before.right, two_before.right);
            let border = [p * inverse, q * inverse];
            for (sum, term) in
                sums.iter_mut().zip([p * border[0], p * border[1], q * border[1], r * border[0], r * border[1]])
            {
                *sum += term;
            }
            *right = r * inverse;
            *factor = FactorRow { far, near, border };
            two_before = before;
            before = Eliminated { near, inverse, border: [p, q], right: r };
            (far_entry, near_entry, next_far) = (next_far, row[1], row[2]);
        }
        let (a, b, c) = (first[0] - sums[0], first[1] - sums[1], last[0] - sums[2]);
        let (u, v) = (outer[0] - sums[3], outer[1] - sums[4]);
        let determinant = a * c - b * b;
        if a.is_nan() || a <= 0.0 || determinant.is_nan() || determinant <= 0.0 {
            return None;
        }
        let (p, q) = ((c * u - b * v) / determinant, (a * v - b * u) / determinant);
        (outer[0], outer[1]) = (p, q);
        // Sums that the two rows below add to the next one up.
        let (mut near_sum, mut far_sum, mut next_far_sum) = (0.0, 0.0, 0.0);
        for (right, factor) in inner.iter_mut().zip(&self.factor).rev() {
            let x = *right - (factor.border[0] * p + factor.border[1] * q) - near_sum - far_sum;
            *right = x;
            (near_sum, far_sum, next_far_sum) = (factor.near * x, next_far_sum, factor.far * x);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A x = b with a known x, for the smallest matrices and rows that differ.
    #[test]
    fn known_solution_comes_back() {
        for n in [5, 6, 7, 40, 101] {
            let mut matrix = CyclicPentadiagonal::new(n);
            for (i, row) in matrix.rows_mut().iter_mut().enumerate() {
                let at = i as f64;
                *row = [30.0 + libm::sin(at), -6.0 + libm::cos(2.0 * at), 3.0 + 0.3 * libm::sin(3.0 * at)];
            }
            let x: Vec<f64> = (0..n).map(|i| libm::cos(3.0 * i as f64) + 0.1 * i as f64).collect();
            let mut b = vec![0.0; n];
            for (i, row) in matrix.rows.iter().enumerate() {
                b[i] += row[0] * x[i];
                for (j, entry) in row.iter().enumerate().skip(1) {
                    let k = (i + j) % n;
                    b[i] += entry * x[k];
                    b[k] += entry * x[i];
                }
            }
            matrix.solve(&mut b).expect("the diagonal outweighs the rest");
            for (found, wanted) in b.iter().zip(&x) {
                assert!((found - wanted).abs() < 1e-12, "n = {n}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn indefinite_matrix_is_refused() {
        let solve = |n: usize, row: [f64; 3]| {
            let mut matrix = CyclicPentadiagonal::new(n);
            matrix.rows_mut().fill(row);
            matrix.solve(&mut vec![1.0; n])
        };
        assert_eq!(solve(8, [1.0, 2.0, 0.0]), None);
        assert_eq!(solve(8, [f64::NAN, 0.0, 0.0]), None);
        assert_eq!(solve(4, [9.0, 1.0, 1.0]), None);
        assert_eq!(solve(5, [9.0, 1.0, 1.0]), Some(()));
    }
}
