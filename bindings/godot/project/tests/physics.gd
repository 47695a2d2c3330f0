extends Node
## Hits from physics. Runs with both of Godot's engines, and the same must come of it.

const Sheet := preload("res://tests/sheet.gd")

var t: Node


func box(parent: Node, size: Vector3, position: Vector3) -> void:
	var shape := CollisionShape3D.new()
	shape.shape = BoxShape3D.new()
	shape.shape.size = size
	shape.position = position
	parent.add_child(shape)


## A body with a sheet on top of a box. A vertex moves by 5 mm for each newton second.
func plate(body: PhysicsBody3D, position: Vector3) -> CrumpleMeshInstance3D:
	body.position = position
	box(body, Vector3(1, 0.2, 1), Vector3(0, -0.1, 0))
	var sheet := CrumpleMeshInstance3D.new()
	sheet.mesh = Sheet.mesh()
	sheet.vertex_mass = 2
	body.add_child(sheet)
	add_child(body)
	return sheet


func ball(mass: float, position: Vector3, velocity := Vector3.ZERO) -> RigidBody3D:
	var body := RigidBody3D.new()
	body.mass = mass
	body.position = position
	body.linear_velocity = velocity
	body.linear_damp_mode = RigidBody3D.DAMP_MODE_REPLACE
	var shape := CollisionShape3D.new()
	shape.shape = SphereShape3D.new()
	shape.shape.radius = 0.1
	body.add_child(shape)
	add_child(body)
	return body


func ticks(count: int) -> void:
	for i in count:
		await get_tree().physics_frame


func deepest(sheet: CrumpleMeshInstance3D) -> Vector3:
	var found := Vector3.ZERO
	for v in Sheet.SIDE * Sheet.SIDE:
		if sheet.get_vertex(v).y < found.y:
			found = sheet.get_vertex(v)
	return found


func clear() -> void:
	for child in get_children():
		child.free()
	await ticks(2)


func test_a_ball_dents_a_body_that_does_not_move() -> void:
	var sheet := plate(StaticBody3D.new(), Vector3.ZERO)
	ball(2, Vector3(0.25, 0.6, 0), Vector3(0, -1, 0))
	await ticks(60)
	# It falls 0.5 m: v^2 = 1 + 2 * 9.8 * 0.5.
	var momentum := 2 * sqrt(1 + 9.8)
	var found := deepest(sheet)
	t.near(found, Vector3(0.25, -0.005 * momentum, 0), 0.0035, "the deepest point")
	var damage := sheet.damage
	await ticks(120)
	t.ok(sheet.damage == damage, "a ball that lies still leaves nothing more")
	await clear()


func test_a_frozen_body_is_dented_as_one_that_does_not_move() -> void:
	var body := RigidBody3D.new()
	var sheet := plate(body, Vector3.ZERO)
	await ticks(1)
	body.freeze = true
	ball(2, Vector3(0.25, 0.6, 0), Vector3(0, -1, 0))
	await ticks(60)
	t.near(deepest(sheet), Vector3(0.25, -0.01 * sqrt(1 + 9.8), 0), 0.0035, "the deepest point")
	await clear()


## A body of 2 kg that runs at 3 m/s into a wall of some width. Damping leaves 2.92 m/s, which is 29.2 mm. Godot Physics needs
## several steps to stop it, and what is slower than twice what gravity adds in a step, 0.33 m/s or 3.3 mm, leaves nothing.
func run_into_wall(width: float) -> CrumpleMeshInstance3D:
	var wall := StaticBody3D.new()
	box(wall, Vector3(width, 0.2, width), Vector3(0.1, -0.1, 0.2))
	add_child(wall)
	var body := RigidBody3D.new()
	body.mass = 2
	body.gravity_scale = 0
	body.axis_lock_angular_x = true
	body.axis_lock_angular_y = true
	body.axis_lock_angular_z = true
	var sheet := plate(body, Vector3(0, -1, 0))
	body.linear_velocity = Vector3(0, 3, 0)
	return sheet


func test_a_body_that_runs_into_a_wall_is_dented() -> void:
	var sheet := run_into_wall(0.06)
	await ticks(60)
	var found := deepest(sheet)
	t.near(found.y, -0.0276, 0.002, "the depth")
	t.near(Vector2(found.x, found.z).distance_to(Vector2(0.1, 0.2)), 0, 0.08, "its distance from the wall's middle")
	await clear()


func test_points_further_apart_than_half_a_dent_share_the_momentum() -> void:
	# The example's dent has a radius of 20 cm. So each corner of a wall 10 cm wide leaves a dent.
	var sheet := run_into_wall(0.1)
	var hits := []
	sheet.dented.connect(func(at: Vector3, moved: Vector3) -> void: hits.append([at, moved.y]))
	await ticks(60)
	var sum := 0.0
	for hit: Array in hits:
		sum += hit[1]
		t.near(Vector2(hit[0].x, hit[0].z).distance_to(Vector2(0.1, 0.2)), 0.0707, 0.03, "a corner's distance from the wall's middle")
	t.near(sum, -0.0276, 0.002, "the depths together")
	t.same(sheet.get_mark_count(), 4, "dents")
	await clear()


func test_a_body_that_is_set_down_is_not_dented() -> void:
	var floor_body := StaticBody3D.new()
	box(floor_body, Vector3(4, 1, 4), Vector3(0, -0.5, 0))
	add_child(floor_body)
	var sheet := plate(RigidBody3D.new(), Vector3(0, 0.201, 0))
	await ticks(120)
	t.same(sheet.get_mark_count(), 0, "dents")
	await clear()


func test_two_bodies_that_collide_get_the_same_momentum() -> void:
	var lower := RigidBody3D.new()
	var upper := RigidBody3D.new()
	lower.mass = 1
	upper.mass = 4
	var one := plate(lower, Vector3(0, 0, 0))
	var two := plate(upper, Vector3(0, 1, 0))
	upper.rotation = Vector3(0, 0, PI)
	for body: RigidBody3D in [lower, upper]:
		body.gravity_scale = 0
		body.linear_damp_mode = RigidBody3D.DAMP_MODE_REPLACE
	upper.linear_velocity = Vector3(0, -3, 0)
	var sums := {}
	for sheet: CrumpleMeshInstance3D in [one, two]:
		sheet.dented.connect(func(_point: Vector3, moved: Vector3) -> void: sums[sheet] = sums.get(sheet, 0.0) + moved.y)
	await ticks(60)
	# Together 5 kg at 2.4 m/s: the lower one has got 2.4 N s, 12 mm.
	t.near(sums.get(one, 0.0), -0.012, 0.001, "what the lower one got")
	t.near(sums.get(two, 0.0), -0.012, 0.001, "what the upper one got")
	await clear()


func test_a_character_that_runs_into_a_wall_is_dented_once() -> void:
	var wall := StaticBody3D.new()
	box(wall, Vector3(2, 0.2, 2), Vector3(0, 0.1, 0))
	add_child(wall)
	var body := CharacterBody3D.new()
	body.motion_mode = CharacterBody3D.MOTION_MODE_FLOATING
	var sheet := plate(body, Vector3(0, -1, 0))
	sheet.character_mass = 2
	for i in 60:
		body.velocity = Vector3(0, 3, 0)
		body.move_and_slide()
		await get_tree().physics_frame
	t.near(deepest(sheet).y, -0.03, 0.004, "the depth")
	await clear()


func test_velocities_that_the_game_sets_are_no_hits() -> void:
	var sheet := plate(StaticBody3D.new(), Vector3.ZERO)
	var lying := ball(2, Vector3(0.1, 0.1, 0))
	await ticks(60)
	var before := sheet.damage
	lying.linear_velocity = Vector3(3, 0, 0)
	await ticks(2)
	lying.linear_velocity = Vector3(0, 4, 0)
	await ticks(2)
	t.ok(sheet.damage == before, "a ball that is thrown from the sheet does not dent it")
	await clear()


func test_the_rate_of_steps_does_not_matter() -> void:
	var depths := []
	for rate: int in [60, 144]:
		Engine.physics_ticks_per_second = rate
		var sheet := plate(StaticBody3D.new(), Vector3.ZERO)
		ball(2, Vector3(0.25, 0.6, 0), Vector3(0, -1, 0))
		await ticks(rate)
		depths.append(deepest(sheet).y)
		await clear()
	Engine.physics_ticks_per_second = 60
	t.near(depths[1], depths[0], 0.003, "the depth at 144 Hz")
