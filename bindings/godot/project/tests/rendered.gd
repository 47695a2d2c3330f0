extends Node
## What is drawn. Needs a rendering driver.

const Sheet := preload("res://tests/sheet.gd")
const SIZE := Vector2i(480, 270)

var t: Node


func data(mesh: ArrayMesh, surface: int) -> PackedByteArray:
	return RenderingServer.mesh_get_surface(mesh.get_rid(), surface).vertex_data


func test_vertices_on_the_server() -> void:
	# Every vertex is written once by Godot and once by Crumple, and both must have packed it alike.
	for tangents: bool in [false, true]:
		var node := Sheet.node(self, Sheet.mesh(Mesh.BLEND_SHAPE_MODE_RELATIVE, 2, tangents))
		var pristine: ArrayMesh = node.mesh
		node.add_displacement(Vector3(0.1, 0, 0.1), Vector3(0, -0.03, 0))
		node.update_now()
		t.ok(data(node.mesh, 0) != data(pristine, 0), "a dent changes the buffer")
		var points: PackedVector3Array = node.mesh.surface_get_arrays(1)[Mesh.ARRAY_VERTEX]
		for v in points.size():
			if points[v] != node.get_vertex(v + 21 * 41):
				t.same(points[v], node.get_vertex(v + 21 * 41), "vertex %d on the server" % v)
				break
		node.repair()
		node.update_now()
		for surface in 2:
			t.ok(data(node.mesh, surface) == data(pristine, surface), "repaired, surface %d is as Godot made it" % surface)
		node.free()


func test_a_crash_looks_as_it_should() -> void:
	var view := SubViewport.new()
	view.size = SIZE
	view.own_world_3d = true
	view.msaa_3d = Viewport.MSAA_4X
	view.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	add_child(view)
	var sun := DirectionalLight3D.new()
	sun.rotation_degrees = Vector3(-22, 75, 0)
	sun.light_energy = 1.6
	sun.shadow_enabled = true
	view.add_child(sun)
	var camera := Camera3D.new()
	camera.position = Vector3(0, 0.72, 0.8)
	camera.rotation_degrees = Vector3(-42, 0, 0)
	camera.fov = 60
	view.add_child(camera)
	var body := StaticBody3D.new()
	view.add_child(body)
	var scene: Node = load("res://assets/hood.glb").instantiate()
	var hood := CrumpleMeshInstance3D.new()
	hood.mesh = (scene.find_children("*", "MeshInstance3D", true, false)[0] as MeshInstance3D).mesh
	scene.free()
	var paint := StandardMaterial3D.new()
	paint.albedo_color = Color(0.85, 0.25, 0.18)
	paint.metallic = 0.1
	paint.roughness = 0.35
	hood.material_override = paint
	# The mesh has z up.
	hood.rotation_degrees = Vector3(-90, 0, 0)
	body.add_child(hood)
	var shape := CollisionShape3D.new()
	shape.shape = hood.mesh.create_trimesh_shape()
	shape.rotation = hood.rotation
	body.add_child(shape)
	for place: Vector3 in [Vector3(0.1, 0.5, 0.1), Vector3(-0.35, 0.6, -0.1)]:
		var ball := RigidBody3D.new()
		ball.mass = 20
		ball.position = place
		ball.linear_velocity = Vector3(0, -8, 0)
		var sphere := CollisionShape3D.new()
		sphere.shape = SphereShape3D.new()
		sphere.shape.radius = 0.1
		ball.add_child(sphere)
		view.add_child(ball)
	for i in 30:
		await get_tree().physics_frame
	t.same(hood.get_mark_count(), 2, "dents")
	for i in 3:
		await RenderingServer.frame_post_draw
	var image := view.get_texture().get_image()
	image.convert(Image.FORMAT_RGB8)
	image.save_png("user://crash.png")
	var wanted := Image.load_from_file("res://tests/crash.png")
	t.ok(wanted != null, "there is a picture to compare with")
	if wanted != null:
		wanted.convert(Image.FORMAT_RGB8)
		t.same(image.get_size(), wanted.get_size(), "size")
		var difference := image.compute_image_metrics(wanted, false)
		t.ok(difference.root_mean_squared < 1, "the picture differs from tests/crash.png: %s" % difference)
	t.ok(RenderingServer.mesh_get_surface(hood.mesh.get_rid(), 0).get("lods", []).size() > 1, "it has levels of detail")
	# The dents are seen.
	hood.repair()
	hood.update_now()
	for i in 3:
		await RenderingServer.frame_post_draw
	var undamaged := view.get_texture().get_image()
	undamaged.convert(Image.FORMAT_RGB8)
	var change: Dictionary = image.compute_image_metrics(undamaged, false)
	t.ok(change.root_mean_squared > 2, "a dented hood looks other than an undamaged one: %s" % change)
	view.free()
