"""Writes README.md into the lab's directory from the tables that are there: `report.py DIRECTORY`."""

import statistics
import sys
from pathlib import Path

from style import BODIES, EVERY_BODY, TRUTHS, read

HERE = Path(__file__).parent
FULL = 24
SCENES = [(t, b) for t in TRUTHS for b in BODIES]


def number(x, digits=2):
    return "–" if x is None or isinstance(x, str) else f"{x:.{digits}f}" if abs(x) < 100 else f"{x:.0f}"


def duration(us):
    if us is None or isinstance(us, str):
        return "–"
    return f"{us:.0f} µs" if us < 1000 else f"{us / 1e3:.1f} ms" if us < 1e5 else f"{us / 1e6:.1f} s"


def milliseconds(ms):
    """In three digits."""
    return f"{float(format(ms, '.3g')):g} ms" if ms >= 1 else f"{1e3 * ms:.3g} µs"


def size(count):
    return "–" if count is None else f"{count:.0f} B" if count < 1000 else f"{count / 1e3:.0f} kB" if count < 1e6 else f"{count / 1e6:.1f} MB"


def table(head, rows):
    line = lambda cells: "| " + " | ".join(str(c) for c in cells) + " |"
    return "\n".join([line(head), "|" + "---|" * len(head)] + [line(r) for r in rows]) + "\n"


def picture(directory, name, text):
    return f"![{text}]({name}.svg)\n" if (directory / f"{name}.svg").exists() else ""


def own_text(part):
    """What the author of a part says about it, if anything."""
    path = HERE / "report" / f"{part}.md"
    return path.read_text().rstrip() + "\n" if path.exists() else ""


def pair(row):
    if not row:
        return "–"
    digits = 2 if row["rel_l2_median"] >= 0.1 else 3 if row["rel_l2_median"] >= 0.01 else 4
    return f"{number(row['rel_l2_median'], digits)} / {number(row['rel_l2_p90'], digits)}"


def heads():
    return [f"{t}, {b}" for t, b in SCENES]


TESTS = [
    *[(name, truth, body, "train", "heldout") for truth, body, _, _, name in EVERY_BODY[:2]],
    ("door, examples of wanted depths: held-out", "structure", "door", "train", "heldout"),
    ("the same: play", "structure", "door", "train", "play"),
    ("door, a solver's batch: held-out", "structure", "door", "train_free", "heldout"),
    ("the same: play", "structure", "door", "train_free", "play"),
    ("front, examples of wanted depths: held-out", "structure", "box", "train", "heldout"),
    ("the same: play", "structure", "box", "train", "play"),
    ("front, a solver's batch: held-out", "structure", "box", "train_free", "heldout"),
    ("the same: play", "structure", "box", "train_free", "play"),
    *[(name, truth, body, "train", "heldout") for truth, body, _, _, name in EVERY_BODY[4:]],
]
LEARNED = ("POD and kriging", "neural field")


def told(directory):
    """What Crumple and its peers make of a blow, on every body."""
    t, surrogates = read(directory, "told.csv"), read(directory, "told_surrogates.csv")
    if t is None:
        return ""

    def row(test, source=t, **wanted):
        _, truth, body, train, name = test
        return source.one(truth=truth, body=body, train=train, test=name, **wanted) if source else None

    def most(test):
        return max(r["examples"] for r in t.where(truth=test[1], body=test[2], train=test[3], method="crumple"))

    def by_examples(what):
        lines = []
        for test in TESTS:
            found = [row(test, told=what, method="crumple", examples=n) for n in (4, 8, 16, FULL, most(test))]
            if any(found):
                lines.append([test[0], *map(pair, found)])
        return table(["impacts", "4 examples", "8", "16", str(FULL), "32 or 40"], lines)

    def peers_of(test):
        known = [row(test, told="blow", method=m, examples=n) for m, n in (("crumple", FULL), ("classic", FULL), ("radial", 0))]
        known += [row(test, surrogates, told="blow", method=m, examples=FULL) for m in LEARNED]
        return [test[0], *map(pair, known)] if known[0] else None

    def costs(source, method, told="blow"):
        rows = [r for r in source.where(method=method, told=told) if method == "radial" or r["examples"] == FULL] if source else []
        times = [r["us_per_impact"] for r in rows]
        trained = [r["train_s"] for r in rows if r.get("train_s") is not None]
        if not times:
            return ""
        text = f"{duration(min(times))} to {duration(max(times))} a hit"
        return text + (f", {number(min(trained))} to {number(max(trained))} s of training" if trained else "")

    def floors():
        found = [(name, t.one(truth=truth, body=body, method="floor")) for truth, body, _, _, name in EVERY_BODY]
        return ", ".join(f"{name} {r['rel_l2_median']:g}" for name, r in found if r)

    impulses = [[test[0], *(pair(row(test, told=what, method="crumple", examples=FULL)) for what in ("displacement", "depth", "blow", "impulse")),
                 *(number((row(test, told=what, method="crumple", examples=FULL) or {}).get("depth_error_median")) for what in ("blow", "impulse"))] for test in TESTS]
    peers_lines = [line for line in map(peers_of, TESTS) if line]
    weak = [(test, row(test, told="blow", method="crumple", examples=FULL)) for test in TESTS]
    weak = [f"{test[0] if not test[0].startswith('the same') else test[2] + ' ' + test[4]} with `{test[3]}`: {r['weak_kept']:.0f} of {r['weak']:.0f}" for test, r in weak if r and r["weak"]]
    hits = "; ".join(f"{body} {r['n'] + r['weak']:.0f}" for body, r in dict((f"{x[1]} {x[2]} {x[4]}", row(x, told="displacement", method="crumple", examples=FULL)) for x in TESTS).items() if r)
    sources = [("Crumple", t, "crumple"), ("the classic rule", t, "classic"), ("the radial profile", t, "radial"), *((m, surrogates, m) for m in LEARNED)]
    cost_list = "; ".join(f"{name} {costs(source, method)}" for name, source, method in sources if costs(source, method))
    return f"""## 1. Told what a rigid-body engine knows

{picture(directory, "accuracy_speed", "Relative error against time per hit, told the blow, for Crumple, the classic rule, a radial profile, learned surrogates and physics engines, on five bodies")}
The error is the relative L2 of the displacement field over all vertices, against hits that no example shows (hits: {hits}). The number is the median / the
90th percentile. No dent at all has error 1. A hit tells the contact point and normal, the striker's mass, velocity and radius, and the impulse
that a rigid-body engine reports: the normal momentum without restitution, and friction. It tells neither the depth nor the duration.
The examples know the blows that made them.

Crumple, told the blow:

{by_examples("blow")}
Crumple, told the displacement that the truth left at the contact. No engine knows it. It is the bound: the error that remains if the depth and the lean are exactly right.

{by_examples("displacement")}
"Examples of wanted depths" have speeds that were chosen for a depth, as an artist would. "A solver's batch" has energies that were drawn without regard to
place. "Play" has hits as they come in play, weak ones among them. A hit that leaves less than 2 mm is in no error; counted is
whether the prediction leaves less than 2 mm too ({'; '.join(weak)}). A press is not a blow, so presses have no row in the first table. The truth's own noise is the
least possible error: {floors()}.

With {FULL} examples, by what a hit tells ("impulse": contact point, normal and impulse, nothing of the striker), and the error of the depth at the contact:

{table(["impacts", "displacement", "its depth", "blow", "impulse", "depth error, blow", "depth error, impulse"], impulses)}
Methods that are told the same blow, with the same {FULL} examples:

{table(["impacts", "Crumple", "classic", "radial profile", *LEARNED], peers_lines)}
- The classic rule and the radial profile need a displacement. They get it from a power law of normal impulse, mass and radius, which is
  fitted to the same examples, along the contact normal. The radial profile is fitted to all training impacts.
- "POD and kriging" predicts the coefficients of the examples' modes by a Gaussian process. Its modes stay where the examples were, so it
  needs more examples than there are here. "Neural field" is a network of two layers of 64 that sees each vertex relative to
  the contact. Both predict the shape, and get the depth from the power law and kriging of what it leaves over.
- Times on one thread: {cost_list}. The surrogates run in NumPy and scikit-learn.
- The chart has physics engines on the shots as they are, without scaling. They know the striker, too.

{picture(directory, "accuracy_examples", "Error against the number of examples on every body")}
{engine(directory)}"""


def engine(directory):
    """What a real engine's contact reports cost."""
    t = read(directory, "told_engine.csv")
    if t is None or "striker" not in t.rows[0]:
        return ""
    names = {(truth, body): name for truth, body, name in LEARNING}
    most = {(r["truth"], r["body"]): r["examples"] for r in t.rows}
    rows = []
    for key in dict.fromkeys((r["truth"], r["body"], r["engine"], r["striker"]) for r in t.rows):
        truth, body, engine, striker = key
        n = most[truth, body]
        by_rate = {r["hz"]: r for r in t.where(truth=truth, body=body, examples=n, engine=engine, striker=striker)}
        first = next(iter(by_rate.values()))
        cells = [f"{number(r['rel_l2_median'])} / {number(r['rel_l2_p90'])}" for r in by_rate.values()]
        told_blow = f"{number(first['told_blow_median'])} / {number(first['told_blow_p90'])}"
        apart = f"{number(100 * first['rates_apart_median'], 1)} / {number(100 * first['rates_apart_p90'], 0)}"
        rows.append([names[truth, body], f"{n:.0f}", engine, striker, told_blow, *cells, apart])
    missed = sum(r["missed"] for r in t.rows)
    lines = []
    for engine, striker in dict.fromkeys((r["engine"], r["striker"]) for r in t.rows):
        of = t.where(engine=engine, striker=striker)
        off = [abs(r["rel_l2_median"] - r["told_blow_median"]) for r in of]
        apart = [r["rates_apart_median"] for r in of]
        within, close = (sum(x <= most for x in of) for of, most in ((off, 0.03), (apart, 0.05)))
        lines.append(
            f"| {engine} | {striker} | {within} of {len(of)} | {number(max(off))} | {close} of {len(of)} | {number(100 * max(apart), 1)} |"
        )
    head = ["impacts", "examples", "engine", "striker", "told the blow", "30 Hz", "60 Hz", "240 Hz", "rates apart, %"]
    engines = ", ".join(dict.fromkeys(r["engine"] for r in t.rows))
    return f"""### A real engine's contacts, end to end

Each hit that no set knows runs again in a physics engine ({engines}), body fixed, striker with continuous collision detection. The body is the truth's
mesh. The engine's contact points go through the contact layer with its defaults, and what it makes of them is all
that Crumple is told. The striker is the truth's ball, or a box of the same mass with half the ball's radius as half its edge, which lands flat: a manifold of
up to four points. The ball's radius is known, and the box's is not. Hits by poles are left out. {missed:.0f} of {sum(r["n"] for r in t.rows):.0f} throws left
nothing. "Rates apart" is the deepest of a hit's dents at the three rates over the shallowest, median / 90th percentile.

Aims: the median error within .03 of "told the blow", and the rates within 5 % of each other. Reached with 24 and with up to 100 examples:

| engine | striker | rows within .03 | furthest off | rows within 5 % | furthest apart, % |
|---|---|---|---|---|---|
{chr(10).join(lines)}

Most of what is left is where the engine touches: the next vertex of the mesh, 2 cm away. Boxes are often nearer to the truth than "told the
blow", because a set that is not told the radius takes a typical one. Jolt's continuous collision detection stops a box that lands flat at the first
triangle, where it begins to turn; so its energy comes in parts that depend on the rate.

With as many examples as a body has, at most 100:

{table(head, rows)}

"""


LEARNING = [
    ("shots", "panel", "shots at a panel"), ("shots", "tube", "shots at a drum"), ("steel", "hood", "hits on a steel hood on a welded frame"),
    ("structure", "door", "hits on a door"), ("structure", "box", "hits on the front of a vehicle"),
    ("dense", "door", "a door with hundreds of hits"), ("dense", "box", "a front with hundreds of hits"),
]


def learning(directory):
    """Error against the number of examples, up to hundreds."""
    t = read(directory, "learn.csv")
    if t is None:
        return ""
    methods = ("crumple", "radial", "classic")
    most = lambda truth, body: max(r["examples"] for r in t.where(truth=truth, body=body))

    def rows(told, count=None):
        lines = []
        for truth, body, name in LEARNING:
            n = count or most(truth, body)
            of = lambda m: t.one(truth=truth, body=body, told=told, method=m, examples=n)
            lines.append([name, f"{n:.0f}", *(pair(of(m)) for m in methods)])
        return [line for line in lines if line[2] != "–"]

    names = ["impacts", "examples", "Crumple", "radial profile", "classic"]
    ours = [r for r in t.where(method="crumple") if r["examples"] >= 24]
    span = lambda key, show: f"{show(min(r[key] for r in ours))} to {show(max(r[key] for r in ours))}"
    return f"""### More examples

{picture(directory, "learn", "Error against the number of examples, from 4 to 356, told the blow, on seven bodies: Crumple, a radial profile and the classic rule")}
A set [learns](../model.md#prediction-from-all-examples) from its examples when it is made. Examples and hits tell the striker's shape. The
classic rule and the radial profile get the displacement from the power law of section 1. From {24} examples on, a hit takes {span("us_per_hit", duration)} to the displacements of the nodes the first time, on one thread of a busy
machine, and making a set {span("build_s", number)} s. Told the blow, with all training examples of each body:

{table(names, rows("blow"))}
With 24 examples:

{table(names, rows("blow", 24))}
With 100:

{table(names, rows("blow", 100))}
Told the displacement, with all of them:

{table(names, rows("displacement"))}
{mixed(t)}"""


def mixed(t):
    """Examples of two meshes in one set."""
    found = t.where(truth="structure and dense")
    if not found:
        return ""
    cheap, both = found
    own = max(t.where(truth="structure", body="door", told="blow", method="crumple"), key=lambda r: r["examples"])
    return f"""**Few good examples and many cheap ones.** Hits in play on the door, told the blow: {own["examples"]:.0f} examples of its own mesh leave {pair(own)}; {cheap["examples"]:.0f} of a mesh
with half as many points, carried onto it, {pair(cheap)}; all in one set {pair(both)}. So both may stand in one set.
"""


def readme_table(directory):
    """Error against the number of examples, for the front page."""
    t = read(directory, "learn.csv")
    path = HERE.parents[1] / "README.md"
    if t is None or directory.resolve() != HERE.parents[1] / "docs/lab":
        return
    lines = []
    for truth, body, name in LEARNING:
        most = max(r["examples"] for r in t.where(truth=truth, body=body))
        of = lambda method, n, told="blow": t.one(truth=truth, body=body, told=told, method=method, examples=n)
        counts = [pair(of("crumple", n)) for n in (8, 24, 100)]
        peers = [number(of(method, most)["rel_l2_median"]) for method in ("radial", "classic")]
        lines.append([name, *counts, f"{pair(of('crumple', most))} ({most:.0f})", pair(of("crumple", most, "displacement")), *peers])
    made = table(["", "8 examples, told the blow", "24", "100", "all (how many)", "all, told the displacement", "radial profile", "classic"], lines)
    begin, end = "<!-- from docs/lab/learn.csv -->\n", "<!-- end of docs/lab/learn.csv -->"
    before, rest = path.read_text().split(begin, 1)
    path.write_text(before + begin + made + end + rest.split(end, 1)[1])


def accuracy(directory):
    t = read(directory, "accuracy.csv")
    if t is None:
        return ""

    def line(name, **wanted):
        found = [t.one(truth=truth, body=body, **wanted) for truth, body in SCENES]
        known = [r for r in found if r]
        times = [r["us_per_impact"] for r in known if r["us_per_impact"] is not None]
        sizes = [r["bytes"] for r in known if r["bytes"] is not None]
        span = lambda values, show: "–" if not values else show(min(values)) if show(min(values)) == show(max(values)) else f"{show(min(values))} to {show(max(values))}"
        return [name, *map(pair, found), span(times, duration), span(sizes, size)]

    rows = [line("no dent at all", method="none")]
    rows += [line(f"the classic rule, as is, {FULL} examples", method="classic", examples=FULL)]
    rows += [line(f"the same, weight clamped, {FULL}", method="classic_clamped", examples=FULL)]
    rows += [line("one radial profile, no examples", method="radial")]
    rows += [line(f"Crumple, {n} examples", method="crumple", examples=n) for n in (4, 8, 16, FULL, 32)]
    rows += [line(f"Crumple, {FULL}, baked to {name[:-2]} mm", method=f"baked_{name}", examples=FULL) for name in ("0.01mm", "0.1mm", "1mm")]
    rows += [line(f"Crumple, {n}, told the depth alone", method="depth_only", examples=n) for n in (4, FULL)]
    rows += [line(f"Crumple, all defaults, {n}", method="defaults", examples=n) for n in (4, FULL)]
    rows += [[c.split(" / ")[0] for c in line("the truth's own noise", method="floor")]]
    rows = [r for r in rows if any(c != "–" for c in r[1:])]
    n = {s: t.one(truth=s[0], body=s[1], method="none") for s in SCENES}
    held = "; ".join(f"{a} {b} {r['n']:.0f} impacts of {r['simulations']:.0f} simulations" for (a, b), r in n.items())
    error = lambda s, **wanted: (t.one(truth=s[0], body=s[1], **wanted) or {"rel_l2_median": float("inf")})["rel_l2_median"]
    near = [f"{b} of the {a}" for a, b in SCENES if error((a, b), method="radial") < 1.1 * error((a, b), method="crumple", examples=4) < float("inf")]
    loses = f" Four examples are no better than the profile without any on the {' and the '.join(near)}." if near else ""
    text = f"""## 2. Told the displacement: configurations on the smooth bodies

The error is the relative L2 of the displacement field over all vertices, against impacts that no example shows ({held}). A
method receives the contact point and the displacement that stays there, nothing else. The cost is that of one thread from the contact to
the written positions: prediction, and every vertex touched. Errors are median / 90th percentile. Cost and memory span
the four bodies:

{table(["method", *heads(), "time an impact", "memory"], rows)}
- The time is for positions only; with normals it is {number(ratio(t), 1)} times as long.
- The classic rule is the cheapest that uses examples. It puts the dent where the example was made, not where the body
  was hit. Without the clamp its weight grows without limit where an example barely moves the contact.
- The radial profile is cheaper still and needs next to no memory.{loses} It cannot know that a drum dents along its axis.
- "Told the depth alone" has the same hits reported along the normal, without the tangential part of the displacement, which an engine's impulse
  does not contain. The difference is the value of a dent's lean; every other row of Crumple has it.
- "Crumple" has no depth limit here. With all defaults no dent is deeper than three times the deepest example. Presses that leave under 5 mm are left out, because there is no dent to predict.

{picture(directory, "accuracy_impacts", "Error of every held-out impact")}
"""
    return text + peers(directory) + own_text("accuracy")


def ratio(t):
    rows = [r for r in t.where(method="crumple", examples=FULL) if r["us_with_normals"]]
    factors = sorted(r["us_with_normals"] / r["us_per_impact"] for r in rows)
    return factors[len(factors) // 2] if factors else None


def peers(directory):
    tables = [read(directory, p.name) for p in sorted(directory.glob("peers_*.csv"))]
    rows = [r for t in tables for r in t.rows if "rel_l2_median" in r]
    if not rows:
        return ""
    cells = [[f"{r['peer']} {r['version']}", f"{r['truth']}, {r['body']}", r["quality"], number(r["rel_l2_median"]), number(r["scaled_rel_l2_median"]),
              duration(r["us_per_impact"]), size(r["bytes"]), f"{number(r['failures'], 0)} of {number(r['n'], 0)}"] for r in rows]
    head = ["engine", "impacts", "quality", "error", "error when scaled", "time an impact", "memory", "failed"]
    return f"""### Physics engines on the same impacts

Engines receive more (what strikes, how fast or how far) and simulate the rest. "Error when scaled" is the error after one factor gave the
contact the displacement that Crumple receives.

{table(head, cells)}
{own_text("peers")}"""


def combining(directory):
    t = read(directory, "combine.csv")
    if t is None:
        return ""

    def rows(source):
        for rule in dict.fromkeys(r["rule"] for r in t.where(source=source)):
            cells = [t.one(source=source, rule=rule, truth=truth, body=body, kind="all") for truth, body in SCENES]
            again = [t.one(source=source, rule=rule, truth="shots", body=body, kind="again") for body in BODIES]
            known = [c for c in cells if c]
            kept = [c["retention_worst"] for c in known if c["retention_worst"] is not None]
            yield [rule, *map(pair, cells), " / ".join(number(a["rel_l2_median"]) for a in again if a), number(max(c["seam_worst"] for c in known)), number(min(kept) if kept else None),
                   number(max(c["order_worst"] for c in known)), f"{max(c['inverted_worst'] for c in known):.0f}"]

    head = ["rule", *heads(), "8 times at one place", "seam", "kept", "order", "inverted"]
    n = ", ".join(f"{t.one(truth=a, body=b, kind='all')['n']:.0f} on the {b} of the {a}" for a, b in SCENES)
    return f"""## 3. Several dents

{picture(directory, "combine_errors", "Error of each rule after the last impact")}
Sequences of two to four impacts ({n}), and one shot eight times at one place. First each rule receives the true dent of each
impact on the fresh body, so that only the rule can be wrong. The error is median / 90th percentile after the last impact.
"Seam" is the largest edge jump over the truth's. "Kept" is the displacement kept at earlier contacts over the truth's. "Order" is the
largest difference between two orders of the same impacts over the deepest dent. "Inverted" counts turned triangles beyond the truth's. Each is
the worst over all bodies.

{table(head, rows("true singles"))}
End to end, with {FULL} examples (the library's rules are free of order by construction, the classic rules are not):

{table(head, rows("predicted"))}
{picture(directory, "combine_seams", "Largest seam against what is kept of earlier dents")}
- Shots beside each other nearly add; upon each other they grow as the root of their number; a press is measured from the
  fresh surface, so there the deepest is nearest. No rule that sees only the dents serves all three best.
- The "overlap" rules add as far as two dents are apart and take energies as far as they coincide; nothing in them is fitted. The
  p of a p-norm is not fitted either: the table shows the steps. There are no training sequences, so nothing could be.
{own_text("combine")}"""


def looks(directory):
    t = read(directory, "looks.csv")
    if t is None:
        return ""
    methods = {"crumple": "Crumple", "radial": "radial profile", "classic": "classic", "pod": "POD"}
    head = ["body", "hits", "method", "L2", "normals, mean / p95, degrees", "over reference", "curvature", "FLIP"]

    def line(r):
        over = number(r["normals_over_reference"]) if r["normals_over_reference"] is not None else "–"
        normals = f"{number(r['normals_mean_deg'])} / {number(r['normals_p95_deg'], 1)}"
        return [f"{r['truth']}, {r['body']}", f"{r['hits']:.0f}", methods[r["method"]], number(r["rel_l2"]), normals, over, number(r["curvature_ratio"]), number(r["flip"], 3)]

    single, worn = [r for r in t.rows if r["n"] > 1], [r for r in t.rows if r["n"] == 1]
    return f"""## 4. Looks

{picture(directory, "looks", "Errors of displacements and of normals after 1, 4, 16 and 64 shots at a panel and a drum, for Crumple, a radial profile, the classic rule and POD")}
![The panel after 64 shots: the solver's, Crumple's, a radial profile's and the classic rule's](looks_panel.png)

![The drum after 64 shots, by the same four](looks_tube.png)

All methods are told what a rigid-body engine knows of each shot, and know all training impacts. One body hit again and again:

{table(head, map(line, worn))}
Single hits that no example shows, medians:

{table(head, map(line, single))}
Normals are those of the displaced surface, by area, where the truth moves by a twentieth of its deepest. "Over reference" is explained below. Curvature is the bending energy over
the truth's. [FLIP](https://github.com/NVlabs/flip) compares pictures like those above: 0 if they look the same.

{own_text("looks")}"""


def speed(directory):
    t = read(directory, "speed_vertices.csv")
    if t is None:
        return ""
    names = {"classic": "classic kernel", "crumple": "Crumple", "memcpy": "copying the positions"}
    methods = [m for m in names if t.where(method=m)]
    sizes = sorted({r["moved_vertices"] for r in t.rows})

    def cell(method, size, threads):
        row = t.one(method=method, moved_vertices=size, threads=threads)
        return milliseconds(row["ms"]) if row else "–"

    rows = [[f"{size:,.0f}".replace(",", " "), *(f"{cell(m, size, 1)} / {cell(m, size, 2)}" for m in methods)] for size in sizes]
    return f"""## 7. Speed

{picture(directory, "speed_vertices", "Time against moved vertices, for Crumple, the classic kernel and a copy")}
Time of one deformation by one example, on one thread / on two:

{table(["moved vertices", *(names[m] for m in methods)], rows)}
{picture(directory, "speed_threads", "Time against threads")}
{own_text("speed")}"""


def scene(directory):
    t, budget = read(directory, "scene.csv"), read(directory, "scene_budget.csv")
    if t is None or budget is None:
        return ""

    def line(r):
        shown = "base mesh" if r["shown"] == "base mesh" else f"`set_view` {r['pixels']:g} px"
        return [shown, f"{number(r['ms_per_frame'])} ms", f"{r['vertices_per_frame']:.0f}", size(r["bytes_bodies"]),
                number(r["error_px_p99"], 3), number(r["error_px_max"]), number(r["dent_error_px_p99"], 3), number(r["dent_error_px_max"])]

    head = ["shown", "a frame", "vertices", "bodies", "error p99", "max", "its dents' p99", "max"]
    limit = lambda r: r["budget"] if r["budget"] == "none" else f"{float(r['budget']):.0f}"
    rows = [[limit(r), f"{number(r['hits_ms'])} ms", f"{number(r['deform_ms'])} ms", f"{number(r['deform_ms_max'])} ms", f"{r['vertices_per_frame']:.0f}",
             f"{r['waiting_per_frame']:.0f}", f"{r['frames_after']:.0f}", "yes" if r["same_bits"] in (True, "true") else "no"] for r in budget.rows]
    heads = ["vertices a frame at most", "hits", "deform", "worst", "written", "waiting", "frames until all is shown", "same bits as without"]
    return f"""## 8. A scene

{picture(directory, "scene", "Cost of a frame against the error on the screen, by level of detail")}
{t.said("what")}; cost is {t.said("cost")}. Levels: {t.said("levels")}. Errors are in pixels, of the surface point that covers a pixel, against the base mesh;
those of dents are without what a level's shape is off at rest.

{table(head, [line(r) for r in t.rows])}
More hits than time: {budget.said("what")}; {budget.said("cost")}. Shown by `set_view` of half a pixel.

{table(heads, rows)}
{own_text("scene")}"""


def crowd(directory):
    """The film of many cars, and what its frames cost."""
    t = read(directory, "crowd.csv")
    if t is None:
        return ""
    struck = [r for r in t.rows if r["hits"] > 0]
    names = {"crumple_ms": "Crumple", "contacts_ms": "its contacts", "fold_ms": "its folding", "deform_ms": "its deforming", "physics_ms": "Rapier"}

    def line(key):
        times = [r[key] for r in struck]
        return [names[key], *(f"{number(of(times))} ms" for of in (statistics.median, statistics.mean, max))]

    hits, last = [r["hits"] for r in struck], t.rows[-1]
    film = "![200 cars in two columns meet, and each frame says how long Crumple took for all of them](crowd.webp)\n"
    return f"""## 9. A crowd

{film if (directory / "crowd.webp").exists() else ""}
{t.said("what")}. All that is drawn are vertices that Crumple wrote. Threads: {t.said("threads")}. Cost: {t.said("cost")}. Load: {t.said("load")}.
Levels: {t.said("levels")}.

{table(["in frames with hits", "median", "mean", "worst"], [line(key) for key in names])}
{len(struck)} of {len(t.rows)} frames have hits: {number(statistics.mean(hits), 1)} each, and {max(hits):.0f} at most. In the end there are {last["marks"]:.0f} dents, and a frame without
hits takes {milliseconds(last["crumple_ms"])}.

{own_text("crowd")}"""


def section(directory, heading, part):
    text = own_text(part)
    charts = "\n".join(picture(directory, p.stem, p.stem.replace("_", " ")) for p in sorted(directory.glob(f"{part}*.svg")))
    images = "" if charts else "\n".join(f"![{p.stem.replace('_', ' ')}]({p.name})\n" for p in sorted(directory.glob(f"{part}*.png")))
    # A text that shows its pictures itself has them where it wants them.
    if "![" in text:
        charts = images = ""
    return f"## {heading}\n\n{text}\n{charts}{images}\n" if text or charts or images else ""


def main():
    directory = Path(sys.argv[1])
    tables = [t for t in (read(directory, n) for n in ("accuracy.csv", "combine.csv")) if t]
    machine = tables[0] if tables else None
    where = f"Machine: {machine.said('machine')}, {machine.said('cores')}; {machine.said('rustc')}; crumple {machine.said('crumple')}." if machine else ""
    text = f"""# The lab

Everything here is made by `cargo xtask lab`: tables (CSV), charts (SVG and PNG) and this page. {where}
Four [truths](../../lab/data/README.md), computed by three independent solvers, are the reference. Parameters were chosen by [cross-validation](../model.md#how-the-rule-was-chosen)
on training impacts, never on the held-out ones measured here. Figures are medians unless said otherwise. "Classic" is the rule of the
paper ([model](../model.md#the-classic-rule)); charts call it "literature".

{told(directory)}
{learning(directory)}
{accuracy(directory)}
{combining(directory)}
{looks(directory)}
{section(directory, "5. Stability where methods fail", "stability")}
{section(directory, "6. The paper's own pictures", "pictures")}
{speed(directory)}
{scene(directory)}
{crowd(directory)}"""
    while "\n\n\n" in text:
        text = text.replace("\n\n\n", "\n\n")
    (directory / "README.md").write_text(text.rstrip() + "\n")
    readme_table(directory)
    print(f"report: {directory / 'README.md'}")


if __name__ == "__main__":
    main()
