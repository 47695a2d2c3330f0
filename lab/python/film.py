"""Makes an animation of the frames that `crumple-lab` drew: `film.py crash|crowd --out DIRECTORY [--quick]`."""

import argparse
from pathlib import Path

from PIL import Image, ImageFilter

RATE = 30  # a second
# The quality, a blur in pixels, and the options of frames. All of the crowd moves: softer edges take a fifth less, and frames that
# hold no parts of others leave no traces of what was there before.
FILMS = {"crash": (55, 0, {}), "crowd": (22, 0.5, {"kmin": 0, "kmax": 1})}
REST = 1500  # ms that the last picture stays


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("film", choices=FILMS)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--quick", action="store_true", help="every tenth frame is there")
    arguments = parser.parse_args()
    quality, blur, keys = FILMS[arguments.film]
    frames = [Image.open(path).convert("RGB") for path in sorted(Path("out", arguments.film).glob("frame_*.png"))]
    if blur > 0:
        frames = [frame.filter(ImageFilter.GaussianBlur(blur)) for frame in frames]
    rate = RATE / 10 if arguments.quick else RATE
    # Whole milliseconds that add up to the film's length.
    ends = [round(1000 * i / rate) for i in range(len(frames) + 1)]
    durations = [b - a for a, b in zip(ends, ends[1:])]
    durations[-1] += REST
    film = arguments.out / f"{arguments.film}.webp"
    frames[0].save(film, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=quality, method=6, **keys)
    print(f"{film}: {len(frames)} frames, {film.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
