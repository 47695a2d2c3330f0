"""Accuracy impact by impact, when told the displacement; `told` has the charts of what a hit tells."""

import numpy as np
from matplotlib.ticker import FuncFormatter

import style
from style import BODIES, CLASSIC, FLOOR, INK, OURS, OURS_LIGHT, PANELS, RADIAL, plt

# The set that stands for "a well-made library of examples".
FULL = 24


def draw(directory):
    table, impacts = style.read(directory, "accuracy.csv"), style.read(directory, "accuracy_impacts.csv")
    if table is None:
        return
    each_impact(impacts, table, directory)


def counts(table):
    """How many impacts each panel shows."""
    parts = []
    for truth in style.TRUTHS:
        n = [table.one(truth=truth, body=b, method="none") for b in BODIES]
        parts.append(f"{truth}: " + ", ".join(f"{r['n']:.0f} {b}" for r, b in zip(n, BODIES) if r))
    return "held-out impacts: " + "; ".join(parts)


def grid(height, width=11, **options):
    figure, axes = plt.subplots(2, 2, figsize=(width, height), **options)
    return figure, dict(zip(PANELS, axes.ravel()))


def plain(value, _=None):
    return f"{value:g}" if value < 1000 else f"{value:,.0f}".replace(",", " ")


def each_impact(impacts, table, directory):
    figure, axes = grid(7.8)
    lines = [
        ("crumple", FULL, OURS, f"Crumple, {FULL} examples"),
        ("crumple", 4, OURS_LIGHT, "Crumple, 4 examples"),
        ("radial", 0, RADIAL, "radial profile"),
        ("classic_clamped", FULL, CLASSIC, f"classic, clamped, {FULL}"),
        ("classic", FULL, CLASSIC, f"classic, as is, {FULL}"),
    ]
    for (truth, body), axis in axes.items():
        for at, (method, n, colour, _) in enumerate(lines):
            rows = impacts.where(truth=truth, body=body, method=method, examples=n)
            errors = np.array(sorted(r["rel_l2"] for r in rows))
            if not len(errors):
                continue
            spread = (np.arange(len(errors)) * 0.618 % 1 - 0.5) * 0.5
            axis.plot(errors, at + spread, "o", ms=4, color=colour, alpha=0.6, mew=0)
            axis.plot([np.median(errors)] * 2, [at - 0.36, at + 0.36], color=colour, lw=2)
            axis.annotate(f"{np.median(errors):.2g}", (np.median(errors), at - 0.37), ha="center", va="bottom", fontsize=8, color=INK)
        axis.axvline(1, color=FLOOR, lw=1, ls=":")
        floor = table.one(truth=truth, body=body, method="floor")["rel_l2_median"]
        if floor > 0.02:
            axis.axvline(floor, color=FLOOR, lw=1, ls="--")
        axis.set_xscale("log")
        axis.set_xlim(0.02, 200)
        axis.xaxis.set_major_formatter(FuncFormatter(plain))
        axis.set_ylim(len(lines) - 0.5, -0.65)
        axis.set_yticks(range(len(lines)), [label for *_, label in lines])
        axis.grid(axis="y", visible=False)
        axis.set_xlabel("relative L2 error, logarithmic")
        axis.set_title(style.panel_title(truth, body), loc="left", fontweight="bold")
    style.title(figure, "Every held-out impact: a dot each, the bar is the median")
    style.footer(figure, table, counts(table), "Dotted: no dent at all; dashed: the truth's own noise.")
    figure.tight_layout(rect=(0, 0.045, 1, 0.965), h_pad=1.6)
    style.save(figure, directory, "accuracy_impacts")
