extends Node
## What the editor's import makes of files.

var t: Node


## The mesh of a scene.
static func mesh_of(scene: Node) -> ArrayMesh:
	return (scene.find_children("*", "MeshInstance3D", true, false)[0] as MeshInstance3D).mesh


## The hood, dented by the blow that one of its examples knows: how much deeper than the example.
func depth_of_known_blow(examples: CrumpleExampleSet, impact: Dictionary) -> float:
	var node := CrumpleMeshInstance3D.new()
	node.example_set = examples
	add_child(node)
	var vector := func(list: Array) -> Vector3: return Vector3(list[0], list[1], list[2])
	var hit := node.add_impulse(vector.call(impact.point), vector.call(impact.impulse), vector.call(impact.normal),
		impact.striker.mass, vector.call(impact.striker.velocity), impact.striker.radius)
	var depth: float = hit.achieved.length()
	node.free()
	return depth


func test_a_gltf_file_brings_examples_and_blows() -> void:
	var scene: Node = load("res://assets/hood.glb").instantiate()
	var mesh := mesh_of(scene)
	var examples := CrumpleExampleSet.from_mesh(mesh)
	t.same(examples.get_problem(), "", "problem")
	t.same(examples.get_vertex_count(), 24616, "vertices")
	t.same(examples.get_example_count(), mesh.get_blend_shape_count(), "examples")
	t.ok(examples.knows_blows(), "the examples know their blows")
	var described := examples.get_examples()
	var impacts: Array = mesh.get_meta("extras").impacts
	for i in described.size():
		t.same(described[i].name, impacts[i].name, "name")
	# Vertices follow nodes, 24 to a node.
	t.near(depth_of_known_blow(examples, impacts[0]), described[0].depth, 3e-4, "the depth of an example's own blow")
	scene.free()


func test_a_quantised_gltf_file_is_imported() -> void:
	var car: Node = load("res://assets/car.glb").instantiate()
	t.same(car.get_child_count(), 43, "parts")
	var normal: Vector3 = (car.get_node("roof") as MeshInstance3D).mesh.surface_get_arrays(0)[Mesh.ARRAY_NORMAL][0]
	t.near(normal.length(), 1, 1e-3, "the length of a normal that was stored as shorts")
	t.ok(normal.y > 0.5, "a normal of the roof, %s, is up" % normal)
	car.free()


func test_a_crumple_file_is_a_resource() -> void:
	var examples := load("res://assets/sheet.crumple") as CrumpleExampleSet
	t.ok(examples != null and examples.get_vertex_count() > 0, "it is an example set with vertices")
	var text: String = load("res://addons/crumple/inspect_set.gd").describe(examples) if Engine.is_editor_hint() else ""
	t.same(text, "", "the inspector belongs to the editor")


func test_the_classes_are_documented() -> void:
	for name: String in ["CrumpleExampleSet", "CrumpleMeshInstance3D"]:
		t.ok(ClassDB.class_exists(name), "%s is there" % name)
