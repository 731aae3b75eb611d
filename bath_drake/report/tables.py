"""The report's figures as words and rows of tables."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bath_drake.certificate.result import Certificate
from bath_drake.report.run_data import RunData

_REACH = {
    "whole": "Almost every start in free space reaches the goal, and none touches a "
    "boundary.",
    "start": "Almost every point that the motion from its start can come to (its "
    "component of a sublevel set) flows to the goal, and none touches a boundary; "
    "elsewhere the field may trap.",
}
_SCOPE = (
    "The proof is by interval arithmetic, rounding included. It is about the field: "
    "a static world with the obstacles as drawn, and a point that follows the flow. It "
    "says nothing of the arm's lag, the camera's errors beyond the areas' margin, the "
    "skin's motion or faults in software. While the world in force is not proved the "
    "robot holds."
)

# Figures of `metrics.periodic`.
_CYCLES = {
    "cycles": "how many",
    "gain": "share washed of what was asked for",
    "asked_share": "share asked for of what was learned",
}


def certificate_text(certificate: Certificate) -> str:
    """What is proved of the world that was driven in, and what is not."""
    if not certificate.passed:
        where = f" {doubts}" if (doubts := _doubts(certificate)) else ""
        return (
            f"Not proved ({certificate.verdict}): {certificate.reason}.{where} In such "
            "a world the robot holds."
        )
    reach = _REACH["whole" if certificate.region is None else "start"]
    return f"Proved: {certificate.reason}. {reach} {_SCOPE}"


def _doubts(certificate: Certificate) -> str:
    return " ".join(f"{d.cause}: {d.remedy}." for d in certificate.doubts[:3])


def certificate_rows(run: RunData) -> list[tuple[str, str]]:
    """Verdict, extent and cost of the run's proofs."""
    told = run.metrics["certificate"]
    seconds = told.get("proof_seconds", {})
    of_skill = run.skill.certificate.get("verdict")
    rows = [
        ("world driven in", told.get("world")),
        ("verdict", told.get("verdict")),
        ("covers", told.get("covers")),
        ("the skill's own certificate", of_skill),
        ("fields followed", _stages(run)),
        ("sensed areas", told.get("sensed_areas")),
        ("proofs during the run", told.get("proofs")),
        ("a proof took, mean", milliseconds(seconds.get("mean"))),
        ("a proof took, at most", milliseconds(seconds.get("max"))),
        ("samples in which it moved unproved", told.get("samples_moved_unproved")),
    ]
    return [(name, number(value)) for name, value in rows]


def _stages(run: RunData) -> str | None:
    told = run.metrics.get("stages")
    return None if told is None else f"{told['reached']} of {told['count']}"


def milliseconds(seconds: float | None) -> str | None:
    """A time in ms, with its unit; None for none."""
    return None if seconds is None else f"{number(1e3 * seconds)} ms"


def washing_rows(run: RunData) -> list[tuple[str, str]]:
    """What was to be washed, what was, and what got wet besides."""
    figures = run.metrics.get("washing") or {}
    return [(words(name), number(figures[name])) for name in figures]


def frechet_text(run: RunData) -> str:
    """Learned, executed and floor, as far as the skill knows them."""
    learned = number(run.metrics["frechet"].get("learned"))
    parts = [f"Fréchet {learned}"]
    floor = run.skill.frechet.get("floor")
    if floor is not None:
        parts.append(f"floor {number(floor)}")
    return ", ".join(parts)


def frechet_rows(run: RunData) -> list[tuple[str, str]]:
    """The run's figures, then what the learner noted; the raw scale last."""
    of_run = dict(run.metrics["frechet"])
    scale = of_run.pop("scale", None)
    rows = [(words(name), number(value)) for name, value in of_run.items()]
    rows += [
        (f"in learning: {words(name)}", number(value))
        for name, value in run.skill.frechet.items()
    ]
    periodic = run.metrics.get("periodic") or {}
    rows += [
        (f"cycles: {_CYCLES.get(k, words(k))}", number(periodic[k])) for k in periodic
    ]
    if scale is not None:
        rows.append(("1 stands for, in canonical units", number(scale)))
    return rows


# Keys that do not end in their unit.
_TOLD = {
    "force_mean_error": "force: mean error [N]",
    "force_within_2_n": "force: share within 2 N",
    "force_peak": "force: peak [N]",
    "force_contact_share": "contact: share of the stroke",
}


def check_rows(checks: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The verification's checks, one row each."""
    return [
        {
            "name": words(name),
            "value": number(check["value"]),
            "limit": number(check["limit"]),
            "passed": bool(check["pass"]),
        }
        for name, check in checks.items()
    ]


def words(name: str) -> str:
    """A check's key as words: units in brackets."""
    name = _TOLD.get(name, name)
    for end, unit in (
        ("_m_per_s", "m/s"),
        ("_cm2", "cm²"),
        ("_mm", "mm"),
        ("_deg", "°"),
        ("_s", "s"),
        ("_m_s", "m/s"),
    ):
        if name.endswith(end):
            return f"{name.removesuffix(end).replace('_', ' ')} [{unit}]"
    return name.replace("_", " ").replace("frechet", "Fréchet")


def number(value: Any) -> str:
    """A figure with three digits; a dash for none."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return str(value)
    if isinstance(value, float | np.floating):
        if not np.isfinite(value):
            return "–"
        number = float(value)
        return f"{number:.3g}" if abs(number) < 1000.0 else f"{number:.0f}"
    return str(value)


def guard_rows(
    seconds: Mapping[str, float], begun: Mapping[str, float]
) -> list[tuple[str, str]]:
    """For how long the guard let nothing pass, by reason, the longest first.

    Args:
        seconds: By reason.
        begun: How often, by reason; what it began with has not begun.
    """
    rows = []
    for name, time in sorted(seconds.items(), key=lambda item: -item[1]):
        times = int(begun.get(name, 0))
        rows.append((words(name), f"{time:.2f} s" + (f" ({times} ×)" if times else "")))
    return rows


def provenance(run: RunData) -> list[tuple[str, str]]:
    """Seed, versions and the demonstrations' hashes."""
    rows = [("seed", str(run.metrics["seed"]))]
    rows += [(str(k), str(v)) for k, v in run.metrics["versions"].items()]
    rows += [
        (f"demonstration {k + 1}, SHA-256", digest)
        for k, digest in enumerate(run.skill.demonstration_hashes)
    ]
    return rows
