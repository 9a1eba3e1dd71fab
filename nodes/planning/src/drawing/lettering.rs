// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lettering as strokes, after the upright lettering of technical drawings (ISO 3098).

use super::pen::{Colour, Pen};
use crate::chart::Point;

/// Height of a capital in the units of the glyphs; small letters are 7 high, descenders 3 deep.
const CAPITAL: f64 = 10.0;

/// Gap between two letters.
const GAP: f64 = 2.3;

/// Advance of a blank.
const BLANK: f64 = 5.0;

/// Raised figures: their size and how far they are raised.
const RAISED: (f64, f64) = (0.62, 4.6);

/// Step along an arc (deg): chords a hundredth of a capital off.
const ARC_STEP_DEG: f64 = 12.0;

/// Which place of its base line a text is put by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Style of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lettering {
    /// Height of a capital.
    pub(crate) height_mm: f64,
    pub(crate) anchor: Anchor,
    pub(crate) colour: Colour,
    pub(crate) is_bold: bool,
    /// Read from below to above.
    pub(crate) is_upright: bool,
}

impl Default for Lettering {
    fn default() -> Self {
        Self {
            height_mm: Self::SMALLEST_MM,
            anchor: Anchor::Start,
            colour: Colour::BLACK,
            is_bold: false,
            is_upright: false,
        }
    }
}

impl Lettering {
    /// Minimum height of a capital, that of ISO 3098. From the descender to the top of a letter it is 12 px, of 25.4/96 mm each.
    pub(crate) const SMALLEST_MM: f64 = 2.5;

    /// A text as it is, or its beginning with dots if it is longer than there is space for.
    pub(crate) fn fitted(self, text: &str, width_mm: f64) -> String {
        if self.width_mm(text) <= width_mm {
            return text.into();
        }
        let mut short: String = text.into();
        while !short.is_empty() && self.width_mm(&format!("{short}...")) > width_mm {
            short.pop();
        }
        short.trim_end().to_owned() + "..."
    }

    /// The strokes of a text on the paper, and the pen for them.
    pub(super) fn strokes(self, at: Point, text: &str) -> (Vec<Vec<Point>>, Pen) {
        let scale = self.height_mm / CAPITAL;
        let along = match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * self.width_mm(text),
            Anchor::End => self.width_mm(text),
        };
        let mut strokes = Vec::new();
        let mut x = 0.0;
        for letter in text.chars() {
            let (width, lines) = glyph(letter);
            for line in lines {
                let place = |[px, py]: Point| {
                    let (right, up) = (scale * (x + px) - along, scale * py);
                    if self.is_upright { [at[0] - up, at[1] - right] } else { [at[0] + right, at[1] - up] }
                };
                strokes.push(line.into_iter().map(place).collect());
            }
            x += width;
        }
        let share = if self.is_bold { 0.145 } else { 0.095 };
        (strokes, Pen::solid(self.colour, share * self.height_mm))
    }

    /// Length of a text.
    pub(crate) fn width_mm(self, text: &str) -> f64 {
        let units: f64 = text.chars().map(|letter| glyph(letter).0).sum();
        (units - GAP).max(0.0) * self.height_mm / CAPITAL
    }
}

/// Advance and strokes of a character; a small frame for one that is not known.
fn glyph(letter: char) -> (f64, Vec<Vec<Point>>) {
    let raised = match letter {
        '²' => Some('2'),
        '³' => Some('3'),
        ' ' => return (BLANK, Vec::new()),
        _ => None,
    };
    if let Some(figure) = raised {
        let (advance, mut lines) = glyph(figure);
        let (size, up) = RAISED;
        lines.iter_mut().flatten().for_each(|[x, y]| (*x, *y) = (size * *x, size * *y + up));
        return (size * (advance - GAP) + GAP, lines);
    }
    let marked = |base: char, height: f64| {
        let (advance, mut lines) = glyph(base);
        let middle = 0.5 * (advance - GAP);
        for x in [middle - 1.4, middle + 1.4] {
            lines.push(vec![[x, height], [x, height + 0.2]]);
        }
        (advance, lines)
    };
    match letter {
        'ä' => return marked('a', 9.2),
        'ö' => return marked('o', 9.2),
        'ü' => return marked('u', 9.2),
        'Ä' => return marked('A', 12.2),
        'Ö' => return marked('O', 12.2),
        'Ü' => return marked('U', 12.2),
        _ => {}
    }
    let known = GLYPHS.iter().find(|(known, ..)| *known == letter);
    let (_, width, strokes) = known.unwrap_or(&('\u{fffd}', 4.0, "0,0 0,7 4,7 4,0 0,0"));
    (width + GAP, strokes.split(';').map(line).collect())
}

/// A stroke: points `x,y` and arcs `@cx,cy,rx,ry,from,to` (deg, counter-clockwise if `to` is larger).
fn line(stroke: &str) -> Vec<Point> {
    let mut points = Vec::new();
    for item in stroke.split_whitespace() {
        let is_arc = item.starts_with('@');
        let numbers: Vec<f64> =
            item.trim_start_matches('@').split(',').filter_map(|number| number.parse().ok()).collect();
        match (is_arc, numbers.as_slice()) {
            (true, &[cx, cy, rx, ry, from, to]) => {
                let steps = ((to - from).abs() / ARC_STEP_DEG).ceil().max(1.0);
                let mut step = 0.0;
                while step <= steps {
                    let angle = (from + (to - from) * step / steps).to_radians();
                    points.push([cx + rx * angle.cos(), cy + ry * angle.sin()]);
                    step += 1.0;
                }
            }
            (false, &[x, y]) => points.push([x, y]),
            _ => {}
        }
    }
    points
}

const GLYPHS: &[(char, f64, &str)] = &[
    ('0', 6.0, "@3,5,3,5,0,360"),
    ('1', 6.0, "1.2,8 3.4,10 3.4,0"),
    ('2', 6.0, "@3,7.1,2.9,2.9,165,-35 0,0 6,0"),
    ('3', 6.0, "@2.9,7.5,2.6,2.5,150,-90;@2.8,2.5,3.1,2.5,90,-150"),
    ('4', 6.0, "4.6,0 4.6,10 0,3 6.2,3"),
    ('5', 6.0, "5.4,10 1.1,10 0.7,5.26 @3,3.2,3,3.2,140,-150"),
    ('6', 6.0, "@5.2,3.3,5.2,6.7,95,180;@3,3.1,3,3.1,0,360"),
    ('7', 6.0, "0,10 6,10 2,0"),
    ('8', 6.0, "@3,7.5,2.5,2.5,0,360;@3,2.5,3,2.5,0,360"),
    ('9', 6.0, "@0.8,6.7,5.2,6.7,-85,0;@3,6.9,3,3.1,0,360"),
    ('A', 7.0, "0,0 3.5,10 7,0;1.2,3.4 5.8,3.4"),
    ('B', 6.4, "0,0 0,10 3.4,10 @3.4,7.6,2.5,2.4,90,-90 0,5.2;3.4,5.2 @3.4,2.6,3,2.6,90,-90 0,0"),
    ('C', 6.3, "@3.8,5,3.8,5,50,310"),
    ('D', 6.6, "0,0 0,10 2.6,10 @2.6,5,4,5,90,-90 0,0"),
    ('E', 5.6, "5.6,10 0,10 0,0 5.6,0;0,5.2 4.8,5.2"),
    ('F', 5.4, "5.4,10 0,10 0,0;0,5.2 4.6,5.2"),
    ('G', 7.2, "@3.7,5,3.7,5,50,350 7.35,4.8 4.3,4.8"),
    ('H', 6.5, "0,0 0,10;6.5,0 6.5,10;0,5.2 6.5,5.2"),
    ('I', 0.0, "0,0 0,10"),
    ('J', 4.0, "4,10 4,2.5 @2,2.5,2,2.5,0,-165"),
    ('K', 6.2, "0,0 0,10;6,10 0,3.9;2.2,6.1 6.2,0"),
    ('L', 5.4, "0,10 0,0 5.4,0"),
    ('M', 8.0, "0,0 0,10 4,3 8,10 8,0"),
    ('N', 6.5, "0,0 0,10 6.5,0 6.5,10"),
    ('O', 7.4, "@3.7,5,3.7,5,0,360"),
    ('P', 6.2, "0,0 0,10 3.5,10 @3.5,7.3,2.7,2.7,90,-90 0,4.6"),
    ('Q', 7.4, "@3.7,5,3.7,5,0,360;4.6,2.4 7.3,-0.7"),
    ('R', 6.4, "0,0 0,10 3.5,10 @3.5,7.3,2.7,2.7,90,-90 0,4.6;3.3,4.6 6.4,0"),
    ('S', 6.2, "@3.1,7.5,2.9,2.5,35,270 @3.1,2.5,3.1,2.5,90,-145"),
    ('T', 7.0, "0,10 7,10;3.5,10 3.5,0"),
    ('U', 6.4, "0,10 0,3.2 @3.2,3.2,3.2,3.2,180,360 6.4,10"),
    ('V', 7.0, "0,10 3.5,0 7,10"),
    ('W', 10.0, "0,10 2.5,0 5,9 7.5,0 10,10"),
    ('X', 6.5, "0,10 6.5,0;6.5,10 0,0"),
    ('Y', 6.8, "0,10 3.4,4.8 6.8,10;3.4,4.8 3.4,0"),
    ('Z', 6.3, "0,10 6.3,10 0,0 6.3,0"),
    ('a', 5.5, "@2.75,3.5,2.75,3.5,0,360;5.5,7 5.5,0"),
    ('b', 5.5, "0,10 0,0;@2.75,3.5,2.75,3.5,0,360"),
    ('c', 4.8, "@2.8,3.5,2.8,3.5,50,310"),
    ('d', 5.5, "@2.75,3.5,2.75,3.5,0,360;5.5,10 5.5,0"),
    ('e', 5.5, "0.1,3.7 5.5,3.7 @2.75,3.5,2.75,3.5,3,312"),
    ('f', 3.8, "@3.5,7.8,1.9,2.2,75,180 1.6,0;0,6.8 3.6,6.8"),
    ('g', 5.5, "@2.75,3.5,2.75,3.5,0,360;5.5,7 5.5,-0.6 @2.8,-0.6,2.7,2.4,0,-150"),
    ('h', 5.2, "0,10 0,0;0,4.3 @2.6,4.3,2.6,2.7,180,0 5.2,0"),
    ('i', 0.2, "0.1,7 0.1,0;0.1,9.5 0.1,9.8"),
    ('j', 1.6, "1.6,7 1.6,-1.2 @0,-1.2,1.6,1.8,0,-95;1.6,9.5 1.6,9.8"),
    ('k', 4.9, "0,10 0,0;4.6,7 0,2.6;1.7,4.2 4.9,0"),
    ('l', 0.2, "0.1,10 0.1,0"),
    ('m', 8.2, "0,7 0,0;0,4.7 @2.05,4.7,2.05,2.3,180,0 4.1,0;4.1,4.7 @6.15,4.7,2.05,2.3,180,0 8.2,0"),
    ('n', 5.2, "0,7 0,0;0,4.3 @2.6,4.3,2.6,2.7,180,0 5.2,0"),
    ('o', 5.6, "@2.8,3.5,2.8,3.5,0,360"),
    ('p', 5.5, "0,7 0,-3;@2.75,3.5,2.75,3.5,0,360"),
    ('q', 5.5, "@2.75,3.5,2.75,3.5,0,360;5.5,7 5.5,-3"),
    ('r', 3.4, "0,7 0,0;0,4 @3,4,3,3,180,82"),
    ('s', 4.4, "@2.2,5.25,2.0,1.75,35,270 @2.2,1.75,2.2,1.75,90,-145"),
    ('t', 3.8, "1.6,9.6 1.6,1.9 @3.3,1.9,1.7,1.9,180,280;0,7 3.6,7"),
    ('u', 5.2, "0,7 0,2.7 @2.6,2.7,2.6,2.7,180,360;5.2,7 5.2,0"),
    ('v', 5.2, "0,7 2.6,0 5.2,7"),
    ('w', 8.0, "0,7 2,0 4,6.5 6,0 8,7"),
    ('x', 5.0, "0,7 5,0;5,7 0,0"),
    ('y', 5.4, "0,7 2.7,0;5.4,7 1.5,-3"),
    ('z', 4.8, "0,7 4.8,7 0,0 4.8,0"),
    ('ß', 5.4, "0,0 0,7.6 @2.3,7.6,2.3,2.4,180,-80;2.6,5.3 @2.6,2.65,2.8,2.65,90,-110"),
    ('µ', 5.2, "0,7 0,-3;0,2.7 @2.6,2.7,2.6,2.7,180,360;5.2,7 5.2,0"),
    ('.', 0.2, "0.1,0 0.1,0.3"),
    (',', 0.8, "0.6,0.3 0.6,0 0,-1.7"),
    (':', 0.2, "0.1,0.6 0.1,0.9;0.1,5.9 0.1,6.2"),
    (';', 0.8, "0.6,0.3 0.6,0 0,-1.7;0.6,5.9 0.6,6.2"),
    ('-', 3.4, "0,4.2 3.4,4.2"),
    ('−', 5.4, "0,4.6 5.4,4.6"),
    ('–', 5.4, "0,4.2 5.4,4.2"),
    ('+', 5.4, "0,4.6 5.4,4.6;2.7,7.3 2.7,1.9"),
    ('±', 5.4, "0,5.8 5.4,5.8;2.7,8.5 2.7,3.1;0,0.8 5.4,0.8"),
    ('×', 4.6, "0,7 4.6,2.4;4.6,7 0,2.4"),
    ('·', 0.2, "0.1,4.4 0.1,4.7"),
    ('=', 5.4, "0,6.2 5.4,6.2;0,3 5.4,3"),
    ('<', 5.0, "5,8 0,4.6 5,1.2"),
    ('>', 5.0, "0,8 5,4.6 0,1.2"),
    ('≤', 5.0, "5,9 0,5.8 5,2.6;0,0.6 5,0.6"),
    ('≥', 5.0, "0,9 5,5.8 0,2.6;0,0.6 5,0.6"),
    ('/', 4.2, "0,-1 4.2,10.6"),
    ('\\', 4.2, "0,10.6 4.2,-1"),
    ('|', 0.0, "0,-1.5 0,10.6"),
    ('_', 5.6, "0,-1.6 5.6,-1.6"),
    ('(', 2.2, "@4.2,4.5,4.2,6.6,120,240"),
    (')', 2.2, "@-2,4.5,4.2,6.6,60,-60"),
    ('[', 2.2, "2.2,10.8 0,10.8 0,-1.8 2.2,-1.8"),
    (']', 2.2, "0,10.8 2.2,10.8 2.2,-1.8 0,-1.8"),
    ('%', 8.0, "@1.6,7.9,1.6,2.1,0,360;@6.4,2.1,1.6,2.1,0,360;6.7,10 1.3,0"),
    ('°', 3.0, "@1.5,8.5,1.5,1.5,0,360"),
    ('\'', 0.2, "0.1,10 0.1,7.4"),
    ('"', 2.2, "0.1,10 0.1,7.4;2.1,10 2.1,7.4"),
    ('′', 1.0, "1,10 0.2,7"),
    ('″', 2.8, "1,10 0.2,7;2.8,10 2,7"),
    ('‴', 4.6, "1,10 0.2,7;2.8,10 2,7;4.6,10 3.8,7"),
    ('*', 4.4, "2.2,9.8 2.2,5;0.1,8.6 4.3,6.2;4.3,8.6 0.1,6.2"),
    ('#', 6.4, "1.8,10 0.8,0;5.6,10 4.6,0;0,6.6 6.4,6.6;0,3.4 6.4,3.4"),
    ('!', 0.2, "0.1,10 0.1,2.8;0.1,0 0.1,0.3"),
    ('?', 4.8, "@2.4,7.6,2.4,2.4,165,-60 2.4,4.2 2.4,2.8;2.4,0 2.4,0.3"),
    ('&', 6.8, "6.6,0 1.4,6.6 @2.9,7.9,1.9,2.1,220,-30 0.9,4.4 @2.7,2.6,2.7,2.6,140,320 6.4,4.6"),
    ('Ø', 7.4, "@3.7,5,3.7,5,0,360;0.4,-0.6 7,10.6"),
    ('→', 7.0, "0,4.4 7,4.4;4.8,6.4 7,4.4 4.8,2.4"),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Every item of every stroke is understood, and lies in the letter's own room.
    #[test]
    fn every_glyph_is_drawn_within_its_width() {
        for (letter, width, strokes) in GLYPHS {
            for stroke in strokes.split(';') {
                let items = stroke.split_whitespace().count();
                let points = line(stroke);
                assert!(items > 0 && points.len() >= items.max(2), "{letter}: {stroke}");
                for [x, y] in points {
                    assert!((-0.4..=width + 0.4).contains(&x), "{letter}: x {x}, width {width}");
                    assert!((-3.1..=11.1).contains(&y), "{letter}: y {y}");
                }
            }
        }
    }

    #[test]
    fn no_glyph_is_there_twice_and_all_of_ascii_that_figures_use_is_there() {
        for (index, (letter, ..)) in GLYPHS.iter().enumerate() {
            assert!(GLYPHS[..index].iter().all(|(other, ..)| other != letter), "{letter}");
        }
        for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.,:;-+=/()%'_".chars() {
            assert!(GLYPHS.iter().any(|(known, ..)| *known == letter), "{letter}");
        }
    }

    #[test]
    fn a_text_that_is_too_long_ends_in_dots() {
        let lettering = Lettering::default();
        let text = "a name of a lobe that is very long";
        assert_eq!(lettering.fitted(text, 200.0), text);
        let short = lettering.fitted(text, 30.0);
        assert!(lettering.width_mm(&short) <= 30.0 && text.starts_with(short.trim_end_matches('.')), "{short}");
        assert!(short.ends_with("..."), "{short}");
    }

    #[test]
    fn a_text_begins_ends_or_has_its_middle_where_it_is_put() {
        let ends = |anchor| {
            let lettering = Lettering { anchor, ..Lettering::default() };
            let (strokes, _) = lettering.strokes([100.0, 50.0], "HIH");
            let x = strokes.iter().flatten().map(|point| point[0]);
            (x.clone().fold(f64::INFINITY, f64::min), x.fold(f64::NEG_INFINITY, f64::max))
        };
        let width = Lettering::default().width_mm("HIH");
        for (anchor, low) in
            [(Anchor::Start, 100.0), (Anchor::Middle, 100.0 - 0.5 * width), (Anchor::End, 100.0 - width)]
        {
            let (from, to) = ends(anchor);
            assert!((from - low).abs() < 1e-9 && (to - low - width).abs() < 1e-9, "{anchor:?}: {from} {to}");
        }
    }
}
