"""A mechanism that the reader moves: every frame is computed here, and the page only chooses which one is shown.

The figure is a still with the frames beside it as JSON. ``book/_static/mechanism.js`` makes it movable; without
the script, on paper and in a notebook, the still is complete.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from itertools import chain, pairwise

import numpy as np
from numpy.typing import ArrayLike

from mechlib.draw import BLUE, GREEN, GREY, PURPLE, RED

WORDS = {"play": "Play", "pause": "Pause", "position": "Position"}  # all that the script says; translate it here

WIDTH, HEIGHT, MARGIN = 440, 380, 44  # SVG units; one is a CSS pixel where there is room, and less on a phone
INK = "#24292f"
COLOURS = (BLUE, RED, GREEN, PURPLE)
GROUND = "M0 0-11 18H11ZM-17 18H17M-11 18l-6 7M-3 18l-6 7M5 18l-6 7M13 18l-6 7"  # a triangle on hatched ground


@dataclass(frozen=True)
class Quantity:
    """A number that belongs to each frame.

    Attributes
    ----------
    symbol : str
        As it is shown: "θ₂".
    values : array_like, shape (frames,)
        In `unit`.
    unit : str
    digits : int
        Decimals that are shown.
    """

    symbol: str
    values: ArrayLike
    unit: str = ""
    digits: int = 0

    def texts(self) -> list[str]:
        """The values as they are shown, with their unit."""
        unit = self.unit if self.unit in ("", "°") else f"\N{NO-BREAK SPACE}{self.unit}"
        rounded = np.round(np.asarray(self.values, dtype=float), self.digits) + 0.0  # no minus before a zero
        return [f"{value:.{self.digits}f}".replace("-", "\N{MINUS SIGN}") + unit for value in rounded]


@dataclass(frozen=True)
class Arrows:
    """Vectors at joints, all on one scale, that the reader can show: velocities, forces.

    Attributes
    ----------
    label : str
        As it is shown beside the box to tick.
    vectors : mapping of joint name to array_like, shape (frames, 2)
        In `unit`.
    unit : str
    """

    label: str
    vectors: Mapping[str, ArrayLike]
    unit: str = ""

    @property
    def longest(self) -> float:
        """Length of the longest vector of all frames, in `unit`."""
        return float(max((np.linalg.norm(v, axis=-1).max() for v in self.vectors.values()), default=0.0))


@dataclass(frozen=True)
class Moving:
    """A mechanism in all its positions, drawn in one; in the book the reader drags it through the others.

    Attributes
    ----------
    joints : mapping of name to array_like, shape (frames, 2) or (2,)
        Where each joint is, in metres; a single point is fixed. A joint whose name begins with "_" only
        places the end of a body: it is not drawn and cannot be dragged.
    bodies : mapping of name to sequence of joint names
        The chain of joints each body connects; one that ends where it began is a closed plate. "OA" is short for
        ("O", "A"). Drawn in this order, in four colours by turns.
    input : Quantity
        What moves the mechanism; it numbers the frames.
    alt : str
        What the picture shows, for those who do not see it.
    cyclic : bool
        Whether the first frame follows the last.
    values : sequence of Quantity
        Shown beside the picture.
    ground : sequence of joint names
        Fixed joints that are drawn as pivots on the ground.
    sliders : mapping of joint name to array_like, shape (2,)
        Joints drawn as a block, with the direction of the straight guide it slides on.
    barrels : sequence of body names
        Bodies that are drawn as the barrel of a cylinder.
    traces : sequence of joint names
        Joints whose path is drawn.
    cloud : array_like, shape (points, 2)
        Points that are drawn and do not move, in metres.
    backdrop : array_like, shape (points, 2)
        Corners of an area that lies behind the mechanism and does not move, in metres.
    arrows : sequence of Arrows
    start : int
        The frame that is drawn.
    seconds : float
        How long all the frames take when they are played, in s.
    autoplay : bool
        Whether it moves by itself once it is seen; never for a reader who asked for less motion.

    Raises
    ------
    ValueError
        If a name is unknown, a shape does not fit, a number is not finite, there are fewer than two frames, a grounded
        joint moves, a cyclic motion does not close, or there is no alt text.
    """

    joints: Mapping[str, ArrayLike]
    bodies: Mapping[str, Sequence[str]]
    input: Quantity
    alt: str
    cyclic: bool = False
    values: Sequence[Quantity] = ()
    ground: Sequence[str] = ()
    sliders: Mapping[str, ArrayLike] = field(default_factory=dict)
    barrels: Sequence[str] = ()
    traces: Sequence[str] = ()
    cloud: ArrayLike = ()
    backdrop: ArrayLike = ()
    arrows: Sequence[Arrows] = ()
    start: int = 0
    seconds: float = 4.0
    autoplay: bool = False

    def __post_init__(self):
        _finite("input", self.input.values, [(self.frames,)])
        if self.frames < 2:
            raise ValueError(f"a motion needs two frames or more, got {self.frames}")
        if not self.alt.strip():
            raise ValueError(f"alt must say what the picture shows, got {self.alt!r}")
        if not 0 <= self.start < self.frames:
            raise ValueError(f"start must be a frame from 0 to {self.frames - 1}, got {self.start}")
        if not self.seconds > 0:
            raise ValueError(f"seconds must be positive, got {self.seconds}")
        for name, place in self.joints.items():
            if not name or len(name.split()) != 1:
                raise ValueError(f"the name of a joint must be one word, got {name!r}")
            _finite(f"joint {name!r}", place, [(self.frames, 2), (2,)])
        for quantity in self.values:
            _finite(f"value {quantity.symbol!r}", quantity.values, [(self.frames,)])
        for arrows in self.arrows:
            for name, vectors in arrows.vectors.items():
                _finite(f"{arrows.label!r} at joint {name!r}", vectors, [(self.frames, 2)])
        for name, direction in self.sliders.items():
            _finite(f"direction of slider {name!r}", direction, [(2,)])
            if not np.any(direction):
                raise ValueError(f"direction of slider {name!r} must not be zero, got {direction}")
        for what, points in (("cloud", self.cloud), ("backdrop", self.backdrop)):
            if np.size(points):
                _finite(what, points, [(len(points), 2)])

        named = {f"body {body!r}": joints for body, joints in self.bodies.items()}
        named |= {"ground": self.ground, "sliders": self.sliders, "traces": self.traces}
        named |= {repr(arrows.label): arrows.vectors for arrows in self.arrows}
        for where, names in named.items():
            for name in names:
                if name not in self.joints:
                    raise ValueError(f"{where} has the unknown joint {name!r}; known are {', '.join(self.joints)}")
        for body, joints in self.bodies.items():
            if len(joints) < 2:
                raise ValueError(f"body {body!r} needs two joints or more, got {len(joints)}")
        for body in self.barrels:
            if body not in self.bodies:
                raise ValueError(f"barrels has the unknown body {body!r}; known are {', '.join(self.bodies)}")
        for name in self.ground:
            if np.ndim(self.joints[name]) != 1:
                raise ValueError(f"ground has the joint {name!r}, which moves; a pivot on the ground is a single point")
        if self.cyclic:
            for name, path in self._paths.items():
                steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
                closing = np.linalg.norm(path[-1] - path[0])
                if closing > 2 * steps.max(initial=0):
                    raise ValueError(
                        f"a cyclic motion must close, but from the last frame to the first joint {name!r} jumps "
                        f"{closing:.3g} m, and {steps.max():.3g} m at most between the others"
                    )

    @property
    def frames(self) -> int:
        """Number of positions."""
        return np.size(self.input.values)

    @cached_property
    def _paths(self) -> dict[str, np.ndarray]:
        """Each joint as an array of points, in metres: one for each frame, or only one if it is fixed."""
        return {name: np.atleast_2d(np.asarray(place, dtype=float)) for name, place in self.joints.items()}

    @property
    def _arrow_scales(self) -> list[float]:
        """Metres for a unit of each set of arrows: the longest arrow is a quarter of the mechanism."""
        size = np.ptp(np.concatenate(list(self._paths.values())), axis=0).max()
        return [0.25 * size / arrows.longest if arrows.longest else 0.0 for arrows in self.arrows]

    @cached_property
    def _frame(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Units for a metre, the upper left corner in metres, and width and height in units.

        Every position fits, and every arrow.
        """
        paths = self._paths
        tips = [
            paths[name] + scale * np.asarray(vectors, dtype=float)
            for arrows, scale in zip(self.arrows, self._arrow_scales, strict=True)
            for name, vectors in arrows.vectors.items()
        ]
        still = [np.reshape(np.asarray(each, dtype=float), (-1, 2)) for each in (self.cloud, self.backdrop)]
        points = np.concatenate([*paths.values(), *tips, *still])
        low, high = points.min(axis=0), points.max(axis=0)
        room = np.array([WIDTH, HEIGHT]) - 2 * MARGIN
        scale = float((room / np.maximum(high - low, 1e-12)).min())
        return scale, np.array([low[0], high[1]]), np.ceil((high - low) * scale + 2 * MARGIN)

    def drawn(self) -> dict[str, np.ndarray]:
        """Every joint in the coordinates of the picture.

        Returns
        -------
        dict of name to ndarray, shape (frames, 2) or (1, 2)
            In SVG units, y downwards, rounded to a hundredth.
        """
        return dict(self._drawn)

    @cached_property
    def _drawn(self) -> dict[str, np.ndarray]:
        return {name: self._to_picture(path) for name, path in self._paths.items()}

    def _to_picture(self, points: np.ndarray) -> np.ndarray:
        scale, corner, _ = self._frame
        return np.round((points - corner) * scale * (1, -1) + MARGIN, 2) + 0.0

    def __repr__(self) -> str:
        now = ", ".join(f"{q.symbol} = {q.texts()[self.start]}" for q in (self.input, *self.values))
        return f"{self.alt}\n{self.frames} frames of the joints {', '.join(self.joints)}. Drawn: {now}."

    def _repr_html_(self) -> str:
        values = "".join(
            f"<div><dt>{escape(q.symbol)}</dt><dd>{escape(q.texts()[self.start])}</dd></div>"
            for q in (self.input, *self.values)
        )
        data = json.dumps(self._data(), ensure_ascii=False, separators=(",", ":")).replace("<", r"\u003c")
        return (
            f'<div class="mechanism">\n{self._still()}\n<dl>{values}</dl>\n'
            f'<script type="application/json">{data}</script>\n</div>'
        )

    def _data(self) -> dict:
        """What the script needs: positions and arrows in SVG units, values as texts."""
        scale, *_ = self._frame
        arrows = [
            {
                "label": f"{a.label}, the longest {a.longest:.3g}\N{NO-BREAK SPACE}{a.unit}".rstrip(),
                "vectors": {
                    name: (np.round(np.asarray(v) * metres * scale * (1, -1), 2) + 0.0).tolist()
                    for name, v in a.vectors.items()
                },
            }
            for a, metres in zip(self.arrows, self._arrow_scales, strict=True)
        ]
        return {
            "joints": {name: path.tolist() for name, path in self._drawn.items()},
            "symbol": self.input.symbol,
            "values": [quantity.texts() for quantity in (self.input, *self.values)],
            "arrows": arrows,
            "start": self.start,
            "cyclic": self.cyclic,
            "seconds": self.seconds,
            "autoplay": self.autoplay,
            "words": WORDS,
        }

    def _still(self) -> str:
        """The frame that is drawn. Its colours are attributes, so that it is complete without the style of the book."""
        drawn = self._drawn
        now = {name: path[self.start if len(path) > 1 else 0] for name, path in drawn.items()}
        lines = 'fill="none" stroke-linecap="round" stroke-linejoin="round"'
        parts = []
        if np.size(self.backdrop):
            corners = _points(self._to_picture(np.asarray(self.backdrop, dtype=float)))
            filled = lines.replace('"none"', f'"{GREY}" fill-opacity="0.1"')
            parts.append(f'<polygon class="backdrop" points="{corners}" {filled} stroke="{GREY}" stroke-width="1.5"/>')
        for name in self.traces:
            shape = "polygon" if self.cyclic else "polyline"
            parts.append(
                f'<{shape} class="trace" points="{_points(drawn[name])}" {lines} stroke="{GREY}" stroke-width="1.5"/>'
            )
        if np.size(self.cloud):
            dots = "".join(f"M{_points([p])}h0" for p in self._to_picture(np.asarray(self.cloud, dtype=float)))
            parts.append(f'<path class="cloud" d="{dots}" {lines} stroke="{GREY}" stroke-width="3"/>')
        for name, direction in self.sliders.items():
            parts.append(
                f'<path class="guide" d="{_guide(drawn[name], direction)}" {lines} stroke="{INK}" stroke-width="1.5"/>'
            )
        for name in self.ground:
            parts.append(
                f'<path class="ground" d="{GROUND}" transform="translate({_points([now[name]])})" {lines} '
                f'stroke="{INK}" stroke-width="1.5"/>'
            )
        for number, (body, names) in enumerate(self.bodies.items()):
            parts.extend(self._body(number % len(COLOURS), body, names, now, lines))
        for name, direction in self.sliders.items():
            angle = np.rad2deg(np.arctan2(-direction[1], direction[0]))
            parts.append(
                f'<g data-joint="{escape(name)}" transform="translate({_points([now[name]])})">'
                f'<rect class="block" x="-17" y="-10" width="34" height="20" rx="2" transform="rotate({angle:.6g})" '
                f'fill="white" stroke="{INK}" stroke-width="2"/></g>'
            )
        for name, path in drawn.items():
            if not name.startswith("_"):
                x, y = self._letter_place(name)
                kind = "joint movable" if len(path) > 1 else "joint"
                parts.append(
                    f'<g class="{kind}" data-joint="{escape(name)}" transform="translate({_points([now[name]])})">'
                    f'<circle r="5.5" fill="{INK if len(path) > 1 else "white"}" stroke="{INK}" stroke-width="2.5"/>'
                    f'<text x="{x:.1f}" y="{y + 6:.1f}" text-anchor="middle" font-family="Georgia, serif" '
                    f'font-style="italic" font-size="18" fill="{INK}">{escape(name)}</text></g>'
                )
        width, height = self._frame[2]
        return (
            f'<svg role="img" aria-label="{escape(self.alt)}" viewBox="0 0 {width:g} {height:g}" '
            f'width="{width:g}" height="{height:g}">\n' + "\n".join(parts) + "\n</svg>"
        )

    def _body(self, colour: int, body: str, names: Sequence[str], now: dict, lines: str) -> list[str]:
        closed = len(names) > 2 and names[0] == names[-1]
        names = names[:-1] if closed else names
        what = (
            f'data-body="{escape(body)}" data-chain="{escape(" ".join(names))}" '
            f'points="{_points([now[name] for name in names])}"'
        )
        paint = f'class="colour{colour}" stroke="{COLOURS[colour]}"'
        if body in self.barrels:
            lines = lines.replace("round", "butt", 1)
            return [
                f'<polyline {what} {paint} {lines} stroke-width="24"/>',
                f'<polyline {what} class="bore" {lines} stroke="white" stroke-width="18"/>',
            ]
        if closed:
            filled = lines.replace('"none"', f'"{COLOURS[colour]}" fill-opacity="0.15"')
            return [f'<polygon {what} {paint} {filled} stroke-width="4"/>']
        return [f'<polyline {what} {paint} {lines} stroke-width="6"/>']

    def _letter_place(self, name: str) -> np.ndarray:
        """Where the letter stands, seen from its joint: on the side that is freest, now and during the motion."""
        drawn = self._drawn
        pairs = chain.from_iterable(map(pairwise, self.bodies.values()))
        neighbours = sorted({other for pair in pairs if name in pair for other in pair} - {name})
        taken = [drawn[other] - drawn[name] for other in neighbours]
        angles, distance = [-45, -135, -90, 0, 180, 45, 135, 90], 20
        if name in self.ground:
            angles, distance = [165, 15], 22  # beside the triangle, and not where a crank may hold its own letter
        if name in self.sliders:
            along, below = _guide_axes(self.sliders[name])
            taken += [along[None], -along[None], below[None]]
            distance = 26
        sides = np.column_stack((np.cos(np.deg2rad(angles)), np.sin(np.deg2rad(angles))))
        crowded = np.full((self.frames, len(sides)), -1.0)
        for away in taken:
            length = np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)
            crowded = np.maximum(crowded, away / length @ sides.T)  # 1: on the body
        return distance * sides[(crowded.mean(axis=0) + crowded[self.start]).round(6).argmin()]


def _finite(what: str, numbers: ArrayLike, shapes: list[tuple[int, ...]]) -> None:
    array = np.asarray(numbers, dtype=float)
    if array.shape not in shapes:
        raise ValueError(f"{what} must have the shape {' or '.join(map(str, shapes))}, got {array.shape}")
    if not np.isfinite(array).all():
        k = np.argwhere(~np.isfinite(array))[0][0]
        raise ValueError(
            f"{what} must be finite, got {array[k]} at index {k}; "
            "leave out the frames in which the mechanism cannot close"
        )


def _points(points: ArrayLike) -> str:
    return " ".join(f"{x:.6g},{y:.6g}" for x, y in points)


def _guide_axes(direction: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors in the picture along a guide and away from it: downwards, or to the right of a vertical guide."""
    along = np.asarray(direction, dtype=float) * (1, -1)
    along = along / np.linalg.norm(along)
    below = np.array([-along[1], along[0]])
    return along, (below if (below[1], below[0]) > (0, 0) else -below)


def _guide(path: np.ndarray, direction: ArrayLike) -> str:
    """A hatched line under the block, as long as the path of its joint asks for."""
    along, below = _guide_axes(direction)
    s = path @ along
    foot = path[0] - s[0] * along + 11 * below
    marks = [foot + t * along for t in np.arange(s.min() - 24, s.max() + 25, 8)]
    hatch = "".join(f"M{_points([mark])}l{_points([7 * below - 6 * along])}" for mark in marks[1:])
    return f"M{_points(marks[:1])}L{_points(marks[-1:])}{hatch}"
