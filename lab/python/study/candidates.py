"""The candidates: what was tried, and what became of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from study.carry import Carry, Window
from study.rule import Rule

BASELINE = Rule(
    place=0.25, size=0.6, tangent=None, kernel="gaussian", kriging=False, count=3, greedy=False, mirrors="none", window=None
)
NEW = Rule()


@dataclass(frozen=True)
class Candidate:
    """A rule with its name, "group: variant" but for the two that all others are compared with."""

    name: str
    description: str
    rule: Rule
    kept: bool = False
    note: str = ""

    @property
    def group(self) -> str:
        """What comes before the colon."""
        return self.name.split(": ")[0]

    @property
    def compared_with(self) -> str:
        """Additions are compared with the baseline, changes with the new rule."""
        return "baseline" if self.group in ("baseline", "step", "alone", "new rule") else "new rule"


def steps() -> list[Candidate]:
    """From the old default to the new rule, one thing after the other; then single things alone."""
    tangent = replace(BASELINE, tangent=0.05)
    kriging = replace(tangent, place=1.3, size=2.4, kernel="rational quadratic", kriging=True)
    mirrors = replace(kriging, mirrors="all")
    greedy = replace(mirrors, greedy=True, count=4)
    window = replace(greedy, window=Window(0.03))
    return [
        Candidate("baseline", "3 nearest in place (0.25 diagonal) and ln depth (0.6), Gaussian weights", BASELINE),
        Candidate("step: 1 + tangential part", "tangential parts of the unit displacements compared, width 0.05", tangent, True),
        Candidate("step: 2 + kriging weights", "ordinary kriging, rational quadratic, widths 1.3 and 2.4, nugget 0.03", kriging, True),
        Candidate("step: 3 + mirror images", "mirror images in the mesh's own planes", mirrors, True),
        Candidate("step: 4 + greedy choice", "4 of the 12 nearest, by kriging variance", greedy, True),
        Candidate("step: 5 + window", "smoothstep over 3 % of the diagonal to a still rim", window, True),
        Candidate("new rule", "all of these, place width learned among 0.2, 0.5, 1.3 by leave-one-out", NEW, True),
        Candidate("alone: kriging weights", "baseline with step 2 only", replace(kriging, tangent=None)),
        Candidate("alone: mirror images", "baseline with step 3 only", replace(BASELINE, mirrors="all")),
        Candidate("alone: window", "baseline with step 5 only", replace(BASELINE, window=Window(0.03))),
    ]


def ablations() -> list[Candidate]:
    """The new rule with one thing taken away."""
    return [
        Candidate("without: tangential part", "place and depth only", replace(NEW, tangent=None)),
        Candidate("without: kriging weights", "4 nearest, Gaussian weights, the same widths", replace(NEW, kriging=False, greedy=False)),
        Candidate("without: mirror images", "examples as they were made", replace(NEW, mirrors="none")),
        Candidate("without: greedy choice", "the 4 nearest", replace(NEW, greedy=False)),
        Candidate("without: window", "no window", replace(NEW, window=None)),
    ]


def settings() -> list[Candidate]:
    """The new rule with one number or function changed."""

    def window(name: str, window: Window) -> Candidate:
        return Candidate(f"window: {name}", f"{name} instead of smoothstep 3 %", replace(NEW, window=window))

    found = [
        window("linear 2 %", Window(0.02, "linear")),
        window("linear 3 %", Window(0.03, "linear")),
        window("smoothstep 4 %", Window(0.04)),
        window("smoothstep 6 %", Window(0.06)),
        Candidate("window: rim still below 1 %", "a rim is still that moves under 1 % of any example's depth, not 5 %", replace(NEW, window=Window(0.03, still=0.01))),
        Candidate("window: rim still below 20 %", "a rim is still that moves under 20 %", replace(NEW, window=Window(0.03, still=0.2)), note="only one ring of one body tells"),
    ]
    for kernel in ("gaussian", "matern 3/2", "exponential"):
        found.append(Candidate(f"kernel: {kernel}", f"{kernel} kernel instead of rational quadratic", replace(NEW, kernel=kernel)))
    for place in (0.2, 0.5, 1.3):
        found.append(Candidate(f"place width: {place}", f"fixed at {place} diagonals instead of learned", replace(NEW, place=place), note="best on some bodies, worst on others"))
    for margin in (0.05, 0.1):
        found.append(Candidate(f"place width: learned, {margin:.0%} margin", "narrower than 1.3 only if better by that in leave-one-out", replace(NEW, margin=margin)))
    for how, text in (("example", "an example and its mirror images only"), ("lookalike", "an example and all of the same depth and slant")):
        note = "the presses' examples hold copies of one simulation, which learning must not see"
        found.append(Candidate(f"place width: learning leaves out {how}", f"{text}, not whole simulations", replace(NEW, leaves_out=how), note=note))
    for tangent in (0.03, 0.1):
        found.append(Candidate(f"tangential width: {tangent}", f"{tangent} instead of 0.05", replace(NEW, tangent=tangent)))
    for size in (0.6, 1.2):
        found.append(Candidate(f"depth width: {size}", f"{size} instead of 2.4", replace(NEW, size=size)))
    for nugget in (0.01, 0.1):
        found.append(Candidate(f"nugget: {nugget}", f"{nugget} instead of 0.03", replace(NEW, nugget=nugget)))
    for count in (1, 2, 3, 6, 8):
        note = "more reads a vertex" if count > 4 else "fewer reads a vertex; selectable"
        found.append(Candidate(f"K: {count}", f"{count} images instead of 4", replace(NEW, count=count), note=note))
    found.append(Candidate("K: all", "kriging over all images", replace(NEW, count=None), note="every image read at every vertex"))
    found.append(Candidate("pool: 24", "greedy choice out of the 24 nearest instead of 12", replace(NEW, pool=24)))
    found.append(Candidate("mirrors: single planes", "no compositions of mirrorings", replace(NEW, mirrors="planes")))
    geodesic = replace(NEW, distance="geodesic")
    note = "not a valid kernel: negative eigenvalues, so weights can be large"
    found.append(Candidate("distance: along the mesh", "shortest paths over edges between contacts", geodesic, note=note))
    rescaled = replace(NEW, rescaled=True)
    note = "the images have that depth already"
    found.append(Candidate("rescaled sum", "the sum scaled once more to the target at the contact, at most twice", rescaled, note=note))
    return found


def carries() -> list[Candidate]:
    """Other ways to bring an example to the contact."""
    found = []
    for stretch in (0.35, 0.65):
        found.append(Candidate(f"stretch: {stretch}", f"exponent {stretch} of the depth ratio instead of 0.5", replace(NEW, carry=Carry(stretch))))
    turned = replace(NEW, carry=Carry(turn="tangents"))
    found.append(Candidate("turn: tangents agree", "spun about the normal so that tangential parts agree", turned))
    framed = replace(NEW, carry=Carry(turn="curvature"))
    found.append(Candidate("turn: principal curvature", "largest curvature's direction onto itself, where it stands out", framed))
    either = replace(NEW, or_carry=(turned.carry,), margin=0.05)
    found.append(Candidate("turn: tangents, where learned", "the turn is learned with the place width, 5 % margin", either))
    both = replace(NEW, or_carry=(turned.carry, Carry(0.35)), margin=0.05)
    found.append(Candidate("turn: tangents or stretch 0.35, where learned", "a choice of three learned with the place width, 5 % margin", both))
    for share in (0.5, 0.75, 0.9):
        partly = replace(NEW, carry=Carry(share=share), mirrors="none")
        found.append(Candidate(f"partly carried: {share}", f"looked up {share} of the way to the contact; no mirror images", partly))
    anchored = replace(NEW, carry=Carry(share=0.0), place=0.15, size=1.2, tangent=None, nugget=0.02, count=None)
    found.append(Candidate("anchored: kriging", "all images left in place, scaled by depth, kriging with widths 0.15 and 1.2", anchored))
    modes = replace(NEW, count=None, modes=4)
    found.append(Candidate("basis: 4 modes", "kriging over all, then the 4 principal modes of the carried images", modes, note="needs every image"))
    return found


def bounds() -> list[Candidate]:
    """What cannot be had: with hindsight, or with what a hit does not tell."""
    return [
        Candidate("bound: tilt and radius known", "the ball's tilt and radius in the distance", replace(NEW, hidden=True), note="a hit does not tell them"),
        Candidate("bound: best single image", "picked with hindsight", replace(NEW, hindsight="single"), note="knows the answer"),
        Candidate("bound: best weights of its 4", "the new rule's 4, weighted with hindsight", replace(NEW, hindsight="chosen"), note="knows the answer"),
        Candidate("bound: best weights of all", "all images, weighted with hindsight", replace(NEW, hindsight="all"), note="knows the answer"),
    ]


def candidates(quick: bool) -> list[Candidate]:
    """All of them; the quick ones need one way to carry and few windows."""
    if quick:
        return steps() + ablations()
    return steps() + ablations() + settings() + carries() + bounds()
