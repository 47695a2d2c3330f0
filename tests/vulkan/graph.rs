//! Plans for a host's render graph. `bindings/godot/project/tests/compute.gd` executes such plans on two kinds of devices, frame by frame,
//! and compares the vertices with the CPU's; the kernels are those of the other tests here.

use crumple::graph::{Graph, GraphBuffer, Job, TargetDef};
use crumple::{Error, Instance, InstanceOptions, Rule};

use crate::gpu::folded;
use crate::scenes;

#[test]
fn a_render_graph_refuses_classic_rules() {
    let set = scenes::cube_set();
    let mut graph = Graph::default();
    let bytes = 12 * set.vertex_count() as u64;
    let def = TargetDef::positions(GraphBuffer { number: 1, size: bytes }, 0, bytes);
    let mut target = graph.add_target(&set, &def).unwrap();
    let classic = Instance::new(set.clone(), InstanceOptions::classic(Rule::MostDisplaced)).unwrap();
    let refused = graph.plan(&mut [Job { instance: &classic, target: &mut target }]).unwrap_err();
    assert!(matches!(refused, Error::WrongRule { .. }), "{refused}");
    // Nothing was lost.
    let instance = folded(&set, 1, 1);
    let (report, passes) = graph.plan(&mut [Job { instance: &instance, target: &mut target }]).unwrap();
    assert_eq!((report.vertices_written, passes.uploads.len()), (set.vertex_count() as u64, 1));
}
