//! The calls that a recording holds, and their bytes.

use super::super::ids::Id;
use bytemuck::{Pod, Zeroable};
use std::fmt;

/// What stands in a call: written and read back.
pub(super) trait Field: Sized {
    fn put(&self, out: &mut Vec<u8>);
    /// `None` where the bytes end too early or mean nothing.
    fn take(bytes: &mut &[u8]) -> Option<Self>;
}

macro_rules! plain {
    ($($type:ty),*) => {$(
        impl Field for $type {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(bytemuck::bytes_of(self));
            }
            fn take(bytes: &mut &[u8]) -> Option<Self> {
                let (head, rest) = bytes.split_at_checked(size_of::<$type>())?;
                *bytes = rest;
                Some(bytemuck::pod_read_unaligned(head))
            }
        }
    )*};
}

plain!(u32, u64, f32, [f32; 3], [f32; 16], [u32; 9]);

impl Field for bool {
    fn put(&self, out: &mut Vec<u8>) {
        u32::from(*self).put(out);
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        match u32::take(bytes)? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

fn put_all<T: Pod>(values: &[T], out: &mut Vec<u8>) {
    (values.len() as u64).put(out);
    out.extend_from_slice(bytemuck::cast_slice(values));
}

fn take_all<T: Pod>(bytes: &mut &[u8]) -> Option<Vec<T>> {
    let count = usize::try_from(u64::take(bytes)?).ok()?;
    let (head, rest) = bytes.split_at_checked(count.checked_mul(size_of::<T>())?)?;
    *bytes = rest;
    Some(bytemuck::pod_collect_to_vec(head))
}

/// What stands for an id, of the context that was recorded.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
pub(in super::super) struct Number(pub(super) u64);

impl Number {
    pub(in super::super) fn of<I: Id>(id: I) -> Self {
        let (index, generation, context) = id.parts();
        Self(u64::from(index) | u64::from(generation) << 32 | u64::from(context) << 48)
    }
}

/// Its index, and which use of that it is where it is not the first.
impl fmt::Debug for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 >> 32 & 0xffff {
            1 => write!(f, "{}", self.0 as u32),
            generation => write!(f, "{}.{generation}", self.0 as u32),
        }
    }
}

impl Field for Number {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        u64::take(bytes).map(Self)
    }
}

impl Field for Vec<Number> {
    fn put(&self, out: &mut Vec<u8>) {
        put_all(self, out);
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        take_all(bytes)
    }
}

/// Bytes of a file or of saved damage.
#[derive(Clone, PartialEq, Eq)]
pub(in super::super) struct Bytes(pub(in super::super) Vec<u8>);

impl Field for Bytes {
    fn put(&self, out: &mut Vec<u8>) {
        put_all(&self.0, out);
    }
    fn take(bytes: &mut &[u8]) -> Option<Self> {
        take_all(bytes).map(Self)
    }
}

impl fmt::Debug for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", self.0.len())
    }
}

macro_rules! calls {
    ($($(#[$doc:meta])* $code:literal $function:literal $name:ident { $($field:ident: $type:ty),* },)*) => {
        /// A call with what was read from its arguments. Ids are numbers of the recorded context.
        #[derive(Clone, PartialEq, Debug)]
        pub(in super::super) enum Call {
            $($(#[$doc])* $name { $($field: $type),* },)*
        }

        impl Call {
            /// Its bytes: a number for which call it is, then its fields.
            pub(super) fn put(&self, out: &mut Vec<u8>) {
                match self {
                    $(Call::$name { $($field),* } => {
                        u32::put(&$code, out);
                        $($field.put(out);)*
                    })*
                }
            }

            /// The call that these bytes, all of them, are.
            pub(super) fn take(mut bytes: &[u8]) -> Option<Self> {
                let bytes = &mut bytes;
                let call = match u32::take(bytes)? {
                    $($code => Call::$name { $($field: Field::take(bytes)?),* },)*
                    _ => return None,
                };
                bytes.is_empty().then_some(call)
            }

            /// The C function.
            pub(super) fn function(&self) -> &'static str {
                match self {
                    $(Call::$name { .. } => $function,)*
                }
            }
        }
    };
}

calls! {
    /// A set was made, from whatever, or got another level of detail: this is what `crumple_example_set_save_baked` gives of it now.
    1 "crumple_example_set_load_baked_memory" Set { set: Number, bytes: Bytes },
    2 "crumple_example_set_destroy" DestroySet { set: Number },
    3 "crumple_instance_create" CreateInstance {
        set: Number, rule: u32, selection: u32, examples_per_hit: u32, mark_capacity: u32, depth_limit: f32, yield_impulse: f32,
        yield_displacement: f32, max_contact_distance: f32, blend_constant: f32, tolerance: f32, local_to_world: [f32; 16]
    },
    4 "crumple_instance_destroy" DestroyInstance { instance: Number },
    5 "crumple_instance_set_transform" SetTransform { instance: Number, local_to_world: [f32; 16] },
    6 "crumple_instance_set_depth_limit" SetDepthLimit { instance: Number, depth_limit: f32 },
    7 "crumple_instance_set_tolerance" SetTolerance { instance: Number, tolerance: f32 },
    8 "crumple_instance_submit_impulse" Impulse {
        instance: Number, space: u32, point: [f32; 3], impulse: [f32; 3], duration: f32, mass: f32, contact_id: u64, preview: bool
    },
    9 "crumple_instance_submit_displacement" Displacement {
        instance: Number, space: u32, point: [f32; 3], displacement: [f32; 3], contact_id: u64, preview: bool
    },
    10 "crumple_instance_end_contact" EndContact { instance: Number, contact_id: u64 },
    11 "crumple_instance_get_marks" GetMarks { instance: Number },
    12 "crumple_instance_set_marks" SetMarks { instance: Number, marks: Bytes },
    13 "crumple_instance_save_damage" SaveDamage { instance: Number },
    14 "crumple_instance_load_damage" LoadDamage { instance: Number, bytes: Bytes },
    15 "crumple_instance_repair_damage" RepairDamage { instance: Number, keep: f32 },
    16 "crumple_instance_reset_damage" ResetDamage { instance: Number },
    17 "crumple_instance_copy_damage" CopyDamage { instance: Number, source: Number },
    /// Host memory, or a Vulkan buffer; a replay has memory of its own for both.
    18 "crumple_buffer_register_host" RegisterBuffer { instance: Number, lod: u32, vertices: u32, normals: bool, tangents: bool },
    19 "crumple_buffer_unregister" UnregisterBuffer { buffer: Number },
    20 "crumple_buffer_invalidate" InvalidateBuffer { buffer: Number },
    21 "crumple_buffer_set_memory" SetBufferMemory { buffer: Number, lod: u32, vertices: u32, normals: bool, tangents: bool },
    22 "crumple_context_deform" Deform { buffers: Vec<Number> },
    /// Or `crumple_vulkan_submit`. Nobody read what the device wrote.
    23 "crumple_vulkan_record" Record { buffers: Vec<Number> },
    24 "crumple_instance_get_attached_frame" AttachedFrame { instance: Number, attachment: [u32; 9] },
    25 "crumple_instance_get_info" InstanceInfo { instance: Number },
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bytes(call: &Call) -> Vec<u8> {
        let mut out = Vec::new();
        call.put(&mut out);
        out
    }

    proptest! {
        #[test]
        fn a_call_is_read_back_as_it_was(
            instance: u64, point: [f32; 3], contact_id: u64, preview: bool, marks: Vec<u8>, buffers: Vec<u64>, matrix: [f32; 16]
        ) {
            let calls = [
                Call::Displacement { instance: Number(instance), space: 1, point, displacement: point, contact_id, preview },
                Call::SetMarks { instance: Number(instance), marks: Bytes(marks) },
                Call::Deform { buffers: buffers.into_iter().map(Number).collect() },
                Call::SetTransform { instance: Number(instance), local_to_world: matrix },
            ];
            for call in &calls {
                // NaN compares by its bits.
                let out = bytes(call);
                let back = Call::take(&out).map(|back| bytes(&back));
                prop_assert_eq!(back.as_deref(), Some(&out[..]));
                for cut in 0..out.len() {
                    prop_assert!(Call::take(&out[..cut]).is_none());
                }
            }
        }

        #[test]
        fn any_bytes_are_a_call_or_none(junk: Vec<u8>, code in 0u32..30) {
            let mut all = code.to_le_bytes().to_vec();
            all.extend(junk);
            if let Some(call) = Call::take(&all) {
                prop_assert_eq!(bytes(&call), all);
            }
        }
    }
}
