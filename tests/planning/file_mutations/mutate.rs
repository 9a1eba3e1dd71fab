// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Changes of a file: of its text where it has one, else of its bytes.

use super::random::Random;

/// Numbers that programs forget.
const EXTREMES: [&str; 40] = [
    "0",
    "-0.0",
    "-1",
    "1",
    "2",
    "1e-300",
    "1e-30",
    "1e-12",
    "1e-9",
    "1e-6",
    "1e-4",
    "0.001",
    "0.01",
    "0.1",
    "10",
    "60",
    "90",
    "100",
    "359.999",
    "360",
    "361",
    "720",
    "1000",
    "3600",
    "36000",
    "65536",
    "100000",
    "1e6",
    "1e9",
    "1e15",
    "1e30",
    "1e300",
    "-1e300",
    ".nan",
    ".inf",
    "-.inf",
    "4294967295",
    "9223372036854775807",
    "18446744073709551616",
    "1e999",
];

/// Factors that leave a number plausible.
const FACTORS: [f64; 14] = [-1.0, 0.001, 0.01, 0.1, 0.5, 0.9, 0.999, 1.001, 1.1, 1.5, 2.0, 10.0, 100.0, 1000.0];

/// Values of another type, and those that are hard on a parser.
const STRANGE: [&str; 14] = [
    "[]",
    "{}",
    "null",
    "\"\"",
    "x",
    "[1, 2, 3]",
    "{a: 1}",
    "true",
    "*a",
    "&a 1",
    "!!binary AAAA",
    "'",
    "| ",
    "../../../../etc/passwd",
];

/// One to four changes of a text; `donor` lends sections.
pub fn text(random: &mut Random, text: &str, donor: &str) -> Vec<u8> {
    let mut changed = text.to_owned();
    if random.is_still() {
        return changed.into_bytes();
    }
    for _ in 0..1 + random.below(4) * random.below(2) {
        match random.below(100) {
            0..50 => changed = number(random, &changed),
            50..58 => changed = lines(random, &changed, donor),
            58..66 => changed = swapped(random, &changed),
            66..76 => changed = value(random, &changed),
            76..80 => changed = repeated(random, &changed),
            80..84 => changed = bomb(random, &changed),
            84..90 => changed = cut(random, &changed),
            // Bytes need not be text any more.
            _ => return bytes(random, changed.as_bytes(), donor.as_bytes()),
        }
    }
    changed.into_bytes()
}

/// Flipped bits, cut ends, sections that are missing, doubled or from elsewhere.
pub fn bytes(random: &mut Random, bytes: &[u8], donor: &[u8]) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    if changed.is_empty() || random.is_still() {
        return changed;
    }
    let range = |random: &mut Random, length: usize| {
        let from = random.below(length);
        from..(from + 1 + random.below(200.min(length))).min(length)
    };
    match random.below(8) {
        0..3 => {
            for _ in 0..1 + random.below(8) {
                let at = random.below(changed.len());
                changed[at] ^= 1 << random.below(8);
            }
        }
        3 => changed.truncate(random.below(bytes.len())),
        4 => drop(changed.drain(range(random, bytes.len()))),
        5 => {
            let doubled = changed[range(random, bytes.len())].to_vec();
            let at = random.below(changed.len());
            changed.splice(at..at, doubled);
        }
        6 if !donor.is_empty() => {
            let lent = donor[range(random, donor.len())].to_vec();
            let replaced = range(random, bytes.len());
            changed.splice(replaced, lent);
        }
        _ => {
            // A length or a count, as binary formats have them.
            let number: u64 =
                *random.pick(&[0, 1, 255, 65_535, 1 << 31, u64::from(u32::MAX), 1 << 40, u64::MAX / 2, u64::MAX]);
            let width = *random.pick(&[1_usize, 2, 4, 8]);
            let at = random.below(changed.len());
            let end = (at + width).min(changed.len());
            changed[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
        }
    }
    changed
}

/// Places of the numbers of a text.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let is_part = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e' | b'E');
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let starts =
            bytes[at].is_ascii_digit() || (bytes[at] == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit));
        let inside_a_word = at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || bytes[at - 1] == b'_');
        if !starts || (inside_a_word && bytes[at - 1].is_ascii_digit()) {
            at += 1;
            continue;
        }
        let end = (at..bytes.len()).find(|end| !is_part(bytes[*end])).unwrap_or(bytes.len());
        found.push((at, end));
        at = end;
    }
    found
}

fn number(random: &mut Random, text: &str) -> String {
    let all = numbers(text);
    if all.is_empty() {
        return text.to_owned();
    }
    let (from, to) = *random.pick(&all);
    let new = match (random.below(3), text[from..to].parse::<f64>()) {
        (0, Ok(value)) => format!("{}", value * random.pick(&FACTORS)),
        // Anything between a thousandth and a thousandfold.
        (1, Ok(value)) => format!("{}", value * 10_f64.powf(6.0 * random.share() - 3.0)),
        _ => (*random.pick(&EXTREMES)).to_owned(),
    };
    format!("{}{new}{}", &text[..from], &text[to..])
}

fn lines(random: &mut Random, text: &str, donor: &str) -> String {
    let mut all: Vec<&str> = text.lines().collect();
    if all.is_empty() {
        return text.to_owned();
    }
    let at = random.below(all.len());
    match random.below(4) {
        0 => drop(all.remove(at)),
        1 => all.insert(at, all[at]),
        2 => {
            let other = random.below(all.len());
            all.swap(at, other);
        }
        _ => {
            let lent: Vec<&str> = donor.lines().collect();
            let from = random.below(lent.len());
            let section = lent.into_iter().skip(from).take(1 + random.below(12)).collect::<Vec<_>>();
            all.splice(at..at, section);
        }
    }
    all.join("\n") + "\n"
}

/// Two values, or two keys, in each other's place.
fn swapped(random: &mut Random, text: &str) -> String {
    let words: Vec<(usize, &str)> = text
        .split([' ', '\n', ',', '{', '}', '[', ']'])
        .filter(|word| !word.is_empty())
        .map(|word| (word.as_ptr() as usize - text.as_ptr() as usize, word))
        .collect();
    let (&(one, first), &(other, second)) = (random.pick(&words), random.pick(&words));
    let ((low, low_word), (high, high_word)) =
        if one <= other { ((one, first), (other, second)) } else { ((other, second), (one, first)) };
    if low + low_word.len() > high {
        return text.to_owned();
    }
    let (begin, middle, end) = (&text[..low], &text[low + low_word.len()..high], &text[high + high_word.len()..]);
    format!("{begin}{high_word}{middle}{low_word}{end}")
}

/// Something else behind a colon or a comma.
fn value(random: &mut Random, text: &str) -> String {
    let places: Vec<usize> = text.match_indices([':', ',']).map(|(at, _)| at + 1).collect();
    if places.is_empty() {
        return text.to_owned();
    }
    let at = *random.pick(&places);
    let end = text[at..].find([',', '\n', '}', ']']).map_or(text.len(), |length| at + length);
    let long;
    let new = match random.below(20) {
        0 => {
            long = "x".repeat(70_000);
            &long
        }
        1 => {
            long = "9".repeat(400);
            &long
        }
        _ => *random.pick(&STRANGE),
    };
    format!("{} {new}{}", &text[..at], &text[end..])
}

/// Some lines many times.
fn repeated(random: &mut Random, text: &str) -> String {
    let all: Vec<&str> = text.lines().collect();
    let from = random.below(all.len());
    let count = 1 + random.below(3);
    let times = *random.pick(&[3, 10, 100, 1000, 20_000]);
    let block: String = all.iter().skip(from).take(count).map(|line| format!("{line}\n")).collect();
    let begin: String = all.iter().take(from).map(|line| format!("{line}\n")).collect();
    let end: String = all.iter().skip(from).map(|line| format!("{line}\n")).collect();
    begin + &block.repeat(times) + &end
}

/// Inputs known to break parsers.
fn bomb(random: &mut Random, text: &str) -> String {
    match random.below(4) {
        0 => {
            let mut aliases = String::from("a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n");
            for level in 1..12 {
                let before = format!("*a{}", level - 1);
                aliases += &format!("a{level}: &a{level} [{}]\n", vec![before; 10].join(", "));
            }
            aliases + text
        }
        1 => format!("{text}deep: {}{}\n", "[".repeat(50_000), "]".repeat(50_000)),
        2 => format!("{text}deep: {}\n", "{a: ".repeat(20_000)),
        _ => (0..5_000).map(|level| format!("{}k:\n", " ".repeat(level))).collect::<String>() + text,
    }
}

fn cut(random: &mut Random, text: &str) -> String {
    let mut end = random.below(text.len().max(1));
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    text[..end].to_owned()
}
