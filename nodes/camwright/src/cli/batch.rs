// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright run --parts N`: size and form of every part, and the capability of the machine.

use super::output::{say, wrapped};
use camwright::cam::capability::Capability;
use camwright::math::units::um_from_mm;
use camwright::planner::{LobeDesign, designs};
use camwright_files::job_file;
use camwright_job_planner::parts::Parts;
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::PartLobe;
use camwright_planning::{self as planning, LobeCapability, MeasuredLobe, tolerance_text};
use camwright_ros::{Node, Qos, RosError, Subscription};
use std::sync::Arc;
use std::time::Duration;

/// Maximum time for the outlines of a finished part to arrive.
const MEASURING: Duration = Duration::from_secs(20);

/// The parts of a batch so far.
pub(super) struct Batch {
    wanted: u32,
    designs: Vec<LobeDesign>,
    outlines: Arc<Parts>,
    parts: Vec<Vec<MeasuredLobe>>,
    plan_hashes: Vec<String>,
    _subscription: Subscription,
}

impl Batch {
    /// Listens to the parts of a job.
    pub(super) fn subscribe(node: &Node, wanted: u32, job: &str, overrides: &[String]) -> Result<Self, RosError> {
        let outlines: Arc<Parts> = Arc::default();
        let into = Arc::clone(&outlines);
        let subscription =
            node.subscribe::<PartLobe>("machine/part", &Qos::latched(32), move |lobe, _| into.add(lobe))?;
        let designs = job_file::load(job, overrides).ok().and_then(|job| designs(&job.spec).ok()).unwrap_or_default();
        Ok(Self { wanted, designs, outlines, parts: Vec::new(), plan_hashes: Vec::new(), _subscription: subscription })
    }

    /// Measures a part that was ground; false if that was the last one.
    pub(super) fn measure(&mut self, result: &RunJobResult) -> bool {
        let names: Vec<&str> = result.lobes.iter().map(|lobe| lobe.name.as_str()).collect();
        let outlines = self.outlines.wait_finished(&names, result.first_tick, MEASURING).unwrap_or_default();
        let measured = outlines.iter().filter_map(|outline| {
            let design = self.designs.iter().find(|design| design.name == outline.name)?;
            planning::measure_lobe(design, outline).ok()
        });
        let measured: Vec<MeasuredLobe> = measured.collect();
        self.parts.push(measured);
        self.plan_hashes.push(result.plan_hash.clone());
        self.parts.len() < self.wanted as usize
    }

    /// Returns true if every measured part is within the tolerance.
    pub(super) fn is_good(&self) -> bool {
        self.parts.iter().flatten().all(|lobe| lobe.form_mm.abs() <= lobe.allowed_mm)
    }

    fn capability(&self) -> Vec<LobeCapability> {
        planning::capability(&self.parts).unwrap_or_default()
    }

    /// The form error of the batch that uses most of its tolerance, with the number of its part.
    pub(super) fn worst(&self) -> Option<(usize, &MeasuredLobe)> {
        let lobes =
            self.parts.iter().enumerate().flat_map(|(part, lobes)| lobes.iter().map(move |lobe| (part + 1, lobe)));
        let used = |lobe: &MeasuredLobe| lobe.form_mm.abs() / lobe.allowed_mm;
        lobes.max_by(|a, b| used(a.1).total_cmp(&used(b.1)))
    }

    /// Capability of the batch; with `details` size and form of every part.
    pub(super) fn print(&self, details: bool) {
        let capability = self.capability();
        if let Some(first) = capability.first() {
            let is_same = capability.iter().all(|lobe| lobe.tolerance_mm.to_bits() == first.tolerance_mm.to_bits());
            let tolerance = match is_same {
                true => format!("tolerance {} um", tolerance_text(first.tolerance_mm)),
                false => {
                    let of = |lobe: &LobeCapability| format!("{} {}", lobe.name, tolerance_text(lobe.tolerance_mm));
                    format!("tolerance in um: {}", capability.iter().map(of).collect::<Vec<_>>().join(", "))
                }
            };
            say!(
                "{}\nlobe   size mean         s    Cp    Cpk    form mean         s    Cpk",
                wrapped(&format!("capability of {} parts ({tolerance})", self.parts.len()), 2)
            );
        }
        for lobe in capability {
            let index = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
            let [size, form] = [&lobe.size, &lobe.form]
                .map(|of| format!("{:>+8.3} um {:>6.3} um", um_from_mm(of.mean), um_from_mm(of.deviation)));
            let (cp, cpk, form_cpk) = (index(lobe.size.cp), index(lobe.size.cpk), index(lobe.form.cpk));
            say!("{:<5} {size} {cp:>6} {cpk:>6}  {form} {form_cpk:>6}", lobe.name);
        }
        if details {
            self.print_parts();
        }
    }

    fn print_parts(&self) {
        say!("size (mean deviation of the base circle or journal) and largest form error in um:");
        for (index, part) in self.parts.iter().enumerate() {
            let lobe = |lobe: &MeasuredLobe| {
                format!("{} {:+.3}, {:+.3}", lobe.name, um_from_mm(lobe.size_mm), um_from_mm(lobe.form_mm))
            };
            let lobes = part.iter().map(lobe).collect::<Vec<_>>().join("; ");
            say!("{}", wrapped(&format!("  part {:<4} {lobes}", index + 1), 12));
        }
        say!("Cp = (U - L)/(6 s), Cpk = min(U - m, m - L)/(3 s); form against U alone");
    }

    /// The batch as JSON.
    pub(super) fn json(&self) -> serde_json::Value {
        let parts = self.parts.iter().zip(&self.plan_hashes).map(|(part, plan_hash)| {
            let lobe = |lobe: &MeasuredLobe| {
                serde_json::json!({
                    "name": lobe.name, "size_um": um_from_mm(lobe.size_mm), "form_um": um_from_mm(lobe.form_mm),
                    "form_allowed_um": um_from_mm(lobe.allowed_mm),
                })
            };
            serde_json::json!({ "plan_hash": plan_hash, "lobes": part.iter().map(lobe).collect::<Vec<_>>() })
        });
        let index = |of: &Capability| {
            serde_json::json!({
                "mean_um": um_from_mm(of.mean), "deviation_um": um_from_mm(of.deviation), "cp": of.cp, "cpk": of.cpk,
            })
        };
        let capability = self.capability();
        let capability = capability.iter().map(|lobe| {
            serde_json::json!({
                "name": lobe.name, "tolerance_um": um_from_mm(lobe.tolerance_mm), "size": index(&lobe.size),
                "form": index(&lobe.form),
            })
        });
        serde_json::json!({
            "parts": parts.collect::<Vec<_>>(),
            "capability": capability.collect::<Vec<_>>(),
        })
    }
}
