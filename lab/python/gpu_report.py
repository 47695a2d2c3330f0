"""Writes gpu.md into the benchmark's directory from the tables of all devices that are there: `gpu_report.py DIRECTORY`."""

import sys
from pathlib import Path

import style
from charts.gpu import device, tables
from charts.speed import short
from report import number, picture, table

# Aims as they are told, those of cards first.
ORDER = ("share", "100", "times as long as the classic kernel with one example: one", "times", "recording one", "recording 1000", "")


def cells(found, show):
    return [show(t) for t in found]


def milliseconds(ms):
    return f"{three(ms)} ms" if ms >= 0.9995 else f"{three(1e3 * ms)} µs"


def time(row):
    return "–" if row is None else milliseconds(row["value"] if row["unit"] == "ms" else row["value"] / 1e3)


def times(row):
    """A ratio, in two digits."""
    return "–" if row is None or row["ratio"] is None else f"{row['ratio']:.2g}"


def three(x):
    """In three digits, whatever its size."""
    return "–" if x is None else f"{float(format(x, '.3g')):g}"


def reached(row):
    value = f"{three(row['value'])} {row['unit']}" if row["aim"].endswith(row["unit"]) else f"{row['ratio']:.2g} x"
    return value + {"yes": ", **met**", "no": ", **missed**", "shown": ", shown"}[row["met"]]


def aims(found):
    names = sorted({r["aim_is"] for t in found for r in t.rows if r["aim_is"]}, key=lambda n: [n.startswith(p) for p in ORDER].index(True))

    def cell(name):
        def show(t):
            return "; ".join(reached(r) for r in t.rows if r["aim_is"] == name) or "–"

        return show

    what = {r["aim_is"]: r["aim"] for t in found for r in t.rows if r["aim_is"]}
    return table(["aim", "", *map(device, found)], [[n, what[n].replace(">=", "≥").replace("<=", "≤"), *cells(found, cell(n))] for n in names])


def vertices(t):
    methods = {"positions": "positions", "normals": "with normals", "classic": "classic kernel", "classic rule": "the library's classic rule", "copy": "copy", "cpu": "CPU path"}
    sizes = sorted({r["vertices"] for r in t.where(workload="vertices", method="classic")})
    one = lambda m, s: next((r for r in t.where(workload="vertices", method=m, vertices=s) if r["case"] is None), None)

    def line(s):
        p, c = one("positions", s), one("classic", s)
        more = [three(p["gb_per_s"]), three(p["share_of_copy"]), times(p), three(c["share_of_copy"])]
        return [short(s), *(time(one(m, s)) for m in methods), *more]

    head = ["moved vertices", *methods.values(), "GB/s", "of the copy's", "times as long as the classic kernel", "its share of a copy"]
    return table(head, map(line, sizes))


def groups(t):
    rows = t.where(workload="groups")
    cases = sorted({r["case"] for r in rows})
    names = {"positions": "Crumple", "classic": "classic kernel"}
    lines = [[short(s), names[m], *(time(t.one(workload="groups", method=m, vertices=s, case=c)) for c in cases)] for s in sorted({r["vertices"] for r in rows}) for m in names]
    return table(["vertices", "", *(f"{c:g}" for c in cases)], lines)


def marks(t):
    lines = []
    for r in sorted(t.where(workload="impulses", method="fresh"), key=lambda r: (r["case"], r["vertices"])):
        lines.append([f"{r['case']:g}, fresh body", short(r["vertices"]), time(r), milliseconds(r["reference_value"]), times(r)])
    tens = {"fresh against one pass": "10, fresh body; one pass of the classic kernel", "repeated": "10 that repeat a body's ten marks; one of them"}
    for method, what in tens.items():
        for r in t.where(workload="impulses", method=method, case=10):
            lines.append([what, short(r["vertices"]), time(r), milliseconds(r["reference_value"]), f"{1 / r['ratio']:.2g}"])
    return table(["impulses", "vertices", "time", "against", "times as fast"], lines)


def instances(t):
    lines = [[f"{r['case']:g} of 1000", short(r["vertices"]), time(r), milliseconds(r["reference_value"]), number(r["ratio"])] for r in t.where(workload="instances") if r["ratio"] is not None]
    return table(["changed", "vertices", "time", "the same in one instance", "times as long"], lines)


def recording(t):
    us = lambda r: "–" if r is None else f"{three(r['value'])} / {three(r['p90'])}"
    one = lambda m, c: t.one(workload="record", method=m, case=c)
    counts = sorted({r["case"] for r in t.where(workload="record") if r["case"] is not None})
    lines = [[f"{c:g}", *(us(one(m, c)) for m in ("changed", "idle"))] for c in counts]
    by_hand = t.one(workload="record", method="by hand")
    text = table(["instances", "a mark of each changed", "nothing changed"], lines)
    return text + (f"\nThe same commands by hand (a copy, two barriers, a dispatch): {us(by_hand)} µs.\n" if by_hand else "")


def transfer(t):
    sizes = sorted({r["vertices"] for r in t.where(workload="transfer")})
    one = lambda m, s: t.one(workload="transfer", method=m, vertices=s)

    def line(s):
        back, up = one("back", s), one("upload device", s)
        return [short(s), f"{up['bytes_per_vertex'] * s / 1e6:.3g} MB", *(time(one(m, s)) for m in ("upload cpu", "upload device")), milliseconds(up["reference_value"]), *(time(one(m, s)) for m in ("back device", "back cpu", "back")), milliseconds(back["reference_value"])]

    head = ["vertices", "upload", "adding the target, CPU", "the next recording, device", "a copy of as many bytes", "reading back, device", "CPU", "all of it", "deforming them in place"]
    return table(head, map(line, sizes))


def each(found, show):
    return "\n".join(f"**{device(t)}**\n\n{show(t)}" for t in found)


def checks(t):
    checked = [r["check"] for r in t.rows if r["check"]]
    apart = [c for c in checked if c != "same bits"]
    return f"{len(checked)} results, " + ("all of them the CPU's bits" if not apart else f"{len(checked) - len(apart)} of them the CPU's bits; the others: " + "; ".join(dict.fromkeys(apart)))


def main():
    directory = Path(sys.argv[1])
    found = tables(directory)
    if not found:
        print("report: no table of a device is there")
        return
    devices = table(["device", "driver", "kind", "processor", "load before", "clock", "compared with the CPU path", "figures"],
                    [[t.said("device"), t.said("driver"), t.said("kind").split(":")[0], f"{t.said('machine')}, {t.said('cores').split(' (')[0]} cores", t.said("load before").split(",")[0] or "–", t.said("clock"), checks(t), f"[CSV](gpu-{p})"] for t, p in zip(found, names(directory, found))])
    left_out = "".join(f"- {device(t)}: {text}\n" for t in found for text in t.comments.get("left out", []))
    text = f"""# Graphics devices

Made by `cargo xtask bench --gpu`, on each device that the Vulkan loader finds; {found[0].said('rustc')}, crumple {found[0].said('crumple')}.
The devices run without extensions, features and validation. Times are medians of timestamps on the device, around everything that is recorded: the copy
of the frame's work, barriers, dispatches. Contenders take turns. Every result is compared with the CPU path's: bit for bit on software drivers,
to 16 units of 2^-23 m elsewhere. A run whose result is further off fails.

{devices}
## Aims

{aims(found)}
"Shown" marks aims for real graphics cards. They are not judged here, because a software driver computes on the cores that it is compared with, and its "memory
bandwidth" is that of its copying loop. The other aims are judged on every device.

## Time against moved vertices

{picture(directory, "gpu_vertices", "Time and share of a copy's bandwidth against moved vertices")}
One mark moves every vertex of a sheet, and all its vertices follow nodes ([model](../model.md#nodes)): any number of marks takes as long. "GB/s" counts
the bytes that must move: base position and result, 12 bytes each, the weights of the nodes that a vertex follows, and a few per block. For the classic kernel,
which adds one example, these are 52 bytes (an entry of 16, base 12, state 12 read and 12 written). Each copy
reads and writes the same number of bytes. The classic kernel starts from the body at rest, so that it writes every vertex. The
library's classic rule keeps its own state beside the engine's buffer.

{each(found, vertices)}
## Workgroup sizes

{picture(directory, "gpu_groups", "Time a vertex against the size of workgroups")}
{each(found, groups)}
## Impulses

{picture(directory, "gpu_marks", "Speed of impulses against the classic kernel")}
{each(found, marks)}
## Many instances

{each(found, instances)}
## What recording costs the CPU

{picture(directory, "gpu_record", "CPU time of a recording against the number of instances")}
The table has median / 90th percentile in µs. The bodies have 10 000 vertices each and share one buffer. The mark of each body has changed, in a
tenth of its blocks.

{each(found, recording)}
## Upload and reading back

{picture(directory, "gpu_transfer", "Upload and reading back against the number of vertices")}
{each(found, transfer)}
## CPU against graphics device

{picture(directory, "gpu_cpu", "CPU path and device against moved vertices")}
{compiled(directory)}
{"## Left out" + chr(10) + chr(10) + left_out if left_out else ""}"""
    while "\n\n\n" in text:
        text = text.replace("\n\n\n", "\n\n")
    (directory / "gpu.md").write_text(text.rstrip() + "\n")
    print(f"report: {directory / 'gpu.md'}")


def compiled(directory):
    """What RADV's compiler makes of each kernel, for each chip: a section, or nothing without compiled.csv."""
    path = directory / "compiled.csv"
    if not path.exists():
        return ""
    rows = style.Table(path).rows
    chips = list(dict.fromkeys(r["chip"] for r in rows))
    shown = ("instructions", "vgprs", "subgroups_per_simd", "inverse_throughput")
    of = {(r["kernel"], r["chip"]): " / ".join(three(r[s]) for s in shown) for r in rows}
    lines = [[kernel, *(of[kernel, chip] for chip in chips)] for kernel in dict.fromkeys(r["kernel"] for r in rows)]
    return f"""## What a card's compiler makes of the kernels

Mesa's RADV compiles for AMD chips that are not there (`cargo xtask bench --gpu --only compiled`; {rows[0]["driver"]}). Each cell has
instructions / vector registers / subgroups that fit on a SIMD / inverse throughput, in which the compiler assumes how often loops run.
"nodes" is for vertices that follow nodes ([model](../model.md#nodes)), whatever the number of marks. ([CSV](compiled.csv))

{table(["kernel", *chips], lines)}
"""


def names(directory, found):
    """The files of these tables, without `gpu-`."""
    by_device = {}
    for path in directory.glob("gpu-*.csv"):
        head = next(l for l in path.read_text().splitlines() if l.startswith("# device: "))
        by_device[head.removeprefix("# device: ")] = path.name.removeprefix("gpu-")
    return [by_device[t.said("device")] for t in found]


if __name__ == "__main__":
    main()
