extends Node
## Two processes: the server's damage reaches the client by a MultiplayerSynchronizer, and comes back as the same bytes.
## Arguments after "--": "server" or "client", and the port.

const Sheet := preload("res://tests/sheet.gd")
const PATIENCE := 30.0

var sheet: CrumpleMeshInstance3D
var server := false


func _ready() -> void:
	var arguments := OS.get_cmdline_user_args()
	server = arguments[0] == "server"
	var port := int(arguments[1])
	sheet = CrumpleMeshInstance3D.new()
	sheet.name = "Sheet"
	sheet.mesh = Sheet.mesh()
	var synchronizer := MultiplayerSynchronizer.new()
	synchronizer.name = "Synchronizer"
	synchronizer.replication_config = SceneReplicationConfig.new()
	synchronizer.replication_config.add_property(^".:damage")
	synchronizer.replication_config.property_set_replication_mode(
		^".:damage", SceneReplicationConfig.REPLICATION_MODE_ON_CHANGE)
	sheet.add_child(synchronizer)
	add_child(sheet)
	var peer := ENetMultiplayerPeer.new()
	if server:
		peer.set_bind_ip("127.0.0.1")
		end_if(peer.create_server(port, 1) != OK, "the server cannot listen")
		multiplayer.peer_connected.connect(hit)
	else:
		end_if(peer.create_client("127.0.0.1", port) != OK, "the client cannot begin")
	multiplayer.multiplayer_peer = peer
	get_tree().create_timer(PATIENCE).timeout.connect(end_if.bind(true, "nothing came"))


func end_if(failed: bool, why: String) -> void:
	if failed:
		printerr(why)
		get_tree().quit(1)


func hit(_client: int) -> void:
	for x: float in [-0.3, 0.0, 0.3]:
		sheet.add_displacement(Vector3(x, 0, x), Vector3(0, -0.03, 0))


func _process(_step: float) -> void:
	if not server and sheet.get_mark_count() == 3:
		received.rpc_id(1, sheet.damage, sheet.get_vertex(0))
		set_process(false)


@rpc("any_peer", "reliable")
func received(damage: PackedByteArray, vertex: Vector3) -> void:
	var same := damage == sheet.damage and vertex == sheet.get_vertex(0)
	print("the client has %s damage, %d bytes" % ["the same" if same else "other", damage.size()])
	finish.rpc()
	await get_tree().create_timer(0.2).timeout
	get_tree().quit(0 if same else 1)


@rpc("authority", "reliable")
func finish() -> void:
	get_tree().quit()
