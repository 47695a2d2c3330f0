"""Accuracy against speed, against the number of examples, against stamp sizes, and impact by impact."""

from pathlib import Path

import numpy as np
from adjustText import adjust_text
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter, NullLocator

import style
from style import BODIES, CLASSIC, FLOOR, INK, OURS, OURS_LIGHT, PANELS, PEER, PEER_2, RADIAL, plt

# The set that stands for "a well-made library of examples".
FULL = 24
K = 3


def draw(directory):
    table, impacts = style.read(directory, "accuracy.csv"), style.read(directory, "accuracy_impacts.csv")
    if table is None:
        return
    peers = [t for t in (style.read(directory, p.name) for p in sorted(Path(directory).glob("peers_*.csv"))) if "rel_l2_median" in (t.rows or [{}])[0]]
    speed(table, peers, directory)
    examples(table, directory)
    stamps(table, directory)
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


def log_error(axis, ticks=(0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)):
    axis.set_yscale("log")
    low, high = axis.get_ylim()
    axis.yaxis.set_major_locator(FixedLocator([t for t in ticks if low <= t <= high]))
    axis.yaxis.set_major_formatter(FuncFormatter(plain))
    axis.yaxis.set_minor_locator(NullLocator())


# What is above or below is drawn at the edge, with its value.
SHOWN = (0.05, 2.2)


def speed(table, peers, directory):
    figure, axes = grid(12.4, width=14, sharex=True)
    colours = {}
    for (truth, body), axis in axes.items():
        labels, xs, ys = [], [], []

        def mark(x, y, text, colour, marker, size=6, weight="normal", filled=True):
            inside = min(max(y, SHOWN[0] * 1.06), SHOWN[1] / 1.06)
            if inside != y:
                marker, text = ("^" if y > inside else "v"), f"{text}: {y:.2g}"
            axis.plot([x], [inside], marker, color=colour, ms=size, mfc=colour if filled else "white", zorder=4)
            labels.append(axis.text(x, inside, text, fontsize=8, color=colour, fontweight=weight, zorder=6, path_effects=style.HALO))
            xs.append(x)
            ys.append(inside)

        def spread(x, low, high, colour):
            axis.plot([x, x], [max(low, SHOWN[0]), min(high, SHOWN[1])], color=colour, lw=0.9, alpha=0.45, zorder=2)

        def ours(row, text, colour, marker, size=6, weight="normal", filled=True):
            if row:
                spread(row["us_per_impact"], row["rel_l2_p25"], row["rel_l2_p75"], colour)
                mark(row["us_per_impact"], row["rel_l2_median"], text, colour, marker, size, weight, filled)

        def one(**wanted):
            return table.one(truth=truth, body=body, **wanted)

        automatic = [r for r in table.where(truth=truth, body=body, method="automatic") if r["stamp"] == stamp_of(table)]
        by_n = sorted((r for r in automatic if r["k"] == K), key=lambda r: r["examples"])
        by_k = sorted((r for r in automatic if r["examples"] == FULL), key=lambda r: r["k"])
        for rows, colour, dashes in ((by_k, OURS_LIGHT, "--"), (by_n, OURS, "-")):
            axis.plot([r["us_per_impact"] for r in rows], [r["rel_l2_median"] for r in rows], dashes, color=colour, lw=1.2, zorder=3)
        for r in by_n:
            ours(r, f"{r['examples']:.0f}", OURS, "o", 6, "bold")
        for r in (r for r in by_k if r["k"] != K):
            ours(r, f"K={r['k']:.0f}", OURS_LIGHT, "s", 5)
        ours(one(method="depth_only", examples=FULL), f"{FULL}, told the depth alone", OURS, "o", 6, filled=False)
        for name in ("0.01mm", "0.1mm", "1mm"):
            ours(one(method=f"baked_{name}", examples=FULL), f"baked to {name[:-2]} mm", OURS, "*", 9)
        ours(one(method="anchored", examples=FULL), "anchored only", "#000000", "v", 6, filled=False)
        ours(one(method="classic", examples=FULL), "classic", CLASSIC, "X", 7)
        ours(one(method="classic_clamped", examples=FULL), "classic, clamped", CLASSIC, "P", 7)
        ours(one(method="radial"), "radial profile", RADIAL, "D", 6)
        engines(peers, truth, body, axis, colours, mark, spread)
        axis.set_xscale("log")
        axis.set_xlim(8, 1.5e8)
        axis.set_ylim(*SHOWN)
        log_error(axis)
        axis.xaxis.set_major_locator(FixedLocator([10.0**e for e in range(1, 9)]))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: {1e3: "1 ms", 1e4: "10 ms", 1e5: "0.1 s", 1e6: "1 s", 1e7: "10 s", 1e8: "100 s"}.get(v, f"{v:g} µs")))
        axis.tick_params(labelbottom=True)
        axis.axhline(1, color=FLOOR, lw=1, ls=":", zorder=1)
        axis.text(0.995, 1.02, "no dent at all", transform=axis.get_yaxis_transform(), fontsize=8, color=FLOOR, ha="right", va="bottom")
        floor = one(method="floor")["rel_l2_median"]
        if floor > SHOWN[0]:
            axis.axhline(floor, color=FLOOR, lw=1.2, ls="--", zorder=1)
        axis.text(0.01, max(floor, SHOWN[0]) * 1.02, f"the truth's own noise: {floor:g}" + ("" if floor > SHOWN[0] else ", below"), fontsize=8, color=FLOOR,
                  ha="left", va="bottom", transform=axis.get_yaxis_transform())
        axis.set_title(style.panel_title(truth, body), loc="left", fontweight="bold")
        axis.set_xlabel("time per impact, one thread")
        axis.set_ylabel("relative L2 error, median")
        adjust_text(labels, x=xs, y=ys, ax=axis, expand=(1.15, 1.5), arrowprops=dict(arrowstyle="-", color="#AAAAAA", lw=0.6), min_arrow_len=6, iter_lim=2000)
    style.title(figure, "Accuracy against speed: about as near to the truth as physics engines, in a thousandth of their time")
    legend = [
        Line2D([], [], color=OURS, marker="o", label=f"Crumple, K = {K}, 4 to 32 examples"),
        Line2D([], [], color=OURS_LIGHT, marker="s", ls="--", label=f"K = 1, 2, 4 with {FULL} examples"),
        Line2D([], [], color=OURS, marker="*", ls="", ms=9, label=f"baked to a tolerance, {FULL}"),
        Line2D([], [], color=CLASSIC, marker="P", ls="", label=f"literature's rule, {FULL} examples"),
        Line2D([], [], color="#000000", marker="v", mfc="white", ls="", label=f"Crumple, anchored only, {FULL}"),
        Line2D([], [], color=RADIAL, marker="D", ls="", label="radial profile, no examples"),
    ]
    legend += [Line2D([], [], color=c, marker=m, ls="", label=peer) for peer, (c, m) in colours.items()]
    figure.legend(handles=legend, loc="upper left", bbox_to_anchor=(0.005, 0.972), ncol=5, columnspacing=1.2, handletextpad=0.5)
    notes = "Error over all vertices, given contact point and target displacement; point: median, bar: middle half of the impacts. Engines are given the ball and its flight, and one factor that brings the contact to its displacement;"
    style.footer(figure, table, counts(table), notes + "\nTheir labels: cells along a side (of the truth's), and step; * with 12 substeps of 9 sweeps. Bars of engines: up to the 90th percentile. Arrows: beyond the axis.")
    figure.tight_layout(rect=(0, 0.045, 1, 0.93), h_pad=1.6)
    style.save(figure, directory, "accuracy_speed")


def engines(peers, truth, body, axis, colours, mark, spread):
    """The physics engines' points of one panel, by the error after scaling."""
    looks = [(PEER, "^"), (PEER_2, "p"), ("#8C564B", "<"), ("#444444", ">"), ("#999933", "h")]
    for t in peers:
        for peer in dict.fromkeys(r["peer"] for r in t.rows):
            colour, marker = colours.setdefault(peer, looks[len(colours) % len(looks)])
            for r in t.where(truth=truth, body=body, peer=peer):
                x, y, high = r["us_per_impact"], r["scaled_rel_l2_median"], r["scaled_rel_l2_p90"]
                if not number(y) or not number(x):
                    continue
                if number(high):
                    spread(x, y, high, colour)
                if "noise floor" in str(r["quality"]):
                    mark(x, y, "the truth's own setting", FLOOR, "*", 9)
                else:
                    mark(x, y, short(str(r["quality"])), colour, marker)


def short(quality):
    """A label for a quality: `½, 1 ms`."""
    cells, _, rest = quality.partition("x cells, ")
    cells = {"0.25": "¼", "0.5": "½"}.get(cells, cells)
    step = rest.split(",")[0].split(" (")[0]
    return f"{cells}, {step}" + ("*" if "12 substeps" in rest else "")


def number(value):
    return isinstance(value, float) and value > 0


def stamp_of(table):
    """The stamp size that is the library's default: that of the configurations with all defaults."""
    r = table.one(method="defaults")
    return r["stamp"] if r else 24


def examples(table, directory):
    figure, axes = grid(8.2, sharex=True)
    methods = [
        ("automatic", K, OURS, "-", "o", f"Crumple, automatic, K = {K}"),
        ("defaults", K, OURS_LIGHT, "--", "s", "the same with the default depth limit"),
        ("anchored", K, "#000000", ":", "v", "Crumple, anchored only"),
        ("classic_clamped", 1, CLASSIC, "-", "P", "classic, clamped"),
        ("classic", 1, CLASSIC, ":", "X", "classic, as is"),
    ]
    for (truth, body), axis in axes.items():
        for method, k, colour, line, marker, label in methods:
            rows = [r for r in table.where(truth=truth, body=body, method=method, k=k) if r["stamp"] in (0, stamp_of(table))]
            rows.sort(key=lambda r: r["examples"])
            x = [r["examples"] for r in rows]
            axis.plot(x, [r["rel_l2_median"] for r in rows], line, marker=marker, color=colour, label=label)
            if method in ("automatic", "classic_clamped"):
                axis.fill_between(x, [r["rel_l2_p25"] for r in rows], [r["rel_l2_p75"] for r in rows], color=colour, alpha=0.13, lw=0)
            if method == "automatic":
                axis.plot(x, [r["rel_l2_p90"] for r in rows], color=colour, lw=0.8, label="its 90th percentile")
        r = table.one(truth=truth, body=body, method="radial")
        if r:
            axis.axhline(r["rel_l2_median"], color=RADIAL, ls="-.", lw=1.1, label="one radial profile, no examples")
        axis.axhline(1, color=FLOOR, lw=1, ls=":", label="no dent at all")
        axis.set_yscale("log")
        axis.set_ylim(0.08, axis.get_ylim()[1] if axis.get_ylim()[1] > 3 else 3)
        log_error(axis)
        axis.set_xscale("log", base=2)
        axis.xaxis.set_major_locator(FixedLocator([4, 8, 16, 24, 32]))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:.0f}"))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.set_xlabel("examples in the set")
        axis.set_ylabel("relative L2 error, logarithmic")
        axis.tick_params(labelbottom=True)
        axis.set_title(style.panel_title(truth, body), loc="left", fontweight="bold")
    style.title(figure, "Few examples are enough when they are carried to where the body is hit")
    handles, labels = axes[PANELS[0]].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper left", bbox_to_anchor=(0.005, 0.965), ncol=4, columnspacing=1.4)
    style.footer(figure, table, counts(table), "Median; bands: middle half of the impacts. The presses' examples are prefixes of 32 rows from 8 simulations.")
    figure.tight_layout(rect=(0, 0.05, 1, 0.905), h_pad=1.6)
    style.save(figure, directory, "accuracy_examples")


def stamps(table, directory):
    figure, axes = grid(7.6, sharex=True)
    for (truth, body), axis in axes.items():
        top = 0
        for n, colour, marker in ((4, OURS_LIGHT, "s"), (FULL, OURS, "o")):
            rows = sorted(table.where(truth=truth, body=body, method="automatic", examples=n, k=K), key=lambda r: r["stamp"])
            rows = [r for r in rows if r["stamp_bytes"]]
            if not rows:
                continue
            x = [r["stamp_bytes"] / n / 1e3 for r in rows]
            axis.plot(x, [r["rel_l2_median"] for r in rows], marker=marker, color=colour, label=f"{n} examples")
            axis.plot(x, [r["rel_l2_p90"] for r in rows], color=colour, lw=0.8, ls=":", label=f"{n} examples, 90th percentile")
            top = max([top] + [r["rel_l2_p90"] for r in rows])
            if n == FULL:
                for r, at in zip(rows, x):
                    axis.annotate(f"{r['stamp']:.0f}", (at, r["rel_l2_median"]), textcoords="offset points", xytext=(0, -13), ha="center", fontsize=8, color=colour)
        axis.set_xscale("log")
        axis.set_ylim(0, top * 1.12)
        axis.xaxis.set_major_formatter(FuncFormatter(plain))
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_xlabel("stamp, kB an example, logarithmic (labels: nodes a side)")
        axis.set_ylabel("relative L2 error")
        axis.tick_params(labelbottom=True)
        axis.set_title(style.panel_title(truth, body), loc="left", fontweight="bold")
    style.title(figure, "What a finer stamp buys")
    handles, labels = axes[PANELS[0]].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper left", bbox_to_anchor=(0.005, 0.963), ncol=4)
    style.footer(figure, table, counts(table), "A node takes 16 bytes: displacement, height, change of the normal, facing.")
    figure.tight_layout(rect=(0, 0.05, 1, 0.93), h_pad=1.6)
    style.save(figure, directory, "accuracy_stamps")


def each_impact(impacts, table, directory):
    figure, axes = grid(7.8)
    lines = [
        ("automatic", K, FULL, OURS, f"Crumple, {FULL} examples"),
        ("automatic", K, 4, OURS_LIGHT, "Crumple, 4 examples"),
        ("anchored", K, FULL, "#000000", f"anchored only, {FULL}"),
        ("radial", 0, 0, RADIAL, "radial profile"),
        ("classic_clamped", 1, FULL, CLASSIC, f"classic, clamped, {FULL}"),
        ("classic", 1, FULL, CLASSIC, f"classic, as is, {FULL}"),
    ]
    for (truth, body), axis in axes.items():
        for at, (method, k, n, colour, _) in enumerate(lines):
            rows = [r for r in impacts.where(truth=truth, body=body, method=method, k=k, examples=n) if r["stamp"] in (0, stamp_of(table))]
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
