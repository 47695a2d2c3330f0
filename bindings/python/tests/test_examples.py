import json

import bodies
import numpy as np
import pytest
import trimesh
from conftest import command

import crumple
from crumple.examples import profile, run, shell
from crumple.examples.body import Body
from crumple.examples.command import main


def check(path, out, count):
    """What holds for every output: `count` examples on the mesh as it was, with closed seams."""
    before, after = Body(path), Body(out, replace=True)
    assert after.vertices.tobytes() == before.vertices.tobytes()
    text = out.read_bytes()
    gltf = json.loads(text[20 : 20 + int.from_bytes(text[12:16], "little")])
    assert all("bufferView" in accessor or "byteOffset" not in accessor for accessor in gltf["accessors"])
    with crumple.Context(threads=1) as context:
        loaded = context.load(out)
        assert loaded.info.example_count == count and loaded.info.vertex_count == len(before.vertices)
        shared = before.of_vertex
        first = np.unique(shared, return_index=True)[1]
        for number, example in enumerate(loaded.examples):
            assert example.moved_vertices > 0 and example.depth > 0
            # An example alone, on a body of its own, at its own contact: seams stay closed to the last bit.
            body = loaded.instance(examples_per_hit=1)
            body.hit_displacement(example.contact_point, -example.depth * example.contact_normal)
            moved = body.deformed().positions
            assert np.isfinite(moved).all()
            assert (moved[first][shared] == moved).all(), number
        return loaded.info, loaded.examples


BODIES = {
    "panel": lambda path: bodies.write(path, [bodies.panel()]),
    "six materials, every edge a seam": lambda path: bodies.write(path, bodies.split_box()),
    "edges of four triangles": lambda path: bodies.write(path, [bodies.crossed()]),
    "millimetres": lambda path: bodies.write(path, [bodies.panel(size=1000)], scale=[0.001] * 3),
    "mirrored and stretched": lambda path: bodies.write(path, [bodies.panel()], scale=[-1, 2, 0.5]),
    "a toy of 4 cm": lambda path: bodies.write(path, [bodies.panel(size=0.03)]),
    "a hall of 90 m": lambda path: bodies.write(path, [bodies.panel(size=60)]),
}


@pytest.mark.parametrize("name", BODIES)
def test_profiles_dent_any_mesh(name, tmp_path):
    path, out = BODIES[name](tmp_path / "body.glb"), tmp_path / "out.glb"
    assert main([str(path), "-o", str(out), "--profile", "--count", "4", "--no-report"]) == 0
    info, examples = check(path, out, 4)
    scale = np.cbrt(abs(np.linalg.det(info.node_transform[:3, :3].astype(float))))
    size = Body(path).size
    depths = [example.max_depth * scale / size for example in examples]
    if name != "mirrored and stretched":
        assert 0.004 < min(depths) < max(depths) < 0.031
    assert info.blow_count == 0


@pytest.mark.parametrize("name", BODIES)
def test_bodies_become_shells(name, tmp_path):
    body = Body(BODIES[name](tmp_path / "body.glb"))
    made = shell.make(body, 600, "auto")
    assert 400 < len(made.points) < 1100
    assert 0 < made.held.mean() < 0.4
    lengths = np.linalg.norm(np.diff(made.points[made.triangles[:, [0, 1, 2, 0]]], axis=1), axis=2)
    assert 0.7 < np.median(lengths) / made.edge < 1.3 and lengths.max() < 3 * made.edge
    # A turn of the whole shell turns the body.
    turn = np.array([[0.96, 0, 0.28], [0, 1, 0], [-0.28, 0, 0.96]]) - np.eye(3)
    carried = shell.Carrier(made, body.points).field(made.points @ turn.T)
    assert np.allclose(carried, body.points @ turn.T, atol=1e-9 * body.size)


def test_many_triangles(tmp_path):
    torus = trimesh.creation.torus(0.5, 0.2, 330, 320)
    path, out = bodies.write(tmp_path / "body.glb", [(torus.vertices, torus.faces)]), tmp_path / "out.glb"
    body = Body(path)
    assert len(body.triangles) > 200_000
    made = shell.make(body, 600, "auto")
    assert 400 < len(made.points) < 1100 and made.notes == ["1 of 1 parts are held by their lowest points (y is up)"]
    assert main([str(path), "-o", str(out), "--profile", "--count", "2", "--no-report"]) == 0
    with crumple.Context(threads=1) as context:
        assert context.load(out).info.example_count == 2


def test_the_solver_makes_examples_that_the_command_uses(tmp_path):
    x = bodies.panel(25)[0][:, 0]
    left = bodies.panel(25)[1][x[bodies.panel(25)[1]].mean(1) < 0]
    right = bodies.panel(25)[1][x[bodies.panel(25)[1]].mean(1) >= 0]
    points = bodies.panel(25)[0]
    path = bodies.write(tmp_path / "body.glb", [(points, left), (points, right)], scale=[0.5] * 3)
    out = tmp_path / "out.glb"
    asked = ["examples", path, "-o", out, "--count", "2", "--detail", "300", "--strikers", "ball", "stone"]
    done = command(*asked)
    assert done.returncode == 0, done.stderr
    assert "2 of 2" in done.stdout
    info, examples = check(path, out, 2)
    assert info.blow_count == 2
    # The mesh's own space is twice as large as the world's.
    size = Body(path).size
    assert all(0.5 * 0.005 < 0.5 * example.depth / size < 2 * 0.03 for example in examples)
    # Half of each material's vertices are of the other's triangles; the rim stays where it was.
    with crumple.Context(threads=1) as context:
        loaded = context.load(out)
        body = loaded.instance()
        told = body.hit(examples[0].contact_point, (0, -1, 0), striker=crumple.Striker(1.0, 0.05, (0, -8, 0)), normal=(0, 1, 0))
        assert told.status == crumple.HitStatus.MARKED
        moved = np.linalg.norm(body.deformed().positions - loaded.mesh().positions, axis=1)
        rim = np.abs(loaded.mesh().positions[:, [0, 2]]).max(1) > 0.4999
        assert moved.max() > 0.002 and (moved[rim] == 0).all()
    impacts = tmp_path / "impacts.json"
    assert command("sample", out, "-o", impacts).returncode == 0
    assert command("apply", out, "--impacts", impacts, "-o", tmp_path / "dented.glb").returncode == 0
    assert "2 examples know their blow" in command("info", out).stdout or "blows" in command("info", out).stdout
    page = (tmp_path / "out_report/index.html").read_text()
    assert "example_02.png" in page and (tmp_path / "out_report/example_02.png").stat().st_size > 3000
    # What is made is kept: the same file again, without a simulation, and two more examples on top.
    first = out.read_bytes()
    assert command(*asked).returncode == 0
    assert out.read_bytes() == first
    kept = {path.name: path.read_bytes() for path in (tmp_path / "out_work").glob("*.npz")}
    asked[asked.index("--count") + 1] = "4"
    assert command(*asked, "--jobs", "2").returncode == 0
    _, more = check(path, out, 4)
    assert [one.name for one in more[:2]] == [one.name for one in examples]
    assert all((tmp_path / "out_work" / name).read_bytes() == data for name, data in kept.items())
    changed = command(*asked, "--thickness", "1.5")
    assert changed.returncode == 1 and "--thickness (0.0008, now 0.0015)" in changed.stderr


def test_flat_strikers_touch_where_they_should(tmp_path):
    from crumple.examples.flight import Blow, Flight

    made = shell.make(Body(bodies.write(tmp_path / "body.glb", [bodies.panel()])), 600, "auto")
    flight = Flight(made, 0.001)
    # A plate touches the point that is furthest along its normal, wherever it is aimed at.
    normal = np.array([0.2, 1.0, -0.1]) / np.linalg.norm([0.2, 1.0, -0.1])
    blow = Blow(made.points[7], normal, -normal, 5.0, 10.0, made.size, "wall")
    centre, at, outward = flight.touch(blow)
    assert (at == made.points[(made.points @ normal).argmax()]).all() and np.allclose(outward, normal)
    assert abs((centre - at) @ normal - 0.1 * made.size - 0.001) < 1e-3 * made.edge
    # The corner of a cube touches with its tip what it is aimed at, and nothing else is nearer.
    vertex = int(np.linalg.norm(made.points - [0.1, 0.1, 0.05], axis=1).argmin())
    blow = Blow(made.points[vertex], made.normals[vertex], -made.normals[vertex], 5.0, 10.0, 0.2, "corner", 1.0)
    centre, at, outward = flight.touch(blow)
    assert np.linalg.norm(at - made.points[vertex]) < 0.1 * made.edge
    tip = centre + blow.direction * 0.2 * np.sqrt(3)
    assert abs(np.linalg.norm(tip - at) - 0.001) < 2e-3 * made.edge
    assert np.allclose(blow.axes.T @ blow.axes, np.eye(3)) and np.allclose(blow.axes @ np.ones(3), np.sqrt(3) * blow.direction)
    assert (np.abs((made.points - centre) @ blow.axes).max(1) > 0.2).all()


def test_the_same_blow_dents_deeper_by_a_corner_than_by_a_wall(tmp_path):
    from crumple.examples.flight import Blow
    from crumple.examples.materials import MATERIALS
    from crumple.examples.solver import Solver

    made = shell.make(Body(bodies.write(tmp_path / "body.glb", [bodies.panel()])), 400, "auto")
    solver = Solver(made, MATERIALS["steel"], 0.0008)
    vertex, deepest = int(np.linalg.norm(made.points - [0.1, 0.12, 0.05], axis=1).argmin()), {}
    for name, radius in (("wall", made.size), ("corner", 0.2)):
        normal = made.normals[vertex]
        outcome = solver.strike(Blow(made.points[vertex], normal, -normal, 4.0, 8.0, radius, name))
        assert outcome.trouble is None and (outcome.field[made.held] == 0).all()
        # Straight on: the body takes the striker's momentum and at most as much again when it bounces off.
        assert 1 <= -(outcome.impulse @ normal) / (4.0 * 8.0) < 2
        deepest[name] = np.linalg.norm(outcome.field, axis=1).max()
    assert 0.01 < deepest["corner"] and deepest["wall"] < 0.75 * deepest["corner"], deepest


def test_a_corner_that_dents_more_beside_its_tip_is_no_example(tmp_path):
    from crumple.examples.flight import Blow
    from crumple.examples.materials import MATERIALS
    from crumple.examples.solver import ELSEWHERE, Solver

    made = shell.make(Body(bodies.write(tmp_path / "body.glb", [bodies.panel()])), 400, "auto")
    solver, found = Solver(made, MATERIALS["steel"], 0.0008), {}
    for far in (0.03, 0.1):
        vertex = int(np.abs(made.to_held - far).argmin())
        normal = made.normals[vertex]
        outcome = solver.strike(Blow(made.points[vertex], normal, -normal, 6.0, 20.0, 0.2, "corner"))
        found[far] = outcome.trouble
        share = outcome.depth / np.linalg.norm(outcome.field, axis=1).max()
        assert (share < 0.5) == (outcome.trouble == ELSEWHERE), share
    # Beside the rim, which is held, the cube's flank dents the panel. Further inside its tip does.
    assert found == {0.03: ELSEWHERE, 0.1: None}


def engine(tmp_path, **placed):
    """A panel with a box of 30 cm under it, whose top is 2 to 4 cm below the panel."""
    box = trimesh.creation.box((0.3, 0.1, 0.3))
    more = [("engine", [(box.vertices, box.faces)], [0.6, 1.045, 0.05]), ("lamp", [(box.vertices, box.faces)], [0.5, 9.0, 0.0])]
    return bodies.write(tmp_path / "body.glb", [bodies.panel()], translation=[0.5, 1.0, 0.0], more=more, **placed)


def test_the_solver_does_not_push_the_shell_into_solids(tmp_path):
    from crumple.examples import inner
    from crumple.examples.flight import Blow
    from crumple.examples.materials import MATERIALS
    from crumple.examples.solver import Solver

    path = engine(tmp_path)
    body, top = Body(path), 0.095
    solids = inner.read([f"{path}/engine"], body, 1.0)
    assert solids[0].points.max(0) == pytest.approx([0.25, top, 0.2], abs=1e-6)
    bare, steel = shell.make(body, 400, "auto"), MATERIALS["steel"]
    near = (np.abs(bare.points - [0.1, 0, 0.05])[:, [0, 2]] < 0.14).all(1)
    assert inner.room(bare.points, solids)[near] == pytest.approx(bare.points[near, 1] - top, abs=1e-5)
    vertex, lowest = int(np.linalg.norm(bare.points - [0.1, 0.12, 0.05], axis=1).argmin()), []
    for made in (bare, run.among(bare, solids, steel, 0.0008)):
        normal = made.normals[vertex]
        outcome = Solver(made, steel, 0.0008).strike(Blow(made.points[vertex], normal, -normal, 5.0, 15.0, 0.1, "ball"))
        assert outcome.trouble is None
        lowest.append((made.points + outcome.field)[near, 1].min())
    assert lowest[0] < top - 0.01 and lowest[1] > top, lowest


def test_no_hit_enters_a_solid(tmp_path):
    path, out = engine(tmp_path), tmp_path / "out.glb"
    asked = ["examples", path, "-o", out, "--count", "2", "--detail", "300", "--no-report", "--depth", "10", "40"]
    done = command(*asked, "--inner", f"{path}/engine", "capsule:0.2,1.05,-0.3,0.2,1.05,0.3,0.02")
    assert done.returncode == 0, done.stderr
    assert "2 solids inside" in done.stdout and "0 vertices begin in a solid" in done.stdout
    check(path, out, 2)
    with crumple.Context(threads=1) as context:
        loaded = context.load(out)
        base = loaded.mesh().positions
        over = (np.abs(base - [0.1, 0, 0.05])[:, [0, 2]] <= 0.15).all(1)
        bar = np.abs(base[:, 2]) < 0.3
        body = loaded.instance()
        for x in (-0.3, 0.1, 0.2):
            body.hit_displacement((x, 0.1, 0.05), (0, -0.2, 0))
        moved = body.deformed().positions
        assert 0.01 < (base - moved)[over, 1].max() and (moved[over, 1] >= 0.095).all()
        away = np.hypot(moved[bar, 0] + 0.3, moved[bar, 1] - 0.05)
        assert 0.02 <= away.min() < 0.03
    again = command(*asked)
    assert again.returncode == 1 and "another --inner" in again.stderr


@pytest.mark.parametrize("scale", [[0.001] * 3, [-1, 2, 0.5]])
def test_limits_are_in_the_units_of_the_mesh(scale, tmp_path):
    from crumple.examples import inner

    points, triangles = bodies.panel(15)
    scaled = points / np.abs(scale) * np.sign(scale)
    path = bodies.write(tmp_path / "body.glb", [(scaled, triangles[:, ::-1] if scale[0] < 0 else triangles)], scale=scale, translation=[0, 0, 1])
    body = Body(path)
    solids = inner.read(["capsule:0,-0.5,1,0,-0.5,1,0.3"], body, 1.0)
    limits = inner.limits(body, solids)
    # The nearest point of the stretched ball, by sampling.
    ball = trimesh.creation.icosphere(4).vertices * 0.3 - [0, 0.5, 0]
    near = np.linalg.norm(body.vertices[:, None].astype(float) - (ball / scale)[None], axis=2).min(1)
    assert (limits <= near + 1e-6 * near.max()).all() and (limits > 0.9 * near).all()


def test_where_to_hit_next_is_where_the_set_is_worst(tmp_path):
    from crumple.examples.places import Places

    made = shell.make(Body(bodies.write(tmp_path / "body.glb", [bodies.panel()])), 600, "auto")
    places = Places(made)
    assert not made.held[places.open].any()
    taken = [np.array(one) for one in ((-0.3, 0.1, -0.3), (-0.3, 0.1, 0.3), (0.3, 0.1, -0.3), (0.3, 0.1, 0.3), (0, 0.12, 0))]
    vertex = places.next(taken, [0.1, 0.1, 0.1, 1.5, 0.1])
    near = np.linalg.norm(np.array(taken) - made.points[vertex], axis=1).argmin()
    assert near == 3
    spread = places.next(taken[:2], [None, None])
    assert made.points[spread][0] > 0.3


def test_messages(tmp_path, capsys):
    panel = bodies.write(tmp_path / "panel.glb", [bodies.panel(11)])
    done = tmp_path / "done.glb"
    assert main([str(panel), "-o", str(done), "--profile", "--count", "1", "--no-report"]) == 0
    sphere = trimesh.creation.icosphere(3)
    closed = bodies.write(tmp_path / "closed.glb", [(sphere.vertices, sphere.faces)])
    broken = bodies.panel(11)[0]
    broken[5, 1] = np.nan
    nan = bodies.write(tmp_path / "nan.glb", [(broken, bodies.panel(11)[1])])
    flat = bodies.write(tmp_path / "flat.glb", [(np.zeros((3, 3)), [[0, 1, 2]])])
    dust = bodies.write(
        tmp_path / "dust.glb", [tuple(map(np.array, ([[k, 0, 0], [k + 0.5, 0, 0], [k, 0.5, 0]], [[0, 1, 2]]))) for k in range(50)]
    )
    hole = bodies.write(tmp_path / "hole.glb", [(sphere.vertices, sphere.faces[1:])])
    text = tmp_path / "text.glb"
    text.write_text("no glTF\n")
    capsys.readouterr()
    for arguments, message in [
        ([done], "has morph targets already"),
        ([tmp_path / "missing.glb"], "there is no file"),
        ([text], "cannot be read as glTF 2.0"),
        ([panel, "--mesh", "door"], "has no mesh door; it has: body"),
        ([panel, "--depth", "30", "2"], "must rise"),
        ([panel, "-o", panel], "is the input"),
        ([panel, "-o", tmp_path / "out.obj"], "must end in .glb"),
        ([nan], "vertex 5 of body is not finite"),
        ([flat], "have no area"),
        ([closed, "--hold", "edges"], "no open edges"),
        ([panel, "--hold", "marked"], "paint it red"),
        ([dust], "join them"),
        ([panel, "--inner", panel], "has no triangles"),
        ([panel, "--inner", hole], "--inner body: "),
        ([panel, "--inner", f"{closed}/engine"], "has no node engine; it has: body"),
        ([panel, "--inner", "capsule:0,0,0,1,1,1"], "seven numbers"),
        ([panel, "--unit", "0.0001", "--thickness", "0.8"], "the unit may be wrong"),
        ([panel, "--unit", "0.0001"], "MuJoCo refuses the shell"),
    ]:
        assert main([str(argument) for argument in arguments]) == 1, arguments
        said = capsys.readouterr().err
        assert message in said and said.startswith("error: ") and said.count("\n") == 1, said
    assert list(tmp_path.glob("*.part")) == []


def test_solver_troubles_name_what_to_change():
    task = run.Task(0, 0, 0.01, 1.0)
    assert "thicker sheet" in run.advice([run.Result(task, None, ["3 m/s, 1 kg: the solver became unstable"])])
    assert "--hold" in run.advice([run.Result(task, None, ["3 m/s, 1 kg: the shell did not come to rest"])])
    assert "--strikers ball wall" in run.advice([run.Result(task, None, ["3 m/s, 1 kg: the wall touched another place first"])])
    assert "another --depth" in run.advice([run.Result(task, None, ["3 m/s, 1 kg: 0.1 mm"])])


def test_what_is_painted_red_is_held(tmp_path):
    points, triangles = bodies.panel()
    colours = np.tile([1.0, 1.0, 1.0, 1.0], (len(points), 1))
    colours[points[:, 0] < -0.35] = [1, 0, 0, 1]
    body = Body(bodies.write(tmp_path / "body.glb", [(points, triangles)], colours=colours))
    made = shell.make(body, 600, "auto")
    assert (made.held == (made.points[:, 0] < -0.35)).mean() > 0.97
    marked = np.zeros(len(body.points), bool)
    marked[body.of_vertex[body.marked]] = True
    assert marked.sum() == (points[:, 0] < -0.35).sum()
    dents = [made.field for made in profile.make(body, 4, (0.01, 0.03))]
    assert all((dent[marked] == 0).all() and np.abs(dent).max() > 0.009 for dent in dents)
