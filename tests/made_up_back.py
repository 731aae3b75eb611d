"""A level back as the camera would see it, with a wound or without."""

import dataclasses

import numpy as np

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.perception.canonical import CanonicalMap

BODY = CanonicalMap(
    np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    np.array([0.7, 0.0, 0.9]),
    np.array([0.17, 0.25]),
)


def observed_back(wound=True, stamp=0.0):
    """A level back of 4 mm pixels, with a dark disc of 30 mm or without."""
    rows, columns = np.mgrid[10:110, 10:90]
    pixels = np.column_stack([columns.ravel(), rows.ravel()])
    p_P = (pixels - [50, 60]) * 0.004 * [1.0, -1.0]
    colours = np.full((len(pixels), 3), (200, 150, 120), dtype=np.uint8)
    if wound:
        colours[np.hypot(*(p_P - [0.05, 0.05]).T) < 0.03] = (25, 12, 12)
    mask = np.zeros((120, 100), dtype=bool)
    mask[rows, columns] = True
    return dataclasses.replace(
        BodyObservation(),
        found=True,
        stamp=stamp,
        mask=mask,
        robot_mask=np.zeros_like(mask),
        pixels=pixels,
        colours=colours,
        points_W=BODY.p_WP + p_P @ BODY.R_WP[:, :2].T,
        point_areas=np.full(len(pixels), 0.004**2),
    )
