// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Small programs to write.

use crate::cams::SplitMix64;
use camwright::gcode::{
    Block, Call, Direction, NcAxis, NumberFormat, Program, Step, Subprogram, Target, Tool, XValues,
};
use camwright::toolpath::cutter_path::CarriageAxis;

/// Lengths and angles with four decimal places.
pub(crate) fn format(x_values: XValues) -> NumberFormat {
    NumberFormat::new(4, 4, x_values).expect("a format")
}

/// Any target by its letters.
pub(crate) fn target(words: &[(NcAxis, i64)]) -> Target {
    words.iter().fold(Target::default(), |target, (axis, count)| target.with(*axis, *count))
}

fn cam(name: &str, number: u32, offset_axis: Option<CarriageAxis>) -> Subprogram {
    let at = |x, c| target(&[(NcAxis::X, x), (NcAxis::C, c)]);
    Subprogram {
        name: name.into(),
        number,
        title: format!("cam {name}, contour"),
        offset_axis,
        blocks: vec![
            Block::Rapid(at(420_000, 0)),
            Block::Feed { target: target(&[(NcAxis::X, 400_000)]), time_s: 1.0 },
            Block::Feed { target: target(&[(NcAxis::C, 900_000)]), time_s: 2.5 },
            Block::Feed { target: at(435_500, 1_800_000), time_s: 3.0 },
            Block::Comment("nose".into()),
            Block::Feed { target: at(400_000, 2_700_000), time_s: 3.0 },
            Block::Feed { target: target(&[(NcAxis::C, 3_600_000)]), time_s: 0.123_456_789 },
            Block::Rapid(target(&[(NcAxis::X, 420_000)])),
        ],
    }
}

/// Two cams, one of them twice, with all kinds of blocks.
pub(crate) fn two_cams(x_values: XValues) -> Program {
    let block = Step::Block;
    let call = |subprogram, phase, offset| Step::Call(Call { subprogram, phase, offset });
    Program {
        name: "Two cams".into(),
        number: 1000,
        header: vec!["Nockenwelle Größe 2, 0.5 µm".into()],
        format: format(x_values),
        tools: vec![Tool { number: 1, radius_mm: 12.5, text: "end mill 25 mm".into() }],
        main: vec![
            block(Block::ToolChange(1)),
            block(Block::SpindleOn { direction: Direction::Clockwise, rpm: 2400 }),
            block(Block::Coolant(true)),
            block(Block::PathTolerance(10)),
            block(Block::Rapid(target(&[(NcAxis::X, 900_000), (NcAxis::C, 0)]))),
            block(Block::Rapid(target(&[(NcAxis::Z, -205_000)]))),
            call(0, 1_500_000, 3000),
            call(0, 5_100_000, 1),
            block(Block::Rapid(target(&[(NcAxis::X, 900_000)]))),
            block(Block::Rapid(target(&[(NcAxis::Z, -400_000)]))),
            call(1, -123_456, 0),
            block(Block::Dwell { ms: 500 }),
            block(Block::Coolant(false)),
            block(Block::SpindleOff),
        ],
        subprograms: vec![cam("A", 1001, Some(CarriageAxis::X)), cam("cam b", 1002, None)],
    }
}

fn random_target(random: &mut SplitMix64) -> Target {
    let mut target = Target::default();
    while target.named().next().is_none() {
        for axis in NcAxis::ALL {
            if random.next().is_multiple_of(2) {
                // As many digits as not: small numbers are those with zeros behind the point.
                let size = 10_i64.pow(u32::try_from(random.next() % 8).expect("small"));
                target = target.with(axis, i64::try_from(random.next() % 20).expect("small") * size / 3 - 3 * size);
            }
        }
    }
    target
}

fn random_block(random: &mut SplitMix64) -> Block {
    match random.next() % 12 {
        0 => Block::Comment("a comment, with µ".into()),
        1 => Block::ToolChange(random.one_of(&[1, 12])),
        2 => Block::SpindleOn {
            direction: random.one_of(&[Direction::Clockwise, Direction::Counterclockwise]),
            rpm: random.one_of(&[1, 777, 99_999]),
        },
        3 => random.one_of(&[None, Some(true), Some(false)]).map_or(Block::SpindleOff, Block::Coolant),
        4 => Block::PathTolerance(random.one_of(&[1, 500])),
        5 => Block::Dwell { ms: random.one_of(&[1, 1500, 9_999_999]) },
        6 | 7 => Block::Rapid(random_target(random)),
        _ => Block::Feed { target: random_target(random), time_s: 60.0 / 10_f64.powf(random.within(0.0, 3.9)) },
    }
}

/// Any program that every dialect can say.
pub(crate) fn random_program(seed: u64) -> Program {
    let random = &mut SplitMix64(seed);
    let x_values = random.one_of(&[XValues::Radius, XValues::Diameter]);
    let format = NumberFormat::new(random.one_of(&[1, 3, 4, 5, 6]), random.one_of(&[1, 3, 4, 6]), x_values);
    let count = random.next() % 4;
    let mut subprograms = Vec::new();
    for index in 0..u32::try_from(count).expect("small") {
        subprograms.push(Subprogram {
            name: format!("{} {index}", random.one_of(&["cam", "nose Ä", "9", "ac", "contour of a cam"])),
            number: 2000 + index,
            title: "a title".into(),
            offset_axis: random.one_of(&[None, Some(CarriageAxis::X), Some(CarriageAxis::Y), Some(CarriageAxis::Z)]),
            blocks: (0..random.next() % 30).map(|_| random_block(random)).collect(),
        });
    }
    let mut main: Vec<Step> = Vec::new();
    for _ in 0..random.next() % 30 {
        main.push(Step::Block(random_block(random)));
    }
    for (subprogram, sub) in subprograms.iter().enumerate() {
        for _ in 0..=random.next() % 3 {
            let mut by = || i64::try_from(random.next() % 20_000_000).expect("small") - 10_000_000;
            let offset = if sub.offset_axis.is_some() { by() } else { 0 };
            main.push(Step::Call(Call { subprogram, phase: by(), offset }));
            main.push(Step::Block(random_block(random)));
        }
    }
    let tool = |number, radius_mm| Tool { number, radius_mm, text: "mill".into() };
    Program {
        name: "any program".into(),
        number: 1,
        header: Vec::new(),
        format: format.expect("a format"),
        tools: vec![tool(1, 0.5), tool(12, 20.0)],
        main,
        subprograms,
    }
}
