// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A drawing as PNG.

use super::canvas::{Drawing, DrawingItem};
use super::pen::{Colour, Pen};
use crate::chart::Point;
use std::io;
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

/// Points per millimetre: 203 dpi, of which the thinnest pen covers one.
const PER_MM: f64 = 8.0;

/// The drawing as a file.
///
/// # Errors
/// A drawing without size.
pub(crate) fn png(drawing: &Drawing) -> io::Result<Vec<u8>> {
    #[allow(clippy::cast_possible_truncation, reason = "some thousand points")]
    let [width, height] = [drawing.width_mm, drawing.height_mm].map(|mm| (mm * PER_MM).round() as u32);
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| io::Error::other("a drawing without size"))?;
    pixmap.fill(tiny_skia::Color::WHITE);
    for mark in &drawing.marks {
        match mark {
            DrawingItem::Line { points, pen } => draw(&mut pixmap, &[points], *pen),
            DrawingItem::Text { strokes, pen, .. } => {
                let strokes: Vec<&[Point]> = strokes.iter().map(Vec::as_slice).collect();
                draw(&mut pixmap, &strokes, *pen);
            }
            DrawingItem::Area { points, colour } => {
                if let Some(path) = path(&[points]) {
                    pixmap.fill_path(&path, &paint(*colour), FillRule::EvenOdd, Transform::identity(), None);
                }
            }
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    // Everything lies on white paper: no pixel is transparent, so its premultiplied colour is its colour.
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    #[allow(clippy::cast_possible_truncation, reason = "a few thousand points per metre")]
    let per_metre = (1000.0 * PER_MM) as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(pixmap.data()).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)?;
    Ok(file)
}

fn paint(Colour(red, green, blue): Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint.anti_alias = true;
    paint
}

#[allow(clippy::cast_possible_truncation, reason = "pixels: single precision is a thousandth of one")]
fn pixels(mm: f64) -> f32 {
    (mm * PER_MM) as f32
}

fn path(lines: &[&[Point]]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for points in lines {
        for (index, [x, y]) in points.iter().enumerate() {
            match index {
                0 => builder.move_to(pixels(*x), pixels(*y)),
                _ => builder.line_to(pixels(*x), pixels(*y)),
            }
        }
    }
    builder.finish()
}

fn draw(pixmap: &mut Pixmap, lines: &[&[Point]], pen: Pen) {
    let dashes: Vec<f32> = pen.dash.lengths_mm().iter().map(|length| pixels(*length)).collect();
    let stroke = Stroke {
        width: pixels(pen.width_mm),
        line_cap: if dashes.is_empty() { LineCap::Round } else { LineCap::Butt },
        line_join: LineJoin::Round,
        dash: StrokeDash::new(dashes, 0.0),
        ..Stroke::default()
    };
    if let Some(path) = path(lines) {
        pixmap.stroke_path(&path, &paint(pen.colour), &stroke, Transform::identity(), None);
    }
}
