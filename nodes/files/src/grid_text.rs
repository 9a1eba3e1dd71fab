// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Radii on a grid as a table: azimuths in the first line, then a line for each place along the part.
//!
//! ```text
//! # anything                          lines that begin with # are comments
//! z_mm,0,5,10,…,355                   azimuths from the keyway (deg): equal steps of a turn
//! 0.0,21.5,21.49,21.46,…,21.49        a place along the part (mm), and the radius at each azimuth (mm)
//! ```
//! `camwright plan` writes the surface of every part like this (`surface.csv`).

use super::{ConfigError, FileLocation};
use camwright::cam::surface::grid::SurfaceGrid;
use camwright::cam::surface::{Surface, SurfaceError, SurfaceKey};
use camwright::math::units::rad_from_deg;
use std::io::{self, Write};
use std::path::Path;

/// Largest file (bytes).
pub(super) const MAX_BYTES: u64 = 1 << 28;

/// Most radii: 128 MB, and as much again for the surface through them.
const MAX_RADII: usize = 16_000_000;

/// Start of the first line.
const HEAD: &str = "z_mm";

/// Maximum number of reported cells without a number.
const MAX_FINDINGS: usize = 20;

/// The surface through the radii of a table.
///
/// # Errors
/// Every cell that is no number, with its line; what is not a grid, with the line of it.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Surface, Vec<ConfigError>> {
    let text = super::locate::text_of(path, bytes).map_err(|error| vec![error])?;
    let (grid, lines) = parse(path, text)?;
    Surface::grid(&grid).map_err(|error| vec![at_line(path, &error, &lines)])
}

/// Lines of the head and of every row.
struct RowLines {
    head: u64,
    rows: Vec<u64>,
}

fn parse(path: &Path, text: &str) -> Result<(SurfaceGrid, RowLines), Vec<ConfigError>> {
    let refuse = |line: u64, message: String| ConfigError::at(FileLocation::line(path, line), message);
    let mut written = (1..).zip(text.lines()).filter(|(_, line)| {
        let line = line.trim();
        !(line.is_empty() || line.starts_with('#'))
    });
    let Some((head, line)) = written.next() else {
        return Err(vec![ConfigError::at(FileLocation::file(path), "has no line with azimuths".to_owned())]);
    };
    let mut cells = line.split(',').map(str::trim);
    let first = cells.next().unwrap_or_default();
    if first != HEAD {
        let message =
            format!("the first line begins with {:?}, it must be {HEAD}, then the azimuths (deg)", short(first));
        return Err(vec![refuse(head, message)]);
    }
    let mut findings = Vec::new();
    let mut azimuths_deg = Vec::new();
    for (column, cell) in cells.enumerate() {
        match number(cell) {
            Ok(azimuth_deg) => azimuths_deg.push(azimuth_deg),
            Err(what) => {
                findings.push(refuse(head, format!("azimuth {}: {what}", column + 1)));
                if findings.len() == MAX_FINDINGS {
                    return Err(findings);
                }
            }
        }
    }
    if !findings.is_empty() {
        return Err(findings);
    }
    let columns = azimuths_deg.len();
    let azimuths_rad = azimuths_deg.iter().map(|azimuth| rad_from_deg(*azimuth)).collect();
    let mut lines = RowLines { head, rows: Vec::new() };
    let mut grid = SurfaceGrid { azimuths_rad, z_mm: Vec::new(), radii_mm: Vec::new() };
    for (line, row) in written {
        if grid.radii_mm.len() + columns > MAX_RADII {
            findings.push(refuse(line, format!("there are more than {MAX_RADII} radii: fewer azimuths or rows")));
            return Err(findings);
        }
        let count = row.split(',').count();
        if count != columns + 1 {
            findings.push(refuse(line, format!("{count} columns, the first line has {}", columns + 1)));
        } else {
            lines.rows.push(line);
            for (column, cell) in row.split(',').map(str::trim).enumerate() {
                let value = number(cell).unwrap_or_else(|what| {
                    let of = match column.checked_sub(1) {
                        None => HEAD.to_owned(),
                        Some(index) => format!("azimuth {} deg", azimuths_deg[index]),
                    };
                    if findings.len() < MAX_FINDINGS {
                        findings.push(refuse(line, format!("{of}: {what}")));
                    }
                    f64::NAN
                });
                if column == 0 { grid.z_mm.push(value) } else { grid.radii_mm.push(value) }
            }
        }
        if findings.len() >= MAX_FINDINGS {
            return Err(findings);
        }
    }
    if findings.is_empty() { Ok((grid, lines)) } else { Err(findings) }
}

fn number(cell: &str) -> Result<f64, String> {
    match cell.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) => Err(format!("{value} is not a finite number")),
        Err(_) => Err(format!("{:?} is not a number", short(cell))),
    }
}

/// A cell as a message can carry it.
fn short(cell: &str) -> String {
    cell.chars().take(40).collect()
}

/// The core counts rows and columns; a message of this program begins with the file and the line.
fn at_line(path: &Path, error: &SurfaceError, lines: &RowLines) -> ConfigError {
    let line = match error {
        SurfaceError::BadRadius { row, .. }
        | SurfaceError::ZNotIncreasing { row, .. }
        | SurfaceError::NotClosed { row, .. } => lines.rows.get(*row).copied(),
        SurfaceError::UnevenAzimuth { .. } | SurfaceError::Count { what: SurfaceKey::Azimuths, .. } => Some(lines.head),
        _ => None,
    };
    let text = error.to_string();
    // `row 3: ` and `row 3, ` say what the line says.
    let number = |rest: &str| rest.trim_start_matches(|c: char| c.is_ascii_digit()).get(2..).map(str::to_owned);
    let message = text.strip_prefix("row ").filter(|_| line.is_some()).and_then(number).unwrap_or(text);
    ConfigError::at(line.map_or_else(|| FileLocation::file(path), |line| FileLocation::line(path, line)), message)
}

/// Writes a surface as `read` reads it: at equal azimuths, and at these places (mm).
///
/// # Errors
/// What cannot be written.
pub fn write(surface: &Surface, azimuths: u32, places_mm: &[f64], to: &mut dyn Write) -> io::Result<()> {
    let degrees: Vec<f64> = (0..azimuths).map(|index| f64::from(index) * 360.0 / f64::from(azimuths)).collect();
    let line = |cells: &mut dyn Iterator<Item = f64>| cells.map(|cell| format!(",{cell}")).collect::<String>();
    writeln!(to, "{HEAD}{}", line(&mut degrees.iter().copied()))?;
    for z_mm in places_mm {
        writeln!(
            to,
            "{z_mm}{}",
            line(&mut degrees.iter().map(|azimuth| surface.radius(rad_from_deg(*azimuth), *z_mm)))
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::cam::surface::solid::{LinearInZ, Solid};

    fn cone() -> Surface {
        let (first_mm, second_mm) =
            (LinearInZ { at_zero: 24.0, per_mm: -0.1 }, LinearInZ { at_zero: 21.0, per_mm: -0.06 });
        Surface::solid(Solid::EllipticCone { first_mm, second_mm, azimuth_rad: 0.3 }, 0.0, 20.0).unwrap()
    }

    fn table() -> String {
        let mut bytes = Vec::new();
        let places: Vec<f64> = (0..=10).map(|k| 2.0 * f64::from(k)).collect();
        write(&cone(), 72, &places, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    fn refusal(text: &str) -> String {
        let errors = read(Path::new("part.csv"), text.as_bytes()).expect_err("it is refused");
        errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn what_is_written_is_read_back() {
        let read = read(Path::new("part.csv"), table().as_bytes()).unwrap();
        assert_eq!(read.ends_mm(), (0.0, 20.0));
        for k in 0..200 {
            let (azimuth, z) = (0.05 * f64::from(k), 0.1 * f64::from(k));
            let off_mm = read.radius(azimuth, z) - cone().radius(azimuth, z);
            // A quintic through 5° steps of an ellipse.
            assert!(off_mm.abs() < 2e-6, "{off_mm} mm at {azimuth} rad, {z} mm");
        }
        let mut again = Vec::new();
        write(&read, 72, &(0..=10).map(|k| 2.0 * f64::from(k)).collect::<Vec<_>>(), &mut again).unwrap();
        let cells = |text: &str| {
            text.lines()
                .skip(1)
                .flat_map(|l| l.split(',').map(|c| c.parse().unwrap()).collect::<Vec<f64>>())
                .collect::<Vec<_>>()
        };
        for (first, second) in cells(&table()).iter().zip(cells(&String::from_utf8(again).unwrap())) {
            assert!((first - second).abs() < 1e-12, "{first} {second}");
        }
    }

    #[test]
    fn comments_and_blanks_are_passed_over() {
        let text = format!("# a cone\n\n{}# its end\n", table().replace(',', " , "));
        assert_eq!(
            read(Path::new("part.csv"), text.as_bytes()).unwrap(),
            read(Path::new("part.csv"), table().as_bytes()).unwrap()
        );
    }

    #[test]
    fn every_error_is_reported_with_its_line_and_value() {
        let change = |line: usize, change: &dyn Fn(&str) -> String| -> String {
            let lines = table()
                .lines()
                .map(str::to_owned)
                .enumerate()
                .map(|(index, text)| if index + 1 == line { change(&text) } else { text })
                .collect::<Vec<_>>();
            lines.join("\n") + "\n"
        };
        let cell = |column: usize, value: &'static str| {
            move |line: &str| {
                let mut cells: Vec<&str> = line.split(',').collect();
                cells[column] = value;
                cells.join(",")
            }
        };
        for (text, words) in [
            (String::new(), "part.csv: has no line with azimuths"),
            ("z_mm\n".into(), "part.csv:1: 0 azimuths, there must be 6 to 36000"),
            (table().replacen("z_mm", "0.0", 1), "part.csv:1: the first line begins with \"0.0\", it must be z_mm"),
            (change(1, &cell(3, "ten")), "part.csv:1: azimuth 3: \"ten\" is not a number"),
            (change(1, &cell(3, "10.5")), "part.csv:1: column 2: azimuth 10.5"),
            (change(5, &cell(1, "wide")), "part.csv:5: azimuth 0 deg: \"wide\" is not a number"),
            (change(5, &cell(0, "NaN")), "part.csv:5: z_mm: NaN is not a finite number"),
            (change(5, &cell(2, "inf")), "part.csv:5: azimuth 5 deg: inf is not a finite number"),
            (change(5, &cell(2, "-21.0")), "part.csv:5: azimuth 5.000 deg: radius -21 mm is not a positive number"),
            (change(5, &cell(0, "1.0")), "part.csv:5: z = 1 mm does not increase (previous 4 mm)"),
            (change(5, &|line| format!("{line},1.0")), "part.csv:5: 74 columns, the first line has 73"),
            (
                table().lines().take(2).fold(String::new(), |all, line| all + line + "\n"),
                "1 rows, there must be 2 to 200000",
            ),
            (table().replace('.', ";"), "is not a number"),
        ] {
            let error = refusal(&text);
            assert!(error.contains(words), "{words}: {error}");
        }
        // All of them, up to a number.
        assert_eq!(refusal(&table().replace(".", "x")).lines().count(), MAX_FINDINGS);
        assert!(
            read(Path::new("a.csv"), b"z_mm,0\n\xff").unwrap_err()[0].to_string().contains("a.csv:2: is not UTF-8")
        );
    }

    #[test]
    fn radii_are_counted_before_they_are_kept() {
        let row = vec!["1"; 36_001].join(",");
        let azimuths: Vec<String> = (0..36_000).map(|k| format!("{}", f64::from(k) / 100.0)).collect();
        let text = format!("z_mm,{}\n{}", azimuths.join(","), (row + "\n").repeat(450));
        let error = refusal(&text);
        assert!(error.contains("part.csv:446: there are more than 16000000 radii"), "{error}");
    }
}
