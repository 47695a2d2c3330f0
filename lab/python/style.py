"""What all charts share: colours, sizes, the footer, how figures are saved, and how the lab's tables are read."""

import csv
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib import patheffects

# Colour-blind safe (Okabe and Ito).
OURS = "#0072B2"
OURS_LIGHT = "#56B4E9"
CLASSIC = "#D55E00"
PEER = "#009E73"
PEER_2 = "#CC79A7"
RADIAL = "#E69F00"
POD = "#8C564B"
FLOOR = "#7F7F7F"
INK = "#222222"
# Keeps a label readable where lines run under it.
HALO = [patheffects.withStroke(linewidth=2, foreground="white")]

TRUTHS = {"shots": "shots (MuJoCo shells)", "presses": "presses (CalculiX bricks)"}
BODIES = ("panel", "tube")
PANELS = [(truth, body) for truth in TRUTHS for body in BODIES]

# Every body: its truth, its name there, the set of examples and the set of hits that charts show, and a title. Hits of the
# door and the box are those of play, their examples those of a solver's batch.
EVERY_BODY = [
    ("shots", "panel", "train", "heldout", "shots, panel"),
    ("shots", "tube", "train", "heldout", "shots, drum"),
    ("structure", "door", "train_free", "play", "door"),
    ("structure", "box", "train_free", "play", "front of a vehicle"),
    ("steel", "hood", "train", "heldout", "steel hood"),
    ("presses", "panel", "train", "heldout", "presses, panel"),
    ("presses", "tube", "train", "heldout", "presses, drum"),
]

plt.rcParams.update({
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.labelsize": 9,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "figure.titlesize": 13,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    # The same file from the same figures.
    "svg.hashsalt": "crumple",
    "svg.fonttype": "path",
})


class Table:
    """A CSV file of the lab: its rows as dictionaries, numbers as numbers, and the comments on top."""

    def __init__(self, path):
        self.comments, lines = {}, []
        for line in Path(path).read_text().splitlines():
            if line.startswith("# "):
                key, value = line[2:].split(": ", 1)
                self.comments.setdefault(key, []).append(value)
            else:
                lines.append(line)
        self.rows = [{k: number(v) for k, v in row.items()} for row in csv.DictReader(lines)]

    def where(self, **wanted):
        return [r for r in self.rows if all(r.get(k) == v for k, v in wanted.items())]

    def one(self, **wanted):
        found = self.where(**wanted)
        return found[0] if found else None

    def said(self, key):
        return "; ".join(self.comments.get(key, []))


def number(text):
    try:
        return float(text) if text != "" else None
    except (TypeError, ValueError):
        return text


def read(directory, name):
    """The table of that name, or None where that part has not run."""
    path = Path(directory) / name
    return Table(path) if path.exists() else None


def title(figure, text):
    """What is seen, on top."""
    figure.text(0.01, 1 - 0.08 / figure.get_figheight(), text, fontsize=13, fontweight="bold", ha="left", va="top")


def footer(figure, table, n=None, more="", threads="one thread"):
    """Machine, versions and counts, below the figure."""
    parts = [table.said("machine").split(" (family")[0] + ", " + threads, table.said("rustc").split(" (")[0]]
    parts.append("crumple " + table.said("crumple"))
    if n:
        parts.append(n)
    text = " · ".join(p for p in parts if p.strip())
    if more:
        text += "\n" + more
    figure.text(0.01, 0.004, text, fontsize=8, color="#666666", ha="left", va="bottom", linespacing=1.35)


def panel_title(truth, body):
    names = {"panel": "panel (hood)", "tube": "tube (drum)"}
    return f"{names[body]}, {TRUTHS[truth]}"


def save(figure, directory, name):
    figure.savefig(Path(directory) / f"{name}.svg", metadata={"Date": None, "Creator": None})
    plt.close(figure)
    print(f"chart: {name}")
