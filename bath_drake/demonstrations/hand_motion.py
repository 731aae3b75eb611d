"""How the hand moved: a recording without noise and outliers, circles included."""

from dataclasses import dataclass

import numpy as np

from bath_drake.demonstrations.denoise import denoise
from bath_drake.demonstrations.outliers import find_outliers
from bath_drake.demonstrations.processing import take_apart
from bath_drake.demonstrations.recording import Recording
from bath_drake.notation import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class HandMotion:
    """A smooth motion, in the recording's frame.

    Attributes:
        t: (n,) s, those of the recording that are no outliers.
        points: (n, d) m.
        outliers: Indices of the recording's samples that were left out.
    """

    t: FloatArray
    points: FloatArray
    outliers: IntArray

    @property
    def length(self) -> float:
        """Of the path, m."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    @property
    def speed(self) -> FloatArray:
        """(n,) m/s."""
        rates = np.gradient(self.points, self.t, axis=0, edge_order=2)
        return np.asarray(np.linalg.norm(rates, axis=1))


def hand_motion(recording: Recording) -> HandMotion:
    """Smooths a recording as `canonical_demonstrations` does.

    The steps from sample to sample of the recording itself would be the noise's: 4 mm
    of it triple the length of a stroke of 8 s at 30 Hz.
    """
    part = take_apart(recording)
    if part.period is None:
        path = denoise(recording.t, recording.points)
        t = np.delete(recording.t, path.outliers)
        return HandMotion(t, path(t), path.outliers)
    stroke = denoise(part.t, part.discrete)(part.t)
    outliers = find_outliers(recording.t, recording.points)
    return HandMotion(part.t, stroke + part.periodic, outliers)
