extends Node
## Runs every method of the scripts beside it whose name begins with "test_", and ends with 1 if one fails.
## Arguments after "--": names of scripts to run.

var failures := 0
var checks := 0
var running := ""


func _ready() -> void:
	var scripts := OS.get_cmdline_user_args()
	for script: String in scripts:
		var code: GDScript = load("res://tests/%s.gd" % script)
		if code == null or not code.can_instantiate():
			ok(false, "%s.gd can be run" % script)
			continue
		var suite: Node = code.new()
		suite.set("t", self)
		add_child(suite)
		for method in suite.get_method_list():
			if not method.name.begins_with("test_"):
				continue
			running = "%s.%s" % [script, method.name]
			var before := failures
			await suite.call(method.name)
			print("%s %s" % ["ok    " if failures == before else "FAILED", running])
		suite.free()
	print("%d checks, %d failed" % [checks, failures])
	get_tree().quit(0 if failures == 0 and checks > 0 else 1)


func ok(fact: bool, what: String) -> void:
	checks += 1
	if not fact:
		failures += 1
		printerr("%s: not so: %s" % [running, what])


func same(found: Variant, wanted: Variant, what: String) -> void:
	ok(found == wanted, "%s is %s; it should be %s" % [what, found, wanted])


func near(found: Variant, wanted: Variant, tolerance: float, what: String) -> void:
	var distance: float = (found - wanted).length() if found is Vector3 else absf(found - wanted)
	ok(distance <= tolerance, "%s is %s; it should be %s, give or take %s" % [what, found, wanted, tolerance])
