// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Drawings on paper: lines, areas and lettering in millimetres, written as SVG or rendered to PNG.
//!
//! Lettering is drawn as strokes, the way a plotter does: a drawing looks the same everywhere and needs no font. The same
//! drawing gives the same bytes.

mod canvas;
mod lettering;
mod pen;
mod png_file;
mod svg_file;

/// A point on the paper (mm), from the upper left corner.
pub(crate) use crate::chart::Point;
pub(crate) use canvas::{Drawing, Plot};
pub(crate) use lettering::{Anchor, Lettering};
pub(crate) use pen::{Colour, Dash, Pen};
pub(crate) use png_file::png;
pub(crate) use svg_file::svg;

#[cfg(test)]
mod tests {
    use super::*;

    /// The same drawing in both files, twice: the same bytes; the SVG is well-formed as far as its tags go.
    #[test]
    fn a_drawing_gives_the_same_bytes_again() {
        let draw = || {
            let mut drawing = Drawing::new(40.0, 20.0, "a < b & c");
            drawing.area(&[[1.0, 1.0], [10.0, 1.0], [10.0, 10.0]], Colour::PALE);
            drawing.line(&[[0.0, 0.0], [40.0, 20.0]], Pen::dashed(Colour::BLACK, 0.3));
            let lettering = Lettering { height_mm: 3.0, anchor: Anchor::Middle, ..Lettering::default() };
            drawing.text([20.0, 10.0], lettering, "Q' < 10 mm²/s");
            drawing
        };
        let (one, other) = (draw(), draw());
        assert_eq!(svg(&one), svg(&other));
        let text = svg(&one);
        assert!(text.contains("<title>a &lt; b &amp; c</title>") && text.ends_with("</svg>\n"), "{text}");
        assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
        let picture = png(&one).unwrap();
        assert_eq!(picture, png(&other).unwrap());
        assert_eq!(&picture[..8], b"\x89PNG\r\n\x1a\n");
        // 40 by 20 mm at 8 points a millimetre.
        assert_eq!(picture[16..24], [0, 0, 1, 64, 0, 0, 0, 160]);
    }
}
