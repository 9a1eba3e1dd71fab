// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which key of the job file is behind a refusal of the core.

use super::process_warnings::limit_key;
use camwright::job::dressing::DressError;
use camwright::job::grinding::{JobError, JobKey, Subject};
use camwright::job::infeed::InfeedError;
use camwright::machine::WHEEL_TOLERANCE_MM;
use camwright::machine::description::Axis;
use camwright::motion::speed_plan::SpeedPlanError;
use camwright::planner::{IdleWheelStep, PlanError, RequiredPosition};
use camwright::toolpath::wheel_path::ToolPathError;
use camwright_files::ConfigError;
use camwright_files::job_file::Job;
use camwright_files::profile_file::contour_key;

/// A refusal of the core as one sentence with the file and the line of the key that causes it.
#[must_use]
pub fn blame(job: &Job, error: &PlanError) -> ConfigError {
    job.document.error(&key(job, error), error.to_string() + &machine_limit(job, error))
}

/// Position of the machine's limit that a speed exceeds.
fn machine_limit(job: &Job, error: &PlanError) -> String {
    match error {
        PlanError::Speed { source: SpeedPlanError::TooFast { worst, .. }, .. } => {
            format!("; limit: {}", job.machine.place(limit_key(worst.axis, worst.quantity)))
        }
        _ => String::new(),
    }
}

fn key(job: &Job, error: &PlanError) -> String {
    match error {
        PlanError::Job(error) => job_key(job, error),
        PlanError::Compensated { .. } => "form_compensation".into(),
        PlanError::NoNormal { .. } => "infeed.along".into(),
        PlanError::Contour { profile, source } => format!("{}.{}", profile_key(job, profile), contour_key(source)),
        PlanError::Path { profile, source, .. } => match source {
            ToolPathError::BadWheelRadius { .. }
            | ToolPathError::WheelTooLarge { .. }
            | ToolPathError::WheelTooSmall { .. }
            | ToolPathError::WheelFillsBore { .. }
                if job.wheel_radius_mm.is_some() =>
            {
                "wheel_radius_mm".into()
            }
            _ => profile_key(job, profile),
        },
        PlanError::Dress(error) => match error {
            DressError::NoReason | DressError::NoDresser { .. } | DressError::WornOut { .. } => "dressing".into(),
            DressError::OutOfRange { key, .. } => format!("dressing.{key}"),
            DressError::NoWear { .. } | DressError::WearsTooMuch { .. } => "dressing.predicted_error_um".into(),
            DressError::TooDeep { .. } => "dressing.depth_um".into(),
        },
        PlanError::TwoWheels { mounted_mm, .. } => wish_key(job, *mounted_mm),
        PlanError::Collision { obstacle: Some(obstacle), .. } => format!("obstacles.{obstacle}"),
        PlanError::Collision { lobe: Some(lobe), .. } => {
            // Lobes may stand in another order than in the file.
            job.spec.lobes.get(*lobe).map_or_else(String::new, |lobe| format!("{}.station", lobe_key(job, &lobe.name)))
        }
        // On its way to the home position the wheel is nearest where the last retract left it.
        PlanError::Collision { x_mm, .. } if *x_mm < job.spec.home.x_mm => "rapid_advance_mm".into(),
        PlanError::Collision { .. } | PlanError::OppositeWall { .. } => "home.x_mm".into(),
        PlanError::WheelTooFast { lobe, .. } => lobe_key(job, lobe),
        PlanError::Infeed { pass, source: InfeedError::WrongSum { .. } | InfeedError::TooLongList { .. } } => {
            pass_key(job, pass, "infeed.per_turn_um")
        }
        PlanError::Infeed { pass, .. } => pass_key(job, pass, "infeed.total_mm"),
        PlanError::TooMuchStock { .. } | PlanError::NoStock { .. } => "measure_stock".into(),
        PlanError::TouchesBlank { .. } => "infeed.total_mm".into(),
        PlanError::SharpForTaper { lobe, .. } => format!("{}.taper_um", lobe_key(job, lobe)),
        PlanError::VariationTooFast { .. } => "speed_variation.period_turns".into(),
        PlanError::NoArrival { .. } | PlanError::Speed { source: SpeedPlanError::NoLead { .. }, .. } => {
            "c_between_lobes".into()
        }
        PlanError::Speed { pass, source: SpeedPlanError::Turn(_) | SpeedPlanError::NoRunUp { .. }, .. } => {
            pass_key(job, pass, "speed")
        }
        PlanError::Speed { pass, .. } => pass_key(job, pass, "work_speed_rpm"),
        PlanError::SoftLimit { place, what, axis, .. } => match (what, axis, place) {
            (RequiredPosition::DryRunHome | RequiredPosition::DryRunHold, ..) => "dry_run.stand_off_mm".into(),
            (RequiredPosition::Home, Axis::X, _) => "home.x_mm".into(),
            (RequiredPosition::Home, ..) => "home.z_mm".into(),
            (RequiredPosition::RapidAdvance, ..) => "rapid_advance_mm".into(),
            (RequiredPosition::Hold, ..) => "retract_clearance_mm".into(),
            (_, _, Subject::Lobe(lobe)) => format!("{}.station", lobe_key(job, lobe)),
            _ => String::new(),
        },
        PlanError::NotClear { what: IdleWheelStep::Home, .. } => "home.x_mm".into(),
        PlanError::NotClear { .. } => "rapid_advance_mm".into(),
        PlanError::Move { .. } => "rapid_speed_mm_s".into(),
        PlanError::DryRun { .. } => "dry_run.stand_off_mm".into(),
        PlanError::Gouges { lobe, .. } => lobe_key(job, lobe),
        PlanError::Check(_) => String::new(),
    }
}

fn job_key(job: &Job, error: &JobError) -> String {
    match error {
        JobError::NoLobes => "lobes".into(),
        JobError::SameName { second, .. } => format!("lobes.{}.name", second.saturating_sub(1)),
        JobError::SameStation { second, .. } => format!("{}.station", lobe_key(job, second)),
        JobError::NeighbourInReach { lobe, .. } | JobError::UnknownStation { lobe, .. } => {
            format!("{}.station", lobe_key(job, lobe))
        }
        JobError::LearnsAndCorrects | JobError::LearnedElsewhere { .. } | JobError::LearnedTooMuch { .. } => {
            "form_compensation".into()
        }
        JobError::SparkOutByForce { pass, .. } => pass_key(job, pass, "infeed.spark_out_until_n"),
        JobError::TooLittleSparkOut { pass, .. } => pass_key(job, pass, "infeed.spark_out_turns"),
        JobError::NoGaugeSize { pass, .. } => pass_key(job, pass, "infeed.gauge_size"),
        JobError::SizeAboveRaw { pass, .. } => pass_key(job, pass, "infeed.gauge_size.ends_above_um"),
        JobError::TurnsAndIndexes => "c_between_lobes".into(),
        JobError::WheelApproach { .. } | JobError::ApproachBeyondInfeed { .. } => "wheel_approach_mm".into(),
        JobError::ChangeTooNear { .. } => "home.x_mm".into(),
        JobError::NoWheelChanger { .. } | JobError::UnknownWheel { .. } | JobError::NotWithWheels { .. } => {
            "wheel".into()
        }
        JobError::BentNowhere { .. } => "raw_part.bent_between_mm".into(),
        JobError::NoSupport { key, .. } => match *key {
            "workholding.steady_rest" => "part_support.steady_rest_z_mm",
            "workholding.tailstock_stiffness_n_um" => "part_support.tailstock",
            "workholding.chuck_tilt_n_m_rad" => "part_support.headstock",
            _ => "part_support",
        }
        .into(),
        JobError::LoosePart => "part_support.tailstock".into(),
        JobError::RestOutside { .. } => "part_support.steady_rest_z_mm".into(),
        JobError::OutsideSupports { lobe, .. } | JobError::UnderSteadyRest { lobe, .. } => {
            format!("{}.station", lobe_key(job, lobe))
        }
        JobError::CannotCorrect { .. } | JobError::GaugeSeesNoCut { .. } => "runout_correction".into(),
        JobError::PublishedWindow { .. } => "runout_correction.published_window_deg".into(),
        JobError::PublishedGauge { .. } => "runout_correction.mode".into(),
        JobError::FinishingByForcePublished => "runout_correction.finishing.force_n".into(),
        JobError::FinishingStock { .. } => "runout_correction.finishing.stock_um".into(),
        JobError::KeptElsewhere { .. } => "runout_correction.contacts".into(),
        JobError::NothingKept { .. } => "runout_correction.stiffness".into(),
        JobError::MeasuresNoStock { .. } => "measure_stock".into(),
        JobError::MarginTooSmall { .. } => "measure_stock.margin_um".into(),
        JobError::RadialLawOnPin { pass, .. } => pass_key(job, pass, "speed.law"),
        JobError::FeedsOfTurns { pass } => pass_key(job, pass, "infeed.per_turn_um"),
        JobError::OneFeed { .. } | JobError::IdentifiesForNothing => "identification".into(),
        JobError::NoAir { .. } => "infeed.total_mm".into(),
        JobError::BoreBesideLobe { lobe, .. } => format!("{}.profile", lobe_key(job, lobe)),
        JobError::NotInBore { key, .. } => (*key).into(),
        JobError::NotRound { lobe }
        | JobError::StockNotRound { lobe }
        | JobError::SizeNotRound { lobe }
        | JobError::PinUnderGauge { lobe, .. } => {
            format!("{}.profile", lobe_key(job, lobe))
        }
        JobError::CorrectsAndTurnsOn => "c_between_lobes".into(),
        JobError::UnknownProfile { lobe, .. } => format!("{}.profile", lobe_key(job, lobe)),
        JobError::SectionCount { .. } => "lobes".into(),
        JobError::WideUnderGauge { key, .. } => (*key).into(),
        JobError::ShapeUnderGauge { key, .. } => (*key).into(),
        JobError::WideWithShape { lobe, .. } => format!("{}.width_mm", lobe_key(job, lobe)),
        JobError::OtherRim(other) => {
            let (lobe, design) = (&other.lobe, other.design);
            let key = if design.taper_mm == 0.0 && design.crown_mm != 0.0 { "crown_um" } else { "taper_um" };
            format!("{}.{key}", lobe_key(job, lobe))
        }
        JobError::ShapeAboveStock { .. } => "stock_mm".into(),
        JobError::RoughedBelow { lobe, .. } => lobe_key(job, lobe),
        JobError::RimBeyondApproach { .. } => "wheel_approach_mm".into(),
        JobError::SectionName { lobe, .. } => format!("{}.name", lobe_key(job, lobe)),
        JobError::PlungeOverlap { lobe, .. } => format!("{}.plunge_overlap_mm", lobe_key(job, lobe)),
        JobError::WiderThanWheel { lobe, .. } => format!("{}.width_mm", lobe_key(job, lobe)),
        JobError::NoBody { name, .. } => {
            index_key("obstacles", job.spec.obstacles.iter().position(|obstacle| obstacle.name == *name))
        }
        JobError::PassCount { .. } => "infeed".into(),
        JobError::MixedDirections { pass, .. } => pass_key(job, pass, "infeed.along"),
        JobError::TooFewBlocks { .. } => "profiles.0.lift".into(),
        JobError::OutOfRange { place, key, .. } => {
            let key = file_key(*key);
            match place {
                Subject::Lobe(lobe) => format!("{}.{key}", lobe_key(job, lobe)),
                Subject::Pass(pass) if key == PER_BLOCK => infeed_key(job, pass),
                Subject::Pass(pass) => pass_key(job, pass, key),
                Subject::Job => key.into(),
            }
        }
    }
}

/// The key of the job file that sets a value of the core. Names differ where units do.
fn file_key(key: JobKey) -> &'static str {
    match key {
        JobKey::TotalInfeed => "infeed.total_mm",
        JobKey::InfeedPerBlock => PER_BLOCK,
        JobKey::InfeedOfTurns => "infeed.per_turn_um",
        JobKey::WorkSpeed => "work_speed_rpm",
        JobKey::FootprintSpeed => "speed.footprint_speed_mm_s",
        JobKey::RemovalRate => "speed.removal_rate_mm2_s",
        JobKey::Power => "speed.power_w_mm",
        JobKey::SpecificEnergy => "speed.specific_energy_j_mm3",
        JobKey::Rubbing => "speed.rubbing_n_mm2",
        JobKey::ReferenceFootprintSpeed => "speed.reference_footprint_speed_mm_s",
        JobKey::ReferenceDepth => "speed.reference_depth_um",
        JobKey::ReferenceEquivalentDiameter => "speed.reference_equivalent_diameter_mm",
        JobKey::Phase => "phase_deg",
        JobKey::SparkOutUntil => "infeed.spark_out_until_n",
        JobKey::GaugeSizeAbove => "infeed.gauge_size.ends_above_um",
        JobKey::GaugeSizeBeyond => "infeed.gauge_size.beyond_um",
        JobKey::SparkOutTurns => "infeed.spark_out_turns",
        JobKey::PartPhase => "part_phase_deg",
        JobKey::FormCompensationMax => "form_compensation.most_um",
        JobKey::FormCompensationMaxSlope => "form_compensation.most_um_per_deg",
        JobKey::CBetweenLobesMargin => "arrival_margin_ms",
        JobKey::SpeedVariationSlower => "speed_variation.slower_percent",
        JobKey::PublishedWindow => "runout_correction.published_window_deg",
        JobKey::PublishedStep => "runout_correction.published_step_deg",
        JobKey::PartModulus => "part_support.modulus_gpa",
        JobKey::Taper => "taper_um",
        JobKey::Crown => "crown_um",
        JobKey::MeasureStockMargin => "measure_stock.margin_um",
        JobKey::MeasureStockSpeed => "measure_stock.work_speed_rpm",
        JobKey::RunoutCorrectionAllowance => "runout_correction.allowance_um",
        JobKey::FinishingDepth => "runout_correction.finishing.per_turn_um",
        JobKey::FinishingStock => "runout_correction.finishing.stock_um",
        JobKey::IdentificationPush => "identification.push_um",
        JobKey::IdentificationPushSpeed => "identification.push_speed_um_s",
        JobKey::IdentificationMaxForce => "identification.most_force_n",
        other => other.name(),
    }
}

/// A key of a pass: the last one's stand in the job itself, those before it in `roughing`.
pub(super) fn pass_key(job: &Job, pass: &str, key: &str) -> String {
    let passes = &job.spec.passes;
    match passes.iter().position(|other| other.name == pass) {
        Some(index) if index + 1 < passes.len() => format!("roughing.{index}.{key}"),
        _ => key.into(),
    }
}

const PER_BLOCK: &str = "infeed.per_block_um";

/// Key of a pass with its infeed per turn or per block, as the job has it.
pub(super) fn infeed_key(job: &Job, pass: &str) -> String {
    let per_turn = pass_key(job, pass, "infeed.per_turn_um");
    if job.document.root.get(&per_turn).is_some() { per_turn } else { pass_key(job, pass, PER_BLOCK) }
}

/// The first key that asks for another wheel than the one that is mounted.
fn wish_key(job: &Job, mounted_mm: f64) -> String {
    let other = job.spec.wheels.iter().find(|wish| (wish.radius_mm - mounted_mm).abs() > WHEEL_TOLERANCE_MM);
    match other.map(|wish| &wish.of) {
        Some(Subject::Lobe(name)) => format!("{}.wheel_radius_mm", lobe_key(job, name)),
        Some(Subject::Pass(name)) => pass_key(job, name, "wheel_radius_mm"),
        _ => "wheel_radius_mm".into(),
    }
}

/// Key of a lobe; that of the lobe for one of its plunges or visits.
fn lobe_key(job: &Job, name: &str) -> String {
    let lobe = job.spec.lobes.iter().find(|lobe| lobe.name == name);
    let plunge = lobe.and_then(|lobe| lobe.plunge.as_ref()).map(|plunge| plunge.lobe.as_str());
    let visit = lobe.and_then(|lobe| lobe.visit.as_ref()).map(|visit| visit.lobe.as_str());
    format!("lobes.{}", plunge.or(visit).unwrap_or(name))
}

fn profile_key(job: &Job, name: &str) -> String {
    index_key("profiles", job.spec.profiles.iter().position(|profile| profile.name == name))
}

fn index_key(list: &str, index: Option<usize>) -> String {
    index.map_or_else(|| list.to_owned(), |index| format!("{list}.{index}"))
}
