"""Time against the number of moved vertices, and against threads: the literature's Figures 5.4 and 5.5."""

from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import plt

LOOK = {
    "classic": dict(color=style.CLASSIC, marker="s", label="literature's kernel"),
    "crumple": dict(color=style.OURS, marker="o", lw=2, label="Crumple"),
    "memcpy": dict(color=style.FLOOR, marker=".", ls="--", label="copying the positions"),
}
THREADS = {1: "one thread", 2: "two threads"}


def draw(directory):
    table = style.read(directory, "speed_vertices.csv")
    if table is not None and table.rows:
        style.save(vertices(table), directory, "speed_vertices")
    table = style.read(directory, "speed_threads.csv")
    if table is not None and table.rows:
        style.save(threads(table), directory, "speed_threads")


def short(n):
    """A count as people say it."""
    digits = lambda x: f"{float(f'{x:.2g}'):g}"
    return f"{digits(n / 1e6)} M" if n >= 995e3 else f"{digits(n / 1e3)} k" if n >= 1e3 else f"{n:g}"


def methods(table):
    return [m for m in LOOK if any(r["method"] == m for r in table.rows)]


def decades(axis, low, high, show, steps=(1,)):
    axis.set_major_locator(FixedLocator([s * 10.0**p for p in range(-6, 9) for s in steps if low * 0.999 <= s * 10.0**p <= high * 1.001]))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda v, _: show(v)))


def duration(ms):
    return f"{ms:g} ms" if ms >= 0.1 else f"{1e3 * ms:g} µs"


def finish(figure, axis, table, more):
    # Inches from below: the footer, the legend, the axes.
    at = lambda inches: inches / figure.get_figheight()
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), bbox_to_anchor=(0.5, at(0.4)))
    style.footer(figure, table, more=more, threads="threads as shown")
    figure.tight_layout(rect=(0, at(0.7), 1, 1 - at(0.35)))


def vertices(table):
    """Above: milliseconds. Below: nanoseconds a vertex, where caches show."""
    figure, axes = plt.subplots(2, 2, figsize=(10.4, 7.6), sharex=True, sharey="row", height_ratios=(3, 2))
    for column, (count, name) in enumerate(THREADS.items()):
        for axis, y in zip(axes[:, column], ("ms", "ns_per_moved_vertex")):
            axis.set_xscale("log")
            axis.set_yscale("log")
            for method in methods(table):
                rows = sorted(table.where(method=method, threads=count), key=lambda r: r["moved_vertices"])
                axis.plot([r["moved_vertices"] for r in rows], [r[y] for r in rows], **LOOK[method])
                if y == "ms":
                    axis.fill_between([r["moved_vertices"] for r in rows], [r["ms_p25"] for r in rows], [r["ms_p75"] for r in rows], color=LOOK[method]["color"], alpha=0.15, lw=0)
        axes[0, column].set_title(name, loc="left", fontweight="bold")
        axes[1, column].set_xlabel("moved vertices")
    spans = {y: (min(r[y] for r in table.rows), max(r[y] for r in table.rows)) for y in ("moved_vertices", "ms", "ns_per_moved_vertex")}
    decades(axes[1, 0].xaxis, *spans["moved_vertices"], short, steps=(1, 3))
    decades(axes[0, 0].yaxis, *spans["ms"], duration)
    decades(axes[1, 0].yaxis, spans["ns_per_moved_vertex"][0] / 2, 2 * spans["ns_per_moved_vertex"][1], lambda v: f"{v:g}", steps=(1, 2, 5))
    axes[0, 0].set_ylabel("time of one deformation")
    axes[1, 0].set_ylabel("ns a moved vertex")
    style.title(figure, "Time against the number of moved vertices")
    finish(figure, axes[0, 0], table, "A sheet, one example that moves every vertex, positions only. Medians of interleaved runs; shade: quartiles.")
    return figure


def threads(table):
    """At up to three sizes."""
    sizes = sorted({r["vertices"] for r in table.rows})
    counts = sorted({r["threads"] for r in table.rows})
    shown = sizes if len(sizes) <= 3 else [sizes[len(sizes) // 3], sizes[2 * len(sizes) // 3], sizes[-1]]
    figure, axes = plt.subplots(1, len(shown), figsize=(10.4, 4.2), sharey=True, squeeze=False)
    for axis, size in zip(axes[0], shown):
        for method in methods(table):
            rows = sorted(table.where(method=method, vertices=size), key=lambda r: r["threads"])
            axis.plot([r["threads"] for r in rows], [r["ms"] for r in rows], **LOOK[method])
        first = [table.one(method=m, vertices=size, threads=1)["ms"] for m in methods(table)]
        for ms in first:
            axis.plot(counts, [ms / c for c in counts], color="#BBBBBB", lw=0.8, ls=":", zorder=1)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.xaxis.set_major_locator(FixedLocator(counts))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.set_xlim(counts[0] / 1.15, counts[-1] * 1.15)
        axis.set_xlabel("threads")
        axis.set_title(f"{short(size)} vertices", loc="left", fontweight="bold")
    times = [r["ms"] for r in table.rows if r["vertices"] in shown]
    decades(axes[0, 0].yaxis, min(times) / 2, 2 * max(times), duration)
    axes[0, 0].set_ylabel("time of one deformation")
    style.title(figure, "Time against threads")
    finish(figure, axes[0, 0], table, "One example that moves every vertex of a sheet, positions only. Dotted: what one thread takes, divided by their number.")
    return figure
