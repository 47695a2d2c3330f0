"""Sweeps over what breaks methods: Crumple blue, the literature's rule vermillion."""

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import BODIES, plt

NAMES = {"panel": "panel (hood)", "tube": "tube (drum)"}
OURS, CLASSIC, BLEND, AS_IS = "crumple", "classic, clamped", "classic, blend 0.5", "classic, as is"
LOOK = {
    OURS: dict(color=style.OURS, lw=2.2, zorder=4, label="Crumple"),
    CLASSIC: dict(color=style.CLASSIC, lw=1.5, ls="-", label="literature, weight clamped"),
    BLEND: dict(color=style.RADIAL, lw=1.5, ls="-.", label="literature, blend 0.5"),
    AS_IS: dict(color=style.CLASSIC, lw=1.5, ls="--", label="literature, as is"),
}


def draw(directory):
    for name, chart in [("impulse", impulse), ("rim", rim), ("hits", hits), ("order", order), ("rates", rates), ("opposite", opposite), ("support", support), ("scale", scale), ("meshes", meshes), ("inversion", inversion)]:
        table = style.read(directory, f"stability_{name}.csv")
        if table is not None and table.rows:
            figure = chart(table)
            style.save(figure, directory, f"stability_{name}")


def methods(table):
    return [m for m in LOOK if any(r.get("method") == m for r in table.rows)]


def line(axis, rows, x, y, method, **more):
    # No dent at all has no place on a logarithmic axis: the line breaks off there.
    shown = lambda v: v if np.isfinite(v) and (v > 0 or axis.get_yscale() != "log") else np.nan
    points = [(r[x], shown(r[y])) for r in rows if isinstance(r[x], float) and isinstance(r[y], float)]
    if points:
        axis.plot(*zip(*points), **{**LOOK[method], **more})


def under(figure, axis, columns=4, y=0.055):
    handles, labels = axis.get_legend_handles_labels()
    unique = dict(zip(labels, handles))
    figure.legend(unique.values(), unique.keys(), loc="lower center", ncol=columns, bbox_to_anchor=(0.5, y))


def finish(figure, axis, table, n, more="", bottom=0.13, top=0.92, columns=4, legend=0.055):
    style.footer(figure, table, n, more)
    under(figure, axis, columns, legend)
    figure.tight_layout(rect=(0, bottom, 1, top))


def powers(axis, which="x", every=3):
    target = axis.xaxis if which == "x" else axis.yaxis
    low, high = axis.get_xlim() if which == "x" else axis.get_ylim()
    low, high = int(np.ceil(np.log10(low) - 1e-9)), int(np.floor(np.log10(high) + 1e-9))
    ticks = [10.0**p for p in range(low, high + 1) if p % every == 0]
    target.set_major_locator(FixedLocator(ticks))
    target.set_minor_locator(NullLocator())
    target.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}" if 1e-3 < v < 2e3 else f"$10^{{{round(np.log10(v))}}}$"))


def impulse(table):
    figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.6), sharey=True)
    for body, axis in zip(BODIES, axes):
        for method in methods(table):
            rows = table.where(body=body, method=method)
            seen = [r for r in rows if r["depth_median"] and r["depth_median"] > 1e-9]
            line(axis, seen, "target_over_limit", "depth_median", method)
            xs = [r["target_over_limit"] for r in seen]
            axis.fill_between(xs, [r["depth_median"] for r in seen], [r["depth_worst"] for r in seen], color=LOOK[method]["color"], alpha=0.15, lw=0)
            broken = [r for r in rows if r["all_finite"] == "false"]
            if broken:
                axis.plot([r["target_over_limit"] for r in broken], [1] * len(broken), "x", color=style.INK, ms=5, label="not finite")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.axhline(1, color=style.FLOOR, lw=0.8, ls=":")
        axis.set_ylim(1e-7, 1e42)
        powers(axis, "x")
        powers(axis, "y", 6)
        axis.set_title(NAMES[body], loc="left", fontweight="bold")
        axis.set_xlabel("impulse x 10 ms / 1 kg / depth limit")
    axes[0].set_ylabel("deepest vertex after 75 hits / depth limit")
    style.title(figure, "75 hits of 1e-6 to 1e12 N s: the unclamped weight explodes, the clamped one cannot be gentle")
    finish(figure, axes[1], table, f"{table.rows[0]['n']:.0f} sequences of 75 random hits a point", "Line: median; shade: to the worst. The literature's rule displaces by impulse x 10 ms / 1 kg; Crumple predicts the blow.", bottom=0.15, columns=5, legend=0.075)
    return figure


def rim(table):
    figure, axes = plt.subplots(1, 3, figsize=(11.6, 4.3))
    for axis in axes[1:]:
        axis.set_yscale("log")
    for axis, (y, label) in zip(axes, [("depth_at_contact_over_target", "at the contact / asked for"), ("depth_over_target", "deepest vertex / asked for"), ("change_m_per_m", "fastest vertex, m per m of contact")]):
        for method in methods(table):
            line(axis, table.where(method=method), "distance_over_radius", y, method)
        axis.axvline(1, color=style.FLOOR, lw=0.8, ls=":")
        axis.set_xlabel("distance from the example's contact / its radius")
        axis.set_title(label, loc="left", fontsize=9.5, fontweight="bold")
    axes[0].set_ylim(0, 1.15)
    for axis in axes[1:]:
        powers(axis, "y", 1)
    style.title(figure, "A contact walks off an example: the literature's dent explodes at the rim or fades, then is gone")
    finish(figure, axes[0], table, f"{len(table.where(method=OURS))} contacts", "Flat sheet with three smooth bowls; dotted: the rim of the one in whose middle the walk begins. Weight = asked for / what the example does at the contact.", bottom=0.16, top=0.91, legend=0.08)
    return figure


def hits(table):
    figure, axes = plt.subplots(2, 2, figsize=(10.4, 6.6), sharex=True)
    for column, body in enumerate(BODIES):
        for row, (y, label, low, high) in enumerate([("depth", "deepest vertex / depth limit", 0.2, 5), ("seam", "largest edge jump / example", 0.05, 50)]):
            axis = axes[row, column]
            axis.set_xscale("log")
            axis.set_yscale("log")
            for method in methods(table):
                line(axis, table.where(body=body, method=method), "hits", y, method, marker="o", ms=3.5)
            axis.set_ylim(low, high)
            axis.yaxis.set_major_locator(FixedLocator([t for t in (0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50) if low <= t <= high]))
            axis.yaxis.set_minor_locator(NullLocator())
            axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
            powers(axis, "x", 1)
            axis.axhline(1, color=style.FLOOR, lw=0.8, ls=":")
            unclamped = [r for r in table.where(body=body, method=AS_IS) if r[y] and r[y] > high]
            if unclamped:
                first = unclamped[0]
                axis.annotate(f"as is: $10^{{{np.log10(first[y]):.0f}}}$ after {first['hits']:.0f} hits", (first["hits"], high), xytext=(8, -12), textcoords="offset points", color=style.CLASSIC, fontsize=8.5, va="top")
            if column == 0:
                axis.set_ylabel(label)
            if row == 0:
                axis.set_title(NAMES[body], loc="left", fontweight="bold")
            else:
                axis.set_xlabel("random hits")
    last = max(r["hits"] for r in table.rows)
    ours, classic = [max(r["bytes_of_damage"] for r in table.where(method=m, hits=last)) for m in (OURS, CLASSIC)]
    style.title(figure, f"{last:,.0f} random hits: bounded, in {ours / 1e3:.1f} kB (the literature's state: {classic / 1e3:.0f} kB)")
    finish(figure, axes[0, 0], table, "one sequence a body, 24 examples", "Example: the largest edge jump of all examples. Blending, and the rule as is, were stopped at 10 000 hits.", bottom=0.1, top=0.945, legend=0.05)
    return figure


def order(table):
    figure, axes = plt.subplots(2, 2, figsize=(9.6, 6.4), sharex=True)
    for column, body in enumerate(BODIES):
        for row, (y, label) in enumerate([("results_worst", "different results"), ("apart_worst", "furthest apart / deepest")]):
            axis = axes[row, column]
            axis.set_yscale("log")
            for method in methods(table):
                rows = [dict(r, apart_worst=max(r["apart_worst"], 1e-9)) for r in table.where(body=body, method=method)]
                line(axis, rows, "hits", y, method, marker="o", ms=4)
            if row == 0:
                rows = table.where(body=body, method=OURS)
                axis.plot([r["hits"] for r in rows], [r["orders"] for r in rows], color=style.FLOOR, lw=1, ls=":", label="orders tried")
                axis.set_ylim(0.8, 120)
                powers(axis, "y", 1)
                axis.set_title(NAMES[body], loc="left", fontweight="bold")
            else:
                axis.set_xlabel("hits")
                axis.set_ylim(3e-10, 100)
                powers(axis, "y", 3)
            if column == 0:
                axis.set_ylabel(label)
    style.title(figure, "The same hits in other orders: one result, or a different body for each order")
    n = table.rows[0]
    finish(figure, axes[0, 0], table, f"{n['n']:.0f} scenes, up to {max(r['orders'] for r in table.rows):.0f} orders each", "The worst scene. Results are told apart by a hash of every bit of the positions; the same bits are drawn at 1e-9.", bottom=0.115, top=0.945, columns=5, legend=0.055)
    return figure


def rates(table):
    ways = list(dict.fromkeys(r["way"] for r in table.rows))
    kinds = [("whole", "o", "-", "whole"), ("one a step", "s", "--", "one impulse a step"), ("four a step", "^", ":", "four impulses a step")]
    figure, axes = plt.subplots(2, len(ways), figsize=(13, 6.2), sharex=True, sharey=True)
    for row, body in enumerate(BODIES):
        for axis, way in zip(axes[row], ways):
            colour = style.CLASSIC if way.startswith("classic") else style.OURS
            for i, (kind, marker, dash, label) in enumerate(kinds):
                rows = table.where(body=body, way=way, reported=kind)
                xs = np.array([r["rate_hz"] for r in rows]) * (1 + 0.05 * (i - 1))
                ys = [r["depth_median"] for r in rows]
                spread = [[y - r["depth_least"] for y, r in zip(ys, rows)], [r["depth_most"] - y for y, r in zip(ys, rows)]]
                axis.errorbar(xs, ys, yerr=spread, color=colour, marker=marker, ls=dash, lw=1.3, ms=5, elinewidth=0.8, capsize=2, mfc="white" if i else colour, label=label)
            axis.axhline(1, color=style.FLOOR, lw=0.8, ls=":")
            axis.set_xscale("log")
            axis.xaxis.set_major_locator(FixedLocator([30, 60, 144, 240]))
            axis.xaxis.set_minor_locator(NullLocator())
            axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
            axis.set_ylim(0, 2.1)
            if row == 0:
                who, rest = way.split(", ", 1)
                rest = rest.replace(", ", ",\n")
                axis.set_title(("Literature" if who == "classic" else "Crumple") + "\n" + rest, loc="left", fontsize=9.5, fontweight="bold", color=colour)
            else:
                axis.set_xlabel("frame rate, Hz")
        axes[row, 0].set_ylabel(f"{NAMES[body]}\ndepth / whole at 60 Hz")
    style.title(figure, "One contact of 25 ms at four frame rates: with a contact id its parts are one dent")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, bbox_to_anchor=(0.5, 0.06))
    style.footer(figure, table, f"{max(r['n'] for r in table.rows):.0f} contacts a point, begun at random phases of a step", "Median; bars from least to most.")
    figure.tight_layout(rect=(0, 0.1, 1, 0.95))
    return figure


def opposite(table):
    figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.5))
    for axis, (y, label) in zip(axes, [("depth_over_target", "deepest vertex / asked for"), ("miss_over_target", "distance from what was asked, at the contact / asked for")]):
        for method in methods(table):
            line(axis, table.where(method=method), "angle_deg", y, method)
        axis.set_xlabel("angle between the two examples, degrees")
        axis.set_title(label, loc="left", fontweight="bold", fontsize=9.5)
        axis.xaxis.set_major_locator(FixedLocator([0, 45, 90, 135, 180]))
        axis.set_ylim(bottom=0)
    style.title(figure, "Two examples that push apart, up to opposite ones: nothing is blown up where they cancel")
    finish(figure, axes[0], table, f"{len(table.where(method=OURS))} angles", "A sheet with two bowls in one place, a hit straight down beside their middle. 1 on the right: no dent.", bottom=0.16, legend=0.075)
    return figure


def support(table):
    figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.5))
    for axis, (y, label) in zip(axes, [("rel_l2", "relative L2 error to the example moved to the hit"), ("depth_over_target", "deepest vertex / asked for")]):
        for method in methods(table):
            line(axis, table.where(method=method), "radius_over_edge", y, method)
        axis.set_xscale("log")
        powers(axis, "x", 1)
        edges = round((table.rows[-1]["radius_over_edge"] / table.rows[-1]["radius_m"]))
        axis.axvline(0.5 * edges, color=style.FLOOR, lw=0.8, ls=":")
        axis.set_xlabel("radius of the example / edge length")
        axis.set_title(label, loc="left", fontweight="bold", fontsize=9.5)
    axes[0].set_yscale("log")
    axes[0].axhline(1, color=style.FLOOR, lw=0.8)
    powers(axes[0], "y", 1)
    axes[1].set_yscale("symlog", linthresh=1)
    axes[1].yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axes[1].set_ylim(bottom=-0.05)
    style.title(figure, "Examples from a few vertices to far beyond the body")
    finish(figure, axes[0], table, f"{len(table.where(method=OURS))} radii", "Error 1: what no dent at all gets. Dotted: half the body. Off the example there is no dent from the literature's rule.", bottom=0.16, legend=0.075)
    return figure


def scale(table):
    figure, axes = plt.subplots(2, 2, figsize=(10.4, 6.8), sharey=True)
    for row, (sweep, x, label) in enumerate([("scale", "scale", "size of the scene, times the original"), ("distance", "distance_over_size", "distance from the origin / size of the body")]):
        for column, body in enumerate(BODIES):
            axis = axes[row, column]
            tiny = 1e-9
            for method in methods(table):
                rows = [dict(r, rel_l2=max(r["rel_l2"], tiny)) for r in table.where(body=body, method=method, sweep=sweep)]
                line(axis, rows, x, "rel_l2", method, marker="o", ms=4)
            rows = [r for r in table.where(body=body, method=OURS, sweep=sweep) if r["rounding_rel_l2"]]
            axis.plot([r[x] for r in rows], [r["rounding_rel_l2"] for r in rows], color=style.FLOOR, ls=":", lw=1.4, label="rounding of positions to 32 bits")
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.set_ylim(tiny / 2, 3)
            powers(axis, "x", 2 if row == 0 else 1)
            powers(axis, "y", 3)
            axis.set_xlabel(label)
            if row == 0:
                axis.set_title(NAMES[body], loc="left", fontweight="bold")
        axes[row, 0].set_ylabel("relative L2 to scale 1 at the origin")
    style.title(figure, "From a millionth to a million times the size: the same dents to 1.2 %")
    finish(figure, axes[0, 0], table, "20 random hits a point, 8 examples", "Exact agreement is drawn at 1e-9.", bottom=0.11, top=0.945, columns=3, legend=0.05)
    return figure


def meshes(table):
    names = list(dict.fromkeys(r["mesh"] for r in table.rows))
    columns = [("finite", "finite"), ("bounded", "bounded"), ("seams_closed", "seams\nclosed"), ("order_free", "free of\norder")]
    figure, axis = plt.subplots(figsize=(10.4, 0.29 * len(names) + 1.9))
    axis.set_xlim(-0.5, 9.4)
    axis.set_ylim(len(names) - 0.5, -0.5)
    for y, name in enumerate(names):
        for group, method in enumerate((OURS, CLASSIC)):
            row = table.one(mesh=name, method=method)
            left = 5 * group
            if row["accepted"] == "no":
                text = str(row["says"])
                if group == 0:
                    axis.text(left - 0.3, y, "refused: " + (text if len(text) < 100 else text[:97] + "…"), fontsize=8, va="center", color="#444444")
                continue
            bounded = row["depth_over_limit"] is not None and row["depth_over_limit"] <= 1.0001
            for x, (key, _) in enumerate(columns):
                value = bounded if key == "bounded" else {"true": True, "false": False}.get(row[key])
                if value is None:
                    axis.text(left + x, y, "–", ha="center", va="center", color="#AAAAAA")
                else:
                    axis.text(left + x, y, "yes" if value else "no", ha="center", va="center", fontsize=9, fontweight="normal" if value else "bold", color=style.OURS if value else style.CLASSIC)
        if y % 2 == 0:
            axis.axhspan(y - 0.5, y + 0.5, color="#F4F4F4", zorder=0, lw=0)
    axis.set_yticks(range(len(names)), names)
    axis.set_xticks([5 * g + x for g in range(2) for x in range(4)], [c[1] for c in columns] * 2)
    axis.xaxis.tick_top()
    axis.tick_params(length=0)
    axis.grid(False)
    for side in axis.spines.values():
        side.set_visible(False)
    axis.plot([4, 4], [-0.5, sum(r["accepted"] == "yes" for r in table.where(method=OURS)) - 0.5], color="#CCCCCC", lw=0.8)
    top = 1 + 0.52 / (0.29 * len(names))
    axis.text(1.5, top, "Crumple", transform=axis.get_xaxis_transform(), ha="center", fontweight="bold", color=style.OURS)
    axis.text(6.5, top, "the literature's rule, clamped", transform=axis.get_xaxis_transform(), ha="center", fontweight="bold", color=style.CLASSIC)
    style.title(figure, "Meshes as exporters leave them: used, or refused by name")
    style.footer(figure, table, table.said("what").split(" on ")[0] + " each", "All hits in one frame, where the library sorts them for the literature's rule too. –: no vertices share a position.")
    figure.tight_layout(rect=(0, 0.04, 1, 0.97))
    return figure


def inversion(table):
    kinds = ["at its own place", "elsewhere", "six, overlapping"]
    figure, axes = plt.subplots(1, 3, figsize=(11.6, 4.3), sharey=True)
    own = table.where(method="the example itself")
    for axis, kind in zip(axes, kinds):
        axis.plot([r["pull"] for r in own], [r["inverted"] for r in own], color=style.FLOOR, lw=4, alpha=0.5, label="the example itself")
        for method in methods(table):
            line(axis, table.where(method=method, hits=kind), "pull", "inverted", method)
        axis.axvline(1, color=style.FLOOR, lw=0.8, ls=":")
        axis.set_title({"elsewhere": "hit elsewhere", "six, overlapping": "six hits, overlapping"}.get(kind, "hit " + kind), loc="left", fontweight="bold")
        axis.set_xlabel("pull towards the middle (above 1 the example folds)")
    axes[0].set_ylabel("triangles turned over")
    axes[0].set_ylim(bottom=0)
    style.title(figure, "Examples that fold the surface: a dent folds as much as its example does, overlapping ones add their pull")
    finish(figure, axes[0], table, f"{own[0]['triangles']:.0f} triangles, {len(own)} examples", bottom=0.13, top=0.91, legend=0.045)
    return figure
