//! The types of the header as this library lays them out, against what C makes of the header: `docs/abi`.

use super::allocator::CrumpleAllocatorDef;
use super::attach::{CrumpleAttachment, CrumpleFrame};
use super::buffer::CrumpleHostBufferDef;
use super::context::CrumpleContextDef;
use super::damage::{CrumpleMark, CrumplePair};
use super::deform::CrumpleDeformReport;
use super::hit::{CrumpleChosen, CrumpleDisplacementDef, CrumpleHitResult, CrumpleImpulseDef};
use super::instance::{CrumpleInstanceDef, CrumpleInstanceInfo};
use super::load::{CrumpleGltfDef, CrumpleObjDef};
use super::set::{CrumpleExampleDef, CrumpleExampleSetDef, CrumpleExampleSetOptions, CrumpleLodDef};
use super::set_info::{CrumpleExampleInfo, CrumpleExampleSetInfo, CrumpleMeshCopyDef, CrumplePrimitive};
use super::tasks::CrumpleTaskSystem;
use super::types::{
    CrumpleAabb, CrumpleBuffer, CrumpleExampleSet, CrumpleInput, CrumpleInstance, CrumpleQuat, CrumpleRange,
    CrumpleStream, CrumpleVec3,
};
use super::vulkan::{
    CrumpleRecordReport, CrumpleVulkanAttachDef, CrumpleVulkanBufferDef, CrumpleVulkanImportDef, CrumpleVulkanOpenDef,
    CrumpleVulkanStream,
};
use std::collections::BTreeMap;
use std::mem::offset_of;

const COMMITTED: &str = include_str!("../../docs/abi/crumple-0.1.abi");

/// Size and alignment of each struct, and the offset of each field.
macro_rules! layout {
    ($($name:ident { $($field:ident),* })*) => {{
        let mut layout = BTreeMap::new();
        $(
            let size = format!("size {} align {}", size_of::<$name>(), align_of::<$name>());
            layout.insert(stringify!($name).to_owned(), size);
            $(
                let offset = format!("offset {}", offset_of!($name, $field));
                layout.insert(concat!(stringify!($name), " field ", stringify!($field)).to_owned(), offset);
            )*
        )*
        layout
    }};
}

fn here() -> BTreeMap<String, String> {
    layout! {
        CrumpleAllocatorDef { struct_size, alloc, free, user }
        CrumpleTaskSystem { parallel_for, user, workers }
        CrumpleContextDef { struct_size, threads, log, log_user, tasks }
        CrumpleInput { data, size, stride }
        CrumpleVec3 { x, y, z }
        CrumpleExampleDef { struct_size, delta_count, name, target_positions, target_normals, delta_indices, position_deltas, normal_deltas, contact_kind, contact_vertex, contact_point, contact_normal, has_contact_normal, placement }
        CrumpleExampleSetOptions { depth_limit, drop_below, vertex_mass, stamp_resolution, tolerance, normal_tolerance, vertex_masses, combine, seams, strict, mirror, held_rims }
        CrumpleExampleSetDef { struct_size, vertex_count, positions, normals, tangents, indices, index_count, index_type, examples, example_count, options }
        CrumpleExampleSet { index, generation, context }
        CrumpleLodDef { struct_size, vertex_count, positions, normals, tangents, indices, index_count, index_type }
        CrumpleGltfDef { struct_size, mesh_index, mesh_name, path, options }
        CrumpleObjDef { struct_size, example_count, base_path, example_paths, options }
        CrumpleStream { data, size, offset, stride }
        CrumpleMeshCopyDef { struct_size, lod, positions, normals, tangents, indices }
        CrumpleAabb { min, max }
        CrumpleExampleSetInfo { name, fingerprint, memory_bytes, vertex_count, triangle_count, example_count, primitive_count, seam_count, depth_limit, bounds, node_transform, has_tangents, lod_count, reserved }
        CrumpleExampleInfo { name, contact_vertex, moved_vertices, contact_point, contact_normal, depth, max_depth, support_radius, placement, reserved }
        CrumplePrimitive { material, first_vertex, vertex_count, first_triangle, triangle_count }
        CrumpleInstanceDef { struct_size, examples_per_hit, set, rule, selection, mark_capacity, depth_limit, yield_impulse, yield_displacement, max_contact_distance, blend_constant, tolerance, local_to_world }
        CrumpleInstance { index, generation, context }
        CrumpleInstanceInfo { set, memory_bytes, mark_count, buffer_count, depth_limit, contact_count, reserved }
        CrumpleImpulseDef { struct_size, space, point, impulse, duration, mass, contact_id, preview }
        CrumpleDisplacementDef { struct_size, space, point, displacement, contact_id, preview }
        CrumpleChosen { example, share, scale, anchored, mirror }
        CrumplePair { example, share }
        CrumpleMark { contact, depth, energy, pairs }
        CrumpleHitResult { status, contact_vertex, contact_distance, target, achieved, chosen_count, clamped, chosen, mark }
        CrumpleHostBufferDef { struct_size, lod, positions, normals, tangents }
        CrumpleBuffer { index, generation, context }
        CrumpleDeformReport { vertices_written, blocks_written, blocks_skipped, parts_skipped, reserved }
        CrumpleRange { first, count }
        CrumpleVulkanAttachDef { struct_size, queue_family, get_instance_proc_addr, instance, physical_device, device, pipeline_cache, pipeline_cache_size, workgroup_size }
        CrumpleVulkanStream { offset, stride, format, reserved }
        CrumpleVulkanBufferDef { struct_size, lod, buffer, buffer_size, usage, queue_family, before_stages, before_access, after_stages, after_access, offset, size, positions, normals, tangents, scale, bias }
        CrumpleRecordReport { vertices_written, blocks_written, blocks_skipped, parts_skipped, bytes_copied, dispatches, reserved0, reserved }
        CrumpleVulkanOpenDef { struct_size, workgroup_size, get_instance_proc_addr, device_uuid, pipeline_cache, pipeline_cache_size }
        CrumpleVulkanImportDef { struct_size, handle_type, handle, memory_size, memory_type, usage, offset, size, dedicated }
        CrumpleAttachment { vertices, weights, point }
        CrumpleQuat { x, y, z, w }
        CrumpleFrame { position, rotation }
    }
}

/// What the committed table says of the same.
fn committed() -> BTreeMap<String, String> {
    let lines = COMMITTED.lines().filter_map(|line| line.strip_prefix("struct "));
    lines
        .map(|line| {
            let words: Vec<&str> = line.split(' ').collect();
            let (name, fact) =
                if words[1] == "field" { (&words[..3], &words[3..5]) } else { (&words[..1], &words[1..]) };
            (name.join(" "), fact.join(" "))
        })
        .collect()
}

#[test]
fn rust_lays_out_what_c_does() {
    let (here, committed) = (here(), committed());
    assert!(committed.len() > 250);
    for (name, fact) in &committed {
        assert_eq!(
            here.get(name),
            Some(fact),
            "{name}: left is Rust's, right is C's; a new one belongs into the list above"
        );
    }
    assert_eq!(here.len(), committed.len(), "a struct or field of the list above is not in the header");
}
