extends SceneTree
## The editor loads the extension again, as it does when its library was rebuilt, while nodes and sets live. Runs as
## godot --headless --editor --script res://tests/reload.gd

const EXTENSION := "res://addons/crumple/crumple.gdextension"

var failures := 0
var checks := 0


func _initialize() -> void:
	test.call_deferred()


func ok(fact: bool, what: String) -> void:
	checks += 1
	if not fact:
		failures += 1
		printerr("reload: not so: %s" % what)


func test() -> void:
	var Sheet: GDScript = load("res://tests/sheet.gd")
	# By name: this script must not hold on to the extension's classes.
	var nodes: Array[MeshInstance3D] = []
	var shared: Resource = ClassDB.class_call_static("CrumpleExampleSet", "from_mesh", Sheet.mesh())
	for i in 3:
		var node: MeshInstance3D = ClassDB.instantiate("CrumpleMeshInstance3D")
		node.set("example_set", shared)
		node.set("yield_impulse", 0.5)
		root.add_child(node)
		nodes.append(node)
	nodes[0].call("add_displacement", Vector3.ZERO, Vector3(0, -0.03, 0))
	nodes[1].call("add_displacement", Vector3(0.2, 0, 0), Vector3(0, -0.02, 0))
	for node in nodes:
		node.call("update_now")
	for round in 2:
		var damage := nodes.map(func(node: Node) -> PackedByteArray: return node.call("save_damage"))
		var centre: Vector3 = nodes[0].call("get_vertex", 20 * 41 + 20)
		ok(centre.y < -0.01, "the first node is dented")
		var status := GDExtensionManager.reload_extension(EXTENSION)
		ok(status == GDExtensionManager.LOAD_STATUS_OK, "the extension is loaded again: status %d" % status)
		await process_frame
		await process_frame
		for i in nodes.size():
			var node := nodes[i]
			ok(node.get_class() == "CrumpleMeshInstance3D", "node %d has its class" % i)
			ok(node.get("yield_impulse") == 0.5, "node %d has its properties" % i)
			ok(node.get("example_set") == shared, "node %d has its set" % i)
			ok(node.has_method("get_problem") and node.call("get_problem") == "", "node %d dents" % i)
			ok(node.call("save_damage") == damage[i], "node %d has its damage" % i)
			ok(node.mesh != null and node.mesh.get_surface_count() == 1, "node %d shows a mesh" % i)
		ok(nodes[0].call("get_vertex", 20 * 41 + 20) == centre, "the first node's dent is where it was")
		ok(nodes[0].mesh != shared.call("get_pristine_mesh"), "the first node shows it on a mesh of its own")
		# It goes on. The next reload comes before this hit is shown.
		var result: Dictionary = nodes[2].call("add_displacement", Vector3(0.1, 0, 0.1), Vector3(0, -0.01 * (round + 1), 0))
		ok(result.get("status") == 0, "hits still dent: %s" % result)
	for node in nodes:
		node.free()
	print("%d checks, %d failed" % [checks, failures])
	quit(0 if failures == 0 else 1)
