"""Where the physics engines fail: every run of a sweep as a mark, its shape and colour telling how it ended."""

import style
from style import CLASSIC, FLOOR, INK, PEER, PEER_2, plt

TABLES = ("stability_peers_rapier.csv", "stability_peers_mujoco.csv")
SWEEPS = ("time step", "stiffness", "impact speed")
AXES = {
    "time step": "time step, ms",
    "stiffness": "stiffness, times the calibrated (yield stress kept)",
    "impact speed": "impact speed, m/s",
}
OUTCOMES = {
    "ok": ("dent stays", "o", PEER),
    "lost": ("dent lost or ball went through", "v", FLOOR),
    "inverted": ("triangles turned over", "s", PEER_2),
    "exploded": ("exploded: a vertex further than the body is large", "X", CLASSIC),
    "nan": ("NaN or infinite", "D", INK),
}


def draw(directory):
    tables = [t for t in (style.read(directory, name) for name in TABLES) if t is not None]
    if not tables:
        return
    rows = [row for table in tables for row in table.rows]
    lanes = list(dict.fromkeys((row["peer"], row["version"], row["body"]) for row in rows))
    figure, axes = plt.subplots(len(SWEEPS), 1, figsize=(10.4, 1.5 + 0.62 * len(lanes) * len(SWEEPS)), sharey=True)
    for axis, sweep in zip(axes, SWEEPS):
        strip(axis, sweep, rows, lanes)
    seen = [o for o in OUTCOMES if any(row["outcome"] == o for row in rows)]
    handles = [plt.Line2D([], [], ls="", marker=OUTCOMES[o][1], color=OUTCOMES[o][2], ms=7, label=OUTCOMES[o][0]) for o in seen]
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.005, 1 - 0.36 / figure.get_figheight()), ncols=len(handles))
    style.title(figure, "Physics engines: the dent follows step, stiffness and speed, and is lost at their ends")
    footer(figure, tables)
    figure.tight_layout(rect=(0, 0.055, 1, 1 - 0.62 / figure.get_figheight()), h_pad=1.2)
    style.save(figure, directory, "stability_peers")


def strip(axis, sweep, rows, lanes):
    """One sweep: a lane for each peer and body, the depth that stayed beside each mark."""
    for lane, (peer, version, body) in enumerate(lanes):
        own = [r for r in rows if (r["peer"], r["version"], r["body"], r["sweep"]) == (peer, version, body, sweep)]
        axis.axhline(lane, color="#E4E4E4", lw=0.8, zorder=0)
        for row in own:
            _, marker, colour = OUTCOMES[row["outcome"]]
            axis.plot(row["value"], lane, marker=marker, color=colour, ms=7, ls="", zorder=2)
            if row["depth_mm"] is not None:
                depth = f"{row['depth_mm']:.0f} mm" if row["depth_mm"] < 1e3 else f"{row['depth_mm'] / 1e3:.0f} m"
                axis.annotate(depth, (row["value"], lane), (0, -5.5), textcoords="offset points", ha="center", va="top", fontsize=8, color="#555555")
    axis.set_xscale("log")
    values = sorted({row["value"] for row in rows if row["sweep"] == sweep})
    axis.set_xticks(values, [f"{v:g}" for v in values])
    axis.minorticks_off()
    axis.set_xlim(values[0] / 1.6, values[-1] * 1.6)
    axis.set_yticks(range(len(lanes)), [f"{peer}, {body}" for peer, _, body in lanes])
    axis.set_ylim(len(lanes) - 0.3, -0.5)
    axis.set_xlabel(AXES[sweep])
    axis.grid(False)
    axis.tick_params(axis="y", length=0)


def footer(figure, tables):
    """Machine, versions, counts."""
    versions = dict.fromkeys(f"{row['peer'].split(',')[0]} {row['version']}" for table in tables for row in table.rows)
    machine = tables[0].said("machine").split(" (family")[0]
    runs = sum(len(table.rows) for table in tables)
    text = f"{machine}, one thread · {' · '.join(versions)} · {runs} runs, one of each\n"
    true = {key.split()[-1]: value for table in tables for key, (value, *_) in table.comments.items() if key.startswith("true depth")}
    text += f"One training shot of median depth a body ({', '.join(f'{b}: the truth is {d}' for b, d in true.items())}); under each mark the depth at the contact.\n"
    text += "A ball slower than the shot's may spring back: no fault."
    figure.text(0.01, 0.004, text, fontsize=8, color="#666666", ha="left", va="bottom", linespacing=1.35)
