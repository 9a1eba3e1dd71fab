// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files that requests over ROS may name: those in the folders of the job and of params, and in folders that the operator names.
//! What a file says travels in refusals, so no other is read.

use super::locate::{file_of, roots};
use super::yaml::YamlValue;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Keys that name files, with the kind of file and how its name may end where it is omitted.
const FILE_KEYS: [(&str, &str, &[&str]); 7] = [
    ("machine", "machines", &["yaml"]),
    ("program", "programs", &["ngc", "NC", "MPF"]),
    ("table", "lifts", &["csv"]),
    ("half_table", "lifts", &["csv"]),
    ("opening_table", "lifts", &["csv"]),
    ("closing_table", "lifts", &["csv"]),
    ("file", "surfaces", &["csv", "stl"]),
];

/// File name extensions of formats that a job reads.
const KNOWN: [&str; 14] =
    ["yaml", "yml", "csv", "txt", "tab", "tsv", "dat", "stl", "ngc", "nc", "mpf", "spf", "tap", "cnc"];

/// Text near the beginning of every file of this program.
const SCHEMA: &str = "schema: camwright/";

/// Bytes in which that must stand.
const HEAD: u64 = 1 << 16;

/// Characters of a name that a refusal repeats.
const SHOWN: usize = 200;

/// Refuses a job and `key=value` overrides that came over ROS and lead to files that are none of the asker's business; `more` are folders that
/// the operator opened in addition.
pub fn check(job: &str, overrides: &[String], more: &[PathBuf]) -> Result<(), String> {
    let job_path = file_of("jobs", job, "yaml", None).or_else(|| file_of("lifts", job, "csv", None));
    let mut folders = roots();
    folders.extend_from_slice(more);
    if let Some(path) = job_path.as_deref().filter(|path| !is_within(path, &folders) && !says_schema(path)) {
        let shown = shown(&path.display().to_string());
        return Err(format!("job {shown:?} is not a job file: a line with {SCHEMA:?}… is missing"));
    }
    if let Some(folder) = job_path.as_deref().and_then(Path::parent) {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        folders.push(folder.to_path_buf());
        folders.extend(FILE_KEYS.iter().map(|(_, kind, _)| folder.join("..").join(kind)));
    }
    for over in overrides {
        // What is no override its reader refuses.
        let Some((key, value)) = over.split_once('=') else { continue };
        let Ok(value) = serde_saphyr::from_str::<YamlValue>(value.trim()) else { continue };
        let key = key.trim().rsplit('.').next().unwrap_or_default();
        named_files(key, &value, &mut |kind, extensions, name| {
            let found = extensions.iter().find_map(|extension| file_of(kind, name, extension, job_path.as_deref()));
            let is_allowed = match &found {
                Some(path) => is_within(path, &folders) && is_known(path),
                // Whether a file is there is not said either.
                None => !name.contains(['/', '\\']),
            };
            if is_allowed {
                return Ok(());
            }
            Err(format!(
                "override {key}={:?} names no file of a known format in the folders of the job and of params: put it there, or open its \
                 folder with the parameter file_folders of job_planner",
                shown(name)
            ))
        })?;
    }
    Ok(())
}

/// Folders of the files that overrides name, for a user of this computer.
pub fn folders_of(overrides: &[String]) -> Vec<String> {
    let mut folders = Vec::new();
    for (key, value) in overrides.iter().filter_map(|over| over.split_once('=')) {
        let Ok(value) = serde_saphyr::from_str::<YamlValue>(value.trim()) else { continue };
        let key = key.trim().rsplit('.').next().unwrap_or_default();
        let _nothing_refuses: Result<(), ()> = named_files(key, &value, &mut |kind, extensions, name| {
            let found = extensions.iter().find_map(|extension| file_of(kind, name, extension, None));
            let folder = found.and_then(|path| path.canonicalize().ok()?.parent().map(Path::to_path_buf));
            folders.extend(folder.map(|folder| folder.display().to_string()));
            Ok(())
        });
    }
    folders
}

/// Calls `check` for every file that a value names, however deep.
fn named_files<E>(
    key: &str,
    value: &YamlValue,
    check: &mut impl FnMut(&str, &[&str], &str) -> Result<(), E>,
) -> Result<(), E> {
    match value {
        YamlValue::Text(name) => match FILE_KEYS.iter().find(|(known, ..)| *known == key) {
            Some((_, kind, extensions)) => check(kind, extensions, name),
            None => Ok(()),
        },
        YamlValue::List(list) => list.iter().try_for_each(|node| named_files(key, &node.value, &mut *check)),
        YamlValue::Map(entries) => {
            entries.iter().try_for_each(|(key, node)| named_files(key, &node.value, &mut *check))
        }
        YamlValue::Null | YamlValue::Bool(_) | YamlValue::Integer(_) | YamlValue::Float(_) => Ok(()),
    }
}

/// Returns whether a file lies in one of the folders after links are resolved.
fn is_within(path: &Path, folders: &[PathBuf]) -> bool {
    let Ok(path) = path.canonicalize() else { return false };
    folders.iter().filter_map(|folder| folder.canonicalize().ok()).any(|folder| path.starts_with(folder))
}

fn is_known(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| KNOWN.contains(&extension.as_str()))
}

fn says_schema(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.is_ok() && String::from_utf8_lossy(&head).lines().any(|line| line.starts_with(SCHEMA))
}

fn shown(name: &str) -> String {
    name.chars().take(SHOWN).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Scratch(tempfile::TempDir);

    impl Scratch {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path();
            std::fs::create_dir_all(path.join("own")).unwrap();
            std::fs::create_dir_all(path.join("secret")).unwrap();
            for (name, text) in [
                ("own/job.yaml", "# mine\nschema: camwright/job/1\n"),
                ("own/flank.csv", "0,0\n"),
                ("own/hostname", "mill-7\n"),
                ("secret/flank.csv", "s3cret\n"),
                ("secret/no_job.yaml", "password: s3cret\n"),
            ] {
                std::fs::write(path.join(name), text).unwrap();
            }
            Self(folder)
        }

        fn path(&self, name: &str) -> String {
            self.0.path().join(name).display().to_string()
        }
    }

    #[test]
    fn overrides_lead_to_files_of_the_job_and_of_params_and_nowhere_else() {
        let scratch = Scratch::new();
        let job = scratch.path("own/job.yaml");
        let tried = |over: String, more: &[PathBuf]| check(&job, &[over], more);
        for allowed in
            ["profiles.a.lift.table=flank.csv", "machine=cam_grinder", "title=/etc/passwd", "program=no_such"]
        {
            assert_eq!(tried(allowed.into(), &[]), Ok(()), "{allowed}");
        }
        let secret = scratch.path("secret/flank.csv");
        for (key, _, _) in FILE_KEYS {
            let refusal = tried(format!("{key}={secret}"), &[]).expect_err(key);
            assert!(refusal.contains("file_folders") && !refusal.contains("s3cret\n"), "{refusal}");
        }
        for refused in [
            "program=/etc/hostname".to_owned(),
            "program=../../../../../../etc/hostname".into(),
            "program=../secret/flank.csv".into(),
            // In the folder of the job, but of no format that a job reads.
            format!("program={}", scratch.path("own/hostname")),
            // Whether it exists is not said.
            "program=/no/such/file".into(),
            format!("surface={{kind: grid, file: {secret}}}"),
            format!("profiles=[{{name: a, lift: {{table: {secret}}}}}]"),
        ] {
            assert!(tried(refused.clone(), &[]).is_err(), "{refused}");
        }
        let opened = [scratch.0.path().join("secret")];
        assert_eq!(tried(format!("program={secret}"), &opened), Ok(()));
        let folders = folders_of(&[format!("program={secret}"), "work_speed_rpm=3".into()]);
        assert_eq!(folders, [opened[0].canonicalize().unwrap().display().to_string()]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_leads_no_further_than_a_path() {
        let scratch = Scratch(tempfile::tempdir().unwrap());
        std::fs::write(scratch.0.path().join("job.yaml"), "schema: camwright/job/1\n").unwrap();
        std::os::unix::fs::symlink("/etc/hosts", scratch.0.path().join("x.ngc")).unwrap();
        let refusal = check(&scratch.path("job.yaml"), &["program=x.ngc".into()], &[]);
        assert!(refusal.is_err());
    }

    #[test]
    fn what_is_no_job_is_not_read_as_one() {
        let scratch = Scratch(tempfile::tempdir().unwrap());
        std::fs::write(scratch.0.path().join("x.yaml"), "password: s3cret\n").unwrap();
        let refusal = check(&scratch.path("x.yaml"), &[], &[]).expect_err("no job");
        assert!(refusal.contains("is not a job file") && !refusal.contains("s3cret"), "{refusal}");
        assert_eq!(check("four_lobe_camshaft", &[], &[]), Ok(()));
        assert_eq!(check("no_such_job", &[], &[]), Ok(()), "its reader says so");
    }
}
