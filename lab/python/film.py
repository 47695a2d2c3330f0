"""Makes crash.webp, an animation of the frames of `crumple-lab crash`: `film.py --out DIRECTORY [--quick]`."""

import argparse
from pathlib import Path

from PIL import Image

FRAMES = Path("out/crash")
RATE = 30  # a second
QUALITY = 55
REST = 1500  # ms that the last picture stays


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--quick", action="store_true", help="every tenth frame is there")
    arguments = parser.parse_args()
    frames = [Image.open(path).convert("RGB") for path in sorted(FRAMES.glob("frame_*.png"))]
    rate = RATE / 10 if arguments.quick else RATE
    # Whole milliseconds that add up to the film's length.
    ends = [round(1000 * i / rate) for i in range(len(frames) + 1)]
    durations = [b - a for a, b in zip(ends, ends[1:])]
    durations[-1] += REST
    film = arguments.out / "crash.webp"
    frames[0].save(film, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=QUALITY, method=6)
    print(f"{film}: {len(frames)} frames, {film.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
