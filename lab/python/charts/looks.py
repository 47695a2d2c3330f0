"""How bodies look that are hit again and again: error of displacements and of normals against the number of hits."""

from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import CLASSIC, OURS, POD, RADIAL, plt

BODIES = [("panel", "panel"), ("tube", "drum")]
METHODS = [
    ("crumple", "Crumple", {"color": OURS, "marker": "o"}),
    ("radial", "radial profile", {"color": RADIAL, "marker": "D", "ls": "-."}),
    ("classic", "classic rule", {"color": CLASSIC, "marker": "P"}),
    ("pod", "POD and kriging", {"color": POD, "marker": "h", "ls": "--"}),
]
MEASURES = [
    ("rel_l2", "relative L2 error of displacements", [0.05, 0.1, 0.2, 0.5, 1, 2]),
    ("normals_mean_deg", "mean error of normals in the dent, degrees", [0.2, 0.5, 1, 2, 5, 10, 20]),
]


def draw(directory):
    table = style.read(directory, "looks.csv")
    if table is None:
        return
    figure, axes = plt.subplots(2, 2, figsize=(10, 7.4), sharex=True)
    for row, (measure, name, ticks) in zip(axes, MEASURES):
        for axis, (body, title) in zip(row, BODIES):
            for method, label, look in METHODS:
                # A wreck is one body; medians over many have more than one.
                rows = [r for r in table.where(truth="shots", body=body, method=method) if r["n"] == 1]
                axis.plot([r["hits"] for r in rows], [r[measure] for r in rows], label=label, **look)
            axis.set_xscale("log", base=2)
            axis.set_yscale("log")
            axis.xaxis.set_major_locator(FixedLocator([1, 4, 16, 64]))
            axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:.0f}"))
            axis.yaxis.set_major_locator(FixedLocator(ticks))
            axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
            axis.yaxis.set_minor_locator(NullLocator())
            axis.set_title(title, loc="left", fontweight="bold")
            axis.set_ylabel(name)
            if measure == MEASURES[-1][0]:
                axis.set_xlabel("shots at random places of one body")
    axes[0][0].legend(loc="lower right")
    style.title(figure, "Hit again and again: told the blows, against the solver")
    style.footer(figure, table)
    figure.tight_layout(rect=(0, 0.04, 1, 0.955), h_pad=1.6)
    style.save(figure, directory, "looks")
