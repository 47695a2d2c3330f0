extends SceneTree
## Crashes a van of the demo "Truck Town" of Godot's demo projects, and sees whether it dents. The demo is not part of Crumple:
## `CRUMPLE_TRUCK_TOWN=/path/to/3d/truck_town cargo xtask test --only godot` runs this in a copy of it.

const SECONDS := 20

var failures := 0
var checks := 0


func _initialize() -> void:
	crash.call_deferred()


func ok(fact: bool, what: String) -> void:
	checks += 1
	if not fact:
		failures += 1
		printerr("truck_town: not so: %s" % what)


func crash() -> void:
	# As the demo's menu does it.
	var car: Node3D = load("res://vehicles/car_base.tscn").instantiate()
	var town: Node3D = load("res://town/town_scene.tscn").instantiate()
	town.setup(car, func() -> void: pass, false)
	root.add_child(town)
	await physics_frame
	await physics_frame
	var van: VehicleBody3D = car.get_child(0)
	var found := van.find_children("*", "CrumpleMeshInstance3D", false, false)
	ok(found.size() == 1, "the van has one mesh that dents: %s" % [found])
	if found.size() == 1:
		var mesh: CrumpleMeshInstance3D = found[0]
		ok(mesh.get_problem() == "", "it dents: %s" % mesh.get_problem())
		print("%d vertices, %d examples" % [mesh.example_set.get_vertex_count(), mesh.example_set.get_example_count()])
		var hits: Array[float] = []
		mesh.dented.connect(func(_at: Vector3, by: Vector3) -> void: hits.append(by.length()))
		var top := 0.0
		Input.action_press(&"accelerate")
		for tick in SECONDS * Engine.physics_ticks_per_second:
			await physics_frame
			top = maxf(top, van.linear_velocity.length())
			if hits.size() > 0 and van.linear_velocity.length() < 1:
				break
		Input.action_release(&"accelerate")
		mesh.update_now()
		var deepest := 0.0
		var vertex := 0
		var pristine: ArrayMesh = mesh.example_set.get_pristine_mesh()
		for surface in pristine.get_surface_count():
			for point: Vector3 in pristine.surface_get_arrays(surface)[Mesh.ARRAY_VERTEX]:
				deepest = maxf(deepest, point.distance_to(mesh.get_vertex(vertex)))
				vertex += 1
		print("top speed %.1f m/s, %d dents, %.3f m deep" % [top, mesh.get_mark_count(), deepest])
		ok(deepest > 0.02, "the dents are deep enough to be seen: %s m" % deepest)
		ok(mesh.get_mark_count() > 0, "driven into the town, it is dented")
		ok(mesh.mesh != mesh.example_set.get_pristine_mesh(), "it shows the dents")
	town.free()
	print("%d checks, %d failed" % [checks, failures])
	quit(0 if failures == 0 else 1)
