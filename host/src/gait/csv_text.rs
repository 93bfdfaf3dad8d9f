//! Reads the text of tables that other programs and spreadsheets export.
//!
//! Holds encodings (UTF-8 and UTF-16, with or without a byte order mark, else
//! Latin-1), line ends, separators (comma, semicolon, tab), quotes and decimal
//! commas. Does not depend on what the columns are.

use std::borrow::Cow;

/// A header or a row is quoted in messages up to this length.
const QUOTED_CHARS: usize = 100;
/// Fewer fields than this are no table of ours, so the separator is another one.
const FEWEST_FIELDS: usize = 3;

/// The text of a file; `None` if it is not text, but for example a spreadsheet's own format.
#[must_use]
pub fn decode(bytes: &[u8]) -> Option<Cow<'_, str>> {
    match bytes {
        [0xFF, 0xFE, rest @ ..] => return Some(utf_16(rest, u16::from_le_bytes).into()),
        [0xFE, 0xFF, rest @ ..] => return Some(utf_16(rest, u16::from_be_bytes).into()),
        // Without a mark: a digit or a letter of ASCII has a zero in its other byte.
        [first, 0, second, 0, ..] if *first != 0 && *second != 0 => {
            return Some(utf_16(bytes, u16::from_le_bytes).into());
        }
        [0, first, 0, second, ..] if *first != 0 && *second != 0 => {
            return Some(utf_16(bytes, u16::from_be_bytes).into());
        }
        _ => {}
    }
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.contains(&0) {
        return None;
    }
    Some(match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect::<String>().into(),
    })
}

fn utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units: Vec<u16> = bytes.as_chunks::<2>().0.iter().map(|pair| unit(*pair)).collect();
    String::from_utf16_lossy(&units)
}

/// Lines without their ends: `\n`, `\r\n`, or, in a text without a `\n`, `\r`.
#[must_use]
pub fn lines(text: &str) -> Vec<&str> {
    if text.contains('\n') { text.lines().collect() } else { text.split_terminator('\r').collect() }
}

/// What separates the fields of a table with this first line.
#[must_use]
pub fn separator(first_line: &str) -> char {
    let separates = |c: &char| split(first_line, *c).len() >= FEWEST_FIELDS;
    [';', '\t'].into_iter().find(separates).unwrap_or(',')
}

/// The fields of a line, trimmed and without their quotes.
#[must_use]
pub fn split(line: &str, separator: char) -> Vec<&str> {
    let mut fields = Vec::new();
    let (mut begin, mut is_quoted) = (0, false);
    for (place, c) in line.char_indices() {
        if c == '"' {
            is_quoted = !is_quoted;
        } else if c == separator && !is_quoted {
            fields.push(&line[begin..place]);
            begin = place + c.len_utf8();
        }
    }
    fields.push(&line[begin..]);
    fields.into_iter().map(unquoted).collect()
}

fn unquoted(field: &str) -> &str {
    let field = field.trim();
    field.strip_prefix('"').and_then(|f| f.strip_suffix('"')).map_or(field, str::trim)
}

/// A finite number; with a decimal comma, too, where it separates no fields.
#[must_use]
pub fn number(text: &str, separator: char) -> Option<f64> {
    let parsed = text.parse::<f64>();
    let parsed = match parsed {
        Err(_) if separator != ',' && text.matches(',').count() == 1 && !text.contains('.') => {
            text.replace(',', ".").parse()
        }
        parsed => parsed,
    };
    parsed.ok().filter(|value| value.is_finite())
}

/// Whether a field says that there is no value.
#[must_use]
pub fn is_blank(text: &str) -> bool {
    const BLANK: [&str; 7] = ["", "nan", "null", "none", "na", "n/a", "-"];
    BLANK.contains(&text.trim_start_matches(['-', '+']).to_ascii_lowercase().as_str()) || text == "-"
}

/// The beginning of a text, for messages: one line of a screen.
#[must_use]
pub fn shortened(text: &str) -> String {
    if text.chars().count() <= QUOTED_CHARS {
        return text.to_owned();
    }
    let begin: String = text.chars().take(QUOTED_CHARS).collect();
    format!("{begin}...")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_usual_encoding_is_the_same_text() {
        let text = "time_s,x\n0,1\n";
        let le: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let be: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
        let files = [
            text.as_bytes().to_vec(),
            marked(&[0xEF, 0xBB, 0xBF], text.as_bytes()),
            marked(&[0xFF, 0xFE], &le),
            marked(&[0xFE, 0xFF], &be),
            le.clone(),
            be.clone(),
        ];
        for file in files {
            assert_eq!(decode(&file).unwrap(), text, "{file:?}");
        }
        assert_eq!(decode(b"temp \xB0C").unwrap(), "temp \u{B0}C");
        assert_eq!(decode(b"PK\x03\x04\0\0\x08"), None);
    }

    #[test]
    fn separators_quotes_and_decimal_commas_are_told_apart() {
        assert_eq!(separator("0,1;0,2;0,3"), ';');
        assert_eq!(separator("time_s\tx_m\ty_m"), '\t');
        assert_eq!(separator("time_s,x_m,y_m"), ',');
        assert_eq!(split("\"0,1\", 2 ,", ','), ["0,1", "2", ""]);
        assert_eq!(number("0,25", ';'), Some(0.25));
        assert_eq!(number("0.25", ';'), Some(0.25));
        assert_eq!(number("1.234,5", ';'), None);
        assert_eq!(number("0,25", ','), None);
        assert_eq!(number("inf", ','), None);
        assert_eq!(lines("a\rb\r"), ["a", "b"]);
        assert_eq!(lines("a\r\nb"), ["a", "b"]);
    }
}
