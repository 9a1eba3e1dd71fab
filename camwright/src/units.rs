//! Units inside the core: mm, rad, s, N, unless a name says otherwise. Angles of people are degrees, positions of
//! encoders are counts; both are converted here and nowhere else.

use core::f64::consts::PI;

/// One turn (rad).
pub const TURN_RAD: f64 = 2.0 * PI;

/// Degrees to radians.
#[must_use]
pub fn rad_from_deg(deg: f64) -> f64 {
    deg * (PI / 180.0)
}

/// Radians to degrees.
#[must_use]
pub fn deg_from_rad(rad: f64) -> f64 {
    rad * (180.0 / PI)
}

/// Millimetres to micrometres.
#[must_use]
pub fn um_from_mm(mm: f64) -> f64 {
    mm * 1000.0
}

/// Micrometres to millimetres.
#[must_use]
pub fn mm_from_um(um: f64) -> f64 {
    um / 1000.0
}

/// Revolutions per minute to radians per second.
#[must_use]
pub fn rad_s_from_rpm(rpm: f64) -> f64 {
    rpm * (TURN_RAD / 60.0)
}

/// Radians per second to revolutions per minute.
#[must_use]
pub fn rpm_from_rad_s(rad_s: f64) -> f64 {
    rad_s * (60.0 / TURN_RAD)
}

/// Wraps an angle into `[0, 2 pi)`.
#[must_use]
pub fn wrap_turn(rad: f64) -> f64 {
    let wrapped = rad - TURN_RAD * libm::floor(rad / TURN_RAD);
    // A tiny negative angle rounds up to a whole turn, which is the same place as zero.
    if wrapped >= TURN_RAD { 0.0 } else { wrapped }
}
