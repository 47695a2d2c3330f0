"""Every candidate of the selection rule: its error in cross-validation on each body."""

import re

from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import CLASSIC, FLOOR, INK, OURS, PANELS, PEER_2, plt

# Filled, and hollow.
MANY, FEW = "all but one", 8
LOW, HIGH = 0.04, 1.0
ROW, GAP = 0.168, 0.55
# Groups of one, shown together.
SINGLE = ("pool", "mirrors", "distance", "rescaled sum", "basis")


def draw(directory):
    table = style.read(directory, "candidates.csv")
    if table is None:
        return
    names = list(dict.fromkeys(r["candidate"] for r in table.rows))
    heights = places(names)
    bottom = max(heights.values())
    figure, axes = plt.subplots(1, len(PANELS), figsize=(14.2, ROW * (bottom + 1) + 1.75), sharey=True)
    for axis, (truth, body) in zip(axes, PANELS):
        rows = {(r["candidate"], r["examples"]): r for r in table.where(truth=truth, body=body)}
        if rows:
            panel(axis, rows, heights)
        axis.set_title(f"{body}, {truth}", loc="left", fontweight="bold")
        axis.set_xlabel("median relative L2 error")
    axes[0].set_ylim(bottom + 0.8, -0.8)
    axes[0].set_yticks(list(heights.values()), names)
    first = {r["candidate"]: r for r in reversed(table.rows)}
    for name, label in zip(names, axes[0].get_yticklabels()):
        label.set_color(colour(first[name]))
        label.set_fontweight("bold" if first[name]["kept"] == "yes" else "normal")
    changes(axes[-1], first, heights)
    style.title(figure, headline(first))
    legend(figure)
    footer(figure, table)
    above = 0.5 / figure.get_figheight()
    figure.tight_layout(rect=(0, 0.42 / figure.get_figheight(), 0.935, 1 - above), w_pad=0.8)
    style.save(figure, directory, "candidates")


def change(row):
    """The mean change in percent and its standard error, out of the reason."""
    found = re.match(r"([+-][\d.]+) % \(s\.e\. ([\d.]+)\)", row["why"])
    return (float(found[1]), float(found[2])) if found else None


def headline(first):
    """What is seen."""
    found = change(first["new rule"])
    return f"The steps kept take {-found[0]:.0f} % off the error of a carried dent; what else was tried adds little or harms"


def places(names):
    """Heights of the rows, with a gap between groups."""
    heights, y, group = {}, 0.0, None
    for name in names:
        own = name.split(": ")[0]
        own = "step" if own in ("baseline", "step", "new rule") else "single" if own in SINGLE else own
        y += 0 if group is None else 1 if own == group else 1 + GAP
        heights[name], group = y, own
    return heights


def colour(row):
    if row["candidate"] == "baseline":
        return CLASSIC
    if row["candidate"].startswith("bound"):
        return PEER_2
    return OURS if row["kept"] == "yes" else INK


def panel(axis, rows, heights):
    for name, line, hue in (("baseline", "--", CLASSIC), ("new rule", "-", OURS)):
        axis.axvline(rows[name, MANY]["cv_median"], color=hue, lw=1, ls=line, zorder=1)
    for name, y in heights.items():
        many, few = rows[name, MANY], rows.get((name, FEW))
        hue, ends = colour(many), []
        for row, filled in ((few, False), (many, True)):
            if row is None:
                continue
            x = row["cv_median"]
            ends.append(min(max(x, LOW * 1.03), HIGH * 0.97))
            marker = ">" if x > HIGH else "<" if x < LOW else "o"
            axis.plot(ends[-1], y, marker, color=hue, ms=4.6, mfc=hue if filled else "white", mew=1, zorder=4, clip_on=False)
        axis.plot(ends, [y] * len(ends), color=hue, lw=0.8, alpha=0.5, zorder=2)
    axis.set_xscale("log")
    axis.set_xlim(LOW, HIGH)
    axis.xaxis.set_major_locator(FixedLocator([0.05, 0.1, 0.2, 0.5, 1]))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.tick_params(axis="y", length=0, labelsize=8)
    axis.grid(axis="y", color="#F0F0F0", lw=0.6)


def changes(axis, first, heights):
    """The mean change with its standard error, right of the last panel."""
    at = axis.get_yaxis_transform()
    axis.text(1.04, -1.1, "mean change,\nall sets, %", transform=at, fontsize=8, color=FLOOR, va="bottom")
    for name, y in heights.items():
        found = change(first[name])
        if found:
            text = f"{found[0]:+.1f} ± {found[1]:.1f}".replace("-", "−")
            clear = abs(found[0]) > 2 * found[1]
            axis.text(1.04, y, text, transform=at, fontsize=8, color=INK if clear else "#999999", va="center")


def legend(figure):
    dot = dict(marker="o", ls="", ms=5)
    handles = [
        Line2D([], [], color=INK, **dot, label="predicted from all simulations but its own"),
        Line2D([], [], color=INK, mfc="white", **dot, label=f"from {FEW} examples far from each other"),
        Line2D([], [], color=CLASSIC, ls="--", label="baseline"),
        Line2D([], [], color=OURS, label="new rule; kept"),
        Line2D([], [], color=PEER_2, **dot, label="bound: knows what a hit does not tell"),
    ]
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.005, 1 - 0.3 / figure.get_figheight()), ncol=5, columnspacing=1.4, handletextpad=0.4)


def footer(figure, table):
    counts = [re.sub(r" \d+ images; predictions: .*", "", n).rstrip(",") for n in table.comments.get("n", [])]
    lines = [
        "Cross-validation on the training impacts by simulation; held-out impacts unseen. Steps and what stands alone are compared with the baseline, all else with the new rule; "
        "± one standard error over simulations, grey under two.",
        f"{table.said('machine')} · numpy {table.said('numpy')} · " + "; ".join(counts),
    ]
    figure.text(0.01, 0.004, "\n".join(lines), fontsize=8, color="#666666", ha="left", va="bottom", linespacing=1.35)
