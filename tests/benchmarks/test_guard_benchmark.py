import math

from bath_drake.benchmarks import guard


def test_both_guards_are_timed_while_they_pass():
    shares = []
    figures = guard.run(lambda what, share: shares.append(share), ticks=20)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    found = {figure.name: figure for figure in figures}
    for name in ("canonical", "joint"):
        p99 = found[f"guard_{name}_tick_p99"]
        # The target; a loaded machine may miss it, a figure must be there.
        assert (p99.target, p99.unit) == (1.0, "ms")
        assert math.isfinite(p99.value)
        assert found[f"guard_{name}_passed"].value == 100.0
