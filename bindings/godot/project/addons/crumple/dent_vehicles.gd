extends Node
## Makes vehicles dent that were not made for it. Add it as an autoload: each [VehicleBody3D] that enters the tree gets a
## [CrumpleMeshInstance3D] with round dents in place of its own meshes. Wheels stay as they are.

const RoundDents := preload("round_dents.gd")

## Edges are divided to this, m.
var edge_length := 0.07
## The number of round dents on a mesh, their radius (m) and their depth (m).
var count := 12
var radius := 0.4
var depth := 0.15
## An impulse at one point that changes the velocity of the body by this dents to [member depth], m/s.
var speed := 5.0

## The meshes with dents, by the meshes of the models.
var meshes: Dictionary[Mesh, ArrayMesh] = {}


func _enter_tree() -> void:
	get_tree().node_added.connect(_added)


func _added(node: Node) -> void:
	if node is VehicleBody3D:
		# Its children are not there yet.
		dent.call_deferred(node)


## Replaces the meshes of a body.
func dent(body: RigidBody3D) -> void:
	for child in body.get_children():
		if child is MeshInstance3D and not child is CrumpleMeshInstance3D and child.mesh is ArrayMesh:
			if not meshes.has(child.mesh):
				meshes[child.mesh] = RoundDents.add_to(child.mesh, edge_length, count, radius, depth)
			if meshes[child.mesh] == null:
				continue
			var dented := CrumpleMeshInstance3D.new()
			dented.name = "Dented" + child.name
			dented.mesh = meshes[child.mesh]
			# An impulse moves its contact by impulse * duration / vertex_mass.
			dented.vertex_mass = body.mass * speed * dented.duration / depth
			dented.transform = child.transform
			dented.layers = child.layers
			dented.material_override = child.material_override
			for surface in child.get_surface_override_material_count():
				dented.set_surface_override_material(surface, child.get_surface_override_material(surface))
			body.add_child(dented)
			child.queue_free()
