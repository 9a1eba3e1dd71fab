// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Search path of params: the given path, `./params`, `share/camwright/params` beside the installed binary, then the copy
//! inside the binary.

use super::recorded_files::RecordedFiles;
use super::schema::nearest;
use super::{ConfigError, FileLocation};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The files of `params/` as they were when the program was built.
const BUILT_IN: &[(&str, &str)] = &[
    ("machines/cam_grinder.yaml", include_str!("../../../params/machines/cam_grinder.yaml")),
    ("machines/cam_grinder_hal.yaml", include_str!("../../../params/machines/cam_grinder_hal.yaml")),
    ("machines/cam_grinder_with_dresser.yaml", include_str!("../../../params/machines/cam_grinder_with_dresser.yaml")),
    (
        "machines/cam_grinder_profiled_wheel.yaml",
        include_str!("../../../params/machines/cam_grinder_profiled_wheel.yaml"),
    ),
    ("machines/cam_grinder_two_wheels.yaml", include_str!("../../../params/machines/cam_grinder_two_wheels.yaml")),
    (
        "machines/cam_grinder_with_steady_rest.yaml",
        include_str!("../../../params/machines/cam_grinder_with_steady_rest.yaml"),
    ),
    ("machines/bore_grinder.yaml", include_str!("../../../params/machines/bore_grinder.yaml")),
    ("machines/crank_grinder.yaml", include_str!("../../../params/machines/crank_grinder.yaml")),
    ("machines/lathe.yaml", include_str!("../../../params/machines/lathe.yaml")),
    ("machines/journal_grinder.yaml", include_str!("../../../params/machines/journal_grinder.yaml")),
    ("jobs/journal_runout.yaml", include_str!("../../../params/jobs/journal_runout.yaml")),
    ("jobs/journal_size.yaml", include_str!("../../../params/jobs/journal_size.yaml")),
    ("jobs/dressed_batch.yaml", include_str!("../../../params/jobs/dressed_batch.yaml")),
    ("jobs/four_lobe_camshaft.yaml", include_str!("../../../params/jobs/four_lobe_camshaft.yaml")),
    ("jobs/rough_and_finish.yaml", include_str!("../../../params/jobs/rough_and_finish.yaml")),
    ("jobs/plate_cam.yaml", include_str!("../../../params/jobs/plate_cam.yaml")),
    ("jobs/brake_cam.yaml", include_str!("../../../params/jobs/brake_cam.yaml")),
    ("jobs/crank_pins.yaml", include_str!("../../../params/jobs/crank_pins.yaml")),
    ("jobs/pump_ring.yaml", include_str!("../../../params/jobs/pump_ring.yaml")),
    ("jobs/punches.yaml", include_str!("../../../params/jobs/punches.yaml")),
    ("jobs/snail_cam.yaml", include_str!("../../../params/jobs/snail_cam.yaml")),
    ("jobs/tapered_lobes.yaml", include_str!("../../../params/jobs/tapered_lobes.yaml")),
    ("jobs/two_wheel_camshaft.yaml", include_str!("../../../params/jobs/two_wheel_camshaft.yaml")),
    ("jobs/wide_lobes.yaml", include_str!("../../../params/jobs/wide_lobes.yaml")),
    ("jobs/long_camshaft.yaml", include_str!("../../../params/jobs/long_camshaft.yaml")),
    ("jobs/long_camshaft_seat.yaml", include_str!("../../../params/jobs/long_camshaft_seat.yaml")),
    ("jobs/eccentric.yaml", include_str!("../../../params/jobs/eccentric.yaml")),
    ("jobs/eccentric_disc.yaml", include_str!("../../../params/jobs/eccentric_disc.yaml")),
    ("jobs/plate_groove.yaml", include_str!("../../../params/jobs/plate_groove.yaml")),
    ("jobs/barrel_groove.yaml", include_str!("../../../params/jobs/barrel_groove.yaml")),
    ("jobs/barrel_indexer.yaml", include_str!("../../../params/jobs/barrel_indexer.yaml")),
    ("jobs/level_wind.yaml", include_str!("../../../params/jobs/level_wind.yaml")),
    ("jobs/turned_cam.yaml", include_str!("../../../params/jobs/turned_cam.yaml")),
    ("studies/speed_and_infeed.yaml", include_str!("../../../params/studies/speed_and_infeed.yaml")),
    ("studies/drive_mismatch.yaml", include_str!("../../../params/studies/drive_mismatch.yaml")),
    ("lifts/intake.csv", include_str!("../../../params/lifts/intake.csv")),
    ("lifts/exhaust.csv", include_str!("../../../params/lifts/exhaust.csv")),
    ("lifts/oblong_points.csv", include_str!("../../../params/lifts/oblong_points.csv")),
    ("lifts/make_lifts.py", include_str!("../../../params/lifts/make_lifts.py")),
];

/// Begin of the path of a copy inside the binary.
const IN_BINARY: &str = "built-in:";

/// File name extension of scripts that make files.
const SCRIPT: &str = "py";

/// Largest text that is read (bytes): a table of 0.01° takes a megabyte.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// A file that was found, with its text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Located {
    /// Path of the file; `built-in:machines/…` for the copy inside the binary.
    pub path: PathBuf,
    pub text: String,
    /// Files that it names and that are found before any on the disk.
    pub recorded: RecordedFiles,
}

impl Located {
    /// Text that was read from a path; what it names is on the disk.
    #[must_use]
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { path: path.into(), text: text.into(), recorded: RecordedFiles::default() }
    }
}

/// A file that may be no text, with its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LocatedBytes {
    /// Path of the file.
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

impl LocatedBytes {
    /// The same as text.
    ///
    /// # Errors
    /// It is not UTF-8, said with its line.
    pub(super) fn into_text(self) -> Result<Located, ConfigError> {
        let Self { path, bytes } = self;
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Located::new(path, text)),
            Err(error) => Err(match text_of(&path, error.as_bytes()) {
                Err(refusal) => refusal,
                Ok(_) => ConfigError::at(FileLocation::file(&path), "is not UTF-8"),
            }),
        }
    }
}

/// Location of a file.
enum FileSource {
    File(PathBuf),
    BuiltIn(PathBuf, &'static str),
}

/// Finds a params file of a kind (`jobs`, `machines`, `lifts`, `studies`) by name or path and reads it.
///
/// # Errors
/// A file that does not exist in any of the places, cannot be read, is too large, or is not UTF-8.
pub fn locate(kind: &str, name: &str, extension: &str, relative_to: Option<&Path>) -> Result<Located, ConfigError> {
    locate_bytes(kind, name, extension, relative_to, MAX_TEXT_BYTES)?.into_text()
}

/// The same for a file that may be no text and is refused if it is larger than so many bytes, before it is read.
///
/// # Errors
/// A file that does not exist in any of the places, cannot be read, or is too large.
pub fn locate_bytes(
    kind: &str,
    name: &str,
    extension: &str,
    relative_to: Option<&Path>,
    max: u64,
) -> Result<LocatedBytes, ConfigError> {
    let path = match find(kind, name, extension, relative_to)? {
        FileSource::File(path) => path,
        FileSource::BuiltIn(path, text) => return Ok(LocatedBytes { path, bytes: text.as_bytes().to_vec() }),
    };
    let too_large =
        |length: u64| ConfigError::at(FileLocation::file(&path), format!("has {length} bytes, at most {max} are read"));
    let file = File::open(&path).map_err(|error| unreadable(&path, &error))?;
    let length = file.metadata().map_err(|error| unreadable(&path, &error))?.len();
    if length > max {
        return Err(too_large(length));
    }
    let mut bytes = Vec::new();
    // What grows while it is read, or has no length, is bounded too.
    file.take(max + 1).read_to_end(&mut bytes).map_err(|error| unreadable(&path, &error))?;
    if bytes.len() as u64 > max {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(LocatedBytes { path, bytes })
}

/// First bytes of files of spreadsheet programs: xlsx and ods, xls.
const SPREADSHEETS: [&[u8]; 2] = [b"PK\x03\x04", b"\xd0\xcf\x11\xe0"];

/// Bytes as text, or the line in which they are none.
pub(super) fn text_of<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str, ConfigError> {
    std::str::from_utf8(bytes).map_err(|error| {
        if SPREADSHEETS.iter().any(|begin| bytes.starts_with(begin)) {
            let text = "is a spreadsheet, not text; save its table as CSV (UTF-8)";
            return ConfigError::at(FileLocation::file(path), text);
        }
        let before = bytes.get(..error.valid_up_to()).unwrap_or_default();
        let line = before.iter().filter(|byte| **byte == b'\n').count() as u64 + 1;
        ConfigError::at(
            FileLocation::line(path, line),
            "is not UTF-8; save the file as text in UTF-8 (a table as CSV UTF-8)",
        )
    })
}

fn unreadable(path: &Path, error: &std::io::Error) -> ConfigError {
    ConfigError::at(FileLocation::file(path), format!("cannot be read: {error}"))
}

/// The file on the disk that [`locate`] finds; none for what is built in or not there.
pub(super) fn file_of(kind: &str, name: &str, extension: &str, relative_to: Option<&Path>) -> Option<PathBuf> {
    match find(kind, name, extension, relative_to).ok()? {
        FileSource::File(path) => Some(path),
        FileSource::BuiltIn(..) => None,
    }
}

fn find(kind: &str, name: &str, extension: &str, relative_to: Option<&Path>) -> Result<FileSource, ConfigError> {
    // The path of a copy leads to the copy.
    let name = name.strip_prefix(IN_BINARY).unwrap_or(name);
    let with_extension =
        if name.ends_with(&format!(".{extension}")) { name.to_owned() } else { format!("{name}.{extension}") };
    let mut candidates = vec![PathBuf::from(name), PathBuf::from(&with_extension)];
    if let Some(directory) = relative_to.and_then(Path::parent) {
        // A file of another kind beside it, `flank.txt`, is named with its own extension.
        if Path::new(name).extension().is_some() {
            candidates.push(directory.join(name));
            candidates.push(directory.join("..").join(kind).join(name));
        }
        candidates.push(directory.join(&with_extension));
        candidates.push(directory.join("..").join(&with_extension));
        candidates.push(directory.join("..").join(kind).join(&with_extension));
    }
    for root in roots() {
        candidates.push(root.join(&with_extension));
        candidates.push(root.join(kind).join(&with_extension));
    }
    if let Some(path) = candidates.into_iter().find(|path| path.is_file()) {
        return Ok(FileSource::File(path));
    }
    let built_in = |key: &str| BUILT_IN.iter().find(|(path, _)| *path == key);
    if let Some((path, text)) = built_in(&format!("{kind}/{with_extension}")).or_else(|| built_in(&with_extension)) {
        return Ok(FileSource::BuiltIn(PathBuf::from(format!("{IN_BINARY}{path}")), text));
    }
    let known = list(kind);
    let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    let known = match nearest(&stem, &known.iter().map(String::as_str).collect::<Vec<_>>()) {
        Some(nearest) => format!("; did you mean {nearest}?"),
        None if known.is_empty() => String::new(),
        None => format!("; known {kind}: {}", known.join(", ")),
    };
    Err(ConfigError::at(
        FileLocation::file(Path::new(name)),
        format!("not found as given, in ./params/{kind}, in share/camwright/params/{kind} or built in{known}"),
    ))
}

/// Names of the files of a kind that [`locate`] finds by name, sorted. A script beside them is none.
#[must_use]
pub fn list(kind: &str) -> Vec<String> {
    let mut names: Vec<String> = BUILT_IN
        .iter()
        .filter_map(|(path, _)| path.strip_prefix(kind)?.strip_prefix('/')?.rsplit_once('.'))
        .filter(|(_, extension)| *extension != SCRIPT)
        .map(|(stem, _)| stem.to_owned())
        .collect();
    for root in roots() {
        let Ok(entries) = std::fs::read_dir(root.join(kind)) else { continue };
        let is_named = |path: &PathBuf| path.is_file() && path.extension().is_none_or(|extension| extension != SCRIPT);
        for path in entries.filter_map(Result::ok).map(|entry| entry.path()).filter(is_named) {
            if let Some(stem) = path.file_stem().and_then(|stem| stem.to_str()) {
                names.push(stem.to_owned());
            }
        }
    }
    names.sort();
    names.dedup();
    names
}

pub(super) fn roots() -> Vec<PathBuf> {
    let mut roots = vec![PathBuf::from("params")];
    // <prefix>/bin/<binary> or <prefix>/lib/camwright/<binary>
    let program = std::env::current_exe().unwrap_or_default();
    roots.extend(program.ancestors().skip(2).take(2).map(|prefix| prefix.join("share/camwright/params")));
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The copy inside the binary is the whole of `params/`, so that an installed program needs no files.
    #[test]
    fn every_params_file_is_built_in() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../params");
        for kind in ["machines", "jobs", "lifts", "studies"] {
            let Ok(entries) = std::fs::read_dir(root.join(kind)) else { continue };
            for entry in entries.filter_map(Result::ok) {
                let key = format!("{kind}/{}", entry.file_name().to_string_lossy());
                assert!(BUILT_IN.iter().any(|(path, _)| *path == key), "{key} is not in BUILT_IN");
            }
        }
    }

    #[test]
    fn a_file_that_is_too_large_is_refused_before_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.stl");
        std::fs::write(&path, [7; 100]).unwrap();
        let name = path.display().to_string();
        assert_eq!(locate_bytes("surfaces", &name, "stl", None, 100).unwrap().bytes.len(), 100);
        let error = locate_bytes("surfaces", &name, "stl", None, 99).unwrap_err().to_string();
        assert!(error.ends_with("has 100 bytes, at most 99 are read"), "{error}");
    }

    #[test]
    fn a_name_that_does_not_exist_is_refused_with_what_exists() {
        let error = locate("machines", "no_such_machine", "yaml", None).unwrap_err();
        assert!(error.to_string().contains("cam_grinder"), "{error}");
    }

    #[test]
    fn a_misspelt_name_is_refused_with_the_nearest() {
        let error = locate("jobs", "four_lobe_camshft", "yaml", None).unwrap_err().to_string();
        assert!(error.ends_with("; did you mean four_lobe_camshaft?"), "{error}");
        let error = locate("machines", "my/folder/cam_grindr.yaml", "yaml", None).unwrap_err().to_string();
        assert!(error.ends_with("; did you mean cam_grinder?"), "{error}");
    }
}
