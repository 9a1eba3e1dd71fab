// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A drawing as SVG.

use super::canvas::{Drawing, DrawingItem};
use super::pen::{Colour, Pen};
use crate::chart::Point;
use crate::markup::escape;
use std::fmt::Write as _;

/// The drawing as a document, in millimetres.
pub(crate) fn svg(drawing: &Drawing) -> String {
    let (width, height) = (drawing.width_mm, drawing.height_mm);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
         viewBox=\"0 0 {width} {height}\" fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n\
         <title>{}</title>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
        escape(&drawing.title)
    );
    for mark in &drawing.marks {
        let _infallible = match mark {
            DrawingItem::Line { points, pen } => writeln!(text, "<path {} d=\"{}\"/>", stroke(*pen), path(points)),
            DrawingItem::Area { points, colour } => {
                writeln!(text, "<path fill=\"{}\" d=\"{}Z\"/>", hex(*colour), path(points))
            }
            DrawingItem::Text { text: label, strokes, pen, .. } => {
                let letters: String = strokes.iter().map(|points| path(points)).collect();
                writeln!(
                    text,
                    "<g role=\"img\" aria-label=\"{}\"><path {} d=\"{letters}\"/></g>",
                    escape(label),
                    stroke(*pen)
                )
            }
        };
    }
    text + "</svg>\n"
}

fn hex(Colour(red, green, blue): Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn stroke(pen: Pen) -> String {
    let mut text = format!("stroke=\"{}\" stroke-width=\"{}\"", hex(pen.colour), number(pen.width_mm));
    let dashes: Vec<String> = pen.dash.lengths_mm().iter().map(|length| number(*length)).collect();
    if !dashes.is_empty() {
        let _infallible = write!(text, " stroke-dasharray=\"{}\" stroke-linecap=\"butt\"", dashes.join(" "));
    }
    text
}

fn path(points: &[Point]) -> String {
    let mut text = String::new();
    for (index, [x, y]) in points.iter().enumerate() {
        let _infallible = write!(text, "{}{} {}", if index == 0 { 'M' } else { 'L' }, number(*x), number(*y));
    }
    text
}

/// To a micrometre of paper, without what is not needed.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}
