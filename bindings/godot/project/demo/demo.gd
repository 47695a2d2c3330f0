extends Node3D
## Drive with the arrow keys or WASD. R puts everything back and repairs it. Without keys the car drives by itself, again and again.

const Car := preload("res://demo/car.gd")
const BarrelMesh := preload("res://demo/barrel_mesh.gd")

## What the car does by itself: until when (s), throttle, steering.
const PLAN: Array[Vector3] = [Vector3(2.6, 1, 0), Vector3(3.4, 0, 0), Vector3(4.6, -0.8, 0), Vector3(6.0, 0, 0)]

var car: VehicleBody3D
var camera: Camera3D
var barrels: Array[RigidBody3D] = []
var places: Array[Transform3D] = []
var clock := 0.0
var taken := false


func _ready() -> void:
	surroundings()
	car = Car.new()
	car.position = Vector3(0, 0.1, 12)
	add_child(car)
	pillar(Vector3(0.5, 0, -3))
	pillar(Vector3(-7, 0, -3))
	var mesh := BarrelMesh.make(25)
	for at: Vector3 in [
		Vector3(-0.75, 0, 5), Vector3(-0.05, 0, 5.2), Vector3(-0.4, 0.9, 5.1), Vector3(-1.5, 0, 4.7), Vector3(-3, 0, -6),
		Vector3(-3.6, 0, -6.3),
	]:
		barrel(mesh, at)
	camera = Camera3D.new()
	camera.fov = 46
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
	follow(1 - exp(-7 * step))


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


## The camera looks at the car's front from the side.
func follow(share: float) -> void:
	var at := car.global_position + Vector3(-3.1, 1.9, -4.2)
	camera.global_position = camera.global_position.lerp(at, share)
	camera.look_at(car.global_position + Vector3(0, 0.6, -0.4))


func solid(size: Vector3, at: Vector3, colour: Color) -> void:
	var body := StaticBody3D.new()
	body.position = at
	var shape := CollisionShape3D.new()
	shape.shape = BoxShape3D.new()
	shape.shape.size = size
	body.add_child(shape)
	var shown := MeshInstance3D.new()
	shown.mesh = BoxMesh.new()
	shown.mesh.size = size
	var material := StandardMaterial3D.new()
	material.albedo_color = colour
	material.roughness = 0.9
	shown.material_override = material
	body.add_child(shown)
	add_child(body)


func pillar(at: Vector3) -> void:
	solid(Vector3(0.7, 3, 0.7), at + Vector3(0, 1.5, 0), Color(0.75, 0.72, 0.66))


func barrel(mesh: ArrayMesh, at: Vector3) -> void:
	var body := RigidBody3D.new()
	body.mass = 25
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
	paint.albedo_color = Color(0.10, 0.32, 0.62)
	paint.metallic = 0.4
	paint.roughness = 0.35
	shown.material_override = paint
	body.add_child(shown)
	add_child(body)
	barrels.append(body)
	places.append(body.transform)


func surroundings() -> void:
	solid(Vector3(60, 1, 60), Vector3(0, -0.5, 0), Color(0.36, 0.37, 0.38))
	var sun := DirectionalLight3D.new()
	sun.rotation_degrees = Vector3(-42, -55, 0)
	sun.light_energy = 1.3
	sun.shadow_enabled = true
	sun.directional_shadow_max_distance = 30
	add_child(sun)
	var environment := Environment.new()
	environment.background_mode = Environment.BG_SKY
	environment.sky = Sky.new()
	environment.sky.sky_material = ProceduralSkyMaterial.new()
	environment.tonemap_mode = Environment.TONE_MAPPER_FILMIC
	var world := WorldEnvironment.new()
	world.environment = environment
	add_child(world)
