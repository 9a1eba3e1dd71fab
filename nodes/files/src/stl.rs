// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Triangles from STL files, as CAD writes them: as text, or as 50 bytes each behind a head of 84.
//!
//! An STL file says neither its unit nor where the axis of the part is; the job does. Normals are not read: the corners say all.

use super::{ConfigError, FileLocation};
use camwright::cam::surface::mesh::Triangle;
use std::path::Path;
use std::str::SplitAsciiWhitespace;

/// Largest file (bytes): three million triangles are read, 150 MB as bytes; a million as text.
pub(super) const MAX_BYTES: u64 = 1 << 28;

/// Size of the head of a binary file: 80 free bytes and the number of triangles.
const HEAD: usize = 84;

/// A triangle there: normal and corners in single precision, and two bytes for anybody.
const RECORD: usize = 50;

/// The triangles of a file, in its own unit and axes.
///
/// # Errors
/// Anything that is not a whole STL file, in one sentence: another length than its number of triangles asks for, words where others must
/// stand, numbers that are none, triangles without an area.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<Triangle>, ConfigError> {
    let refuse = |message: String| ConfigError::at(FileLocation::file(path), message);
    let says_text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // Some programs begin binary files with the word that marks text: what counts is whether the length is that of a binary file.
    let length = whole_length(bytes);
    let triangles = match length {
        Some(wanted) if wanted == bytes.len() as u64 => binary(bytes).map_err(refuse)?,
        _ if says_text && !bytes.contains(&0) => text(path, bytes)?,
        _ if says_text => {
            return Err(refuse(format!(
                "begins with \"solid\", as a text file does, but holds bytes that are no text; as a binary file {}",
                length_fault(bytes.len(), length)
            )));
        }
        _ => {
            return Err(refuse(format!(
                "is no STL file: it does not begin with \"solid\", as a text file does, and as a binary file {}",
                length_fault(bytes.len(), length)
            )));
        }
    };
    if triangles.is_empty() {
        return Err(refuse("has no triangles".to_owned()));
    }
    match triangles.iter().position(has_no_area) {
        None => Ok(triangles),
        Some(first) => {
            let count = triangles.iter().filter(|triangle| has_no_area(triangle)).count();
            let [x, y, z] = triangles[first][0];
            Err(refuse(format!(
                "{count} of its {} triangles have no area, the first is triangle {} at ({x}, {y}, {z}): two corners are one, or all lie \
                 on a line",
                triangles.len(),
                first + 1
            )))
        }
    }
}

/// Required length of a binary file with the number of triangles in its head.
fn whole_length(bytes: &[u8]) -> Option<u64> {
    let count = u32::from_le_bytes(*bytes.get(HEAD - 4..)?.first_chunk()?);
    Some(HEAD as u64 + RECORD as u64 * u64::from(count))
}

fn length_fault(length: usize, wanted: Option<u64>) -> String {
    match wanted {
        None => format!("it has {length} bytes; the minimum is {HEAD}"),
        Some(wanted) => {
            let count = (wanted - HEAD as u64) / RECORD as u64;
            format!("its head states {count} triangles, which are {wanted} bytes, it has {length}")
        }
    }
}

fn binary(bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    let records = bytes.get(HEAD..).unwrap_or_default().chunks_exact(RECORD);
    let mut triangles = Vec::with_capacity(records.len());
    for (index, record) in records.enumerate() {
        let mut triangle: Triangle = [[0.0; 3]; 3];
        // Behind three numbers of the normal.
        for (number, bytes) in triangle.as_flattened_mut().iter_mut().zip(record.chunks_exact(4).skip(3)) {
            let single = bytes.first_chunk().map_or(f32::NAN, |bytes| f32::from_le_bytes(*bytes));
            if !single.is_finite() {
                return Err(format!("triangle {}: a coordinate is {single}, not a finite number", index + 1));
            }
            *number = f64::from(single);
        }
        triangles.push(triangle);
    }
    Ok(triangles)
}

/// The words of a text file with their lines.
struct StlWords<'a> {
    path: &'a Path,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    line: u64,
    words: SplitAsciiWhitespace<'a>,
}

impl<'a> StlWords<'a> {
    fn error(&self, message: String) -> ConfigError {
        ConfigError::at(FileLocation::line(self.path, self.line), message)
    }

    /// The next word, on this line or one below.
    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            let (index, line) = self.lines.next()?;
            self.line = index as u64 + 1;
            self.words = line.split_ascii_whitespace();
        }
    }

    fn expect(&mut self, wanted: &str) -> Result<(), ConfigError> {
        match self.next() {
            Some(word) if word.eq_ignore_ascii_case(wanted) => Ok(()),
            Some(word) => Err(self.error(format!("{:?} stands where {wanted:?} must stand", shortened(word)))),
            None => Err(self.error(format!("the file ends where {wanted:?} must stand"))),
        }
    }

    fn number(&mut self) -> Result<f64, ConfigError> {
        match self.next() {
            Some(word) => match word.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                Ok(value) => Err(self.error(format!("a coordinate is {value}, not a finite number"))),
                Err(_) => Err(self.error(format!("{:?} is not a number", shortened(word)))),
            },
            None => Err(self.error("the file ends where a number must stand".to_owned())),
        }
    }
}

/// A word as a message can carry it.
fn shortened(word: &str) -> String {
    const MAX_CHARACTERS: usize = 40;
    let mut short: String = word.chars().take(MAX_CHARACTERS).collect();
    if short.len() < word.len() {
        short.push('…');
    }
    short
}

fn text(path: &Path, bytes: &[u8]) -> Result<Vec<Triangle>, ConfigError> {
    let text = super::locate::text_of(path, bytes)?;
    let mut words = StlWords { path, lines: text.lines().enumerate(), line: 1, words: "".split_ascii_whitespace() };
    words.expect("solid")?;
    // The rest of that line is its name.
    words.words = "".split_ascii_whitespace();
    let mut triangles = Vec::new();
    loop {
        match words.next() {
            Some(word) if word.eq_ignore_ascii_case("facet") => {}
            Some(word) if word.eq_ignore_ascii_case("endsolid") => break,
            Some(word) => {
                return Err(
                    words.error(format!("{:?} stands where \"facet\" or \"endsolid\" must stand", shortened(word)))
                );
            }
            None => {
                let message = format!("the file ends after {} triangles, without \"endsolid\"", triangles.len());
                return Err(words.error(message));
            }
        }
        words.expect("normal")?;
        for _ in 0..3 {
            // A normal of a triangle that has none is written as NaN by some; it is not used.
            if words.next().is_none() {
                return Err(words.error("the file ends where a number must stand".to_owned()));
            }
        }
        words.expect("outer")?;
        words.expect("loop")?;
        let mut triangle: Triangle = [[0.0; 3]; 3];
        for corner in &mut triangle {
            words.expect("vertex")?;
            for number in corner {
                *number = words.number()?;
            }
        }
        words.expect("endloop")?;
        words.expect("endfacet")?;
        triangles.push(triangle);
    }
    words.words = "".split_ascii_whitespace();
    match words.next() {
        None => Ok(triangles),
        Some(word) => {
            Err(words.error(format!("{:?} stands behind \"endsolid\": a file holds one solid", shortened(word))))
        }
    }
}

/// Returns whether a triangle is a point or a line, to the digits of single precision.
fn has_no_area(triangle: &Triangle) -> bool {
    let side = |k: usize| [0, 1, 2].map(|i| triangle[k][i] - triangle[0][i]);
    let ([a, b, c], [d, e, f]) = (side(1), side(2));
    let square = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let area = square([b * f - c * e, c * d - a * f, a * e - b * d]);
    // Of a right triangle this is the square of the product of its sides.
    area <= 1e-14 * square([a, b, c]) * square([d, e, f])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(crate) fn binary_of(triangles: &[Triangle]) -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            #[allow(clippy::cast_possible_truncation, reason = "what the format holds")]
            bytes.extend(triangle.as_flattened().iter().flat_map(|number| (*number as f32).to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    pub(crate) fn text_of(triangles: &[Triangle]) -> String {
        let facet = |triangle: &Triangle| {
            let vertices: String =
                triangle.iter().map(|[x, y, z]| format!("      vertex {x:e} {y:e} {z:e}\n")).collect();
            format!("  facet normal 0 0 0\n    outer loop\n{vertices}    endloop\n  endfacet\n")
        };
        format!("solid part\n{}endsolid part\n", triangles.iter().map(facet).collect::<String>())
    }

    const TWO: [Triangle; 2] =
        [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [[2.0, 0.0, 0.0], [0.0, -2.5, 0.0], [0.0, 0.0, 1.25]]];

    fn refusal(bytes: &[u8]) -> String {
        read(Path::new("part.stl"), bytes).expect_err("it is refused").to_string()
    }

    #[test]
    fn both_kinds_give_the_triangles_that_were_written() {
        assert_eq!(read(Path::new("a.stl"), &binary_of(&TWO)).unwrap(), TWO);
        assert_eq!(read(Path::new("a.stl"), text_of(&TWO).as_bytes()).unwrap(), TWO);
        // Words in capitals, everything on one line, a name of several words.
        let loud = text_of(&TWO).to_uppercase();
        assert_eq!(read(Path::new("a.stl"), loud.as_bytes()).unwrap(), TWO);
    }

    #[test]
    fn a_binary_file_that_begins_like_text_is_read_as_what_it_is() {
        let mut bytes = binary_of(&TWO);
        bytes[..5].copy_from_slice(b"solid");
        assert_eq!(read(Path::new("a.stl"), &bytes).unwrap(), TWO);
        bytes.pop();
        let error = refusal(&bytes);
        assert!(
            error.contains("begins with \"solid\"") && error.contains("2 triangles, which are 184 bytes, it has 183"),
            "{error}"
        );
    }

    #[test]
    fn what_is_no_whole_file_is_refused_in_one_sentence() {
        let cut = |bytes: Vec<u8>, by: usize| bytes[..bytes.len() - by].to_vec();
        let with = |at: usize, four: [u8; 4]| {
            let mut bytes = binary_of(&TWO);
            bytes[at..at + 4].copy_from_slice(&four);
            bytes
        };
        let text = |from: &str, to: &str| text_of(&TWO).replacen(from, to, 1).into_bytes();
        for (bytes, words) in [
            (Vec::new(), "it has 0 bytes; the minimum is 84"),
            (cut(binary_of(&TWO), 110), "it has 74 bytes; the minimum is 84"),
            (cut(binary_of(&TWO), 1), "states 2 triangles, which are 184 bytes, it has 183"),
            (with(80, u32::MAX.to_le_bytes()), "states 4294967295 triangles, which are 214748364834 bytes"),
            (binary_of(&[]), "has no triangles"),
            (with(84 + 50 + 12, f32::NAN.to_le_bytes()), "triangle 2: a coordinate is NaN"),
            (with(84 + 16, f32::INFINITY.to_le_bytes()), "triangle 1: a coordinate is inf"),
            (text("vertex 1e0", "vertex one"), "part.stl:4: \"one\" is not a number"),
            (text("vertex 1e0", "vertex NaN"), "part.stl:4: a coordinate is NaN"),
            (text("endloop", "vertex"), "part.stl:7: \"vertex\" stands where \"endloop\" must stand"),
            (text("  facet", "  facette"), "part.stl:2: \"facette\" stands where \"facet\" or \"endsolid\" must stand"),
            (text("endsolid part", ""), "the file ends after 2 triangles, without \"endsolid\""),
            (text("endsolid part\n", "endsolid part\nsolid b\nendsolid b\n"), "\"solid\" stands behind \"endsolid\""),
            (b"solid part\n facet normal 0 0".to_vec(), "part.stl:2: the file ends where a number must stand"),
            (b"solid \xff\xfe\n".to_vec(), "part.stl:1: is not UTF-8"),
            (
                binary_of(&[TWO[0], [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [0.0; 3]]]),
                "1 of its 2 triangles have no area, the first is triangle 2 at (1, 2, 3)",
            ),
            (binary_of(&[[[0.0; 3], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]]]), "1 of its 1 triangles have no area"),
        ] {
            let error = refusal(&bytes);
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}
