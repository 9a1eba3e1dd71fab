// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The splines of a plan as messages, and back.

use super::pages::count;
use super::{m_from_mm, mm_from_m};
use camwright::math::hermite::{HermiteSpline, Knot};
use camwright::math::periodic_spline::PeriodicSpline;
use camwright::motion::plan::Plan;
use camwright_msgs::camwright_msgs::msg::{PlanHeader, PlanPage, PlanSpline};

/// Kind and values of every spline, in the order of their ids: paths, ratios, laws over time, laws over the angle.
pub(super) fn splines_to(plan: &Plan) -> Vec<(u8, Vec<f64>)> {
    let in_m = |path: &PeriodicSpline| path.coefficients().iter().map(|c| m_from_mm(*c)).collect();
    let paths = plan.paths.iter().map(|path| (PlanSpline::PERIODIC_PATH, in_m(path)));
    let ratios = plan.ratios.iter().map(|ratio| (PlanSpline::PERIODIC_RATIO, ratio.coefficients().to_vec()));
    let time_laws = plan.time_laws.iter().map(|law| (PlanSpline::TIME_LAW, quadruples(law, |rad| rad)));
    let angle_laws = plan.angle_laws.iter().map(|law| (PlanSpline::ANGLE_LAW, quadruples(law, m_from_mm)));
    paths.chain(ratios).chain(time_laws).chain(angle_laws).collect()
}

fn quadruples(law: &HermiteSpline, convert: impl Fn(f64) -> f64) -> Vec<f64> {
    law.knots()
        .iter()
        .flat_map(|knot| [knot.at, convert(knot.value), convert(knot.first), convert(knot.second)])
        .collect()
}

/// Ids of a plan's splines, from their indices in the plan.
#[derive(Debug, Clone, Copy)]
pub(super) struct SplineIds {
    ratios_at: usize,
    time_laws_at: usize,
    angle_laws_at: usize,
}

impl SplineIds {
    pub(super) fn new(plan: &Plan) -> Self {
        let ratios_at = plan.paths.len();
        let time_laws_at = ratios_at + plan.ratios.len();
        Self { ratios_at, time_laws_at, angle_laws_at: time_laws_at + plan.time_laws.len() }
    }

    pub(super) fn path(self, index: usize) -> u32 {
        count(index)
    }

    /// Id of a ratio; -1 for none.
    pub(super) fn ratio(self, index: Option<usize>) -> i32 {
        id_or_none(index.map(|index| self.ratios_at + index))
    }

    pub(super) fn time_law(self, index: usize) -> u32 {
        count(self.time_laws_at + index)
    }

    /// Id of a law over time; -1 for none.
    pub(super) fn optional_time_law(self, index: Option<usize>) -> i32 {
        id_or_none(index.map(|index| self.time_laws_at + index))
    }

    pub(super) fn angle_law(self, index: usize) -> u32 {
        count(self.angle_laws_at + index)
    }
}

fn id_or_none(id: Option<usize>) -> i32 {
    id.and_then(|id| i32::try_from(id).ok()).unwrap_or(-1)
}

/// Joins the pieces of the splines on the pages of a plan: kind and values by id.
pub(super) fn join_pieces(pages: &[PlanPage], header: &PlanHeader) -> Result<Vec<(u8, Vec<f64>)>, String> {
    let mut splines: Vec<(u8, Vec<f64>)> = Vec::new();
    for piece in pages.iter().flat_map(|page| &page.splines) {
        let id = piece.id as usize;
        if id == splines.len() && piece.offset == 0 {
            splines.push((piece.kind, piece.values.clone()));
        } else if id + 1 == splines.len() && piece.offset as usize == splines[id].1.len() && piece.kind == splines[id].0
        {
            splines[id].1.extend_from_slice(&piece.values);
        } else {
            return Err(format!("spline {id}: piece at {} is out of order", piece.offset));
        }
        if splines[id].1.len() > piece.total as usize {
            return Err(format!("spline {id}: more than its {} values", piece.total));
        }
    }
    if splines.len() != header.spline_count as usize {
        return Err(format!("{} of {} splines are here", splines.len(), header.spline_count));
    }
    Ok(splines)
}

/// Kind and index in the plan of every spline, by id.
#[derive(Debug)]
pub(super) struct SplineIndices(Vec<(u8, usize)>);

impl SplineIndices {
    /// Adds splines to a plan.
    pub(super) fn add_to(plan: &mut Plan, splines: Vec<(u8, Vec<f64>)>) -> Result<Self, String> {
        let add = |(id, (kind, values))| match add_spline(plan, kind, values) {
            Ok(index) => Ok((kind, index)),
            Err(what) => Err(format!("spline {id}: {what}")),
        };
        splines.into_iter().enumerate().map(add).collect::<Result<_, _>>().map(Self)
    }

    /// Index in the plan of the spline with an id and a kind.
    pub(super) fn find(&self, id: u32, kind: u8) -> Result<usize, String> {
        match self.0.get(id as usize) {
            Some((found, index)) if *found == kind => Ok(*index),
            _ => Err(format!("there is no spline {id} of kind {kind}")),
        }
    }
}

/// Adds a spline to a plan; returns its index there.
fn add_spline(plan: &mut Plan, kind: u8, values: Vec<f64>) -> Result<usize, String> {
    Ok(match kind {
        PlanSpline::PERIODIC_PATH => push(&mut plan.paths, periodic(values.into_iter().map(mm_from_m).collect())?),
        PlanSpline::PERIODIC_RATIO => push(&mut plan.ratios, periodic(values)?),
        PlanSpline::TIME_LAW => push(&mut plan.time_laws, hermite(&values, |rad| rad)?),
        PlanSpline::ANGLE_LAW => push(&mut plan.angle_laws, hermite(&values, mm_from_m)?),
        other => return Err(format!("its kind is {other}")),
    })
}

fn push<T>(list: &mut Vec<T>, spline: T) -> usize {
    list.push(spline);
    list.len() - 1
}

fn periodic(coefficients: Vec<f64>) -> Result<PeriodicSpline, String> {
    PeriodicSpline::from_coefficients(coefficients).map_err(|error| error.to_string())
}

fn hermite(values: &[f64], convert: fn(f64) -> f64) -> Result<HermiteSpline, String> {
    let knot = |quad: &[f64]| match *quad {
        [at, value, first, second] => {
            Ok(Knot { at, value: convert(value), first: convert(first), second: convert(second) })
        }
        _ => Err(format!("{} values are not quadruples", values.len())),
    };
    let knots = values.chunks(4).map(knot).collect::<Result<_, _>>()?;
    HermiteSpline::new(knots).map_err(|error| error.to_string())
}
