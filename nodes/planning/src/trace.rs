// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Trace of one commanded position back to its causes: rows of the lift table, follower, wheel, speed law and limit, infeed, setpoint.

use super::turn::LobeTurn;
use super::turn_summary::{bound_name, law_name};
use super::{AnyPrepared, PreparedJob};
use camwright::cam::follower::Follower;
use camwright::machine::description::Axis;
use camwright::math::units::{TURN_RAD, deg_from_rad, rad_from_deg, rpm_from_rad_s, um_from_mm, wrap_turn};
use camwright::motion::speed_plan::Bound;
use serde::Serialize;
use std::fmt;
use thiserror::Error;

/// Position to trace: an angle of `c_axis` in a turn of a pass over a lobe.
#[derive(Debug, Clone)]
pub struct TraceRequest {
    pub lobe: String,
    /// Name of the pass; none: the last one.
    pub pass: Option<String>,
    /// Turn of the pass from 1.
    pub turn: u32,
    /// Angle of `c_axis` (deg).
    pub c_deg: f64,
}

/// Position that cannot be traced.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TraceError {
    #[error("{job} turns a part; only positions on ground lobes are traced")]
    Turned { job: String },
    #[error("lobe is {lobe:?}; lobes of {job}: {known}")]
    UnknownLobe { job: String, lobe: String, known: String },
    #[error("pass is {pass:?}; passes of {job}: {known}")]
    UnknownPass { job: String, pass: String, known: String },
    #[error("turn is {turn}; pass {pass} over lobe {lobe} has {turns} turns, from 1")]
    NoTurn { turn: u32, pass: String, lobe: String, turns: u32 },
    #[error("the cut over lobe {lobe} has no turn at the programmed speed")]
    NoCut { lobe: String },
}

/// Causes of one commanded position.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PositionTrace {
    pub job: String,
    pub lobe: String,
    pub pass: String,
    pub turn: u32,
    pub turns: u32,
    pub c_deg: f64,
    pub lift: TracedLift,
    pub contact: TracedContact,
    pub speed: TracedSpeed,
    pub infeed: TracedInfeed,
    pub setpoint: TracedSetpoint,
}

/// Lift at the cam angle of the contact.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TracedLift {
    pub profile: String,
    pub cam_angle_deg: f64,
    /// Lift; of an oscillating follower along the arc of its arm.
    pub lift_mm: f64,
    pub follower: String,
    /// Reading of the table; none for a formula.
    pub reading: Option<&'static str>,
    /// Tolerance of a row (µm); 0 where the curve passes through the rows.
    pub allowed_um: f64,
    /// Rows before and behind the cam angle; none for a formula.
    pub rows: Vec<TracedRow>,
}

/// Row of a lift table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TracedRow {
    /// Number of the row from 0, in the order of the cam angle.
    pub row: usize,
    pub cam_angle_deg: f64,
    pub printed_mm: f64,
    /// Deviation of the curve from the printed value.
    pub deviation_um: f64,
}

/// Contact of wheel and lobe.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TracedContact {
    /// Azimuth of the contact in the frame of the lobe, of a crank pin about its own centre.
    pub azimuth_deg: f64,
    /// Contact angle: from the normal of the contact to the wheel line.
    pub angle_deg: f64,
    /// Distance of the centre of a crank pin from the axis of C; 0 of every other lobe.
    pub throw_mm: f64,
    pub radius_mm: f64,
    pub curvature_1_mm: f64,
    pub wheel_radius_mm: f64,
    /// Largest wheel that fits the contour; none where any does.
    pub largest_wheel_radius_mm: Option<f64>,
    /// Smallest wheel that follows a crank pin; none where any does.
    pub smallest_wheel_radius_mm: Option<f64>,
    /// Distance of the wheel's centre from the axis of C at full depth.
    pub x_mm: f64,
    /// Largest distance of the ground points from the contour, of the whole path.
    pub contour_error_um: f64,
}

/// Speed of C and the bounds that act on it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TracedSpeed {
    pub law: &'static str,
    pub c_rpm: f64,
    /// Bound that sets the speed at this angle of a turn at the programmed speed, or `none`.
    pub set_by: String,
    /// Use of each bound, the largest first; 1 is all that planning allows.
    pub uses: Vec<(String, f64)>,
}

/// Infeed at the position.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TracedInfeed {
    pub infeed_turns: u32,
    /// Distance of the wheel from its finished path, along X.
    pub stock_mm: f64,
    /// Infeed of the last turn at this angle, along X.
    pub last_turn_um: f64,
}

/// First setpoint of the cut at or behind the position.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TracedSetpoint {
    /// Tick of the cut from 0, and its time since the begin of the cut.
    pub tick: u64,
    pub time_s: f64,
    /// Angle of C since its position at homing modulo one turn, and encoder counts.
    pub c_deg: f64,
    pub c_counts: i64,
    pub x_axis_mm: f64,
    pub x_counts: i64,
}

/// Traces a position of a planned job.
///
/// # Errors
/// A lobe, pass or turn that the job does not have; a turned part.
pub fn trace(prepared: &AnyPrepared, request: &TraceRequest) -> Result<PositionTrace, TraceError> {
    let prepared = match prepared {
        AnyPrepared::Ground(prepared) => prepared,
        AnyPrepared::Turned(turned) => return Err(TraceError::Turned { job: turned.job.spec.name.clone() }),
    };
    let job = &prepared.job.spec.name;
    let lobes = &prepared.planned.lobes;
    let index = lobes.iter().position(|lobe| lobe.design.name == request.lobe).ok_or_else(|| {
        let known: Vec<&str> = lobes.iter().map(|lobe| lobe.design.name.as_str()).collect();
        TraceError::UnknownLobe { job: job.clone(), lobe: request.lobe.clone(), known: known.join(", ") }
    })?;
    let passes = prepared.job.spec.passes_of(index);
    let pass = match &request.pass {
        None => passes.len().saturating_sub(1),
        Some(name) => passes.iter().position(|pass| pass.name == *name).ok_or_else(|| {
            let known: Vec<&str> = passes.iter().map(|pass| pass.name.as_str()).collect();
            TraceError::UnknownPass { job: job.clone(), pass: name.clone(), known: known.join(", ") }
        })?,
    };
    trace_lobe(prepared, (index, pass), request)
}

fn trace_lobe(
    prepared: &PreparedJob,
    (index, pass): (usize, usize),
    request: &TraceRequest,
) -> Result<PositionTrace, TraceError> {
    let plan = &prepared.planned.plan;
    let lobe = &prepared.planned.lobes[index];
    let pass_name = prepared.job.spec.passes_of(index)[pass].name.clone();
    let no_cut = || TraceError::NoCut { lobe: request.lobe.clone() };
    let cut = plan.cuts_of(index).nth(pass).ok_or_else(no_cut)?;
    let motion = plan.motion_of(cut).ok_or_else(no_cut)?;
    let turn = LobeTurn::new(prepared, index, pass).ok_or_else(no_cut)?;
    if request.turn == 0 || request.turn > cut.turns {
        let (lobe, turns) = (request.lobe.clone(), cut.turns);
        return Err(TraceError::NoTurn { turn: request.turn, pass: pass_name, lobe, turns });
    }
    let (c_scale, x_scale) = (prepared.machine.axis(Axis::C).scale, prepared.machine.axis(Axis::X).scale);
    let start_rad = c_scale.position(cut.start_counts);
    let angle_rad = wrap_turn(rad_from_deg(request.c_deg) - start_rad) + f64::from(request.turn - 1) * TURN_RAD;
    let path_rad = cut.path_start_rad + angle_rad;
    let theta = f64::from(prepared.machine.rotation_sense) * path_rad;
    let contour = &lobe.design.contour;
    let azimuth_rad = wrap_turn(lobe.tool_path.contact_azimuth(theta));
    let cam_angle_rad = contour.cam_angle_at(azimuth_rad);

    let cycle_s = prepared.machine.cycle_time_s();
    let since_start_s = motion.time_of(angle_rad) - motion.start_s();
    #[allow(clippy::cast_possible_truncation, reason = "time since the begin of a cut")]
    let tick = (since_start_s / cycle_s).ceil().max(0.0) as u64;
    let at_tick = motion.at(motion.start_s() + tick as f64 * cycle_s);
    let c_counts = cut.start_counts + c_scale.counts(at_tick.c.value);
    let x_counts = x_scale.counts(at_tick.x.value);

    // The law of the turn at the programmed speed: its value is the path angle.
    let mut c = motion.law.sample(motion.time_of(angle_rad));
    c.value = path_rad;
    let law = &turn.bounds.speed;
    let mut uses: Vec<(String, f64)> = Bound::ALL
        .into_iter()
        .zip(turn.bounds.uses(c))
        .filter(|(_, share)| *share > 0.0)
        .map(|(bound, share)| (bound_name(law, Some(bound)), share))
        .collect();
    uses.sort_by(|a, b| b.1.total_cmp(&a.1));
    let offset_mm = motion.offset_over_angle(angle_rad).value;
    let before_mm = (angle_rad >= TURN_RAD).then(|| motion.offset_over_angle(angle_rad - TURN_RAD).value);

    Ok(PositionTrace {
        job: prepared.job.spec.name.clone(),
        lobe: request.lobe.clone(),
        pass: pass_name,
        turn: request.turn,
        turns: cut.turns,
        c_deg: request.c_deg,
        lift: lift_at(prepared, index, cam_angle_rad),
        contact: TracedContact {
            azimuth_deg: deg_from_rad(azimuth_rad),
            angle_deg: deg_from_rad(lobe.tool_path.beta(theta)),
            throw_mm: contour.throw_mm(),
            radius_mm: contour.radius_at(azimuth_rad),
            curvature_1_mm: contour.curvature(cam_angle_rad),
            wheel_radius_mm: lobe.tool_path.wheel_radius_mm(),
            largest_wheel_radius_mm: contour.largest_wheel_radius_mm(),
            smallest_wheel_radius_mm: contour.smallest_wheel_radius_mm(),
            x_mm: lobe.tool_path.sample(theta).value + lobe.tool_path.wheel_radius_mm(),
            contour_error_um: um_from_mm(lobe.tool_path.accuracy().contour_error_mm),
        },
        speed: TracedSpeed {
            law: law_name(law),
            c_rpm: rpm_from_rad_s(c.first),
            set_by: bound_name(law, turn.bounds.active(c)),
            uses,
        },
        infeed: TracedInfeed {
            infeed_turns: cut.infeed_turns,
            stock_mm: offset_mm,
            last_turn_um: before_mm.map_or(0.0, |before_mm| um_from_mm(before_mm - offset_mm)),
        },
        setpoint: TracedSetpoint {
            tick,
            time_s: tick as f64 * cycle_s,
            c_deg: deg_from_rad(wrap_turn(c_scale.position(c_counts))),
            c_counts,
            x_axis_mm: x_scale.position(x_counts),
            x_counts,
        },
    })
}

/// Lift, and the rows of the table on both sides of the cam angle.
fn lift_at(prepared: &PreparedJob, index: usize, cam_angle_rad: f64) -> TracedLift {
    let profile = prepared.job.spec.lobes[index].profile;
    let contour = &prepared.planned.lobes[index].design.contour;
    let lift = contour.lift();
    let rows = prepared.job.lifts[profile].table.iter().flat_map(|table| {
        #[allow(clippy::cast_possible_truncation, reason = "a block within one turn")]
        let block = (cam_angle_rad / table.block_rad()).floor().max(0.0) as usize;
        [block, block + 1].map(|block| {
            let row = block % table.blocks();
            let at_rad = row as f64 * table.block_rad();
            let printed_mm = table.lift_mm(row);
            let deviation_um = um_from_mm(lift.sample(at_rad).value - printed_mm);
            TracedRow { row, cam_angle_deg: deg_from_rad(at_rad), printed_mm, deviation_um }
        })
    });
    let reading = lift.reading();
    TracedLift {
        profile: prepared.job.spec.profiles[profile].name.clone(),
        cam_angle_deg: deg_from_rad(cam_angle_rad),
        lift_mm: lift.sample(cam_angle_rad).value,
        follower: match contour.is_pin() {
            true => format!("none, a crank pin; radius {} mm", contour.base_radius_mm()),
            false => follower_text(&contour.follower(), contour.base_radius_mm()),
        },
        reading: reading.map(|reading| reading.reading.name()),
        allowed_um: reading.map_or(0.0, |reading| um_from_mm(reading.allowed_mm)),
        rows: rows.collect(),
    }
}

fn follower_text(follower: &Follower, base_radius_mm: f64) -> String {
    let kind = match follower {
        Follower::KnifeEdge { offset_mm } => format!("knife edge, offset {offset_mm} mm"),
        Follower::Roller { radius_mm, offset_mm } => format!("roller of {radius_mm} mm radius, offset {offset_mm} mm"),
        Follower::Mushroom { radius_mm } => format!("curved face of {radius_mm} mm radius"),
        Follower::Flat => "flat face".to_owned(),
        Follower::OscillatingRoller { radius_mm, arm_mm, .. } => {
            format!("roller of {radius_mm} mm radius on an arm of {arm_mm} mm")
        }
        Follower::OscillatingFlat { face_offset_mm, .. } => format!("swinging flat face, offset {face_offset_mm} mm"),
    };
    format!("{kind}; base radius {base_radius_mm} mm")
}

impl fmt::Display for PositionTrace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (lift, contact, speed, infeed) = (&self.lift, &self.contact, &self.speed, &self.infeed);
        writeln!(
            f,
            "lobe {}, pass {}, turn {} of {}, C {} deg",
            self.lobe, self.pass, self.turn, self.turns, self.c_deg
        )?;
        writeln!(f, "contact:  cam angle {:.4} deg, azimuth {:.4} deg", lift.cam_angle_deg, contact.azimuth_deg)?;
        writeln!(f, "contour:  radius {:.6} mm, curvature {:.6} 1/mm", contact.radius_mm, contact.curvature_1_mm)?;
        if contact.throw_mm > 0.0 {
            writeln!(
                f,
                "pin:      throw {} mm; the wheel line is {:+.4} deg off the contact",
                contact.throw_mm, contact.angle_deg
            )?;
        }
        writeln!(f, "lift:     {:.6} mm of profile {}", lift.lift_mm, lift.profile)?;
        for row in &lift.rows {
            writeln!(
                f,
                "          row {} at {:.4} deg: {} mm, the curve {:+.3} um",
                row.row, row.cam_angle_deg, row.printed_mm, row.deviation_um
            )?;
        }
        match lift.reading {
            Some(reading) => writeln!(f, "          reading {reading}, allowed {:.3} um", lift.allowed_um)?,
            None => writeln!(f, "          a formula, no table")?,
        }
        writeln!(f, "follower: {}", lift.follower)?;
        let fits = match (contact.largest_wheel_radius_mm, contact.smallest_wheel_radius_mm) {
            (Some(largest_mm), _) => format!("largest possible {largest_mm:.3} mm"),
            (None, Some(smallest_mm)) => format!("smallest possible {smallest_mm:.3} mm"),
            (None, None) => "every radius fits".to_owned(),
        };
        writeln!(f, "wheel:    radius {} mm, {fits}", contact.wheel_radius_mm)?;
        writeln!(
            f,
            "path:     wheel centre at {:.6} mm; the path is off by {:.6} um at most",
            contact.x_mm, contact.contour_error_um
        )?;
        writeln!(
            f,
            "infeed:   {:.6} mm above the path, {:.3} um less than a turn before",
            infeed.stock_mm, infeed.last_turn_um
        )?;
        writeln!(f, "speed:    C {:.3} rpm by {}, set by {}", speed.c_rpm, speed.law, speed.set_by)?;
        for (bound, share) in speed.uses.iter().take(3) {
            writeln!(f, "          {:5.1} % of {bound}", 100.0 * share)?;
        }
        let setpoint = &self.setpoint;
        writeln!(
            f,
            "setpoint: tick {} of the cut ({:.3} s): C {:.6} deg ({} counts),",
            setpoint.tick, setpoint.time_s, setpoint.c_deg, setpoint.c_counts
        )?;
        write!(f, "          x_axis {:.6} mm ({} counts)", setpoint.x_axis_mm, setpoint.x_counts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{prepare_any, simulate_job};

    fn prepared(job: &str, set: &[&str]) -> AnyPrepared {
        prepare_any(job, &set.iter().map(ToString::to_string).collect::<Vec<_>>(), None).unwrap()
    }

    fn request(lobe: &str, turn: u32, c_deg: f64) -> TraceRequest {
        TraceRequest { lobe: lobe.into(), pass: None, turn, c_deg }
    }

    /// The setpoint of a trace is one that the interpolator sends, and the one before it lies before the traced angle.
    #[test]
    fn the_traced_setpoint_is_sent() {
        let prepared = prepared("four_lobe_camshaft", &["infeed.total_mm=0.072", "stock_mm=0.06"]);
        let AnyPrepared::Ground(ground) = &prepared else { panic!("a grinding job") };
        let mut sent: Vec<Vec<(i64, i64)>> = vec![Vec::new(); ground.planned.lobes.len()];
        simulate_job(ground, &[], |setpoint, report| {
            if let Some(lobe) = report.lobe.and_then(|lobe| sent.get_mut(lobe)) {
                lobe.push((setpoint.counts[Axis::C.index()], setpoint.counts[Axis::X.index()]));
            }
        })
        .unwrap();
        let counts_per_turn = ground.machine.axis(Axis::C).scale.counts(TURN_RAD);
        for (index, lobe) in ground.planned.plan.lobes.iter().enumerate() {
            for (turn, c_deg) in [(1, 143.2), (2, 0.0), (3, 359.99)] {
                let traced = trace(&prepared, &request(lobe, turn, c_deg)).unwrap();
                let setpoint = &traced.setpoint;
                let is_same = |(c, x): &(i64, i64)| {
                    (c - setpoint.c_counts).rem_euclid(counts_per_turn) == 0 && *x == setpoint.x_counts
                };
                assert!(sent[index].iter().any(is_same), "{lobe}, turn {turn}, {c_deg} deg: {setpoint:?}");
                let beyond_deg = (setpoint.c_deg - c_deg + 180.0).rem_euclid(360.0) - 180.0;
                let step_deg = traced.speed.c_rpm * 6.0 * ground.machine.cycle_time_s();
                assert!((-1e-4..step_deg + 1e-4).contains(&beyond_deg), "{beyond_deg} deg, step {step_deg} deg");
            }
        }
    }

    /// Rows on both sides of the cam angle within half a digit, and infeed as the law has it.
    #[test]
    fn a_trace_has_rows_tolerance_and_infeed() {
        let prepared = prepared("four_lobe_camshaft", &[]);
        let traced = trace(&prepared, &request("I1", 2, 143.2)).unwrap();
        let [before, behind] = &traced.lift.rows[..] else { panic!("{:?}", traced.lift) };
        assert!((before.cam_angle_deg..behind.cam_angle_deg).contains(&traced.lift.cam_angle_deg), "{:?}", traced.lift);
        assert!(traced.lift.rows.iter().all(|row| row.deviation_um.abs() <= traced.lift.allowed_um * 1.000_001));
        assert!((before.printed_mm.min(behind.printed_mm) - 0.001..).contains(&traced.lift.lift_mm));
        assert!((traced.infeed.last_turn_um - 36.0).abs() < 1e-6, "{:?}", traced.infeed);
        assert_eq!((traced.speed.law, traced.speed.set_by.as_str()), ("constant_work_speed", "work_speed"));
        assert!((traced.speed.uses[0].1 - 1.0).abs() < 1e-9, "{:?}", traced.speed);
        assert!(traced.to_string().lines().all(|line| line.chars().count() <= 80), "{traced}");
    }

    /// A disc: centre of the wheel at e cos a + √((r + R)² − e² sin² a), contact on the line of centres.
    #[test]
    fn the_trace_of_a_disc_is_its_closed_form() {
        let prepared = prepared("eccentric", &[]);
        let (e, centres) = (4.2_f64, 19.0 + 15.0);
        for c_deg in [0.0, 37.0, 143.2, 270.0] {
            let traced = trace(&prepared, &request("A", 1, c_deg)).unwrap();
            let x_mm = traced.contact.x_mm;
            let cos = (x_mm * x_mm + e * e - centres * centres) / (2.0 * e * x_mm);
            let angle_rad = rad_from_deg(c_deg);
            assert!((cos.abs() - angle_rad.cos().abs()).abs() < 1e-6, "{c_deg}: {x_mm} mm");
            assert!((traced.contact.curvature_1_mm - 1.0 / 19.0).abs() < 1e-9);
            assert!(traced.lift.rows.is_empty() && traced.lift.reading.is_none());
        }
    }

    /// A crank pin in both senses of rotation: X and the contact angle by the triangle of axis, pin and wheel.
    #[test]
    fn the_trace_of_a_crank_pin_is_its_closed_form() {
        let (e, arm) = (40.0_f64, 25.0 + 250.0);
        for sense in [1.0_f64, -1.0] {
            let located = camwright_files::locate::locate("jobs", "crank_pins", "yaml", None).unwrap();
            let mut job = camwright_files::job_file::parse(&located, &[]).unwrap();
            job.machine.description.rotation_sense = if sense > 0.0 { 1 } else { -1 };
            let prepared = AnyPrepared::Ground(Box::new(crate::plan(job, None).unwrap()));
            for (lobe, phase_deg) in [("P1", 0.0), ("P2", 180.0)] {
                for c_deg in [0.0, 37.0, 143.2, 270.0] {
                    let traced = trace(&prepared, &request(lobe, 1, c_deg)).unwrap();
                    let theta = rad_from_deg(sense * c_deg - phase_deg);
                    let x_mm = e * theta.cos() + (arm * arm - (e * theta.sin()).powi(2)).sqrt();
                    let contact = &traced.contact;
                    assert!((contact.x_mm - x_mm).abs() < 1e-8, "{lobe}, {c_deg}: {} {x_mm}", contact.x_mm);
                    let beta_deg = deg_from_rad(-(e * theta.sin() / arm).asin());
                    assert!((contact.angle_deg - beta_deg).abs() < 1e-6, "{lobe}, {c_deg}: {}", contact.angle_deg);
                    assert!((contact.radius_mm - 25.0).abs() < 1e-9 && (contact.throw_mm - 40.0).abs() < 1e-12);
                    let text = traced.to_string();
                    assert!(text.contains("throw 40 mm") && text.contains("smallest possible 15.617 mm"), "{text}");
                }
            }
        }
    }

    #[test]
    fn unknown_lobes_passes_and_turns_are_refused() {
        let ground = prepared("eccentric", &[]);
        let refused = |request: &TraceRequest| trace(&ground, request).unwrap_err().to_string();
        assert_eq!(refused(&request("Z9", 1, 0.0)), "lobe is \"Z9\"; lobes of eccentric: A");
        let rough = TraceRequest { pass: Some("rough".into()), ..request("A", 1, 0.0) };
        assert_eq!(refused(&rough), "pass is \"rough\"; passes of eccentric: grind");
        assert_eq!(refused(&request("A", 14, 0.0)), "turn is 14; pass grind over lobe A has 13 turns, from 1");
        let turned = prepared("turned_cam", &[]);
        assert!(matches!(trace(&turned, &request("A", 1, 0.0)), Err(TraceError::Turned { .. })));
    }
}
