//! From penetration to removal: the place where the contact between wheel and part becomes elastic one day.

/// How wheel and part give way to each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Contact {
    /// Neither gives way: what the wheel would penetrate is gone.
    #[default]
    Rigid,
}

impl Contact {
    /// Depth removed (mm) where the undeflected wheel would penetrate the part by `penetration_mm`.
    #[must_use]
    pub fn removed_mm(self, penetration_mm: f64) -> f64 {
        match self {
            Contact::Rigid => penetration_mm,
        }
    }
}
