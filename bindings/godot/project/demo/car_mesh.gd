extends RefCounted
## A car's body made by code, with examples of how it crumples. Metres; the front is at -Z, and up is +Y.

const RINGS := 110
const AROUND := 72
const LENGTH := 4.2
const FLOOR := 0.32
## Height of the roof line and half width of the body at places from the front (0) to the rear (1).
const PROFILE: Array[Vector3] = [
	Vector3(0.00, 0.62, 0.70), Vector3(0.03, 0.72, 0.80), Vector3(0.10, 0.80, 0.84), Vector3(0.28, 0.92, 0.86),
	Vector3(0.44, 1.36, 0.86), Vector3(0.54, 1.42, 0.86), Vector3(0.70, 1.38, 0.86), Vector3(0.86, 0.98, 0.85),
	Vector3(0.97, 0.92, 0.82), Vector3(1.00, 0.80, 0.74),
]
const PAINT := Color(0.80, 0.10, 0.07)
const GLASS := Color(0.05, 0.06, 0.08)
const LAMP := Color(0.95, 0.93, 0.85)


static func profile(s: float) -> Vector2:
	for i in range(1, PROFILE.size()):
		var a := PROFILE[i - 1]
		var b := PROFILE[i]
		if s <= b.x:
			var f := smoothstep(0, 1, (s - a.x) / (b.x - a.x))
			return Vector2(lerpf(a.y, b.y, f), lerpf(a.z, b.z, f))
	return Vector2(PROFILE[-1].y, PROFILE[-1].z)


## A point of the body: s from the front to the rear, a around it from the left sill over the roof.
static func point(s: float, a: float) -> Vector3:
	var p := profile(s)
	# The ends are closed by smaller and smaller rings.
	var close := minf(clampf(s / 0.015, 0, 1), clampf((1 - s) / 0.015, 0, 1))
	close = sqrt(1 - (1 - close) * (1 - close))
	var low := FLOOR + 0.10
	var middle := (p.x + low) / 2
	var x := -cos(a)
	var y := sin(a)
	# A rounded rectangle.
	var power := 0.32
	x = signf(x) * pow(absf(x), power)
	y = signf(y) * pow(absf(y), power)
	# The cabin is narrower towards the roof.
	var cabin := clampf((middle + y * (p.x - low) / 2 - 0.92) / 0.5, 0, 1)
	return Vector3(x * p.y * (1 - 0.28 * cabin) * close, middle + y * (p.x - low) / 2 * close, (s - 0.5) * LENGTH)


static func base() -> Array:
	var points := PackedVector3Array()
	var colors := PackedColorArray()
	var index := PackedInt32Array()
	for r in RINGS:
		var f := float(r) / (RINGS - 1)
		# Rings are denser at the ends.
		var s := f - 0.6 * sin(TAU * f) / TAU
		for i in AROUND + 1:
			var p := point(s, TAU * i / AROUND)
			points.append(p)
			colors.append(color(p, s))
			if r < RINGS - 1 and i < AROUND:
				var v := r * (AROUND + 1) + i
				index.append_array([v, v + 1, v + AROUND + 1, v + 1, v + AROUND + 2, v + AROUND + 1])
	var all := []
	all.resize(Mesh.ARRAY_MAX)
	all[Mesh.ARRAY_VERTEX] = points
	all[Mesh.ARRAY_NORMAL] = normals(points, index)
	all[Mesh.ARRAY_COLOR] = colors
	all[Mesh.ARRAY_INDEX] = index
	return all


static func color(p: Vector3, s: float) -> Color:
	if p.y > 0.97 and p.y < 1.33 and s > 0.31 and s < 0.84:
		return GLASS
	if s < 0.03 and p.y > 0.55 and p.y < 0.70 and absf(p.x) > 0.4:
		return LAMP
	return PAINT if p.y > 0.44 else Color(0.09, 0.09, 0.1)


static func normals(points: PackedVector3Array, index: PackedInt32Array) -> PackedVector3Array:
	var sums := PackedVector3Array()
	sums.resize(points.size())
	for t in range(0, index.size(), 3):
		var a := points[index[t]]
		# Godot's front faces are clockwise.
		var n := (points[index[t + 2]] - a).cross(points[index[t + 1]] - a)
		for k in 3:
			sums[index[t + k]] += n
	# The seam below.
	for r in RINGS:
		var first := r * (AROUND + 1)
		var both := sums[first] + sums[first + AROUND]
		sums[first] = both
		sums[first + AROUND] = both
	for v in sums.size():
		sums[v] = sums[v].normalized() if sums[v].length() > 1e-12 else Vector3.FORWARD
	return sums


## Buckled sheet metal: a bowl with a raised rim and folds across it.
static func dent(p: Vector3, centre: Vector3, into: Vector3, radius: float, depth: float) -> Vector3:
	var d := p - centre
	var r := d.length() / radius
	if r >= 1:
		return Vector3.ZERO
	var bowl := (1 - r * r) * (1 - r * r)
	var fold := 0.22 * sin(9 * (d.x + 0.6 * d.y + 0.8 * d.z) / radius) * bowl * r
	return into * depth * (bowl + fold)


## The front runs into something: it shortens, the hood folds upwards, and the fenders bulge.
static func crush(p: Vector3, x: float, depth: float) -> Vector3:
	var from_front := p.z + LENGTH / 2
	var across := absf(p.x - x) / 0.95
	if from_front > 1.25 or across > 1:
		return Vector3.ZERO
	var near := 1 - from_front / 1.25
	var width := pow(1 - across * across, 1.5)
	var shorter := depth * width * pow(near, 1.6)
	var top := clampf((p.y - 0.62) / 0.2, 0, 1)
	var up := 0.45 * depth * width * top * sin(PI * clampf(near * 1.05, 0, 1)) * (1 + 0.35 * sin(10 * near))
	var side := 0.16 * depth * sin(PI * near) * signf(p.x) * clampf(absf(p.x) / 0.8, 0, 1) * width
	return Vector3(side, up, shorter)


## The examples: name, contact, how the body moves there, and the impulse that did it (N s) at 8 m/s.
static func examples() -> Array[Dictionary]:
	var front := -LENGTH / 2
	return [
		{name = "front", at = Vector3(0, 0.60, front), into = Vector3.BACK, depth = 0.42, crush = 0.0},
		{name = "front left", at = Vector3(-0.6, 0.60, front), into = Vector3.BACK, depth = 0.46, crush = -0.6},
		{name = "front right", at = Vector3(0.6, 0.60, front), into = Vector3.BACK, depth = 0.46, crush = 0.6},
		{name = "rear", at = Vector3(0, 0.65, -front), into = Vector3.FORWARD, depth = 0.3, radius = 0.8},
		{name = "door", at = Vector3(-0.84, 0.70, 0.1), into = Vector3.RIGHT, depth = 0.22, radius = 0.65},
		{name = "fender", at = Vector3(0.84, 0.65, -1.2), into = Vector3.LEFT, depth = 0.2, radius = 0.5},
		{name = "roof", at = Vector3(0, 1.41, 0.2), into = Vector3.DOWN, depth = 0.2, radius = 0.6},
		{name = "hood", at = Vector3(0.1, 0.86, -1.2), into = Vector3.DOWN, depth = 0.16, radius = 0.5},
	]


## The body with one blend shape for each example, and what the examples know of their blows.
static func make(mass: float) -> ArrayMesh:
	var arrays := base()
	var points: PackedVector3Array = arrays[Mesh.ARRAY_VERTEX]
	var mesh := ArrayMesh.new()
	mesh.blend_shape_mode = Mesh.BLEND_SHAPE_MODE_NORMALIZED
	var shapes: Array[Array] = []
	var impacts := []
	for e in examples():
		mesh.add_blend_shape(e.name)
		var moved := points.duplicate()
		for v in points.size():
			if e.has("crush"):
				moved[v] += crush(points[v], e.crush, e.depth)
			else:
				moved[v] += dent(points[v], e.at, e.into, e.radius, e.depth)
		var shape := []
		shape.resize(Mesh.ARRAY_MAX)
		shape[Mesh.ARRAY_VERTEX] = moved
		shape[Mesh.ARRAY_NORMAL] = normals(moved, arrays[Mesh.ARRAY_INDEX])
		shapes.append(shape)
		var list := func(v: Vector3) -> Array: return [v.x, v.y, v.z]
		impacts.append({
			name = e.name, point = list.call(e.at), normal = list.call(-e.into), impulse = list.call(8 * mass * e.into),
			striker = {mass = mass, velocity = list.call(8 * e.into)},
		})
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, shapes)
	mesh.set_meta("extras", {impacts = impacts})
	return mesh
