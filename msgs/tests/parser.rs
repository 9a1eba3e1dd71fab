// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The parser reads interface files as rosidl does, and refuses what rosidl would refuse or misread.

#[path = "../generator/mod.rs"]
#[expect(dead_code, reason = "writing Rust is the build script's business")]
mod generator;

use std::path::Path;

use generator::load::{Library, Origin};
use generator::model::{Base, Definition, FieldType, Kind, Multiplicity, Primitive, TypeName, Value};
use generator::{describe, parse, rust, schema};

fn read(text: &str) -> Definition {
    parse::message("demo_msgs", text).expect("the text is a message")
}

/// The line and the complaint about a text that is not a message.
fn refusal(text: &str) -> (usize, String) {
    let fault = parse::message("demo_msgs", text).expect_err("the text is not a message");
    (fault.line, fault.what)
}

fn name(kind: Kind, name: &str) -> TypeName {
    TypeName::new("demo_msgs", kind, name)
}

/// A library with the interfaces that services and actions refer to, and the given ones.
fn library(interfaces: &[(Kind, &str, &str)]) -> Library {
    let mut library = Library::default();
    let standard = Path::new(env!("CARGO_MANIFEST_DIR")).join("standard");
    for package in ["builtin_interfaces", "service_msgs", "unique_identifier_msgs"] {
        library.add_package(package, &standard.join(package), Origin::Standard).expect("the package is readable");
    }
    for (kind, interface, text) in interfaces {
        library
            .add_interface(&name(*kind, interface), Path::new("demo"), text, Origin::Own)
            .expect("the text is an interface");
    }
    library.check_references().expect("all types are known");
    library
}

#[test]
fn every_primitive_type_is_known_by_its_word() {
    let words = "bool byte char float32 float64 int8 uint8 int16 uint16 int32 uint32 int64 uint64";
    for word in words.split(' ') {
        let definition = read(&format!("{word} x\n"));
        let Base::Primitive(primitive) = &definition.fields[0].ty.base else { panic!("{word} is not primitive") };
        assert_eq!(primitive.word(), word);
    }
}

#[test]
fn shapes_and_bounds_are_read() {
    let shapes = |text: &str| parse::field_type("demo_msgs", text).expect("the type is valid");
    let text = |bound, shape| FieldType { base: Base::Text(bound), shape };
    assert_eq!(shapes("string"), text(None, Multiplicity::One));
    assert_eq!(shapes("string<=32"), text(Some(32), Multiplicity::One));
    assert_eq!(shapes("string<=32[]"), text(Some(32), Multiplicity::Sequence));
    assert_eq!(shapes("string<=32[<=4]"), text(Some(32), Multiplicity::BoundedSequence(4)));
    assert_eq!(shapes("string[4]"), text(None, Multiplicity::Array(4)));
    let point = Base::Nested(TypeName::new("geometry_msgs", Kind::Msg, "Point"));
    assert_eq!(shapes("geometry_msgs/Point[<=3]"), FieldType { base: point, shape: Multiplicity::BoundedSequence(3) });
    assert_eq!(shapes("Latch"), FieldType::one(Base::Nested(name(Kind::Msg, "Latch"))));
    for text in ["string<=32[<=4]", "geometry_msgs/Point[3]", "float64[]", "bool"] {
        assert_eq!(shapes(text).word(), text);
    }
}

#[test]
fn wrong_types_are_refused() {
    for text in [
        "float64[0]",
        "float64[-1]",
        "float64[<=]",
        "float64[<=0]",
        "float64[x]",
        "float64]",
        "string<=0",
        "string<=",
        "string<=-3",
        "wstring",
        "wstring<=3",
        "time",
        "duration",
        "lower",
        "a/b/C",
        "Pkg/Name",
        "demo/name",
        "A_b",
        "/Name",
        "float64[",
        "",
    ] {
        assert!(parse::field_type("demo_msgs", text).is_err(), "{text} was taken");
    }
}

#[test]
fn comments_go_to_what_they_speak_of() {
    let definition = read(
        "# A message.\n#\n## Of two paragraphs.\n\n# before x\nfloat64 x # beside x\n    # indented below x\n\nuint8 A = 1# of A\n# before y\nfloat64 y",
    );
    assert_eq!(definition.comment, ["A message.", "", "Of two paragraphs."]);
    assert_eq!(definition.fields[0].comment, ["before x", "beside x", "indented below x"]);
    assert_eq!(definition.constants[0].comment, ["of A"]);
    assert_eq!(definition.fields[1].comment, ["before y"]);
}

#[test]
fn a_comment_below_an_empty_first_line_belongs_to_the_first_field() {
    let definition = read("\n# about x\nfloat64 x\n");
    assert!(definition.comment.is_empty());
    assert_eq!(definition.fields[0].comment, ["about x"]);
}

/// The last line counts without its newline; tabs, trailing blanks and Windows line ends do not matter.
#[test]
fn layout_does_not_change_the_meaning() {
    let plain = read("float64 x\nuint8 A = 1\nfloat64 y 2.5\n");
    for text in [
        "float64 x\nuint8 A = 1\nfloat64 y 2.5",
        "float64\tx\nuint8\tA\t=\t1\nfloat64\ty\t2.5\t\n",
        "float64 x  \nuint8 A=1\nfloat64   y   2.5  ",
        "float64 x\r\nuint8 A =1\r\nfloat64 y 2.5\r\n",
    ] {
        let other = read(text);
        assert_eq!((&other.fields, &other.constants), (&plain.fields, &plain.constants), "{text:?}");
        assert_eq!(other.text, text);
    }
}

#[test]
fn constants_stand_anywhere_and_keep_their_values() {
    let definition = read(
        "int32 code\nint32 LOW=-5\nuint64 HIGH = 18446744073709551615\nuint8 MASK = 0x1F\nfloat64 PI = 3.25 # not pi\n\
         bool ON = True\nstring GREETING = \"two  words \"\nstring BARE = two  words\nstring QUOTE='it\\'s'\n",
    );
    assert_eq!(definition.fields.len(), 1);
    let values: Vec<_> = definition.constants.iter().map(|c| (c.name.as_str(), &c.value)).collect();
    assert_eq!(
        values,
        [
            ("LOW", &Value::Integer(-5)),
            ("HIGH", &Value::Integer(u64::MAX.into())),
            ("MASK", &Value::Integer(31)),
            ("PI", &Value::Float(3.25)),
            ("ON", &Value::Bool(true)),
            ("GREETING", &Value::Text("two  words ".to_owned())),
            ("BARE", &Value::Text("two  words".to_owned())),
            ("QUOTE", &Value::Text("it's".to_owned())),
        ]
    );
}

/// rosidl cuts a line at the first `#`, quotes or not, and would take the remaining half as the text.
#[test]
fn a_hash_sign_within_quotes_is_refused() {
    let (line, what) = refusal("uint8 x\nstring S = \"a # b\"\n");
    assert_eq!(line, 2);
    assert!(what.contains("no closing quote"), "{what}");
    assert_eq!(read("string S = a # b\n").constants[0].value, Value::Text("a".to_owned()));
}

#[test]
fn defaults_are_read_in_every_shape() {
    let definition = read(
        "bool a true\nint8 b -128\nfloat32 c 1e-3\nstring d \"x, y\"\nstring<=5 e hello\nint32[] f [1, -2,3]\n\
         float64[2] g [0.5,1]\nstring[<=3] h [\"a, b\", 'c', d]\nbool[] i []\nbyte j 0xff\n",
    );
    let integers = |values: &[i128]| Value::List(values.iter().map(|v| Value::Integer(*v)).collect());
    let texts = |values: &[&str]| Value::List(values.iter().map(|v| Value::Text((*v).to_owned())).collect());
    let defaults: Vec<_> = definition.fields.into_iter().map(|field| field.default.expect("there is one")).collect();
    assert_eq!(
        defaults,
        [
            Value::Bool(true),
            Value::Integer(-128),
            Value::Float(1e-3),
            Value::Text("x, y".to_owned()),
            Value::Text("hello".to_owned()),
            integers(&[1, -2, 3]),
            Value::List(vec![Value::Float(0.5), Value::Float(1.0)]),
            texts(&["a, b", "c", "d"]),
            Value::List(vec![]),
            Value::Integer(255),
        ]
    );
}

#[test]
fn wrong_values_are_refused() {
    for text in [
        "uint8 x 256",
        "uint8 x -1",
        "int8 x 128",
        "int64 x 9223372036854775808",
        "bool x yes",
        "float64 x 1,5",
        "int32 x 1.5",
        "int32 x 0x",
        "int32 x 0x-1",
        "string<=3 x four",
        "float64[2] x [1]",
        "float64[<=2] x [1,2,3]",
        "float64[] x 1, 2",
        "int32[] x [1,,2]",
        "string[] x [\"a]",
        "demo_msgs/Other x 3",
        "demo_msgs/Other[] x [3]",
        "string x \"a\"b\"",
        "float64 X_RAY = high",
        "uint8 A = 256",
        "string<=3 A = abc",
        "int32[] A = [1]",
        "demo_msgs/Other A = 1",
    ] {
        assert_eq!(refusal(&format!("bool first\n{text}\n")).0, 2, "{text}");
    }
}

#[test]
fn wrong_names_are_refused() {
    for text in [
        "float64 X",
        "float64 _x",
        "float64 x_",
        "float64 x__y",
        "float64 1x",
        "float64 x-y",
        "float64",
        "float64 ",
        "uint8 a = 1",
        "uint8 A_ = 1",
        "uint8 A__B = 1",
        "uint8 = 1",
        " float64 x",
    ] {
        assert_eq!(refusal(&format!("{text}\n")).0, 1, "{text}");
    }
    assert_eq!(refusal("float64 x\nuint8 x\n"), (2, "the field x is defined twice".to_owned()));
    assert_eq!(refusal("uint8 A = 1\nuint8 A = 2\n"), (2, "the constant A is defined twice".to_owned()));
}

#[test]
fn services_and_actions_split_at_their_dashes_and_count_lines() {
    assert_eq!(parse::split("a\n---\nb\nc\n", 2), Ok(vec![(1, "a\n".to_owned()), (3, "b\nc\n".to_owned())]));
    assert_eq!(parse::split("---\n---\n", 3).map(|parts| parts.len()), Ok(3));
    assert!(parse::split("a\n", 2).is_err());
    assert!(parse::split("---\n---\n", 2).is_err());
    let mut library = Library::default();
    let refused =
        library.add_interface(&name(Kind::Srv, "Ask"), Path::new("Ask.srv"), "bool a\n---\n\nbool B\n", Origin::Own);
    let error = refused.expect_err("B is no field name").to_string();
    assert!(error.starts_with("Ask.srv:4: B is no name for a field"), "{error}");
}

/// Readers of bags disagree on the hash of `char`; arrays above 32 elements have no serde implementation.
#[test]
fn own_interfaces_may_not_use_what_others_misread() {
    let add =
        |text: &str, origin| Library::default().add_interface(&name(Kind::Msg, "M"), Path::new("M.msg"), text, origin);
    assert!(add("char[4] x\n", Origin::Own).is_err());
    assert!(add("char[4] x\n", Origin::Standard).is_ok());
    assert!(add("float64[33] x\n", Origin::Standard).is_err());
    assert!(add("float64[32] x\n", Origin::Own).is_ok());
}

#[test]
fn unknown_and_circular_types_are_refused() {
    let mut library = Library::default();
    for (message, text) in [("A", "B[] b\n"), ("B", "C c\n")] {
        library.add_interface(&name(Kind::Msg, message), Path::new("x.msg"), text, Origin::Own).expect("valid text");
    }
    let unknown = library.check_references().expect_err("C is not there").to_string();
    assert_eq!(unknown, "x.msg: demo_msgs/msg/C is not known");
    library.add_interface(&name(Kind::Msg, "C"), Path::new("x.msg"), "A[] a\n", Origin::Own).expect("valid text");
    let circular = library.check_references().expect_err("A holds A").to_string();
    assert_eq!(circular, "x.msg: demo_msgs/msg/A contains itself");
}

/// Type ids, sizes and defaults as `type_description_interfaces` numbers and prints them.
#[test]
fn descriptions_number_types_as_ros_does() {
    let library = library(&[(
        Kind::Msg,
        "Probe",
        "int8 a\nbyte b 7\nstring<=9 c\nfloat64[3] d [1, 2.5, 3]\nbool[<=4] e [true]\nbuiltin_interfaces/Time[] f\n\
         string[] g [\"it's\", \"plain\"]\nstring h \"text\"\nfloat32 i 2\n",
    )]);
    let fields = describe::fields(&library.types[&name(Kind::Msg, "Probe")]);
    let seen: Vec<_> = fields
        .iter()
        .map(|f| (f.type_id, f.capacity, f.string_capacity, f.nested_type_name.as_str(), f.default_value.as_str()))
        .collect();
    assert_eq!(
        seen,
        [
            (2, 0, 0, "", ""),
            (16, 0, 0, "", "7"),
            (21, 0, 9, "", ""),
            (11 + 48, 3, 0, "", "(1.0, 2.5, 3.0)"),
            (15 + 96, 4, 0, "", "(True,)"),
            (1 + 144, 0, 0, "builtin_interfaces/msg/Time", ""),
            (17 + 144, 0, 0, "", "(\"it's\", 'plain')"),
            (17, 0, 0, "", "text"),
            (10, 0, 0, "", "2.0"),
        ]
    );
}

/// Computed by two other implementations (rosbags, and a transcription of rosidl's own).
#[test]
fn a_message_with_everything_has_the_hash_others_compute() {
    let text = "int32 MODE_A=1\nstring<=32 id\nfloat64[3] axis\nfloat64[<=16] lift\nuint8 mode 1\n\
                builtin_interfaces/Duration d\n";
    let mut library = library(&[]);
    let probe = TypeName::new("camwright_msgs", Kind::Msg, "Probe");
    library.add_interface(&probe, Path::new("Probe.msg"), text, Origin::Own).expect("the text is a message");
    let expected = "RIHS01_d02ad6861c948f95b8df8ad9c43cac5b118b6b85dacf5cd9a6a74e739018e51f";
    assert_eq!(describe::hash(&library, &probe), expected);
}

/// From the wheel of `test_msgs` 2.0.3: an action, and every message and service that follows from it.
#[test]
fn an_action_and_all_its_parts_have_the_hashes_rosidl_gives_them() {
    let mut library = library(&[]);
    let fibonacci = TypeName::new("test_msgs", Kind::Action, "Fibonacci");
    let text = "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n";
    library.add_interface(&fibonacci, Path::new("Fibonacci.action"), text, Origin::Standard).expect("an action");
    for (suffix, expected) in [
        ("", "be9273e3557225044b4a040811112491f7079326e3a573f83258b0b4c30bd069"),
        ("_Feedback", "7d1110f2efa019ad5ad8ad2244db98d862f39dc9fae8c976814b0065fa2f32d5"),
        ("_FeedbackMessage", "37487bae8cea358366b97003c1ef1ca7ce7c08df36f9e8cca496624226aee64e"),
        ("_GetResult", "5d30fdeb21d20e117aa5f36c7b4f0b6874f1a8cf7a9c038d58f1156c5737b209"),
        ("_GetResult_Event", "fe0aa5843ef10550a9b322aeeccd5b11e78bca05b3571cf6999c51bff30c1e23"),
        ("_GetResult_Request", "c65e93c4c4328d7f1abd6ace83dba8e5fa0f32de76b4d2c96b5c655d94803b92"),
        ("_GetResult_Response", "ef88159d47a3d21d9bf4bec690cf668939d9542db28a9cfd77dbcd97eaf1add2"),
        ("_Goal", "e58ef5a8f4f039ab522a740823547c460b1d5aed8031c8b7825d33d345d90df8"),
        ("_Result", "0774b095467813c6904d475498b5486b7ebd4cda6a4569f97e8de8c862689049"),
        ("_SendGoal", "d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9"),
        ("_SendGoal_Event", "a20e708c6aae7a99d1eb0e930a0916f596bb5bae93a342a61752e13135be2c44"),
        ("_SendGoal_Request", "dfe75c73dc2c090cbc8fd8c45039bfa279d16aa6aadd348f812c6adad26e669e"),
        ("_SendGoal_Response", "1e7e84f7edf1fb020d9e51c7842bceef4cbdbd847f354125f3227cf4f314a683"),
    ] {
        let part = fibonacci.derived(suffix);
        assert_eq!(describe::hash(&library, &part), format!("RIHS01_{expected}"), "{part}");
    }
}

/// Dependencies follow depth first, in the order of their names, each once; the texts are verbatim.
#[test]
fn a_schema_holds_every_definition_once_in_order() {
    let library = library(&[
        (Kind::Msg, "Root", "# The root.\nZ z\nA a\nA[] more"),
        (Kind::Msg, "A", "M m # comment\n"),
        (Kind::Msg, "M", "bool x\n"),
        (Kind::Msg, "Z", "M m\nbuiltin_interfaces/Time t\n"),
    ]);
    let rule = "=".repeat(80);
    let expected = format!(
        "# The root.\nZ z\nA a\nA[] more\n{rule}\nMSG: demo_msgs/A\nM m # comment\n\n{rule}\nMSG: demo_msgs/M\nbool x\n\n\
         {rule}\nMSG: demo_msgs/Z\nM m\nbuiltin_interfaces/Time t\n\n{rule}\nMSG: builtin_interfaces/Time\nint32 sec\n\
         uint32 nanosec\n"
    );
    assert_eq!(schema::text(&library, &name(Kind::Msg, "Root")), expected);
}

/// Keywords, Markdown in comments and text in defaults come out as valid Rust.
#[test]
fn odd_words_become_valid_rust() {
    let library = library(&[(
        Kind::Msg,
        "Odd",
        "# About [this] and `that_one`.\nint32 type\nbool match # a_b*c\nstring s \"q\\\"q\"\n",
    )]);
    let code = rust::emit(&library).expect("the library can be written");
    for expected in [
        "pub type_: i32,",
        "#[serde(rename = \"type\")]",
        "pub match_: bool,",
        "a\\\\_b\\\\*c",
        "About \\\\[this\\\\] and `that_one`.",
        "s: ::std::string::String::from(\"q\\\"q\"),",
    ] {
        assert!(code.contains(expected), "{expected} is missing");
    }
}

#[test]
fn two_types_of_one_rust_name_are_refused() {
    let mut library = library(&[(Kind::Srv, "Ask", "---\n")]);
    library
        .add_interface(&name(Kind::Srv, "AskRequest"), Path::new("AskRequest.srv"), "---\n", Origin::Own)
        .expect("the text is a service");
    let error = rust::emit(&library).expect_err("AskRequest is there twice").to_string();
    assert!(error.contains("would both be AskRequest in Rust"), "{error}");
}

#[test]
fn a_primitive_is_never_taken_for_a_message() {
    assert_eq!(read("float64 x\n").fields[0].ty, FieldType::one(Base::Primitive(Primitive::Float64)));
    assert!(parse::field_type("demo_msgs", "float64s").is_err());
    assert!(matches!(
        parse::field_type("demo_msgs", "chararray_msgs/Foo"),
        Ok(FieldType { base: Base::Nested(_), .. })
    ));
}
