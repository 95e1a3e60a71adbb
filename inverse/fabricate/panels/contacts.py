"""Where thick panels run into each other: volumes of intersection over the motion, and the first contact."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.fabricate.extras import needed
from inverse.fabricate.panels.boxes import overlapping_boxes
from inverse.fabricate.panels.panels import Panels
from inverse.fabricate.panels.separation import gaps

CONTACT = 1e-9  # an overlap of this share of a panel, in depth or in volume, is contact
RESOLUTION = float(np.radians(1e-3))  # to which the first contact is located
_BEYOND = 8  # states between the range and the flat state
_STATES_AT_ONCE = 8  # bounds the memory


@dataclass(frozen=True)
class Contact:
    """Two panels that meet.

    Attributes:
        t: folding amount in radians.
        facets: the two, the smaller number first.
        volume: of their intersection at ``t``, cubic units of the design.
    """

    t: float
    facets: tuple[int, int]
    volume: float


def penetrations(panels: Panels, t: FloatArray) -> list[list[Contact]]:
    """All pairs of panels that penetrate each other, at each of the folding amounts ``t`` (S,), radians.

    Pairs are taken apart by bounding boxes, then by separating planes; where neither does, manifold3d computes the
    volume of the intersection. Less than 1e-9 of the smaller panel is contact, not penetration.

    Raises:
        InputError: manifold3d is not installed.
    """
    found = []
    for some in np.array_split(t, range(_STATES_AT_ONCE, len(t), _STATES_AT_ONCE)):
        found += [_penetrations(panels, *state) for state in zip(some, panels.bodies_at(some), strict=True)]
    return found


def first_contacts(
    panels: Panels, states: int = 24, progress: Callable[[float], None] | None = None
) -> tuple[Contact | None, Contact | None]:
    """The first contact on the way to the developed and on the way to the flat-folded state, None without one.

    States are sampled from the middle of the range outwards, its limits included, then beyond them to the flat
    states; the first contact is located by bisection. One that comes and goes between two samples is missed.

    Args:
        panels: the thick structure.
        states: sampled over the range.
        progress: told every state, in radians, before it is looked at.
    """

    def worst(t: float) -> Contact | None:
        if progress is not None:
            progress(t)
        return max(penetrations(panels, np.array([t]))[0], key=lambda contact: contact.volume, default=None)

    low, high = panels.range.low, panels.range.high
    inside = np.array_split(panels.range.states(states | 1), [states // 2, states // 2 + 1])
    down, up = ([*inside[1], *way, *_beyond(end, flat)] for way, end, flat in
                ((inside[0][::-1], low, 0.0), (inside[2], high, np.pi)))  # fmt: skip
    return _first(worst, down), _first(worst, up)


def _beyond(limit: float, flat: float) -> list[float]:
    return [] if limit == flat else np.linspace(limit, flat, _BEYOND)[1:].tolist()


def _first(contact_at: Callable[[float], Contact | None], states: list[float]) -> Contact | None:
    """The first contact along these states, located between the last one without and the first one with one."""
    found = contact_at(states[0])
    if found is not None:
        return found
    for free, t in pairwise(states):
        found = contact_at(t)
        if found is not None:
            return _located(contact_at, free, found)
    return None


def _located(contact_at: Callable[[float], Contact | None], free: float, found: Contact) -> Contact:
    while abs(found.t - free) > RESOLUTION:
        middle = (free + found.t) / 2
        here = contact_at(middle)
        free, found = (middle, found) if here is None else (free, here)
    return found


def _penetrations(panels: Panels, t: float, bodies: FloatArray) -> list[Contact]:
    """Contacts among bodies (F, L, 2, K, 3) of one state."""
    volumes: dict[tuple[int, int], float] = {}
    for facets, volume in _overlaps(bodies, CONTACT * panels.thickness.thickness):
        volumes[facets] = volumes.get(facets, 0.0) + volume
    whole = panels.volumes.sum(axis=1)
    return [
        Contact(float(t), facets, volume)
        for facets, volume in sorted(volumes.items())
        if volume > CONTACT * whole[list(facets)].min()
    ]


def _overlaps(bodies: FloatArray, depth: float) -> Iterator[tuple[tuple[int, int], float]]:
    """Facets and volume of intersection of every pair of bodies that planes do not separate."""
    layers = bodies.shape[1]
    flat = bodies.reshape(-1, *bodies.shape[2:])
    one, other = _candidates(flat, layers).T
    deep = gaps(flat[one], flat[other]) < -depth
    if not deep.any():
        return
    manifold3d = needed("manifold3d")
    for pair in zip(one[deep].tolist(), other[deep].tolist(), strict=True):
        a, b = (manifold3d.Manifold.hull_points(_about(flat, pair, k)) for k in pair)
        yield (pair[0] // layers, pair[1] // layers), float((a ^ b).volume())


def _candidates(bodies: FloatArray, layers: int) -> IntArray:
    """(P, 2): pairs of bodies of two panels whose boxes overlap."""
    corners = bodies.reshape(len(bodies), -1, 3)
    pairs = overlapping_boxes(corners.min(axis=1), corners.max(axis=1))
    return np.asarray(pairs[pairs[:, 0] // layers != pairs[:, 1] // layers])


def _about(bodies: FloatArray, pair: tuple[int, int], which: int) -> FloatArray:
    """Corners of a body, the origin near the pair, where numbers are finest."""
    return np.ascontiguousarray((bodies[which] - bodies[pair[0], 0, 0]).reshape(-1, 3))
