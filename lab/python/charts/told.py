"""Error against time and against the number of examples, by what a hit tells, on every body."""

from pathlib import Path

from adjustText import adjust_text
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import CLASSIC, EVERY_BODY, FLOOR, OURS, OURS_LIGHT, PEER, PEER_2, POD, RADIAL, plt

FULL = 24
# What is above or below is drawn at the edge, with its value.
SHOWN = (0.07, 2.3)
LEARNED = [("POD and kriging", POD, "h"), ("neural field", "#444444", ">")]


def draw(directory):
    table = style.read(directory, "told.csv")
    if table is None:
        return
    surrogates = style.read(directory, "told_surrogates.csv")
    peers = [t for t in (style.read(directory, p.name) for p in sorted(Path(directory).glob("peers_*.csv"))) if "rel_l2_median" in (t.rows or [{}])[0]]
    speed(table, surrogates, peers, directory)
    examples(table, surrogates, directory)


def rows_of(table, body, **wanted):
    truth, name, train, test, _ = body
    found = table.where(truth=truth, body=name, train=train, test=test, **wanted) if table else []
    return sorted(found, key=lambda r: r["examples"])


def error_axis(axis):
    axis.set_yscale("log")
    axis.set_ylim(*SHOWN)
    axis.yaxis.set_major_locator(FixedLocator([0.1, 0.2, 0.5, 1, 2]))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axis.yaxis.set_minor_locator(NullLocator())
    axis.set_ylabel("relative L2 error, median")
    axis.axhline(1, color=FLOOR, lw=1, ls=":", zorder=1)


def time_axis(axis, last):
    names = {10: "10 µs", 1e2: "0.1 ms", 1e3: "1 ms", 1e4: "10 ms", 1e5: "0.1 s", 1e6: "1 s", 1e7: "10 s"}
    axis.set_xscale("log")
    axis.set_xlim(6, last)
    axis.xaxis.set_major_locator(FixedLocator([t for t in names if t <= last]))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: names.get(v, "")))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.set_xlabel("time per hit, one thread")


def shown(y):
    return min(max(y, SHOWN[0] * 1.06), SHOWN[1] / 1.06)


def speed(table, surrogates, peers, directory):
    figure, axes = plt.subplots(2, 3, figsize=(15, 10.4))
    axes = axes.ravel()
    bodies = [b for b in EVERY_BODY if b[0] != "presses"]
    for body, axis in zip(bodies, axes):
        labels, xs, ys = [], [], []

        def mark(row, text, colour, marker, size=6, weight="normal", filled=True, spread=True):
            x, y = row["us_per_impact"], shown(row["rel_l2_median"])
            if y != row["rel_l2_median"]:
                text = f"{text}: {row['rel_l2_median']:.2g}"
            if spread and row.get("rel_l2_p25"):
                axis.plot([x, x], [shown(row["rel_l2_p25"]), shown(row["rel_l2_p75"])], color=colour, lw=0.9, alpha=0.45, zorder=2)
            axis.plot([x], [y], marker, color=colour, ms=size, mfc=colour if filled else "white", zorder=4)
            xs.append(x)
            ys.append(y)
            if text:
                labels.append(axis.text(x, y, text, fontsize=8, color=colour, fontweight=weight, zorder=6, path_effects=style.HALO))

        for told, colour, line, filled in (("displacement", OURS_LIGHT, "--", False), ("blow", OURS, "-", True)):
            rows = rows_of(table, body, told=told, method="crumple")
            axis.plot([r["us_per_impact"] for r in rows], [shown(r["rel_l2_median"]) for r in rows], line, color=colour, lw=1.2, zorder=3)
            for r in rows:
                few = r["examples"] in (4, 8, FULL, rows[-1]["examples"])
                mark(r, f"{r['examples']:.0f}" if few else "", colour, "o", 6, "bold", filled, spread=filled)
        for r in rows_of(table, body, told="blow", method="classic", examples=FULL):
            mark(r, "classic", CLASSIC, "P", 7)
        for r in rows_of(table, body, told="blow", method="radial"):
            mark(r, "radial profile", RADIAL, "D")
        for method, colour, marker in LEARNED:
            rows = [r for r in rows_of(surrogates, body, told="blow", method=method) if r["examples"] in (8, FULL)]
            axis.plot([r["us_per_impact"] for r in rows], [shown(r["rel_l2_median"]) for r in rows], color=colour, lw=0.8, zorder=3)
            for r in rows:
                mark(r, f"{r['examples']:.0f}", colour, marker, 6)
        engines(peers, body, mark)
        error_axis(axis)
        if body[0] == "shots":
            time_axis(axis, 4e7)
        else:
            # No engine here, and no error below 0.3.
            time_axis(axis, 2e4)
            axis.set_ylim(0.25, SHOWN[1])
        low = axis.get_ylim()[0]
        axis.text(0.995, 1.02, "no dent at all", transform=axis.get_yaxis_transform(), fontsize=8, color=FLOOR, ha="right", va="bottom")
        floor = table_floor(directory, body)
        if floor and floor > low:
            axis.axhline(floor, color=FLOOR, lw=1.2, ls="--", zorder=1)
        if floor:
            text = f"the truth's own noise: {floor:g}" + ("" if floor > low else ", below")
            axis.text(0.995, 0.01, text, fontsize=8, color=FLOOR, ha="right", va="bottom", transform=axis.transAxes)
        axis.set_title(body[4], loc="left", fontweight="bold")
        adjust_text(labels, x=xs, y=ys, ax=axis, expand=(1.15, 1.5), arrowprops=dict(arrowstyle="-", color="#AAAAAA", lw=0.6), min_arrow_len=6, iter_lim=1000)
    legend = axes[len(bodies)]
    legend.axis("off")
    handles = [
        Line2D([], [], color=OURS, marker="o", label="Crumple, told the blow\n(label: number of examples)"),
        Line2D([], [], color=OURS_LIGHT, marker="o", mfc="white", ls="--", label="the bound: Crumple, told the displacement\nthat the truth left at the contact"),
        Line2D([], [], color=CLASSIC, marker="P", ls="", label=f"classic rule, {FULL} examples, depth by a power law"),
        Line2D([], [], color=RADIAL, marker="D", ls="", label="radial profile, depth by a power law"),
        *(Line2D([], [], color=c, marker=m, lw=0.8, label=f"{n}, 8 and {FULL} examples") for n, c, m in LEARNED),
        Line2D([], [], color=PEER, marker="^", ls="", label="MuJoCo shell, given the striker (shots only;\nthe truth's own solver, other mesh or step)"),
        Line2D([], [], color=PEER_2, marker="p", ls="", label="rapier soft body, given the striker (shots only)"),
    ]
    legend.legend(handles=handles, loc="upper left", fontsize=10, labelspacing=1.0, borderaxespad=0)
    style.title(figure, "Error against time when a hit tells what a rigid-body engine knows: impulse, striker, place")
    notes = "Error over all vertices, of hits that no example shows; point: median, bar: middle half. The door and the front: hits as they come in play."
    style.footer(figure, table, None, notes + " Engines' labels: cells along a side, and step.")
    figure.tight_layout(rect=(0, 0.04, 1, 0.965), h_pad=1.6)
    style.save(figure, directory, "accuracy_speed")


def engines(peers, body, mark):
    """The physics engines on one body, unscaled: they know the striker, as Crumple does."""
    for t in peers:
        for r in t.where(truth=body[0], body=body[1]):
            if r["peer"] not in ("MuJoCo flex", "rapier soft body") or "noise floor" in str(r["quality"]) or not r["us_per_impact"]:
                continue
            cells, _, rest = str(r["quality"]).partition("x cells, ")
            label = {"0.25": "¼", "0.5": "½"}.get(cells, cells) + ", " + rest.split(",")[0] + ("*" if "12 substeps" in rest else "")
            # The two best of each engine have a label.
            best = sorted(x["rel_l2_median"] for x in t.where(truth=body[0], body=body[1], peer=r["peer"]) if "noise floor" not in str(x["quality"]))[:2]
            colour, marker = (PEER, "^") if r["peer"] == "MuJoCo flex" else (PEER_2, "p")
            mark(r, label if r["rel_l2_median"] in best else "", colour, marker)


def table_floor(directory, body):
    table = style.read(directory, "told.csv")
    found = table.one(truth=body[0], body=body[1], method="floor")
    return found and found["rel_l2_median"]


def examples(table, surrogates, directory):
    figure, axes = plt.subplots(2, 4, figsize=(15, 8.2), sharey=True)
    axes = axes.ravel()
    handles = {}
    for body, axis in zip(EVERY_BODY, axes):
        told = "displacement" if body[0] == "presses" else "blow"

        def line(source, told, method, label, **look):
            rows = rows_of(source, body, told=told, method=method)
            if rows:
                (handles[label],) = axis.plot([r["examples"] for r in rows], [shown(r["rel_l2_median"]) for r in rows], label=label, **look)
            return rows

        line(table, "displacement", "crumple", "Crumple, told the displacement (the bound)", color=OURS_LIGHT, ls="--", marker="o", mfc="white")
        rows = line(table, "blow", "crumple", "Crumple, told the blow; band: to the 90th percentile", color=OURS, marker="o")
        axis.fill_between([r["examples"] for r in rows], [shown(r["rel_l2_median"]) for r in rows], [shown(r["rel_l2_p90"]) for r in rows], color=OURS, alpha=0.1, lw=0)
        line(table, told, "classic", "classic rule, told the same", color=CLASSIC, marker="P")
        for method, colour, marker in LEARNED:
            line(surrogates, told, method, f"{method}, told the same", color=colour, marker=marker, lw=0.9)
        for r in rows_of(table, body, told=told, method="radial"):
            handles["radial profile, told the same"] = axis.axhline(shown(r["rel_l2_median"]), color=RADIAL, ls="-.", lw=1.1)
        error_axis(axis)
        axis.set_xscale("log", base=2)
        axis.xaxis.set_major_locator(FixedLocator([4, 8, 16, 24, 32 if body[0] in ("shots", "presses") else 40]))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:.0f}"))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.set_xlabel("examples in the set")
        axis.tick_params(labelleft=True)
        note = " (told the displacement)" if body[0] == "presses" else ""
        axis.set_title(body[4] + note, loc="left", fontweight="bold")
    axes[-1].axis("off")
    axes[-1].legend(list(handles.values()), list(handles), loc="upper left", fontsize=9, labelspacing=0.9, borderaxespad=0)
    style.title(figure, "Error against the number of examples, on every body")
    style.footer(figure, table, None, "Median over hits that no example shows. A press is not a blow, so presses are told the displacement. Their examples are rows of 8 simulations.")
    figure.tight_layout(rect=(0, 0.05, 1, 0.955), h_pad=1.6)
    style.save(figure, directory, "accuracy_examples")
