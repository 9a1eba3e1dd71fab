// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Mutated files: shipped files of every kind, small ones beside them, and the commands that read them.

use super::bags::BagSeed;
use super::mutate;
use super::random::Random;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Kinds of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Job,
    Machine,
    Lift,
    Surface,
    Stl,
    Program,
    Parameters,
    Bag,
}

impl Kind {
    pub const ALL: [Self; 8] =
        [Self::Job, Self::Machine, Self::Lift, Self::Surface, Self::Stl, Self::Program, Self::Parameters, Self::Bag];

    /// Cases of a hundred: jobs are what people write, and where most of the work hangs on single numbers.
    pub const fn weight(self) -> usize {
        match self {
            Self::Job => 40,
            Self::Machine => 10,
            Self::Bag => 15,
            Self::Lift | Self::Surface => 8,
            Self::Stl | Self::Program => 7,
            Self::Parameters => 5,
        }
    }

    pub const fn name(self) -> &'static str {
        match self {
            Self::Job => "jobs",
            Self::Machine => "machines",
            Self::Lift => "lifts",
            Self::Surface => "surfaces",
            Self::Stl => "stl",
            Self::Program => "programs",
            Self::Parameters => "parameters",
            Self::Bag => "bags",
        }
    }
}

/// A file that exists, to be changed.
#[derive(Debug, Clone)]
struct Seed {
    name: String,
    extension: String,
    text: String,
}

/// A program that the program under test made.
#[derive(Debug, Clone)]
struct Program {
    control: &'static str,
    job: &'static str,
    /// Its files, the main program first.
    files: Vec<Seed>,
}

/// All that is changed.
#[derive(Debug)]
pub struct Subjects {
    jobs: Vec<Seed>,
    machines: Vec<Seed>,
    lifts: Vec<Seed>,
    surfaces: Vec<Seed>,
    /// Triangles as text and as bytes.
    stl_text: String,
    stl_bytes: Vec<u8>,
    programs: Vec<Program>,
    parameters: Seed,
    bags: Vec<BagSeed>,
}

/// A lobe whose plan takes a moment, so that many can be tried.
pub const SMALL_JOB: &str = "schema: camwright/job/1
name: one_lobe
title: one
machine: cam_grinder
profiles:
  - name: intake
    base_radius_mm: 16.0
    follower: {kind: roller, radius_mm: 8.5}
    lift:
      segments:
        - {law: dwell, angle_deg: 120}
        - {law: 4-5-6-7, angle_deg: 120, rise_mm: 4.0}
        - {law: 4-5-6-7, angle_deg: 120, rise_mm: -4.0}
lobes:
  - {name: I1, station: LS1, profile: intake, phase_deg: 210.0, width_mm: 14.0}
stock_mm: 0.3
rapid_advance_mm: 40.0
rapid_speed_mm_s: 100.0
infeed: {total_mm: 0.36, per_block_um: 0.01, spark_out_turns: 4}
work_speed_rpm: 60.0
rotary_indexing: false
home: {x_mm: 150.0, z_mm: 0.0}
";

/// Keys that the shipped jobs do not use, each on a line that fits below [`SMALL_JOB`].
const MORE_KEYS: [&str; 14] = [
    "blocks_per_turn: 360",
    "speed: {law: time_optimal}",
    "speed: {law: footprint, mm_s: 100.0}",
    "retract_clearance_mm: 1.0",
    "hold_in_cut: stop_infeed",
    "c_between_lobes: turns_on",
    "arrival_margin_ms: 10.0",
    "lobe_order: fastest",
    "clearance_mm: 1.0",
    "part_phase_deg: 20.0",
    "dry_run: {stand_off_mm: 5.0}",
    "wheel_power: {max_w: 8000.0, specific_energy_j_mm3: 30.0}",
    "nc: {control: fanuc, linear_decimals: 4, finish_tolerance_um: 0.5, lead_deg: 45.0}",
    "form_compensation: {gain: 0.5, harmonics: 40}",
];

/// Controls, extension of their main programs, and jobs of which programs are made.
const PROGRAMS: [(&str, &str, &str); 3] =
    [("linuxcnc", "ngc", "four_lobe_camshaft"), ("fanuc", "NC", "four_lobe_camshaft"), ("siemens", "MPF", "eccentric")];

/// A short part; `SURFACE` stands for its surface.
pub const SMALL_TURNED: &str = "schema: camwright/turning_job/1
name: turn_small
machine: lathe
surface: SURFACE
turned: {from_mm: 8.0, to_mm: 2.0}
bar_radius_mm: 22.0
part_zero_mm: 2.0
roughing: {deepest_mm: 3.0, leaves_mm: 0.3, along_z_mm: 0.5}
finishing: {along_z_mm: 0.5}
spindle: {law: fastest}
rapid_speed_mm_s: 200.0
tolerance_um: 10.0
form_grid: {azimuths: 180, column_mm: 0.2}
";

pub const SURFACES: [&str; 5] = [
    "{kind: eccentric, radius_mm: 20.0, eccentricity_mm: 1.5, from_mm: 0.0, to_mm: 24.0}",
    "{kind: cylinder, radius_mm: 20.0, from_mm: 0.0, to_mm: 24.0}",
    "{kind: elliptic_cone, from_mm: 0.0, to_mm: 24.0, first_mm: {from: 21.0, to: 20.5}, second_mm: 20.0, azimuth_deg: 10.0}",
    "{kind: lobed, from_mm: 0.0, to_mm: 24.0, mean_mm: 20.0, waves: [{per_turn: 3, amplitude_mm: 0.5, phase_deg: {from: 0.0, to: 20.0}}]}",
    "{kind: grid, file: surface.csv}",
];

fn eccentric_radius(azimuth_rad: f64) -> f64 {
    1.5 * azimuth_rad.cos() + (400.0 - (1.5 * azimuth_rad.sin()).powi(2)).sqrt()
}

/// An eccentric as a table of radii.
pub fn grid(azimuths: usize, rows: usize) -> String {
    let step_deg = 360.0 / azimuths as f64;
    let azimuth_deg: Vec<String> = (0..azimuths).map(|k| format!("{}", k as f64 * step_deg)).collect();
    let radii: Vec<String> =
        (0..azimuths).map(|k| format!("{:.4}", eccentric_radius((k as f64 * step_deg).to_radians()))).collect();
    let mut text = format!("z_mm,{}\n", azimuth_deg.join(","));
    for row in 0..rows {
        text += &format!("{},{}\n", 2 * row, radii.join(","));
    }
    text
}

/// The wall of an eccentric as triangles.
fn triangles(azimuths: usize, rows: usize) -> Vec<[[f64; 3]; 3]> {
    let corner = |k: usize, row: usize| {
        let azimuth = std::f64::consts::TAU * (k % azimuths) as f64 / azimuths as f64;
        let radius = eccentric_radius(azimuth);
        [radius * azimuth.cos(), radius * azimuth.sin(), 24.0 * row as f64 / rows as f64]
    };
    let mut all = Vec::new();
    for row in 0..rows {
        for k in 0..azimuths {
            let [a, b, c, d] = [corner(k, row), corner(k + 1, row), corner(k + 1, row + 1), corner(k, row + 1)];
            all.push([a, b, c]);
            all.push([a, c, d]);
        }
    }
    all
}

fn stl_text(all: &[[[f64; 3]; 3]]) -> String {
    let mut text = String::from("solid part\n");
    for corners in all {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in corners {
            text += &format!("  vertex {x:.5} {y:.5} {z:.5}\n");
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid part\n"
}

fn stl_bytes(all: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend_from_slice(&(all.len() as u32).to_le_bytes());
    for corners in all {
        bytes.extend_from_slice(&[0; 12]);
        for number in corners.as_flattened() {
            bytes.extend_from_slice(&(*number as f32).to_le_bytes());
        }
        bytes.extend_from_slice(&[0; 2]);
    }
    bytes
}

fn read(folder: &Path, extension: &str) -> Vec<Seed> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder).expect("shipped files").filter_map(Result::ok).map(|e| e.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|found| found == extension));
    paths.sort();
    let seed = |path: PathBuf| Seed {
        name: path.file_stem().expect("a name").to_string_lossy().into_owned(),
        extension: extension.to_owned(),
        text: fs::read_to_string(&path).expect("a text"),
    };
    paths.into_iter().map(seed).collect()
}

impl Subjects {
    /// Reads the shipped files, and makes programs with the program under test; `scratch` is for these.
    pub fn new(repository: &Path, program: &Path, scratch: &Path) -> Self {
        let params = repository.join("params");
        let mut jobs = read(&params.join("jobs"), "yaml");
        jobs.push(Seed { name: "one_lobe".into(), extension: "yaml".into(), text: SMALL_JOB.into() });
        for surface in &SURFACES[..4] {
            jobs.push(Seed {
                name: "turn_small".into(),
                extension: "yaml".into(),
                text: SMALL_TURNED.replace("SURFACE", surface),
            });
        }
        let programs = PROGRAMS.map(|(control, extension, job)| {
            let out = scratch.join(control);
            let set = format!("nc.control={control}");
            let made = Command::new(program).args(["post", job, "--set", &set, "--out"]).arg(&out).output();
            assert!(made.expect("it starts").status.success(), "no program for {control}");
            let mut files = read(&out, extension);
            if control == "siemens" {
                files.extend(read(&out, "SPF"));
            }
            Program { control, job, files }
        });
        let all = triangles(48, 12);
        Self {
            jobs,
            machines: read(&params.join("machines"), "yaml"),
            lifts: vec![
                Seed {
                    name: "intake".into(),
                    extension: "csv".into(),
                    text: fs::read_to_string(params.join("lifts/intake.csv")).expect("a lift"),
                },
                Seed { name: "small".into(), extension: "csv".into(), text: small_lift() },
            ],
            surfaces: vec![
                Seed { name: "grid".into(), extension: "csv".into(), text: grid(36, 13) },
                Seed { name: "fine".into(), extension: "csv".into(), text: grid(120, 25) },
            ],
            stl_text: stl_text(&all),
            stl_bytes: stl_bytes(&all),
            programs: programs.into(),
            parameters: Seed {
                name: "nodes".into(),
                extension: "yaml".into(),
                text: fs::read_to_string(params.join("nodes.yaml")).expect("parameters"),
            },
            bags: ["ground", "program", "turned", "runout"]
                .map(|name| BagSeed::read(&repository.join("bags/golden").join(name)))
                .into(),
        }
    }

    /// Writes a mutated file into a folder, and returns what reads it.
    pub fn prepare(&self, kind: Kind, random: &mut Random, folder: &Path) -> Vec<String> {
        let write = |name: &str, bytes: &[u8]| fs::write(folder.join(name), bytes).expect("room");
        match kind {
            Kind::Job => {
                let seed = random.pick(&self.jobs);
                let donor = random.pick(&self.jobs);
                let mut text = seed.text.clone();
                if seed.name == "one_lobe" && random.below(2) == 0 {
                    text = format!("{text}{}\n", *random.pick(&MORE_KEYS));
                }
                write("job.yaml", &mutate::text(random, &text, &donor.text));
                job_command(random)
            }
            Kind::Machine => {
                let seed = random.pick(&self.machines);
                let donor = random.pick(&self.machines);
                write("machine.yaml", &mutate::text(random, &seed.text, &donor.text));
                let job = match seed.name.as_str() {
                    "lathe" => SMALL_TURNED.replace("SURFACE", SURFACES[0]).replace(": lathe", ": machine.yaml"),
                    "journal_grinder" => self.job("journal_runout").replace(": journal_grinder", ": machine.yaml"),
                    "cam_grinder_with_steady_rest" => {
                        let job = self.job("long_camshaft_seat");
                        job.replace(": cam_grinder_with_steady_rest", ": machine.yaml")
                    }
                    "cam_grinder_with_dresser" => {
                        self.job("dressed_batch").replace(": cam_grinder_with_dresser", ": machine.yaml")
                    }
                    _ => SMALL_JOB.replace(": cam_grinder", ": machine.yaml"),
                };
                write("job.yaml", job.as_bytes());
                match random.below(4) {
                    0 => vec!["urdf".into(), "machine.yaml".into()],
                    _ => job_command(random),
                }
            }
            Kind::Lift => {
                let seed = random.pick(&self.lifts);
                let donor = random.pick(&self.lifts);
                write("lift.csv", &mutate::text(random, &seed.text, &donor.text));
                let job = SMALL_JOB;
                let (begin, end) = (job.find("    lift:").unwrap_or(0), job.find("lobes:").unwrap_or(0));
                let smoothed = *random.pick(&[
                    "",
                    ", reading: cubic_spline",
                    ", resolution_mm: 0.0001",
                    ", smooth_within_um: 2.0",
                ]);
                let job = format!("{}    lift: {{table: lift.csv{smoothed}}}\n{}", &job[..begin], &job[end..]);
                write("job.yaml", job.as_bytes());
                match random.below(2) {
                    0 => vec!["check".into(), "lift.csv".into()],
                    _ => job_command(random),
                }
            }
            Kind::Surface => {
                let seed = random.pick(&self.surfaces);
                write("surface.csv", &mutate::text(random, &seed.text, &self.surfaces[0].text));
                write("job.yaml", SMALL_TURNED.replace("SURFACE", SURFACES[4]).as_bytes());
                random.pick(&TURNED_COMMANDS).split(' ').map(str::to_owned).collect()
            }
            Kind::Stl => {
                let mutated = match random.below(2) {
                    0 => mutate::text(random, &self.stl_text, &self.stl_text),
                    _ => mutate::bytes(random, &self.stl_bytes, self.stl_text.as_bytes()),
                };
                write("part.stl", &mutated);
                let unit = random.pick(&["mm", "mm", "mm", "inch", "m"]);
                let surface = format!("{{kind: mesh, file: part.stl, unit: {unit}}}");
                write("job.yaml", SMALL_TURNED.replace("SURFACE", &surface).as_bytes());
                random.pick(&TURNED_COMMANDS).split(' ').map(str::to_owned).collect()
            }
            Kind::Program => {
                let Program { control, job, files } = random.pick(&self.programs);
                let donor = &random.pick(&self.programs).files[0];
                let changed = random.below(files.len());
                for (index, file) in files.iter().enumerate() {
                    let text = if index == changed {
                        mutate::text(random, &file.text, &donor.text)
                    } else {
                        file.text.clone().into_bytes()
                    };
                    write(&format!("{}.{}", file.name, file.extension), &text);
                }
                let main = format!("{}.{}", files[0].name, files[0].extension);
                let job = format!("{}\nprogram: {main}\nnc: {{control: {control}}}\n", self.job(job));
                write("job.yaml", job.as_bytes());
                vec!["check".into(), "job.yaml".into()]
            }
            Kind::Parameters => {
                write("nodes.yaml", &mutate::text(random, &self.parameters.text, SMALL_JOB));
                // The command ends before it would take part in anything.
                let arguments = ["urdf", "--ros-args", "--params-file", "nodes.yaml"];
                arguments.map(str::to_owned).into()
            }
            Kind::Bag => {
                random.pick(&self.bags).mutated(random, &folder.join("bag"));
                let command = *random.pick(&[
                    "bag info bag",
                    "bag info bag --json",
                    "bag check bag",
                    "bag check bag --json",
                    "bag recover bag --into new",
                    "bag export bag --into new",
                    "bag export bag --into new --to parquet",
                    "bag export bag --into new --to zstd",
                    "bag report bag --out page.html",
                    "replay bag --against",
                    "replay bag --against",
                    "replay bag --against bag --to-tick 5000",
                    "replan bag",
                ]);
                command.split(' ').map(str::to_owned).collect()
            }
        }
    }

    fn job(&self, name: &str) -> &str {
        self.jobs.iter().find(|seed| seed.name == name).map_or("", |seed| seed.text.as_str())
    }
}

/// 120 steps of 3° of a lift that is smooth enough.
fn small_lift() -> String {
    let lift = |deg: f64| match (deg - 180.0).abs() {
        away if away < 100.0 => 5.0 * (0.5 + 0.5 * (std::f64::consts::PI * away / 100.0).cos()).powi(2),
        _ => 0.0,
    };
    let row = |k: u32| format!("{:.1},{:.4}\n", f64::from(k) * 3.0, lift(f64::from(k) * 3.0));
    "cam_angle_deg,lift_mm\n".to_owned() + &(0..120).map(row).collect::<String>()
}

/// Commands that read turning jobs.
const TURNED_COMMANDS: [&str; 3] =
    ["check job.yaml", "plan job.yaml --out out", "plan job.yaml --out out --plots --json"];

fn job_command(random: &mut Random) -> Vec<String> {
    let command = *random.pick(&[
        "check job.yaml",
        "check job.yaml",
        "check job.yaml --json",
        "plan job.yaml --out out",
        "plan job.yaml --out out --plots --json",
        "post job.yaml --out out",
    ]);
    command.split(' ').map(str::to_owned).collect()
}
