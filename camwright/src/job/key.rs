// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Names of the settings and parts of a job, for errors.

use crate::math::named::named;
use alloc::string::String;
use core::fmt;

named! {
    /// Setting of a grinding job with a range of its own. It displays with the unit of the core.
    JobKey {
        TotalInfeed = "total_infeed_mm",
        InfeedPerBlock = "infeed_per_block_mm",
        InfeedOfTurns = "infeed_of_turns_mm",
        WorkSpeed = "work_speed_rad_s",
        FootprintSpeed = "footprint_speed_mm_s",
        RemovalRate = "removal_rate_mm2_s",
        Power = "power_w_mm",
        SpecificEnergy = "specific_energy_j_mm3",
        Rubbing = "rubbing_n_mm2",
        ReferenceFootprintSpeed = "reference.footprint_speed_mm_s",
        ReferenceDepth = "reference.depth_mm",
        ReferenceEquivalentDiameter = "reference.equivalent_diameter_mm",
        SparkOutTurns = "spark_out_turns",
        SparkOutUntil = "spark_out_until_n",
        GaugeSizeAbove = "gauge_size.ends_above_mm",
        GaugeSizeBeyond = "gauge_size.beyond_mm",
        Phase = "phase_rad",
        Width = "width_mm",
        RapidAdvance = "rapid_advance_mm",
        RapidSpeed = "rapid_speed_mm_s",
        RetractClearance = "retract_clearance_mm",
        Stock = "stock_mm",
        CBetweenLobesMargin = "c_between_lobes.margin_s",
        WheelPowerMax = "wheel_power.most_w",
        WheelPowerSpecificEnergy = "wheel_power.specific_energy_j_mm3",
        WheelPowerRubbing = "wheel_power.rubbing_n_mm2",
        SpeedVariationSlower = "speed_variation.slower",
        SpeedVariationPeriod = "speed_variation.period_turns",
        Clearance = "clearance_mm",
        DryRunStandOff = "dry_run.stand_off_mm",
        RawPart = "raw_part",
        PartDiameter = "part_support.diameter_mm",
        PartLength = "part_support.length_mm",
        PartModulus = "part_support.modulus_n_mm2",
        HeadstockZ = "part_support.headstock_z_mm",
        WheelRadius = "wheel_radius_mm",
        HomeX = "home.x_mm",
        HomeZ = "home.z_mm",
        PartPhase = "part_phase_rad",
        RunoutCorrectionHarmonics = "runout_correction.harmonics",
        RunoutCorrectionAllowance = "runout_correction.allowance_mm",
        FinishingDepth = "runout_correction.finishing.per_turn_mm",
        FinishingTurns = "runout_correction.finishing.turns",
        FinishingStock = "runout_correction.finishing.stock_mm",
        FinishingForce = "runout_correction.finishing.force_n",
        FinishingMaxTurns = "runout_correction.finishing.max_turns",
        PublishedWindow = "runout_correction.published_window_rad",
        PublishedStep = "runout_correction.published_phases",
        MeasureStockSpeed = "measure_stock.speed_rad_s",
        Taper = "taper_mm",
        Crown = "crown_mm",
        MeasureStockMargin = "measure_stock.margin_mm",
        FormCompensationGain = "form_compensation.gain",
        FormCompensationHarmonics = "form_compensation.harmonics",
        FormCompensationMax = "form_compensation.most_mm",
        FormCompensationMaxSlope = "form_compensation.most_slope_mm_rad",
        IdentificationPush = "identification.push_mm",
        IdentificationPushSpeed = "identification.push_speed_mm_s",
        IdentificationMaxForce = "identification.most_n",
    }
}

/// Part of a job that an error or a requirement is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    Job,
    /// A lobe, by name.
    Lobe(String),
    /// A pass, by name.
    Pass(String),
}

impl Subject {
    /// Start of a message about it: `lobe I1: `, `pass finish: `, or nothing for the job.
    #[must_use]
    pub fn prefix(&self) -> String {
        match self {
            Self::Job => String::new(),
            Self::Lobe(_) | Self::Pass(_) => alloc::format!("{self}: "),
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Job => f.write_str("the job"),
            Self::Lobe(name) => write!(f, "lobe {name}"),
            Self::Pass(name) => write!(f, "pass {name}"),
        }
    }
}
