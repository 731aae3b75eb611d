"""Judging a run against the truth: figures, limits and the verdict."""

from bath_drake.verification.evaluation import (
    Evaluation,
    evaluate,
    pose_from_row,
    versions,
    wound_outlines,
)

__all__ = ["Evaluation", "evaluate", "pose_from_row", "versions", "wound_outlines"]
