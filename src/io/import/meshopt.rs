//! BufferViews that meshoptimizer packed: EXT_meshopt_compression and KHR_meshopt_compression.

use super::{malformed, whole};
use crate::base::error::Error;
use meshoptimizer_rs::codec::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
    decode_index_sequence, decode_vertex_buffer,
};
use meshoptimizer_rs::{Limits, Workspace};
use serde_json::Value;

/// The extensions, which have the same properties.
pub(crate) const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// What a packed bufferView says of itself.
pub(super) struct Packed<'v> {
    pub buffer: usize,
    pub offset: u64,
    pub length: u64,
    /// Elements, and bytes of each when unpacked.
    pub count: usize,
    pub stride: usize,
    mode: &'v str,
    filter: &'v str,
}

impl<'v> Packed<'v> {
    /// `None` if a bufferView is not packed. `user` names it.
    pub fn of(view: &'v Value, user: &str) -> Result<Option<Self>, Error> {
        let extensions = view.get("extensions");
        let Some(packed) = extensions.and_then(|all| EXTENSIONS.iter().find_map(|name| all.get(name))) else {
            return Ok(None);
        };
        let number = |key: &str| {
            whole(&packed[key]).ok_or_else(|| {
                malformed(format!("{user}: {key} of its compression is {}; it must be a whole number", packed[key]))
            })
        };
        let size = |key: &str| number(key).map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        Ok(Some(Packed {
            buffer: size("buffer")?,
            offset: if packed["byteOffset"].is_null() { 0 } else { number("byteOffset")? },
            length: number("byteLength")?,
            count: size("count")?,
            stride: size("byteStride")?,
            mode: packed["mode"].as_str().unwrap_or_default(),
            filter: packed["filter"].as_str().unwrap_or("NONE"),
        }))
    }

    /// Unpacks the bytes. `user` names the bufferView.
    pub fn decode(&self, packed: &[u8], user: &str) -> Result<Vec<u8>, Error> {
        let (count, stride) = (self.count, self.stride);
        let mut workspace = Workspace::new(Limits { max_bytes: usize::MAX, ..Limits::default() });
        let unpacked = match self.mode {
            "ATTRIBUTES" => decode_vertex_buffer(count, stride, packed, &mut workspace),
            "TRIANGLES" => decode_index_buffer(count, stride, packed, &mut workspace),
            "INDICES" => decode_index_sequence(count, stride, packed, &mut workspace),
            other => return Err(malformed(format!("{user}: '{other}' is no mode of meshoptimizer's compression"))),
        };
        let broken = |e| malformed(format!("{user} cannot be unpacked by meshoptimizer: {e}"));
        let mut bytes = unpacked.map_err(broken)?;
        match self.filter {
            "NONE" => Ok(()),
            "OCTAHEDRAL" => decode_filter_oct(&mut bytes, count, stride, &mut workspace),
            "QUATERNION" => decode_filter_quat(&mut bytes, count, stride, &mut workspace),
            "EXPONENTIAL" => decode_filter_exp(&mut bytes, count, stride, &mut workspace),
            "COLOR" => decode_filter_color(&mut bytes, count, stride, &mut workspace),
            other => return Err(malformed(format!("{user}: '{other}' is no filter of meshoptimizer's compression"))),
        }
        .map_err(broken)?;
        Ok(bytes)
    }
}
