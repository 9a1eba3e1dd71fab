// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Curves of many points, drawn in few: the least and the most of every column of pixels, in their order. Never a mean, which hides peaks.

/// Least and most of what fell into one column, with where they were.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Column {
    low: (f64, f64),
    high: (f64, f64),
}

/// The extremes of a curve by columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Columns {
    from: f64,
    to: f64,
    columns: Vec<Option<Column>>,
}

impl Columns {
    /// Empty columns of equal width over a range.
    pub(super) fn new(from: f64, to: f64, count: usize) -> Self {
        Self { from, to, columns: vec![None; count.max(1)] }
    }

    /// Those of some points.
    pub(super) fn from_points(from: f64, to: f64, count: usize, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut columns = Self::new(from, to, count);
        points.into_iter().for_each(|(x, y)| columns.add(x, y));
        columns
    }

    /// Takes a point; what lies outside the range, or is no number, is omitted.
    pub(super) fn add(&mut self, x: f64, y: f64) {
        let place = (x - self.from) / (self.to - self.from);
        if !(0.0..=1.0).contains(&place) || !y.is_finite() {
            return;
        }
        let count = self.columns.len();
        #[allow(clippy::cast_possible_truncation, reason = "between 0 and the number of columns")]
        let index = ((place * count as f64) as usize).min(count - 1);
        let column = self.columns[index].get_or_insert(Column { low: (x, y), high: (x, y) });
        if y < column.low.1 {
            column.low = (x, y);
        }
        if y > column.high.1 {
            column.high = (x, y);
        }
    }

    /// The points to draw, by place.
    pub(super) fn points(&self) -> Vec<(f64, f64)> {
        let mut points = Vec::with_capacity(2 * self.columns.len());
        for column in self.columns.iter().flatten() {
            let (first, second) =
                if column.low.0 <= column.high.0 { (column.low, column.high) } else { (column.high, column.low) };
            points.push(first);
            if first != second {
                points.push(second);
            }
        }
        points
    }

    /// The value of the column at a place, in the middle of its extremes; none where nothing fell into it.
    pub(super) fn middle_at(&self, x: f64) -> Option<f64> {
        let width = (self.to - self.from) / self.columns.len() as f64;
        let index = ((x - self.from) / width).floor();
        #[allow(clippy::cast_possible_truncation, reason = "saturates; get() refuses the rest")]
        let column = self.columns.get(index.max(0.0) as usize).copied().flatten()?;
        Some(0.5 * (column.low.1 + column.high.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hundred thousand points with one peak and one hole of one point each, in so many columns as a drawing has.
    #[test]
    fn no_extreme_is_lost_and_every_column_keeps_its_order() {
        let value = |i: u32| match i {
            31_415 => 9.0,
            77_777 => -7.0,
            _ => (f64::from(i) * 0.01).sin(),
        };
        let curve: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), value(i))).collect();
        let columns = Columns::from_points(0.0, 1e5, 360, curve.iter().copied());
        let points = columns.points();
        assert!(points.len() <= 720, "{}", points.len());
        assert!(points.contains(&(31_415.0, 9.0)) && points.contains(&(77_777.0, -7.0)));
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0), "from left to right");
        assert!(points.iter().all(|point| curve.contains(point)), "every point is one of the curve's own");
    }

    #[test]
    fn what_is_outside_or_no_number_is_left_out() {
        let columns = Columns::from_points(0.0, 10.0, 5, [(-1.0, 1.0), (11.0, 1.0), (3.0, f64::NAN), (10.0, 2.0)]);
        assert_eq!(columns.points(), [(10.0, 2.0)]);
        assert_eq!(columns.middle_at(9.0), Some(2.0));
        assert_eq!(columns.middle_at(1.0), None);
    }
}
