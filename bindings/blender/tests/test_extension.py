"""Runs in bpy, where the packed extension is installed first: CRUMPLE_EXTENSION names its .zip."""

import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[3]
SIDE = 31


@pytest.fixture(scope="session", autouse=True)
def extension():
    bpy.ops.extensions.package_install_files(filepath=os.environ["CRUMPLE_EXTENSION"], repo="user_default", enable_on_install=True)
    assert "bl_ext.user_default.crumple" in bpy.context.preferences.addons


@pytest.fixture
def sheet():
    """A bare sheet of 1 m."""
    bpy.data.batch_remove([*bpy.data.objects, *bpy.data.meshes])
    bpy.context.scene.cursor.location = (0, 0, 0)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=SIDE - 1, y_subdivisions=SIDE - 1, size=1)
    bpy.context.object.name = bpy.context.object.data.name = "Sheet"
    return bpy.context.object


def dent(obj, name, at, depth=0.05, radius=0.2):
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name=name, from_mix=False)
    key.value = 0
    base = positions(obj.data.shape_keys.reference_key)
    away = np.linalg.norm(base - at, axis=1) / radius
    base[:, 2] -= depth * np.maximum(0, 1 - away**2) ** 2
    key.points.foreach_set("co", base.ravel())
    obj.active_shape_key_index = len(obj.data.shape_keys.key_blocks) - 1
    return key


def positions(key):
    out = np.empty(3 * len(key.points), np.float32)
    key.points.foreach_get("co", out)
    return out.reshape(-1, 3)


def damage(obj):
    return positions(obj.data.shape_keys.key_blocks["Crumple damage"]) - positions(obj.data.shape_keys.reference_key)


def report():
    return bpy.data.texts["Crumple report"].as_string()


@pytest.fixture
def dentable(sheet):
    dent(sheet, "left", (-0.25, 0, 0))
    dent(sheet, "right", (0.25, 0.1, 0), 0.03)
    return sheet


def test_hits_are_the_librarys_dents_and_undo(dentable):
    import crumple

    bpy.ops.crumple.hit(location=(0, -0.2, 0), depth=0.02)
    bpy.ops.crumple.hit(location=(0.1, 0.3, 0), direction=(0, 0, -1), depth=0.03)
    base, triangles = positions(dentable.data.shape_keys.reference_key), np.zeros(3 * len(dentable.data.loop_triangles), np.int32)
    dentable.data.loop_triangles.foreach_get("vertices", triangles)
    with crumple.Context() as context:
        examples = [crumple.Example(positions(dentable.data.shape_keys.key_blocks[name]), name=name) for name in ("left", "right")]
        body = context.example_set(base, triangles.reshape(-1, 3), examples).instance()
        body.hit_displacement((0, -0.2, 0), (0, 0, -0.02))
        body.hit_displacement((0.1, 0.3, 0), (0, 0, -0.03))
        assert np.abs(body.deformed().positions - base - damage(dentable)).max() < 1e-7
    assert -0.031 < damage(dentable)[:, 2].min() < -0.029
    bpy.ops.crumple.clear(index=1)
    assert len(dentable.crumple_hits) == 1 and -0.021 < damage(dentable)[:, 2].min() < -0.019
    bpy.ops.ed.undo_push(message="one hit")
    bpy.ops.crumple.hit(location=(0.1, 0.3, 0), depth=0.03)
    bpy.ops.ed.undo_push(message="two hits")
    bpy.ops.ed.undo()
    again = bpy.data.objects["Sheet"]
    assert len(again.crumple_hits) == 1 and damage(again)[:, 2].min() > -0.021
    bpy.ops.crumple.clear()
    assert "Crumple damage" not in again.data.shape_keys.key_blocks and not again.crumple_hits


def test_hits_follow_the_objects_transform(dentable):
    dentable.rotation_euler, dentable.location = (0, np.pi / 2, 0), (1, 2, 3)
    bpy.context.view_layer.update()
    place = dentable.matrix_world @ dentable.data.vertices[SIDE * SIDE // 2].co
    bpy.ops.crumple.hit(location=place, direction=(-1, 0, 0), depth=0.02)
    assert abs(np.abs(damage(dentable)).max() - 0.02) < 1e-4


def test_wrong_meshes_get_a_message_and_lose_nothing(sheet):
    with pytest.raises(RuntimeError, match="has no examples"):
        bpy.ops.crumple.hit(location=(0, 0, 0))
    dent(sheet, "dent", (0, 0, 0))
    with pytest.raises(RuntimeError, match="leaves no dent"):
        bpy.ops.crumple.hit(location=(0, 0, 0), direction=(0, 0, 1))
    with pytest.raises(RuntimeError, match="max_contact_distance"):
        bpy.ops.crumple.hit(location=(50, 0, 0))
    sheet.data["impacts"] = "[nonsense"
    with pytest.raises(RuntimeError, match="is no JSON"):
        bpy.ops.crumple.hit(location=(0, 0, 0))
    assert len(sheet.crumple_hits) == 0 and len(sheet.data.shape_keys.key_blocks) == 2
    with pytest.raises(RuntimeError, match="must end in .glb or .crumple"):
        bpy.ops.crumple.export(filepath="/nowhere/sheet.fbx")


def test_baked_hits_are_keyed_and_add_up(dentable):
    for frame, x in ((10, -0.1), (20, 0.2)):
        bpy.context.scene.frame_set(frame)
        bpy.ops.crumple.hit(location=(x, 0.2, 0), depth=0.02)
    whole = damage(dentable)
    bpy.ops.crumple.bake()
    keys = dentable.data.shape_keys.key_blocks
    assert "Crumple damage" not in keys
    for frame, shown in ((9, 0), (10, 1), (19, 1), (20, 2)):
        bpy.context.scene.frame_set(frame)
        shown_mesh = dentable.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        assert [keys["Crumple damage 10"].value, keys["Crumple damage 20"].value] == [float(shown > 0), float(shown > 1)]
    moved = np.array([vertex.co for vertex in shown_mesh.vertices]) - positions(keys[0])
    assert np.abs(moved - whole).max() < 1e-6
    bpy.ops.crumple.clear()
    assert len(keys) == 3


def rigid(obj, kind, shape, mass=1.0):
    bpy.context.view_layer.objects.active = obj
    bpy.ops.rigidbody.object_add(type=kind)
    obj.rigid_body.collision_shape, obj.rigid_body.mass = shape, mass


def ball(location, radius=0.1):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=location, segments=24, ring_count=16)
    return bpy.context.object


def test_hits_of_the_scenes_rigid_bodies(dentable):
    scene, sheet = bpy.context.scene, dentable
    scene.frame_end = 40

    def hits(**settings):
        bpy.context.view_layer.objects.active = sheet
        bpy.ops.crumple.rigid_bodies(**settings)
        return [(hit.frame, np.array(hit.point), np.array(hit.vector), hit.mass, hit.radius) for hit in sheet.crumple_hits]

    with pytest.raises(RuntimeError, match="do not know their blows"):
        hits()
    for index in (1, 2):
        sheet.active_shape_key_index = index
        bpy.ops.crumple.mark(mass=5, speed=4, radius=0.1)
    with pytest.raises(RuntimeError, match="no rigid bodies"):
        hits()
    # A ball falls 1 m onto the fixed sheet. Its lower end reaches it after sqrt(2 / 9.81) s, which is 10.8 frames, at 4.43 m/s.
    sheet.location, sheet.rotation_euler = (1, 2, 3), (0, 0, np.pi / 2)
    rigid(sheet, "PASSIVE", "MESH")
    with pytest.raises(RuntimeError, match="no other mesh is a rigid body"):
        hits()
    falling = ball((1.1, 2.2, 4.1))
    rigid(falling, "ACTIVE", "SPHERE", 3.0)
    scene.frame_set(7)
    ((frame, point, velocity, mass, radius),) = hits()
    assert (frame, scene.frame_current) == (12, 7) and np.abs(point - [0.2, -0.1, 0]).max() < 0.02
    assert np.abs(velocity - [0, 0, -4.43]).max() < 0.15 and abs(mass - 3) < 0.1 and abs(radius - 0.1) < 1e-3
    assert 0.005 < np.abs(damage(sheet)).max() < 0.1
    bpy.ops.crumple.bake()
    assert "Crumple damage 12" in sheet.data.shape_keys.key_blocks
    # The same beside the sheet, and too slow.
    falling.location.x = 2.2
    with pytest.raises(RuntimeError, match="nothing hits Sheet at 1 m/s"):
        hits()
    falling.location.x = 1.1
    with pytest.raises(RuntimeError, match="nothing hits Sheet at 5 m/s"):
        hits(slowest=5)
    # The sheet falls upside down upon a fixed ball: half of its mass or less acts far from its centre.
    falling.rigid_body.type, sheet.rigid_body.type = "PASSIVE", "ACTIVE"
    sheet.rigid_body.collision_shape, sheet.rigid_body.mass = "CONVEX_HULL", 2.0
    sheet.rotation_euler, falling.location = (np.pi, 0, 0), (1.4, 2, 1.9)
    ((frame, point, velocity, mass, _), *_) = hits()
    assert frame == 12 and np.abs(point - [0.4, 0, 0]).max() < 0.05 and abs(velocity[2] + 4.43) < 0.3 and 0.2 < mass < 1.2
    # An animated ball goes through a fixed sheet: the whole of its mass acts, once.
    falling.rigid_body.kinematic, sheet.rigid_body.type, sheet.rotation_euler = True, "PASSIVE", (0, 0, 0)
    for at, z in ((1, 4), (31, 2)):
        falling.location.z = z
        falling.keyframe_insert("location", frame=at)
    for curve in curves(falling.animation_data):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    ((frame, point, velocity, mass, _),) = hits()
    assert frame in (14, 15) and np.abs(point - [0.4, 0, 0]).max() < 0.02 and abs(velocity[2] + 1.6) < 0.01 and mass == 3
    bpy.ops.rigidbody.world_remove()


def curves(animation):
    """The action's curves, also in Blender 5."""
    action = animation.action
    return action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbag(animation.action_slot).fcurves


def test_marked_examples_are_read_back_from_the_file(dentable, tmp_path):
    import crumple

    dentable.active_shape_key_index = 1
    bpy.ops.crumple.mark(mass=5, speed=4, radius=0.1)
    dentable.active_shape_key_index = 2
    bpy.context.scene.cursor.location = (0.2, 0.1, 0)
    bpy.ops.crumple.mark(at="CURSOR", impulse=12)
    entry = json.loads(dentable.data["impacts"])[0]
    assert entry["striker"] == {"mass": 5.0, "radius": pytest.approx(0.1), "velocity": [0.0, -4.0, 0.0]} and entry["impulse"] == [0, -20, 0]
    bpy.ops.crumple.hit(location=(0, -0.2, 0), by="BLOW", mass=5, speed=4, radius=0.1)
    bpy.ops.crumple.clear()
    bpy.ops.crumple.hit(location=(0, -0.2, 0), depth=0.02)
    before = [key.name for key in dentable.data.shape_keys.key_blocks]
    path = tmp_path / "sheet.glb"
    bpy.ops.crumple.export(filepath=str(path))
    shown = report()
    assert [key.name for key in dentable.data.shape_keys.key_blocks] == before and dentable.data.name == "Sheet" and dentable.select_get()
    with crumple.Context() as context:
        loaded = context.load(path)
        examples = loaded.examples
        assert [one.name for one in examples] == ["left", "right"] and loaded.info.blow_count == 2
        assert np.abs(examples[0].contact_point - entry["point"]).max() < 1e-6
        assert abs(examples[1].contact_point[0] - 0.2) < 0.02 and abs(examples[1].contact_point[2] + 0.1) < 0.02
        baked = tmp_path / "sheet.crumple"
        bpy.ops.crumple.export(filepath=str(baked), tolerance=0.05)
        of_baked = context.load(baked)
        assert of_baked.info.example_count == 2 and of_baked.info.memory_bytes < loaded.info.memory_bytes
    assert sorted(one.name for one in tmp_path.iterdir()) == ["sheet.crumple", "sheet.glb"]
    # The command says the same of the file as Blender showed.
    import crumple._library

    program = crumple._library.BINARIES / "crumple"
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    said = subprocess.run([program, "info", path], capture_output=True, text=True, check=True).stdout
    for one in examples:
        row = next(line.split() for line in said.splitlines() if f" {one.name} " in line)
        assert f"{one.name}: {float(row[3]):.1f} mm, moves {row[2]}, " in shown
    assert "2 of 2 examples know their blow" in said and "2 know their blow" in shown


def test_selected_objects_are_one_body(dentable, tmp_path):
    import crumple

    dentable.location = (2, 0, 0)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2, size=1)
    pane, wheel = bpy.context.object, bpy.context.object.copy()
    pane.name, wheel.name, wheel.location = "Pane", "Wheel", (9, 0, 0)
    bpy.context.scene.collection.objects.link(wheel)
    for one in (wheel, dentable):
        one.select_set(True)
    bpy.context.view_layer.objects.active = dentable
    path = tmp_path / "body.crumple"
    bpy.ops.crumple.export(filepath=str(path), tolerance=0, parts=True, targets="*, !right", glass="Pan*", moving="Wheel", unit=0.01)
    with crumple.Context() as context:
        body = context.load(path)
        across = body.mesh().positions[:, 0]
        assert (across.min(), across.max()) == pytest.approx((-0.005, 0.025))
        assert [one.name for one in body.examples] == ["left"]
        assert body.examples[0].depth == pytest.approx(0.01 * 0.05, rel=0.02)
    assert sorted(one.name for one in bpy.data.objects) == ["Pane", "Sheet", "Wheel"]
    with pytest.raises(RuntimeError, match="unit is of .crumple files"):
        bpy.ops.crumple.export(filepath=str(tmp_path / "body.glb"), unit=0.01)


def test_round_dents_make_a_bare_mesh_dentable(sheet):
    bpy.ops.crumple.make_examples(count=6)
    assert len(sheet.data.shape_keys.key_blocks) == 7 and len(json.loads(sheet.data["impacts"])) == 6
    # Made again they replace each other; what the artist sculpted stays.
    dent(sheet, "mine", (0.2, 0.2, 0), 0.01)
    bpy.ops.crumple.make_examples(count=4)
    assert [key.name for key in sheet.data.shape_keys.key_blocks][:2] == ["Basis", "mine"] and len(sheet.data.shape_keys.key_blocks) == 6
    assert len(json.loads(sheet.data["impacts"])) == 4
    sheet.shape_key_remove(sheet.data.shape_keys.key_blocks["mine"])
    bpy.ops.crumple.make_examples(count=6)
    assert len(sheet.data.shape_keys.key_blocks) == 7
    with pytest.raises(RuntimeError, match="do not know their blows: hit by depth"):
        bpy.ops.crumple.hit(location=(0.1, 0.1, 0), by="BLOW", mass=5, speed=4, radius=0.1)
    bpy.ops.crumple.hit(location=(0.1, 0.1, 0), depth=0.02)
    assert abs(np.abs(damage(sheet)).max() - 0.02) < 1e-3
    bpy.ops.crumple.check()
    assert report().startswith("Nothing wrong was found")
    for kind in ("ERROR", "REACH"):
        bpy.ops.crumple.coverage(kind=kind)
        colours = np.empty(4 * SIDE * SIDE, np.float32)
        sheet.data.color_attributes["Crumple coverage"].data.foreach_get("color", colours)
        assert np.isfinite(colours).all() and np.ptp(colours.reshape(-1, 4), axis=0).max() > 0.01
    # The rim is held: nothing moves it.
    assert abs(abs(bpy.context.scene.cursor.location.x) - 0.5) < 1e-6 or abs(abs(bpy.context.scene.cursor.location.y) - 0.5) < 1e-6


def test_check_names_what_is_wrong(dentable):
    dent(dentable, "again", (-0.25, 0, 0))
    dent(dentable, "nothing", (0, 0, 0), 0)
    dent(dentable, "outward", (0, 0.3, 0), -0.02)
    dent(dentable, "everywhere", (0, 0, 0), 0.02, 1.5)
    dentable.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    dentable.modifiers.new("Smooth", "SUBSURF")
    bpy.ops.crumple.check()
    for text in (
        "again repeats left", "nothing moves no vertex", "outward moves its contact outwards", "everywhere reaches beyond its dent", "left has no contact",
        "the object is scaled", "modifier Smooth: apply it",
    ):  # fmt: skip
        assert text in report(), text


def test_painted_limits_and_stiffness_hold_in_hits_and_in_the_file(dentable, tmp_path):
    import crumple

    bpy.ops.crumple.paint(what="LIMIT")
    assert dentable.mode == "WEIGHT_PAINT" and dentable.vertex_groups.active.name == "Crumple depth limit"
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.crumple.paint(what="STIFFNESS")
    bpy.ops.object.mode_set(mode="OBJECT")
    limit, stiff = (dentable.vertex_groups[name] for name in ("Crumple depth limit", "Crumple stiffness"))
    x = positions(dentable.data.shape_keys.reference_key)[:, 0]
    limit.add(np.flatnonzero(x < -0.2).tolist(), 0.9, "REPLACE")
    limit.add(np.flatnonzero(x < -0.29).tolist(), 1.0, "REPLACE")
    stiff.add(np.flatnonzero(x > 0.2).tolist(), 0.5, "REPLACE")
    # Nine tenths of 10 cm are forbidden: 1 cm is left.
    assert abs(dentable.crumple_deepest - 0.1) < 1e-6
    bpy.ops.crumple.hit(location=(-0.21, 0, 0), depth=0.03)
    moved = damage(dentable)
    assert 0.0095 < np.abs(moved[x < -0.2]).max() <= 0.0101 and (moved[x < -0.29] == 0).all() and np.abs(moved).max() < 0.035
    path = tmp_path / "sheet.glb"
    bpy.ops.crumple.export(filepath=str(path))
    with crumple.Context() as context:
        body = context.load(path).instance()
        body.hit_displacement((-0.21, 0, 0), (0, -0.03, 0))
        of_file, base = body.deformed().positions, body.set.mesh().positions
        down = (base - of_file)[:, 1]
        assert abs(down.max() + moved[:, 2].min()) < 1e-4
        assert down[base[:, 0] < -0.2].max() <= 0.0101 and (down[base[:, 0] < -0.29] == 0).all()
        body.reset()
        body.hit_displacement((0.15, 0, 0), (0, -0.03, 0))
        half = (base - body.deformed().positions)[:, 1]
    dentable.vertex_groups.remove(stiff)
    bpy.ops.crumple.clear()
    bpy.ops.crumple.hit(location=(0.15, 0, 0), depth=0.03)
    whole = -damage(dentable)[:, 2]
    stiffer = x > 0.2
    assert whole[stiffer].max() > 0.01 and abs(half[base[:, 0] > 0.2].max() / whole[stiffer].max() - 0.5) < 0.02
    with pytest.raises(RuntimeError, match="rigid"):
        bpy.ops.crumple.hit(location=(-0.4, 0, 0), depth=0.02)


def test_dents_keep_out_of_picked_objects(dentable, tmp_path):
    import crumple

    with pytest.raises(RuntimeError, match="select the solids too"):
        bpy.ops.crumple.keep_out()
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.1, location=(1.2, 2, 2.885), segments=24, ring_count=16)
    ball = bpy.context.object
    bpy.ops.mesh.primitive_plane_add(size=0.1, location=(1, 2, 2))
    sail = bpy.context.object
    dentable.location = (1, 2, 3)
    bpy.context.view_layer.update()

    def pick(*chosen):
        for one in bpy.data.objects:
            one.select_set(one in chosen or one == dentable)
        bpy.context.view_layer.objects.active = dentable

    pick(sail)
    with pytest.raises(RuntimeError, match="Plane is no closed solid"):
        bpy.ops.crumple.keep_out()
    assert "_DEPTH_LIMIT" not in dentable.data.attributes
    pick(ball)
    bpy.ops.crumple.keep_out()
    base = positions(dentable.data.shape_keys.reference_key)
    bpy.ops.crumple.hit(location=(1.2, 2, 3), depth=0.04)
    path = tmp_path / "sheet.glb"
    bpy.ops.crumple.export(filepath=str(path))
    with crumple.Context() as context:
        body = context.load(path).instance()
        body.hit_displacement((0.2, 0, 0), (0, -0.04, 0))
        shown = [base + damage(dentable), body.deformed().positions[:, [0, 2, 1]] * [1, -1, 1]]
    for moved in shown:
        away = np.linalg.norm(moved - [0.2, 0, -0.115], axis=1)
        # The sphere is a mesh, a little smaller than a ball.
        assert 0.098 < away.min() < 0.105 and 0.01 < np.abs(moved[:, 2]).max() < 0.025
    bpy.ops.crumple.keep_out(clear=True)
    assert np.abs(damage(dentable)).max() > 0.029 and "_DEPTH_LIMIT" not in dentable.data.attributes


def test_the_solver_runs_apart(sheet, tmp_path):
    """A small program stands for `crumple examples`, which has its own tests: it takes the file and writes it back with round dents."""
    preferences = bpy.context.preferences.addons["bl_ext.user_default.crumple"].preferences
    python = os.environ.get("CRUMPLE_EXAMPLES_PYTHON")
    if python is None:
        pytest.skip("CRUMPLE_EXAMPLES_PYTHON names no Python with crumple[examples]")
    program = tmp_path / "crumple"
    program.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/asked\nexec {python} -m crumple "$@" --profile\n')
    program.chmod(0o755)
    preferences.program = str(program)
    sheet.location, sheet.rotation_euler = (1, 2, 3), (0.3, 0.4, 0.5)
    bpy.ops.mesh.primitive_cube_add(size=0.1, location=(1, 2, 2.5))
    cube = bpy.context.object
    sheet.select_set(True)
    bpy.context.view_layer.objects.active = sheet
    bpy.ops.crumple.keep_out()
    bpy.ops.crumple.make_examples(method="SOLVER", count=3)
    # The solver gets the solid, where it stands in the scene.
    asked = (tmp_path / "asked").read_text()
    assert "--quality good --material steel --hold auto --strikers ball --tilt 30 --count 3" in asked and "--unit" not in asked
    solids = asked.split("--inner ")[1].strip()
    before = set(bpy.data.objects)
    bpy.ops.import_scene.gltf(filepath=solids)
    (read,) = set(bpy.data.objects) - before
    assert (read.matrix_world.translation - cube.location).length < 1e-6 and abs(read.dimensions.x - 0.1) < 1e-6
    bpy.data.batch_remove([read, cube])
    bpy.context.view_layer.objects.active = sheet
    assert [one.name for one in bpy.data.objects] == ["Sheet"] and len(sheet.data.shape_keys.key_blocks) == 4
    bpy.ops.crumple.hit(location=sheet.matrix_world.translation, depth=0.02)
    assert abs(np.abs(damage(sheet)).max() - 0.02) < 1e-3
    # In a scene in centimetres the same sheet is 1 cm wide, and lengths are told in its units.
    bpy.context.scene.unit_settings.scale_length = 0.1
    sheet.modifiers.new("Smooth", "SUBSURF")
    held = sheet.vertex_groups.new(name="Crumple held")
    with pytest.raises(RuntimeError, match="nothing of Sheet is painted as held"):
        bpy.ops.crumple.make_examples(method="SOLVER", hold="marked")
    held.add([0, 1, 2], 1.0, "REPLACE")
    bpy.ops.crumple.make_examples(
        method="SOLVER", count=2, thickness=0.008, material="tin", hold="marked", strikers={"ball", "wall"}, shallowest=0.01, deepest=0.02, jobs=1,
        lightest=1.5, heaviest=20, smallest=0.03, largest=0.03, quality="draft", until_error=0.3, go_on=True, report_page=False, detail=400,
    )  # fmt: skip
    asked = (tmp_path / "asked").read_text()
    for option in (
        "--unit 0.1", "--thickness 0.8", "--material tin", "--hold marked", "--strikers ball wall", "--depth 1 2", "--jobs 1", "--quality draft",
        "--mass 1.5 20", "--radius 3 3",
        "--until-error 0.3", "--go-on", "--no-report", "--detail 400", "--count 2",
    ):  # fmt: skip
        assert option in asked, (option, asked)
    assert sorted(key.name for key in sheet.data.shape_keys.key_blocks) == ["Basis", "Crumple damage", "profile 1", "profile 2"]
    # They are 1 to 2 mm deep.
    assert "profile 1: 1.0 mm" in report(), report()
    written = Path(bpy.app.tempdir) / "Sheet" / "body.glb"
    assert b"_HELD" in written.read_bytes() and b"_HELD" not in (tmp_path / "asked").read_bytes()
    bpy.context.scene.unit_settings.scale_length = 1.0
    preferences.program = str(tmp_path / "none")
    with pytest.raises(RuntimeError, match="the solver is not installed: type pip install '.*crumple-.*whl"):
        bpy.ops.crumple.make_examples(method="SOLVER")


if __name__ == "__main__":
    status = pytest.main([__file__, "--quiet", "-p", "no:cacheprovider"])
    sys.stdout.flush()
    # bpy 4.2 crashes at exit after its own glTF exporter has run, also without this extension.
    os._exit(status)
