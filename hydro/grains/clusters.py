"""Clusters of grains: friends of friends."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hydro.grains.dynamics import Dynamics

LINK = 1.3  # diameters between the centres of friends, at most


def clusters(grains: Dynamics) -> np.ndarray:
    """Of each grain the rank of its cluster by size, 0 for the largest, shape (N,).

    Grains whose centres are nearer than LINK are friends, and with the friends of friends they are a cluster. A uniform
    gas falls into many small clusters up to n = 0.4, and is nearly all in one from 0.6 on.
    """
    box = grains.arena
    periods = [box.periodic_x * 1.0, box.periodic_y * box.length_y]
    friends = cKDTree(grains.places, boxsize=periods).query_pairs(LINK * box.diameter, output_type="ndarray")
    graph = coo_matrix((np.ones(len(friends), bool), friends.T), shape=(grains.number, grains.number))
    _, cluster = connected_components(graph, directed=False)
    by_size = np.argsort(-np.bincount(cluster), kind="stable")
    return np.argsort(by_size)[cluster]
