extends VehicleBody3D
## A car to drive into things. Its body dents by its examples, and its glass breaks. `cargo xtask addon --demo` lays out its files.

const ReadQuantized := preload("res://addons/crumple/read_quantized.gd")
## The size of the collision shape as a share of the car's. What is in between crumples.
const HARD := Vector3(0.9, 1.0, 0.9)
## Vertices above this height belong to the cabin, m.
const BELT := 0.92
## Glass breaks when a part of it has moved this far, m.
const GLASS_HOLDS := 0.012


## A pane of glass: a surface of the body's mesh.
class Pane:
	var surface: int
	## Its first vertex in the set.
	var first: int
	var vertices: PackedVector3Array


var start: Transform3D
var body := CrumpleMeshInstance3D.new()
var panes: Array[Pane] = []
var broken := broken_glass()


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
			part.reparent(add_wheel(part) if part.name.begins_with("wheel") else self, false)
			continue
		for s in part.mesh.get_surface_count():
			var arrays := part.mesh.surface_get_arrays(s)
			var material: StandardMaterial3D = part.mesh.surface_get_material(s)
			var pane := Pane.new()
			pane.surface = mesh.get_surface_count()
			pane.first = first
			pane.vertices = arrays[Mesh.ARRAY_VERTEX]
			first += pane.vertices.size()
			if material.resource_name.begins_with("glass"):
				panes.append(pane)
			material.clearcoat_enabled = material.resource_name.begins_with("paint")
			mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
			mesh.surface_set_material(pane.surface, material)
			if not part.name.begins_with("mirror"):
				for p in pane.vertices:
					if p.y < BELT:
						lower.append(p * HARD)
					else:
						upper.append(p * HARD)
	add_hull(lower)
	add_hull(upper)
	return mesh


func add_hull(points: PackedVector3Array) -> void:
	var shape := CollisionShape3D.new()
	shape.shape = ConvexPolygonShape3D.new()
	shape.shape.points = points
	add_child(shape)


func add_wheel(part: MeshInstance3D) -> VehicleWheel3D:
	var box := part.mesh.get_aabb()
	var centre := box.get_center()
	var wheel := VehicleWheel3D.new()
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
	part.position = -centre
	add_child(wheel)
	return wheel


func drive(throttle: float, turn: float, step: float) -> void:
	engine_force = throttle * 6000
	brake = 0.0 if throttle != 0 else 8.0
	steering = move_toward(steering, 0.5 * turn, 2 * step)


func reset() -> void:
	transform = start
	linear_velocity = Vector3.ZERO
	angular_velocity = Vector3.ZERO
	body.repair()
	for pane in panes:
		body.set_surface_override_material(pane.surface, null)


func _dented(_point: Vector3, _displacement: Vector3) -> void:
	for pane in panes:
		for v in range(0, pane.vertices.size(), 8):
			if body.get_vertex(pane.first + v).distance_to(pane.vertices[v]) > GLASS_HOLDS:
				body.set_surface_override_material(pane.surface, broken)
				break


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
