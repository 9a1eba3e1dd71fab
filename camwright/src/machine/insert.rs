//! What a lathe turns with: a round insert that a spindle of its own rotates.

use crate::machine::description::{MachineDescription, WheelDescription};
use crate::machine::description_error::{DescriptionError, ordered};
use crate::math::units::TURN_RAD;

/// A round, driven insert, as JP2012-71381A turns parts that are not round with. A machine with one is a lathe.
///
/// The insert turns about the normal of its rake face, so its edge stays the same circle; where it stands is its centre.
/// ```text
///        y
///        │    part turns, the surface comes down on the rake face when H is below the axis
///  ──────●─────────── x
///        │     ╲
///      H ┼──────●═══════  rake face, towards +y
///        │      ╲│        flank, by the relief angle off the normal of the rake face
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsertDescription {
    /// R, radius of the edge (mm).
    pub radius_mm: f64,
    /// H, height of the rake face above the part's axis (mm); below it negative.
    pub height_mm: f64,
    /// Between which heights the tool can be set (mm).
    pub height_range_mm: (f64, f64),
    /// γ, how far the flank leans back from the normal of the rake face (rad).
    pub relief_rad: f64,
    /// Speed of the edge along itself when the insert runs (m/s).
    pub surface_speed_m_s: f64,
    /// Time to reach its speed or to come to rest (s).
    pub spin_up_s: f64,
    /// Fastest its spindle may turn (rad/s); `None` where nobody says.
    pub max_speed_rad_s: Option<f64>,
}

impl InsertDescription {
    /// The insert as what a spindle rotates: as wide along the part as its edge, without wear or unbalance.
    ///
    /// The drive of a lathe's insert is that of a grinder's wheel, so are its speed, its orders and its alarms.
    #[must_use]
    pub fn tool(&self) -> WheelDescription {
        WheelDescription {
            new_radius_mm: self.radius_mm,
            min_radius_mm: self.radius_mm,
            width_mm: 2.0 * self.radius_mm,
            surface_speed_m_s: self.surface_speed_m_s,
            spin_up_s: self.spin_up_s,
            max_surface_speed_m_s: None,
            max_speed_rad_s: self.max_speed_rad_s,
            grinding_ratio: None,
            unbalance_mm: 0.0,
        }
    }

    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        let positive = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::NotPositive { what, value }),
        };
        positive("radius of the insert (mm)", self.radius_mm)?;
        positive("surface speed of the insert (m/s)", self.surface_speed_m_s)?;
        let (low, high) = self.height_range_mm;
        for (what, value) in
            [("lowest height of the rake face (mm)", low), ("highest height of the rake face (mm)", high)]
        {
            if !value.is_finite() {
                return Err(DescriptionError::NotFinite { what, value });
            }
        }
        ordered("heights of the rake face (mm)", low, high)?;
        if !(low..=high).contains(&self.height_mm) {
            let (what, value) = ("height of the rake face (mm)", self.height_mm);
            return Err(DescriptionError::Outside { what, value, low, high });
        }
        let (what, value) = ("relief angle of the insert (rad)", self.relief_rad);
        match (0.0..0.25 * TURN_RAD).contains(&value) {
            true => Ok(()),
            false => Err(DescriptionError::Outside { what, value, low: 0.0, high: 0.25 * TURN_RAD }),
        }
    }
}

impl MachineDescription {
    /// Whether it turns with an insert; otherwise it grinds with a wheel.
    #[must_use]
    pub fn is_lathe(&self) -> bool {
        self.insert.is_some()
    }

    /// This lathe with the rake face set to another height (mm).
    ///
    /// # Errors
    /// A height that the tool cannot be set to; a grinder.
    pub fn with_rake_height(mut self, height_mm: f64) -> Result<Self, DescriptionError> {
        let Some(insert) = &mut self.insert else {
            return Err(DescriptionError::NotALathe);
        };
        insert.height_mm = height_mm;
        insert.validate()?;
        Ok(self)
    }

    /// A lathe's rotating tool is its insert, and it has nothing of what only a grinder is simulated with: what is cut does not give way,
    /// nothing measures it and nothing dresses.
    pub(super) fn validate_insert(&self) -> Result<(), DescriptionError> {
        let Some(insert) = &self.insert else { return Ok(()) };
        insert.validate()?;
        let only = [
            (self.wheel != insert.tool(), "a wheel"),
            (self.contact.is_some(), "a contact"),
            (self.thermal.is_some(), "a wheelhead that grows"),
            (self.gauge.is_some(), "a gauge"),
            (self.gap_detector.is_some(), "a gap detector"),
            (self.process.is_some(), "a grinding process"),
            (self.dresser.is_some(), "a dresser"),
        ];
        match only.into_iter().find(|(has, _)| *has) {
            Some((_, what)) => Err(DescriptionError::OnlyOfAGrinder { what }),
            None => Ok(()),
        }
    }
}
