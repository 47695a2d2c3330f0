extends RefCounted
## A steel barrel made by code, with two examples of dents. Metres; it stands on the origin.

const RINGS := 40
const AROUND := 48
const RADIUS := 0.3
const HEIGHT := 0.88


static func point(r: int, i: int) -> Vector3:
	# The lid and the bottom are the rings at both ends.
	var side := clampf(float(r - 4) / (RINGS - 9), 0, 1)
	var flat := minf(minf(r / 4.0, (RINGS - 1 - r) / 4.0), 1)
	var ribs := 0.012 * exp(-pow((side - 0.33) * 22, 2)) + 0.012 * exp(-pow((side - 0.67) * 22, 2))
	var a := TAU * i / AROUND
	return Vector3(cos(a), 0, sin(a)) * (RADIUS + ribs) * flat + Vector3(0, side * HEIGHT, 0)


static func make(mass: float) -> ArrayMesh:
	var points := PackedVector3Array()
	var index := PackedInt32Array()
	for r in RINGS:
		for i in AROUND + 1:
			points.append(point(r, i))
			if r < RINGS - 1 and i < AROUND:
				var v := r * (AROUND + 1) + i
				index.append_array([v, v + 1, v + AROUND + 1, v + 1, v + AROUND + 2, v + AROUND + 1])
	var mesh := ArrayMesh.new()
	mesh.blend_shape_mode = Mesh.BLEND_SHAPE_MODE_NORMALIZED
	var shapes: Array[Array] = []
	var impacts := []
	for height: float in [0.44, 0.75]:
		var at := Vector3(RADIUS, height, 0)
		var moved := points.duplicate()
		for v in points.size():
			var d := points[v] - at
			var r := Vector2(d.z / 0.24, d.y / 0.34).length()
			if r < 1 and points[v].x > 0:
				moved[v].x -= 0.16 * pow(1 - r * r, 2) * (1 + 0.2 * sin(20 * d.y))
		mesh.add_blend_shape("side %.2f" % height)
		shapes.append(arrays(moved, index))
		impacts.append({point = [at.x, at.y, at.z], normal = [1, 0, 0], impulse = [-8 * mass, 0, 0],
			striker = {mass = mass, velocity = [-8, 0, 0]}})
	var base := arrays(points, index)
	base[Mesh.ARRAY_INDEX] = index
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, base, shapes)
	mesh.set_meta("extras", {impacts = impacts})
	return mesh


static func arrays(points: PackedVector3Array, index: PackedInt32Array) -> Array:
	var sums := PackedVector3Array()
	sums.resize(points.size())
	for t in range(0, index.size(), 3):
		var a := points[index[t]]
		var n := (points[index[t + 2]] - a).cross(points[index[t + 1]] - a)
		for k in 3:
			sums[index[t + k]] += n
	for r in RINGS:
		var first := r * (AROUND + 1)
		var both := sums[first] + sums[first + AROUND]
		sums[first] = both
		sums[first + AROUND] = both
	for v in sums.size():
		sums[v] = sums[v].normalized() if sums[v].length() > 1e-12 else Vector3.UP
	var all := []
	all.resize(Mesh.ARRAY_MAX)
	all[Mesh.ARRAY_VERTEX] = points
	all[Mesh.ARRAY_NORMAL] = sums
	return all
