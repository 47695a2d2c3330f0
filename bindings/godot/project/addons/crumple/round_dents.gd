extends RefCounted
## Gives a mesh round dents as examples, so that a model without examples dents at once. Dents that are sculpted or simulated
## look better: this is a start.


## Returns a copy of [param mesh] with [param count] examples, spread over its surface. Its edges are divided to
## [param edge_length]; a third of [param radius] shows a dent well. All lengths are in metres.
static func add_to(mesh: ArrayMesh, edge_length: float, count := 8, radius := 0.4, depth := 0.15) -> ArrayMesh:
	var fine := CrumpleExampleSet.divide_mesh(mesh, edge_length)
	if fine == null:
		return null
	var surfaces: Array[Array] = []
	for s in fine.get_surface_count():
		surfaces.append(fine.surface_get_arrays(s))
	var dented := ArrayMesh.new()
	dented.blend_shape_mode = Mesh.BLEND_SHAPE_MODE_NORMALIZED
	var spots := spread(surfaces, count)
	for i in spots.size():
		dented.add_blend_shape("round dent %d" % (i + 1))
	for s in surfaces.size():
		var shapes: Array[Array] = []
		for spot in spots:
			shapes.append(shape(surfaces[s], spot[0], spot[1], radius, depth))
		var custom := fine.surface_get_format(s) & (0xfff << Mesh.ARRAY_FORMAT_CUSTOM_BASE)
		dented.add_surface_from_arrays(fine.surface_get_primitive_type(s), surfaces[s], shapes, {}, custom)
		dented.surface_set_material(s, fine.surface_get_material(s))
		dented.surface_set_name(s, fine.surface_get_name(s))
	return dented


## Vertices far from each other, each with its normal.
static func spread(surfaces: Array[Array], count: int) -> Array[Array]:
	var points := PackedVector3Array()
	var normals := PackedVector3Array()
	for arrays in surfaces:
		if arrays[Mesh.ARRAY_NORMAL] != null:
			points.append_array(arrays[Mesh.ARRAY_VERTEX])
			normals.append_array(arrays[Mesh.ARRAY_NORMAL])
	var distances := PackedFloat32Array()
	distances.resize(points.size())
	distances.fill(INF)
	var found: Array[Array] = []
	var next := 0
	while found.size() < count and points.size() > 0:
		found.append([points[next], normals[next]])
		var from := points[next]
		for v in points.size():
			distances[v] = minf(distances[v], points[v].distance_squared_to(from))
		for v in points.size():
			if distances[v] > distances[next]:
				next = v
		if distances[next] == 0:
			break
	return found


static func shape(arrays: Array, at: Vector3, normal: Vector3, radius: float, depth: float) -> Array:
	var points: PackedVector3Array = arrays[Mesh.ARRAY_VERTEX].duplicate()
	var moved := false
	for v in points.size():
		var r := points[v].distance_to(at) / radius
		if r < 1:
			points[v] -= normal * depth * (1 - r * r) * (1 - r * r)
			moved = true
	var all := []
	all.resize(Mesh.ARRAY_MAX)
	all[Mesh.ARRAY_VERTEX] = points
	if arrays[Mesh.ARRAY_NORMAL] != null:
		all[Mesh.ARRAY_NORMAL] = turned(arrays, points) if moved else arrays[Mesh.ARRAY_NORMAL]
	all[Mesh.ARRAY_TANGENT] = arrays[Mesh.ARRAY_TANGENT]
	return all


## The normals, turned as the triangles around each vertex turn.
static func turned(arrays: Array, points: PackedVector3Array) -> PackedVector3Array:
	var before := sums(arrays, arrays[Mesh.ARRAY_VERTEX])
	var after := sums(arrays, points)
	var normals: PackedVector3Array = arrays[Mesh.ARRAY_NORMAL].duplicate()
	for v in normals.size():
		if before[v] != after[v] and before[v].length() > 1e-12 and after[v].length() > 1e-12:
			normals[v] = (Quaternion(before[v].normalized(), after[v].normalized()) * normals[v]).normalized()
	return normals


static func sums(arrays: Array, points: PackedVector3Array) -> PackedVector3Array:
	var all := PackedVector3Array()
	all.resize(points.size())
	var index: PackedInt32Array
	if arrays[Mesh.ARRAY_INDEX] != null:
		index = arrays[Mesh.ARRAY_INDEX]
	else:
		index = PackedInt32Array(range(points.size()))
	for t in range(0, index.size() - 2, 3):
		var a := points[index[t]]
		var n := (points[index[t + 2]] - a).cross(points[index[t + 1]] - a)
		for k in 3:
			all[index[t + k]] += n
	return all
