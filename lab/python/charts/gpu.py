"""Graphics devices: the literature's Figures 5.1 to 5.3, 5.6 and 5.7, marks, and the CPU's cost of recording. Each device is a column."""

import textwrap
from pathlib import Path

from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from charts.speed import decades, duration, short
from style import plt

LOOK = {
    "classic": dict(color=style.CLASSIC, marker="s", label="literature's kernel"),
    "classic rule": dict(color=style.RADIAL, marker="v", label="the library's classic rule"),
    "positions": dict(color=style.OURS, marker="o", lw=2, label="Crumple, positions"),
    "normals": dict(color=style.OURS_LIGHT, marker="D", lw=2, label="Crumple, with normals"),
    "copy": dict(color=style.FLOOR, marker=".", ls="--", label="a copy of as many bytes"),
    "nothing": dict(color="#BBBBBB", marker="", ls=":", label="a submission of nothing"),
}
TRANSFERS = {
    "upload cpu": dict(color=style.RADIAL, marker="s", label="upload: adding the target, CPU"),
    "upload device": dict(color=style.CLASSIC, marker="D", label="upload: the next recording, device"),
    "back device": dict(color=style.PEER, marker="^", label="reading back: copy, device"),
    "back": dict(color=style.PEER_2, marker="v", label="reading back: all of it"),
    "deforming": dict(color=style.OURS, marker="o", lw=2, label="deforming in place"),
}
WIDTH = 5.0


def tables(directory):
    """Of each device, real cards first."""
    found = [style.Table(p) for p in sorted(Path(directory).glob("gpu-*.csv"))]
    return sorted(found, key=lambda t: ("software" in t.said("kind"), t.said("device")))


def draw(directory):
    found = tables(directory)
    if not found:
        return
    for name, chart in CHARTS.items():
        style.save(chart(found), directory, name)


def device(table):
    """Its name, as short as it is plain."""
    return table.said("device").split(" (")[0]


def figure(tables, rows, height, **more):
    return plt.subplots(rows, len(tables), figsize=(max(8.4, WIDTH * len(tables)), height), squeeze=False, **more)


def series(table, workload, method, key="vertices", **more):
    rows = [r for r in table.where(workload=workload, method=method, **more) if r["unit"] in ("ms", "µs")]
    return sorted(rows, key=lambda r: r[key])


def finish(figure, axes, tables, title, more, legend=True):
    at = lambda inches: inches / figure.get_figheight()
    handles, labels = axes.get_legend_handles_labels()
    columns = min(len(labels), 3)
    rows = -(-len(labels) // columns) if legend and labels else 0
    style.title(figure, title)
    kinds = {t.said("machine").split(" (family")[0] + ", " + t.said("cores").split(" (")[0] + " cores" for t in tables}
    first = " · ".join([*sorted(kinds), tables[0].said("rustc").split(" (")[0], "crumple " + tables[0].said("crumple")])
    notes = textwrap.wrap(more, int(15.5 * figure.get_figwidth()))
    if rows:
        figure.legend(handles, labels, loc="lower center", ncol=columns, bbox_to_anchor=(0.5, at(0.28 + 0.15 * len(notes))))
    figure.text(0.01, 0.004, "\n".join([first, *notes]), fontsize=8, color="#666666", ha="left", va="bottom", linespacing=1.35)
    figure.tight_layout(rect=(0, at(0.32 + 0.15 * len(notes) + 0.2 * rows), 1, 1 - at(0.35)))
    return figure


def logarithmic(axis, x=None, y=None):
    if x:
        axis.set_xscale("log")
        decades(axis.xaxis, 0.95 * x[0], 1.05 * x[1], short)
    if y:
        axis.set_yscale("log")
        decades(axis.yaxis, y[0] / 1.5, 1.5 * y[1], duration)
        axis.set_ylim(y[0] / 1.5, 1.5 * y[1])


def span(rows, key):
    values = [r[key] for r in rows if r[key]]
    return min(values), max(values)


def vertices(tables):
    """Above: time. Below: the share of the copy's bandwidth."""
    fig, axes = figure(tables, 2, 7.6, sharex="col", height_ratios=(3, 2))
    for column, table in enumerate(tables):
        above, below = axes[:, column]
        shown = []
        for method, look in LOOK.items():
            rows = [r for r in series(table, "vertices", method) if r["case"] is None]
            shown += rows
            x = [r["vertices"] for r in rows]
            above.plot(x, [r["value"] for r in rows], **look)
            above.fill_between(x, [r["p25"] for r in rows], [r["p75"] for r in rows], color=look["color"], alpha=0.15, lw=0)
            shares = [(r["vertices"], r["share_of_copy"]) for r in rows if r["share_of_copy"] and method != "copy"]
            if shares:
                below.plot(*zip(*shares), **{**look, "label": None})
        logarithmic(above, span(shown, "vertices"), span(shown, "value"))
        below.axhline(1, color=style.FLOOR, ls="--", lw=1)
        below.axhline(0.85, color=style.INK, ls=":", lw=0.9)
        below.set_yscale("log")
        low = min(r["share_of_copy"] for r in shown if r["share_of_copy"])
        decades(below.yaxis, low / 2, 1.5, lambda v: f"{100 * v:g} %", steps=(1, 3))
        below.set_ylim(low / 1.5, 1.5)
        above.set_title(device(table), loc="left", fontweight="bold")
        below.set_xlabel("moved vertices")
    axes[0, 0].set_ylabel("time of one deformation, on the device")
    axes[1, 0].set_ylabel("share of a copy's bandwidth")
    note = "A sheet, one mark that moves every vertex. Medians of interleaved runs; shade: quartiles. Dotted: the aim for real cards, 85 %."
    return finish(fig, axes[0, 0], tables, "Time against the number of moved vertices, on graphics devices", note)


def groups(tables):
    fig, axes = figure(tables, 1, 4.4)
    for axis, table in zip(axes[0], tables):
        sizes = sorted({r["vertices"] for r in table.where(workload="groups")})
        cases = sorted({r["case"] for r in table.where(workload="groups")})
        for method in ("classic", "positions"):
            for n, size in enumerate(sizes):
                rows = series(table, "groups", method, "case", vertices=size)
                look = {**LOOK[method], "label": f"{LOOK[method]['label']}, {short(size)}", "alpha": (n + 1) / len(sizes), "ls": ["-", "--", ":", "-."][len(sizes) - 1 - n]}
                axis.plot([r["case"] for r in rows], [1e6 * r["value"] / r["vertices"] for r in rows], **look)
        axis.set_xscale("log")
        axis.xaxis.set_major_locator(FixedLocator(cases))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.set_ylim(bottom=0)
        axis.set_xlabel("invocations a workgroup")
        axis.set_title(device(table), loc="left", fontweight="bold")
    axes[0, 0].set_ylabel("ns a moved vertex")
    return finish(fig, axes[0, 0], tables, "Workgroup sizes", "A sheet, one mark that moves every vertex, positions only.")


def transfer(tables):
    fig, axes = figure(tables, 1, 4.8)
    for axis, table in zip(axes[0], tables):
        shown = []
        for method, look in TRANSFERS.items():
            if method == "deforming":
                rows = [{**r, "value": r["reference_value"]} for r in series(table, "transfer", "back")]
            else:
                rows = series(table, "transfer", method)
            shown += rows
            axis.plot([r["vertices"] for r in rows], [r["value"] for r in rows], **look)
        logarithmic(axis, span(shown, "vertices"), span(shown, "value"))
        axis.set_xlabel("vertices")
        axis.set_title(device(table), loc="left", fontweight="bold")
    axes[0, 0].set_ylabel("time")
    note = "Upload: a mesh and one example, once a set and device. Reading back: positions, copied by the device and then read by the CPU; engines that deform in place never do."
    return finish(fig, axes[0, 0], tables, "Upload, and reading the vertices back", note)


def processors(tables):
    """The CPU path beside the devices, as the literature's Figure 5.7."""
    fig, axes = figure(tables, 1, 4.4)
    cpu = dict(color=style.PEER, marker="^", lw=2, label="CPU path, all cores")
    for axis, table in zip(axes[0], tables):
        shown = []
        for method, look in (("cpu", cpu), ("positions", {**LOOK["positions"], "label": "the device"}), ("classic", {**LOOK["classic"], "label": "literature's kernel, the device"})):
            rows = [r for r in series(table, "vertices", method) if r["case"] is None]
            shown += rows
            axis.plot([r["vertices"] for r in rows], [r["value"] for r in rows], **look)
        logarithmic(axis, span(shown, "vertices"), span(shown, "value"))
        axis.set_xlabel("moved vertices")
        axis.set_title(device(table), loc="left", fontweight="bold")
    axes[0, 0].set_ylabel("time of one deformation")
    note = "The same work, to the same bits on software drivers. The CPU path writes memory of the CPU, the device the engine's vertex buffer."
    return finish(fig, axes[0, 0], tables, "CPU against graphics device", note)


def marks(tables):
    """Speed against the literature's kernel, at the largest size."""
    fig, axes = figure(tables, 1, 4.4)
    look = dict(color=style.OURS, marker="o", lw=2)
    for axis, table in zip(axes[0], tables):
        largest = {r["case"]: r for r in sorted(table.where(workload="impulses", method="fresh"), key=lambda r: r["vertices"])}
        rows = [largest[c] for c in sorted(largest)]
        ratios = [r["ratio"] for r in rows]
        axis.plot(list(sorted(largest)), ratios, **look)
        for r in rows:
            axis.annotate(f"{r['ratio']:.2g}", (r["case"], r["ratio"]), textcoords="offset points", xytext=(0, 7), ha="center", fontsize=8.5, color=look["color"], path_effects=style.HALO)
        axis.axhline(1, color=style.CLASSIC, lw=1, ls="--")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.xaxis.set_major_locator(FixedLocator(sorted(largest)))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.set_xlim(0.85, 12)
        low, high = min(ratios), max(1, *ratios)
        decades(axis.yaxis, low / 2, 2 * high, lambda v: f"{v:g}", steps=(1, 3))
        axis.set_ylim(low / 2, 2 * high)
        axis.set_xlabel("impulses that overlap, on a fresh body")
        axis.set_title(device(table), loc="left", fontweight="bold")
    axes[0, 0].set_ylabel("times as fast as the literature's")
    note = "Dashed: as many passes of the literature's kernel, one an impulse."
    return finish(fig, axes[0, 0], tables, "Impulses against the literature's kernel", note, legend=False)


def recording(tables):
    fig, axes = figure(tables, 1, 4.4, sharey=True)
    looks = {
        "changed": dict(color=style.OURS, marker="o", lw=2, label="a mark of each changed"),
        "idle": dict(color=style.FLOOR, marker=".", ls="--", label="nothing changed"),
    }
    for axis, table in zip(axes[0], tables):
        shown = []
        for method, look in looks.items():
            rows = series(table, "record", method, "case")
            shown += rows
            x = [r["case"] for r in rows]
            axis.plot(x, [r["value"] for r in rows], **look)
            axis.fill_between(x, [r["p25"] for r in rows], [r["p90"] for r in rows], color=look["color"], alpha=0.15, lw=0)
        axis.plot([1, 1000], [5, 400], ls="", marker="_", ms=14, mew=2, color=style.INK, label="the aims")
        axis.set_xscale("log")
        axis.set_yscale("log")
        low, high = span(shown, "value")
        ticks = [s * 10.0**p for p in range(-2, 6) for s in (1,) if low / 2 <= s * 10.0**p <= 2 * high]
        axis.yaxis.set_major_locator(FixedLocator(ticks))
        axis.yaxis.set_minor_locator(NullLocator())
        axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g} µs"))
        decades(axis.xaxis, 1, 1000, lambda v: f"{v:g}")
        axis.set_xlabel("instances")
        axis.set_title(device(table), loc="left", fontweight="bold")
    axes[0, 0].set_ylabel("CPU time of one recording")
    note = "Bodies of 10 k vertices; a tenth of each one's blocks changes. Medians; shade: first quartile to 90th percentile. Release build, no validation."
    return finish(fig, axes[0, 0], tables, "What recording costs the CPU", note)


CHARTS = {
    "gpu_vertices": vertices,
    "gpu_groups": groups,
    "gpu_marks": marks,
    "gpu_transfer": transfer,
    "gpu_cpu": processors,
    "gpu_record": recording,
}
