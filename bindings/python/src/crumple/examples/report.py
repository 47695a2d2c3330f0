"""The report: a page with the verdict, the learning curve, a table, and lit pictures of the most telling examples."""

from __future__ import annotations

import html
import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

from .body import Body, Floats, Ints, Made, face_normals, point_normals  # noqa: E402
from .run import Run  # noqa: E402

MOST_TRIANGLES = 60000
CELLS = 120
"""Pictures of meshes with more triangles join the vertices of each cell, so many cells along the diagonal."""
PICTURES = 16
"""Examples with a picture: the deepest, the weakest, those that the others predict worst, and some between."""

_STYLE = "body{font:15px sans-serif;max-width:70em;margin:2em auto}td,th{padding:.2em .8em;text-align:right}figure{display:inline-block;margin:.5em}.warning{color:#b00}"
_METAL = np.array([0.66, 0.68, 0.71])


def write(folder: Path, body: Body, examples: Sequence[Made], held: Floats, done: Run | None, words: Sequence[str]) -> None:
    """Writes `folder`/index.html and its pictures. `held` are points that do not move, `words` paragraphs about the run. Lengths in m."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.png"):
        old.unlink()
    errors = done.judged.errors if done is not None and done.judged is not None else {}
    depths = [float(np.linalg.norm(made.field[body.nearest(made.point)])) for made in examples]
    known = any(made.impulse is not None for made in examples)
    head = ["example", "depth, mm", "largest, mm"]
    head += ["impulse, N s", "mass, kg", "speed, m/s", "radius, mm", "contact, ms", "error"] if known else []
    rows = []
    for number, made in enumerate(examples):
        row = [made.name, f"{1000 * depths[number]:.1f}", f"{1000 * np.linalg.norm(made.field, axis=1).max():.1f}"]
        if made.impulse is not None and made.velocity is not None:
            row += [f"{np.linalg.norm(made.impulse):.3g}", f"{made.mass:.3g}", f"{np.linalg.norm(made.velocity):.1f}"]
            row += [f"{1000 * made.radius:.0f}", f"{1000 * made.duration:.1f}", f"{errors[made.name]:.2f}" if made.name in errors else "–"]
        rows.append(row)
    figures = []
    for number in _telling(depths, [errors.get(made.name, 0.0) for made in examples]):
        made, name = examples[number], f"example_{number + 1:04}.png"
        picture(folder / name, body, made.field, made.normal, held, made.point)
        error = f", error {errors[made.name]:.2f}" if made.name in errors else ""
        figures.append(_figure(name, f"{made.name}: {1000 * depths[number]:.1f} mm{error}"))
    reached = np.max([np.linalg.norm(made.field, axis=1) for made in examples], axis=0)
    middle = np.mean([made.normal for made in examples], axis=0)
    middle = middle / np.linalg.norm(middle) if np.linalg.norm(middle) > 0.1 else examples[0].normal
    picture(folder / "coverage.png", body, np.zeros_like(body.points), middle, held, None, 1000 * reached)
    overview = [_figure("coverage.png", "The deepest displacement of any example, mm. Blue points are held")]
    if done is not None and len(done.curve) > 1:
        curve(folder / "curve.png", done.curve)
        overview.append(_figure("curve.png", "Expected error of a hit, told its blow, against the number of examples"))
    share = _share(body.points, body.triangles, reached > 1e-3 * body.size)
    moved = f"Some example moves {share:.0%} of the surface by more than {body.size:.3g} mm."
    words = [*words, f"{moved} Hits elsewhere are predicted from examples of other places."]
    cells = lambda row, tag: "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"  # noqa: E731
    page = (
        f'<!doctype html><meta charset="utf-8"><title>{html.escape(body.name)}</title><style>{_STYLE}</style>'
        f"<h1>Examples of {html.escape(body.name)}</h1>"
        + "".join(f"<p{_class(text)}>{html.escape(text)}</p>" for text in words)
        + f"{''.join(overview)}<h2>Examples</h2>{''.join(figures)}"
        + f"<table>{cells(head, 'th')}{''.join(cells(row, 'td') for row in rows)}</table>\n"
    )
    (folder / "index.html").write_text(page, encoding="utf-8")


def _class(text: str) -> str:
    return ' class="warning"' if text.startswith("Warning: ") else ""


def _figure(name: str, caption: str) -> str:
    return f'<figure><img src="{name}" width="420"><figcaption>{html.escape(caption)}</figcaption></figure>'


def _telling(depths: Sequence[float], errors: Sequence[float]) -> list[int]:
    """The examples that get a picture."""
    if len(depths) <= PICTURES:
        return list(range(len(depths)))
    deep = [int(i) for i in np.argsort(depths)[::-1]]
    bad = sorted(range(len(errors)), key=lambda i: -errors[i])
    between = deep[:: max(1, len(deep) // PICTURES)]
    return sorted(list(dict.fromkeys([*deep[:4], *deep[-2:], *bad[:4], *between]))[:PICTURES])


def curve(path: Path, points: Sequence[tuple[int, float, float]]) -> None:
    """The learning curve."""
    n, median, worst = np.array(points).T
    figure, axes = plt.subplots(figsize=(5.2, 3.9))
    axes.plot(n, median, "o-", label="median")
    axes.plot(n, worst, "o:", label="one in ten is above", color="0.6")
    axes.axhline(1, color="0.8", zorder=0)
    axes.set(xlabel="examples", ylabel="error (no dent is 1)", ylim=(0, min(2.0, 1.05 * max(worst.max(), 1.0))), xscale="log")
    # From the last one back, those that have room.
    ticks = [int(n[-1])]
    for one in n[-2::-1]:
        if np.log(ticks[-1] / one) > 0.12 * np.log(n[-1] / n[0]):
            ticks.append(int(one))
    axes.set_xticks(ticks, [str(one) for one in ticks], minor=False)
    axes.minorticks_off()
    axes.legend(frameon=False)
    figure.savefig(path, dpi=90, bbox_inches="tight")
    plt.close(figure)


def _share(points: Floats, triangles: Ints, which: np.ndarray) -> float:
    areas = np.linalg.norm(face_normals(points, triangles), axis=1)
    return float((areas * which[triangles].mean(1)).sum() / areas.sum())


def _coarse(points: Floats, triangles: Ints) -> Ints:
    """Fewer triangles on some of the points."""
    least = points.min(0)
    cells = ((points - least) * (CELLS / np.linalg.norm(points.max(0) - least))).astype(np.int64)
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    joined = first[cell.reshape(-1)][triangles]
    a, b, c = joined.T
    return np.unique(joined[(a != b) & (b != c) & (c != a)], axis=0)


def picture(
    path: Path, body: Body, field: Floats, towards: Floats, held: Floats, contact: Floats | None = None, values: Floats | None = None
) -> None:
    """The displaced body, lit from above, seen obliquely from the side that `towards` points to; in metal, or coloured by `values`."""
    points, triangles = body.points, body.triangles
    if len(triangles) > MOST_TRIANGLES:
        triangles = _coarse(points, triangles)
    moved = points + field
    up = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([0.0, 0.0, -1.0])
    right = np.cross(up, towards)
    eye = towards + 0.45 * right / np.linalg.norm(right) + 0.55 * up
    eye /= np.linalg.norm(eye)
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    frame = np.stack([right, np.cross(eye, right), eye])
    seen = moved @ frame.T
    smooth = point_normals(moved, triangles)[triangles].mean(1) @ frame.T
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-30)
    smooth *= np.where(smooth[:, 2:] < 0, -1, 1)
    light = np.array([-0.55, 0.75, 0.37])
    diffuse = smooth @ light
    # The undamaged surface is of middling grey, and slopes away from it are lighter or darker.
    diffuse = np.clip(0.5 + 0.9 * (diffuse - np.median(diffuse)), 0, 1)
    half = (light + [0, 0, 1]) / np.linalg.norm(light + [0, 0, 1])
    shine = np.clip(smooth @ half, 0, 1) ** 40
    order = seen[triangles, 2].mean(1).argsort()
    colours = np.ones((len(triangles), 4))
    if values is None:
        colours[:, :3] = np.clip(_METAL * (0.25 + 1.1 * diffuse[:, None]) + 0.25 * shine[:, None], 0, 1)
    else:
        most = max(float(values.max()), 1e-9)
        colours = plt.get_cmap("viridis")(values[triangles].mean(1) / most)
        colours[:, :3] *= (0.4 + 0.6 * diffuse)[:, None]
    figure, axes = plt.subplots(figsize=(5.2, 3.9))
    axes.add_collection(PolyCollection(seen[triangles[order], :2], facecolors=colours[order], edgecolors=colours[order], linewidths=0.2))
    if len(held):
        at = held @ frame.T
        axes.plot(at[:, 0], at[:, 1], ".", color="tab:blue", ms=3, alpha=0.8)
    if contact is not None:
        axes.plot(*(frame @ contact)[:2], "o", mfc="none", mec="red", ms=9)
    axes.set_aspect("equal")
    axes.autoscale()
    axes.axis("off")
    if values is not None:
        figure.colorbar(plt.cm.ScalarMappable(plt.Normalize(0, most), "viridis"), ax=axes, label="displacement, mm", shrink=0.7)
    figure.savefig(path, dpi=90, bbox_inches="tight")
    plt.close(figure)
