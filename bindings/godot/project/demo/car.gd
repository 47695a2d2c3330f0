extends VehicleBody3D
## A car to drive into things. Its collision shape is two boxes; its body dents.

const CarMesh := preload("res://demo/car_mesh.gd")
const WHEEL := 0.32

var start: Transform3D
var body: CrumpleMeshInstance3D


func _ready() -> void:
	start = transform
	mass = 1200
	center_of_mass_mode = RigidBody3D.CENTER_OF_MASS_MODE_CUSTOM
	center_of_mass = Vector3(0, 0.4, 0)
	add_box(Vector3(1.66, 0.5, 4.1), Vector3(0, 0.66, 0))
	add_box(Vector3(1.3, 0.45, 1.9), Vector3(0, 1.15, 0.25))
	body = CrumpleMeshInstance3D.new()
	body.mesh = CarMesh.make(mass)
	body.yield_impulse = 150
	var paint := StandardMaterial3D.new()
	paint.vertex_color_use_as_albedo = true
	paint.vertex_color_is_srgb = true
	paint.metallic = 0.35
	paint.metallic_specular = 0.6
	paint.roughness = 0.28
	body.material_override = paint
	add_child(body)
	for front: bool in [true, false]:
		for side: int in [-1, 1]:
			add_wheel(Vector3(0.76 * side, 0.55, -1.3 if front else 1.3), front)


func add_box(size: Vector3, at: Vector3) -> void:
	var shape := CollisionShape3D.new()
	shape.shape = BoxShape3D.new()
	shape.shape.size = size
	shape.position = at
	add_child(shape)


func add_wheel(at: Vector3, front: bool) -> void:
	var wheel := VehicleWheel3D.new()
	wheel.position = at
	wheel.use_as_steering = front
	wheel.use_as_traction = not front
	wheel.wheel_radius = WHEEL
	wheel.wheel_rest_length = 0.2
	wheel.suspension_travel = 0.2
	wheel.suspension_stiffness = 45
	wheel.damping_compression = 0.4
	wheel.damping_relaxation = 0.6
	wheel.wheel_friction_slip = 4
	var tyre := MeshInstance3D.new()
	var cylinder := CylinderMesh.new()
	cylinder.top_radius = WHEEL
	cylinder.bottom_radius = WHEEL
	cylinder.height = 0.22
	tyre.mesh = cylinder
	tyre.rotation.z = PI / 2
	var rubber := StandardMaterial3D.new()
	rubber.albedo_color = Color(0.06, 0.06, 0.06)
	tyre.material_override = rubber
	wheel.add_child(tyre)
	add_child(wheel)


func drive(throttle: float, turn: float, step: float) -> void:
	engine_force = -throttle * 6000
	brake = 0.0 if throttle != 0 else 8.0
	steering = move_toward(steering, 0.5 * turn, 2 * step)


func reset() -> void:
	transform = start
	linear_velocity = Vector3.ZERO
	angular_velocity = Vector3.ZERO
	body.repair()
