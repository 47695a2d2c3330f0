"""One unit for everything that the command says, and sizes that cannot be meant."""

from __future__ import annotations

from . import Failure

LEAST, MOST = 0.03, 30.0
"""Diagonals of bodies, m, that are taken as they are. Others need --unit."""
USUAL = (0.2, 8.0)
UNITS = (("millimetres", 0.001), ("centimetres", 0.01), ("inches", 0.0254), ("feet", 0.3048), ("metres", 1.0))


def metres(length: float) -> str:
    return f"{length:.0f} m" if length >= 100 else f"{length:.3g} m" if length >= 1 else f"{1000 * length:.3g} mm"


def check(name: str, size: float, given: float | None) -> None:
    """Refuses a body whose diagonal, m, is absurd, unless the user gave a unit."""
    if given is not None or LEAST <= size <= MOST:
        return
    fitting = [f"--unit {unit:g} if it is in {word} ({metres(size * unit)})" for word, unit in UNITS if USUAL[0] <= size * unit <= USUAL[1]]
    if size < LEAST:
        fitting = [f"--unit {unit:g} ({metres(size * unit)})" for unit in (10, 100, 1000) if USUAL[0] <= size * unit <= USUAL[1]]
    hint = ", or ".join(fitting[:3]) or f"--unit {0.3 * size**-1:.2g}"
    raise Failure(f"{name} is {metres(size)} across, which is no body's size; add {hint}. If it is meant so, add --unit 1")
