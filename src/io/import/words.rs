//! Text of any encoding, and names and values in messages, cut so that a message has at most three lines.

use super::malformed;
use crate::base::error::Error;
use serde_json::Value;
use std::borrow::Cow;

/// Text of any encoding that tools write: UTF-8, UTF-16 with or without a mark, else Latin-1.
pub(crate) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |bytes: &[u8], of: fn([u8; 2]) -> u16| {
        String::from_utf16_lossy(&bytes.as_chunks::<2>().0.iter().map(|pair| of(*pair)).collect::<Vec<_>>())
    };
    match bytes {
        [0xFF, 0xFE, rest @ ..] => wide(rest, u16::from_le_bytes).into(),
        [0xFE, 0xFF, rest @ ..] => wide(rest, u16::from_be_bytes).into(),
        [a, 0, b, 0, ..] if *a != 0 && *b != 0 => wide(bytes, u16::from_le_bytes).into(),
        [0, a, 0, b, ..] if *a != 0 && *b != 0 => wide(bytes, u16::from_be_bytes).into(),
        _ => {
            let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
            let text = std::str::from_utf8(bytes).map(Cow::Borrowed);
            text.unwrap_or_else(|_| bytes.iter().map(|byte| char::from(*byte)).collect())
        }
    }
}

/// Some of many names for a message.
pub(crate) fn listed<T: AsRef<str>>(names: impl ExactSizeIterator<Item = T>) -> String {
    some("none", names.map(|name| quoted(name.as_ref())))
}

/// Some of many things for a message, which says `none` if there are none.
pub(crate) fn some(none: &str, things: impl ExactSizeIterator<Item = String>) -> String {
    const SHOWN: usize = 4;
    let more = things.len().saturating_sub(SHOWN);
    let text = things.take(SHOWN).collect::<Vec<_>>().join(", ");
    match more {
        _ if text.is_empty() => none.into(),
        0 => text,
        _ => format!("{text} and {more} more"),
    }
}

/// A name for a message, at most 40 characters of it.
pub(crate) fn cut(name: &str) -> String {
    cut_at(name, 40)
}

/// The same in quotes.
pub(crate) fn quoted(name: &str) -> String {
    format!("'{}'", cut(name))
}

/// A value for an error message, at most one line of it.
pub(crate) fn brief(value: &Value) -> String {
    cut_at(&value.to_string(), 60)
}

/// At most so many characters of a text that may be megabytes long.
pub(crate) fn cut_at(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// The error for a value of a file that is not what it must be.
pub(crate) fn unfit(name: &str, value: &Value, right: &str) -> Error {
    malformed(format!("{name} is {}; it must be {right}", brief(value)))
}
