import json
import threading

import numpy as np
import pygltflib
import pytest
from conftest import HOOD, SIDE, command, sheet

import crumple
from crumple import CrumpleError, Example, Result, SetOptions, Striker


def test_a_hit_dents_like_quickstart_c(sheet_set):
    body = sheet_set.instance()
    told = body.hit((0.25, 0, 0), (0, 0, -2), 0.01)
    assert told.status == crumple.HitStatus.MARKED
    # Quickstart.c finds the same depth at the same vertex.
    assert told.contact_vertex == 30 * SIDE + 20
    assert abs(body.deformed().positions[told.contact_vertex, 2] + 0.04) < 1e-4
    assert np.allclose(told.achieved, (0, 0, -0.04), atol=1e-4)
    assert 0 <= told.expected_error <= 1
    # The mark tells a displacement, straight down.
    assert (told.mark["told"][0], told.mark["striker"][0]) == (0, 0) and np.isclose(told.mark["depth"][0], 0.04)


def test_deform_writes_what_the_command_writes(context, tmp_path):
    impacts = json.loads(HOOD.with_suffix(".json").read_text())
    dented = tmp_path / "dented.glb"
    done = command("apply", HOOD, "--impacts", HOOD.with_suffix(".json"), "-o", dented)
    assert done.returncode == 0, done.stderr
    body = context.load(HOOD).instance()
    for impact in impacts:
        striker = Striker(*(impact["striker"][key] for key in ("mass", "radius", "velocity")))
        body.hit(impact["point"], impact["impulse"], impact.get("duration", 0), normal=impact["normal"], striker=striker)
    glb = pygltflib.GLTF2().load(dented)
    accessor = glb.accessors[glb.meshes[0].primitives[0].attributes.POSITION]
    start = (glb.bufferViews[accessor.bufferView].byteOffset or 0) + (accessor.byteOffset or 0)
    written = np.frombuffer(glb.binary_blob(), np.float32, 3 * accessor.count, start).reshape(-1, 3)
    assert body.deformed().positions.tobytes() == written.tobytes()


def test_vertices_go_into_the_callers_interleaved_array(context, sheet_set):
    body = sheet_set.instance()
    vertices = np.full((SIDE * SIDE, 8), 7, np.float32)
    buffer = body.buffer(vertices[:, :3], vertices[:, 3:6])
    assert context.deform().vertices_written == SIDE * SIDE
    body.hit_displacement((0, 0, 0), (0, 0, -0.03))
    report = context.deform([buffer])
    assert 0 < report.vertices_written < SIDE * SIDE
    changes = buffer.changes()
    assert changes.ranges[:, 1].sum() == report.vertices_written
    triangles = buffer.changed_triangles()
    assert triangles.ranges[:, 1].min() > 0 and np.isclose(triangles.bounds[0, 2], -0.03, atol=1e-6)
    assert np.isclose(changes.bounds[0, 2], vertices[:, 2].min()) and np.isclose(vertices[:, 2].min(), -0.03, atol=1e-6)
    assert (vertices[:, 6:] == 7).all()
    assert np.allclose(np.linalg.norm(vertices[:, 3:6], axis=1), 1, atol=1e-5)
    buffer.unregister()
    before = vertices.copy()
    body.reset()
    context.deform()
    assert (vertices == before).all()


def test_normals_of_two_16_bit_numbers_are_octahedral(sheet_set, context):
    body = sheet_set.instance()
    positions, floats = (np.empty((SIDE * SIDE, 3), np.float32) for _ in range(2))
    again, packed = np.empty_like(positions), np.empty((SIDE * SIDE, 2), np.uint16)
    body.buffer(positions, floats)
    body.buffer(again, packed)
    body.hit_displacement((0, 0, 0), (0, 0, -0.03))
    context.deform()
    x, y = (packed / 65535 * 2 - 1).T
    normals = np.column_stack((x, y, 1 - abs(x) - abs(y)))  # of the upper half of the octahedron
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert floats[:, 2].min() > 0 and np.allclose(normals, floats, atol=2e-4)
    with pytest.raises(ValueError, match="normals has the shape"):
        body.buffer(again, packed[:, :1])


def test_no_dent_moves_a_vertex_into_a_solid(context):
    flat, triangles, dented = sheet()
    box = np.array([[x, y, z] for z in (-0.3, -0.01) for y in (0.1, 0.4) for x in (0.1, 0.4)])
    faces = np.reshape(
        [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5], (-1, 3)
    )
    limits = crumple.keep_out(flat, capsules=[((-1, -0.2, -0.1), (1, -0.2, -0.1), 0.08)], meshes=[(box, faces)])
    assert np.isclose(limits.min(), 0.01, atol=1e-5) and limits.max() > 0.1
    body = context.example_set(flat, triangles, [Example(dented)], depth_limits=limits).instance()
    for x in (-0.2, 0, 0.2):
        for y in (-0.2, 0, 0.2):
            body.hit_displacement((x, y, 0), (0, 0, -0.1))
    moved = np.linalg.norm(body.deformed().positions - flat, axis=1)
    assert (moved <= limits).all() and moved.max() > 0.03
    with pytest.raises(crumple.CrumpleError, match="solid 0 has 11 triangles and 3 open edges"):
        crumple.keep_out(flat, meshes=[(box, faces[1:])])


def test_inputs_are_read_in_place(context):
    flat, triangles, dented = sheet()
    whole = np.zeros((len(flat), 5), np.float32)
    whole[:, 1:4] = flat
    of_view = context.example_set(whole[:, 1:4], triangles, [Example(dented)])
    of_copy = context.example_set(flat.tolist(), triangles.tolist(), [Example(dented)])
    moved = np.flatnonzero(dented[:, 2])
    of_deltas = context.example_set(flat, triangles, [Example((dented - flat)[moved], indices=moved)])
    assert of_view.info.fingerprint == of_copy.info.fingerprint == of_deltas.info.fingerprint
    assert (of_view.mesh().triangles == triangles).all()
    # A lattice of every second vertex: its rows are not beside each other.
    assert context.example_set(flat[::2], triangles[:1] * 0 + [0, 1, 2], [Example(dented[::2])]).info.vertex_count == 841


def test_damage_is_saved_loaded_copied_and_repaired(context, sheet_set):
    body, other = sheet_set.instance(), sheet_set.instance()
    body.hit_displacement((0.2, 0.1, 0), (0, 0, -0.04))
    body.hit_displacement((-0.2, 0.1, 0), (0, 0, -0.02))
    vertices, marks = body.deformed().positions.copy(), body.marks
    assert len(marks) == body.info.mark_count == 2 and sorted(marks["depth"].round(4)) == [0.02, 0.04]
    for restore in (
        lambda: other.load_damage(body.save_damage()),
        lambda: setattr(other, "marks", marks),
        lambda: other.copy_damage(body),
    ):
        other.reset()
        restore()
        assert other.deformed().positions.tobytes() == vertices.tobytes()
    mapped, done = sheet_set.map_damage(body.save_damage(), sheet_set, 0)
    assert mapped == body.save_damage() and (done.kept, done.moved, done.too_far, done.without_blows) == (2, 0, 0, 0)
    other.repair(0.5)
    assert np.isclose(other.deformed().positions[:, 2].min(), vertices[:, 2].min() / 2, rtol=1e-3)
    with pytest.raises(CrumpleError, match="cut short|too short|bytes") as error:
        other.load_damage(body.save_damage()[:-3])
    assert error.value.result == Result.ERROR_DAMAGE_MISMATCH


def test_baked_sets_and_files_are_the_same_set(context, tmp_path):
    loaded = context.load(HOOD)
    assert (loaded.info.name, loaded.info.example_count, loaded.info.blow_count) == ("hood", 12, 12)
    errors = [one.field_error for one in loaded.examples]
    assert len(errors) == 12 and 0 < min(errors) < loaded.info.field_error < max(errors)
    baked = loaded.bake()
    again = context.load_baked(baked)
    assert again.info.fingerprint == loaded.info.fingerprint
    path = tmp_path / "hood.crumple"
    path.write_bytes(baked)
    assert context.load(path).bake() == baked
    with pytest.raises(CrumpleError) as error:
        context.load_baked(baked[:-1])
    assert error.value.result == Result.ERROR_FORMAT


def test_messages_are_the_librarys_own(context, tmp_path):
    flat, triangles, dented = sheet()
    missing = tmp_path / "missing.glb"
    with pytest.raises(CrumpleError) as error:
        context.load(missing)
    assert error.value.result == Result.ERROR_IO
    # The command and the package say the same about a file.
    said = command("info", missing).stderr.strip().removeprefix("error: ")
    assert str(missing) in said and str(missing) in str(error.value)
    broken = dented.copy()
    broken[7, 1] = np.nan
    with pytest.raises(CrumpleError, match="7") as error:
        context.example_set(flat, triangles, [Example(broken)])
    assert error.value.result == Result.ERROR_NOT_FINITE
    with pytest.raises(CrumpleError, match="1682"):
        context.example_set(flat, [[0, 1, 1682]], [Example(dented)])
    with pytest.raises(CrumpleError, match="basis_tolerance"):
        context.example_set(flat, triangles, [Example(dented)], options=SetOptions(basis_tolerance=-1))
    body = context.example_set(flat, triangles, [Example(dented)]).instance()
    with pytest.raises(CrumpleError) as error:
        body.hit((0, 0, 50), (0, 0, -1), 0.01, mass=1)
    assert error.value.result == Result.ERROR_CONTACT_TOO_FAR
    with pytest.raises(TypeError, match="float64"):
        body.buffer(np.zeros((len(flat), 3)))
    with pytest.raises(ValueError, match="three numbers"):
        body.hit((0, 0), (0, 0, -1), 0.01)
    # A failed call changes nothing.
    assert body.info.mark_count == 0


def test_other_meshes_attachments_and_world_hits(context, sheet_set):
    flat, triangles, _ = sheet()
    lod = sheet_set.add_lod(flat[:3] + [0, 0, 0.01], [[0, 1, 2]])
    attachment = sheet_set.attach((0, 0, 0.02))
    turned = np.array([[0, 0, 1, 5], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], np.float32)
    body = sheet_set.instance(transform=turned)
    small = np.zeros((3, 3), np.float32)
    body.buffer(small, lod=lod)
    # The mesh's -z is the world's -x, and its origin is at x = 5.
    told = body.hit_displacement((5, 0, 0), (-0.03, 0, 0), space=crumple.Space.WORLD)
    assert np.allclose(told.target, (0, 0, -0.03), atol=1e-6)
    assert np.allclose(body.attached(attachment).position, (0, 0, -0.01), atol=2e-3)
    context.deform()
    assert np.allclose(small, flat[:3] + [0, 0, 0.01], atol=1e-6)


def test_contacts(context):
    flat, triangles, dented = sheet()
    body = context.example_set(flat, triangles, [Example(dented)]).instance()
    for _ in range(3):
        body.hit_displacement((0, 0, 0), (0, 0, -0.01), contact_id=9)
    assert np.isclose(np.linalg.norm(body.contact(9).target), 0.03)
    assert body.info.mark_count == body.info.contact_count == 1
    preview = body.hit_displacement((0.3, 0, 0), (0, 0, -0.01), preview=True)
    assert preview.status == crumple.HitStatus.MARKED
    body.end_contact(9)
    with pytest.raises(crumple.CrumpleError, match="contact_id is 9"):
        body.end_contact(9)
    body.deformed()


def test_nodes_and_dents_of_a_gltf_are_chosen_by_name(context):
    path = HOOD.parents[2] / "tests/fixtures/two_materials.glb"
    whole = context.load(path, nodes="*")
    assert [example.name for example in whole.examples] == ["Left", "Middle"]
    one = context.load(path, targets=["*", "!L?ft"], unit=0.01)
    assert [example.name for example in one.examples] == ["Middle"]
    assert np.allclose(one.mesh().positions, context.load(path).mesh().positions / 100, atol=1e-6)
    with pytest.raises(crumple.CrumpleError, match="no such node"):
        context.load(path, nodes="no such node")
    with pytest.raises(ValueError, match="baked set"):
        context.load("any.crumple", nodes="*")


def test_contact_points_of_a_manifold_are_one_blow(context):
    flat, triangles, dented = sheet()
    struck = Example(dented, impulse=(0, 0, -40), striker=crumple.Striker(mass=8, velocity=(0, 0, -5)))
    body = context.example_set(flat, triangles, [struck]).instance()
    places = [(x, y, 0) for x in (-0.01, 0.01) for y in (-0.01, 0.01)]
    parts = [crumple.ContactPoint(1, (body, None), place, (0, 0, 1), impulse=10, velocity=(0, 0, -5)) for place in places]
    context.report_contacts(parts)
    assert context.step_contacts(1 / 60).hits == 1
    assert body.info.mark_count == 1
    (hit,) = context.contact_hits
    assert hit.instance is body and hit.pair == 1 and np.allclose(hit.point, 0) and np.allclose(hit.impulse, (0, 0, -40))
    assert np.array_equal(body.contact(hit.contact_id).target, hit.result.target)
    rests = crumple.ContactPoint(2, (None, body), (0.2, 0, 0), (0, 0, -1), velocity=(0, 0, 0.1), masses=(8, None), impulse=1)
    context.report_contacts([rests])
    assert context.step_contacts(1 / 60).slow == 1 and context.contact_hits == []
    wrong = crumple.ContactPoint(3, (body, None), (0, 0, 0), (0, 0, 0), impulse=1)
    with pytest.raises(crumple.CrumpleError, match="points\\[1\\].normal"):
        context.report_contacts([rests, wrong])
    with pytest.raises(TypeError, match="grain"):
        context.set_contact_options(grain=2)
    context.set_contact_options(gain=2)
    context.clear_contacts()
    assert context.contact_totals.points == 5


def test_what_is_closed_is_an_error_and_not_a_crash():
    flat, triangles, dented = sheet()
    context = crumple.Context(threads=1)
    body = context.example_set(flat, triangles, [Example(dented)]).instance()
    positions = body.deformed().positions
    context.close()
    context.close()
    with pytest.raises(ValueError, match="closed"):
        body.info  # noqa: B018
    assert positions.shape == flat.shape
    with pytest.raises(CrumpleError) as error:
        crumple.Context(threads=4000)
    assert error.value.result == Result.ERROR_INVALID_ARGUMENT and "4000" in str(error.value)


def test_threads_may_hit_at_any_time(sheet_set):
    body, other = sheet_set.instance(), sheet_set.instance()
    hits = [((x, y, 0.0), (0, 0, -0.01)) for x in (-0.3, 0, 0.3) for y in (-0.3, 0.2)]
    threads = [threading.Thread(target=body.hit_displacement, args=hit) for hit in hits]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for hit in reversed(hits):
        other.hit_displacement(*hit)
    assert body.save_damage() == other.save_damage()


def test_the_log_gets_warnings():
    said = []
    with crumple.Context(threads=1, log=lambda text, warning: said.append((text, warning))) as context:
        flat, triangles, dented = sheet()
        context.example_set(flat, triangles, [Example(dented), Example(flat, name="flat")])
    assert ("example 'flat' moves no vertex", True) in said
    assert [warning for _, warning in said] == [True, False]


def test_the_command_is_the_packed_program():
    said = command("--version")
    assert said.stdout.split() == ["crumple", crumple.__version__]
