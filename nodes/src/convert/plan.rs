//! Plans as pages of at most 32 kB, and back.

use super::{core_from_si, m_from_mm, mm_from_m, si_from_core};
use camwright::machine::description::{Axis, MachineDescription, MotionLimits};
use camwright::numeric::hermite::{HermiteSpline, Knot};
use camwright::numeric::periodic_spline::PeriodicSpline;
use camwright::plan::{AxisTarget, Command, CutSegment, Half, Phase, Plan, Segment, SegmentKind, SpiralSegment};
use camwright_msgs::camwright_msgs::msg::{MachineCommand, PlanHeader, PlanPage, PlanSegment, PlanSpline};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use thiserror::Error;

/// Values of a spline on one page: 3500 · 8 B stay below 32 kB with everything around them.
const VALUES_PER_PAGE: usize = 3500;
/// Segments on one page: about 0.4 kB each.
const SEGMENTS_PER_PAGE: usize = 48;

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
        /// What is missing.
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

/// What goes on the header page besides what the plan knows itself.
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
    let splines: Vec<(u8, Vec<f64>)> = plan
        .paths
        .iter()
        .map(|path| (PlanSpline::PERIODIC_PATH, path.coefficients().iter().map(|c| m_from_mm(*c)).collect()))
        .chain(plan.ratios.iter().map(|ratio| (PlanSpline::PERIODIC_RATIO, ratio.coefficients().to_vec())))
        .chain(plan.time_laws.iter().map(|law| (PlanSpline::TIME_LAW, quadruples(law, |rad| rad))))
        .chain(plan.angle_laws.iter().map(|law| (PlanSpline::ANGLE_LAW, quadruples(law, m_from_mm))))
        .collect();
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
    let segments: Vec<PlanSegment> =
        (0..).zip(&plan.segments).map(|(index, segment)| segment_to(plan, index, segment)).collect();
    let mut pages = vec![PlanPage { header: vec![header], ..PlanPage::default() }];
    pages.extend(
        segments.chunks(SEGMENTS_PER_PAGE).map(|chunk| PlanPage { segments: chunk.to_vec(), ..PlanPage::default() }),
    );
    for (id, (kind, values)) in (0..).zip(&splines) {
        for (piece, chunk) in values.chunks(VALUES_PER_PAGE).enumerate() {
            let spline = PlanSpline {
                id,
                kind: *kind,
                offset: count(piece * VALUES_PER_PAGE),
                total: count(values.len()),
                values: chunk.to_vec(),
            };
            // Small splines share a page.
            match pages.last_mut() {
                Some(page) if !page.splines.is_empty() && page_values(page) + chunk.len() <= VALUES_PER_PAGE => {
                    page.splines.push(spline);
                }
                _ => pages.push(PlanPage { splines: vec![spline], ..PlanPage::default() }),
            }
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

fn page_values(page: &PlanPage) -> usize {
    page.splines.iter().map(|spline| spline.values.len()).sum()
}

fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

fn quadruples(law: &HermiteSpline, convert: impl Fn(f64) -> f64) -> Vec<f64> {
    law.knots()
        .iter()
        .flat_map(|knot| [knot.at, convert(knot.value), convert(knot.first), convert(knot.second)])
        .collect()
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

fn segment_to(plan: &Plan, index: u32, segment: &Segment) -> PlanSegment {
    let base = PlanSegment {
        index,
        phase: segment.phase as u8,
        lobe: segment.lobe.and_then(|lobe| i32::try_from(lobe).ok()).unwrap_or(-1),
        label: segment.label.clone(),
        ticks: segment.ticks,
        stop_ticks: segment.stop_ticks,
        stock_at_start: m_from_mm(segment.stock_mm),
        ..PlanSegment::default()
    };
    let ratios_at = plan.paths.len();
    let laws_at = ratios_at + plan.ratios.len();
    let angle_laws_at = laws_at + plan.time_laws.len();
    match &segment.kind {
        SegmentKind::Move(targets) => PlanSegment {
            kind: PlanSegment::MOVE,
            joints: targets.iter().map(|target| target.axis.joint().to_owned()).collect(),
            target_counts: targets.iter().map(|target| target.target_counts).collect(),
            velocity: targets.iter().map(|t| si_from_core(t.axis, t.limits.velocity)).collect(),
            acceleration: targets.iter().map(|t| si_from_core(t.axis, t.limits.acceleration)).collect(),
            jerk: targets.iter().map(|t| si_from_core(t.axis, t.limits.jerk)).collect(),
            ..base
        },
        SegmentKind::Search { axis, input, travel_counts, offset_counts, limits } => PlanSegment {
            kind: PlanSegment::SEARCH,
            joints: vec![axis.joint().to_owned()],
            target_counts: vec![*travel_counts, *offset_counts],
            velocity: vec![si_from_core(*axis, limits.velocity)],
            acceleration: vec![si_from_core(*axis, limits.acceleration)],
            jerk: vec![si_from_core(*axis, limits.jerk)],
            input: input.clone(),
            ..base
        },
        // No plan of a job has one; a receiver refuses it.
        SegmentKind::Home(_) => PlanSegment { kind: 0, ..base },
        SegmentKind::Cut(cut) => PlanSegment {
            kind: PlanSegment::CUT,
            path: count(cut.path),
            speed: count(laws_at + cut.speed),
            infeed: count(angle_laws_at + cut.infeed),
            ratio: cut.ratio.and_then(|ratio| i32::try_from(ratios_at + ratio).ok()).unwrap_or(-1),
            lead: cut.lead.and_then(|lead| i32::try_from(laws_at + lead).ok()).unwrap_or(-1),
            start_counts: cut.start_counts,
            path_start: cut.path_start_rad,
            turns: f64::from(cut.turns),
            infeed_turns: f64::from(cut.infeed_turns),
            plateau_start: cut.plateau_s.0,
            plateau_end: cut.plateau_s.1,
            turn_time: cut.turn_s,
            retract: m_from_mm(cut.retract_mm),
            hold: m_from_mm(cut.hold_mm),
            until_steady: cut.until_steady_n.map_or(0.0, f64::from),
            ..base
        },
        SegmentKind::Spiral(spiral) => PlanSegment {
            kind: PlanSegment::SPIRAL,
            path: count(angle_laws_at + spiral.path),
            speed: count(laws_at + spiral.speed),
            infeed: count(angle_laws_at + spiral.advance),
            start_counts: spiral.start_counts,
            ..base
        },
        SegmentKind::Dwell => PlanSegment { kind: PlanSegment::DWELL, ..base },
        SegmentKind::Wait => PlanSegment { kind: PlanSegment::WAIT, ..base },
        SegmentKind::Command(command) => PlanSegment {
            kind: PlanSegment::COMMAND,
            command: match command {
                Command::SetHome(_) => MachineCommand::SET_HOME,
                Command::WheelStart => MachineCommand::WHEEL_START,
                Command::WheelStop => MachineCommand::WHEEL_STOP,
                Command::ExpectWheel { .. } => MachineCommand::EXPECT_WHEEL,
                Command::Dress { .. } => MachineCommand::DRESS,
                Command::Push { .. } => MachineCommand::PUSH,
                Command::WatchForce { .. } => MachineCommand::WATCH_FORCE,
            },
            target: match command {
                Command::SetHome(axis) => axis.joint().to_owned(),
                _ => String::new(),
            },
            target_counts: match command {
                Command::ExpectWheel { radius_nm } | Command::Dress { radius_nm } => vec![*radius_nm],
                Command::Push { most_n } | Command::WatchForce { most_n } => vec![*most_n],
                _ => Vec::new(),
            },
            ..base
        },
    }
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
    if expected == 0 || by_index.len() != expected as usize || by_index.keys().copied().ne(0..expected) {
        return Err(incomplete(format!("{} of {expected} pages are here", by_index.len())));
    }
    let ordered: Vec<PlanPage> = by_index.into_values().cloned().collect();
    let found = content_hash(&ordered);
    if found != hash || ordered.iter().any(|page| page.plan_hash != hash) {
        return Err(PlanPagesError::HashMismatch { claimed: hash, found });
    }
    let header = ordered[0].header.first().cloned().ok_or_else(|| incomplete("page 0 has no header".into()))?;
    let splines = collect_splines(&ordered, &header).map_err(&incomplete)?;
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
    let mut place = Vec::with_capacity(splines.len());
    for (id, (kind, values)) in splines.into_iter().enumerate() {
        place.push(add_spline(&mut plan, kind, values).map_err(|what| invalid(format!("spline {id}: {what}")))?);
    }
    for message in ordered.iter().flat_map(|page| &page.segments) {
        let segment = segment_from(message, &place, &plan, machine)
            .map_err(|what| invalid(format!("segment {}: {what}", message.index)))?;
        plan.segments.push(segment);
    }
    if plan.segments.len() != header.segment_count as usize {
        return Err(incomplete(format!("{} of {} segments are here", plan.segments.len(), header.segment_count)));
    }
    Ok((plan, header))
}

fn collect_splines(pages: &[PlanPage], header: &PlanHeader) -> Result<Vec<(u8, Vec<f64>)>, String> {
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

/// Where a spline of the messages went in the plan: its kind and its index there.
type SplinePlace = (u8, usize);

fn add_spline(plan: &mut Plan, kind: u8, values: Vec<f64>) -> Result<SplinePlace, String> {
    let knots = |values: &[f64], convert: fn(f64) -> f64| -> Result<HermiteSpline, String> {
        let knots = values
            .chunks(4)
            .map(|quad| match *quad {
                [at, value, first, second] => {
                    Ok(Knot { at, value: convert(value), first: convert(first), second: convert(second) })
                }
                _ => Err(format!("{} values are not quadruples", values.len())),
            })
            .collect::<Result<_, _>>()?;
        HermiteSpline::new(knots).map_err(|error| error.to_string())
    };
    match kind {
        PlanSpline::PERIODIC_PATH => {
            let coefficients = values.into_iter().map(mm_from_m).collect();
            plan.paths.push(PeriodicSpline::from_coefficients(coefficients).map_err(|error| error.to_string())?);
            Ok((kind, plan.paths.len() - 1))
        }
        PlanSpline::PERIODIC_RATIO => {
            plan.ratios.push(PeriodicSpline::from_coefficients(values).map_err(|error| error.to_string())?);
            Ok((kind, plan.ratios.len() - 1))
        }
        PlanSpline::TIME_LAW => {
            plan.time_laws.push(knots(&values, |rad| rad)?);
            Ok((kind, plan.time_laws.len() - 1))
        }
        PlanSpline::ANGLE_LAW => {
            plan.angle_laws.push(knots(&values, mm_from_m)?);
            Ok((kind, plan.angle_laws.len() - 1))
        }
        other => Err(format!("its kind is {other}")),
    }
}

fn segment_from(
    message: &PlanSegment,
    place: &[SplinePlace],
    plan: &Plan,
    machine: &MachineDescription,
) -> Result<Segment, String> {
    let lobe = usize::try_from(message.lobe).ok();
    if let Some(lobe) = lobe.filter(|lobe| *lobe >= plan.lobes.len()) {
        return Err(format!("lobe {lobe} of {} lobes", plan.lobes.len()));
    }
    Ok(Segment {
        kind: kind_from(message, place, machine)?,
        phase: phase_from(message.phase).ok_or_else(|| format!("its phase is {}", message.phase))?,
        lobe,
        label: message.label.clone(),
        ticks: message.ticks,
        stop_ticks: message.stop_ticks,
        stock_mm: mm_from_m(finite("stock_at_start", message.stock_at_start)?),
    })
}

fn finite(name: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{name} is {value}")) }
}

/// The phase with this number.
#[must_use]
pub fn phase_from(number: u8) -> Option<Phase> {
    use Phase::{Approach, Cut, Dress, Home, Index, Position, Retract, Return, RotaryIndex, SparkOut};
    [Home, Index, Position, Approach, Cut, SparkOut, Retract, Return, RotaryIndex, Dress]
        .into_iter()
        .find(|phase| *phase as u8 == number)
}

/// A phase in the words of the shop.
#[must_use]
pub fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Home => "home",
        Phase::Index => "index",
        Phase::Position => "position",
        Phase::Approach => "approach",
        Phase::Cut => "cut",
        Phase::SparkOut => "spark-out",
        Phase::Retract => "retract",
        Phase::Return => "return",
        Phase::RotaryIndex => "rotary index",
        Phase::Dress => "dress",
    }
}

fn kind_from(
    message: &PlanSegment,
    place: &[SplinePlace],
    machine: &MachineDescription,
) -> Result<SegmentKind, String> {
    let axis = |index: usize| -> Result<Axis, String> {
        let joint = message.joints.get(index).ok_or("joints are missing")?;
        Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?}"))
    };
    let limits = |index: usize, axis: Axis| -> Result<MotionLimits, String> {
        let own = machine.axis(axis).limits;
        let value = |name: &str, values: &[f64], most: f64| {
            let value = *values.get(index).ok_or_else(|| format!("{name} of {} is missing", axis.joint()))?;
            let value = core_from_si(axis, value);
            // The way through metres may cost the last bit.
            if value > 0.0 && value <= most * (1.0 + 1e-12) {
                Ok(value.min(most))
            } else {
                Err(format!("{name} of {} is {value}, the machine allows {most}", axis.joint()))
            }
        };
        Ok(MotionLimits {
            velocity: value("velocity", &message.velocity, own.velocity)?,
            acceleration: value("acceleration", &message.acceleration, own.acceleration)?,
            jerk: value("jerk", &message.jerk, own.jerk)?,
        })
    };
    let target = |index: usize| message.target_counts.get(index).copied().ok_or("target_counts are missing");
    let spline = |id: u32, kind: u8| match place.get(id as usize) {
        Some((found, index)) if *found == kind => Ok(*index),
        _ => Err(format!("there is no spline {id} of kind {kind}")),
    };
    match message.kind {
        PlanSegment::MOVE => (0..message.joints.len())
            .map(|index| {
                let axis = axis(index)?;
                Ok(AxisTarget { axis, target_counts: target(index)?, limits: limits(index, axis)? })
            })
            .collect::<Result<_, String>>()
            .map(SegmentKind::Move),
        PlanSegment::SEARCH => {
            let axis = axis(0)?;
            Ok(SegmentKind::Search {
                axis,
                input: message.input.clone(),
                travel_counts: target(0)?,
                offset_counts: target(1)?,
                limits: limits(0, axis)?,
            })
        }
        PlanSegment::CUT => Ok(SegmentKind::Cut(CutSegment {
            path: spline(message.path, PlanSpline::PERIODIC_PATH)?,
            speed: spline(message.speed, PlanSpline::TIME_LAW)?,
            infeed: spline(message.infeed, PlanSpline::ANGLE_LAW)?,
            ratio: match u32::try_from(message.ratio) {
                Ok(ratio) => Some(spline(ratio, PlanSpline::PERIODIC_RATIO)?),
                Err(_) => None,
            },
            lead: match u32::try_from(message.lead) {
                Ok(lead) => Some(spline(lead, PlanSpline::TIME_LAW)?),
                Err(_) => None,
            },
            start_counts: message.start_counts,
            path_start_rad: finite("path_start", message.path_start)?,
            turns: whole("turns", message.turns)?,
            infeed_turns: whole("infeed_turns", message.infeed_turns)?,
            plateau_s: (finite("plateau_start", message.plateau_start)?, finite("plateau_end", message.plateau_end)?),
            turn_s: finite("turn_time", message.turn_time)?,
            retract_mm: mm_from_m(finite("retract", message.retract)?),
            hold_mm: mm_from_m(finite("hold", message.hold)?),
            until_steady_n: Some(whole("until_steady", message.until_steady)?).filter(|most_n| *most_n > 0),
        })),
        PlanSegment::SPIRAL => Ok(SegmentKind::Spiral(SpiralSegment {
            path: spline(message.path, PlanSpline::ANGLE_LAW)?,
            advance: spline(message.infeed, PlanSpline::ANGLE_LAW)?,
            speed: spline(message.speed, PlanSpline::TIME_LAW)?,
            start_counts: message.start_counts,
        })),
        PlanSegment::DWELL => Ok(SegmentKind::Dwell),
        PlanSegment::WAIT => Ok(SegmentKind::Wait),
        PlanSegment::COMMAND => match message.command {
            MachineCommand::SET_HOME => Axis::from_joint(&message.target)
                .map(|axis| SegmentKind::Command(Command::SetHome(axis)))
                .ok_or_else(|| format!("there is no joint {:?} to home", message.target)),
            MachineCommand::WHEEL_START => Ok(SegmentKind::Command(Command::WheelStart)),
            MachineCommand::WHEEL_STOP => Ok(SegmentKind::Command(Command::WheelStop)),
            MachineCommand::EXPECT_WHEEL => {
                Ok(SegmentKind::Command(Command::ExpectWheel { radius_nm: radius_nm(target(0)?)? }))
            }
            MachineCommand::DRESS => Ok(SegmentKind::Command(Command::Dress { radius_nm: radius_nm(target(0)?)? })),
            MachineCommand::PUSH => Ok(SegmentKind::Command(Command::Push { most_n: force_n(target(0)?)? })),
            MachineCommand::WATCH_FORCE => {
                Ok(SegmentKind::Command(Command::WatchForce { most_n: force_n(target(0)?)? }))
            }
            other => Err(format!("its command is {other}")),
        },
        other => Err(format!("its kind is {other}")),
    }
}

/// A force of up to 100 kN: what is larger was not meant.
fn force_n(most_n: i64) -> Result<i64, String> {
    if (0..=100_000).contains(&most_n) { Ok(most_n) } else { Err(format!("its force is {most_n} N")) }
}

/// A wheel of up to 10 m: what is larger was not meant.
fn radius_nm(radius_nm: i64) -> Result<i64, String> {
    if (1..=10_000_000_000).contains(&radius_nm) {
        Ok(radius_nm)
    } else {
        Err(format!("its wheel has a radius of {radius_nm} nm"))
    }
}

fn whole(name: &str, value: f64) -> Result<u32, String> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be whole and in range")]
    if value.fract().abs() < f64::EPSILON && (0.0..=1e9).contains(&value) {
        Ok(value as u32)
    } else {
        Err(format!("{name} is {value}, not a whole number"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright::machine::reference::cam_grinder;

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
