extends Node3D
## Drive with the arrow keys. R puts everything back and repairs it. Without keys the car drives by itself, again and again.

const Car := preload("res://demo/car.gd")
const BarrelMesh := preload("res://demo/barrel_mesh.gd")

## What the car does by itself: until when (s), throttle, steering.
const PLAN: Array[Vector3] = [
	Vector3(1.1, 1, 0), Vector3(2.3, 0, 0), Vector3(3.7, -0.7, 0.7), Vector3(4.4, 0, 0), Vector3(5.2, 0.6, 0), Vector3(6.0, 0, 0),
]

var car: VehicleBody3D
var camera: Camera3D
var barrels: Array[RigidBody3D] = []
var places: Array[Transform3D] = []
var clock := 0.0
var taken := false


func _ready() -> void:
	get_viewport().msaa_3d = Viewport.MSAA_4X
	surroundings()
	car = Car.new()
	car.position = Vector3(0, 0, -10)
	add_child(car)
	var mesh := BarrelMesh.make(25)
	for at: Vector3 in [
		Vector3(-0.6, 0, -3), Vector3(0.05, 0, -3.1), Vector3(0.7, 0, -3), Vector3(-0.25, 0.9, -3), Vector3(-4.2, 0, -7),
		Vector3(-4.9, 0, -6.8),
	]:
		barrel(mesh, at)
	camera = Camera3D.new()
	camera.fov = 40
	add_child(camera)
	follow(1)


func _physics_process(step: float) -> void:
	var throttle := Input.get_axis("ui_down", "ui_up")
	var turn := Input.get_axis("ui_right", "ui_left")
	taken = taken or throttle != 0 or turn != 0
	if not taken:
		clock += step
		var now := Vector3(0, 0, 0)
		for part in PLAN:
			if clock < part.x:
				now = part
				break
		throttle = now.y
		turn = now.z
		if clock > PLAN[-1].x:
			reset()
	car.drive(throttle, turn, step)


func _process(step: float) -> void:
	follow(1 - exp(-12 * step))


func _unhandled_key_input(event: InputEvent) -> void:
	if event.is_pressed() and (event as InputEventKey).keycode == KEY_R:
		reset()


func reset() -> void:
	clock = 0
	taken = false
	car.reset()
	for i in barrels.size():
		barrels[i].transform = places[i]
		barrels[i].linear_velocity = Vector3.ZERO
		barrels[i].angular_velocity = Vector3.ZERO
		(barrels[i].get_node("Mesh") as CrumpleMeshInstance3D).repair()


## The camera looks at what is about to crash, and from behind when somebody drives.
func follow(share: float) -> void:
	var at := Vector3(-2.3, 1.5, 3.7).rotated(Vector3.UP, -2.6 * smoothstep(2.8, 4, clock))
	if taken:
		at = car.basis * Vector3(0, 2.2, -6.5)
	camera.position = camera.position.lerp(car.position + at, share)
	camera.look_at(car.position + Vector3(0, 0.6, 0.3))


func solid(mesh: PrimitiveMesh, at: Vector3, colour: Color) -> MeshInstance3D:
	var shown := MeshInstance3D.new()
	shown.mesh = mesh
	shown.position = at
	var material := StandardMaterial3D.new()
	material.albedo_color = colour
	material.roughness = 0.9
	shown.material_override = material
	add_child(shown)
	return shown


func box(size: Vector3, at: Vector3, colour: Color) -> MeshInstance3D:
	var mesh := BoxMesh.new()
	mesh.size = size
	return solid(mesh, at, colour)


func post(at: Vector3) -> void:
	var mesh := CylinderMesh.new()
	mesh.top_radius = 0.13
	mesh.bottom_radius = 0.13
	mesh.height = 1.1
	solid(mesh, at + Vector3(0, 0.55, 0), Color(0.9, 0.62, 0.05)).create_convex_collision()


func barrel(mesh: ArrayMesh, at: Vector3) -> void:
	var body := RigidBody3D.new()
	body.mass = 25
	# It tips over the hood, not below the car.
	body.center_of_mass_mode = RigidBody3D.CENTER_OF_MASS_MODE_CUSTOM
	body.center_of_mass = Vector3(0, 0.6, 0)
	body.position = at
	var shape := CollisionShape3D.new()
	shape.shape = CylinderShape3D.new()
	shape.shape.radius = 0.3
	shape.shape.height = 0.88
	shape.position.y = 0.44
	body.add_child(shape)
	var shown := CrumpleMeshInstance3D.new()
	shown.name = "Mesh"
	shown.mesh = mesh
	var paint := StandardMaterial3D.new()
	paint.albedo_color = Color(0.75, 0.16, 0.04)
	paint.metallic = 0.4
	paint.roughness = 0.35
	shown.material_override = paint
	body.add_child(shown)
	add_child(body)
	barrels.append(body)
	places.append(body.transform)


func surroundings() -> void:
	box(Vector3(200, 1, 200), Vector3(0, -0.5, 0), Color(0.2, 0.2, 0.21)).create_convex_collision()
	for x in range(-20, 21, 5):
		box(Vector3(0.12, 0.01, 5), Vector3(x + 2.5, 0, -1), Color(0.85, 0.85, 0.82))
		post(Vector3(x - 0.4, 0, 2))
	# A wall's corner, to back into.
	box(Vector3(4, 2.6, 6), Vector3(5.4, 1.3, -11), Color(0.62, 0.58, 0.52)).create_convex_collision()
	var sun := DirectionalLight3D.new()
	sun.rotation_degrees = Vector3(-42, -80, 0)
	sun.light_energy = 1.4
	sun.light_color = Color(1, 0.95, 0.88)
	sun.shadow_enabled = true
	sun.directional_shadow_max_distance = 30
	add_child(sun)
	var environment := Environment.new()
	environment.background_mode = Environment.BG_SKY
	environment.sky = Sky.new()
	var sky := ProceduralSkyMaterial.new()
	sky.ground_bottom_color = Color(0.12, 0.12, 0.13)
	sky.ground_horizon_color = sky.sky_horizon_color
	environment.sky.sky_material = sky
	environment.tonemap_mode = Environment.TONE_MAPPER_ACES
	environment.ssao_enabled = true
	var world := WorldEnvironment.new()
	world.environment = environment
	add_child(world)
