//! Least and largest of values.

/// Least and largest; of none, infinity and its negative. What is no number is passed over.
#[must_use]
pub fn least_and_most(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    values.into_iter().fold(none, |(least, most), value| (least.min(value), most.max(value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_no_values_there_is_no_range_and_what_is_no_number_is_passed_over() {
        assert_eq!(least_and_most([]), (f64::INFINITY, f64::NEG_INFINITY));
        assert_eq!(least_and_most([2.0, f64::NAN, -1.0, 0.5]), (-1.0, 2.0));
    }
}
