// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Drawings of every lobe by `camwright plan --plots`.
//!
//! | name | shows |
//! |---|---|
//! | `contour` | contour, blank, wheel and its path; colours on the contour where the last pass cuts it |
//! | `tool_path` | X, X′, X″, X‴ over the angle of C |
//! | `c_axis` | speed, acceleration, jerk of C with what is allowed of them, per pass |
//! | `x_axis` | the same of X |
//! | `removal_rate` | specific removal rate with its bound and how long it lasts, per pass |
//! | `infeed` | distance from the finished path over the turns of all passes, of a list of infeeds, several passes, or no spark-out |
//! | `compliance` | compliance of a slender part along Z with its supports |
//! | `plunges` | wheel of every plunge over a lobe that is wider than the wheel |
//! | `shape` | taper and crown of a lobe, and the rim that grinds them |

mod chart;
mod compliance;
mod contour;
mod curves;
mod infeed;
pub(super) mod nc;
mod plunges;
mod shape;
mod sheet;
mod stability;
mod turned;

pub(crate) use stability::stability_plot;
pub(crate) use turned::turned_plots;

use super::PreparedJob;
use super::summary::LobeSummary;
use super::turn::LobeTurn;
use super::turn_summary::arcs;
use crate::drawing::Plot;
use sheet::{DrawnPass, Sheet};

/// All drawings of a lobe.
pub(super) fn plots(prepared: &PreparedJob, index: usize, summary: &LobeSummary) -> Vec<Plot> {
    let sheet = Sheet { prepared, index, summary };
    let mut plots = vec![
        Plot {
            name: "contour".into(),
            caption: "Contour of the lobe with blank and wheel; its colours show the limit that sets the speed.".into(),
            drawing: contour::drawing(&sheet),
        },
        Plot {
            name: "tool_path".into(),
            caption: "X of the wheel over one turn of C, with its first three derivatives.".into(),
            drawing: curves::tool_path(&sheet),
        },
    ];
    plots.extend(infeed::drawing(&sheet).map(|drawing| Plot {
        name: "infeed".into(),
        caption: "Infeed of all passes over the turns of C.".into(),
        drawing,
    }));
    plots.extend(plunges::drawing(&sheet).map(|drawing| Plot {
        name: "plunges".into(),
        caption: "Wheel of every plunge over the lobe, and the sections that they leave.".into(),
        drawing,
    }));
    plots.extend(shape::drawing(&sheet).map(|drawing| Plot {
        name: "shape".into(),
        caption: "Taper and crown of the lobe over its width, and the rim that grinds them.".into(),
        drawing,
    }));
    plots.extend(compliance::drawing(&sheet).map(|drawing| Plot {
        name: "compliance".into(),
        caption: "Compliance of the part along Z with its supports.".into(),
        drawing,
    }));
    for (pass, of_pass) in summary.passes.iter().enumerate() {
        let Some(turn) = LobeTurn::new(prepared, index, pass) else { continue };
        let cut = DrawnPass { arcs: arcs(&turn.points), turn, summary: of_pass };
        let drawings = [
            ("c_axis", "speed plan of C; shading shows the limit that acts", curves::c_axis(&sheet, &cut)),
            ("x_axis", "speed, acceleration and jerk of X", curves::x_axis(&sheet, &cut)),
            ("removal_rate", "specific removal rate and how long it lasts", curves::removal_rate(&sheet, &cut)),
        ];
        for (name, shows, drawing) in drawings {
            let name = if summary.passes.len() > 1 { format!("{name}_pass_{}", pass + 1) } else { name.into() };
            plots.push(Plot { name, caption: format!("Pass {}: {shows}.", of_pass.name), drawing });
        }
    }
    plots
}

#[cfg(test)]
mod tests {
    use super::sheet::PAPER;
    use super::*;
    use crate::drawing::{png, svg};
    use crate::{prepare, summary};

    fn drawn(job: &str, set: &[&str]) -> Vec<Plot> {
        let prepared = prepare(job, &set.iter().map(ToString::to_string).collect::<Vec<_>>(), None).unwrap();
        let summary = summary(&prepared);
        summary.lobes.iter().enumerate().flat_map(|(index, lobe)| plots(&prepared, index, lobe)).collect()
    }

    /// Whatever the job and its speed law, everything that is drawn lies within the margins of the sheet, and every text can be read.
    #[test]
    fn nothing_is_drawn_beyond_the_margins_and_every_text_can_be_read() {
        let law = |law| vec![law, "work_speed_rpm=300.0"];
        for (job, set, count) in [
            ("four_lobe_camshaft", vec![], 20),
            ("four_lobe_camshaft", law("speed.law=time_optimal"), 20),
            ("four_lobe_camshaft", law("speed={law: constant_removal_rate, removal_rate_mm2_s: 10.0}"), 20),
            ("four_lobe_camshaft", law("speed={law: constant_footprint_speed, footprint_speed_mm_s: 300.0}"), 20),
            ("rough_and_finish", vec![], 36),
            ("eccentric", vec![], 5),
            ("eccentric", vec!["infeed.spark_out_turns=0"], 6),
            ("plate_cam", vec!["infeed.per_block_um=null", "infeed.per_turn_um=[200, 100, 60]"], 6),
            ("brake_cam", vec![], 5),
            ("dressed_batch", vec![], 36),
            ("journal_runout", vec![], 27),
            ("plate_cam", vec![], 5),
            ("crank_pins", vec![], 18),
            ("pump_ring", vec![], 9),
            ("punches", vec![], 10),
            ("wide_lobes", vec![], 39),
            ("tapered_lobes", vec![], 20),
            ("long_camshaft", vec![], 60),
            ("long_camshaft_seat", vec![], 10),
        ] {
            let plots = drawn(job, &set);
            assert_eq!(plots.len(), count, "{job} {set:?}");
            for plot in plots {
                let [low, high] = plot.drawing.extent();
                assert!(low[0] >= 8.0 && low[1] >= 8.0, "{job} {set:?} {}: {low:?}", plot.name);
                assert!(high[0] <= PAPER.0 - 8.0 && high[1] <= PAPER.1 - 4.0, "{job} {set:?} {}: {high:?}", plot.name);
                assert_eq!(plot.drawing.text_faults(), [""; 0], "{job} {set:?} {}", plot.name);
            }
        }
    }

    #[test]
    fn the_same_job_gives_the_same_bytes() {
        let (one, other) = (drawn("eccentric", &[]), drawn("eccentric", &[]));
        let names: Vec<&str> = one.iter().map(|plot| plot.name.as_str()).collect();
        assert_eq!(names, ["contour", "tool_path", "c_axis", "x_axis", "removal_rate"]);
        for (one, other) in one.iter().zip(&other) {
            assert_eq!(svg(&one.drawing), svg(&other.drawing), "{}", one.name);
            assert_eq!(png(&one.drawing).unwrap(), png(&other.drawing).unwrap(), "{}", one.name);
        }
    }
}
