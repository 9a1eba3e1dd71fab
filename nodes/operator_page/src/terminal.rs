// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Content of the page, in lines for a terminal.

use super::status::{AxisLine, Status, Verdict};
use std::fmt;

impl Status {
    /// Returns true if a machine was found.
    pub fn has_machine(&self) -> bool {
        !self.axes.is_empty() || !self.machine.is_empty()
    }

    /// Returns true if the cell does the same as in `other`: times, positions and process values may differ.
    #[must_use]
    pub fn is_same_state(&self, other: &Self) -> bool {
        let lobe = |status: &Self| status.lobe.as_ref().map(|lobe| (lobe.name.clone(), lobe.phase));
        let job = |status: &Self| status.job.as_ref().map(|job| (job.name.clone(), job.message.clone()));
        let wheel = |status: &Self| status.wheel.as_ref().map(|wheel| wheel.is_running);
        let recorder = |status: &Self| status.recorder.as_ref().map(|recorder| recorder.state.clone());
        let command = |status: &Self| (status.holder.clone(), status.lease.clone());
        self.state == other.state
            && self.alarms == other.alarms
            && self.results == other.results
            && self.override_percent == other.override_percent
            && (self.is_held, self.is_homed) == (other.is_held, other.is_homed)
            && (lobe(self), job(self), wheel(self)) == (lobe(other), job(other), wheel(other))
            && (recorder(self), command(self)) == (recorder(other), command(other))
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
        let namespace = if self.cell.is_empty() { "/" } else { &self.cell };
        line("cell", format!("{namespace}  {}  machine time {:.3} s", self.machine, self.machine_time_s))?;
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
            let verdict = match result.verdict {
                Verdict::Good => "GOOD",
                Verdict::Out => "OUT",
                Verdict::Burnt => "BURNT",
            };
            let text = format!("{}  {verdict}  form error {:+.3} um", result.name, result.error_um);
            let burn = result.burn_index.map_or_else(String::new, |burn_index| format!(", burn index {burn_index:.2}"));
            let (rms, allowed) = (result.rms_um, result.allowed_um);
            line("result", format!("{text}, {rms:.3} um rms, tolerance {allowed:.1} um{burn}"))?;
        }
        for AxisLine {
            name,
            position,
            velocity,
            following_error,
            following_error_share,
            position_unit,
            velocity_unit,
            following_error_unit,
        } in &self.axes
        {
            let text = format!("{name:<13} {position:>10.4} {position_unit:<3} {velocity:>10.3} {velocity_unit:<6}");
            let share = following_error_share.map_or_else(String::new, |share| format!(" ({:.0} %)", 100.0 * share));
            line("axis", format!("{text} lag {following_error:>+9.4} {following_error_unit}{share}"))?;
        }
        if let Some(cutting) = self.cutting.as_ref().filter(|cutting| cutting.is_in_contact) {
            let mut values = vec![format!("normal force {:.0} N", cutting.normal_force_n)];
            values.extend(cutting.tangential_force_n.map(|force| format!("tangential {force:.0} N")));
            values.extend(cutting.power_w.map(|power| format!("wheel power {power:.0} W")));
            values.extend(cutting.burn_index.map(|burn_index| format!("burn index {burn_index:.2}")));
            line("cutting", values.join(", "))?;
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
            let name = wheel.name.as_ref().map_or_else(String::new, |name| format!("{name}, "));
            line("wheel", format!("{name}radius {:.4} mm, wear {:.2} um, {runs}", wheel.radius_mm, wheel.wear_um))?;
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
