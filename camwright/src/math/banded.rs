// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Symmetric positive definite band matrices that close on themselves, as every periodic spline problem has them.
//!
//! ```text
//!   x x x . . . x x        the band runs round the corner: the last P unknowns are taken out as a border,
//!   x x x x . . . x        the rest is an ordinary band, factored row by row; what the border sees of it
//!   x x x x x . . .        (the Schur complement) is a small dense matrix
//! ```

use alloc::vec;
use alloc::vec::Vec;
use thiserror::Error;

/// Why a cyclic band matrix could not be factored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum BandError {
    /// Too few unknowns: the band would overlap itself.
    #[error("{unknowns} unknowns, but a cyclic band of this width needs at least {min}")]
    TooFewUnknowns { unknowns: usize, min: usize },
    /// Not positive definite, in the arithmetic at hand.
    #[error("the matrix is not positive definite at row {row}")]
    NotPositive {
        /// Row of the pivot.
        row: usize,
    },
}

/// A symmetric cyclic band matrix: `rows[i][j]` is the entry (i, i + j mod n), j = 0 … W − 1; W − 1 is the half bandwidth.
#[derive(Debug, Clone, PartialEq)]
pub struct CyclicBand<const W: usize> {
    rows: Vec<[f64; W]>,
}

impl<const W: usize> CyclicBand<W> {
    /// A matrix with the same entries in every row.
    #[must_use]
    pub fn circulant(unknowns: usize, row: [f64; W]) -> Self {
        Self { rows: vec![row; unknowns] }
    }

    /// The upper half of the band, row by row.
    pub fn rows_mut(&mut self) -> &mut [[f64; W]] {
        &mut self.rows
    }

    /// Cholesky factor.
    ///
    /// # Errors
    /// Fewer than 2W − 1 unknowns, or a matrix that is not positive definite.
    pub fn factor(&self) -> Result<CyclicCholesky<W>, BandError> {
        let (n, p) = (self.rows.len(), W - 1);
        if n < 2 * p + 1 {
            return Err(BandError::TooFewUnknowns { unknowns: n, min: 2 * p + 1 });
        }
        let m = n - p;
        // lower[i][j] is L(i, i − j).
        let mut lower = vec![[0.0; W]; m];
        for i in 0..m {
            let mut row = [0.0; W];
            for j in (1..=p.min(i)).rev() {
                let k = i - j;
                let mut sum = self.rows[k][j];
                for t in 1..=p.min(k) {
                    if j + t > p {
                        break;
                    }
                    sum -= row[j + t] * lower[k][t];
                }
                row[j] = sum / lower[k][0];
            }
            let pivot = self.rows[i][0] - row[1..].iter().map(|x| x * x).sum::<f64>();
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(BandError::NotPositive { row: i });
            }
            row[0] = libm::sqrt(pivot);
            lower[i] = row;
        }
        // border[i][r] is L(m + r, i); dense, because the corner fills it.
        let mut border = vec![[0.0; W]; m];
        for i in 0..m {
            #[allow(clippy::needless_range_loop, reason = "r counts corner rows, of several arrays")]
            for r in 0..p {
                let below = m + r - i;
                let round = i + p - r;
                let mut sum = if below <= p {
                    self.rows[i][below]
                } else if round <= p {
                    self.rows[m + r][round]
                } else {
                    0.0
                };
                for t in 1..=p.min(i) {
                    sum -= border[i - t][r] * lower[i][t];
                }
                border[i][r] = sum / lower[i][0];
            }
        }
        let mut corner = [[0.0; W]; W];
        for r in 0..p {
            for q in 0..=r {
                corner[r][q] = self.rows[m + q][r - q] - border.iter().map(|row| row[r] * row[q]).sum::<f64>();
            }
        }
        for r in 0..p {
            for q in 0..=r {
                let sum = corner[r][q] - (0..q).map(|t| corner[r][t] * corner[q][t]).sum::<f64>();
                if q < r {
                    corner[r][q] = sum / corner[q][q];
                } else if sum.is_nan() || sum <= 0.0 {
                    return Err(BandError::NotPositive { row: m + r });
                } else {
                    corner[r][r] = libm::sqrt(sum);
                }
            }
        }
        Ok(CyclicCholesky { lower, border, corner })
    }
}

/// Cholesky factor of a [`CyclicBand`].
#[derive(Debug, Clone, PartialEq)]
pub struct CyclicCholesky<const W: usize> {
    lower: Vec<[f64; W]>,
    border: Vec<[f64; W]>,
    corner: [[f64; W]; W],
}

impl<const W: usize> CyclicCholesky<W> {
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.lower.len() + W - 1
    }

    /// Replaces the right side by the solution. Entries beyond [`Self::unknowns`] are left alone, missing ones are not
    /// solved for: the caller gives exactly that many.
    pub fn solve(&self, right: &mut [f64]) {
        let (m, p) = (self.lower.len(), W - 1);
        debug_assert_eq!(right.len(), m + p, "one right side per unknown");
        let (inner, outer) = right.split_at_mut(m);
        for i in 0..m {
            let mut sum = inner[i];
            for t in 1..=p.min(i) {
                sum -= self.lower[i][t] * inner[i - t];
            }
            inner[i] = sum / self.lower[i][0];
        }
        for r in 0..p {
            let mut sum = outer[r] - inner.iter().zip(&self.border).map(|(y, row)| y * row[r]).sum::<f64>();
            sum -= self.corner[r][..r].iter().zip(&*outer).map(|(l, x)| l * x).sum::<f64>();
            outer[r] = sum / self.corner[r][r];
        }
        for r in (0..p).rev() {
            let mut sum = outer[r];
            sum -= (r + 1..p).map(|q| self.corner[q][r] * outer[q]).sum::<f64>();
            outer[r] = sum / self.corner[r][r];
        }
        for i in (0..m).rev() {
            let mut sum = inner[i];
            sum -= self.border[i].iter().zip(&*outer).map(|(l, x)| l * x).sum::<f64>();
            for t in 1..=p.min(m - 1 - i) {
                sum -= self.lower[i + t][t] * inner[i + t];
            }
            inner[i] = sum / self.lower[i][0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A x = b with a known x, for the smallest matrix, odd and even sizes, and rows that differ.
    #[test]
    fn known_solution_comes_back() {
        for n in [11, 12, 13, 40, 101] {
            let mut matrix = CyclicBand::<6>::circulant(n, [30.0, -6.0, 3.0, -2.0, 1.0, -0.5]);
            for (i, row) in matrix.rows_mut().iter_mut().enumerate() {
                row[0] += libm::sin(i as f64);
                row[3] += 0.3 * libm::cos(2.0 * i as f64);
            }
            let x: Vec<f64> = (0..n).map(|i| libm::cos(3.0 * i as f64) + 0.1 * i as f64).collect();
            let mut b = vec![0.0; n];
            for i in 0..n {
                for j in 0..6 {
                    let k = (i + j) % n;
                    b[i] += matrix.rows[i][j] * x[k];
                    if j > 0 {
                        b[k] += matrix.rows[i][j] * x[i];
                    }
                }
            }
            matrix.factor().unwrap().solve(&mut b);
            for (found, wanted) in b.iter().zip(&x) {
                assert!((found - wanted).abs() < 1e-12, "n = {n}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn indefinite_matrix_is_refused() {
        let matrix = CyclicBand::<2>::circulant(8, [1.0, 2.0]);
        assert_eq!(matrix.factor(), Err(BandError::NotPositive { row: 1 }));
        let matrix = CyclicBand::<3>::circulant(4, [9.0, 1.0, 1.0]);
        assert_eq!(matrix.factor(), Err(BandError::TooFewUnknowns { unknowns: 4, min: 5 }));
    }
}
