//! Small programs to write.

use camwright::cutter_path::CarriageAxis;
use camwright::nc::{Block, Call, Direction, Format, NcAxis, Program, Step, Subprogram, Target, Tool, XValues};

/// Lengths and angles with four decimal places.
pub(crate) fn format(x_values: XValues) -> Format {
    Format::new(4, 4, x_values).expect("a format")
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
