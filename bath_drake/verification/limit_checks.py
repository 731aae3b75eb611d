"""A run's figures against the scenario's limits: the verdict."""

from typing import Any

from bath_drake.faults.expectation import Expectation, reaction_checks
from bath_drake.scenario import Limits


def fault_checks(
    metrics: dict[str, Any], expected: Expectation
) -> dict[str, dict[str, Any]]:
    """Compares the guard's reaction with what was expected; and nothing was entered.

    Args:
        metrics: The content of metrics.json but for the verdict.
        expected: Of the scenario.

    Returns:
        By name: `value`, `limit` and whether it did `pass`.
    """
    entries = metrics["restricted_entries"]
    return {
        **reaction_checks(expected, metrics["reaction"]),
        "restricted_entries": _check(entries, 0, entries == 0),
    }


def limit_checks(metrics: dict[str, Any], limits: Limits) -> dict[str, dict[str, Any]]:
    """Compares figures with limits; a figure that is missing has not passed.

    Args:
        metrics: The content of metrics.json but for the verdict.
        limits: Of the scenario; None asks for the figure alone.

    Returns:
        By name: `value`, `limit` and whether it did `pass`.
    """
    most = {
        "frechet_learned": metrics["frechet"]["learned"],
        "frechet_executed": metrics["frechet"]["executed"],
        "surface_error_mean_mm": metrics["surface_error_mm"]["mean"],
        "surface_error_max_mm": metrics["surface_error_mm"]["max"],
        "normal_error_mean_deg": metrics["normal_error_deg"]["mean"],
        "restricted_entries": metrics["restricted_entries"],
        "wound_wetted_cm2": metrics["washing"]["wound_wetted_cm2"],
    }
    least = {"coverage": metrics["coverage"]}
    force = metrics.get("force")
    if force is not None:
        most |= {
            "force_mean_error": force["mean_error"],
            "force_peak": force["peak"],
            "approach_speed_m_per_s": force["approach_speed_m_per_s"],
            "skin_speed_m_per_s": metrics["speed_m_per_s"]["max"],
            "touched_skin_mean_mm": metrics["touched_skin_mm"]["mean"],
        }
        least |= {
            "force_within_2_n": force["within_2_n"],
            "force_contact_share": force["contact_share"],
        }
    verdict = metrics["certificate"]["verdict"]
    unproved = metrics["certificate"]["samples_moved_unproved"]
    checks = {
        "reached_goal": _check(metrics["reached_goal"], True, metrics["reached_goal"]),
        "certificate": _check(verdict, "proved", verdict == "proved"),
    }
    for name, value in (least | most).items():
        limit = getattr(limits, name)
        if limit is not None:
            kept = value is not None and (
                value >= limit if name in least else value <= limit
            )
            checks[name] = _check(value, limit, kept)
    for name, count in (
        ("washed_off_the_body", metrics["washed_off_the_body"]),
        ("moved_unproved", unproved),
    ):
        checks[name] = _check(count, 0, count == 0)
    return checks


def _check(value: Any, limit: Any, passed: Any) -> dict[str, Any]:
    return {"value": value, "limit": limit, "pass": bool(passed)}
