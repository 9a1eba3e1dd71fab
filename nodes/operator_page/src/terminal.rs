//! Content of the page, in lines for a terminal.

use super::status::{AxisLine, Status};
use std::fmt;

impl Status {
    /// Returns true if a machine was found.
    pub fn is_there(&self) -> bool {
        !self.axes.is_empty() || !self.machine.is_empty()
    }

    /// Returns true if an alarm needs a reset.
    pub fn has_alarms(&self) -> bool {
        self.alarms.iter().any(|alarm| alarm.severity != "warning")
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |name: &str, text: String| writeln!(f, "{name:<9} {}", text.trim_end());
        line("state", format!("{}  {}", self.state.word, self.state.detail))?;
        let place = if self.cell.is_empty() { "/" } else { &self.cell };
        line("cell", format!("{place}  {}  machine time {:.3} s", self.machine, self.machine_time_s))?;
        if let Some(job) = &self.job {
            line("job", format!("{}  {:.1} %, {:.1} s left  {}", job.name, job.percent, job.time_left_s, job.message))?;
        }
        if let Some(lobe) = &self.lobe {
            let (number, turn, turns) = (lobe.number, lobe.turn, lobe.turns);
            let count = lobe.count.map_or_else(String::new, |count| format!(" of {count}"));
            let text = format!("{} ({number}{count})  {}, turn {turn:.2} of {turns:.2}", lobe.name, lobe.phase);
            line("lobe", format!("{text}, {:.1} um above the contour", lobe.stock_um))?;
        }
        for result in &self.results {
            let verdict = if result.is_good { "good" } else { "not good" };
            let text = format!("{}  {verdict}  largest error {:+.3} um", result.name, result.error_um);
            line("result", format!("{text}, {:.3} um rms, tolerance {:.1} um", result.rms_um, result.allowed_um))?;
        }
        for AxisLine {
            name,
            position,
            velocity,
            following_error,
            position_unit,
            velocity_unit,
            following_error_unit,
        } in &self.axes
        {
            let text = format!("{name:<13} {position:>10.4} {position_unit:<3} {velocity:>10.3} {velocity_unit:<6}");
            line("axis", format!("{text} lag {following_error:>+9.4} {following_error_unit}"))?;
        }
        let holder = if self.lease.is_empty() { "none" } else { &self.lease };
        line("command", holder.to_owned())?;
        let motion = if self.holder.is_empty() { "none" } else { &self.holder };
        let held = if self.is_held { ", held" } else { "" };
        let homed = if self.is_homed { "homed" } else { "not homed" };
        let over = self.override_percent.map_or_else(String::new, |percent| format!(", override {percent:.0} %"));
        line("motion", format!("{motion}{held}, {homed}{over}"))?;
        if let Some(wheel) = &self.wheel {
            let runs = match wheel.is_running {
                Some(true) => "runs",
                Some(false) => "stopped",
                None => "speed unknown",
            };
            line("wheel", format!("radius {:.4} mm, wear {:.2} um, {runs}", wheel.radius_mm, wheel.wear_um))?;
        }
        for alarm in &self.alarms {
            let text = format!("{} ({}) of {}: {}", alarm.number, alarm.severity, alarm.source, alarm.text);
            line("alarm", format!("{text}; {}", alarm.remedy))?;
        }
        match &self.recorder {
            Some(bag) => {
                let text = format!("{}  {:.1} MB, {} messages", bag.state, bag.megabytes, bag.written);
                line("recorder", format!("{text}, {} dropped  {}", bag.dropped, bag.bag))
            }
            None => line("recorder", "none".into()),
        }
    }
}
