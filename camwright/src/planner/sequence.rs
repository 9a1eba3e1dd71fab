// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The steps of a part, one after the other, with the time each is predicted to take.

use super::PlanStart;
use super::error::PlanError;
use super::error::RequiredPosition;
use super::lobe::{LobeStart, PlannedLobe, WheelShape, soft_limit};
use super::steps::{PlanSteps, StepSubject, shared};
use crate::job::dressing::{WheelCourse, WheelMount};
use crate::job::grinding::Subject;
use crate::job::grinding::{JobSpec, LobeSpec};
use crate::job::plunges;
use crate::machine::description::{Axis, MachineDescription, Station};
use crate::machine::wheel_state::nm_from_mm;
use crate::math::hermite::HermiteSpline;
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{CutSegment, GaugeSize, Half, Phase, Plan, PlanCommand, SegmentKind};
use crate::motion::point_to_point::whole_ticks;
use crate::motion::speed_plan::{FixedPathSpeed, SpeedPlan};
use crate::planner::deflection::{GaugedSize, GroundLobe};
use alloc::string::String;

/// Distance of the table before a station's switch at the start of the search (mm), and the limit of the search beyond the switch.
/// It covers a shifted switch and lets the table reach its search speed; a longer distance costs time at the slow search speed.
pub(super) const RUN_IN_MM: f64 = 5.0;

/// A plan in the making.
pub(super) struct Sequence<'a> {
    pub(super) job: &'a JobSpec,
    start: PlanStart,
    pub(super) steps: PlanSteps<'a>,
    /// Last force threshold sent to the monitor (N).
    watched_n: i64,
    /// The infeed of a cut ends at a size on the gauge.
    watches_size: bool,
    /// Position of the mounted wheel in the changer.
    pub(super) wheel: usize,
}

impl<'a> Sequence<'a> {
    pub(super) fn new(
        job: &'a JobSpec,
        machine: &'a MachineDescription,
        shapes: &[WheelShape],
        start: PlanStart,
    ) -> Self {
        let plan = Plan {
            job: job.name.clone(),
            lobes: job.lobes.iter().map(|lobe| lobe.name.clone()).collect(),
            paths: shapes.iter().map(|shape| shape.path.clone()).collect(),
            ratios: shapes.iter().filter_map(|shape| shape.ratio.clone()).collect(),
            ..Plan::default()
        };
        let steps = PlanSteps { machine, at: start.counts, ticks: 0, plan };
        Self { job, start, steps, watched_n: 0, watches_size: false, wheel: machine.mounted_wheel() }
    }

    /// Wheel clear of the part, C on its origin, the first wheel of the job mounted if it names one, wheel up to speed.
    pub(super) fn prepare(&mut self, first: Option<&WheelMount>) -> Result<(), PlanError> {
        let of = StepSubject::part(Phase::Home);
        self.steps.move_axis(
            of,
            Axis::X,
            self.steps.counts(Axis::X, self.job.home.x_mm),
            None,
            "wheel clear of the part",
        )?;
        self.steps.home_headstock(of, self.start.c_homed)?;
        match first {
            // Whichever wheel is mounted: the plan does not depend on it.
            Some(mount) => self.mount(mount, self.steps.machine.longest_spin_up_s()),
            None => self.steps.start_wheel(of),
        }
        Ok(())
    }

    /// Mounts a wheel if the job does so before this lobe.
    pub(super) fn change_wheel(&mut self, index: usize, course: &WheelCourse) -> Result<(), PlanError> {
        // The first one is mounted before the wheel starts for the first time.
        let Some(mount) = course.mounts.iter().skip(1).find(|mount| mount.before_lobe == index) else { return Ok(()) };
        let of = StepSubject::part(Phase::WheelChange);
        let clear = self.steps.counts(Axis::X, self.job.home.x_mm);
        self.steps.move_axis(of, Axis::X, clear, None, "wheel clear of the part")?;
        self.mount(mount, self.steps.machine.wheel_at(self.wheel).spin_up_s);
        Ok(())
    }

    /// The wheel to rest, which takes `stop_s` (s), another one in its place, and that up to speed, with X clear of the part.
    fn mount(&mut self, mount: &WheelMount, stop_s: f64) {
        let of = StepSubject::part(Phase::WheelChange);
        let machine = self.steps.machine;
        let cycle_s = machine.cycle_time_s();
        let name = machine.wheel_name(mount.wheel).unwrap_or_default();
        self.steps.command(of, PlanCommand::WheelStop, "wheel stop");
        self.steps.add(of, SegmentKind::Dwell, whole_ticks(stop_s, cycle_s), 0, "wheel to rest");
        let label = alloc::format!("change to wheel {name}");
        #[allow(clippy::cast_possible_truncation, reason = "a changer has a few wheels")]
        let wheel = mount.wheel as u32;
        self.steps.command(of, PlanCommand::ChangeWheel { wheel }, &label);
        let change_s = machine.wheel_changer.as_ref().map_or(0.0, |changer| changer.change_s);
        self.steps.add(of, SegmentKind::Dwell, whole_ticks(change_s, cycle_s), 0, &label);
        let label = alloc::format!("wheel {name} of radius {:.4} mm", mount.radius_mm);
        let radius_nm = nm_from_mm(mount.radius_mm);
        self.steps.command(of, PlanCommand::ExpectWheel { radius_nm }, &label);
        self.steps.start_wheel_in(of, machine.wheel_at(mount.wheel).spin_up_s);
        self.wheel = mount.wheel;
    }

    /// The table to the station of a lobe.
    pub(super) fn index_to(&mut self, index: usize) -> Result<(), PlanError> {
        let lobe = &self.job.lobes[index];
        let stock_mm = self.job.stock_of_mm(index);
        let of = StepSubject { phase: Phase::Index, lobe: Some((index, &lobe.name)), stock_mm };
        match self.steps.machine.station(&lobe.station) {
            Some(station) => self.index_table(of, lobe, station),
            None => Ok(()),
        }
    }

    /// X to where it stands between the lobes (mm), if it has been elsewhere.
    pub(super) fn stand_clear(&mut self, index: usize, x_mm: f64) -> Result<(), PlanError> {
        let target_counts = self.steps.counts(Axis::X, x_mm);
        if self.steps.at[Axis::X.index()] == target_counts {
            return Ok(());
        }
        let name = self.job.lobes[index].name.as_str();
        let of = StepSubject { phase: Phase::Position, lobe: Some((index, name)), stock_mm: self.job.stock_mm };
        self.steps.move_axis(of, Axis::X, target_counts, None, "wheel to just clear of the lobes")
    }

    /// C to where a lobe begins (counts), the conventional way.
    pub(super) fn turn_to_lobe(&mut self, index: usize, c_counts: i64) -> Result<(), PlanError> {
        let name = self.job.lobes[index].name.as_str();
        let of = StepSubject { phase: Phase::RotaryIndex, lobe: Some((index, name)), stock_mm: self.job.stock_mm };
        self.steps.move_axis(of, Axis::C, c_counts, None, "part to the lobe's cam angle 0")
    }

    /// One lobe at its station, from where C stands, or comes turning and meets its phase after a while (ticks), to the wheel clear
    /// of the part.
    pub(super) fn grind(
        &mut self,
        index: usize,
        lobe: &PlannedLobe,
        begin: LobeStart,
        waits_ticks: u64,
    ) -> Result<(), PlanError> {
        let name = lobe.design.name.as_str();
        let of = |phase: Phase, stock_mm: f64| StepSubject { phase, lobe: Some((index, name)), stock_mm };
        let stock_mm = self.job.stock_of_mm(index);
        let rapid = Some(self.job.rapid_speed_mm_s);
        let mut retracted = self.steps.at[Axis::X.index()];
        let mut goes_turning = false;
        // Passes that would be cut in the air are omitted from the first on.
        let specs = self.job.passes_of(index);
        let specs = &specs[specs.len() - lobe.passes.len()..];
        let finishes = lobe.design.is_finished();
        for (number, pass) in lobe.passes.iter().enumerate() {
            let until_steady_n = specs[number].spark_out_until_n;
            let cut = CutSegment { until_steady_n, ..self.cut_segment(lobe.path, pass, begin) };
            if let Some(max_n) = until_steady_n.map(i64::from).filter(|max_n| *max_n != self.watched_n) {
                let label = alloc::format!("force monitor to {max_n} N");
                self.steps.command(of(Phase::Position, stock_mm), PlanCommand::WatchForce { max_n }, &label);
                self.watched_n = max_n;
            }
            let size = self.job.size_control().filter(|_| finishes && number + 1 == lobe.passes.len());
            if let Some(size) = size {
                let diameter_mm = 2.0 * lobe.design.contour.radius_at(0.0) + size.ends_above_mm;
                let size = GaugeSize { diameter_nm: nm_from_mm(diameter_mm), beyond_nm: nm_from_mm(size.beyond_mm) };
                let label = alloc::format!("gauge to {diameter_mm:.4} mm");
                self.steps.command(of(Phase::Position, stock_mm), PlanCommand::WatchSize(size), &label);
                self.watches_size = true;
            }
            // The same arithmetic as in the cut, so that the wheel stands where the cut begins to the count.
            let motion = self.steps.plan.motion_of(&cut).expect("its splines have just been put into the plan");
            let first = self.steps.counts(Axis::X, motion.x_mm(motion.start_s()));
            let last = self.steps.counts(Axis::X, motion.x_mm(motion.end_s()));
            let comes_turning = motion.end_speeds_rad_s().0 > 0.0;
            goes_turning = motion.end_speeds_rad_s().1 > 0.0;
            let change_s = self.steps.machine.cycle_time_s() * pass.stop_ticks() as f64;
            let added_s = match &cut.variation {
                Some(variation) if variation.period_turns * cut.turn_s < 2.0 * change_s => {
                    let (lobe, pass) = (String::from(name), specs[number].name.clone());
                    return Err(PlanError::VariationTooFast {
                        lobe,
                        pass,
                        shortest_turns: 2.0 * change_s / cut.turn_s,
                    });
                }
                Some(variation) => motion.time_added_by(variation, cut.plateau_s, change_s),
                None => 0.0,
            };
            if number == 0 && !comes_turning {
                retracted = first + self.steps.counts(Axis::X, self.job.rapid_advance_mm);
                let label = "wheel corrected by the lift";
                self.steps.move_axis(of(Phase::Position, stock_mm), Axis::X, retracted, None, label)?;
                self.steps.move_axis(of(Phase::Approach, stock_mm), Axis::X, first, rapid, "rapid advance")?;
            } else if number > 0 && self.steps.at[Axis::X.index()] != first {
                // A rounding apart: a count at most.
                self.steps.move_axis(of(Phase::Approach, stock_mm), Axis::X, first, rapid, "to the next pass")?;
            }
            let mut label =
                alloc::format!("{} turns with infeed, {} without", cut.infeed_turns, cut.turns - cut.infeed_turns);
            if let Some(max_n) = until_steady_n {
                label += &alloc::format!(" or until the force is steady within {max_n} N");
            }
            if size.is_some() {
                label += ", infeed until the gauge reads the size";
            }
            if comes_turning || goes_turning {
                label += ", c_axis turning on";
            }
            if let Some(variation) = cut.variation {
                label += &alloc::format!(
                    ", work speed {:.0} % lower in half of every {} turns",
                    100.0 * variation.slower,
                    variation.period_turns
                );
            }
            if lobe.passes.len() > 1 {
                label = alloc::format!("{}, {label}", specs[number].name);
            }
            let length_s = pass.law().end() - pass.law().start();
            let waits = if number == 0 { waits_ticks } else { 0 };
            let cycle_s = self.steps.machine.cycle_time_s();
            let ticks = waits + whole_ticks(length_s + added_s, cycle_s);
            let turn_counts = self.steps.machine.axis(Axis::C).scale.counts(TURN_RAD);
            if comes_turning {
                self.steps.at[Axis::C.index()] = begin.c_counts;
            }
            self.steps.at[Axis::C.index()] += i64::from(cut.turns) * turn_counts;
            self.steps.at[Axis::X.index()] = last;
            let schedule = pass.infeed().schedule();
            let left_mm = stock_mm.min(schedule.left_mm() + schedule.total_mm());
            self.steps.add(of(Phase::Cut, left_mm), SegmentKind::Cut(cut), ticks, pass.stop_ticks(), &label);
        }
        if goes_turning {
            return Ok(());
        }
        self.steps.move_axis(of(Phase::Retract, 0.0), Axis::X, retracted, rapid, "rapid retract")
    }

    /// Predicted ticks of the steps so far.
    pub(super) const fn ticks(&self) -> u64 {
        self.steps.ticks
    }

    /// A turn of a journal under the gauge, with the wheel where it is clear of everything; C at its end (rad).
    pub(super) fn gauge(&mut self, index: usize, speed_rad_s: f64) -> Result<f64, PlanError> {
        let of = StepSubject::lobe(Phase::Position, index, &self.job.lobes[index].name);
        let scale = self.steps.machine.axis(Axis::C).scale;
        let turned = self.steps.at[Axis::C.index()] + scale.counts(TURN_RAD);
        self.steps.move_axis(of, Axis::C, turned, Some(speed_rad_s), "one turn under the gauge")?;
        Ok(scale.position(turned))
    }

    /// A turn that corrects a journal: `cut` but for what is shared with the plan.
    pub(super) fn correct(
        &mut self,
        index: usize,
        name: &str,
        cut: CutSegment,
        path: PeriodicSpline,
        speed: &FixedPathSpeed,
        offset: HermiteSpline,
    ) -> Result<(), PlanError> {
        let of = |phase: Phase| StepSubject { phase, lobe: Some((index, name)), stock_mm: 0.0 };
        let turn_counts = self.steps.machine.axis(Axis::C).scale.counts(TURN_RAD);
        self.steps.plan.paths.push(path);
        let cut = CutSegment {
            speed: shared(&mut self.steps.plan.time_laws, &speed.law),
            infeed: shared(&mut self.steps.plan.angle_laws, &offset),
            start_counts: self.steps.at[Axis::C.index()].rem_euclid(turn_counts),
            ..cut
        };
        let motion = self.steps.plan.motion_of(&cut).expect("its splines have just been put into the plan");
        let (first, last) = (motion.x_mm(motion.start_s()), motion.x_mm(motion.end_s()));
        let (first, last) = (self.steps.counts(Axis::X, first), self.steps.counts(Axis::X, last));
        let rapid = Some(self.job.rapid_speed_mm_s);
        self.steps.move_axis(of(Phase::Approach), Axis::X, first, rapid, "rapid advance to just clear of it")?;
        let ticks = whole_ticks(speed.law.end(), self.steps.machine.cycle_time_s());
        self.steps.at[Axis::C.index()] += i64::from(cut.turns) * turn_counts;
        self.steps.at[Axis::X.index()] = last;
        self.steps.add(
            of(Phase::Cut),
            SegmentKind::Cut(cut),
            ticks,
            speed.stop_ticks,
            "one turn that corrects its runout",
        );
        let home = self.steps.counts(Axis::X, self.job.home.x_mm);
        self.steps.move_axis(of(Phase::Retract), Axis::X, home, rapid, "rapid retract")
    }

    /// X to its home position and no more: the wheel runs on and the table stays, for the plan that follows.
    pub(super) fn stand_by(mut self) -> Result<Plan, PlanError> {
        let of = StepSubject::part(Phase::Return);
        self.steps.move_axis(
            of,
            Axis::X,
            self.steps.counts(Axis::X, self.job.home.x_mm),
            None,
            "wheel clear of the part",
        )?;
        self.steps.plan.half = Half::First;
        Ok(self.done())
    }

    /// Wheel clear of the part, and up to speed.
    pub(super) fn clear_and_run(&mut self) -> Result<(), PlanError> {
        let of = StepSubject::part(Phase::Dress);
        self.steps.move_axis(
            of,
            Axis::X,
            self.steps.counts(Axis::X, self.job.home.x_mm),
            None,
            "wheel clear of the part",
        )?;
        self.steps.start_wheel(of);
        Ok(())
    }

    /// The wheel comes to rest where it is; the plan.
    pub(super) fn stop_wheel(mut self) -> Plan {
        self.steps.command(StepSubject::part(Phase::Dress), PlanCommand::WheelStop, "wheel stop");
        self.done()
    }

    /// X, then the table, to the home position; the plan.
    pub(super) fn finish(mut self) -> Result<Plan, PlanError> {
        let of = StepSubject::part(Phase::Return);
        self.steps.move_axis(
            of,
            Axis::X,
            self.steps.counts(Axis::X, self.job.home.x_mm),
            None,
            "wheel to its home position",
        )?;
        self.steps.command(of, PlanCommand::WheelStop, "wheel stop");
        self.steps.move_axis(
            of,
            Axis::Z,
            self.steps.counts(Axis::Z, self.job.home.z_mm),
            None,
            "table to its home position",
        )?;
        Ok(self.done())
    }

    /// Predicts the time of cuts whose infeed ends at a size, or whose spark-out ends when the force is steady.
    fn foresee(&mut self) {
        for (index, lobe) in self.job.lobes.iter().enumerate() {
            let machine = self.steps.machine;
            let part_mm_n = self.job.lobe_compliance_mm_n(machine, lobe);
            let wheel_mm = machine.wheel_at(lobe.wheel(machine)).width_mm;
            let law =
                plunges::contact_law(machine, wheel_mm, &lobe.station, lobe.width_mm, lobe.plunge.as_ref(), part_mm_n);
            let Some(law) = law else { continue };
            let mut surface = GroundLobe::new(self.job.stock_of_mm(index), &law);
            for number in 0..self.steps.plan.segments.len() {
                let size = GaugedSize::from_plan(&self.steps.plan, number, self.steps.machine);
                let segment = &mut self.steps.plan.segments[number];
                let SegmentKind::Cut(cut) = &segment.kind else { continue };
                if segment.lobe != Some(index) {
                    continue;
                }
                let Some(infeed) = self.steps.plan.angle_laws.get(cut.infeed) else { continue };
                let left_out = cut.turns.saturating_sub(surface.after(cut, infeed, size.as_ref()));
                let saved =
                    whole_ticks(f64::from(left_out) * cut.turn_s, self.steps.machine.cycle_time_s()).min(segment.ticks);
                segment.ticks -= saved;
                self.steps.ticks -= saved;
            }
        }
    }

    fn done(mut self) -> Plan {
        if self.watched_n > 0 || self.watches_size {
            self.foresee();
        }
        self.steps.done()
    }

    /// The table goes to just before the switch, whichever side it comes from, then searches for it in its positive
    /// direction: a switch closes at one place only when approached from one side. A plunge stands beside the switch.
    fn index_table(&mut self, of: StepSubject<'_>, lobe: &LobeSpec, station: &Station) -> Result<(), PlanError> {
        let axis = self.steps.machine.axis(Axis::Z);
        let before_mm = station.position_mm - RUN_IN_MM;
        let speed = axis.search_velocity.min(axis.limits.velocity);
        let after_mm = RUN_IN_MM + self.steps.overshoot(Axis::Z, speed);
        let offset_mm = lobe.offset_mm();
        let place = || Subject::Lobe(lobe.name.clone());
        soft_limit(self.steps.machine, Axis::Z, before_mm, place(), RequiredPosition::SearchStart)?;
        soft_limit(self.steps.machine, Axis::Z, station.position_mm + after_mm, place(), RequiredPosition::SearchEnd)?;
        soft_limit(self.steps.machine, Axis::Z, station.position_mm + offset_mm, place(), RequiredPosition::Plunge)?;
        let label = alloc::format!("table to before {}", station.switch);
        self.steps.move_axis(of, Axis::Z, self.steps.counts(Axis::Z, before_mm), None, &label)?;
        let offset = self.steps.counts(Axis::Z, offset_mm);
        let label = match offset {
            0 => alloc::format!("table to {}", station.switch),
            _ => alloc::format!("table to {}, {offset_mm:+.3} mm from it", station.switch),
        };
        self.steps.search(of, Axis::Z, &station.switch, RUN_IN_MM + after_mm, RUN_IN_MM, offset, &label)?;
        self.steps.at[Axis::Z.index()] = self.steps.counts(Axis::Z, station.position_mm) + offset;
        Ok(())
    }

    fn cut_segment(&mut self, path: usize, pass: &SpeedPlan, begin: LobeStart) -> CutSegment {
        let turn_counts = self.steps.machine.axis(Axis::C).scale.counts(TURN_RAD);
        CutSegment {
            path,
            speed: shared(&mut self.steps.plan.time_laws, pass.law()),
            infeed: shared(&mut self.steps.plan.angle_laws, pass.infeed().law()),
            // All profiles have one or none has.
            ratio: (path < self.steps.plan.ratios.len()).then_some(path),
            lead: pass.lead().map(|lead| shared(&mut self.steps.plan.time_laws, lead)),
            start_counts: begin.c_counts.rem_euclid(turn_counts),
            path_start_rad: begin.path_rad,
            turns: pass.turns(),
            infeed_turns: pass.infeed().schedule().turns(),
            plateau_s: pass.plateau_s(),
            turn_s: pass.turn_s(),
            retract_mm: self.job.retract_clearance_mm,
            hold_mm: self.job.hold_mm(),
            until_steady_n: None,
            variation: self.job.speed_variation,
        }
    }
}
