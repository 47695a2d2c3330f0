"""The report: a page with a table, and a picture of every example."""

from __future__ import annotations

import html
import os
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

import crumple  # noqa: E402

from .body import Body, Floats, Ints, Made, face_normals  # noqa: E402

MOST_TRIANGLES = 30000
CELLS = 120
"""Pictures of meshes with more triangles join the vertices of each cell, so many cells along the diagonal."""

_STYLE = "body{font:15px sans-serif;max-width:70em;margin:2em auto}td,th{padding:.2em .8em;text-align:right}figure{display:inline-block;margin:.5em}"


def write(
    folder: Path, body: Body, examples: Sequence[Made], info: crumple.SetInfo, each: Sequence[crumple.ExampleInfo], words: Sequence[str]
) -> None:
    """Writes `folder`/index.html and its pictures. `words` are paragraphs about the run."""
    folder.mkdir(parents=True, exist_ok=True)
    known = any(made.impulse is not None for made in examples)
    head = ["example", "depth, mm", "largest, mm", "reach, mm"]
    head += ["impulse, N s", "mass, kg", "speed, m/s", "radius, mm", "contact, ms"] if known else []
    head += ["error of its field", "error of its depth"]
    rows, figures = [], []
    for number, (made, one) in enumerate(zip(examples, each, strict=True)):
        row = [made.name, *(f"{1000 * value:.1f}" for value in (one.depth, one.max_depth, one.support_radius))]
        if made.impulse is not None and made.velocity is not None:
            row += [f"{np.linalg.norm(made.impulse):.3g}", f"{made.mass:.3g}", f"{np.linalg.norm(made.velocity):.1f}"]
            row += [f"{1000 * made.radius:.0f}", f"{1000 * made.duration:.1f}"]
        row += ["–" if error is None else f"{error:.2f}" for error in (one.field_error, one.depth_error)]
        rows.append(row)
        name = f"example_{number + 1:02}.png"
        picture(folder / name, body.points, body.triangles, made.field, made.point, made.normal)
        figures.append(f'<figure><img src="{name}" width="420"><figcaption>{html.escape(made.name)}</figcaption></figure>')
    reached = np.max([np.linalg.norm(made.field, axis=1) for made in examples], axis=0)
    middle = examples[0].normal
    picture(folder / "coverage.png", body.points, body.triangles, np.zeros_like(body.points), None, middle, reached)
    share = _share(body.points, body.triangles, reached > 1e-3 * body.size)
    field, depth = ("unknown" if error is None else f"{error:.2f}" for error in (info.field_error, info.depth_error))
    words = [
        *words,
        f"Expected error of a dent, told its depth: {field} (relative L2 norm around an example when the other examples predict it, median; 1 "
        f"is no dent). Expected error of the depth, told the blow: {depth}.",
        f"Some example moves {share:.0%} of the surface by more than {body.size:.3g} mm. Hits elsewhere use carried examples.",
    ]
    cells = lambda row, tag: "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"  # noqa: E731
    page = (
        f'<!doctype html><meta charset="utf-8"><title>{html.escape(body.name)}</title><style>{_STYLE}</style>'
        f"<h1>Examples of {html.escape(body.name)}</h1>"
        + "".join(f"<p>{html.escape(text)}</p>" for text in words)
        + f"<table>{cells(head, 'th')}{''.join(cells(row, 'td') for row in rows)}</table>{''.join(figures)}"
        + '<h2>Coverage</h2><figure><img src="coverage.png" width="420"><figcaption>The deepest displacement of any example</figcaption></figure>\n'
    )
    (folder / "index.html").write_text(page, encoding="utf-8")


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
    path: Path, points: Floats, triangles: Ints, field: Floats, contact: Floats | None, towards: Floats, values: Floats | None = None
) -> None:
    """The displaced mesh, coloured by displacement in mm, seen obliquely from the side that `towards` points to."""
    moved = points + field
    values = 1000 * (np.linalg.norm(field, axis=1) if values is None else values)
    if len(triangles) > MOST_TRIANGLES:
        triangles = _coarse(points, triangles)
    up = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([0.0, 0.0, -1.0])
    right = np.cross(up, towards)
    eye = towards + 0.45 * right / np.linalg.norm(right) + 0.55 * up
    eye /= np.linalg.norm(eye)
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    frame = np.stack([right, np.cross(eye, right), eye])
    seen = moved @ frame.T
    normals = face_normals(moved, triangles)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    order = seen[triangles, 2].mean(1).argsort()
    light = frame.T @ np.array([-0.4, 0.6, 0.7]) / np.linalg.norm([0.4, 0.6, 0.7])
    shade = 0.45 + 0.55 * np.abs(normals @ light)
    most = max(float(values.max()), 1e-9)
    colours = plt.get_cmap("viridis")(values[triangles].mean(1) / most)
    colours[:, :3] *= shade[:, None]
    figure, axes = plt.subplots(figsize=(5.2, 3.9))
    axes.add_collection(PolyCollection(seen[triangles[order], :2], facecolors=colours[order], edgecolors=colours[order], linewidths=0.2))
    if contact is not None:
        axes.plot(*(frame @ contact)[:2], "o", mfc="none", mec="red", ms=9)
    axes.set_aspect("equal")
    axes.autoscale()
    axes.axis("off")
    bar = plt.cm.ScalarMappable(plt.Normalize(0, most), "viridis")
    figure.colorbar(bar, ax=axes, label="displacement, mm", shrink=0.7)
    figure.savefig(path, dpi=90, bbox_inches="tight")
    plt.close(figure)
