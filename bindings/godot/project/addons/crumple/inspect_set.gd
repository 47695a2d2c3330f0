@tool
extends EditorInspectorPlugin
## Shows in the inspector what an example set holds, and how well its examples predict each other.


func _can_handle(object: Object) -> bool:
	return object is CrumpleExampleSet


func _parse_begin(object: Object) -> void:
	var label := Label.new()
	label.text = describe(object)
	label.autowrap_mode = TextServer.AUTOWRAP_WORD_SMART
	add_custom_control(label)


static func describe(examples: CrumpleExampleSet) -> String:
	var problem := examples.get_problem()
	if problem != "":
		return "Not usable: %s." % problem
	var lines := PackedStringArray()
	lines.append("%d examples, %d vertices, up to %.1f mm deep." % [
		examples.get_example_count(), examples.get_vertex_count(), 1000 * examples.get_deepest()])
	lines.append("Error when each example is predicted from the others, median: %.2f (0 is perfect, 1 is no dent)." %
		examples.get_own_error())
	if not examples.knows_blows():
		lines.append("No example knows its blow: depth is impulse * duration / vertex mass of the node.")
	for example: Dictionary in examples.get_examples():
		lines.append("%s: %.1f mm deep, radius %.2f m, at %s, error %.2f" % [
			example.name, 1000 * example.depth, example.radius, example.contact, example.error])
	return "\n".join(lines)
