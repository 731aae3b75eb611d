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
        "restricted_entries": {"value": entries, "limit": 0, "pass": entries == 0},
    }


def limit_checks(metrics: dict[str, Any], limits: Limits) -> dict[str, dict[str, Any]]:
    """Compares figures with limits; a figure that is missing has not passed.

    Args:
        metrics: The content of metrics.json but for the verdict.
        limits: Of the scenario; None asks for the figure alone.

    Returns:
        By name: `value`, `limit` and whether it did `pass`.
    """
    bounded = {
        "frechet_learned": (metrics["frechet"]["learned"], limits.frechet_learned),
        "frechet_executed": (metrics["frechet"]["executed"], limits.frechet_executed),
        "surface_error_mean_mm": (
            metrics["surface_error_mm"]["mean"],
            limits.surface_error_mean_mm,
        ),
        "surface_error_max_mm": (
            metrics["surface_error_mm"]["max"],
            limits.surface_error_max_mm,
        ),
        "normal_error_mean_deg": (
            metrics["normal_error_deg"]["mean"],
            limits.normal_error_mean_deg,
        ),
        "restricted_entries": (
            metrics["restricted_entries"],
            limits.restricted_entries,
        ),
        "wound_wetted_cm2": (
            metrics["washing"]["wound_wetted_cm2"],
            limits.wound_wetted_cm2,
        ),
        "washed_off_the_body": (metrics["washed_off_the_body"], 0),
        "moved_unproved": (metrics["certificate"]["samples_moved_unproved"], 0),
    }
    checks: dict[str, dict[str, Any]] = {
        "reached_goal": {
            "value": metrics["reached_goal"],
            "limit": True,
            "pass": metrics["reached_goal"],
        },
        "certificate": {
            "value": metrics["certificate"]["verdict"],
            "limit": "proved",
            "pass": metrics["certificate"]["verdict"] == "proved",
        },
    }
    force = metrics.get("force")
    if force is not None:
        bounded |= {
            "force_mean_error": (force["mean_error"], limits.force_mean_error),
            "force_peak": (force["peak"], limits.force_peak),
            "approach_speed_m_per_s": (
                force["approach_speed_m_per_s"],
                limits.approach_speed_m_per_s,
            ),
            "skin_speed_m_per_s": (
                metrics["speed_m_per_s"]["max"],
                limits.skin_speed_m_per_s,
            ),
            "touched_skin_mean_mm": (
                metrics["touched_skin_mm"]["mean"],
                limits.touched_skin_mean_mm,
            ),
        }
        for name in ("within_2_n", "contact_share"):
            least = getattr(limits, f"force_{name}")
            if least is not None:
                passed = force[name] is not None and bool(force[name] >= least)
                checks[f"force_{name}"] = {
                    "value": force[name],
                    "limit": least,
                    "pass": passed,
                }
    for name, (value, limit) in bounded.items():
        if limit is not None:
            passed = value is not None and bool(value <= limit)
            checks[name] = {"value": value, "limit": limit, "pass": passed}
    if limits.coverage is not None:
        share = metrics["coverage"]
        passed = share is not None and bool(share >= limits.coverage)
        checks["coverage"] = {"value": share, "limit": limits.coverage, "pass": passed}
    return checks
