// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Several passes: roughing of equal depth, then finishing.
//!
//! Depth is measured where the insert cuts: along the section's normal in the rake plane, between the parallels to the section that two
//! passes leave. In space, square to the surface, it is less wherever that leans away from the rake plane. A pass leaves its parallel but
//! for the cusps of its own feed, f²/8R higher, and for hollows that R and the stock together do not reach into, both of which the next
//! pass takes in addition. The first pass meets the bar, which is no parallel: it takes at most its depth where the stock is at least what the bar
//! stands beyond the part, as a turning job must say, and less, or nothing, elsewhere.

use super::{InsertFeed, InsertPath, InsertPathError, InsertPathKey, PathRequest};
use crate::cam::surface::Surface;
use alloc::vec::Vec;

/// Distribution of the stock over passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passes {
    /// Stock on the section before the first pass (mm).
    pub stock_mm: f64,
    /// Stock of the last pass (mm).
    pub finish_mm: f64,
    /// Most that a roughing pass takes (mm).
    pub deepest_mm: f64,
    pub rough_feed: InsertFeed,
}

/// Depth and feed of one pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassStep {
    /// Maximum depth along the section's normal in the rake plane (mm), in addition to the cusps of the previous feed.
    pub depth_mm: f64,
    /// Stock left on the section (mm).
    pub stock_mm: f64,
    pub feed: InsertFeed,
}

/// One pass and its path.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// Depth along the section's normal in the rake plane (mm).
    pub depth_mm: f64,
    /// Path of the insert's centre.
    pub path: InsertPath,
}

const MAX_PASSES: f64 = 1000.0;

/// Height of the cusps that a feed leaves between two turns (mm): R − √(R² − f²/4), where the section does not curve.
#[must_use]
pub fn cusp_mm(insert_radius_mm: f64, feed_mm: f64) -> f64 {
    let (r, half) = (insert_radius_mm, 0.5 * feed_mm);
    r - libm::sqrt((r - half) * (r + half))
}

impl Passes {
    /// Stock that every pass leaves on the section (mm), 0 after the last one: roughing passes of equal depth, no deeper than allowed, then
    /// finishing.
    ///
    /// # Errors
    /// Numbers out of range, more than 1000 passes.
    pub fn stocks_mm(&self) -> Result<Vec<f64>, InsertPathError> {
        let bad = |what, value, allowed| Err(InsertPathError::BadNumber { what, value, allowed });
        if !(self.stock_mm >= 0.0 && self.stock_mm.is_finite()) {
            return bad(InsertPathKey::Stock, self.stock_mm, "at least 0 and finite");
        }
        if !(self.finish_mm >= 0.0 && self.finish_mm <= self.stock_mm) {
            return bad(InsertPathKey::FinishingStock, self.finish_mm, "at least 0 and no more than the whole stock");
        }
        if !(self.deepest_mm > 0.0 && self.deepest_mm.is_finite()) {
            return bad(InsertPathKey::RoughingDepth, self.deepest_mm, "above 0");
        }
        let rough = self.stock_mm - self.finish_mm;
        let passes = libm::ceil(rough / self.deepest_mm - 1e-9).max(0.0);
        if passes > MAX_PASSES {
            return bad(InsertPathKey::RoughingPasses, passes, "up to 1000");
        }
        #[allow(clippy::cast_possible_truncation, reason = "it was bounded")]
        let passes = passes as u32;
        let left = |pass: u32| self.finish_mm + rough * f64::from(passes - pass) / f64::from(passes);
        let mut stocks: Vec<f64> = (1..=passes).map(left).collect();
        // Without stock for finishing the last roughing pass is the last of all.
        if stocks.is_empty() || self.finish_mm > 0.0 {
            stocks.push(0.0);
        }
        Ok(stocks)
    }

    /// All passes in their order; the last one advances by `finish`.
    ///
    /// # Errors
    /// What [`Self::stocks_mm`] says.
    pub fn steps(&self, finish: InsertFeed) -> Result<Vec<PassStep>, InsertPathError> {
        let stocks = self.stocks_mm()?;
        let last = stocks.len() - 1;
        let mut before_mm = self.stock_mm;
        let step = |(index, stock_mm)| {
            let depth_mm = before_mm - stock_mm;
            before_mm = stock_mm;
            PassStep { depth_mm, stock_mm, feed: if index == last { finish } else { self.rough_feed } }
        };
        Ok(stocks.into_iter().enumerate().map(step).collect())
    }

    /// The paths of all passes; the last one as `finish` asks for it, whose stock does not count.
    ///
    /// # Errors
    /// What [`Self::steps`] and [`InsertPath::new`] say.
    pub fn paths(&self, surface: &Surface, finish: &PathRequest) -> Result<Vec<Pass>, InsertPathError> {
        let path = |step: PassStep| {
            let PassStep { depth_mm, stock_mm, feed } = step;
            Ok(Pass { depth_mm, path: InsertPath::new(surface, &PathRequest { feed, stock_mm, ..*finish })? })
        };
        self.steps(finish.feed)?.into_iter().map(path).collect()
    }
}
