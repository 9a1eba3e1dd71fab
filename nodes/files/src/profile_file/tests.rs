// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Kinds of cams that a profile can be, and what is refused of each.

use super::*;
use camwright::cam::contour::Contour;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use tempfile::TempDir;

/// Files in a folder of their own beside a job.
struct Folder(TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder for temporary files");
        for (file, text) in files {
            std::fs::write(folder.path().join(file), text).expect("a file in it");
        }
        Self(folder)
    }

    /// Reads the keys of a profile, written in YAML flow form.
    fn read(&self, profile: &str) -> Result<ProfileSpec, Vec<String>> {
        self.read_whole(profile).map(|(spec, _)| spec)
    }

    fn read_whole(&self, profile: &str) -> Result<(ProfileSpec, ProfileLift), Vec<String>> {
        #[derive(Deserialize, JsonSchema)]
        struct ProfilesOnly {
            profiles: Vec<ProfileFile>,
        }
        let error_text = |error: ConfigError| error.to_string().replace(&format!("{}/", self.0.path().display()), "");
        let text = format!("profiles:\n  - {{name: p, {profile}}}\n");
        let document =
            Document::parse(&self.0.path().join("job.yaml"), &text, &[]).map_err(|error| vec![error_text(error)])?;
        let file: ProfilesOnly =
            crate::schema::read(&document).map_err(|errors| errors.into_iter().map(error_text).collect::<Vec<_>>())?;
        let found = findings("profiles", &file.profiles);
        if !found.is_empty() {
            return Err(found.into_iter().map(|(_, message)| message).collect());
        }
        let read = file.profiles[0].read(&document, ("profiles", 0), &[], &mut JobFiles::from_document(&document));
        read.map_err(|errors| errors.into_iter().map(error_text).collect())
    }

    fn contour(&self, profile: &str) -> Contour {
        let spec = self.read(profile).expect("a profile");
        Contour::from_lift(&spec.lift, &spec.follower, spec.base_radius_mm).expect("a contour")
    }
}

fn contour(profile: &str) -> Contour {
    Folder::new(&[]).contour(profile)
}

fn refusal(profile: &str) -> String {
    Folder::new(&[]).read(profile).expect_err("it is no profile").join("\n")
}

fn azimuths() -> impl Iterator<Item = f64> {
    (0..720).map(|i| TURN_RAD * (f64::from(i) + 0.31) / 720.0)
}

/// Radius of a disc of radius r, its middle e beside the axis towards `nose`, at an azimuth.
fn disc(e: f64, r: f64, nose: f64, azimuth: f64) -> f64 {
    let angle = azimuth - nose;
    e * angle.cos() + (r * r - (e * angle.sin()).powi(2)).sqrt()
}

/// E 4.2 and D 38: the disc's own radius is 19 mm, or with D as the largest diameter over all 14.8 mm.
#[test]
fn an_eccentric_by_its_diameter_is_the_disc() {
    for (diameter_is, r) in [("disc", 19.0), ("largest", 14.8)] {
        let found = contour(&format!(
            "lift: {{eccentric: {{eccentricity_mm: 4.2, diameter_mm: 38, diameter_is: {diameter_is}, nose_deg: 30}}}}"
        ));
        for azimuth in azimuths() {
            let wanted = disc(4.2, r, rad_from_deg(30.0), azimuth);
            assert!((found.radius_at(azimuth) - wanted).abs() < 1e-9, "{diameter_is}, {azimuth}");
        }
    }
}

/// A crank pin by its throw, and the same disc as an eccentric that misses the axis: the circle about its own centre.
#[test]
fn a_crank_pin_is_a_circle_beside_the_axis() {
    for (lift, throw_mm, radius_mm) in [
        ("{crank_pin: {throw_mm: 40, diameter_mm: 50}}", 40.0, 25.0),
        ("{eccentric: {eccentricity_mm: 40, diameter_mm: 50, diameter_is: disc}}", 40.0, 25.0),
        ("{eccentric: {eccentricity_mm: 19, diameter_mm: 38, diameter_is: disc}}", 19.0, 19.0),
        ("{eccentric: {eccentricity_mm: 10, diameter_mm: 38, diameter_is: largest}}", 10.0, 9.0),
    ] {
        let spec = Folder::new(&[]).read(&format!("lift: {lift}")).expect("a pin");
        assert!(spec.is_pin() && !spec.is_round(), "{lift}");
        let contour = spec.contour().expect("a circle");
        assert!((contour.throw_mm() - throw_mm).abs() < 1e-12, "{lift}: {}", contour.throw_mm());
        for azimuth in azimuths() {
            assert!((contour.radius_at(azimuth) - radius_mm).abs() < 1e-12, "{lift}, {azimuth}");
            let point = contour.point_about_axis(azimuth);
            assert!(((point.x - throw_mm).hypot(point.y) - radius_mm).abs() < 1e-9, "{lift}, {azimuth}");
        }
    }
}

#[test]
fn a_crank_pin_that_is_none_is_refused() {
    for (keys, words) in [
        ("lift: {crank_pin: {throw_mm: 0, diameter_mm: 50}}", "throw_mm is 0; it must be 0.000001 to 10000"),
        ("lift: {crank_pin: {throw_mm: 40, diameter_mm: -50}}", "diameter_mm is -50; it must be 0.000001 to 10000"),
        ("lift: {crank_pin: {throw_mm: 40}}", "diameter_mm"),
        (
            "base_radius_mm: 25, lift: {crank_pin: {throw_mm: 40, diameter_mm: 50}}",
            "base_radius_mm is given, but the lift defines the contour itself",
        ),
        (
            "lift: {crank_pin: {throw_mm: 40, diameter_mm: 50}, reading: smoothest}",
            "reading is about a table; this lift is a formula",
        ),
        (
            "lift: {crank_pin: {throw_mm: 40, diameter_mm: 50}, round: true}",
            "lift needs exactly one of: table, half_table",
        ),
        (
            "gauge: {kind: flat}, lift: {crank_pin: {throw_mm: 40, diameter_mm: 50}}",
            "a crank pin is measured about its own centre",
        ),
    ] {
        let result = refusal(keys);
        assert!(result.starts_with("job.yaml:2: profile") && result.contains(words), "{keys}: {result}");
    }
}

#[test]
fn an_eccentric_that_is_none_is_refused() {
    let lift = |keys: &str| refusal(&format!("lift: {{eccentric: {{{keys}}}}}"));
    for (keys, words) in [
        (
            "eccentricity_mm: 4, diameter_mm: 38",
            "needs diameter_mm and what it is that of, diameter_is: disc or largest",
        ),
        ("eccentricity_mm: 4, diameter_is: disc", "needs diameter_mm and what it is that of"),
        (
            "eccentricity_mm: 20, diameter_mm: 38, diameter_is: largest",
            "eccentricity 20 mm leaves a disc of -1 mm within the largest diameter; it must be below half of diameter_mm",
        ),
        (
            "eccentricity_mm: 40, diameter_mm: 50, diameter_is: disc, nose_deg: 30",
            "nose_deg is 30; the disc misses the axis, and its farthest point is at cam angle 0: turn the lobe by its phase_deg",
        ),
        ("eccentricity_mm: 4", "the lift of an eccentric needs a follower and a base circle"),
    ] {
        let result = lift(keys);
        assert!(result.starts_with("job.yaml:2: profile p: ") && result.contains(words), "{keys}: {result}");
    }
    for (keys, words) in [
        ("eccentricity_mm: 4, diameter_mm: -38", "diameter_mm is -38; it must be 0.000001 to 10000"),
        ("eccentricity_mm: -4, diameter_mm: 38", "eccentricity_mm is -4; it must be 0 to 10000"),
    ] {
        let result = lift(&format!("{keys}, diameter_is: disc"));
        assert_eq!(result, format!("job.yaml:2: profiles.p.lift.eccentric.{words}"));
    }
    let disc = "lift: {eccentric: {eccentricity_mm: 4, diameter_mm: 38, diameter_is: disc}}";
    for (given, key) in [("base_radius_mm: 12", "base_radius_mm"), ("follower: {kind: flat}", "follower")] {
        let result = refusal(&format!("{given}, {disc}"));
        assert_eq!(
            result,
            format!(
                "job.yaml:2: profile p: {key} is given, but the lift defines the contour itself; remove one of both"
            )
        );
    }
}

#[test]
fn a_lift_needs_what_it_is_a_lift_of() {
    let round = "lift: {round: true}";
    assert!(
        refusal(&format!("base_radius_mm: 10, {round}"))
            .contains("follower is missing; this lift needs it to define a contour")
    );
    assert!(refusal(&format!("follower: {{kind: flat}}, {round}")).contains("base_radius_mm is missing"));
    assert!(
        refusal(&format!("base_radius_mm: -1, follower: {{kind: flat}}, {round}")).contains("base_radius_mm is -1")
    );
}

/// Three equal lobes: the contour is the same a third of a turn further, and has the height of its segments.
#[test]
fn segments_are_repeated_over_the_turn() {
    let lobes = |repeat: &str| {
        format!(
            "base_radius_mm: 30, follower: {{kind: roller, radius_mm: 10}}, lift: {{{repeat}segments: [{{law: dwell, angle_deg: 30}}, \
             {{law: 4-5-6-7, angle_deg: 40, rise_mm: 3}}, {{law: dwell, angle_deg: 10}}, {{law: 4-5-6-7, angle_deg: 40, rise_mm: -3}}]}}"
        )
    };
    let contour = contour(&lobes("repeat: 3, "));
    for azimuth in azimuths() {
        let (here, there) = (contour.radius_at(azimuth), contour.radius_at(azimuth + TURN_RAD / 3.0));
        assert!((here - there).abs() < 1e-9, "{azimuth}: {here} {there}");
    }
    assert!((contour.radius_at(rad_from_deg(75.0)) - 33.0).abs() < 1e-9);
    assert!(refusal(&lobes("")).contains("the segments cover 120.000000 deg, one turn is 360 deg"));
    assert!(refusal(&lobes("repeat: 2, ")).contains("the segments cover 240.000000 deg"));
    for (repeat, words) in [
        ("0", "repeat is 0; it must be 1 to 1000"),
        ("251", "repeat is 251 with 4 segments; a turn has at most 1000 segments"),
        ("1000000000000", "repeat is 1000000000000; it must be 1 to 1000"),
    ] {
        let result = refusal(&lobes(&format!("repeat: {repeat}, ")));
        assert!(result.contains(words), "{result}");
    }
    assert!(
        refusal("base_radius_mm: 9, follower: {kind: flat}, lift: {round: true, repeat: 2}")
            .contains("repeat is about segments")
    );
}

fn s_cam(offset: f64, keys: &str) -> String {
    format!(
        "base_radius_mm: 16, follower: {{kind: roller, radius_mm: 14, offset_mm: {offset}}}, lift: {{s_cam: {{{keys}}}}}"
    )
}

/// Along the working part the normal of an arm touches the circle of the offset, which is what an involute of it does; the roller is lifted
/// by the offset per radian, without an angle of pressure; and half a turn further everything is the same.
#[test]
fn arms_of_a_brake_cam_are_involutes() {
    for offset in [8.0_f64, -8.0] {
        let contour = contour(&s_cam(offset, "working_deg: 70, blend_deg: 12"));
        let working = if offset > 0.0 { 12.0..82.0 } else { 98.0..168.0 };
        for i in 0..=100 {
            let share = f64::from(i) / 100.0;
            let angle = rad_from_deg(working.start + 1e-6 + share * (working.end - working.start - 2e-6));
            let (point, normal) = (contour.point(angle), contour.normal(angle));
            let from_axis = point.y * normal.x - point.x * normal.y;
            assert!((from_axis - offset).abs() < 1e-9, "{offset}: {from_axis} at {angle}");
            assert!(
                (contour.lift().sample(angle).first - offset).abs() < 1e-9
                    && contour.pressure_angle(angle).abs() < 1e-9
            );
        }
        assert!((contour.lift().max_lift_mm() - 8.0 * rad_from_deg(82.0)).abs() < 1e-9);
        for azimuth in azimuths() {
            let (here, there) = (contour.radius_at(azimuth), contour.radius_at(azimuth + 0.5 * TURN_RAD));
            assert!((here - there).abs() < 1e-9, "{azimuth}: {here} {there}");
        }
    }
}

#[test]
fn a_brake_cam_that_is_none_is_refused() {
    for (offset, keys, words) in [
        (0.0, "working_deg: 70, blend_deg: 12", "offset_mm is 0, it must not be 0"),
        (8.0, "working_deg: 0, blend_deg: 12", "working_deg is 0; it must be 0.000001 to 180"),
        (8.0, "working_deg: 70, blend_deg: -1", "blend_deg is -1; it must be 0.000001 to 180"),
        (
            8.0,
            "working_deg: 160, blend_deg: 12",
            "leave -4.000 deg of the half turn for the return; it must be above 0",
        ),
        (8.0, "working_deg: 70", "blend_deg"),
    ] {
        let result = refusal(&s_cam(offset, keys));
        assert!(result.contains(words), "{result}");
    }
    let flat = "base_radius_mm: 16, follower: {kind: flat}, lift: {s_cam: {working_deg: 70, blend_deg: 12}}";
    assert!(refusal(flat).contains("an s_cam is made for a roller on a line beside the axis"));
    assert!(
        refusal(&s_cam(8.0, "working_deg: 70, blend_deg: 12").replace("lift: {", "lift: {reading: smoothest, "))
            .contains("reading is about a table")
    );
}

/// A disc of radius 19 mm, 4.2 mm beside the axis towards azimuth 0, as radii over azimuths.
fn radii(count: u32, header: &str, per_mm: f64) -> String {
    (0..count).fold(header.to_owned(), |text, k| {
        let deg = 360.0 * f64::from(k) / f64::from(count);
        text + &format!("{deg},{:.5}\n", per_mm * disc(4.2, 19.0, 0.0, rad_from_deg(deg)))
    })
}

#[test]
fn a_table_of_radii_is_the_contour() {
    let text = radii(360, "azimuth_deg,radius_mm\n", 1.0);
    let inches = radii(360, "azimuth_deg,radius_inch\n", 1.0 / 25.4);
    // Half of it, from the farthest point on.
    let half: String = text.lines().take(182).fold(String::new(), |all, line| all + line + "\n");
    let folder = Folder::new(&[("r.csv", &text), ("i.csv", &inches), ("h.csv", &half)]);
    for (lift, bound) in
        [("{table: r.csv}", 2e-5), ("{table: i.csv}", 3e-4), ("{half_table: h.csv, zero_deg: 0}", 2e-5)]
    {
        let contour = folder.contour(&format!("lift: {lift}"));
        for azimuth in azimuths() {
            let off = contour.radius_at(azimuth) - disc(4.2, 19.0, 0.0, azimuth);
            assert!(off.abs() < bound, "{lift}, {azimuth}: {off}");
        }
    }
    let result = folder.read("base_radius_mm: 10, lift: {table: r.csv}").unwrap_err();
    assert!(result[0].contains("base_radius_mm is given, but the lift defines the contour itself"), "{result:?}");
}

/// Points of that disc, evenly round its own middle.
fn points(count: u32, header: &str) -> String {
    (0..count).fold(header.to_owned(), |text, k| {
        let angle = TURN_RAD * f64::from(k) / f64::from(count);
        text + &format!("{:.5};{:.5}\n", 4.2 + 19.0 * angle.cos(), 19.0 * angle.sin())
    })
}

#[test]
fn a_table_of_points_is_the_contour() {
    let text = points(360, "x_mm;y_mm\n");
    let clockwise = text.lines().skip(1).fold(String::new(), |all, line| line.to_owned() + "\n" + &all);
    let half: String = text.lines().take(182).fold(String::new(), |all, line| all + line + "\n");
    let files = [("p.csv", text.as_str()), ("c.csv", &clockwise), ("h.csv", &half)];
    let folder = Folder::new(&files);
    for lift in ["{table: p.csv}", "{table: c.csv, columns: [x_mm, y_mm]}", "{half_table: h.csv, zero_deg: 0}"] {
        let contour = folder.contour(&format!("lift: {lift}"));
        for azimuth in azimuths() {
            let off = contour.radius_at(azimuth) - disc(4.2, 19.0, 0.0, azimuth);
            assert!(off.abs() < 3e-5, "{lift}, {azimuth}: {off}");
        }
    }
    // Two digits more than the points have, and not all of a number's.
    let (_, lift) = folder.read_whole("lift: {table: p.csv}").unwrap();
    let table = lift.table.expect("a table");
    assert!(
        (table.digit_mm() - 1e-7).abs() < 1e-12
            && (table.resolution_mm() - 1e-5).abs() < 1e-15
            && table.blocks() == 720
    );
}

#[test]
fn tables_of_contours_are_refused_with_their_lines() {
    let good = points(360, "x_mm;y_mm\n");
    let lines: Vec<&str> = good.lines().collect();
    let with = |at: usize, line: &str| {
        let mut lines = lines.clone();
        lines[at - 1] = line;
        lines.join("\n")
    };
    let zero = radii(360, "azimuth_deg,radius_mm\n", 1.0).replace("\n10,23.", "\n10,-23.");
    for (text, lift, words) in [
        (with(20, lines[30]), "", "t.csv:21: the point lies at azimuth 1".to_owned()),
        (with(20, "0;0"), "", "t.csv:20: the point lies on the axis".into()),
        (with(20, "12,5;1"), "", "t.csv:20: \"12,5\" has a decimal comma".into()),
        (with(20, "12.5;x"), "", "t.csv:20: \"x\" is not a number".into()),
        (with(20, "12.5"), "", "t.csv:20: 1 columns, the header has 2".into()),
        (lines[..200].join("\n"), "", "t.csv:2: the point lies ".into()),
        (good.replace("x_mm;y_mm", "x_mm;y_inch"), "", "x and y are in two units; one is needed".into()),
        (good.replace("x_mm;y_mm", "x_mm;block"), "", "a column of x needs one of y".into()),
        (good.replace("x_mm;y_mm", "y_mm;block"), "", "radii, or of x and y".into()),
        (good.replace("x_mm;y_mm", "y_mm;lift_mm"), "", "a column of y needs one of x".into()),
        (
            good.replace("x_mm;y_mm", "x_mm;radius_mm"),
            "",
            "column radius_mm beside another of lifts, radii or points".into(),
        ),
        (
            good.clone(),
            ", step_cam_deg: 1",
            "the table is of points, and the job declares a step of their angles".into(),
        ),
        (zero, "", "t.csv:12: the radius is -23.12219 mm; it must be a positive number".into()),
        (
            radii(360, "azimuth_deg,radius_mm\n", 1.0).replace("\n10,", "\n8.5,"),
            "",
            "t.csv:12: angle 8.5000 deg".into(),
        ),
    ] {
        let result =
            Folder::new(&[("t.csv", &text)]).read(&format!("lift: {{table: t.csv{lift}}}")).unwrap_err().join("\n");
        assert!(result.contains(&words), "{words}: {result}");
    }
    let text = radii(360, "azimuth_deg,radius_mm\n", 1.0);
    let folder = Folder::new(&[("a.csv", &text), ("b.csv", &good)]);
    let result = folder.read("lift: {opening_table: a.csv, closing_table: b.csv}").unwrap_err().join("\n");
    assert!(result.contains("the two flanks are not tables of the same"), "{result}");
}
