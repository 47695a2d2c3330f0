extends Node
## What the classes do without physics.

const Sheet := preload("res://tests/sheet.gd")

var t: Node


func dented(node: CrumpleMeshInstance3D) -> Dictionary:
	return node.add_impulse(node.to_global(Vector3(0.25, 0, 0)), node.global_basis * Vector3(0, -2, 0))


func test_a_hit_dents_the_place_that_was_hit() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	node.position = Vector3(3, 2, 1)
	node.rotate_z(PI)
	var hits := []
	node.dented.connect(func(point: Vector3, displacement: Vector3) -> void: hits.append([point, displacement]))
	# Upside down, so the sheet is hit from below.
	var hit := node.add_impulse(node.to_global(Vector3(0.25, 0, 0)), Vector3(0, 2, 0))
	t.same(hit.status, CrumpleMeshInstance3D.MARKED, "status")
	t.near(hit.achieved, Vector3(0, -0.04, 0), 1e-4, "achieved")
	t.same(hits.size(), 1, "signals")
	t.near(hits[0][0], Vector3(0.25, -0.04, 0), 1e-4, "the signal's point")
	t.near(node.get_vertex(hit.contact_vertex), Vector3(0.25, -0.04, 0), 1e-4, "the contact")
	t.same(node.add_displacement(node.to_global(Vector3(-0.3, 0, 0)), Vector3(0, 0.02, 0)).status, 0, "status")
	t.near(node.get_vertex(Sheet.SIDE * Sheet.SIDE / 2 - 12), Vector3(-0.3, -0.02, 0), 1e-4, "a displaced vertex")
	node.free()


func test_absolute_and_relative_shapes_give_the_same_set() -> void:
	var points := []
	for mode: int in [Mesh.BLEND_SHAPE_MODE_NORMALIZED, Mesh.BLEND_SHAPE_MODE_RELATIVE]:
		var node := Sheet.node(self, Sheet.mesh(mode))
		points.append(node.get_vertex(dented(node).contact_vertex))
		t.same(node.example_set.get_example_count(), 1, "examples")
		t.near(node.example_set.get_deepest(), 0.05 * 3, 1e-6, "the furthest that a vertex moves")
		node.free()
	t.same(points[0], points[1], "the contact")


func test_surfaces_are_one_body() -> void:
	var node := Sheet.node(self, Sheet.mesh(Mesh.BLEND_SHAPE_MODE_RELATIVE, 2))
	t.same(node.example_set.get_vertex_count(), 2 * 21 * 41, "vertices")
	t.same(node.mesh.get_surface_count(), 2, "surfaces")
	var material := StandardMaterial3D.new()
	node.set_surface_override_material(1, material)
	node.add_displacement(Vector3.ZERO, Vector3(0, -0.03, 0))
	node.update_now()
	t.same(node.get_active_material(1), material, "the material")
	# The seam between the surfaces, in both.
	t.near(node.get_vertex(20 * 41 + 20), Vector3(0, -0.03, 0), 1e-4, "the first surface's vertex")
	t.same(node.get_vertex(20 * 41 + 20), node.get_vertex(21 * 41 + 20), "the second surface's vertex")
	node.free()


func test_what_is_fixed_to_the_mesh_moves_and_turns_with_it() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	# A post of 0.1 m on the slope of the dent, and a lamp at a corner.
	var post := Transform3D(Basis(Vector3.UP, 1), Vector3(0.1, 0.1, 0.003))
	var lamp := Transform3D(Basis.IDENTITY, Vector3(0.49, 0, 0.49))
	t.near(node.get_attached(post).origin, post.origin, 1e-6, "the post at rest")
	node.add_displacement(Vector3.ZERO, Vector3(0, -0.05, 0))
	var bent := node.get_attached(post)
	# The dent is 0.05 (1 - r^2 / 0.2^2)^2 deep at r: 0.028 at 0.1, where its slope is 0.375.
	var normal := bent.basis.y.normalized()
	# Of the facets, which are 25 mm wide.
	t.near(normal, Vector3(-0.375, 1, 0).normalized(), 0.05, "the post stands on the slope")
	t.near(bent.origin - 0.1 * normal, Vector3(0.1, -0.028, 0.003), 2e-3, "its foot is on the sheet")
	t.same(node.get_attached(lamp), lamp, "the lamp")
	node.free()


func test_a_coarse_mesh_is_divided() -> void:
	# 0.25 m between vertices, and the same sheet with 0.125 m.
	for surfaces: int in [1, 2]:
		var coarse := CrumpleExampleSet.from_mesh(Sheet.mesh(Mesh.BLEND_SHAPE_MODE_NORMALIZED, surfaces, true, 5))
		t.same(coarse.get_vertex_count(), 25 if surfaces == 1 else 30, "vertices")
		coarse.edge_length = 0.2
		t.same(coarse.get_vertex_count(), 81 if surfaces == 1 else 90, "vertices after division")
		t.near(coarse.get_deepest(), 0.05 * 3, 1e-6, "the furthest that a vertex moves")
		var node := CrumpleMeshInstance3D.new()
		node.example_set = coarse
		add_child(node)
		node.add_displacement(Vector3.ZERO, Vector3(0, -0.05, 0))
		var points := PackedVector3Array()
		for v in coarse.get_vertex_count():
			points.append(node.get_vertex(v))
		for p in points:
			if p.x == 0.125 and p.z == 0:
				t.near(p.y, -0.025, 1e-3, "half way between a dented and an undented vertex")
		t.ok(Vector3(0.125, -0.025, 0) in points or points.size() > 80, "a new vertex is there")
		t.same(node.mesh.surface_get_array_len(0), 81 if surfaces == 1 else 45, "vertices shown")
		node.free()


func test_a_mesh_without_examples_gets_round_ones() -> void:
	var box := ArrayMesh.new()
	box.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, BoxMesh.new().get_mesh_arrays())
	var mesh: ArrayMesh = load("res://addons/crumple/round_dents.gd").add_to(box, 0.1, 6, 0.3, 0.1)
	t.same(mesh.get_blend_shape_count(), 6, "examples")
	var node := Sheet.node(self, mesh)
	t.same(node.get_problem(), "", "problem")
	var hit := node.add_displacement(Vector3(0.1, 0.5, 0.1), Vector3(0, -0.08, 0))
	t.near(node.get_vertex(hit.contact_vertex).y, 0.42, 0.01, "the top")
	t.ok(CrumpleExampleSet.divide_mesh(box, 0) == null, "a length of 0 is refused")
	node.free()


func test_other_channels_are_kept() -> void:
	var arrays := Sheet.arrays(0, 1, false, false, 5)
	var custom := PackedFloat32Array()
	var bytes := PackedByteArray()
	for i in 50:
		custom.append(i)
	for i in 100:
		bytes.append(i)
	arrays[Mesh.ARRAY_CUSTOM0] = custom
	arrays[Mesh.ARRAY_CUSTOM1] = bytes
	var dent := Sheet.arrays(0, 1, true, false, 5)
	dent[Mesh.ARRAY_INDEX] = null
	dent[Mesh.ARRAY_TEX_UV] = null
	var mesh := ArrayMesh.new()
	mesh.add_blend_shape("dent")
	mesh.blend_shape_mode = Mesh.BLEND_SHAPE_MODE_NORMALIZED
	var format := (Mesh.ARRAY_CUSTOM_RG_FLOAT << Mesh.ARRAY_FORMAT_CUSTOM0_SHIFT) \
		| (Mesh.ARRAY_CUSTOM_RG_HALF << Mesh.ARRAY_FORMAT_CUSTOM1_SHIFT)
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, [dent], {}, format)
	var shown := CrumpleExampleSet.from_mesh(mesh).get_pristine_mesh()
	var kept := shown.surface_get_arrays(0)
	for channel: int in [Mesh.ARRAY_CUSTOM0, Mesh.ARRAY_CUSTOM1, Mesh.ARRAY_TEX_UV]:
		t.same(kept[channel], mesh.surface_get_arrays(0)[channel], "channel %d" % channel)


func test_nodes_share_a_set_and_the_undamaged_mesh() -> void:
	var mesh := Sheet.mesh()
	var one := Sheet.node(self, mesh)
	var two := Sheet.node(self, mesh)
	t.same(one.example_set, two.example_set, "the set")
	t.same(one.mesh, two.mesh, "the mesh")
	t.same(one.mesh.get_blend_shape_count(), 0, "blend shapes of the shown mesh")
	dented(one)
	one.update_now()
	t.ok(one.mesh != two.mesh, "a dented node shows a mesh of its own")
	t.same(two.get_mark_count(), 0, "dents of the other")
	one.free()
	two.free()


func test_damage_is_saved_loaded_copied_and_repaired() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	var contact: int = dented(node).contact_vertex
	var bytes := node.save_damage()
	var there := node.get_vertex(contact)
	t.ok(bytes.size() < 200, "one dent takes %d bytes" % bytes.size())
	var copy := node.duplicate() as CrumpleMeshInstance3D
	add_child(copy)
	t.same(copy.get_vertex(contact), there, "the duplicate's vertex")
	copy.free()
	var scene := PackedScene.new()
	scene.pack(node)
	var again := scene.instantiate() as CrumpleMeshInstance3D
	add_child(again)
	t.same(again.get_vertex(contact), there, "the vertex of a packed scene")
	again.free()
	node.repair(0.5)
	t.near(node.get_vertex(contact), Vector3(there.x, there.y / 2, there.z), 1e-3, "half repaired")
	node.repair()
	t.near(node.get_vertex(contact).y, 0, 0, "repaired")
	t.same(node.save_damage().size(), 0, "bytes without damage")
	t.same(node.load_damage(bytes), OK, "loading")
	t.same(node.get_vertex(contact), there, "loaded")
	node.free()


func test_options_may_change() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	var contact: int = dented(node).contact_vertex
	node.depth_limit = 0.01
	t.near(node.get_vertex(contact).y, -0.01, 3e-4, "near the limit")
	node.depth_limit = 0
	t.near(node.get_vertex(contact).y, -0.04, 1e-4, "the whole depth")
	node.yield_impulse = 3
	t.same(dented(node).status, CrumpleMeshInstance3D.BELOW_YIELD, "a weak hit")
	node.free()


func test_another_set_begins_anew() -> void:
	var mesh := Sheet.mesh()
	var node := Sheet.node(self, mesh)
	dented(node)
	node.update_now()
	node.example_set = CrumpleExampleSet.from_mesh(Sheet.mesh(Mesh.BLEND_SHAPE_MODE_RELATIVE, 1, false, 31))
	t.same(node.get_mark_count(), 0, "dents")
	t.same(node.mesh.surface_get_array_len(0), 31 * 31, "vertices")
	node.example_set = null
	t.same(node.example_set.mesh, mesh, "without a set it takes its own mesh again")
	node.free()


func test_bounds_follow_the_dents() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	dented(node)
	node.update_now()
	t.near((node.mesh as ArrayMesh).custom_aabb.position.y, -0.04, 1e-3, "the lowest point of the bounds")
	node.free()


func test_hits_may_come_from_the_signal() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	var again := func(point: Vector3, _displacement: Vector3) -> void:
		if point.x > 0:
			node.add_displacement(Vector3(-0.3, 0, 0), Vector3(0, -0.02, 0))
			node.repair(1)
	node.dented.connect(again)
	dented(node)
	t.same(node.get_mark_count(), 2, "dents")
	node.free()


func test_a_file_gives_the_same_set() -> void:
	var set_of_mesh := CrumpleExampleSet.from_mesh(Sheet.mesh())
	t.same(set_of_mesh.save_file("user://sheet.crumple"), OK, "saving")
	var loaded := CrumpleExampleSet.load_file("user://sheet.crumple")
	t.same(loaded.get_vertex_count(), 41 * 41, "vertices")
	t.same(loaded.get_examples(), set_of_mesh.get_examples(), "examples")
	var node := CrumpleMeshInstance3D.new()
	node.example_set = loaded
	add_child(node)
	var point := node.get_vertex(dented(node).contact_vertex)
	t.near(point, Vector3(0.25, -0.04, 0), 1e-4, "the contact")
	t.same(node.mesh.surface_get_array_len(0), 41 * 41, "vertices of the shown mesh")
	# With the mesh it has what a baked set lacks.
	var both := CrumpleExampleSet.from_mesh(Sheet.mesh())
	both.data = FileAccess.get_file_as_bytes("user://sheet.crumple")
	t.same(both.get_problem(), "", "problem")
	t.ok(both.get_pristine_mesh().surface_get_format(0) & Mesh.ARRAY_FORMAT_TEX_UV != 0, "it has texture coordinates")
	# Compression rounds positions and adds tangents.
	var compressed := ArrayMesh.new()
	compressed.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, Sheet.arrays(0, 1, false, false), [], {},
		Mesh.ARRAY_FLAG_COMPRESS_ATTRIBUTES)
	both.mesh = compressed
	t.same(both.get_problem(), "", "problem of a compressed mesh")
	node.example_set = both
	dented(node)
	node.update_now()
	t.near((node.mesh as ArrayMesh).custom_aabb.size.y, 0.04, 1e-3, "depth")
	node.free()


func test_a_set_loads_on_another_thread() -> void:
	var set_of_mesh := CrumpleExampleSet.from_mesh(Sheet.mesh())
	var kept := CrumpleExampleSet.new()
	kept.data = set_of_mesh.bake()
	t.same(ResourceSaver.save(kept, "user://sheet.res"), OK, "saving")
	ResourceLoader.load_threaded_request("user://sheet.res", "", true)
	while ResourceLoader.load_threaded_get_status("user://sheet.res") == ResourceLoader.THREAD_LOAD_IN_PROGRESS:
		# Frames in between made Godot 4.6 leak an object of its own in one of five runs.
		OS.delay_msec(1)
	var loaded := ResourceLoader.load_threaded_get("user://sheet.res") as CrumpleExampleSet
	t.same(loaded.get_example_count(), 1, "examples")


func test_damage_for_another_set_is_refused() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	dented(node)
	var bytes := node.save_damage()
	var other := Sheet.node(self, Sheet.mesh(Mesh.BLEND_SHAPE_MODE_RELATIVE, 1, false, 31))
	dented(other)
	var before := other.save_damage()
	t.same(other.load_damage(bytes), ERR_INVALID_DATA, "loading another's damage")
	t.same(other.load_damage(before.slice(0, 40)), ERR_INVALID_DATA, "loading a piece")
	t.same(other.save_damage(), before, "the damage")
	node.free()
	other.free()


func test_bad_resources_say_what_is_wrong() -> void:
	var plain := ArrayMesh.new()
	plain.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, Sheet.arrays(0, 1, false, false))
	var lines := ArrayMesh.new()
	var arrays := []
	arrays.resize(Mesh.ARRAY_MAX)
	arrays[Mesh.ARRAY_VERTEX] = PackedVector3Array([Vector3.ZERO, Vector3.ONE])
	lines.add_surface_from_arrays(Mesh.PRIMITIVE_LINES, arrays)
	var extras := Sheet.mesh()
	extras.set_meta("extras", {"impacts": [{"name": "dent"}]})
	var not_finite := Sheet.mesh()
	not_finite.set_meta("extras", 7)
	for bad: Array in [
		[null, "neither a mesh nor the bytes"],
		[plain, "the mesh has no blend shapes"],
		[lines, "no surface of triangles"],
		[extras, "extras.impacts[0] has neither a point nor a contact_vertex"],
		[not_finite, "the mesh's metadata \"extras\" is 7"],
	]:
		var made := CrumpleExampleSet.from_mesh(bad[0])
		t.ok(made.get_problem().contains(bad[1]), "'%s' says: %s" % [made.get_problem(), bad[1]])
		t.same(made.build(), ERR_INVALID_DATA, "building")
		t.same(made.bake().size(), 0, "bytes")
	var other := CrumpleExampleSet.from_mesh(Sheet.mesh(Mesh.BLEND_SHAPE_MODE_RELATIVE, 1, false, 31))
	other.data = CrumpleExampleSet.from_mesh(Sheet.mesh()).bake()
	t.ok(other.get_problem().contains("baked from another mesh"), other.get_problem())
	other.data = PackedByteArray([1, 2, 3])
	t.ok(other.get_problem() != "", "three bytes are no set")
	t.same(CrumpleExampleSet.load_file("user://none.crumple"), null, "a file that is not there")
	var node := CrumpleMeshInstance3D.new()
	node.mesh = BoxMesh.new()
	add_child(node)
	t.ok(node.get_problem().contains("BoxMesh"), node.get_problem())
	t.same(node.add_impulse(Vector3.ZERO, Vector3.DOWN), {}, "a hit without examples")
	node.free()


func test_bad_hits_leave_nothing() -> void:
	var node := Sheet.node(self, Sheet.mesh())
	t.same(node.add_impulse(Vector3(NAN, 0, 0), Vector3.DOWN), {}, "a hit nowhere")
	t.same(node.add_displacement(Vector3(0, 100, 0), Vector3.DOWN), {}, "a hit far away")
	t.same(node.add_impulse(Vector3.ZERO, Vector3.ZERO).status, CrumpleMeshInstance3D.BELOW_YIELD, "no impulse")
	t.same(node.get_mark_count(), 0, "dents")
	node.free()


func test_a_thousand_nodes() -> void:
	var mesh := Sheet.mesh()
	var nodes: Array[CrumpleMeshInstance3D] = []
	for i in 1000:
		nodes.append(Sheet.node(self, mesh))
		dented(nodes[-1])
	await get_tree().process_frame
	var own := {}
	for node in nodes:
		own[node.mesh] = true
	t.same(own.size(), 1000, "meshes")
	for node in nodes:
		node.free()
