"""Rules that combine dents: error after the last impact, and seams against what is kept of earlier dents."""

import numpy as np
from adjustText import adjust_text
from matplotlib.colors import LogNorm
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import PANELS, plt

SCENES = [
    ("shots", "panel", "all", "shots\npanel"),
    ("shots", "tube", "all", "shots\ntube"),
    ("shots", "panel", "again", "8 times\npanel"),
    ("shots", "tube", "again", "8 times\ntube"),
    ("presses", "panel", "all", "presses\npanel"),
    ("presses", "tube", "all", "presses\ntube"),
]


OURS = "energies"
"""The library's rule."""


def draw(directory):
    table = style.read(directory, "combine.csv")
    if table is None:
        return
    errors(table, directory)
    seams(table, directory)


def sequences(table):
    return "sequences: " + "; ".join(f"{t} {b} {table.one(truth=t, body=b, kind='all')['n']:.0f}" for t, b in PANELS)


def rules(table, source):
    return list(dict.fromkeys(r["rule"] for r in table.where(source=source) if r["rule"] != "no dent"))


def errors(table, directory):
    sources = [("true singles", "fed with each impact's own true dent: only the rule is wrong"), ("predicted", "end to end: the library predicts the dents, 24 examples")]
    names = {source: rules(table, source) for source, _ in sources}
    heights = [len(names[s]) for s, _ in sources]
    figure, axes = plt.subplots(2, 1, figsize=(8.6, 0.29 * sum(heights) + 2.6), height_ratios=heights)
    for axis, (source, title) in zip(axes, sources):
        found = {(r["rule"], r["truth"], r["body"], r["kind"]): r for r in table.where(source=source)}
        cells = [[found.get((rule, t, b, k)) for t, b, k, _ in SCENES] for rule in names[source]]
        values = np.array([[c["rel_l2_median"] if c else np.nan for c in row] for row in cells])
        axis.imshow(values, cmap="RdYlBu_r", norm=LogNorm(0.1, 1.5), aspect="auto", alpha=0.85)
        best = np.nanmin(values, axis=0)
        for i, row in enumerate(cells):
            for j, cell in enumerate(row):
                if cell:
                    dark = not 0.14 < values[i, j] < 1.1
                    axis.text(j, i, f"{values[i, j]:.2f}  ({cell['rel_l2_max']:.2f})", ha="center", va="center", fontsize=8.5, color="white" if dark else "#222222",
                              fontweight="bold" if values[i, j] <= best[j] * 1.0001 else "normal")
        axis.set_xticks(range(len(SCENES)), [s[3] for s in SCENES])
        axis.xaxis.tick_top()
        axis.set_yticks(range(len(names[source])), names[source])
        for tick, rule in zip(axis.get_yticklabels(), names[source]):
            tick.set_fontweight("bold" if rule in (OURS, "all defaults") else "normal")
        axis.grid(False)
        axis.tick_params(length=0)
        for side in axis.spines.values():
            side.set_visible(False)
        axis.set_title(title, loc="left", fontweight="bold", fontsize=9.5, pad=8)
    style.title(figure, "Several dents: relative L2 error after the last impact, median (worst)")
    style.footer(figure, table, sequences(table), "8 times: one shot repeated at one vertex, 2 cases a body. Bold figures: the best of their column; bold rules: the library's.")
    figure.tight_layout(rect=(0, 0.035, 1, 0.975), h_pad=2)
    style.save(figure, directory, "combine_errors")


def seams(table, directory):
    figure, axes = plt.subplots(2, 2, figsize=(12.2, 9.2))
    norm = LogNorm(0.1, 1)
    # The p-norm 1 is the sum wherever dents point the same way.
    names = [r for r in rules(table, "true singles") if r != "p-norm 1"]
    for (truth, body), axis in zip(PANELS, axes.ravel()):
        rows = [table.one(source="true singles", truth=truth, body=body, kind="all", rule=rule) for rule in names]
        xs, ys = [r["retention_mean"] for r in rows], [r["seam_worst"] for r in rows]
        for x, y, r in zip(xs, ys, rows):
            axis.plot([r["retention_worst"], x], [y, y], color="#D5D5D5", lw=0.8, zorder=1)
            marker = "s" if r["ordered"] == "yes" else "o"
            axis.scatter([x], [y], c=[r["rel_l2_median"]], cmap="RdYlBu_r", norm=norm, s=44, marker=marker, edgecolors="#333333", linewidths=1.6 if r["rule"] == OURS else 0.6, zorder=3)
        axis.set_yscale("log")
        axis.axvline(1, color=style.FLOOR, lw=0.9, ls=":")
        axis.axhline(1, color=style.FLOOR, lw=0.9, ls=":")
        low, high = min(ys + [1]) * 0.9, max(ys) * 1.1
        axis.set_ylim(low, high)
        axis.yaxis.set_major_locator(FixedLocator([t for t in (0.9, 1, 1.1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 4) if low <= t <= high]))
        axis.yaxis.set_minor_locator(NullLocator())
        axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        left, right = axis.get_xlim()
        axis.set_xlim(left, right + 0.05 * (right - left))
        labels = [axis.text(x, y, str(i), fontsize=8.5, fontweight="bold" if r["rule"] == OURS else "normal", zorder=5, path_effects=style.HALO) for i, (x, y, r) in enumerate(zip(xs, ys, rows), 1)]
        adjust_text(labels, x=xs, y=ys, ax=axis, expand=(1.3, 1.5), force_text=(0.4, 0.8), iter_lim=2000, arrowprops=dict(arrowstyle="-", color="#999999", lw=0.6), min_arrow_len=4)
        axis.set_title(style.panel_title(truth, body), loc="left", fontweight="bold")
        axis.set_xlabel("kept at earlier contacts, over the truth's: mean (line: down to the worst)")
        axis.set_ylabel("largest edge jump over the truth's, worst, logarithmic")
    style.title(figure, "Seams against forgetting: the truth is where the dotted lines cross, colour is the error to it")
    style.footer(figure, table, sequences(table), "Fed with each impact's own true dent. Circles: free of order; squares: depend on it. Bold and thick: the library's.")
    figure.tight_layout(rect=(0, 0.045, 0.83, 0.965), h_pad=1.6)
    for i, rule in enumerate(names):
        figure.text(0.842, 0.925 - 0.0205 * i, f"{i + 1}", fontsize=9, ha="right", fontweight="bold" if rule == OURS else "normal")
        figure.text(0.85, 0.925 - 0.0205 * i, rule, fontsize=9, fontweight="bold" if rule == OURS else "normal")
    scale = plt.cm.ScalarMappable(norm=norm, cmap="RdYlBu_r")
    bar = figure.colorbar(scale, cax=figure.add_axes([0.845, 0.12, 0.014, 0.26]), label="relative L2 error, median")
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    bar.ax.yaxis.set_major_locator(FixedLocator([0.1, 0.2, 0.5, 1]))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    style.save(figure, directory, "combine_seams")
