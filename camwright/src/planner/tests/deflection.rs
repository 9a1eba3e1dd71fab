// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::cam::form::Form;
use crate::planner::deflection::Deflections;

/// The predicted deflection error equals the error on the ground lobes, after one pass and after two, for any spark-out; the
/// reported maximum deflection is not exceeded.
#[test]
fn what_giving_way_leaves_on_a_lobe_is_predicted() {
    let soft = MachineDescription { contact: Some(contact()), ..machine() };
    let mut one = job();
    one.passes[0].total_infeed_mm = 0.108;
    one.passes[0].infeed_per_block_mm = 0.000_01;
    one.stock_mm = 0.09;
    one.lobes.truncate(2);
    let mut two = one.clone();
    two.passes.insert(0, PassSpec { name: String::from("rough"), total_infeed_mm: 0.072, ..one.passes[0].clone() });
    two.passes[1].infeed_per_block_mm = 0.000_005;
    two.passes[1].total_infeed_mm = 0.036;
    for (job, spark_out_turns) in [(&one, 2), (&one, 4), (&two, 1), (&two, 3)] {
        let mut job = job.clone();
        job.passes.iter_mut().for_each(|pass| pass.spark_out_turns = spark_out_turns);
        let planned = plan_job(&job, &soft, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
        let mut largest_n = [0.0_f64; 2];
        let (_, ground) = ground(&job, &planned, planned.plan.clone(), &soft, |_, report| {
            if let Some(lobe) = report.lobe {
                largest_n[lobe] = largest_n[lobe].max(report.normal_force_n);
            }
        });
        for (index, lobe) in planned.lobes.iter().enumerate() {
            let design = &lobe.design;
            let station = soft.station(&design.station).expect("it was planned for it");
            let law = contact().law(station.position_mm, design.width_mm).expect("a width");
            let predicted = Deflections::from_lobe(&planned.plan, index, job.stock_mm, &law, &soft).expect("it is cut");
            let radii = ground.part().lobe(&design.name).expect("it was loaded").radii_mm();
            let form = Form::measure(radii, &design.contour, design.phase_rad).expect("radii");
            let off_mm = form.largest.deviation_mm - predicted.left_mm;
            assert!(
                off_mm.abs() < 1e-4 + 0.02 * predicted.left_mm,
                "{} after {spark_out_turns}: {} mm, reported {} mm",
                design.name,
                form.largest.deviation_mm,
                predicted.left_mm
            );
            assert!(
                largest_n[index] < 1.02 * predicted.largest_n && largest_n[index] > 0.9 * predicted.largest_n,
                "{} N, reported {} N",
                largest_n[index],
                predicted.largest_n
            );
        }
    }
}
