"""The slow and obvious lidar: every beam against every segment. Tests and the benchmark use it."""

import numpy as np


def dense_ranges(segments, place, angles, range_max, reach=0.0):
    """Return the (n,) ranges of beams at these world `angles` [rad] from a place (x, y); inf: none.

    `reach` makes every segment longer (or shorter) at both ends, by that part of its length.
    """
    if not len(segments):
        return np.full(len(angles), np.inf)
    a, b = segments[:, 0], segments[:, 1]
    ax, ay = a[:, 0] - place[0], a[:, 1] - place[1]
    dx, dy = (b - a).T
    c, s = np.cos(angles), np.sin(angles)
    with np.errstate(all="ignore"):
        across = c[None] * dy[:, None] - s[None] * dx[:, None]
        distance = (ax * dy - ay * dx)[:, None] / across
        along = (ax[:, None] * s[None] - ay[:, None] * c[None]) / across
    # Cramer's rule for (x, y) + t (c, s) = a + u d gives t = (a × d) / (c × d) and u as above.
    hit = (distance > 0) & (along >= -reach) & (along <= 1 + reach)
    ranges = np.where(hit, distance, np.inf).min(axis=0)
    ranges[ranges > range_max] = np.inf
    return ranges
