//! What the process allows: the largest speed of C at every path angle.

use crate::job::SpeedLaw;
use crate::numeric::hermite::Sample;

/// How fast the contact runs along the contour per unit of C's speed (mm/rad), from the path of the wheel's cutting point:
/// |W|/(cos β (1 + κR)), with 1/(1 + κR) = 1 − R κc and κc the curvature of the path of the wheel's centre.
#[must_use]
pub fn footprint_speed_ratio_mm(x: Sample, wheel_radius_mm: f64) -> f64 {
    let centre = x.value + wheel_radius_mm;
    let square = centre * centre + x.first * x.first;
    let length = libm::sqrt(square);
    let curvature = (square + x.first * x.first - centre * x.second) / (square * length);
    length * (1.0 - wheel_radius_mm * curvature)
}

/// Specific removal rate Q′ per unit of C's speed (mm²/rad): depth along the contour's normal, which is the infeed of a turn
/// times cos β, times the footprint speed. Exact for stock of constant normal depth; the law ω = k/(ρ dφ/dC) of constant
/// radial stock lacks the cosine of the contour angle.
#[must_use]
pub fn removal_rate_ratio_mm2(x: Sample, wheel_radius_mm: f64, infeed_per_turn_mm: f64) -> f64 {
    let centre = x.value + wheel_radius_mm;
    let cos_beta = centre / libm::hypot(centre, x.first);
    infeed_per_turn_mm * cos_beta * footprint_speed_ratio_mm(x, wheel_radius_mm)
}

/// The largest speed of C that a law of the job allows where the path is at `x` (rad/s).
#[must_use]
pub fn largest_speed_rad_s(law: &SpeedLaw, x: Sample, wheel_radius_mm: f64, infeed_per_turn_mm: f64) -> f64 {
    match *law {
        SpeedLaw::ConstantWorkSpeed { work_speed_rad_s } => work_speed_rad_s,
        SpeedLaw::TimeOptimal { most_rad_s } => most_rad_s,
        SpeedLaw::ConstantFootprintSpeed { footprint_speed_mm_s, most_rad_s } => {
            (footprint_speed_mm_s / footprint_speed_ratio_mm(x, wheel_radius_mm)).min(most_rad_s)
        }
        SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s, most_rad_s } => {
            (removal_rate_mm2_s / removal_rate_ratio_mm2(x, wheel_radius_mm, infeed_per_turn_mm)).min(most_rad_s)
        }
    }
}
