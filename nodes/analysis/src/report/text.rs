// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Numbers and recorded strings as the page shows them.

pub(super) use camwright_files::convert::um_from_m as um;

/// A number with so many digits behind the point; what is none is a dash.
pub(super) fn fixed(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// The same with its sign.
pub(super) fn signed(value: f64, digits: usize) -> String {
    let text = fixed(value, digits);
    if value > 0.0 && text.contains(|c: char| ('1'..='9').contains(&c)) { format!("+{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_fixed_digits_and_no_negative_zero() {
        assert_eq!(
            (fixed(-0.0004, 3), fixed(-1.25, 1), fixed(f64::NAN, 2)),
            ("0.000".into(), "−1.2".into(), "–".into())
        );
        assert_eq!(
            (signed(0.0004, 3), signed(2.0, 1), signed(-2.0, 1)),
            ("0.000".into(), "+2.0".into(), "−2.0".into())
        );
    }
}
