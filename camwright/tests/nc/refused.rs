// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Programs that a dialect cannot express: each refusal with its sentence.

use super::sample::{format, target, two_cams};
use camwright::gcode::{
    Block, Call, Dialect, FormatError, NcAxis, NumberFormat, Program, Step, Target, Tool, WriteError, XValues,
};

/// The sample with something wrong in it.
fn broken(change: impl FnOnce(&mut Program)) -> Program {
    let mut program = two_cams(XValues::Radius);
    change(&mut program);
    program
}

fn refused(dialect: Dialect, program: &Program, sentence: &str) -> WriteError {
    let error = dialect.write(program).expect_err("it is refused");
    assert_eq!(error.to_string(), sentence, "{dialect:?}");
    error
}

fn everywhere(change: impl Fn(&mut Program), sentence: &str) {
    for dialect in Dialect::ALL {
        refused(dialect, &broken(&change), sentence);
    }
}

/// One block in front of all others.
fn with_block(block: &Block) -> impl Fn(&mut Program) {
    move |program| program.main.insert(0, Step::Block(block.clone()))
}

#[test]
fn names_must_be_names_and_differ() {
    everywhere(
        |program| program.subprograms[1].name = " ?! ".into(),
        "the name \" ?! \" has no letter or digit that a program's name may have",
    );
    everywhere(
        |program| program.name = String::new(),
        "the name \"\" has no letter or digit that a program's name may have",
    );
    let same = broken(|program| program.subprograms[1].name = "a".into());
    refused(
        Dialect::LinuxCnc,
        &same,
        "programs \"A\" and \"a\" would both be named a on this control; names must differ there",
    );
    // Cut to 24 characters they are one, where names may be longer they are two.
    let long = broken(|program| {
        program.subprograms[0].name = "camshaft of four long cams, intake".into();
        program.subprograms[1].name = "camshaft of four long cams, exhaust".into();
    });
    assert!(matches!(Dialect::Siemens.write(&long), Err(WriteError::SameName { .. })));
    assert!(Dialect::LinuxCnc.write(&long).is_ok());
}

/// `CYCLE81`, `AC` and `X1` mean something to a SINUMERIK.
#[test]
fn no_name_is_a_word_of_the_control() {
    for (name, fitted) in [
        ("CYCLE_81", "NC_CYCLE_81"),
        ("ac", "NC_AC"),
        ("x_1", "NC_X_1"),
        ("1", "NC_1"),
        ("cam 1", "CAM_1"),
        ("ccs_", "NC_CCS_"),
    ] {
        let program = broken(|program| program.subprograms[0].name = name.into());
        let files = Dialect::Siemens.write(&program).expect("it can be written");
        assert_eq!(files[1].name, format!("{fitted}.SPF"));
        assert!(files[1].text.starts_with(&format!("PROC {fitted}(")));
    }
}

#[test]
fn numbers_of_programs_are_the_users_and_differ() {
    for number in [0, 8_000] {
        let sentence = format!("program \"A\": the number {number} is not within 1 to 7999");
        refused(Dialect::Fanuc, &broken(|program| program.subprograms[0].number = number), &sentence);
    }
    let same = broken(|program| program.subprograms[1].number = 1000);
    refused(
        Dialect::Fanuc,
        &same,
        "programs \"Two cams\" and \"cam b\" both have the number 1000; numbers must differ",
    );
    assert!(Dialect::Siemens.write(&same).is_ok(), "it has no numbers");
}

/// A bracket, a line's end or `%` would end a comment; `(msg,` and its like would be executed.
#[test]
fn no_text_ends_its_comment() {
    let nasty = "a) G0 X0 (b\nM3\r; msg, ä % {c} \"d\" \u{7}é";
    for dialect in Dialect::ALL {
        let mut program = two_cams(XValues::Radius);
        let lines = |program: &Program| {
            let files = dialect.write(program).expect("it can be written");
            files.iter().map(|file| file.text.lines().count()).sum::<usize>()
        };
        program.header = vec!["a".into()];
        let before = lines(&program);
        for text in [nasty, "msg, hello", "MSG,HELLO"] {
            program.header = vec![text.into()];
            program.main[4] = Step::Block(Block::Comment(text.into()));
            program.subprograms[0].title = text.into();
            program.tools[0].text = text.into();
            assert_eq!(lines(&program), before);
            for file in dialect.write(&program).expect("it can be written") {
                assert!(file.text.is_ascii());
                for line in file.text.lines().filter(|line| line.to_ascii_lowercase().contains("msg")) {
                    assert!(!line.contains(['%', '\r', '\u{7}']), "{line}");
                    match dialect {
                        Dialect::Siemens => assert!(line.starts_with(';'), "{line}"),
                        _ => assert!(line.matches(['(', ')']).count() == 2 && line.ends_with(')'), "{line}"),
                    }
                    assert!(dialect != Dialect::LinuxCnc || !line.contains(','), "{line}");
                }
            }
        }
    }
}

#[test]
fn long_texts_are_refused() {
    let text = "x".repeat(121);
    let shown = &text[..40];
    let sentence = |text: &str| format!("a comment has 121 characters, at most 120 are allowed: {text:?}");
    for dialect in [Dialect::LinuxCnc, Dialect::Siemens] {
        refused(dialect, &broken(|program| program.header = vec![text.clone()]), &sentence(shown));
    }
    refused(Dialect::Fanuc, &broken(with_block(&Block::Comment(text.clone()))), &sentence(&shown.to_ascii_uppercase()));
}

#[test]
fn tools_have_numbers_and_radii() {
    let tool = |number, radius_mm| Tool { number, radius_mm, text: String::new() };
    for (number, radius_mm) in [(0, 1.0), (10_000, 1.0), (2, 0.0), (2, f64::NAN), (2, -1.0), (2, f64::INFINITY)] {
        everywhere(
            |program| program.tools.push(tool(number, radius_mm)),
            &format!(
                "tool {number}, radius {radius_mm} mm: the number must be within 1 to 9999 and the radius positive"
            ),
        );
    }
    everywhere(|program| program.tools.push(tool(1, 3.0)), "two tools have the number 1; numbers must differ");
    everywhere(
        with_block(&Block::ToolChange(7)),
        "main program, block 1: tool 7 is not among the tools of the program",
    );
}

#[test]
fn calls_call_what_there_is() {
    let call = |subprogram, phase, offset| {
        move |program: &mut Program| program.main.push(Step::Call(Call { subprogram, phase, offset }))
    };
    everywhere(call(2, 0, 0), "main program, block 15: subprogram 2 is called, the program has 2");
    everywhere(
        call(1, 0, 5),
        "main program, block 15: an offset of 5 increments is passed to \"cam b\", which shifts no linear axis",
    );
    let far = broken(call(0, 0, 99_999_999));
    refused(
        Dialect::Fanuc,
        &far,
        "main program, block 15: X shifted by the call has 9 digits, this control reads at most 8",
    );
    assert!(Dialect::LinuxCnc.write(&far).is_ok());
    for dialect in Dialect::ALL {
        for count in [i64::MIN, i64::MAX] {
            let written = dialect.write(&broken(call(0, count, 0)));
            assert!(matches!(written, Err(WriteError::ShiftedTooFar { .. })), "{written:?}");
        }
    }
}

#[test]
fn coordinates_have_no_more_digits_than_the_control_reads() {
    let sentence = |word: &str, digits: u32, max: u32| {
        format!("main program, block 1: {word} has {digits} digits, this control reads at most {max}")
    };
    let rapid = |axis, count| broken(with_block(&Block::Rapid(target(&[(axis, count)]))));
    refused(Dialect::Fanuc, &rapid(NcAxis::C, 100_000_000), &sentence("C10000.0000", 9, 8));
    refused(Dialect::Fanuc, &rapid(NcAxis::X, -123_456_789), &sentence("X-12345.6789", 9, 8));
    assert!(Dialect::Fanuc.write(&rapid(NcAxis::Y, -99_999_999)).is_ok());
    for dialect in [Dialect::LinuxCnc, Dialect::Siemens] {
        assert!(dialect.write(&rapid(NcAxis::C, 999_999_999_999)).is_ok());
        refused(dialect, &rapid(NcAxis::Z, i64::MIN), &sentence("Z-922337203685477.5808", 19, 12));
    }
    everywhere(with_block(&Block::Rapid(Target::default())), "main program, block 1: a motion names no axis");
}

#[test]
fn feeds_have_times_that_the_control_reads() {
    let feed = |time_s| Block::Feed { target: target(&[(NcAxis::C, 1)]), time_s };
    for time_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        everywhere(
            with_block(&feed(time_s)),
            &format!("main program, block 1: a feed takes {time_s} s; it must be a positive time"),
        );
    }
    refused(
        Dialect::Fanuc,
        &broken(|program| program.subprograms[1].blocks.push(feed(0.006))),
        "subprogram cam b, block 9: F 10000/min (0.006 s) is not within 0.5 to 9999.999/min on this control",
    );
    refused(
        Dialect::Fanuc,
        &broken(with_block(&feed(240.0))),
        "main program, block 1: F 0.25/min (240 s) is not within 0.5 to 9999.999/min on this control",
    );
    refused(
        Dialect::Siemens,
        &broken(with_block(&feed(1e-6))),
        "main program, block 1: F 60000000/min (0.000001 s) is not within 0.0001 to 9999999/min on this control",
    );
    for dialect in Dialect::ALL {
        for time_s in [f64::MIN_POSITIVE / 4.0, f64::MAX] {
            let written = dialect.write(&broken(with_block(&feed(time_s))));
            assert!(matches!(written, Err(WriteError::FeedOutOfRange { .. })), "{written:?}");
        }
    }
}

#[test]
fn speeds_tolerances_and_pauses_have_a_range() {
    let spindle = |rpm| Block::SpindleOn { direction: camwright::gcode::Direction::Counterclockwise, rpm };
    for rpm in [0, 100_000] {
        everywhere(
            with_block(&spindle(rpm)),
            &format!("main program, block 1: a spindle speed of {rpm} rpm is not within 1 to 99999 rpm"),
        );
    }
    for increments in [0, -1, 10_000_000, i64::MIN] {
        everywhere(
            with_block(&Block::PathTolerance(increments)),
            &format!("main program, block 1: a path tolerance of {increments} increments is not within 1 to 9999999"),
        );
    }
    for ms in [0, 10_000_000] {
        everywhere(
            with_block(&Block::Dwell { ms }),
            &format!("main program, block 1: a dwell of {ms} ms is not within 1 to 9999999 ms"),
        );
    }
}

#[test]
fn formats_and_coordinates_can_be_counted() {
    let new = |linear, rotary| NumberFormat::new(linear, rotary, XValues::Radius);
    let sentence = |format: Result<NumberFormat, FormatError>| format.expect_err("it is refused").to_string();
    assert_eq!(sentence(new(0, 4)), "0 decimal places of lengths are not within 1 to 6");
    assert_eq!(sentence(new(4, 7)), "7 decimal places of angles are not within 1 to 6");
    let counted = format(XValues::Diameter).count(NcAxis::X, 6e10).expect_err("it is refused");
    assert_eq!(counted.to_string(), "X of 120000000000 is not a number of at most 15 digits with 4 decimal places");
}
