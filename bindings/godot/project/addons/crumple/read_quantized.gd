@tool
extends GLTFDocumentExtension
## Godot 4.6 decodes the bytes and shorts of KHR_mesh_quantization, but refuses files that require it. With this it reads them.


func _get_supported_extensions() -> PackedStringArray:
	return ["KHR_mesh_quantization"]
