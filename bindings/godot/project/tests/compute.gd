extends Node
## Vertices written by compute shaders into buffers of the game, on a device of its own and on the one that draws.

const Sheet := preload("res://tests/sheet.gd")
## Bytes of a vertex: position, normal, tangent, and 4 that nobody writes.
const STRIDE := 44
const PLACES: Array[Vector2i] = [Vector2i(8, STRIDE), Vector2i(20, STRIDE), Vector2i(32, STRIDE)]

var t: Node


## A buffer of the device, filled with 0xff.
func make(rd: RenderingDevice, size: int) -> RID:
	var poison := PackedByteArray()
	poison.resize(size)
	poison.fill(0xff)
	return rd.storage_buffer_create(size, poison)


## What the main device does on its own thread, if it has one.
func on_device(work: Callable) -> Variant:
	var results := []
	RenderingServer.call_on_render_thread(func() -> void: results.append(work.call()))
	RenderingServer.force_sync()
	return results[0]


func read(rd: RenderingDevice, buffer: RID, local: bool) -> PackedByteArray:
	if local:
		rd.submit()
		rd.sync()
		return rd.buffer_get_data(buffer)
	return on_device(rd.buffer_get_data.bind(buffer))


func release(rd: RenderingDevice, buffer: RID, local: bool) -> void:
	if local:
		rd.free_rid(buffer)
	else:
		on_device(rd.free_rid.bind(buffer))


## The first `width` bytes of each vertex from `first` on.
func values(data: PackedByteArray, first: int, count: int, width: int) -> PackedByteArray:
	var found := PackedByteArray()
	for v in count:
		found.append_array(data.slice(first + v * STRIDE, first + v * STRIDE + width))
	return found


## Every float of the buffer equals the processor's, bit for bit, and the bytes between vertices are untouched.
func compare(writer: CrumpleComputeWriter, data: PackedByteArray, targets: Array, counts: Array, firsts: Array, what: String) -> void:
	var untouched := 0
	for i in targets.size():
		var wanted := writer.compute_expected(targets[i])
		t.same(wanted.size(), data.size(), "%s: the size of what is expected" % what)
		var same := values(data, firsts[i], counts[i], 40) == values(wanted, firsts[i], counts[i], 40)
		t.ok(same, "%s: target %d has the processor's bits" % [what, i])
		untouched += values(data, firsts[i] + 40, counts[i], 4).count(0xff)
	t.same(untouched, 4 * counts.reduce(func(a: int, b: int) -> int: return a + b), "%s: bytes left alone" % what)


func frames(rd: RenderingDevice, local: bool) -> void:
	var what := "a local device" if local else "the main device"
	# Both meshes are made of two surfaces. The second has other vertices, and another storage of examples.
	var nodes: Array[CrumpleMeshInstance3D] = []
	for side: int in [41, 21]:
		nodes.append(Sheet.node(self, Sheet.mesh(Mesh.BLEND_SHAPE_MODE_RELATIVE, 2, true, side)))
	var counts: Array[int] = []
	var firsts: Array[int] = []
	var size := 0
	for node in nodes:
		counts.append(node.example_set.get_vertex_count())
		firsts.append(size + 8)
		size += 8 + counts[-1] * STRIDE
	var buffer := make(rd, size)
	var writer := CrumpleComputeWriter.create(rd)
	var targets: Array[int] = []
	for i in nodes.size():
		var at := Vector2i(firsts[i] - 8, 0)
		targets.append(writer.add_target(nodes[i], buffer, size, PLACES[0] + at, PLACES[1] + at, PLACES[2] + at))
	var pristine := PackedByteArray()
	for frame in 5:
		var wrote := writer.write()
		var data := read(rd, buffer, local)
		compare(writer, data, targets, counts, firsts, "%s, frame %d" % [what, frame])
		if frame == 0:
			t.same(wrote, counts[0] + counts[1], "%s: the first frame writes all vertices" % what)
			# Not by the same code: these are the floats that Godot has.
			var floats := data.slice(firsts[0], firsts[0] + 12).to_float32_array()
			var first: Vector3 = nodes[0].mesh.surface_get_arrays(0)[Mesh.ARRAY_VERTEX][0]
			t.same(Vector3(floats[0], floats[1], floats[2]), first, "%s: the first vertex" % what)
			pristine = data
		elif frame == 3:
			t.same(wrote, 0, "%s: nothing is written where nothing changed" % what)
		elif frame < 3:
			t.ok(wrote > 0 and data != pristine, "%s: frame %d wrote dents" % [what, frame])
			var points := values(data, firsts[0], counts[0], 12).to_float32_array()
			for v in counts[0]:
				var p := Vector3(points[3 * v], points[3 * v + 1], points[3 * v + 2])
				if p != nodes[0].get_vertex(v):
					t.same(p, nodes[0].get_vertex(v), "%s: vertex %d" % [what, v])
					break
		else:
			t.ok(data == pristine, "%s: repaired, all is as it was" % what)
		if frame == 0:
			nodes[0].add_displacement(Vector3(0.1, 0, 0.1), Vector3(0, -0.03, 0))
		elif frame == 1:
			nodes[0].add_displacement(Vector3(-0.2, 0, -0.1), Vector3(0, -0.02, 0.01))
			nodes[1].add_displacement(Vector3(0, 0, -0.1), Vector3(0, -0.04, 0))
		elif frame == 3:
			nodes[0].repair()
			nodes[1].repair()
	# A target of a freed node goes, and so does its storage.
	nodes[1].free()
	nodes[0].add_displacement(Vector3.ZERO, Vector3(0, -0.03, 0))
	t.ok(writer.write() > 0, "%s: the other node is written after one was freed" % what)
	compare(writer, read(rd, buffer, local), [targets[0]], [counts[0]], [firsts[0]], "%s, after one was freed" % what)
	writer.remove_target(targets[0])
	t.same(writer.write(), 0, "%s: without targets nothing is written" % what)
	writer = null
	release(rd, buffer, local)
	nodes[0].free()


func test_the_main_device_writes_the_vertices() -> void:
	frames(RenderingServer.get_rendering_device(), false)
	await RenderingServer.frame_post_draw


func test_a_local_device_writes_the_vertices() -> void:
	var rd := RenderingServer.create_local_rendering_device()
	frames(rd, true)
	rd.free()


func test_what_cannot_be_written_is_refused() -> void:
	t.same(CrumpleComputeWriter.create(null), null, "a writer without a device")
	var rd := RenderingServer.get_rendering_device()
	var writer := CrumpleComputeWriter.create(rd)
	var node := Sheet.node(self, Sheet.mesh())
	var size := 12 * node.example_set.get_vertex_count()
	var buffer := rd.storage_buffer_create(size)
	var place := Vector2i(0, 12)
	t.same(writer.add_target(null, buffer, size, place), 0, "no node")
	var empty := CrumpleMeshInstance3D.new()
	t.same(writer.add_target(empty, buffer, size, place), 0, "a node without examples")
	empty.free()
	t.same(writer.add_target(node, RID(), size, place), 0, "no buffer")
	t.same(writer.add_target(node, buffer, size - 4, place), 0, "a buffer that is too small")
	t.same(writer.add_target(node, buffer, size, Vector2i(0, 10)), 0, "a stride that is too small")
	t.same(writer.add_target(node, buffer, size, Vector2i(-4, 12)), 0, "an offset below 0")
	t.same(writer.add_target(node, buffer, size, Vector2i.ZERO), 0, "no positions")
	t.same(writer.compute_expected(1), PackedByteArray(), "a target that does not exist")
	var target := writer.add_target(node, buffer, size, place)
	t.ok(target > 0, "a target that is right")
	var before := node.example_set
	node.example_set = CrumpleExampleSet.from_mesh(Sheet.mesh())
	t.same(writer.write(), -1, "a node that got other examples")
	node.example_set = before
	t.ok(writer.write() > 0, "after errors the target is written")
	writer = null
	release(rd, buffer, false)
	node.free()
