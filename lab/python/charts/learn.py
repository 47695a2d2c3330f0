"""Error against the number of examples, up to hundreds."""

from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import CLASSIC, FLOOR, OURS, RADIAL, plt

BODIES = [
    ("shots", "panel", "shots, panel"),
    ("shots", "tube", "shots, drum"),
    ("structure", "door", "door"),
    ("structure", "box", "front of a vehicle"),
    ("steel", "hood", "steel hood"),
    ("dense", "door", "door, hundreds of hits"),
    ("dense", "box", "front, hundreds of hits"),
]
METHODS = [
    ("crumple", "Crumple; band: to the 90th percentile", {"color": OURS, "marker": "o"}),
    ("radial", "radial profile", {"color": RADIAL, "marker": "D", "ls": "-."}),
    ("classic", "classic rule", {"color": CLASSIC, "marker": "P"}),
]
SHOWN = (0.1, 2.3)


def draw(directory):
    table = style.read(directory, "learn.csv")
    if table is None:
        return
    shown = lambda y: min(max(y, SHOWN[0]), SHOWN[1])
    figure, axes = plt.subplots(2, 4, figsize=(15, 8.2), sharey=True)
    axes = axes.ravel()
    handles = {}
    for (truth, body, name), axis in zip(BODIES, axes):
        for method, label, look in METHODS:
            rows = sorted(table.where(truth=truth, body=body, told="blow", method=method), key=lambda r: r["examples"])
            counts, medians = [r["examples"] for r in rows], [shown(r["rel_l2_median"]) for r in rows]
            (handles[label],) = axis.plot(counts, medians, **look)
            if method == "crumple":
                axis.fill_between(counts, medians, [shown(r["rel_l2_p90"]) for r in rows], color=OURS, alpha=0.1, lw=0)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_ylim(*SHOWN)
        axis.yaxis.set_major_locator(FixedLocator([0.2, 0.3, 0.5, 0.7, 1, 2]))
        axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.yaxis.set_minor_locator(NullLocator())
        axis.axhline(1, color=FLOOR, lw=1, ls=":", zorder=1)
        axis.xaxis.set_major_locator(FixedLocator(sorted({r["examples"] for r in table.where(truth=truth, body=body)})))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:.0f}"))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.set_xlabel("examples in the set")
        axis.set_ylabel("relative L2 error, median")
        axis.tick_params(labelleft=True)
        axis.set_title(name, loc="left", fontweight="bold")
    axes[-1].axis("off")
    axes[-1].legend(list(handles.values()), list(handles), loc="upper left", fontsize=9, labelspacing=0.9, borderaxespad=0)
    style.title(figure, "Told the blow: error against the number of examples")
    style.footer(figure, table, None, "Median over hits that no example shows. Dotted: no dent at all.")
    figure.tight_layout(rect=(0, 0.05, 1, 0.955), h_pad=1.6)
    style.save(figure, directory, "learn")
