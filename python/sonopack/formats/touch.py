"""Finds what overlaps: grains sorted into cells as wide as the largest of them."""
from __future__ import annotations

import itertools
import math

import numpy as np

from .._core import Integers
from .work import Links, Work, fractions

_PART = 2_000_000  # pairs that are looked at together


def grains(w: Work) -> Links:
    """All pairs of grains that overlap, but for those across the face at which the box is cut."""
    i, j = _pairs(w)
    across = w.goes_across(i, j)
    w.report.across += int(across.sum())
    links = Links(int((~across).sum()))
    links.i, links.j = i[~across], j[~across]
    w.place_links(links)
    return links


def count(w: Work) -> int:
    """How many pairs overlap, but for those across."""
    i, j = _pairs(w)
    return int((~w.goes_across(i, j)).sum())


def walls(w: Work) -> Links:
    """All grains that overlap the walls whose positions are known."""
    out = Links()
    for side in range(6):
        if w.has_wall[side]:
            links = Links(w.n)
            links.i, links.j = np.arange(w.n), np.full(w.n, -1 - side)
            w.place_links(links)
            out = out + links.take(links.depth > 0)
    return out


def _pairs(w: Work) -> tuple[Integers, Integers]:
    """Pairs i < j that overlap, ascending."""
    counts = _counts(w)
    cell = _cells(w, counts)
    number = (cell[:, 2] * counts[1] + cell[:, 1]) * counts[0] + cell[:, 0]
    order = np.argsort(number, kind="stable")
    start = np.searchsorted(number[order], np.arange(math.prod(counts) + 1))
    found = [_touching(w, order, start, _neighbours(w, cell, counts, step)) for step in _steps(counts)]
    i, j = (np.concatenate(part) for part in zip(*found))
    pair = np.unique(i * np.int64(w.n) + j)
    return pair // w.n, pair % w.n


def _counts(w: Work) -> list[int]:
    """Cells along each axis."""
    wide, most = 2.0001 * float(w.r.max()), (8.0 * w.n + 64) ** (1 / w.dim)
    return [int(max(1, min(_thickness(w, a) // wide, most))) if a < w.dim else 1 for a in range(3)]


def _thickness(w: Work, a: int) -> float:
    """Distance between the faces of the box on an axis."""
    e, (xy, xz, yz) = w.edge, w.tilt
    if a == 0 and w.dim == 3:
        return e[0] * e[1] * e[2] / math.sqrt((e[1] * e[2]) ** 2 + (xy * e[2]) ** 2 + (xy * yz - e[1] * xz) ** 2)
    if a == 0:
        return e[0] * e[1] / math.hypot(e[1], xy)
    return e[1] * e[2] / math.hypot(e[2], yz) if a == 1 and w.dim == 3 else e[a]


def _cells(w: Work, counts: list[int]) -> Integers:
    """The cell of each grain along each axis."""
    s = np.stack(fractions(w, w.x), axis=1)
    for a in range(w.dim):
        if w.periodic[a]:
            s[:, a] -= np.floor(s[:, a])
    s[:, w.dim:] = 0
    limit = np.array(counts)
    return np.minimum((np.clip(s, 0, 1) * limit).astype(np.int64), limit - 1)


def _steps(counts: list[int]) -> list[tuple[int, ...]]:
    """The steps to a cell itself and its neighbours, each pair of cells once; where cells are few, each way."""
    ranges = [(0,) if n == 1 else (0, 1) if n == 2 else (-1, 0, 1) for n in counts]
    return [step for step in itertools.product(*ranges) if 2 in counts or step >= (0, 0, 0)]


def _neighbours(w: Work, cell: Integers, counts: list[int], step: tuple[int, ...]) -> tuple[Integers, Integers]:
    """The grains that have a cell at this step, and its number."""
    other = cell + np.array(step)
    inside = np.ones(len(cell), bool)
    for a, n in enumerate(counts):
        # of two cells that do not repeat, the first has the second at a step of 1, and the second the first: the same
        if n == 2 or w.periodic[a]:
            other[:, a] %= n
        else:
            inside &= (other[:, a] >= 0) & (other[:, a] < n)
    return np.flatnonzero(inside), ((other[:, 2] * counts[1] + other[:, 1]) * counts[0] + other[:, 0])[inside]


def _touching(w: Work, order: Integers, start: Integers, near: tuple[Integers, Integers]) -> tuple[Integers, Integers]:
    """The pairs of the first grains with those in the cells beside them that overlap."""
    first, cell = near
    many = start[cell + 1] - start[cell]
    ends = np.cumsum(many)
    out: list[tuple[Integers, Integers]] = [(np.zeros(0, np.int64), np.zeros(0, np.int64))]
    begin = 0
    while begin < len(first):
        before = int(ends[begin - 1]) if begin else 0
        stop = max(begin + 1, int(np.searchsorted(ends, before + _PART)))
        part = slice(begin, stop)
        i = np.repeat(first[part], many[part])
        at = np.arange(len(i)) - np.repeat(ends[part] - many[part] - before, many[part])
        j = order[np.repeat(start[cell[part]], many[part]) + at]
        out.append(_overlapping(w, i, j))
        begin = stop
    i, j = (np.concatenate(column) for column in zip(*out))
    return i, j


def _overlapping(w: Work, i: Integers, j: Integers) -> tuple[Integers, Integers]:
    other = i != j
    i, j = i[other], j[other]
    reach = 2.0001 * float(w.r.max())
    for a in reversed(range(w.dim if not any(w.tilt) else 0)):  # most are too far apart along one axis
        d = np.ascontiguousarray(w.x[:, a])
        d = d[j] - d[i]
        if w.periodic[a]:
            d -= w.edge[a] * np.rint(d / w.edge[a])
        near = np.abs(d) < reach
        i, j = i[near], j[near]
    links = Links(len(i))
    links.i, links.j = i, j
    w.place_links(links)
    touch = links.depth > 0
    return np.minimum(i, j)[touch], np.maximum(i, j)[touch]
