import math

import numpy as np
import pytest

from bath_drake.benchmarks import frechet
from bath_drake.benchmarks.figures import Settings, to_mapping
from bath_drake.benchmarks.frechet_peers import PEERS, TO_BEAT, Peer
from bath_drake.benchmarks.registry import find
from bath_drake.errors import BathDrakeError
from bath_drake.learning.frechet import discrete_frechet

WITHOUT_PEERS = {
    *(f"frechet_{n}_{k}" for n in (100, 200, 1000) for k in ("unrelated", "alike")),
    "frechet_gradient_200_unrelated",
    "frechet_gradient_200_alike",
}
AGAINST_PEERS = (
    "frechet_200_unrelated_against_peers",
    "frechet_200_alike_against_peers",
)


def run(settings, seen=None):
    """With as few calls as there can be."""

    def progress(what, share):
        if seen is not None:
            seen.append((what, share))

    return frechet.run(settings, progress, effort=0.0)


@pytest.fixture
def quick(monkeypatch):
    """Plain numpy takes seconds for 1000 points: instead, nothing is compared."""
    monkeypatch.setattr(frechet, "plain_frechet", lambda a, b: 0.0)


def give_peers(monkeypatch, missing=()):
    """Peers that are our own distance, or not there."""

    def function(package):
        def load():
            if package in missing:
                raise ModuleNotFoundError("not there", name=f"{package}.core")
            return lambda a, b: (1.0 + 1e-9) * discrete_frechet(a, b)

        return load

    peers = [Peer(name, function(name), f"get {name}") for name in (*TO_BEAT, "other")]
    monkeypatch.setattr(frechet, "PEERS", peers)


def test_it_measures_three_sizes_of_two_kinds_and_aims_at_200_points(quick):
    seen = []
    report = run(Settings(), seen)
    figures = to_mapping(report.figures)
    assert set(figures) == WITHOUT_PEERS | {
        f"{name}_speedup" for name in WITHOUT_PEERS if "gradient" not in name
    }
    aimed = {name: f["target"] for name, f in figures.items() if f["target"]}
    assert aimed == {"frechet_200_unrelated": 80.0, "frechet_200_alike": 80.0}
    for name in WITHOUT_PEERS:
        assert figures[name]["unit"] == "us"
        assert figures[name]["value"] > 0.0
    assert report.rows == []
    shares = [share for _, share in seen]
    assert shares == sorted(shares)
    assert seen[-1] == ("done", 1.0)


def test_peers_are_measured_and_the_fastest_is_to_be_beaten_twice(quick, monkeypatch):
    give_peers(monkeypatch)
    report = run(Settings(peers=True))
    figures = to_mapping(report.figures)
    assert [row["peer"] for row in report.rows] == [*TO_BEAT, "other"]
    for row in report.rows:
        assert row["note"] == ""
        assert row["differs_by"] == pytest.approx(1e-9, rel=1e-6)
    for name, kind in zip(AGAINST_PEERS, ("unrelated", "alike"), strict=True):
        times = [r[f"{kind}_us"] for r in report.rows if r["peer"] in TO_BEAT]
        ratio = min(times) / figures[f"frechet_200_{kind}"]["value"]
        assert figures[name]["value"] == pytest.approx(ratio)
        assert figures[name]["target"] == 2.0
        assert figures[name]["bound"] == "at least"


def test_a_missing_peer_is_told_with_what_installs_it_and_meets_no_target(
    quick, monkeypatch
):
    give_peers(monkeypatch, missing=("tslearn",))
    report = run(Settings(peers=True))
    notes = {row["peer"]: row["note"] for row in report.rows}
    assert notes.pop("tslearn") == "missing (tslearn.core): get tslearn"
    assert set(notes.values()) == {""}
    figures = {figure.name: figure for figure in report.figures}
    for name in AGAINST_PEERS:
        assert math.isnan(figures[name].value)
        assert not figures[name].passed


def test_a_missing_peer_that_is_not_to_be_beaten_costs_no_target(quick, monkeypatch):
    give_peers(monkeypatch, missing=("other",))
    report = run(Settings(peers=True))
    assert report.rows[-1]["note"] == "missing (other.core): get other"
    figures = {figure.name: figure for figure in report.figures}
    assert all(math.isfinite(figures[name].value) for name in AGAINST_PEERS)


@pytest.mark.parametrize(("n", "m"), [(1, 1), (1, 7), (7, 1), (12, 12), (30, 17)])
def test_plain_numpy_gives_the_same_distance(n, m):
    rng = np.random.default_rng(n + m)
    a, b = rng.normal(size=(n, 2)), rng.normal(size=(m, 2))
    assert frechet.plain_frechet(a, b) == discrete_frechet(a, b)


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.package)
def test_a_peer_agrees_or_is_said_to_be_missing(peer):
    distance = peer.load()
    if isinstance(distance, str):
        assert distance.endswith(peer.install)
        assert peer.package in peer.install
        return
    for a, b in (*frechet.walks(30), *frechet.takes(30)):
        # Distances are rounded in other places.
        assert distance(a, b) == pytest.approx(discrete_frechet(a, b), rel=1e-14)


@pytest.mark.parametrize("make", [frechet.walks, frechet.takes])
def test_curves_are_the_same_in_every_run(make):
    for (a, b), (c, d) in zip(make(50), make(50), strict=True):
        assert a.shape == b.shape == (50, 2)
        np.testing.assert_array_equal(a, c)
        np.testing.assert_array_equal(b, d)


def test_its_only_option_is_peers():
    find("frechet", Settings(peers=True))
    with pytest.raises(BathDrakeError, match=r"allowed: --json, --peers$"):
        find("frechet", Settings(held_out=True))
