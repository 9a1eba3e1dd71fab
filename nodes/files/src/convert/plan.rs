// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plans as pages of at most 32 kB, and back.

use super::pages::{SEGMENTS_PER_PAGE, VALUES_PER_PAGE, are_complete, count, split};
pub use super::phase::{phase_from, phase_name};
use super::plan_segment::segment_to;
use super::plan_splines::{SplineIds, SplineIndices, join_pieces, splines_to};
use super::segment_reader::segment_from;
use camwright::machine::description::MachineDescription;
use camwright::motion::plan::{Half, Plan};
use camwright_msgs::camwright_msgs::msg::{PlanHeader, PlanPage, PlanSegment, PlanSpline};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use thiserror::Error;

/// Why pages do not make a plan.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlanPagesError {
    /// The content does not have the hash it claims.
    #[error("plan {claimed}: its content has the hash {found}")]
    HashMismatch {
        /// Hash on the pages.
        claimed: String,
        /// Hash of what they carry.
        found: String,
    },
    /// A page or a piece is missing or twice there.
    #[error("plan {hash}: {what}")]
    Incomplete {
        /// Hash on the pages.
        hash: String,
        what: String,
    },
    /// A value makes no sense.
    #[error("plan {hash}: {what}")]
    Invalid {
        /// Hash on the pages.
        hash: String,
        /// Which value, and why.
        what: String,
    },
}

/// Data of the header page that the plan itself lacks.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// SHA-256 of the job with everything it names.
    pub job_hash: String,
    /// Hash of the machine description the plan was made for.
    pub machine_hash: String,
}

/// A plan as pages; every page carries the plan's hash.
#[must_use]
pub fn pages_from_plan(plan: &Plan, provenance: &Provenance) -> Vec<PlanPage> {
    let splines = splines_to(plan);
    let header = PlanHeader {
        job: plan.job.clone(),
        half: plan.half as u8,
        job_hash: provenance.job_hash.clone(),
        machine_hash: provenance.machine_hash.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        lobes: plan.lobes.clone(),
        segment_count: count(plan.segments.len()),
        spline_count: count(splines.len()),
        duration: plan.duration_s,
        duration_with_indexing: plan.duration_with_indexing_s,
    };
    let ids = SplineIds::new(plan);
    let segments: Vec<PlanSegment> =
        (0..).zip(&plan.segments).map(|(index, segment)| segment_to(ids, index, segment)).collect();
    let mut pages = vec![PlanPage { header: vec![header], ..PlanPage::default() }];
    let pieces = split(&segments, SEGMENTS_PER_PAGE);
    pages.extend(pieces.map(|piece| PlanPage { segments: piece.items.to_vec(), ..PlanPage::default() }));
    for (id, (kind, values)) in (0..).zip(&splines) {
        let total = count(values.len());
        for piece in split(values, VALUES_PER_PAGE) {
            let values = piece.items.to_vec();
            add_to_pages(&mut pages, PlanSpline { id, kind: *kind, offset: count(piece.offset), total, values });
        }
    }
    let page_count = count(pages.len());
    for (page, index) in pages.iter_mut().zip(0..) {
        page.page = index;
        page.page_count = page_count;
    }
    let hash = content_hash(&pages);
    for page in &mut pages {
        page.plan_hash.clone_from(&hash);
    }
    pages
}

/// Adds a spline to the last page if it fits there, else to a page of its own.
fn add_to_pages(pages: &mut Vec<PlanPage>, spline: PlanSpline) {
    let values = |splines: &[PlanSpline]| splines.iter().map(|spline| spline.values.len()).sum::<usize>();
    let fits = |page: &&mut PlanPage| {
        !page.splines.is_empty() && values(&page.splines) + spline.values.len() <= VALUES_PER_PAGE
    };
    match pages.last_mut().filter(fits) {
        Some(page) => page.splines.push(spline),
        None => pages.push(PlanPage { splines: vec![spline], ..PlanPage::default() }),
    }
}

/// SHA-256 over the content of pages without their hashes, in page order.
fn content_hash(pages: &[PlanPage]) -> String {
    let mut hasher = Sha256::new();
    for page in pages {
        let bare = PlanPage { plan_hash: String::new(), ..page.clone() };
        // The debug form of a float is its shortest exact decimal: equal text is equal bits.
        hasher.update(format!("{bare:?}").as_bytes());
    }
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Hash of a plan if a program of another version had written it: the header names the version, and the hash covers the header.
#[must_use]
pub fn hash_with_version(pages: &[PlanPage], version: &str) -> String {
    let mut pages = pages.to_vec();
    for header in pages.iter_mut().flat_map(|page| &mut page.header) {
        version.clone_into(&mut header.version);
    }
    content_hash(&pages)
}

/// The plan that pages carry, in any order of arrival.
///
/// # Errors
/// A missing or foreign page, a content that does not have the hash it claims, values that make no plan.
pub fn plan_from_pages(pages: &[PlanPage], machine: &MachineDescription) -> Result<(Plan, PlanHeader), PlanPagesError> {
    let hash = pages.first().map(|page| page.plan_hash.clone()).unwrap_or_default();
    let incomplete = |what: String| PlanPagesError::Incomplete { hash: hash.clone(), what };
    let by_index: BTreeMap<u32, &PlanPage> = pages.iter().map(|page| (page.page, page)).collect();
    let expected = by_index.get(&0).map_or(0, |page| page.page_count);
    if expected == 0 || !are_complete(by_index.keys().copied(), expected) {
        return Err(incomplete(format!("{} of {expected} pages are here", by_index.len())));
    }
    let ordered: Vec<PlanPage> = by_index.into_values().cloned().collect();
    let found = content_hash(&ordered);
    if found != hash || ordered.iter().any(|page| page.plan_hash != hash) {
        return Err(PlanPagesError::HashMismatch { claimed: hash, found });
    }
    let header = ordered[0].header.first().cloned().ok_or_else(|| incomplete("page 0 has no header".into()))?;
    let splines = join_pieces(&ordered, &header).map_err(&incomplete)?;
    let invalid = |what: String| PlanPagesError::Invalid { hash: hash.clone(), what };
    let mut plan = Plan {
        job: header.job.clone(),
        half: match header.half {
            PlanHeader::WHOLE => Half::Whole,
            PlanHeader::FIRST => Half::First,
            PlanHeader::SECOND => Half::Second,
            PlanHeader::NO_PART => Half::NoPart,
            PlanHeader::MIDDLE => Half::Middle,
            other => return Err(invalid(format!("there is no half {other}"))),
        },
        lobes: header.lobes.clone(),
        duration_s: header.duration,
        duration_with_indexing_s: header.duration_with_indexing,
        ..Plan::default()
    };
    let splines = SplineIndices::add_to(&mut plan, splines).map_err(&invalid)?;
    for message in ordered.iter().flat_map(|page| &page.segments) {
        let segment = segment_from(message, &splines, &plan, machine)
            .map_err(|what| invalid(format!("segment {}: {what}", message.index)))?;
        plan.segments.push(segment);
    }
    if plan.segments.len() != header.segment_count as usize {
        return Err(incomplete(format!("{} of {} segments are here", plan.segments.len(), header.segment_count)));
    }
    Ok((plan, header))
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::machine::description::Axis;
    use camwright::machine::reference::cam_grinder;
    use camwright::math::hermite::{HermiteSpline, Knot};
    use camwright::motion::plan::{AxisTarget, Phase, Segment, SegmentKind, SpiralSegment};

    /// A spiral with a move before it; its laws, longer than a page.
    fn turned() -> Plan {
        let knots = |count: u32, value: f64| {
            let knot = |i: u32| Knot { at: f64::from(i), value: value + f64::from(i), first: 1.0, second: 0.0 };
            HermiteSpline::new((0..count).map(knot).collect()).expect("they increase")
        };
        let segment = |kind, label: &str| Segment {
            kind,
            phase: Phase::Cut,
            lobe: Some(0),
            label: label.into(),
            ticks: 1000,
            stop_ticks: 77,
            stock_mm: 0.5,
        };
        let limits = cam_grinder().axis(Axis::Z).limits;
        Plan {
            job: "turned".into(),
            lobes: vec!["part".into()],
            time_laws: vec![knots(2, 0.0), knots(3, 0.0)],
            angle_laws: vec![knots(2000, 32.0), knots(2, 50.0)],
            segments: vec![
                segment(SegmentKind::Move(vec![AxisTarget { axis: Axis::Z, target_counts: 5, limits }]), "move"),
                segment(
                    SegmentKind::Spiral(SpiralSegment { path: 0, advance: 1, speed: 1, start_counts: 17 }),
                    "spiral",
                ),
            ],
            duration_s: 2.0,
            ..Plan::default()
        }
    }

    #[test]
    fn a_spiral_comes_back_from_its_pages_in_any_order() {
        let plan = turned();
        let mut pages = pages_from_plan(&plan, &Provenance::default());
        assert!(pages.len() > 4, "{} pages", pages.len());
        pages.reverse();
        let (back, _) = plan_from_pages(&pages, &cam_grinder()).expect("whole");
        assert_eq!(back.segments[1], plan.segments[1]);
        for (law, other) in plan.angle_laws.iter().zip(&back.angle_laws) {
            assert_eq!(law.knots().len(), other.knots().len());
            for (knot, other) in law.knots().iter().zip(other.knots()) {
                // Through metres and back: a bit may differ.
                assert!((knot.value - other.value).abs() <= 4.0 * f64::EPSILON * knot.value, "{knot:?} {other:?}");
            }
        }
    }

    #[test]
    fn a_spiral_that_names_a_law_of_another_kind_is_refused() {
        let mut plan = turned();
        plan.segments.truncate(2);
        if let SegmentKind::Spiral(spiral) = &mut plan.segments[1].kind {
            spiral.speed = 2;
        }
        let pages = pages_from_plan(&plan, &Provenance::default());
        let error = plan_from_pages(&pages, &cam_grinder()).expect_err("law 2 is not over time");
        assert!(error.to_string().contains("there is no spline 2 of kind"), "{error}");
    }
}
