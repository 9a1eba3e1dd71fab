// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Surfaces that stand in files of their own.

use super::*;
use crate::locate::{Located, locate};
use crate::stl::tests::{binary_of, text_of};
use crate::turning_file::{TurnedJob, read};
use camwright::cam::surface::mesh::Triangle;
use camwright::math::units::TURN_RAD;
use std::path::Path;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

fn cone() -> Surface {
    let (first_mm, second_mm) = (LinearInZ { at_zero: 24.0, per_mm: -0.1 }, LinearInZ { at_zero: 21.0, per_mm: -0.06 });
    Surface::solid(Solid::EllipticCone { first_mm, second_mm, azimuth_rad: 0.3 }, 0.0, 20.0).unwrap()
}

/// Triangles with their corners on the cone, with both ends.
fn mesh(angles: u32, bands: u32) -> Vec<Triangle> {
    let cone = cone();
    let corner = |i: u32, k: u32| {
        let azimuth = f64::from(i % angles) * TURN_RAD / f64::from(angles);
        let z = 20.0 * f64::from(k) / f64::from(bands);
        let radius = cone.radius(azimuth, z);
        [radius * azimuth.cos(), radius * azimuth.sin(), z]
    };
    let mut triangles = Vec::new();
    for i in 0..angles {
        for k in 0..bands {
            let (a, b, c, d) = (corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([[0.0, 0.0, 0.0], corner(i + 1, 0), corner(i, 0)]);
        triangles.push([[0.0, 0.0, 20.0], corner(i, bands), corner(i + 1, bands)]);
    }
    triangles
}

/// The shipped job with this surface.
fn job(surface: &str) -> Result<TurnedJob, Vec<String>> {
    let overrides = [format!("surface={surface}"), "turned={from_mm: 20.0, to_mm: 0.0}".to_owned()];
    read(&locate("jobs", "turned_cam", "yaml", None).unwrap(), &overrides)
        .map_err(|errors| errors.iter().map(ToString::to_string).collect())
}

fn largest_difference_mm(surface: &Surface) -> f64 {
    let cone = cone();
    (0..500).fold(0.0_f64, |max, k| {
        let (azimuth, z) = (0.0377 * f64::from(k), 0.04 * f64::from(k));
        max.max((surface.radius(azimuth, z) - cone.radius(azimuth, z)).abs())
    })
}

/// The same part from text, from bytes, in inches and metres, and along another axis.
#[test]
fn a_mesh_is_the_smooth_part_that_it_was_made_of_in_any_unit_and_along_any_axis() {
    let folder = Folder::new();
    let triangles = mesh(96, 20);
    let scaled = |factor: f64, axis: fn([f64; 3]) -> [f64; 3]| -> Vec<Triangle> {
        triangles.iter().map(|triangle| triangle.map(|corner| axis(corner.map(|length| length * factor)))).collect()
    };
    for (name, bytes, keys) in [
        ("a.stl", binary_of(&triangles), "unit: mm"),
        ("b.stl", text_of(&triangles).into_bytes(), "unit: mm, axis: z"),
        ("c.stl", binary_of(&scaled(1.0 / 25.4, |corner| corner)), "unit: inch"),
        ("d.stl", text_of(&scaled(1e-3, |[x, y, z]| [z, x, y])).into_bytes(), "unit: m, axis: x"),
        ("e.stl", text_of(&scaled(1.0, |[x, y, z]| [y, z, x])).into_bytes(), "unit: mm, axis: y"),
    ] {
        let path = folder.write(name, &bytes);
        let job = job(&format!("{{kind: mesh, file: {:?}, {keys}}}", path.display().to_string()))
            .unwrap_or_else(|e| panic!("{name}: {e:?}"));
        // Single precision rounds to 1.5 nm at 24 mm; the spline through the corners adds some more.
        let off_mm = largest_difference_mm(&job.spec.surface);
        assert!(off_mm < 2e-4, "{name}: {off_mm}");
        let (file, reading) = job.mesh.expect("how it was read");
        assert_eq!((file, reading.triangles, reading.left_out), (path, 96 * 20 * 2, 96 * 2), "{name}");
        assert!(reading.corners_off_mm < 1e-5 && reading.faces_off_mm > 5e-3, "{name}: {reading:?}");
    }
}

#[test]
fn the_surface_file_is_hashed_and_its_errors_name_it() {
    let folder = Folder::new();
    let surface = |path: &Path| format!("{{kind: mesh, file: {:?}, unit: mm}}", path.display().to_string());
    let good = folder.write("part.stl", &binary_of(&mesh(48, 8)));
    let first = job(&surface(&good)).unwrap().hash;
    folder.write("part.stl", &binary_of(&mesh(48, 10)));
    assert_ne!(job(&surface(&good)).unwrap().hash, first);
    for (bytes, words) in [
        (binary_of(&mesh(48, 8)[..200]), "no triangle covers azimuth"),
        (binary_of(&mesh(48, 8)[..3]), "3 triangles, there must be 4 to 3000000"),
        (b"solid".to_vec(), "without \"endsolid\""),
    ] {
        let path = folder.write("part.stl", &bytes);
        let error = job(&surface(&path)).expect_err("refused").join("\n");
        assert!(error.contains("part.stl") && error.contains(words), "{words}: {error}");
    }
    for (surface, words) in [
        ("{kind: mesh, file: none.stl, unit: mm}", "none.stl: not found as given, in ./params/surfaces"),
        ("{kind: grid, file: none.csv}", "none.csv: not found as given"),
        ("{kind: mesh, file: a.stl}", "unit"),
        ("{kind: mesh, file: a.stl, unit: cm}", "cm"),
        ("{kind: mesh, file: a.stl, unit: mm, axis: w}", "surface.axis is \"w\"; it must be one of x, y, z"),
        ("{kind: mesh, file: a.stl, unit: mm, axis: n}", "surface.axis is false; it must be one of x, y, z"),
        ("{kind: grid}", "file"),
    ] {
        let error = job(surface).expect_err("refused").join("\n");
        assert!(error.contains(words), "{surface}: {error}");
    }
}

/// Bytes changed, cut off, doubled, and numbers put in: whatever comes, it is a surface or a sentence.
fn mutated(bytes: &[u8], below: &mut impl FnMut(usize) -> usize) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=below(4) {
        let length = bytes.len().max(1);
        let at = below(length).min(bytes.len());
        match below(6) {
            0 => bytes.truncate(at),
            1 => bytes.extend_from_within(at..),
            2 => {
                let inserted: &[u8] =
                    [&b"nan"[..], b"-1e308", b"\0", b"solid", b"{", b"\xff\xff", b",", b"\n"][below(8)];
                bytes.splice(at..at, inserted.iter().copied());
            }
            3 => drop(bytes.splice(at..(at + below(40)).min(bytes.len()), [])),
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << below(8);
                }
            }
        }
    }
    bytes
}

/// Whole numbers from 0 up to below another, the same for the same seed.
fn random_below(seed: u64) -> impl FnMut(usize) -> usize {
    let mut state = seed;
    move |count| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).expect("31 bits") % count
    }
}

#[test]
fn no_file_of_a_surface_makes_the_reader_panic() {
    let seed = 20_260_722;
    let mut below = random_below(seed);
    let folder = Folder::new();
    let triangles = mesh(24, 3);
    let mut table = Vec::new();
    grid_text::write(&cone(), 24, &[0.0, 5.0, 10.0, 20.0], &mut table).unwrap();
    let sources = [
        ("part.stl", "mesh", "unit: mm", binary_of(&triangles)),
        ("part.stl", "mesh", "unit: mm", text_of(&triangles).into_bytes()),
        ("part.csv", "grid", "", table),
    ];
    let (mut made, mut refused) = (0, 0);
    for round in 0..600 {
        let (name, kind, keys, bytes) = &sources[round % sources.len()];
        let path = folder.write(name, &mutated(bytes, &mut below));
        match job(&format!("{{kind: {kind}, file: {:?}, {keys}}}", path.display().to_string())) {
            Ok(_) => made += 1,
            Err(errors) => {
                refused += 1;
                for error in errors {
                    assert!(error.len() > 20 && error.len() < 1000, "seed {seed} round {round}: {error}");
                }
            }
        }
    }
    assert!(made > 5 && refused > 300, "seed {seed}: made {made}, refused {refused}");
}

#[test]
fn no_job_file_makes_the_reader_panic() {
    let seed = 7_210;
    let mut below = random_below(seed);
    let located = locate("jobs", "turned_cam", "yaml", None).unwrap();
    let (mut made, mut refused) = (0, 0);
    for round in 0..400 {
        let text = String::from_utf8_lossy(&mutated(located.text.as_bytes(), &mut below)).into_owned();
        match read(&Located::new(located.path.clone(), text), &[]) {
            Ok(_) => made += 1,
            Err(errors) => {
                refused += 1;
                assert!(
                    !errors.is_empty() && errors.iter().all(|error| !error.message.is_empty()),
                    "seed {seed} round {round}"
                );
            }
        }
    }
    assert!(made > 5 && refused > 100, "seed {seed}: made {made}, refused {refused}");
}
