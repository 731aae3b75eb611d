import pytest

from bath_drake.benchmarks import field, fresh
from bath_drake.benchmarks.field import Effort
from bath_drake.benchmarks.figures import to_mapping

SMALL = Effort(
    disjoint=2,
    overlapping=2,
    boxes=400,
    box_worlds=2,
    proved=2,
    starts=20,
    points=100,
    batch=5,
    repeats=1,
    uncompiled=1,
)
# Figure -> target and unit, from the issue that asks for them.
TARGETS = {
    "proof_12_disjoint_median": (6.0, "ms"),
    "proof_12_disjoint_worst": (50.0, "ms"),
    "proof_12_disjoint_undecided": (0.0, ""),
    "proof_20_overlapping_median": (15.0, "ms"),
    "proof_20_overlapping_undecided": (0.1, "%"),
    "soundness_boxes": (1_000_000, ""),
    "soundness_boxes_wrong": (0.0, ""),
    "soundness_roll_outs": (20_000, ""),
    "soundness_roll_outs_lost": (0.0, ""),
    "first_call_cold": (40.0, "s"),
    "first_call_warm": (1.0, "s"),
    "flow_direction": (10.0, "ns"),
    "roll_out_200_steps": (40.0, "us"),
    "roll_out_batch_of_1000": (25.0, "ms"),
}


@pytest.fixture(scope="module")
def measured():
    """The figures of a small run without other processes, and its progress."""
    seen = []
    with pytest.MonkeyPatch.context() as patch:
        calls = [
            {"numba": 0.5, "call": t, "cpu": 0.9 * t} for t in (30.0, 0.7, 0.6, 0.8)
        ]
        patch.setattr(field, "first_calls", lambda warm: calls[: 1 + warm])
        patch.setattr(field, "uncompiled_proof_seconds", lambda worlds: [1.0] * worlds)
        figures = field.run(lambda what, share: seen.append((what, share)), SMALL)
    return {figure.name: figure for figure in figures}, seen


def test_every_figure_of_the_issue_is_there_with_its_target(measured):
    figures = to_mapping(list(measured[0].values()))
    for name, (target, unit) in TARGETS.items():
        assert figures[name]["target"] == target
        assert figures[name]["unit"] == unit
        assert figures[name]["value"] is not None
    aimed = {name for name, figure in figures.items() if figure["target"] is not None}
    assert aimed == set(TARGETS)


def test_speeds_come_with_ratios_against_plain_code(measured):
    figures, _ = measured
    for name in (
        "proof_12_disjoint",
        "flow_direction",
        "roll_out_200_steps",
        "roll_out_batch_of_1000",
    ):
        assert figures[f"{name}_speedup"].value > 0.0


def test_every_world_has_one_verdict(measured):
    figures, _ = measured
    disjoint = [
        figures[f"proof_12_disjoint_{verdict}"].value
        for verdict in ("proved", "refuted", "undecided")
    ]
    assert sum(disjoint) == SMALL.disjoint


def test_nothing_is_wrong_or_lost(measured):
    figures, _ = measured
    assert figures["soundness_boxes_wrong"].value == 0
    assert figures["soundness_roll_outs_lost"].value == 0
    # A smaller effort than the targets are meant for does not reach them.
    assert not figures["soundness_boxes"].passed


def test_the_first_call_is_the_cold_one_and_the_best_of_the_warm(measured):
    figures, _ = measured
    assert figures["first_call_cold"].value == 30.0
    assert figures["first_call_warm"].value == 0.6
    assert figures["import_of_numba"].value == 0.5


def test_progress_rises_from_none_to_all(measured):
    _, seen = measured
    shares = [share for _, share in seen]
    assert shares[0] == 0.0
    assert shares == sorted(shares)
    assert seen[-1] == ("done", 1.0)


@pytest.mark.exhaustive
def test_a_fresh_interpreter_tells_its_first_call():
    cold, warm = fresh.first_calls(1)
    assert set(cold) == set(warm) == {"numba", "call", "cpu"}
    # Compiling takes tens of seconds, loading what was compiled less than a few.
    assert cold["call"] > warm["call"] > 0.0


@pytest.mark.slow
def test_plain_python_proves_the_same_worlds():
    (plain,) = fresh.uncompiled_proof_seconds(1)
    assert plain > 0.0
