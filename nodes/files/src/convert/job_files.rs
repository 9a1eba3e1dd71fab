// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The files that a job names as pages of at most 32 kB, and back.

use super::pages::{BYTES_PER_PAGE, are_complete, page_count, split};
use crate::recorded_files::NamedFile;
use camwright_msgs::camwright_msgs::msg::JobFilePage;

/// Maximum number of pages of all files of a job: so many stay latched.
pub const MAX_PAGES: u32 = 1024;

/// The files of a job as pages. A file beyond [`MAX_PAGES`] is listed without its content.
#[must_use]
pub fn pages_from_files(job_hash: &str, files: &[NamedFile]) -> Vec<JobFilePage> {
    let mut pages: Vec<JobFilePage> = Vec::new();
    // Every file has at least one page.
    let mut left = (MAX_PAGES as usize).saturating_sub(files.len());
    for file in files {
        let head = JobFilePage {
            job_hash: job_hash.to_owned(),
            kind: file.kind.clone(),
            name: file.name.clone(),
            size: file.bytes.len() as u64,
            ..JobFilePage::default()
        };
        let own = page_count(file.bytes.len(), BYTES_PER_PAGE).max(1);
        let Some(remaining) = left.checked_sub(own as usize - 1) else {
            pages.push(head);
            continue;
        };
        left = remaining;
        let head = JobFilePage { page_count: own, ..head };
        if file.bytes.is_empty() {
            pages.push(head);
            continue;
        }
        pages.extend(split(&file.bytes, BYTES_PER_PAGE).map(|piece| JobFilePage {
            page: piece.page,
            data: piece.items.to_vec(),
            ..head.clone()
        }));
    }
    pages
}

/// The complete files of a job, from pages in any order.
#[must_use]
pub fn files_from_pages<'a>(job_hash: &str, pages: impl IntoIterator<Item = &'a JobFilePage>) -> Vec<NamedFile> {
    let mut own: Vec<&JobFilePage> = pages.into_iter().filter(|page| page.job_hash == job_hash).collect();
    own.sort_by(|a, b| (&a.kind, &a.name, a.page).cmp(&(&b.kind, &b.name, b.page)));
    own.dedup_by(|a, b| (&a.kind, &a.name, a.page) == (&b.kind, &b.name, b.page));
    let same_file = |a: &&JobFilePage, b: &&JobFilePage| (&a.kind, &a.name) == (&b.kind, &b.name);
    let whole = own.chunk_by(same_file).filter(|pages| {
        let bytes: usize = pages.iter().map(|page| page.data.len()).sum();
        are_complete(pages.iter().map(|page| page.page), pages[0].page_count) && bytes as u64 == pages[0].size
    });
    whole
        .map(|pages| NamedFile {
            kind: pages[0].kind.clone(),
            name: pages[0].name.clone(),
            bytes: pages.iter().flat_map(|page| page.data.iter().copied()).collect(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, size: usize) -> NamedFile {
        let bytes = (0..size).map(|at| u8::try_from(at % 251).unwrap()).collect();
        NamedFile { kind: "lifts".into(), name: name.into(), bytes }
    }

    #[test]
    fn files_come_back_from_their_pages_in_any_order() {
        let files = [file("a.csv", 0), file("b.csv", BYTES_PER_PAGE), file("c.csv", 3 * BYTES_PER_PAGE + 1)];
        let mut pages = pages_from_files("hash", &files);
        assert_eq!(pages.len(), 1 + 1 + 4);
        pages.reverse();
        pages.push(pages[0].clone());
        pages.push(JobFilePage { job_hash: "of another job".into(), ..pages[1].clone() });
        assert_eq!(files_from_pages("hash", &pages), files);
        // What lacks a page, or has one of another length, is none.
        pages.retain(|page| page.name != "c.csv" || page.page != 2);
        assert_eq!(files_from_pages("hash", &pages), files[..2]);
        pages.iter_mut().for_each(|page| page.data.truncate(7));
        assert_eq!(files_from_pages("hash", &pages), files[..1]);
    }

    #[test]
    fn too_large_files_are_recorded_without_content_and_the_others_whole() {
        let files =
            [file("small.csv", 10), file("large.stl", MAX_PAGES as usize * BYTES_PER_PAGE), file("b.csv", 40_000)];
        let pages = pages_from_files("hash", &files);
        assert!(pages.len() <= MAX_PAGES as usize);
        let large = pages.iter().find(|page| page.name == "large.stl").unwrap();
        assert_eq!((large.page_count, large.size), (0, files[1].bytes.len() as u64));
        assert_eq!(files_from_pages("hash", &pages), [files[2].clone(), files[0].clone()]);
    }
}
