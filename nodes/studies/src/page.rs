// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Report of a study: one HTML page that needs no other file.

use super::analysis::{FactorEffect, short};
use super::folder::{StudyFolder, set_text};
use super::results::{StudyResults, StudyRow};
use camwright_files::study_file::StudyResponse;
use camwright_planning::chart::{Axes, Frame, Scale};
use camwright_planning::markup::escape;
use std::fmt::Write as _;

/// Maximum number of points of a scatter that are drawn; the table files hold all.
const MAX_POINTS: usize = 4000;

const STYLE: &str = "\
:root { color-scheme: light dark; --ground: #f2f4f6; --panel: #fff; --ink: #16202a; --faint: #55626f; --line: #cfd6dd; --good: #1d8348; --bad: #c0292b; --is: #1f6fb2; }
@media screen and (prefers-color-scheme: dark) { :root { --ground: #11161b; --panel: #1b222a; --ink: #e9eef3; --faint: #a3b0bc; --line: #3a4650; --is: #5aa9e6; } }
* { box-sizing: border-box; margin: 0; }
body { background: var(--ground); color: var(--ink); font: 15px/1.4 system-ui, \"DejaVu Sans\", sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 12px 20px 40px; }
.verdict { color: #fff; border-radius: 8px; padding: 10px 22px; print-color-adjust: exact; } .good { background: var(--good); } .bad { background: var(--bad); }
section { background: var(--panel); border-radius: 8px; margin-top: 12px; padding: 12px 18px 16px; overflow-x: auto; }
h2 { font-size: 19px; margin-bottom: 6px; } .faint { color: var(--faint); }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(290px, 1fr)); gap: 10px 18px; }
figure { min-width: 0; break-inside: avoid; } figcaption { color: var(--faint); font-weight: 600; font-size: 14px; }
svg { display: block; width: 100%; height: auto; } svg text { fill: var(--faint); font-size: 11px; } svg .end { text-anchor: end; } svg .mid { text-anchor: middle; }
path { fill: none; stroke: var(--line); } path.is { stroke: var(--is); stroke-width: 1.8; } path.range { stroke: var(--is); opacity: .45; } path.limit { stroke: var(--good); stroke-dasharray: 5 3; }
circle { fill: var(--faint); opacity: .55; } circle.ok { fill: var(--is); opacity: .8; } circle.front { fill: var(--bad); opacity: 1; }
table { border-collapse: collapse; } td, th { padding: 3px 14px 3px 0; text-align: right; vertical-align: top; border-bottom: 1px solid var(--line); }
td.text, th.text { text-align: left; } pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: 13px; }
";

impl StudyResults<'_> {
    /// The page.
    pub(crate) fn page(&self, folder: &StudyFolder) -> String {
        let study = self.study;
        let class = if self.is_good() { "good" } else { "bad" };
        let mut out = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
             <title>Study {name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
             <p class=\"faint\">Study {name} of job {job}. {title}</p>\n<div class=\"verdict {class}\"><h1>{}</h1></div>\n",
            escape(&self.verdict()),
            name = escape(&study.name),
            job = escape(&study.job),
            title = escape(&study.title),
        );
        self.write_best(&mut out, folder);
        self.write_front(&mut out);
        self.write_effects(&mut out);
        self.write_failures(&mut out);
        let _infallible = write!(
            out,
            "<section><h2>Study file</h2><pre>{}</pre><p class=\"faint\">camwright {}; all cases are in results.parquet \
             and results.csv, their settings in plan.json.</p></section>\n</main>\n</body>\n</html>\n",
            escape(&study.document.text),
            env!("CARGO_PKG_VERSION")
        );
        out
    }

    fn write_best(&self, out: &mut String, folder: &StudyFolder) {
        out.push_str("<section><h2>Best feasible case</h2>");
        match self.best() {
            Some(best) => {
                self.write_rows(out, &[best.row]);
                let command = escape(&self.command(&best, folder));
                let _infallible = write!(out, "<pre>{command}</pre>");
            }
            None => {
                let _infallible = write!(out, "<p>No point keeps {}.</p>", escape(&self.limits_text()));
            }
        }
        out.push_str("</section>\n");
    }

    /// Table of cases.
    fn write_rows(&self, out: &mut String, rows: &[usize]) {
        out.push_str("<table><tr><th>case</th>");
        for response in &self.study.responses {
            let _infallible = write!(out, "<th>{}</th>", response.name());
        }
        out.push_str("<th class=\"text\">settings</th></tr>");
        for row in rows.iter().filter_map(|index| self.rows.get(*index)) {
            let _infallible = write!(out, "<tr><td>{}</td>", row.case.number);
            for response in &self.study.responses {
                let value = row.outcome.response(*response).map_or_else(|| "–".to_owned(), short);
                let _infallible = write!(out, "<td>{value}</td>");
            }
            let set: Vec<String> = row.case.settings.iter().map(set_text).collect();
            let _infallible = write!(out, "<td class=\"text\">{}</td></tr>", escape(&set.join("  ")));
        }
        out.push_str("</table>");
    }

    fn write_front(&self, out: &mut String) {
        out.push_str("<section><h2>Time against form error</h2>");
        let point = |row: &StudyRow| {
            let response = |response| row.outcome.response(response);
            Some((response(StudyResponse::JobTimeS)?, response(StudyResponse::FormErrorMaxUm)?, row.is_feasible))
        };
        let points: Vec<(f64, f64, bool)> = self.rows.iter().filter_map(point).take(MAX_POINTS).collect();
        if points.is_empty() {
            out.push_str("<p class=\"faint\">No case made a part.</p></section>\n");
            return;
        }
        let axes = axes(900.0, 320.0, points.iter().map(|p| p.0), points.iter().map(|p| p.1));
        out.push_str("<figure><figcaption>form_error_max_um over job_time_s; blue: feasible, red: no other case is both \
             faster and better</figcaption><svg viewBox=\"0 0 900 320\" role=\"img\" aria-label=\"time against form error\">");
        write_axes(out, &axes);
        write_ticks(out, &axes);
        let limit = self.study.limits.iter().find(|(response, _)| *response == StudyResponse::FormErrorMaxUm);
        if let Some((_, max)) = limit.filter(|(_, max)| *max < axes.up.high) {
            let (left, right, y) = (axes.frame.left, axes.frame.right(), axes.y(*max));
            let _infallible = write!(out, "<path class=\"limit\" d=\"M{left:.1} {y:.1}H{right:.1}\"/>");
        }
        for (time_s, error_um, is_feasible) in &points {
            let [x, y] = axes.at(*time_s, *error_um);
            let class = if *is_feasible { " class=\"ok\"" } else { "" };
            let _infallible = write!(out, "<circle{class} cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
        }
        let front = self.front();
        for (time_s, error_um, _) in front.iter().filter_map(|index| point(&self.rows[*index])) {
            let [x, y] = axes.at(time_s, error_um);
            let _infallible = write!(out, "<circle class=\"front\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
        }
        out.push_str("</svg></figure>");
        self.write_rows(out, &front);
        out.push_str("</section>\n");
    }

    fn write_effects(&self, out: &mut String) {
        out.push_str(
            "<section><h2>Main effects</h2><p class=\"faint\">Mean over all cases with the same value of the factor; \
             bars from the lowest to the highest case.</p>",
        );
        for factor in &self.study.factors {
            let _infallible = write!(out, "<h3>{}</h3><div class=\"figures\">", escape(&factor.key));
            let effects = self.effects();
            for effect in effects.iter().filter(|effect| effect.key == factor.key && !effect.levels.is_empty()) {
                write_effect(out, effect);
            }
            out.push_str("</div>");
        }
        out.push_str("</section>\n");
    }

    fn write_failures(&self, out: &mut String) {
        let failures = self.failures();
        if failures.is_empty() {
            return;
        }
        out.push_str(
            "<section><h2>Failures by reason</h2><table><tr><th>cases</th><th class=\"text\">end</th><th>first case</th>\
             <th class=\"text\">reason of the first case</th></tr>",
        );
        for failure in failures {
            let _infallible = write!(
                out,
                "<tr><td>{}</td><td class=\"text\">{}</td><td>{}</td><td class=\"text\">{}</td></tr>",
                failure.count,
                failure.status.name(),
                failure.first_case,
                escape(&failure.reason)
            );
        }
        out.push_str("</table></section>\n");
    }
}

fn axes(width: f64, height: f64, across: impl Iterator<Item = f64>, up: impl Iterator<Item = f64>) -> Axes {
    let frame = Frame { left: 58.0, top: 10.0, width: width - 76.0, height: height - 36.0 };
    Axes { frame, across: Scale::around(across), up: Scale::around(up) }
}

fn write_axes(out: &mut String, axes: &Axes) {
    let Frame { left, top, .. } = axes.frame;
    let (right, bottom) = (axes.frame.right(), axes.frame.bottom());
    let _infallible = write!(out, "<path d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\"/>");
    for tick in axes.up.ticks() {
        let y = axes.y(tick);
        let _infallible = write!(
            out,
            "<path d=\"M{left:.1} {y:.1}H{right:.1}\" opacity=\".5\"/><text class=\"end\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            left - 6.0,
            y + 4.0,
            axes.up.label(tick)
        );
    }
}

/// A label below a place across.
fn write_label(out: &mut String, axes: &Axes, across: f64, label: &str) {
    let (x, y) = (axes.x(across), axes.frame.bottom() + 16.0);
    let _infallible = write!(out, "<text class=\"mid\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escape(label));
}

fn write_ticks(out: &mut String, axes: &Axes) {
    axes.across.ticks().for_each(|tick| write_label(out, axes, tick, &axes.across.label(tick)));
}

/// Chart of one effect; values that are no numbers stand side by side.
fn write_effect(out: &mut String, effect: &FactorEffect) {
    let places: Vec<f64> =
        effect.levels.iter().enumerate().map(|(index, level)| level.at.unwrap_or(index as f64)).collect();
    let is_number = effect.levels.iter().all(|level| level.at.is_some());
    let bounds = effect.levels.iter().flat_map(|level| [level.min, level.max]);
    let axes = axes(300.0, 170.0, places.iter().copied(), bounds);
    let title = escape(effect.response.name());
    let _infallible = write!(
        out,
        "<figure><figcaption>{title}</figcaption><svg viewBox=\"0 0 300 170\" role=\"img\" aria-label=\"{title} over {}\">",
        escape(&effect.key)
    );
    write_axes(out, &axes);
    match is_number {
        true => write_ticks(out, &axes),
        false => {
            let labels = effect.levels.iter().zip(&places);
            labels.for_each(|(level, place)| write_label(out, &axes, *place, &level.label));
        }
    }
    let mut line = String::new();
    for (index, (level, place)) in effect.levels.iter().zip(&places).enumerate() {
        let [x, y] = axes.at(*place, level.mean);
        let (low, high) = (axes.y(level.min), axes.y(level.max));
        let _infallible = write!(line, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
        let _infallible = write!(
            out,
            "<path class=\"range\" d=\"M{x:.1} {low:.1}V{high:.1}\"/><circle class=\"ok\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>"
        );
    }
    let _infallible = write!(out, "<path class=\"is\" d=\"{line}\"/></svg></figure>");
}
