@tool
extends EditorImportPlugin
## Imports .crumple files, which the `crumple` command and CrumpleExampleSet.save_file write, as example sets.


func _get_importer_name() -> String:
	return "crumple.example_set"


func _get_visible_name() -> String:
	return "Crumple Example Set"


func _get_recognized_extensions() -> PackedStringArray:
	return ["crumple"]


func _get_save_extension() -> String:
	return "res"


func _get_resource_type() -> String:
	return "CrumpleExampleSet"


func _get_priority() -> float:
	return 1.0


func _get_import_order() -> int:
	return 0


func _get_preset_count() -> int:
	return 0


func _get_import_options(_path: String, _preset: int) -> Array[Dictionary]:
	return []


func _get_option_visibility(_path: String, _option: StringName, _options: Dictionary) -> bool:
	return true


func _import(source: String, save: String, _options: Dictionary, _variants: Array[String], _files: Array[String]) -> Error:
	var examples := CrumpleExampleSet.load_file(source)
	if examples == null:
		return ERR_INVALID_DATA
	return ResourceSaver.save(examples, "%s.%s" % [save, _get_save_extension()])
