//! What the reader of YAML says, in words: its messages name types of this program, which mean nothing to whoever wrote the file.

/// Types and forms by their names in messages, the longer names first where one begins like another.
const WORDS: [(&str, &str); 24] = [
    ("invalid floating point", "it is not a number"),
    ("invalid boolean", "it is neither true nor false"),
    ("expected mapping start", "expected keys with values here"),
    ("expected sequence start", "expected a list here"),
    ("unknown variant", "unknown word"),
    ("unknown field", "unknown key"),
    ("missing field", "missing key"),
    ("duplicate field", "key given twice:"),
    ("data did not match any variant of untagged enum", "it has none of the allowed forms"),
    ("internally tagged enum", "keys with values"),
    ("adjacently tagged enum", "keys with values"),
    ("invalid type: map", "found keys with values"),
    ("invalid type: sequence", "found a list"),
    ("invalid type: string", "found the text"),
    ("invalid type: integer", "found the number"),
    ("invalid type: floating point", "found the number"),
    ("invalid type: boolean", "found"),
    ("invalid type: unit value", "found nothing"),
    ("invalid value: ", "found "),
    ("invalid length ", "found so many entries: "),
    ("tuple struct", "a list"),
    ("unit struct", "nothing"),
    ("struct", "keys with values"),
    ("enum", "one of its forms"),
];

/// Numbers that the program expects.
const NUMBERS: [&str; 10] = ["f64", "f32", "u8", "u16", "u32", "u64", "usize", "i8", "i32", "i64"];

/// A message without names of types.
pub(super) fn in_words(message: &str) -> String {
    let mut text = message.to_owned();
    for number in NUMBERS {
        let word = match number.as_bytes()[0] {
            b'f' => "a number",
            b'u' => "a whole number from 0 on",
            _ => "a whole number",
        };
        if text == format!("invalid {number}") {
            return format!("it is not {word}");
        }
        text = text.replace(&format!("expected {number}"), &format!("expected {word}"));
    }
    for (name, word) in WORDS {
        let Some(at) =
            text.find(name).filter(|at| !matches!(name, "struct" | "enum") || text[..*at].ends_with("expected "))
        else {
            continue;
        };
        let rest = &text[at + name.len()..];
        // The name of the type that follows says nothing either.
        let is_of_type = matches!(name, "struct" | "enum" | "tuple struct" | "unit struct") || name.ends_with("enum");
        let type_name = rest.trim_start().split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
        let rest = match is_of_type && type_name.starts_with(|c: char| c.is_ascii_uppercase()) {
            true => rest.trim_start()[type_name.len()..].to_owned(),
            false => rest.to_owned(),
        };
        text = format!("{}{word}{rest}", &text[..at]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_told_in_words() {
        for (message, words) in [
            ("invalid type: string \"x\", expected f64", "found the text \"x\", expected a number"),
            ("invalid u32", "it is not a whole number from 0 on"),
            (
                "invalid type: string \"fast\", expected internally tagged enum SpeedFile",
                "found the text \"fast\", expected keys with values",
            ),
            ("data did not match any variant of untagged enum LiftFile", "it has none of the allowed forms"),
            ("invalid type: map, expected struct HomeFile", "found keys with values, expected keys with values"),
            (
                "unknown variant `foo`, expected one of stops, turns_on",
                "unknown word `foo`, expected one of stops, turns_on",
            ),
            ("unknown field `stock_m`, expected one of stock_mm", "unknown key `stock_m`, expected one of stock_mm"),
        ] {
            assert_eq!(in_words(message), words);
        }
    }
}
