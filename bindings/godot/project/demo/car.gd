extends VehicleBody3D
## A car to drive into things. Its body dents by its examples, its glass breaks, its bumpers fall off, and its wheels get out of line.
## `cargo xtask addon --demo` lays out its files.

const ReadQuantized := preload("res://addons/crumple/read_quantized.gd")
## The size of the collision shape as a share of the car's. What is in between crumples.
const HARD := Vector3(0.9, 1.0, 0.9)
## Vertices above this height belong to the cabin, m.
const BELT := 0.92
## Glass breaks when it is hit, or when a vertex of it has moved this far, m.
const GLASS_HOLDS := 0.012
## A bumper holds until a vertex of it has moved this far, m.
const BUMPER_HOLDS := 0.1
const BUMPER_MASS := 12.0
## How far parts move at most before they break or fall off, m.
const REACH := 0.3


## A surface of the body's mesh.
class Surface:
	var index: int
	## Its first vertex in the set.
	var first: int
	var vertices: PackedVector3Array
	## It stays within this box.
	var near: AABB

	## How far the vertex has moved that moved furthest, m. It looks at each eighth.
	func deepest(body: CrumpleMeshInstance3D) -> float:
		var furthest := 0.0
		for v in range(0, vertices.size(), 8):
			furthest = maxf(furthest, body.get_vertex(first + v).distance_to(vertices[v]))
		return furthest

	## Whether a vertex of it is at a point now.
	func is_at(point: Vector3, body: CrumpleMeshInstance3D) -> bool:
		return near.has_point(point) and range(vertices.size()).any(
			func(v: int) -> bool: return body.get_vertex(first + v) == point
		)


class Wheel:
	var node: VehicleWheel3D
	## It is drawn apart from the node, which turns with the wheel.
	var shown: MeshInstance3D
	var centre: Vector3
	## Where the car's structure holds it.
	var mount: Transform3D


var start: Transform3D
var body := CrumpleMeshInstance3D.new()
var panes: Array[Surface] = []
## The surfaces of each bumper.
var bumpers: Array[Array] = []
var wheels: Array[Wheel] = []
## Bumpers that have fallen off.
var loose: Array[RigidBody3D] = []
var broken := broken_glass()
var unseen := unseen_material()


func _ready() -> void:
	start = transform
	mass = 1200
	center_of_mass_mode = RigidBody3D.CENTER_OF_MASS_MODE_CUSTOM
	center_of_mass = Vector3(0, 0.4, 0)
	var model := read("res://assets/car.glb")
	var examples := CrumpleExampleSet.load_file("res://assets/car.crumple")
	examples.mesh = take_apart(model)
	model.free()
	body.example_set = examples
	body.dented.connect(_dented)
	add_child(body)


## The scene of a glTF file. Godot's import sorts vertices, which must keep the order of the example set.
static func read(path: String) -> Node:
	var quantized := ReadQuantized.new()
	GLTFDocument.register_gltf_document_extension(quantized)
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	document.append_from_file(path, state)
	GLTFDocument.unregister_gltf_document_extension(quantized)
	return document.generate_scene(state)


## Returns the parts that dent as one mesh, and adds the others to the car.
func take_apart(model: Node) -> ArrayMesh:
	var mesh := ArrayMesh.new()
	var lower := PackedVector3Array()
	var upper := PackedVector3Array()
	var first := 0
	for part: MeshInstance3D in model.get_children():
		# The file marks what does not dent.
		if part.has_meta("extras"):
			part.owner = null
			part.reparent(self, false)
			if part.name.begins_with("wheel"):
				wheels.append(add_wheel(part))
			continue
		var surfaces: Array[Surface] = []
		for s in part.mesh.get_surface_count():
			var arrays := part.mesh.surface_get_arrays(s)
			var material: StandardMaterial3D = part.mesh.surface_get_material(s)
			var surface := Surface.new()
			surface.index = mesh.get_surface_count()
			surface.first = first
			surface.vertices = arrays[Mesh.ARRAY_VERTEX]
			surface.near = part.mesh.get_aabb().grow(REACH)
			first += surface.vertices.size()
			surfaces.append(surface)
			if material.resource_name.begins_with("glass"):
				panes.append(surface)
			material.clearcoat_enabled = material.resource_name.begins_with("paint")
			mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
			mesh.surface_set_material(surface.index, material)
			if not part.name.begins_with("mirror"):
				for p in surface.vertices:
					if p.y < BELT:
						lower.append(p * HARD)
					else:
						upper.append(p * HARD)
		if part.name.begins_with("bumper"):
			bumpers.append(surfaces)
	add_hull(lower)
	add_hull(upper)
	return mesh


func add_hull(points: PackedVector3Array) -> void:
	var shape := CollisionShape3D.new()
	shape.shape = ConvexPolygonShape3D.new()
	shape.shape.points = points
	add_child(shape)


func add_wheel(part: MeshInstance3D) -> Wheel:
	var box := part.mesh.get_aabb()
	var centre := box.get_center()
	var wheel := VehicleWheel3D.new()
	var added := Wheel.new()
	added.node = wheel
	added.shown = part
	added.centre = centre
	added.mount = Transform3D(Basis.IDENTITY, centre * Vector3(0.5, 1, 1))
	# Godot's wheels sink in by a tenth.
	wheel.wheel_radius = 1.1 * box.size.y / 2
	wheel.wheel_rest_length = 0.2
	wheel.suspension_travel = 0.2
	wheel.suspension_stiffness = 45
	wheel.damping_compression = 2
	wheel.damping_relaxation = 3
	wheel.wheel_friction_slip = 4
	wheel.use_as_steering = centre.z > 0
	wheel.use_as_traction = centre.z < 0
	# The car's weight compresses the springs.
	wheel.position = centre + Vector3(0, 0.2 - 9.8 / 4 / 45, 0)
	add_child(wheel)
	return added


func drive(throttle: float, turn: float, step: float) -> void:
	engine_force = throttle * 6000
	brake = 0.0 if throttle != 0 else 8.0
	steering = move_toward(steering, 0.5 * turn, 2 * step)


func _process(_step: float) -> void:
	for wheel in wheels:
		var bent := body.get_attached(wheel.mount) * wheel.mount.affine_inverse()
		wheel.shown.transform = bent * wheel.node.transform.translated_local(-wheel.centre)


func reset() -> void:
	transform = start
	linear_velocity = Vector3.ZERO
	angular_velocity = Vector3.ZERO
	body.repair()
	for surface in body.mesh.get_surface_count():
		body.set_surface_override_material(surface, null)
	for bumper in loose:
		bumper.queue_free()
	loose.clear()


func _dented(point: Vector3, _displacement: Vector3) -> void:
	for pane in panes.filter(is_whole):
		if pane.is_at(point, body) or pane.deepest(body) > GLASS_HOLDS:
			body.set_surface_override_material(pane.index, broken)
	for bumper: Array[Surface] in bumpers:
		if bumper.all(is_whole) and bumper.any(func(s: Surface) -> bool: return s.deepest(body) > BUMPER_HOLDS):
			for surface in bumper:
				body.set_surface_override_material(surface.index, unseen)
			# Not within a step of physics.
			take_off.call_deferred(bumper)


## Whether a surface is neither broken nor off.
func is_whole(surface: Surface) -> bool:
	return body.get_surface_override_material(surface.index) == null


## Makes surfaces of the body a body of their own, as dented as they are.
func take_off(surfaces: Array[Surface]) -> void:
	body.update_now()
	var mesh := ArrayMesh.new()
	var hull := ConvexPolygonShape3D.new()
	for surface in surfaces:
		var arrays := body.mesh.surface_get_arrays(surface.index)
		mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
		mesh.surface_set_material(mesh.get_surface_count() - 1, body.mesh.surface_get_material(surface.index))
		hull.points += arrays[Mesh.ARRAY_VERTEX]
	var centre := mesh.get_aabb().get_center()
	var bumper := RigidBody3D.new()
	bumper.mass = BUMPER_MASS
	bumper.transform = global_transform.translated_local(centre)
	bumper.linear_velocity = linear_velocity
	bumper.angular_velocity = angular_velocity
	# It meets other things, and the wheels do not take it for ground.
	bumper.collision_layer = 0
	bumper.add_collision_exception_with(self)
	var shape := CollisionShape3D.new()
	shape.shape = hull
	shape.position = -centre
	bumper.add_child(shape)
	var shown := MeshInstance3D.new()
	shown.mesh = mesh
	shown.position = -centre
	bumper.add_child(shown)
	get_parent().add_child(bumper)
	loose.append(bumper)


## What cannot be seen and has no shadow.
static func unseen_material() -> StandardMaterial3D:
	var material := StandardMaterial3D.new()
	material.albedo_color = Color.TRANSPARENT
	material.transparency = BaseMaterial3D.TRANSPARENCY_ALPHA_SCISSOR
	return material


## White cracks in dark glass.
static func broken_glass() -> StandardMaterial3D:
	var noise := FastNoiseLite.new()
	noise.noise_type = FastNoiseLite.TYPE_CELLULAR
	noise.cellular_return_type = FastNoiseLite.RETURN_DISTANCE2_SUB
	noise.frequency = 0.03
	var cracks := NoiseTexture2D.new()
	cracks.noise = noise
	cracks.seamless = true
	cracks.color_ramp = Gradient.new()
	cracks.color_ramp.colors = [Color(0.8, 0.9, 0.92, 0.95), Color(0.2, 0.24, 0.25, 0.7)]
	cracks.color_ramp.offsets = [0.05, 0.25]
	var material := StandardMaterial3D.new()
	material.albedo_texture = cracks
	material.transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
	material.roughness = 0.4
	material.uv1_triplanar = true
	material.uv1_scale = 2 * Vector3.ONE
	return material
