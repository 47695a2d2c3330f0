"""200 dented bodies before a camera: what tolerances and levels of detail cost, against what is off on the screen."""

from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import plt

COLOURS = [style.INK, style.OURS, style.OURS_LIGHT, style.RADIAL]
TICKS = (0, 0.03, 0.1, 0.3, 1, 3, 10)
OUTPUTS = "positions and normals"


def draw(directory):
    table = style.read(directory, "scene.csv")
    if table is None:
        return
    rows = table.where(outputs=OUTPUTS)
    edges = list(dict.fromkeys(r["lod_edge_px"] for r in rows))
    figure, axes = plt.subplots(1, 2, figsize=(11.5, 5.2), sharey=True)
    left(axes[0], [r for r in rows if r["lod_edge_px"] == 0])
    right(axes[1], rows, edges)
    for axis in axes:
        axis.set_yscale("log")
        axis.yaxis.set_major_locator(FixedLocator([0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200]))
        axis.yaxis.set_minor_locator(NullLocator())
        axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.set_xscale("symlog", linthresh=0.03, linscale=0.4)
        axis.xaxis.set_major_locator(FixedLocator(TICKS))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axis.axvline(0.5, color=style.FLOOR, lw=0.9, ls=":")
    axes[0].set_ylabel("ms a frame, one thread, logarithmic")
    bodies = table.said("what").split(" bodies")[0]
    style.title(figure, f"{bodies} dented bodies from 1 m to 300 m: cost of a frame against what is off on the screen")
    more = "Submitting and deforming, positions and normals. Dotted: half a pixel. " + table.said("what")
    style.footer(figure, table, None, more)
    figure.tight_layout(rect=(0, 0.06, 1, 0.94), w_pad=2)
    style.save(figure, directory, "scene")


def left(axis, rows):
    axis.plot([r["tolerance_error_px_max"] for r in rows], [r["ms_per_frame"] for r in rows], "o-", color=style.INK, label="worst dented pixel")
    axis.plot([r["tolerance_error_px_p99"] for r in rows], [r["ms_per_frame"] for r in rows], "s--", color=style.OURS, label="99 % of dented pixels")
    for r in rows:
        axis.annotate(f"{r['tolerance_px']:g} px", (r["tolerance_error_px_max"], r["ms_per_frame"]), textcoords="offset points", xytext=(7, 3), fontsize=8.5, path_effects=style.HALO)
    axis.set_title("the base mesh, by tolerance", loc="left", fontweight="bold")
    axis.set_xlabel("error on the screen due to the tolerance, pixels")
    axis.legend(loc="lower left")
    axis.set_xlim(-0.005, 3)


def right(axis, rows, edges):
    for edge, colour in zip(edges, COLOURS):
        found = [r for r in rows if r["lod_edge_px"] == edge]
        memory = found[0]["bytes_bodies"] / 1e6
        name = "base mesh always" if edge == 0 else f"edges up to {edge:g} px"
        axis.plot([r["error_px_p99"] for r in found], [r["ms_per_frame"] for r in found], "o-", color=colour, label=f"{name}: {memory:.0f} MB")
        for r in found:
            if r["tolerance_px"] in (0, 0.5, 2):
                axis.annotate(f"{r['tolerance_px']:g}", (r["error_px_p99"], r["ms_per_frame"]), textcoords="offset points", xytext=(6, 2), fontsize=8, color=colour, path_effects=style.HALO)
    axis.set_title("with levels of detail too (figures: tolerance in px)", loc="left", fontweight="bold")
    axis.set_xlabel("error of 99 % of covered pixels, of tolerance and level, pixels")
    axis.legend(loc="upper right")
    axis.set_xlim(-0.005, 10)
