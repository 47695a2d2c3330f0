"""Dented bodies before a camera: what levels of detail cost, against what is off on the screen."""

from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

import style
from style import plt

TICKS = (0, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30)
LINES = [("base mesh", "the base mesh", style.INK), ("view", "level of detail by set_view, for so many pixels", style.OURS)]


def draw(directory):
    table = style.read(directory, "scene.csv")
    if table is None:
        return
    figure, axes = plt.subplots(1, 2, figsize=(11.5, 5.2), sharey=True)
    panel(axes[0], table, "error_px_p99", "error of 99 % of covered pixels, pixels", "all that is off")
    panel(axes[1], table, "dent_error_px_max", "error of the worst dented pixel, pixels", "dents alone, without the level's shape at rest")
    axes[0].set_ylabel("ms a frame, one thread, logarithmic")
    axes[1].legend(loc="lower left")
    what = table.said("what")
    style.title(figure, f"{what.split(' from')[0]} on a street: cost of a frame against what is off on the screen")
    style.footer(figure, table, None, f"Submitting and deforming, positions and normals. Dotted: half a pixel. {what}")
    figure.tight_layout(rect=(0, 0.06, 1, 0.94), w_pad=2)
    style.save(figure, directory, "scene")


def panel(axis, table, error, label, title):
    for shown, name, colour in LINES:
        rows = table.where(shown=shown)
        axis.plot([r[error] for r in rows], [r["ms_per_frame"] for r in rows], "o-", color=colour, label=name)
        for r in rows:
            axis.annotate(f"{r['pixels']:g}", (r[error], r["ms_per_frame"]), textcoords="offset points", xytext=(6, 3), fontsize=8.5, color=colour, path_effects=style.HALO)
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(FixedLocator([1, 2, 3, 5, 7, 8, 9, 10, 12, 15, 20, 30, 50, 100, 200]))
    axis.yaxis.set_minor_locator(NullLocator())
    axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axis.set_xscale("symlog", linthresh=0.01, linscale=0.4)
    axis.xaxis.set_major_locator(FixedLocator(TICKS))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axis.axvline(0.5, color=style.FLOOR, lw=0.9, ls=":")
    axis.set_title(title, loc="left", fontweight="bold")
    axis.set_xlabel(label)
    axis.set_xlim(-0.002, 60)
