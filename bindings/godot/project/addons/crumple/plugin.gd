@tool
extends EditorPlugin
## Adds Crumple's importer and its view of example sets to the editor.

const Importer := preload("import_crumple.gd")
const Inspector := preload("inspect_set.gd")
const Quantized := preload("read_quantized.gd")

var importer: EditorImportPlugin
var inspector: EditorInspectorPlugin
var quantized: GLTFDocumentExtension


func _enter_tree() -> void:
	importer = Importer.new()
	add_import_plugin(importer)
	inspector = Inspector.new()
	add_inspector_plugin(inspector)
	quantized = Quantized.new()
	GLTFDocument.register_gltf_document_extension(quantized)


func _exit_tree() -> void:
	remove_import_plugin(importer)
	remove_inspector_plugin(inspector)
	GLTFDocument.unregister_gltf_document_extension(quantized)
	importer = null
	inspector = null
	quantized = null
