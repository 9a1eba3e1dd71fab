// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Course of a groove round a cylinder: the centre of its roller over the azimuth, closed after whole turns or with two ends.
//!
//! A roller on a slide stands at y = 0 and z = s(φ). On a turret of radius R, whose axis is parallel to the roller's at y = C, the lift is the
//! arc of the roller's centre, and with the turret's angle ψ = ψ₀ + s/R
//!
//! ```text
//! z = R sin ψ      y = C − R cos ψ        (C > 0; with C < 0: y = C + R cos ψ)
//! ```

use super::{GrooveError, positive};
use crate::cam::lift::{LiftLaw, MAX_PROGRAM_TURNS, MotionProgram};
use crate::math::hermite::Sample;
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;

/// Turret that carries the rollers of an indexing cam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turret {
    /// Number of rollers, evenly spaced.
    pub stations: u32,
    /// Distance of a roller's centre from the turret's axis (mm).
    pub radius_mm: f64,
    /// Y of the turret's axis (mm): the centre distance, positive towards growing azimuth.
    pub axis_y_mm: f64,
    /// Angle of the roller at lift 0, from the line through both axes towards +Z (rad).
    pub start_rad: f64,
}

impl Turret {
    /// Angle from roller to roller (rad).
    #[must_use]
    pub fn station_rad(&self) -> f64 {
        TURN_RAD / f64::from(self.stations)
    }

    /// Y and Z of a roller's centre at an angle of the turret (mm), Z from its axis.
    #[must_use]
    pub fn place_mm(&self, roller_rad: f64) -> [f64; 2] {
        let towards = if self.axis_y_mm < 0.0 { -1.0 } else { 1.0 };
        let (sin, cos) = (libm::sin(roller_rad), libm::cos(roller_rad));
        [self.axis_y_mm - towards * self.radius_mm * cos, self.radius_mm * sin]
    }
}

/// Centre of the roller at an azimuth, with derivatives (mm over rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollerCentre {
    /// Across the radial line.
    pub y: Sample,
    /// Along the part.
    pub z: Sample,
}

#[derive(Debug, Clone, PartialEq)]
enum CourseLift {
    /// One turn of the law is so many turns of the part.
    Closed { law: LiftLaw, turns: u32 },
    /// A program with two ends.
    Open(MotionProgram),
}

/// Course of a groove's roller.
#[derive(Debug, Clone, PartialEq)]
pub struct GrooveCourse {
    lift: CourseLift,
    turret: Option<Turret>,
}

/// Steps of a grid over one turn of an open course.
const STEPS_PER_TURN: usize = 7200;

impl GrooveCourse {
    /// The course of a roller on a slide that closes after so many turns, over which the law is read.
    ///
    /// # Errors
    /// No turns, or too many.
    pub fn closed(law: &LiftLaw, turns: u32) -> Result<Self, GrooveError> {
        if !(1..=MAX_PROGRAM_TURNS).contains(&turns) {
            return Err(GrooveError::TurnCount { turns, max: MAX_PROGRAM_TURNS });
        }
        Ok(Self { lift: CourseLift::Closed { law: law.clone(), turns }, turret: None })
    }

    /// The course of a roller on a slide with the ends of an open program.
    ///
    /// # Errors
    /// A program that closes.
    pub fn open(program: MotionProgram) -> Result<Self, GrooveError> {
        if !program.is_open() {
            return Err(GrooveError::NoEnds);
        }
        Ok(Self { lift: CourseLift::Open(program), turret: None })
    }

    /// The same lift as the arc of a roller on a turret.
    ///
    /// # Errors
    /// A radius, a centre distance or a number of stations that is none; a roller that turns to the side or behind the turret's axis; turns of
    /// an open course that are not whole stations apart.
    pub fn on_turret(self, turret: Turret) -> Result<Self, GrooveError> {
        positive("the radius of the turret", turret.radius_mm)?;
        if turret.stations == 0 {
            return Err(GrooveError::NoStations);
        }
        let distance_mm = turret.axis_y_mm;
        if !distance_mm.is_finite() || distance_mm.abs() <= 0.0 {
            let (what, bound) = ("Y of the turret's axis", "a number other than 0");
            return Err(GrooveError::BadNumber { what, value: distance_mm, bound });
        }
        if !turret.start_rad.is_finite() {
            let (what, bound) = ("the angle of the turret at lift 0", "a number");
            return Err(GrooveError::BadNumber { what, value: turret.start_rad, bound });
        }
        let course = Self { lift: self.lift, turret: Some(turret) };
        let (low_mm, high_mm) = course.lift_range_mm();
        for lift_mm in [low_mm, high_mm] {
            let angle_rad = turret.start_rad + lift_mm / turret.radius_mm;
            if angle_rad.is_nan() || angle_rad.abs() >= MAX_TURRET_RAD {
                return Err(GrooveError::TurretTurnsAway {
                    angle_deg: deg_from_rad(angle_rad),
                    max_deg: deg_from_rad(MAX_TURRET_RAD),
                });
            }
        }
        course.check_stations(&turret)?;
        Ok(course)
    }

    /// Refuses an open course whose turns do not lie whole stations apart: the rollers behind one follow it a turn later.
    fn check_stations(&self, turret: &Turret) -> Result<(), GrooveError> {
        if !self.is_open() {
            return Ok(());
        }
        let steps = 720 * (self.turns() - 1);
        let turned_rad = |azimuth_rad: f64| {
            let turned_mm = self.lift(azimuth_rad + TURN_RAD).value - self.lift(azimuth_rad).value;
            turned_mm / turret.radius_mm
        };
        for step in 0..=steps {
            let azimuth_rad = f64::from(step) * TURN_RAD / 720.0;
            let turned_rad = turned_rad(azimuth_rad);
            let stations = libm::round(turned_rad / turret.station_rad());
            let off_rad = (turned_rad - stations * turret.station_rad()).abs();
            if stations == 0.0 || off_rad.is_nan() || off_rad > STATION_CLOSURE_RAD {
                return Err(GrooveError::Stations {
                    turned_deg: deg_from_rad(turned_rad),
                    azimuth_deg: deg_from_rad(azimuth_rad),
                    stations: turret.stations,
                    station_deg: deg_from_rad(turret.station_rad()),
                });
            }
        }
        Ok(())
    }

    /// Azimuth over which it runs (rad).
    #[must_use]
    pub fn span_rad(&self) -> f64 {
        f64::from(self.turns()) * TURN_RAD
    }

    /// Turns of the part over which it runs.
    #[must_use]
    pub fn turns(&self) -> u32 {
        match &self.lift {
            CourseLift::Closed { turns, .. } => *turns,
            CourseLift::Open(program) => program.turns(),
        }
    }

    /// Returns whether it has two ends: azimuth 0 and [`Self::span_rad`].
    #[must_use]
    pub fn is_open(&self) -> bool {
        matches!(self.lift, CourseLift::Open(_))
    }

    /// The turret that carries the roller; `None` for a roller on a slide.
    #[must_use]
    pub fn turret(&self) -> Option<Turret> {
        self.turret
    }

    /// Angle of the roller on its turret at an azimuth (rad); 0 for a roller on a slide.
    #[must_use]
    pub fn turret_angle_rad(&self, azimuth_rad: f64) -> f64 {
        self.turret.map_or(0.0, |turret| turret.start_rad + self.lift(azimuth_rad).value / turret.radius_mm)
    }

    /// Steps of a grid over all of it.
    #[must_use]
    pub fn grid(&self) -> usize {
        let turns = usize::try_from(self.turns()).unwrap_or(1);
        match &self.lift {
            CourseLift::Closed { law, .. } => law.grid().max(turns * STEPS_PER_TURN),
            CourseLift::Open(_) => turns * STEPS_PER_TURN,
        }
    }

    /// Azimuths at which acceleration or jerk may jump (rad).
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        match &self.lift {
            CourseLift::Closed { law, turns } => {
                law.breaks().into_iter().map(|angle_rad| angle_rad * f64::from(*turns)).collect()
            }
            CourseLift::Open(program) => program.joints().collect(),
        }
    }

    /// Lift and derivatives at an azimuth (mm over rad); beyond an end those of the end.
    #[must_use]
    pub fn lift(&self, azimuth_rad: f64) -> Sample {
        match &self.lift {
            CourseLift::Closed { law, turns } => {
                let turns = f64::from(*turns);
                law.sample(azimuth_rad / turns).stretched(turns)
            }
            CourseLift::Open(program) => program.sample(azimuth_rad),
        }
    }

    /// Centre of the roller at an azimuth; Z from that of lift 0, on a turret from the turret's axis.
    #[must_use]
    pub fn centre(&self, azimuth_rad: f64) -> RollerCentre {
        let lift = self.lift(azimuth_rad);
        let Some(Turret { radius_mm, axis_y_mm, start_rad, .. }) = self.turret else {
            return RollerCentre { y: Sample::default(), z: lift };
        };
        let (angle, first, second, third) = (
            start_rad + lift.value / radius_mm,
            lift.first / radius_mm,
            lift.second / radius_mm,
            lift.third / radius_mm,
        );
        let (sin, cos) = (radius_mm * libm::sin(angle), radius_mm * libm::cos(angle));
        let z = Sample {
            value: sin,
            first: cos * first,
            second: cos * second - sin * first * first,
            third: cos * third - 3.0 * sin * first * second - cos * first * first * first,
        };
        let towards = if axis_y_mm < 0.0 { -1.0 } else { 1.0 };
        let y = Sample {
            value: axis_y_mm - towards * cos,
            first: towards * sin * first,
            second: towards * (sin * second + cos * first * first),
            third: towards * (sin * third + 3.0 * cos * first * second - sin * first * first * first),
        };
        RollerCentre { y, z }
    }

    /// Smallest and largest Z of the roller's centre (mm), from that of lift 0 or from the turret's axis.
    #[must_use]
    pub fn z_range_mm(&self) -> (f64, f64) {
        let (low_mm, high_mm) = self.lift_range_mm();
        match self.turret {
            None => (low_mm, high_mm),
            // Within a quarter turn to either side the sine grows.
            Some(turret) => {
                let z = |lift_mm: f64| turret.radius_mm * libm::sin(turret.start_rad + lift_mm / turret.radius_mm);
                (z(low_mm), z(high_mm))
            }
        }
    }

    /// Smallest and largest lift (mm).
    fn lift_range_mm(&self) -> (f64, f64) {
        match &self.lift {
            CourseLift::Closed { law, .. } => (law.min_lift_mm(), law.max_lift_mm()),
            CourseLift::Open(_) => {
                let smallest = |sign: f64| {
                    let lift = |azimuth: f64| sign * self.lift(azimuth).value;
                    crate::math::extremum::smallest_over_period(self.span_rad(), self.grid(), &self.breaks(), lift)
                };
                // The ends of an open course are places of no grid.
                let end_mm = self.lift(self.span_rad()).value;
                (smallest(1.0).value.min(end_mm), (-smallest(-1.0).value).max(end_mm))
            }
        }
    }
}

/// Error of the angle between rollers in a groove that is accepted (rad): sums of decimal figures.
pub(super) const STATION_CLOSURE_RAD: f64 = 1e-8;

/// A roller on a turret stays within this angle of the line through both axes (rad): beyond a quarter turn it would go back.
const MAX_TURRET_RAD: f64 = 0.5 * core::f64::consts::PI;
