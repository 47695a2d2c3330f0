# Reads a glTF with Godot, without its pictures, which need a screen, and writes it with Godot's exporter.
#
# godot --headless --script godot.gd -- IN.glb OUT.glb
extends SceneTree


func _initialize() -> void:
	var paths := OS.get_cmdline_user_args()
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	state.handle_binary_image = GLTFState.HANDLE_BINARY_DISCARD_TEXTURES
	var read := document.append_from_file(paths[0], state)
	var scene := document.generate_scene(state)
	# The editor does this when it imports a file.
	for importer: ImporterMeshInstance3D in scene.find_children("*", "ImporterMeshInstance3D", true, false):
		var shown := MeshInstance3D.new()
		shown.name = importer.name
		shown.transform = importer.transform
		shown.mesh = importer.mesh.get_mesh()
		importer.replace_by(shown)
		importer.free()
	document = GLTFDocument.new()
	state = GLTFState.new()
	var appended := document.append_from_scene(scene, state)
	var written := document.write_to_filesystem(state, paths[1])
	scene.free()
	quit(0 if [read, appended, written] == [OK, OK, OK] else 1)
