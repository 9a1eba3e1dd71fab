// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Content that travels in pages of at most 32 kB: plans, keyframes, files of a job, turned parts.

/// Bytes on a page; the other fields of the message fit into the rest of 32 kB.
pub const BYTES_PER_PAGE: usize = 32_000;
/// Values of splines on a page, of 8 B each.
pub(super) const VALUES_PER_PAGE: usize = 3500;
/// Segments of a plan on a page, of about 0.4 kB each.
pub(super) const SEGMENTS_PER_PAGE: usize = 48;
/// Radii of a turned part on a page, of 8 B each.
pub const RADII_PER_PAGE: usize = 4096;

/// Part of a content that one page carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PageContent<'a, T> {
    /// Index of the page, from 0.
    pub page: u32,
    pub page_count: u32,
    /// Index of the first item in the content.
    pub offset: usize,
    pub items: &'a [T],
}

/// Number of pages of a content.
#[must_use]
pub fn page_count(items: usize, per_page: usize) -> u32 {
    count(items.div_ceil(per_page))
}

/// Splits a content into pieces of `per_page` items; the last one may be shorter. No items make no pieces.
pub fn split<T>(items: &[T], per_page: usize) -> impl Iterator<Item = PageContent<'_, T>> {
    let page_count = page_count(items.len(), per_page);
    let pieces = items.chunks(per_page).zip(0..);
    pieces.map(move |(piece, page)| PageContent { page, page_count, offset: page as usize * per_page, items: piece })
}

/// Returns true if the indices are those of all pages, in order.
pub(super) fn are_complete(indices: impl IntoIterator<Item = u32>, page_count: u32) -> bool {
    indices.into_iter().eq(0..page_count)
}

/// A number of items as messages carry it.
pub(super) fn count(items: usize) -> u32 {
    u32::try_from(items).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_the_content_once_and_in_order() {
        for (items, pages) in [(0, 0), (1, 1), (10, 1), (11, 2), (40, 4), (41, 5)] {
            let content: Vec<usize> = (0..items).collect();
            let pieces: Vec<PageContent<'_, usize>> = split(&content, 10).collect();
            assert_eq!(pieces.iter().flat_map(|piece| piece.items.to_vec()).collect::<Vec<_>>(), content);
            assert!(are_complete(pieces.iter().map(|piece| piece.page), pages), "{items} items");
            assert!(pieces.iter().all(|piece| piece.page_count == pages && piece.offset == piece.items[0]));
        }
        assert!(!are_complete([0, 2], 2) && !are_complete([0], 2) && !are_complete([1, 0], 2));
    }
}
