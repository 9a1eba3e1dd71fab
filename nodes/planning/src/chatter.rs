// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Chatter forecast of a planned job: `camwright chatter`.

use super::PreparedJob;
use super::drawing::{png, svg};
use super::files::Files;
use super::plots::stability_plot;
use camwright::cam::wave_cause::WaveCause;
use camwright::job::speed_variation::SpeedVariation;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::math::units::{TURN_RAD, rpm_from_rad_s};
use camwright::planner::PlannedLobe;
use camwright::planner::chatter::{ChatterForecast, ChatterRequest, ContactCompliance, SpeedRange, WaveGrowth};
use camwright_files::{ConfigError, FileLocation};
use serde::Serialize;
use std::borrow::Cow;
use std::path::Path;

/// Work speeds of the plot and of the search for stable ones, relative to the planned one.
const SLOWEST: f64 = 0.25;
const FASTEST: f64 = 2.0;

/// Azimuths of a mean radius.
const AZIMUTHS: u32 = 72;

/// Decibels of a ratio of amplitudes.
fn decibels(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

/// Chatter forecast of a job.
#[derive(Debug, Clone, Serialize)]
pub struct ChatterReport {
    pub job: String,
    pub machine: String,
    /// No wave of any pass grows, with the variation of the work speed if the job has it.
    pub is_stable: bool,
    /// Variation of the work speed whose effect the passes state.
    pub variation: VariationSummary,
    /// Friction that holds the slide of the wheelhead against a smaller change of force; 0: none.
    pub x_friction_n: f64,
    pub passes: Vec<PassChatter>,
}

/// Variation of the work speed: half of each period is slower.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VariationSummary {
    pub slower_percent: f64,
    pub period_turns: f64,
    /// The job has it; otherwise it is compared only.
    pub is_of_job: bool,
}

impl VariationSummary {
    /// Variation of the job if it has one.
    #[must_use]
    pub fn of_job(prepared: &PreparedJob) -> Option<Self> {
        let variation = prepared.job.spec.speed_variation?;
        let slower_percent = 100.0 * variation.slower;
        Some(Self { slower_percent, period_turns: variation.period_turns, is_of_job: true })
    }
}

/// Wave with its growth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WaveSummary {
    pub frequency_hz: f64,
    /// Waves in a turn of the part, or of the wheel for its own.
    pub waves_per_turn: f64,
    /// Factor of the amplitude per turn; above 1 it grows.
    pub growth_per_turn: f64,
    pub growth_per_s: f64,
}

impl From<WaveGrowth> for WaveSummary {
    fn from(wave: WaveGrowth) -> Self {
        Self {
            frequency_hz: wave.frequency_hz,
            waves_per_turn: wave.waves_per_turn,
            growth_per_turn: wave.per_turn,
            growth_per_s: wave.per_s,
        }
    }
}

/// Forecast of one pass of one lobe.
#[derive(Debug, Clone, Serialize)]
pub struct PassChatter {
    pub lobe: String,
    pub pass: String,
    /// Speed of a turn in the mean, and the slowest and the fastest within it.
    pub work_speed_rpm: f64,
    pub speed_range_rpm: [f64; 2],
    pub is_stable: bool,
    /// Wave of the part that grows fastest or decays slowest.
    pub part: Option<WaveSummary>,
    /// Its length on the part, and the length of the contact, which wipes shorter waves out.
    pub wave_mm: Option<f64>,
    pub contact_mm: f64,
    /// The same of the wheel; none of a wheel that does not wear.
    pub wheel: Option<WaveSummary>,
    /// Factor that a turn leaves of long waves and of runout.
    pub long_waves_per_turn: f64,
    pub width_mm: f64,
    /// Width at which the cut begins to chatter at this speed, and at some speed; none where no width does.
    pub limit_width_mm: Option<f64>,
    pub unconditional_width_mm: Option<f64>,
    /// The first of them over the width; above 1 the cut is stable.
    pub margin: Option<f64>,
    pub margin_db: Option<f64>,
    /// Nearest stable speeds of a cut that chatters.
    pub stable_below_rpm: Option<f64>,
    pub stable_above_rpm: Option<f64>,
    /// Mean growth of the worst wave per turn while the work speed varies.
    pub varied_growth_per_turn: f64,
    #[serde(skip)]
    pub(crate) forecast: ChatterForecast,
    #[serde(skip)]
    pub(crate) range: SpeedRange,
    #[serde(skip)]
    pub(crate) grinding_n_mm2: f64,
}

/// Forecasts the chatter of every pass of a job, with the effect of a variation of its work speed.
///
/// # Errors
/// A machine without a contact.
pub fn chatter(prepared: &PreparedJob, variation: VariationSummary) -> Result<ChatterReport, ConfigError> {
    let machine = &prepared.machine;
    if let Some(index) = prepared.job.spec.profiles.iter().position(|profile| profile.is_bore) {
        let message = "the job grinds an internal contour, for which there is no forecast of chatter";
        return Err(prepared.job.document.error(&format!("profiles.{index}.internal"), message));
    }
    let mut passes = Vec::new();
    for (index, lobe) in prepared.planned.lobes.iter().enumerate() {
        for pass in 0..lobe.passes.len() {
            let forecast = pass_chatter(prepared, (index, pass), variation).ok_or_else(|| {
                let message = format!(
                    "machine {} is rigid, so nothing can chatter; `contact` with machine_stiffness and grinding_stiffness_n_um_mm \
                     describes what deflects (docs/guides/chatter.md)",
                    machine.name
                );
                ConfigError::at(FileLocation::file(&prepared.job.machine.path), message)
            })?;
            passes.push(forecast);
        }
    }
    Ok(ChatterReport {
        job: prepared.planned.plan.job.clone(),
        machine: machine.name.clone(),
        is_stable: passes.iter().all(|pass| pass.is_stable),
        variation,
        x_friction_n: machine.axis(Axis::X).drive.coulomb_friction,
        passes,
    })
}

/// The machine with the wheel of a lobe mounted.
fn of_wheel<'a>(prepared: &'a PreparedJob, lobe: &PlannedLobe) -> Cow<'a, MachineDescription> {
    let machine = &prepared.machine;
    let wheel = lobe.design.wheel(machine);
    if wheel == machine.mounted_wheel() {
        return Cow::Borrowed(machine);
    }
    let mut mounted = machine.clone();
    // A plan has no other wheels than those of its machine.
    match mounted.mount_wheel(wheel) {
        Ok(()) => Cow::Owned(mounted),
        Err(_) => Cow::Borrowed(machine),
    }
}

/// Forecast of a pass of a lobe; `None` on a rigid machine and for a bore.
fn forecast_of(prepared: &PreparedJob, lobe: &PlannedLobe, pass: usize) -> Option<ChatterForecast> {
    if lobe.design.contour.is_bore() {
        return None;
    }
    let (design, speed) = (&lobe.design, lobe.passes.get(pass)?);
    let radii = (0..AZIMUTHS).map(|i| design.contour.radius_at(f64::from(i) * TURN_RAD / f64::from(AZIMUTHS)));
    ChatterForecast::new(&ChatterRequest {
        machine: &of_wheel(prepared, lobe),
        station: &design.station,
        part_mm_n: design.part_compliance_mm_n(&prepared.machine, 0.0),
        width_mm: design.width_mm,
        radius_mm: radii.sum::<f64>() / f64::from(AZIMUTHS),
        wheel_radius_mm: lobe.tool_path.wheel_radius_mm(),
        turn_s: speed.turn_s(),
        infeed_per_turn_mm: speed.infeed().schedule().max_per_turn_mm(),
    })
}

/// No wave grows at the work speed, or none grows in the mean of the speeds between which the job varies it.
fn is_stable(prepared: &PreparedJob, forecast: &ChatterForecast) -> bool {
    let is_calmed = |variation: &SpeedVariation| forecast.cut.varied_growth(variation).0 <= 1.0;
    forecast.is_stable() || prepared.job.spec.speed_variation.as_ref().is_some_and(is_calmed)
}

/// Causes of waves that the last pass of a lobe left on the part, one for each number of waves per turn.
#[must_use]
pub fn wave_causes(prepared: &PreparedJob, lobe: &PlannedLobe, waves_per_turn: &[usize]) -> Vec<Option<WaveCause>> {
    let Some(last) = lobe.passes.len().checked_sub(1) else { return vec![None; waves_per_turn.len()] };
    let machine = of_wheel(prepared, lobe);
    let wheel_radius_mm = lobe.tool_path.wheel_radius_mm();
    let forecast = forecast_of(prepared, lobe, last);
    let of_part = |forecast: &ChatterForecast| match is_stable(prepared, forecast) {
        true => Vec::new(),
        false => forecast.cut.part_waves(),
    };
    let waves = forecast.iter().flat_map(|forecast| of_part(forecast).into_iter().chain(forecast.wheel));
    let growing: Vec<f64> = waves.filter(WaveGrowth::is_growing).map(|wave| wave.frequency_hz * TURN_RAD).collect();
    let speeds = lobe.passes[last].speed_range_rad_s();
    let cause = |waves: &usize| WaveCause::find(*waves, speeds, &machine, wheel_radius_mm, &growing);
    waves_per_turn.iter().map(cause).collect()
}

/// Warning for the pass whose waves grow fastest, if any grow.
pub(super) fn chatter_warning(prepared: &PreparedJob) -> Option<String> {
    let machine = &prepared.machine;
    let mut worst: Option<(f64, String)> = None;
    for (index, lobe) in prepared.planned.lobes.iter().enumerate() {
        let design = &lobe.design;
        let (law, station) = (
            of_wheel(prepared, lobe).contact_law(&design.station, design.width_mm)?,
            machine.station(&design.station)?,
        );
        let compliance = ContactCompliance::from_machine(machine, station.position_mm)?;
        let limit = compliance.with_part(design.part_compliance_mm_n(machine, 0.0)).unconditional_n_mm();
        // Stable at every speed: no root needs to be found.
        if limit.is_none_or(|limit| law.grinding_n_mm() < limit) {
            continue;
        }
        for pass in 0..lobe.passes.len() {
            let Some(forecast) = forecast_of(prepared, lobe, pass) else { continue };
            let Some(wave) = forecast.part.filter(|_| !is_stable(prepared, &forecast)) else { continue };
            if worst.as_ref().is_none_or(|(growth, _)| wave.per_turn > *growth) {
                let message = format!(
                    "lobe {}, pass {}: chatter; waves of {:.0} Hz, {:.0} in a turn, grow {:.2} times per turn; \
                     `camwright chatter` shows what is stable",
                    design.name,
                    prepared.job.spec.passes_of(index)[pass].name,
                    wave.frequency_hz,
                    wave.waves_per_turn,
                    wave.per_turn
                );
                worst = Some((wave.per_turn, message));
            }
        }
    }
    worst.map(|(_, message)| message)
}

fn pass_chatter(
    prepared: &PreparedJob,
    (index, pass): (usize, usize),
    variation: VariationSummary,
) -> Option<PassChatter> {
    let lobe = prepared.planned.lobes.get(index)?;
    let (machine, design, speed) = (&prepared.machine, &lobe.design, lobe.passes.get(pass)?);
    let turn_s = speed.turn_s();
    let forecast = forecast_of(prepared, lobe, pass)?;
    let planned_rad_s = TURN_RAD / turn_s;
    let range = SpeedRange {
        slowest_rad_s: SLOWEST * planned_rad_s,
        fastest_rad_s: (FASTEST * planned_rad_s).min(machine.axis(Axis::C).limits.velocity).max(planned_rad_s),
    };
    let is_stable = is_stable(prepared, &forecast);
    let (below, above) = if is_stable { (None, None) } else { forecast.nearest_stable_rad_s(range) };
    let grinding_n_mm2 = machine.contact.as_ref()?.grinding_n_mm2;
    let finite = |value: f64| value.is_finite().then_some(value);
    let (slowest, fastest) = speed.speed_range_rad_s();
    let varied = SpeedVariation { slower: 0.01 * variation.slower_percent, period_turns: variation.period_turns };
    Some(PassChatter {
        lobe: design.name.clone(),
        pass: prepared.job.spec.passes_of(index).get(pass)?.name.clone(),
        work_speed_rpm: rpm_from_rad_s(planned_rad_s),
        speed_range_rpm: [rpm_from_rad_s(slowest), rpm_from_rad_s(fastest)],
        is_stable,
        part: forecast.part.map(WaveSummary::from),
        wave_mm: forecast.wave_mm,
        contact_mm: forecast.contact_mm,
        wheel: forecast.wheel.map(WaveSummary::from),
        long_waves_per_turn: forecast.long_waves_per_turn,
        width_mm: design.width_mm.min(of_wheel(prepared, lobe).wheel.width_mm),
        limit_width_mm: finite(forecast.boundary.grinding_n_mm / grinding_n_mm2),
        unconditional_width_mm: forecast.cut.unconditional_n_mm().map(|limit| limit / grinding_n_mm2),
        margin: finite(forecast.margin()),
        margin_db: finite(decibels(forecast.margin())),
        stable_below_rpm: below.map(rpm_from_rad_s),
        stable_above_rpm: above.map(rpm_from_rad_s),
        varied_growth_per_turn: forecast.cut.varied_growth(&varied).0,
        forecast,
        range,
        grinding_n_mm2,
    })
}

impl ChatterReport {
    /// Pass nearest to chatter, or deepest in it.
    #[must_use]
    pub fn worst(&self) -> Option<&PassChatter> {
        let growth = |pass: &PassChatter| pass.part.map_or(0.0, |wave| wave.growth_per_turn);
        // The first of equal ones.
        self.passes.iter().rev().max_by(|one, other| growth(one).total_cmp(&growth(other)))
    }

    /// Writes the stability lobes of the worst pass as a drawing, SVG or PNG by the name of the file.
    ///
    /// # Errors
    /// Another file name, a file that cannot be written, a report without passes.
    pub fn write_plot(&self, path: &Path) -> Result<(), ConfigError> {
        let refused = |message: String| ConfigError::at(FileLocation::file(path), message);
        let pass = self.worst().ok_or_else(|| refused(String::from("the job has no pass to draw")))?;
        let drawing = stability_plot(self, pass);
        let mut files = Files::new(|_: &Path| {});
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => files.write(path, &|to| to.write_all(svg(&drawing).as_bytes())),
            Some("png") => files.write(path, &|to| to.write_all(&png(&drawing)?)),
            _ => Err(refused(String::from("a plot is an .svg or a .png file; name it so, for example lobes.svg"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare;
    use camwright::cam::lobe_inspection::LobeInspection;
    use camwright::machine::description::ContactMode;

    const VARIATION: VariationSummary = VariationSummary { slower_percent: 25.0, period_turns: 2.0, is_of_job: false };

    fn with_mode(job: &str, mode: Option<(f64, f64, f64)>) -> PreparedJob {
        let mut prepared = prepare(job, &[], None).unwrap();
        if let Some((frequency_hz, damping, compliance_share)) = mode {
            let contact = prepared.machine.contact.as_mut().unwrap();
            let frequency_rad_s = frequency_hz * TURN_RAD;
            let mode = ContactMode { frequency_rad_s, damping, compliance_share };
            contact.modes = vec![mode];
        }
        prepared
    }

    fn report(job: &str, mode: Option<(f64, f64, f64)>) -> ChatterReport {
        chatter(&with_mode(job, mode), VARIATION).unwrap()
    }

    /// The check of a job warns about the worst pass, and about no stable one.
    #[test]
    fn a_job_that_chatters_is_warned_about() {
        assert_eq!(chatter_warning(&with_mode("journal_runout", None)), None);
        let warned = chatter_warning(&with_mode("journal_runout", Some((140.0, 0.03, 0.6)))).unwrap();
        let worst = report("journal_runout", Some((140.0, 0.03, 0.6)));
        let worst = worst.worst().unwrap();
        assert!(warned.contains(&format!("lobe {}, pass {}", worst.lobe, worst.pass)), "{warned}");
    }

    /// Every pass of every lobe, stable on the machines as they come; a soft mode makes the widest cut chatter, and a varying speed helps.
    #[test]
    fn a_soft_mode_makes_a_journal_chatter_and_a_varying_speed_helps() {
        let calm = report("journal_runout", None);
        assert_eq!(calm.passes.len(), 6);
        assert!(calm.is_stable, "{:?}", calm.worst());
        let chattering = report("journal_runout", Some((140.0, 0.03, 0.6)));
        assert!(!chattering.is_stable);
        let worst = chattering.worst().unwrap();
        let wave = worst.part.unwrap();
        assert!(worst.margin.unwrap() < 1.0 && wave.growth_per_turn > 1.0, "{worst:?}");
        assert!((wave.waves_per_turn - wave.frequency_hz * 60.0 / worst.work_speed_rpm).abs() < 1e-6, "{wave:?}");
        assert!(worst.varied_growth_per_turn < wave.growth_per_turn, "{worst:?}");
        assert!(worst.unconditional_width_mm.unwrap() <= worst.limit_width_mm.unwrap() * 1.001);
    }

    /// Amplitude of so many waves per turn on a journal of 20 mm.
    fn wave_mm(radii: &[f64], per_turn: f64) -> f64 {
        let part = |of: fn(f64) -> f64| {
            let angle = |i: usize| per_turn * TURN_RAD * i as f64 / radii.len() as f64;
            let sum: f64 = radii.iter().enumerate().map(|(i, radius)| (radius - 20.0) * of(angle(i))).sum();
            2.0 * sum / radii.len() as f64
        };
        part(f64::cos).hypot(part(f64::sin))
    }

    /// Amplitude of 60 waves on the first journal of a job that ends with so many turns of spark-out (mm), and the forecast of its growth.
    fn left_of_planted_waves(spark_out_turns: u32, coulomb_friction: f64) -> (f64, f64) {
        let set = [
            format!("infeed.spark_out_turns={spark_out_turns}"),
            "runout_correction=null".to_owned(),
            "identification=null".to_owned(),
            "raw_part={lobes: [{count: 60, um: 2.0}]}".to_owned(),
            "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0.0, width_mm: 20.0}]".to_owned(),
        ];
        let prepared = prepare("journal_runout", &set, None).unwrap();
        let mut machine = prepared.machine.clone();
        let drive = &mut machine.axes[Axis::X.index()].drive;
        drive.coulomb_friction = coulomb_friction;
        let (_, _, outlines) = crate::simulate_outlines_on(&prepared, &machine, |_, _| {}).unwrap();
        let forecast = forecast_of(&prepared, &prepared.planned.lobes[0], 1).unwrap();
        let per_turn = forecast.cut.planted_wave_per_turn(60.0, TURN_RAD / forecast.cut.turn_s);
        (wave_mm(&outlines[0], 60.0), per_turn)
    }

    /// Three more turns of spark-out in a planned job shrink planted waves by the forecast, or by the contact law while friction holds the
    /// slide of the wheelhead.
    #[test]
    fn planted_waves_of_a_job_shrink_in_spark_out_as_forecast() {
        for (coulomb_friction, holds) in [(0.0, false), (20.0, true)] {
            let (few, forecast) = left_of_planted_waves(3, coulomb_friction);
            let (many, _) = left_of_planted_waves(6, coulomb_friction);
            let (found, wanted) = ((many / few).cbrt(), if holds { 30.0 / 36.0 } else { forecast });
            assert!(few > 5e-5 && many < few, "{few} mm, {many} mm");
            assert!((found / wanted - 1.0).abs() < 0.015, "friction {coulomb_friction} N: {found}, {wanted}");
        }
    }

    /// Waves of a journal that chatters have the forecast number in a turn within 3 %, and its growth as their cause. The same job on the same machine with a
    /// stiff mode has none of them.
    #[test]
    fn waves_of_a_cut_that_chatters_are_the_forecast_ones() {
        let set = [
            "runout_correction=null".to_owned(),
            "identification=null".to_owned(),
            "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0.0, width_mm: 20.0}]".to_owned(),
        ];
        let strongest = |mode: Option<(f64, f64, f64)>| {
            let mut prepared = prepare("journal_runout", &set, None).unwrap();
            prepared.machine.axes[Axis::X.index()].drive.coulomb_friction = 0.0;
            if let Some((frequency_hz, damping, compliance_share)) = mode {
                let mode = ContactMode { frequency_rad_s: frequency_hz * TURN_RAD, damping, compliance_share };
                prepared.machine.contact.as_mut().unwrap().modes = vec![mode];
            }
            let (_, _, outlines) = crate::simulate_outlines_on(&prepared, &prepared.machine, |_, _| {}).unwrap();
            let lobe = &prepared.planned.lobes[0];
            let phase_rad = lobe.design.phase_on_rad(prepared.job.spec.raw_part.clamped_at_rad);
            let inspection = LobeInspection::new(&outlines[0], &lobe.design.contour, phase_rad).unwrap();
            let forecast = forecast_of(&prepared, lobe, lobe.passes.len() - 1).unwrap();
            let wave = inspection.waves[0];
            (
                wave.per_turn,
                wave.amplitude_mm,
                forecast.part.unwrap(),
                wave_causes(&prepared, lobe, &[wave.per_turn])[0],
            )
        };
        let (_, calm_mm, calm, _) = strongest(None);
        assert!(!calm.is_growing());
        let (per_turn, amplitude_mm, wave, cause) = strongest(Some((70.0, 0.03, 0.6)));
        eprintln!("{per_turn} waves of {amplitude_mm} mm, calm {calm_mm} mm; forecast {wave:?}");
        assert!(wave.is_growing() && amplitude_mm > 10.0 * calm_mm, "{amplitude_mm} mm, {calm_mm} mm");
        // Neighbouring numbers grow nearly as fast, and a few turns do not separate them.
        assert!((per_turn as f64 / wave.waves_per_turn - 1.0).abs() < 0.03, "{per_turn}, {wave:?}");
        assert_eq!(cause, Some(WaveCause::Chatter));
    }

    /// Waves of a cut that chatters grow from the raw part to the finished one; with `speed_variation` they shrink as forecast, no warning is
    /// left, and the job takes as much longer as its plan says.
    #[test]
    fn a_varying_work_speed_calms_a_job_that_chatters() {
        const PLANTED_MM: f64 = 2e-4;
        // Of the 30 turns with infeed 15 are in air.
        const TURNS: i32 = 15 + 3;
        let ground = |variation: &str| {
            let set = [
                "runout_correction=null".to_owned(),
                "identification=null".to_owned(),
                "roughing=[]".to_owned(),
                "stock_mm=0.03".to_owned(),
                "infeed={total_mm: 0.06, per_turn_um: 2.0, spark_out_turns: 3}".to_owned(),
                "raw_part={lobes: [{count: 192, um: 0.2}]}".to_owned(),
                "lobes=[{name: J1, station: LS1, profile: journal, phase_deg: 0.0, width_mm: 20.0}]".to_owned(),
                format!("speed_variation={variation}"),
            ];
            let mut prepared = prepare("journal_runout", &set, None).unwrap();
            prepared.machine.axes[Axis::X.index()].drive.coulomb_friction = 0.0;
            let mode = ContactMode { frequency_rad_s: 180.0 * TURN_RAD, damping: 0.04, compliance_share: 0.2 };
            prepared.machine.contact.as_mut().unwrap().modes = vec![mode];
            let (_, _, outlines) = crate::simulate_outlines_on(&prepared, &prepared.machine, |_, _| {}).unwrap();
            let wave_mm = wave_mm(&outlines[0], 192.0);
            let forecast = forecast_of(&prepared, &prepared.planned.lobes[0], 0).unwrap();
            let factor = |rate: f64| forecast.cut.planted_wave_per_turn(192.0, rate * TURN_RAD / forecast.cut.turn_s);
            (wave_mm, factor(1.0), factor(0.75), chatter_warning(&prepared), prepared.planned.plan.duration_s)
        };
        let (steady_mm, planned, slow, warning, steady_s) = ground("null");
        assert!(warning.is_some() && planned > 1.0 && slow < 1.0, "{warning:?} {planned} {slow}");
        assert!(steady_mm > 2.0 * PLANTED_MM, "{steady_mm} mm");
        let (varied_mm, _, _, warning, varied_s) = ground("{slower_percent: 25, period_turns: 2}");
        assert_eq!(warning, None);
        assert!(varied_s > 1.1 * steady_s, "{varied_s} s, {steady_s} s");
        let forecast_mm = PLANTED_MM * (planned * slow).powi(TURNS / 2);
        assert!((varied_mm / forecast_mm - 1.0).abs() < 0.1, "{varied_mm} mm, forecast {forecast_mm} mm");
        assert!(varied_mm < 0.55 * PLANTED_MM, "{varied_mm} mm");
    }

    #[test]
    fn a_rigid_machine_is_rejected_with_a_reason() {
        let mut prepared = prepare("journal_runout", &[], None).unwrap();
        prepared.machine.contact = None;
        let refused = chatter(&prepared, VARIATION).unwrap_err().to_string();
        assert!(refused.contains("is rigid") && refused.contains("journal_grinder"), "{refused}");
    }

    #[test]
    fn the_plot_is_svg_or_png_and_says_so_otherwise() {
        let report = report("journal_runout", Some((140.0, 0.03, 0.6)));
        let drawing = stability_plot(&report, report.worst().unwrap());
        assert_eq!(drawing.text_faults(), [""; 0]);
        let [low, high] = drawing.extent();
        assert!(low[0] >= 8.0 && low[1] >= 8.0 && high[0] <= 289.0 && high[1] <= 206.0, "{low:?} {high:?}");
        let refused = report.write_plot(Path::new("lobes.pdf")).unwrap_err().to_string();
        assert!(refused.contains("lobes.pdf") && refused.contains(".svg"), "{refused}");
    }
}
