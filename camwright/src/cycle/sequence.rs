//! The steps of a part, one after the other, with the time each is predicted to take.

use super::PlanStart;
use super::error::PlanError;
use super::lobe::{Begin, PlannedLobe, Shape, soft_limit};
use crate::giving_way::Surface;
use crate::job::JobSpec;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits, Station};
use crate::numeric::hermite::HermiteSpline;
use crate::numeric::periodic_spline::PeriodicSpline;
use crate::path_stop::path_stop_s;
use crate::plan::{AxisTarget, Command, CutSegment, Half, Phase, Plan, Segment, SegmentKind};
use crate::point_to_point::{MOVE_SHARE, MoveLaw, PointToPointError, rest_to_rest, velocity_ramp, whole_ticks};
use crate::speed_plan::{SpeedPlan, WaySpeed};
use crate::units::{TURN_RAD, wrap_turn};
use alloc::string::String;
use alloc::vec::Vec;

/// How far before a station's switch the table stands when the search for it begins (mm), and how far beyond the switch
/// the search may go. It covers a switch that has shifted and lets the table reach its search speed; longer costs time
/// at the slow search speed.
pub(super) const RUN_IN_MM: f64 = 5.0;

/// Turns in which the search for the origin must meet it: one, and a quarter for a start inside its window.
const HOMING_TURNS: f64 = 1.25;

/// A plan in the making.
pub(super) struct Sequence<'a> {
    pub(super) job: &'a JobSpec,
    pub(super) machine: &'a MachineDescription,
    start: PlanStart,
    at: [i64; AXIS_COUNT],
    ticks: u64,
    /// What the force monitor was told last (N).
    watched_n: i64,
    plan: Plan,
}

/// Who a step is for.
#[derive(Clone, Copy)]
pub(super) struct Of<'a> {
    phase: Phase,
    lobe: Option<(usize, &'a str)>,
    stock_mm: f64,
}

impl<'a> Of<'a> {
    pub(super) const fn lobe(phase: Phase, index: usize, name: &'a str) -> Self {
        Self { phase, lobe: Some((index, name)), stock_mm: 0.0 }
    }

    pub(super) const fn part(phase: Phase) -> Self {
        Self { phase, lobe: None, stock_mm: 0.0 }
    }
}

impl<'a> Sequence<'a> {
    pub(super) fn new(job: &'a JobSpec, machine: &'a MachineDescription, shapes: &[Shape], start: PlanStart) -> Self {
        let plan = Plan {
            job: job.name.clone(),
            lobes: job.lobes.iter().map(|lobe| lobe.name.clone()).collect(),
            paths: shapes.iter().map(|shape| shape.path.clone()).collect(),
            ratios: shapes.iter().filter_map(|shape| shape.ratio.clone()).collect(),
            ..Plan::default()
        };
        Self { job, machine, start, at: start.counts, ticks: 0, watched_n: 0, plan }
    }

    /// Wheel clear of the part, C on its origin, wheel up to speed.
    pub(super) fn prepare(&mut self) -> Result<(), PlanError> {
        let of = Of::part(Phase::Home);
        self.move_axis(of, Axis::X, self.counts(Axis::X, self.job.home.x_mm), None, "wheel clear of the part")?;
        let distance = if self.start.c_homed {
            wrap_turn(-self.machine.axis(Axis::C).scale.position(self.at[Axis::C.index()]))
        } else {
            0.5 * TURN_RAD
        };
        // The latch catches the index mark at the window's centre, where the key-way faces the wheel.
        self.search(of, Axis::C, "origin", HOMING_TURNS * TURN_RAD, distance, 0, "headstock to its origin")?;
        self.at[Axis::C.index()] = 0;
        self.command(of, Command::SetHome(Axis::C), "origin is zero");
        self.move_axis(of, Axis::C, 0, None, "key-way to the wheel")?;
        self.start_wheel(of);
        Ok(())
    }

    /// The table to the station of a lobe.
    pub(super) fn index_to(&mut self, index: usize) -> Result<(), PlanError> {
        let lobe = &self.job.lobes[index];
        let of = Of { phase: Phase::Index, lobe: Some((index, &lobe.name)), stock_mm: self.job.stock_mm };
        match self.machine.station(&lobe.station) {
            Some(station) => self.index_table(of, &lobe.name, station),
            None => Ok(()),
        }
    }

    /// X to where it stands between the lobes (mm), if it has been elsewhere.
    pub(super) fn stand_clear(&mut self, index: usize, x_mm: f64) -> Result<(), PlanError> {
        let target_counts = self.counts(Axis::X, x_mm);
        if self.at[Axis::X.index()] == target_counts {
            return Ok(());
        }
        let name = self.job.lobes[index].name.as_str();
        let of = Of { phase: Phase::Position, lobe: Some((index, name)), stock_mm: self.job.stock_mm };
        self.move_axis(of, Axis::X, target_counts, None, "wheel to just clear of the lobes")
    }

    /// C to where a lobe begins (counts), the conventional way.
    pub(super) fn turn_to_lobe(&mut self, index: usize, c_counts: i64) -> Result<(), PlanError> {
        let name = self.job.lobes[index].name.as_str();
        let of = Of { phase: Phase::RotaryIndex, lobe: Some((index, name)), stock_mm: self.job.stock_mm };
        self.move_axis(of, Axis::C, c_counts, None, "part to the lobe's cam angle 0")
    }

    /// One lobe at its station, from where C stands, or comes turning and meets its phase after a while (ticks), to the wheel clear
    /// of the part.
    pub(super) fn grind(
        &mut self,
        index: usize,
        lobe: &PlannedLobe,
        begin: Begin,
        waits_ticks: u64,
    ) -> Result<(), PlanError> {
        let name = lobe.design.name.as_str();
        let of = |phase: Phase, stock_mm: f64| Of { phase, lobe: Some((index, name)), stock_mm };
        let stock_mm = self.job.stock_mm;
        let rapid = Some(self.job.rapid_speed_mm_s);
        let mut retracted = self.at[Axis::X.index()];
        let mut goes_turning = false;
        // Passes that would be cut in the air are left out from the first on.
        let specs = &self.job.passes[self.job.passes.len() - lobe.passes.len()..];
        for (number, pass) in lobe.passes.iter().enumerate() {
            let until_steady_n = specs[number].spark_out_until_n;
            let cut = CutSegment { until_steady_n, ..self.cut_segment(lobe.path, pass, begin) };
            if let Some(most_n) = until_steady_n.map(i64::from).filter(|most_n| *most_n != self.watched_n) {
                let label = alloc::format!("force monitor to {most_n} N");
                self.command(of(Phase::Position, stock_mm), Command::WatchForce { most_n }, &label);
                self.watched_n = most_n;
            }
            // The same arithmetic as in the cut, so that the wheel stands where the cut begins to the count.
            let motion = self.plan.motion_of(&cut).expect("its splines have just been put into the plan");
            let first = self.counts(Axis::X, motion.x_mm(motion.start_s()));
            let last = self.counts(Axis::X, motion.x_mm(motion.end_s()));
            let comes_turning = motion.end_speeds_rad_s().0 > 0.0;
            goes_turning = motion.end_speeds_rad_s().1 > 0.0;
            if number == 0 && !comes_turning {
                retracted = first + self.counts(Axis::X, self.job.rapid_advance_mm);
                let label = "wheel corrected by the lift";
                self.move_axis(of(Phase::Position, stock_mm), Axis::X, retracted, None, label)?;
                self.move_axis(of(Phase::Approach, stock_mm), Axis::X, first, rapid, "rapid advance")?;
            } else if number > 0 && self.at[Axis::X.index()] != first {
                // A rounding apart: a count at most.
                self.move_axis(of(Phase::Approach, stock_mm), Axis::X, first, rapid, "to the next pass")?;
            }
            let mut label =
                alloc::format!("{} turns with infeed, {} without", cut.infeed_turns, cut.turns - cut.infeed_turns);
            if let Some(most_n) = until_steady_n {
                label += &alloc::format!(" or until the force is steady within {most_n} N");
            }
            if comes_turning || goes_turning {
                label += ", c_axis turning on";
            }
            if lobe.passes.len() > 1 {
                label = alloc::format!("{}, {label}", specs[number].name);
            }
            let length_s = pass.law().end() - pass.law().start();
            let waits = if number == 0 { waits_ticks } else { 0 };
            let ticks = waits + whole_ticks(length_s, self.machine.cycle_time_s());
            let turn_counts = self.machine.axis(Axis::C).scale.counts(TURN_RAD);
            if comes_turning {
                self.at[Axis::C.index()] = begin.c_counts;
            }
            self.at[Axis::C.index()] += i64::from(cut.turns) * turn_counts;
            self.at[Axis::X.index()] = last;
            let schedule = pass.infeed().schedule();
            let left_mm = stock_mm.min(schedule.left_mm() + schedule.total_mm());
            self.add(of(Phase::Cut, left_mm), SegmentKind::Cut(cut), ticks, pass.stop_ticks(), &label);
        }
        if goes_turning {
            return Ok(());
        }
        self.move_axis(of(Phase::Retract, 0.0), Axis::X, retracted, rapid, "rapid retract")
    }

    /// Predicted ticks of the steps so far.
    pub(super) const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// A turn of a journal under the gauge, with the wheel where it is clear of everything; C at its end (rad).
    pub(super) fn gauge(&mut self, index: usize, speed_rad_s: f64) -> Result<f64, PlanError> {
        let of = Of::lobe(Phase::Position, index, &self.job.lobes[index].name);
        let scale = self.machine.axis(Axis::C).scale;
        let turned = self.at[Axis::C.index()] + scale.counts(TURN_RAD);
        self.move_axis(of, Axis::C, turned, Some(speed_rad_s), "one turn under the gauge")?;
        Ok(scale.position(turned))
    }

    /// A turn that corrects a journal: `cut` but for what is shared with the plan.
    pub(super) fn correct(
        &mut self,
        index: usize,
        name: &str,
        cut: CutSegment,
        path: PeriodicSpline,
        speed: &WaySpeed,
        offset: HermiteSpline,
    ) -> Result<(), PlanError> {
        let of = |phase: Phase| Of { phase, lobe: Some((index, name)), stock_mm: 0.0 };
        let turn_counts = self.machine.axis(Axis::C).scale.counts(TURN_RAD);
        self.plan.paths.push(path);
        let cut = CutSegment {
            speed: shared(&mut self.plan.time_laws, &speed.law),
            infeed: shared(&mut self.plan.angle_laws, &offset),
            start_counts: self.at[Axis::C.index()].rem_euclid(turn_counts),
            ..cut
        };
        let motion = self.plan.motion_of(&cut).expect("its splines have just been put into the plan");
        let (first, last) = (motion.x_mm(motion.start_s()), motion.x_mm(motion.end_s()));
        let (first, last) = (self.counts(Axis::X, first), self.counts(Axis::X, last));
        let rapid = Some(self.job.rapid_speed_mm_s);
        self.move_axis(of(Phase::Approach), Axis::X, first, rapid, "rapid advance to just clear of it")?;
        let ticks = whole_ticks(speed.law.end(), self.machine.cycle_time_s());
        self.at[Axis::C.index()] += i64::from(cut.turns) * turn_counts;
        self.at[Axis::X.index()] = last;
        self.add(of(Phase::Cut), SegmentKind::Cut(cut), ticks, speed.stop_ticks, "one turn that corrects its runout");
        let home = self.counts(Axis::X, self.job.home.x_mm);
        self.move_axis(of(Phase::Retract), Axis::X, home, rapid, "rapid retract")
    }

    /// X to its home position and no more: the wheel runs on and the table stays, for the plan that follows.
    pub(super) fn stand_by(mut self) -> Result<Plan, PlanError> {
        let of = Of::part(Phase::Return);
        self.move_axis(of, Axis::X, self.counts(Axis::X, self.job.home.x_mm), None, "wheel clear of the part")?;
        self.plan.half = Half::First;
        Ok(self.done())
    }

    /// Wheel clear of the part, and up to speed.
    pub(super) fn clear_and_run(&mut self) -> Result<(), PlanError> {
        let of = Of::part(Phase::Dress);
        self.move_axis(of, Axis::X, self.counts(Axis::X, self.job.home.x_mm), None, "wheel clear of the part")?;
        self.start_wheel(of);
        Ok(())
    }

    /// The wheel comes to rest where it is; the plan.
    pub(super) fn stop_wheel(mut self) -> Plan {
        self.command(Of::part(Phase::Dress), Command::WheelStop, "wheel stop");
        self.done()
    }

    fn start_wheel(&mut self, of: Of<'_>) {
        self.command(of, Command::WheelStart, "wheel start");
        let spin_up = whole_ticks(self.machine.wheel.spin_up_s, self.machine.cycle_time_s());
        self.add(of, SegmentKind::Dwell, spin_up, 0, "wheel to its speed");
    }

    /// X, then the table, to the home position; the plan.
    pub(super) fn finish(mut self) -> Result<Plan, PlanError> {
        let of = Of::part(Phase::Return);
        self.move_axis(of, Axis::X, self.counts(Axis::X, self.job.home.x_mm), None, "wheel to its home position")?;
        self.command(of, Command::WheelStop, "wheel stop");
        self.move_axis(of, Axis::Z, self.counts(Axis::Z, self.job.home.z_mm), None, "table to its home position")?;
        Ok(self.done())
    }

    /// How long the cuts take whose spark-out ends when the force is steady.
    fn foresee(&mut self) {
        for (index, lobe) in self.job.lobes.iter().enumerate() {
            let Some(law) = self.machine.contact_law(&lobe.station, lobe.width_mm) else { continue };
            let mut surface = Surface::new(self.job.stock_mm, &law);
            for segment in self.plan.segments.iter_mut().filter(|segment| segment.lobe == Some(index)) {
                let SegmentKind::Cut(cut) = &segment.kind else { continue };
                let Some(infeed) = self.plan.angle_laws.get(cut.infeed) else { continue };
                let left_out = cut.turns.saturating_sub(surface.after(cut, infeed));
                let saved =
                    whole_ticks(f64::from(left_out) * cut.turn_s, self.machine.cycle_time_s()).min(segment.ticks);
                segment.ticks -= saved;
                self.ticks -= saved;
            }
        }
    }

    fn done(mut self) -> Plan {
        if self.watched_n > 0 {
            self.foresee();
        }
        #[allow(clippy::cast_precision_loss, reason = "a part takes far less than 2^53 ticks")]
        let duration_s = self.ticks as f64 * self.machine.cycle_time_s();
        self.plan.duration_s = duration_s;
        self.plan
    }

    /// The table goes to just before the switch, whichever side it comes from, then searches for it in its positive
    /// direction: a switch closes at one place only when approached from one side.
    fn index_table(&mut self, of: Of<'_>, lobe: &str, station: &Station) -> Result<(), PlanError> {
        let axis = self.machine.axis(Axis::Z);
        let before_mm = station.position_mm - RUN_IN_MM;
        let speed = axis.search_velocity.min(axis.limits.velocity);
        let after_mm = RUN_IN_MM + self.overshoot(Axis::Z, speed);
        let place = || alloc::format!("lobe {lobe}: ");
        soft_limit(self.machine, Axis::Z, before_mm, place(), "the start of the search for the station's switch")?;
        soft_limit(
            self.machine,
            Axis::Z,
            station.position_mm + after_mm,
            place(),
            "the end of the search for the station's switch",
        )?;
        let label = alloc::format!("table to before {}", station.switch);
        self.move_axis(of, Axis::Z, self.counts(Axis::Z, before_mm), None, &label)?;
        let label = alloc::format!("table to {}", station.switch);
        self.search(of, Axis::Z, &station.switch, RUN_IN_MM + after_mm, RUN_IN_MM, 0, &label)?;
        self.at[Axis::Z.index()] = self.counts(Axis::Z, station.position_mm);
        Ok(())
    }

    fn cut_segment(&mut self, path: usize, pass: &SpeedPlan, begin: Begin) -> CutSegment {
        let turn_counts = self.machine.axis(Axis::C).scale.counts(TURN_RAD);
        CutSegment {
            path,
            speed: shared(&mut self.plan.time_laws, pass.law()),
            infeed: shared(&mut self.plan.angle_laws, pass.infeed().law()),
            // All profiles have one or none has.
            ratio: (path < self.plan.ratios.len()).then_some(path),
            lead: pass.lead().map(|lead| shared(&mut self.plan.time_laws, lead)),
            start_counts: begin.c_counts.rem_euclid(turn_counts),
            path_start_rad: begin.path_rad,
            turns: pass.turns(),
            infeed_turns: pass.infeed().schedule().turns(),
            plateau_s: pass.plateau_s(),
            turn_s: pass.turn_s(),
            retract_mm: self.job.retract_clearance_mm,
            hold_mm: self.job.hold_mm(),
            until_steady_n: None,
        }
    }

    pub(super) fn counts(&self, axis: Axis, position: f64) -> i64 {
        self.machine.axis(axis).scale.counts(position)
    }

    /// How far an axis runs on after an edge at a speed: until the edge is known, and until it stands.
    fn overshoot(&self, axis: Axis, speed: f64) -> f64 {
        let limits = self.machine.axis(axis).limits;
        let known_s = f64::from(self.machine.feedback_delay_ticks + 2) * self.machine.cycle_time_s();
        // A stop takes v/a + a/j at most, at half the speed in the mean; doubled for the share that moves leave unused.
        speed * known_s + speed * (speed / limits.acceleration + limits.acceleration / limits.jerk)
    }

    pub(super) fn add(&mut self, of: Of<'_>, kind: SegmentKind, ticks: u64, stop_ticks: u64, label: &str) {
        let label = match of.lobe {
            Some((_, name)) => alloc::format!("{name}: {label}"),
            None => String::from(label),
        };
        self.ticks += ticks;
        self.plan.segments.push(Segment {
            kind,
            phase: of.phase,
            lobe: of.lobe.map(|(index, _)| index),
            label,
            ticks,
            stop_ticks,
            stock_mm: of.stock_mm,
        });
    }

    pub(super) fn command(&mut self, of: Of<'_>, command: Command, label: &str) {
        // To the machine and back.
        let ticks = 2 * u64::from(self.machine.feedback_delay_ticks).max(1);
        self.add(of, SegmentKind::Command(command), ticks, 0, label);
    }

    pub(super) fn move_axis(
        &mut self,
        of: Of<'_>,
        axis: Axis,
        target_counts: i64,
        speed: Option<f64>,
        label: &str,
    ) -> Result<(), PlanError> {
        let own = self.machine.axis(axis).limits;
        let limits = speed.map_or(own, |speed| own.at_most(speed));
        let targets = alloc::vec![AxisTarget { axis, target_counts, limits }];
        let (ticks, stop_ticks) = self.time_of_move(self.at, &targets, label)?;
        self.at[axis.index()] = target_counts;
        self.add(of, SegmentKind::Move(targets), ticks, stop_ticks, label);
        Ok(())
    }

    fn time_of_move(&self, from: [i64; AXIS_COUNT], to: &[AxisTarget], label: &str) -> Result<(u64, u64), PlanError> {
        let wrong = |source| PlanError::Move { what: String::from(label), source };
        let law = MoveLaw::new(from, to, self.machine).map_err(wrong)?;
        let cycle_time_s = self.machine.cycle_time_s();
        let ticks = law.ticks(cycle_time_s);
        let ((velocity, acceleration), line) = (law.law().peaks(), law.limits());
        let peaks = MotionLimits { velocity, acceleration, jerk: line.jerk };
        let whole =
            MotionLimits { acceleration: line.acceleration / MOVE_SHARE, jerk: line.jerk / MOVE_SHARE, ..*line };
        // A law without room for a stop is stopped by letting it end.
        let stop_ticks = path_stop_s(&peaks, &whole).map_or(ticks, |stop_s| whole_ticks(stop_s, cycle_time_s));
        Ok((ticks, stop_ticks))
    }

    /// A search with the time it takes if the edge lies `distance` ahead (mm or rad).
    #[allow(clippy::too_many_arguments, reason = "each is one field of the search")]
    fn search(
        &mut self,
        of: Of<'_>,
        axis: Axis,
        input: &str,
        travel: f64,
        distance: f64,
        offset_counts: i64,
        label: &str,
    ) -> Result<(), PlanError> {
        let description = self.machine.axis(axis);
        let limits = description.limits.at_most(description.search_velocity);
        let travel_counts = self.counts(axis, travel + self.overshoot(axis, limits.velocity));
        let mut target = self.at;
        target[axis.index()] += travel_counts;
        let whole = AxisTarget { axis, target_counts: target[axis.index()], limits };
        let (_, stop_ticks) = self.time_of_move(self.at, &[whole], label)?;
        let offset = description.scale.position(offset_counts);
        let seconds = self
            .search_s(&limits, distance, offset)
            .map_err(|source| PlanError::Move { what: String::from(label), source })?;
        let kind = SegmentKind::Search { axis, input: String::from(input), travel_counts, offset_counts, limits };
        self.add(of, kind, whole_ticks(seconds, self.machine.cycle_time_s()), stop_ticks, label);
        Ok(())
    }

    /// Run to the edge, run on until it is known and the axis stands, back to the edge plus offset.
    fn search_s(&self, limits: &MotionLimits, distance: f64, offset: f64) -> Result<f64, PointToPointError> {
        let speed = limits.velocity;
        let ramp = velocity_ramp(0.0, speed, limits)?;
        let ramp_length = ramp.knots()[ramp.knots().len() - 1].value;
        let run_s = ramp.end() + (distance - ramp_length).max(0.0) / speed;
        let known_s = f64::from(self.machine.feedback_delay_ticks) * self.machine.cycle_time_s();
        let beyond = speed * known_s + ramp_length;
        let back = rest_to_rest(offset - beyond, limits)?;
        Ok(run_s + known_s + ramp.end() + back.end())
    }
}

/// Index of a law among those of the plan; a new one is added.
fn shared(laws: &mut Vec<HermiteSpline>, law: &HermiteSpline) -> usize {
    laws.iter().position(|known| known == law).unwrap_or_else(|| {
        laws.push(law.clone());
        laws.len() - 1
    })
}
