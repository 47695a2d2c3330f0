@tool
extends EditorPlugin
## Adds Crumple's importer and its view of example sets to the editor.

const Importer := preload("import_crumple.gd")
const Inspector := preload("inspect_set.gd")

var importer: EditorImportPlugin
var inspector: EditorInspectorPlugin


func _enter_tree() -> void:
	importer = Importer.new()
	add_import_plugin(importer)
	inspector = Inspector.new()
	add_inspector_plugin(inspector)


func _exit_tree() -> void:
	remove_import_plugin(importer)
	remove_inspector_plugin(inspector)
	importer = null
	inspector = null
