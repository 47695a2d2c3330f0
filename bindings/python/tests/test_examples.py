import json

import bodies
import numpy as np
import pytest
import trimesh
from conftest import command

import crumple
from crumple.examples import judge, profile, remesh, run, shell
from crumple.examples.body import Body, face_normals
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
            # On a body of its own, at the example's own contact: seams stay closed to the last bit.
            body = loaded.instance()
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
    unit = ["--unit", "1"] if name == "a hall of 90 m" else []
    assert main([str(path), "-o", str(out), "--profile", "--count", "4", "--no-report", *unit]) == 0
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


def test_narrow_grooves_leave_no_slivers(tmp_path):
    body = Body(bodies.write(tmp_path / "body.glb", [bodies.grooved()]))
    made = shell.make(body, 600, "auto")
    assert len(made.points) < 1.2 * 600
    sides = np.linalg.norm(np.diff(made.points[made.triangles[:, [0, 1, 2, 0]]], axis=1), axis=2)
    heights = np.linalg.norm(face_normals(made.points, made.triangles), axis=1) / sides.max(1)
    assert sides.min() > 0.25 * made.edge and heights.min() > 0.15 * made.edge
    # It is still one sheet, and no smaller.
    edges, uses = remesh.edges_of(made.triangles)
    assert uses.max() == 2 and len(made.points) - len(edges) + len(made.triangles) == 1
    flat = trimesh.Trimesh(*bodies.panel(), process=False).area
    assert 0.995 < made.area / flat < 1.1


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
    assert all(1e-5 < 0.5 * example.depth / size < 0.2 for example in examples)
    assert max(0.5 * example.max_depth / size for example in examples) > 0.02
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
    assert "example_0002.png" in page and (tmp_path / "out_report/example_0002.png").stat().st_size > 3000
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
    path = bodies.write(
        tmp_path / "body.glb", [(scaled, triangles[:, ::-1] if scale[0] < 0 else triangles)], scale=scale, translation=[0, 0, 1]
    )
    body = Body(path)
    solids = inner.read(["capsule:0,-0.5,1,0,-0.5,1,0.3"], body, 1.0)
    limits = inner.limits(body, solids)
    # The nearest point of the stretched ball, by sampling.
    ball = trimesh.creation.icosphere(4).vertices * 0.3 - [0, 0.5, 0]
    near = np.linalg.norm(body.vertices[:, None].astype(float) - (ball / scale)[None], axis=2).min(1)
    assert (limits <= near + 1e-6 * near.max()).all() and (limits > 0.9 * near).all()


def planned(tmp_path, **mesh):
    """A bowed sheet as a shell, and a plan for it."""
    from crumple.examples import symmetry
    from crumple.examples.materials import MATERIALS
    from crumple.examples.plan import Plan

    body = Body(bodies.write(tmp_path / "body.glb", [bodies.panel()], **mesh))
    made = shell.make(body, 600, "auto")
    mirror, notes = symmetry.find(body, made.points, made.held, made.room)
    return (
        made,
        mirror,
        notes,
        lambda **more: Plan(made, MATERIALS["steel"], 0.0008, ["ball", "stone"], 30.0, 1, **({"symmetry": mirror} | more)),
    )


def test_blows_fill_the_space_of_place_energy_and_size(tmp_path):
    from crumple.examples.plan import POOL, Tried
    from crumple.examples.symmetry import Symmetry

    made, _, _, told = planned(tmp_path)
    plan, energies, known, chosen = told(symmetry=Symmetry()), (1.0, 100.0), [], []
    assert not made.held[plan.open].any()
    for index in range(40):
        blow = plan.next(index, energies, known)
        known.append(Tried(plan.features(blow, energies), 1.0))
        chosen.append(blow)
    own = np.log([0.5 * one.mass * (one.speed * (one.direction @ one.normal)) ** 2 for one in chosen])
    assert own.min() < np.log(3) and own.max() > np.log(33) and abs(own.mean() - np.log(10)) < 0.7
    assert {one.radius < 0.027 * made.size for one in chosen} == {True, False}

    # Masses and radii that are told are kept, and the energy says the speed.
    for blow in told(mass=(1.0, 20.0), radius=(0.03, 0.15)).draw(0, 64, energies):
        assert 1 <= blow.mass <= 20 and 0.03 <= blow.radius <= 0.15 and 0.5 <= blow.speed <= 20
        own = 0.5 * blow.mass * (blow.speed * (blow.direction @ blow.normal)) ** 2
        assert 0.99 < own < 101 or blow.speed in (0.5, 20)

    # They are less alike than blows that are only drawn.
    def spacing(blows):
        found = np.array([plan.features(one, energies) for one in blows])
        return np.median(np.sort(np.linalg.norm(found[:, None] - found[None], axis=2), axis=1)[:, 1])

    assert spacing(chosen) > 1.2 * spacing(plan.draw(64 * POOL, 64, energies)[:40])
    again = planned(tmp_path)[3](symmetry=Symmetry())
    assert (again.next(0, energies, []).point == chosen[0].point).all()
    # The next one goes where the set knows least.
    right = [Tried(one.features, 2.0 if blow.point[0] > 0 else 0.5) for one, blow in zip(known, chosen, strict=True)]
    assert sum(plan.next(index, energies, right).point[0] > 0 for index in range(40, 60)) >= 15


def test_of_a_symmetric_body_one_side_is_hit(tmp_path):
    made, mirror, notes, plan = planned(tmp_path, rotation=[0, np.sin(0.4), 0, np.cos(0.4)])
    assert len(mirror.normals) == 2 and "one side is hit" in notes[0]
    sides = np.array([(one.point - mirror.centre) @ np.array(mirror.normals).T for one in plan().draw(0, 64, (1.0, 9.0))])
    assert (sides >= 0).all() and (sides.max(0) > 0.3).all()
    assert np.allclose(mirror.folded(mirror.centre - mirror.normals[0]), mirror.centre + mirror.normals[0])
    # If one side is held, both are hit.
    points, triangles = bodies.panel()
    colours = np.where(points[:, :1] < -0.35, [1.0, 0, 0, 1], [1.0, 1, 1, 1])
    from crumple.examples import symmetry

    body = Body(bodies.write(tmp_path / "held.glb", [(points, triangles)], colours=colours))
    made = shell.make(body, 600, "auto")
    mirror, notes = symmetry.find(body, made.points, made.held, made.room)
    assert len(mirror.normals) == 1 and abs(mirror.normals[0][2]) == 1 and "not" in notes[0]


def dents(made, count, seed=1):
    """Round dents that know their blows, by a law that is easy to learn."""
    rng = np.random.default_rng(seed)
    round_ones, out = profile.Profile(made.points, made.normals, made.held, made.size), []
    places = np.flatnonzero(made.to_held > 0.2)
    for k in range(count):
        at, speed = int(rng.choice(places)), float(rng.uniform(2, 8))
        normal = made.normals[at]
        moved = -0.004 * speed * normal
        blow = dict(impulse=-speed * normal, duration=0.01, mass=1.0, radius=0.1, velocity=-speed * normal, shape="ball")
        out.append(run.Made(f"ball {k + 1}", round_ones.dent(at, moved), made.points[at], normal, **blow))
    return out


def test_one_metric_judges_examples_and_round_dents(tmp_path):
    made = planned(tmp_path)[0]
    assert judge.judge(made, dents(made, 7)) is None
    judged = judge.judge(made, dents(made, 24))
    # Round dents are exactly what a round dent predicts, and nearly what other round dents do.
    assert judged.count == 24 and judged.round < 1e-6 and judged.blow < 0.4 and judged.displacement < 0.4
    assert "good" in judged.words()
    rng = np.random.default_rng(3)
    noise = [run.replace(one, field=one.field * rng.choice([-1, 0.02, 1])) for one in dents(made, 24)]
    assert judge.judge(made, noise).blow > judged.blow + 0.2


def test_judged_blows_tell_the_kind_of_striker(tmp_path):
    made = planned(tmp_path)[0]
    # A corner's dent is a fifth of a ball's, and only the kind tells them apart.
    balls, corners = dents(made, 12), dents(made, 12, seed=2)
    corners = [run.replace(one, name=f"corner {one.name}", shape="corner", field=0.2 * one.field) for one in corners]
    assert judge.judge(made, balls + corners).blow < 0.5


def test_a_set_that_predicts_nothing_is_a_failure_with_its_cause(tmp_path):
    from crumple.examples import command

    bad = judge.Judged(20, 1.02, 1.6, 0.7, 0.8, {})
    failure = command._failure(bad, run.Run([], [], bad), ["Warning: it stands on 3% of its ground plan; is y up?"])
    assert "predicts nothing (error 1.02" in str(failure) and "stands on 3%" in str(failure) and "depths are not" in str(failure)
    assert command._failure(judge.Judged(20, 0.8, 1.2, 0.7, 0.8, {}), run.Run([], [], None), []) is None


def test_a_run_ends_when_more_hits_do_not_help(tmp_path):
    made, _, _, plan = planned(tmp_path)
    settings = run.Settings("steel", 0.0008, "auto", ("ball",), (0.004, 0.08), 30.0, 600, 1)
    some = dents(made, 128)
    blow = plan().draw(0, 1, (1.0, 2.0))[0]
    state = run._State(plan(), settings, [run.Result(k, blow, one, None, 0.01, 1.0) for k, one in enumerate(some)])
    state.judged, state.curve = judge.Judged(99, 0.60, 1.0, 0.5, 0.6, {}), [(62, 0.61, 1.0), (128, 0.60, 1.0)]
    assert "no longer help" in state.done(300, None, False)
    assert state.done(300, None, True) is None and "--until-error" in state.done(300, 0.6, True)
    state.curve[0] = (62, 0.7, 1.0)
    assert state.done(300, None, False) is None and "all examples" in state.done(128, None, False)


def test_what_breaks_the_shell_lowers_the_hardest_blows(tmp_path):
    made, _, _, plan = planned(tmp_path)
    settings = run.Settings("steel", 0.0008, "auto", ("ball",), (0.004, 0.08), 30.0, 600, 1)
    state = run._State(plan(), settings, [])
    low, high = state.energies()
    hard = [run.Result(10 + k, blow, None, run.UNSTABLE, 0.0, 1.0) for k, blow in enumerate(plan().draw(0, 8, (0.9 * high, high)))]
    state.results = hard
    assert state.energies()[0] == low and 3 * low * 0.7 <= state.energies()[1] < 0.8 * high


def test_a_free_body_bends_and_does_not_fly_away(tmp_path):
    from crumple.examples.flight import Blow
    from crumple.examples.materials import MATERIALS
    from crumple.examples.solver import Solver, without_motion

    made = shell.make(Body(bodies.write(tmp_path / "body.glb", [bodies.panel()])), 400, "free")
    assert not made.held.any() and "free" in made.notes[-1]
    vertex = int(np.linalg.norm(made.points - [0.1, 0.12, 0.05], axis=1).argmin())
    normal = made.normals[vertex]
    outcome = Solver(made, MATERIALS["steel"], 0.0008).strike(Blow(made.points[vertex], normal, -normal, 8.0, 10.0, 0.08, "ball"))
    assert outcome.trouble is None and outcome.steps > 50
    length = np.linalg.norm(outcome.field, axis=1)
    assert length.max() > 0.003 and np.median(length) < 0.4 * length.max()
    # A turned and shifted body is not dented at all.
    a = 0.3
    turn = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    assert np.abs(without_motion(made.points, made.points @ turn.T + [1, 2, 3] - made.points)).max() < 1e-9


def test_odd_holds_and_loose_parts_are_named(tmp_path):
    sphere = trimesh.creation.icosphere(4)
    pierced = sphere.faces[np.linalg.norm(sphere.triangles_center - [0, 0, 1], axis=1) > 0.2]
    head = Body(bodies.write(tmp_path / "head.glb", [(sphere.vertices, pierced)]))
    hanging = shell.make(head, 500, "edges")
    assert len(hanging.warnings) == 1 and "hangs by 1 open edges" in hanging.warnings[0] and hanging.points[hanging.held][:, 2].min() > 0.9
    standing = shell.make(head, 500, "auto")
    assert standing.notes[0].startswith("1 small holes are not held") and standing.points[standing.held][:, 1].max() < -0.7
    box = trimesh.creation.box((0.2, 2.0, 0.2)).subdivide().subdivide().subdivide()
    flat = trimesh.creation.box((2.0, 1.0, 2.0)).subdivide().subdivide().subdivide()
    lamp = trimesh.util.concatenate([flat, trimesh.creation.box((0.1, 0.3, 0.1)).apply_translation([0.5, -0.9, 0])])
    path = bodies.write(
        tmp_path / "lamp.glb",
        [(flat.vertices, flat.faces), (lamp.vertices[len(flat.vertices) :], lamp.faces[len(flat.faces) :] - len(flat.vertices))],
    )
    made = shell.make(Body(path), 500, "auto")
    assert made.notes[0].startswith("1 loose parts of 2 follow") and "of paint 1 near (0.5, -0.9, 0)" in made.notes[0]
    assert (
        made.warnings == []
        and shell.make(Body(bodies.write(tmp_path / "post.glb", [(box.vertices, box.faces)])), 500, "auto").warnings == []
    )
    upright = trimesh.creation.cone(0.5, 1.0, sections=48).subdivide().subdivide().subdivide()
    tip = bodies.write(tmp_path / "tip.glb", [(upright.vertices[:, [0, 2, 1]] * [1, -1, 1], upright.faces)])
    assert "stands on" in shell.make(Body(tip), 500, "auto").warnings[0]


def test_many_examples_are_written_with_half_the_bytes(tmp_path):
    from crumple.examples import body as bodies_of

    path, sizes, fields = bodies.write(tmp_path / "body.glb", [bodies.panel(101)]), {}, {}
    for count in (bodies_of.MANY - 1, bodies_of.MANY):
        body, out = Body(path), tmp_path / f"{count}.glb"
        body.write(out, profile.make(body, count, (0.01, 0.03)), {})
        sizes[count] = (out.stat().st_size - path.stat().st_size) / count
        check(path, out, count)
        with crumple.Context(threads=1) as context:
            loaded = context.load(out)
            one = loaded.instance()
            one.hit_displacement(loaded.examples[0].contact_point, -loaded.examples[0].depth * loaded.examples[0].contact_normal)
            fields[count] = one.deformed().positions
    few, many = sizes
    assert sizes[many] < 0.6 * sizes[few]
    # Nodes and files are wrong by less than a hundredth of the deepest example, 0.03 m.
    assert np.abs(fields[few] - fields[many]).max() < 4e-4
    assert "profile 50" in command("info", tmp_path / f"{many}.glb").stdout
    # A contact that moves by a step of these numbers still moves. By a third of it, it would not, and the library refuses such an example.
    slight = profile.make(body, many, (0.01, 0.03))
    for share, loads in ((1.0, True), (1 / 3, False)):
        for made in slight:
            made.field[np.linalg.norm(body.points - made.point, axis=1).argmin()] = share * body.step * made.normal
        body.write(out, slight, {})
        with crumple.Context(threads=1) as context:
            try:
                context.load(out)
            except crumple.CrumpleError as error:
                assert not loads and "does not move its own contact" in str(error)
            else:
                assert loads


def test_interrupted_runs_keep_every_finished_hit(tmp_path):
    import signal
    import subprocess
    import sys
    import time

    path, out = bodies.write(tmp_path / "body.glb", [bodies.panel()]), tmp_path / "out.glb"
    asked = [sys.executable, "-m", "crumple", "examples", path, "-o", out, "--count", "40", "--detail", "300", "--jobs", "2", "--no-report"]
    # Whoever runs the tests in the background ignores the signal, and so would this process.
    heed = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(list(map(str, asked)), start_new_session=True, preexec_fn=heed, **pipes)
    until = time.monotonic() + 300
    while len(list(tmp_path.glob("out_work/0*.npz"))) < 5 and time.monotonic() < until:
        time.sleep(0.05)
    # As a terminal does: to the whole group.
    import os

    os.killpg(process.pid, signal.SIGINT)
    said, wrong = process.communicate(timeout=120)
    kept = sorted(tmp_path.glob("out_work/0*.npz"))
    assert process.returncode == 130 and "every finished hit is kept" in wrong and "Traceback" not in wrong, wrong
    assert len(kept) >= 5 and len(kept) >= said.count(" kg, ") and not list(tmp_path.glob("out_work/*.part"))
    before = {one.name: one.read_bytes() for one in kept}
    asked[asked.index("40")] = str(len(kept) + 1)
    done = subprocess.run(list(map(str, asked)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with crumple.Context(threads=1) as context:
        # Slight dents may miss the mesh's own vertices.
        assert len(kept) // 2 < context.load(out).info.example_count <= len(kept) + 1
    assert all((tmp_path / "out_work" / name).read_bytes() == data for name, data in before.items())


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
    huge = bodies.write(tmp_path / "huge.glb", [bodies.panel(11, size=1000)])
    hole = bodies.write(tmp_path / "hole.glb", [(sphere.vertices, sphere.faces[1:])])
    text = tmp_path / "text.glb"
    text.write_text("no glTF\n")
    capsys.readouterr()
    for arguments, message in [
        ([dust, "--unit", "1"], "join them"),
        ([done], "has morph targets already"),
        ([tmp_path / "missing.glb"], "there is no file"),
        ([text], "cannot be read as glTF 2.0"),
        ([panel, "--mesh", "door"], "has no mesh door; it has: body"),
        ([panel, "--depth", "30", "2"], "must rise"),
        ([panel, "--mass", "20", "1"], "--mass is 20 to 1 kg; it must rise"),
        ([panel, "--radius", "30", "900"], "--radius is 30 to 900 mm; it must rise, up to"),
        ([panel, "-o", panel], "is the input"),
        ([panel, "-o", tmp_path / "out.obj"], "must end in .glb"),
        ([nan], "vertex 5 of body is not finite"),
        ([flat], "have no area"),
        ([closed, "--hold", "edges"], "no open edges"),
        ([panel, "--hold", "marked"], "paint it red"),
        ([panel, "--inner", panel], "has no triangles"),
        ([panel, "--inner", hole], "--inner body: "),
        ([panel, "--inner", f"{closed}/engine"], "has no node engine; it has: body"),
        ([panel, "--inner", "capsule:0,0,0,1,1,1"], "seven numbers"),
        ([huge], "add --unit 0.001 if it is in millimetres (1.42 m)"),
        ([panel, "--unit", "0.0001", "--thickness", "0.8"], "the unit may be wrong"),
        ([panel, "--unit", "0.0001"], "MuJoCo refuses the shell"),
    ]:
        assert main([str(argument) for argument in arguments]) == 1, arguments
        said = capsys.readouterr().err
        assert message in said and said.startswith("error: ") and said.count("\n") == 1, said
    assert list(tmp_path.glob("*.part")) == []


def test_solver_troubles_name_what_to_change():
    def failed(trouble):
        return run.Result(0, None, None, trouble, 0.0, 1.0)

    assert "thicker sheet" in run.advice([failed("the solver became unstable")])
    assert "--hold" in run.advice([failed("the shell did not come to rest")])
    assert "--strikers ball wall" in run.advice([failed("the wall touched another place first")])
    both = run.advice([failed("the blow left nothing"), failed("the solver became unstable"), failed("the solver became unstable")])
    assert "larger --depth" in both and both.index("(2 of 3 hits)") < both.index("(1 of 3 hits)")


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
