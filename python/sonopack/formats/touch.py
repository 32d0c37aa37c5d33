"""Finds what overlaps."""
from __future__ import annotations

import numpy as np

from .._core import Integers
from .work import Links, Work, joined, length, links_of


def grains(w: Work) -> Links:
    """All pairs of grains that overlap."""
    links = links_of(*_pairs(w))
    w.place_links(links)
    return links


def walls(w: Work) -> Links:
    """All grains that overlap the walls whose positions are known."""
    out = links_of([], [])
    for side in np.flatnonzero(w.has_wall):
        links = links_of(np.arange(w.n), np.full(w.n, -1 - side))
        w.place_links(links)
        out = joined(out, links[links.depth > 0])
    return out


def _pairs(w: Work) -> tuple[Integers, Integers]:
    """Pairs i < j that overlap, ascending. Near periodic faces the grains have images on the other side."""
    from scipy.spatial import cKDTree
    reach, lattice = 2.0001 * float(w.r.max()), w.lattice()
    x, s, of = w.x, w.fractions(w.x), np.arange(w.n)
    for a in np.flatnonzero(w.periodic[:w.dim]):
        turns = np.floor(s[:, a])
        x, near = x - turns[:, None] * lattice[a], reach / _thickness(w, a)
        s[:, a] -= turns
        first, last = np.flatnonzero(s[:, a] < near), np.flatnonzero(s[:, a] > 1 - near)
        images = np.concatenate([first, last])
        step = np.repeat([1.0, -1.0], [len(first), len(last)])
        x = np.concatenate([x, x[images] + step[:, None] * lattice[a]])
        s, of = np.concatenate([s, s[images]]), np.concatenate([of, of[images]])
    found = cKDTree(x[:, :w.dim], balanced_tree=False, compact_nodes=False).query_pairs(reach, output_type="ndarray")
    found = found[(found < w.n).any(axis=1)]
    i, j = of[found[:, 0]], of[found[:, 1]]
    overlap = (i != j) & (w.r[i] + w.r[j] > length(w.separation(i, j)))
    pair = np.unique(np.minimum(i, j)[overlap] * np.int64(w.n) + np.maximum(i, j)[overlap])
    return pair // w.n, pair % w.n


def _thickness(w: Work, a: int) -> float:
    """Distance between the faces of the box on an axis."""
    return 1 / float(np.linalg.norm(np.linalg.inv(w.lattice()[:w.dim, :w.dim])[:, a]))
