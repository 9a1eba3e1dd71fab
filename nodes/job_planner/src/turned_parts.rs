// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The part in a lathe, as the machine last reported it page by page.

use super::{lock, wait_for};
use camwright::simulation::turned_part::{MAX_CELLS, PartGrid, TurnedPart, TurnedPartError};
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::msg::TurnedPage;
use std::sync::{Condvar, Mutex};
use std::time::Duration;
use thiserror::Error;

/// Why there is no finished part.
#[derive(Debug, Clone, PartialEq, Error)]
pub(crate) enum TurnedPartMissing {
    #[error("the machine did not report the finished part {name}")]
    Missing { name: String },
    /// It arrived in part.
    #[error("of the finished part {name} {missing} of {pages} pages have not arrived")]
    Pages {
        name: String,
        /// Pages that are missing.
        missing: usize,
        pages: usize,
    },
    /// The received part is invalid.
    #[error(transparent)]
    Part(#[from] TurnedPartError),
}

/// The newest state of the part.
#[derive(Debug, Default)]
pub(crate) struct TurnedParts {
    newest: Mutex<Option<PartPages>>,
    changed: Condvar,
}

/// Pages of one state of a part.
#[derive(Debug)]
struct PartPages {
    name: String,
    tick: u64,
    finished: bool,
    grid: PartGrid,
    radii_mm: Vec<f64>,
    /// Which pages have come.
    pages: Vec<bool>,
}

impl PartPages {
    /// Room for the state that a page is of; none where it cannot be a page of any part.
    fn begun_by(page: &TurnedPage) -> Option<Self> {
        let size = |count: u32| usize::try_from(count).unwrap_or(usize::MAX);
        let (azimuths, columns, pages) = (size(page.azimuths), size(page.columns), size(page.pages));
        let cells = azimuths.checked_mul(columns).filter(|cells| (1..=MAX_CELLS).contains(cells))?;
        (1..=cells).contains(&pages).then(|| Self {
            name: page.name.clone(),
            tick: page.tick,
            finished: page.finished,
            grid: PartGrid { azimuths, columns, from_mm: mm_from_m(page.from_z), to_mm: mm_from_m(page.to_z) },
            radii_mm: vec![0.0; cells],
            pages: vec![false; pages],
        })
    }

    /// Puts a page into its place; what does not fit there is omitted, and the page stays missing.
    fn add_page(&mut self, page: &TurnedPage) {
        let place = usize::try_from(page.first).ok().and_then(|first| self.radii_mm.get_mut(first..));
        let place = place.and_then(|rest| rest.get_mut(..page.radius.len()));
        let came = usize::try_from(page.page).ok().and_then(|page| self.pages.get_mut(page));
        if let (Some(place), Some(came)) = (place, came) {
            place.iter_mut().zip(&page.radius).for_each(|(place, radius)| *place = mm_from_m(*radius));
            *came = true;
        }
    }

    fn missing(&self) -> usize {
        self.pages.iter().filter(|came| !**came).count()
    }
}

impl TurnedParts {
    /// Takes a page; those of an older state than the newest are late and count no more.
    pub(crate) fn receive_page(&self, page: &TurnedPage) {
        let mut newest = lock(&self.newest);
        let is_of = |state: &PartPages| state.tick == page.tick && state.name == page.name;
        if !newest.as_ref().is_some_and(is_of) {
            if newest.as_ref().is_some_and(|state| state.name == page.name && state.tick > page.tick) {
                return;
            }
            let Some(begun) = PartPages::begun_by(page) else { return };
            *newest = Some(begun);
        }
        if let Some(state) = newest.as_mut() {
            state.add_page(page);
        }
        drop(newest);
        self.changed.notify_all();
    }

    pub(crate) fn clear(&self) {
        *lock(&self.newest) = None;
    }

    /// Waits until all pages of a part that was finished at or after a tick are there.
    pub(crate) fn wait_finished(
        &self,
        name: &str,
        since_tick: u64,
        timeout: Duration,
    ) -> Result<TurnedPart, TurnedPartMissing> {
        let named = || name.to_owned();
        let (grid, radii_mm) = wait_for(&self.newest, &self.changed, timeout, |newest| match newest {
            Some(state) if state.name == name && state.finished && state.tick >= since_tick => match state.missing() {
                0 => Ok((state.grid, state.radii_mm.clone())),
                missing => Err(TurnedPartMissing::Pages { name: named(), missing, pages: state.pages.len() }),
            },
            _ => Err(TurnedPartMissing::Missing { name: named() }),
        })?;
        Ok(TurnedPart::new(named(), grid, radii_mm)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Page `page` of three, of a part of 20 azimuths and 3 columns, 20 mm in radius.
    fn page(tick: u64, page: u32) -> TurnedPage {
        TurnedPage {
            name: "cam".into(),
            tick,
            finished: true,
            azimuths: 20,
            columns: 3,
            to_z: 0.002,
            page,
            pages: 3,
            first: u64::from(page) * 20,
            radius: vec![0.02 + f64::from(page) * 0.001; 20],
            ..TurnedPage::default()
        }
    }

    fn wait(parts: &TurnedParts, since: u64) -> Result<TurnedPart, TurnedPartMissing> {
        parts.wait_finished("cam", since, Duration::from_millis(1))
    }

    #[test]
    fn a_part_is_there_when_all_its_pages_are_in_any_order() {
        let parts = TurnedParts::default();
        assert_eq!(wait(&parts, 0), Err(TurnedPartMissing::Missing { name: "cam".into() }));
        parts.receive_page(&page(100, 2));
        parts.receive_page(&page(100, 0));
        assert_eq!(wait(&parts, 0), Err(TurnedPartMissing::Pages { name: "cam".into(), missing: 1, pages: 3 }));
        parts.receive_page(&page(100, 1));
        let part = wait(&parts, 0).expect("it is whole");
        assert!((part.radius_mm(19, 1) - 21.0).abs() < 1e-12 && (part.grid().to_mm - 2.0).abs() < 1e-12);
        assert!(wait(&parts, 101).is_err(), "that was the part before");
        parts.clear();
        assert!(wait(&parts, 0).is_err());
    }

    #[test]
    fn pages_of_an_older_state_do_not_disturb_the_newest() {
        let parts = TurnedParts::default();
        (0..3).for_each(|number| parts.receive_page(&page(200, number)));
        parts.receive_page(&page(100, 0));
        assert!(wait(&parts, 150).is_ok());
        parts.receive_page(&page(300, 0));
        assert!(matches!(wait(&parts, 150), Err(TurnedPartMissing::Pages { missing: 2, .. })));
    }

    #[test]
    fn pages_that_cannot_be_are_left_out_before_memory_is_taken() {
        let parts = TurnedParts::default();
        for wrong in [
            TurnedPage { azimuths: u32::MAX, columns: u32::MAX, ..page(100, 0) },
            TurnedPage { azimuths: 0, ..page(100, 0) },
            TurnedPage { pages: 0, ..page(100, 0) },
            TurnedPage { pages: u32::MAX, ..page(100, 0) },
        ] {
            parts.receive_page(&wrong);
            assert_eq!(wait(&parts, 0), Err(TurnedPartMissing::Missing { name: "cam".into() }));
        }
        for wrong in [
            TurnedPage { first: u64::MAX, ..page(100, 0) },
            TurnedPage { radius: vec![0.02; 61], ..page(100, 0) },
            TurnedPage { page: 3, ..page(100, 0) },
        ] {
            parts.receive_page(&wrong);
            assert!(matches!(wait(&parts, 0), Err(TurnedPartMissing::Pages { missing: 3, .. })));
        }
        let flat = TurnedPage { radius: vec![-0.02; 20], ..page(300, 0) };
        [flat, page(300, 1), page(300, 2)].iter().for_each(|page| parts.receive_page(page));
        assert!(matches!(wait(&parts, 0), Err(TurnedPartMissing::Part(_))));
    }
}
