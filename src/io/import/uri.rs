//! Resolves a glTF's `uri` to the bytes of a `data:` URI or to the path of another file.

use super::words::cut_at;
use super::{malformed, unsupported};
use crate::base::error::Error;
use base64::Engine;
use base64::alphabet::{STANDARD, URL_SAFE};
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The target of a URI, not yet read.
pub(crate) enum UriTarget {
    /// The bytes of a `data:` URI.
    Data(Vec<u8>),
    /// A relative path, percent-decoded.
    File(String),
}

/// Parses a URI. `what` names the user of the URI in errors.
pub(crate) fn parse(uri: &str, what: &str) -> Result<UriTarget, Error> {
    let shown = cut_at(uri, 80);
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme).filter(|s| is_scheme(s));
    match scheme {
        Some(s) if s.eq_ignore_ascii_case("data") => data(&uri[5..], what).map(UriTarget::Data),
        Some(_) => Err(unsupported(format!(
            "{what} points to '{shown}'; only files beside this one or below and data: URIs are read"
        ))),
        None if uri.is_empty() => Err(malformed(format!("{what} has an empty uri"))),
        // Some exporters do not encode paths. A path that does not decode is used as written.
        None => match percent_decode_str(uri).decode_utf8().unwrap_or_else(|_| uri.into()) {
            path if path.starts_with(['/', '\\']) => Err(unsupported(format!(
                "{what} points to the absolute path '{shown}'; put it beside the file, and name it by a relative path"
            ))),
            path if leaves_folder(&path) => Err(unsupported(format!(
                "{what} points to '{shown}', outside the file's folder; put it beside the file or below"
            ))),
            path => Ok(UriTarget::File(path.into_owned())),
        },
    }
}

/// Whether a relative path leads out of the folder it starts in, so that a file from a stranger cannot read files elsewhere.
/// Links in the folder are followed: whoever made them has access to it.
pub(super) fn leaves_folder(path: &str) -> bool {
    let mut depth = 0;
    path.split(['/', '\\']).any(|part| {
        match part {
            ".." => depth -= 1,
            "" | "." => {}
            _ => depth += 1,
        }
        depth < 0
    })
}

/// Reads at most `limit` bytes of the file that a relative URI names.
pub(crate) fn read_file(
    base_dir: Option<&Path>,
    relative: &str,
    what: &str,
    limit: Option<u64>,
) -> Result<Vec<u8>, Error> {
    let Some(base_dir) = base_dir else {
        return Err(Error::Io {
            path: relative.into(),
            message: format!("{what} is in this file, and no folder to look in was given (base_dir)"),
        });
    };
    let path = base_dir.join(relative.replace('\\', "/"));
    read(&path, limit)
}

/// Reads a regular file. Refuses devices and pipes, because they may never end.
pub(crate) fn read(path: &Path, limit: Option<u64>) -> Result<Vec<u8>, Error> {
    let io = |e: std::io::Error| Error::Io { path: path.display().to_string(), message: e.to_string() };
    let about = std::fs::metadata(path).map_err(io)?;
    if !about.is_file() {
        return Err(Error::Io { path: path.display().to_string(), message: "not a regular file".into() });
    }
    let length = about.len().min(limit.unwrap_or(u64::MAX));
    let mut bytes =
        crate::base::error::reserve(usize::try_from(length).unwrap_or(usize::MAX), &path.display().to_string())?;
    let file = std::fs::File::open(PathBuf::from(path)).map_err(io)?;
    file.take(length).read_to_end(&mut bytes).map_err(io)?;
    Ok(bytes)
}

fn is_scheme(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'))
}

fn data(rest: &str, what: &str) -> Result<Vec<u8>, Error> {
    let (head, body) =
        rest.split_once(',').ok_or_else(|| malformed(format!("{what}: the data: URI has no comma before its data")))?;
    let body: Cow<'_, [u8]> = percent_decode_str(body).into();
    if !head.ends_with(";base64") {
        return Ok(body.into_owned());
    }
    // Accepts both alphabets, with or without padding: data-url reads only the standard one.
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let alphabet = if body.iter().any(|b| b"-_".contains(b)) { &URL_SAFE } else { &STANDARD };
    let decoded = GeneralPurpose::new(alphabet, config).decode(&*body);
    decoded.map_err(|e| malformed(format!("{what}: the data: URI is not base64: {e}")))
}
