extends RefCounted
## A sheet of metal, 1 m by 1 m in the x-z plane, with normals up and one example of a round dent 5 cm deep in the middle.

const SIDE := 41


static func mesh(mode := Mesh.BLEND_SHAPE_MODE_RELATIVE, surfaces := 1, tangents := false, side := SIDE) -> ArrayMesh:
	var sheet := ArrayMesh.new()
	sheet.add_blend_shape("dent")
	sheet.blend_shape_mode = mode
	for s in surfaces:
		var base := arrays(s, surfaces, false, tangents, side)
		var dent := arrays(s, surfaces, true, tangents, side)
		if mode == Mesh.BLEND_SHAPE_MODE_RELATIVE:
			for v in dent[Mesh.ARRAY_VERTEX].size():
				dent[Mesh.ARRAY_VERTEX][v] -= base[Mesh.ARRAY_VERTEX][v]
				dent[Mesh.ARRAY_NORMAL][v] = Vector3.ZERO
		dent[Mesh.ARRAY_INDEX] = null
		dent[Mesh.ARRAY_TEX_UV] = null
		sheet.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, base, [dent])
	return sheet


## One of several strips of the sheet.
static func arrays(strip: int, strips: int, dented: bool, tangents: bool, side := SIDE) -> Array:
	var points := PackedVector3Array()
	var normals := PackedVector3Array()
	var uvs := PackedVector2Array()
	var tangent := PackedFloat32Array()
	var index := PackedInt32Array()
	var rows := (side - 1) / strips + 1
	for j in rows:
		for i in side:
			var p := Vector3(float(i) / (side - 1) - 0.5, 0, float(j + strip * (rows - 1)) / (side - 1) - 0.5)
			uvs.append(Vector2(p.x + 0.5, p.z + 0.5))
			var r := p.length() / 0.2
			if dented and r < 1:
				p.y = -0.05 * (1 - r * r) * (1 - r * r)
			points.append(p)
			normals.append(Vector3.UP)
			tangent.append_array([1, 0, 0, -1])
			if i < side - 1 and j < rows - 1:
				var a := j * side + i
				# Clockwise from above, Godot's front.
				index.append_array([a, a + 1, a + side, a + side, a + 1, a + side + 1])
	var all := []
	all.resize(Mesh.ARRAY_MAX)
	all[Mesh.ARRAY_VERTEX] = points
	all[Mesh.ARRAY_NORMAL] = normals
	all[Mesh.ARRAY_TEX_UV] = uvs
	all[Mesh.ARRAY_INDEX] = index
	if tangents:
		all[Mesh.ARRAY_TANGENT] = tangent
	return all


static func node(parent: Node, shown: ArrayMesh) -> CrumpleMeshInstance3D:
	var made := CrumpleMeshInstance3D.new()
	made.mesh = shown
	parent.add_child(made)
	return made
