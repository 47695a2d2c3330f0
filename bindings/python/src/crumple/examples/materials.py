"""Presets in a designer's words: what the body is made of, and what strikes it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """SI units; the yields are strains."""

    young: float
    poisson: float
    density: float
    thickness: float
    """Default, m."""
    yield_stretch: float
    yield_bend: float

    @property
    def wave_speed(self) -> float:
        """Of stretching along a bar, m/s."""
        return (self.young / self.density) ** 0.5

    def strength(self, thickness: float) -> float:
        """The force scale of a dent: yield stress times thickness squared, N."""
        return self.young * self.yield_stretch * thickness**2


MATERIALS = {
    # Yields are half of the metals' own: a shell of finite triangles springs back further than metal does.
    "steel": Material(2.1e11, 0.30, 7850.0, 0.0008, 0.0006, 0.0006),
    "aluminium": Material(7.0e10, 0.33, 2700.0, 0.0010, 0.0010, 0.0010),
    "tin": Material(2.0e11, 0.30, 7300.0, 0.0003, 0.0005, 0.0005),
    "plastic": Material(1.5e9, 0.38, 950.0, 0.0030, 0.0060, 0.0060),
}


@dataclass(frozen=True)
class Striker:
    shape: str
    """ball; pole: a vertical cylinder that moves in the horizontal plane; wall: a plate that faces the surface; corner: of a cube."""
    radius: tuple[float, float]
    """As shares of the body's diagonal. Half the side of a wall, and of the cube of a corner."""
    heaviest: float = 10000.0
    """kg, if masses are not told."""


STRIKERS = {
    "ball": Striker("ball", (0.03, 0.10)),
    "stone": Striker("ball", (0.01, 0.025), 50.0),
    "pole": Striker("pole", (0.03, 0.10)),
    # A plate as large as the body, whose own edges touch nothing.
    "wall": Striker("wall", (1.0, 1.0)),
    "corner": Striker("corner", (0.1, 0.2)),
}
TOLD = {"corner": 0.1}
"""The radius that a blow is told with, as a share of the striker's: that of a ball with the corner's footprint in a usual dent."""
SPEEDS = (2.0, 10.0)
"""m/s, of strikers whose masses are not told: their energy says their masses."""
LIMITS = (0.5, 20.0)
"""m/s, of all strikers."""


def radii(striker: str, size: float, told: tuple[float, float] | None) -> tuple[float, float]:
    """The least and the largest, m, for a body of this diagonal. Walls do not take what is told."""
    usual = STRIKERS[striker].radius
    return told if told is not None and striker != "wall" else (usual[0] * size, usual[1] * size)
