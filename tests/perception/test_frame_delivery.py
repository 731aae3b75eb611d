import copy

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bath_drake.perception.faults import FaultsConfig, FrameFault, LateFault
from bath_drake.perception.frame_delivery import (
    Delivery,
    Frame,
    FrameFate,
    dropped_frames,
    frame_fate,
    next_delivery,
)

PERIOD = 0.1


def frame(index):
    """An image that tells its number."""
    return Frame(
        stamp=PERIOD * index,
        colour=np.full((1, 1, 4), index, dtype=np.uint8),
        depth=np.full((1, 1), index, dtype=np.float32),
        arm_position=np.full(7, float(index)),
    )


def delivered(fates):
    """The newest frame after each one is taken."""
    delivery, newest = Delivery(), []
    for index, fate in enumerate(fates):
        delivery = next_delivery(delivery, index, frame(index), fate)
        newest.append(delivery.newest)
    return newest


def stamps(fates):
    return [None if f is None else round(f.stamp / PERIOD) for f in delivered(fates)]


def test_without_faults_every_frame_comes_at_once():
    assert stamps([FrameFate()] * 4) == [0, 1, 2, 3]


def test_a_lost_frame_leaves_the_last_one():
    lost = FrameFate(lost=True)
    assert stamps([lost, FrameFate(), lost, lost, FrameFate()]) == [None, 1, 1, 1, 4]


def test_a_late_frame_comes_with_its_own_time_and_arm():
    late = FrameFate(delay=2 * PERIOD)
    assert stamps([late] * 5) == [None, None, 0, 1, 2]
    assert delivered([late] * 5)[4].arm_position[0] == 2.0


def test_a_frame_that_a_newer_one_has_overtaken_never_comes():
    fates = [FrameFate(), FrameFate(delay=2 * PERIOD), FrameFate(), FrameFate()]
    assert stamps(fates) == [0, 0, 2, 3]


def test_a_frozen_frame_is_the_old_image_with_a_new_time():
    fates = [FrameFate(), FrameFate(), FrameFate(frozen=True), FrameFate(frozen=True)]
    shown = delivered(fates)
    assert [round(f.stamp / PERIOD) for f in shown] == [0, 1, 2, 3]
    assert [f.depth[0, 0] for f in shown] == [0.0, 1.0, 1.0, 1.0]
    # The very first cannot repeat anything.
    assert delivered([FrameFate(frozen=True)])[0].depth[0, 0] == 0.0


fates = st.builds(
    FrameFate,
    lost=st.booleans(),
    frozen=st.booleans(),
    delay=st.sampled_from([0.0, 0.05, 0.1, 0.25, 1.0]),
)


@given(st.lists(fates, max_size=30))
def test_time_never_runs_back_and_nothing_comes_before_it_is_due(fates):
    last = -np.inf
    for index, newest in enumerate(delivered(fates)):
        if newest is None:
            continue
        taken = round(newest.stamp / PERIOD)
        assert newest.stamp >= last
        assert not fates[taken].lost
        # Rounding of the stamps.
        assert newest.stamp + fates[taken].delay <= PERIOD * index + 1e-9
        last = newest.stamp


def fate_of(config, index, seed=4):
    return frame_fate(config, seed=seed, index=index, t=PERIOD * index)


def test_faults_strike_within_their_while_alone():
    config = FaultsConfig(
        loss=FrameFault(begin=0.3, end=0.6),
        frozen=FrameFault(begin=1.0, end=1.1),
        late=LateFault(begin=2.0, end=2.2, delay=0.15),
    )
    found = [fate_of(config, index) for index in range(30)]
    assert [k for k, f in enumerate(found) if f.lost] == [3, 4, 5]
    assert [k for k, f in enumerate(found) if f.frozen] == [10]
    assert {k: f.delay for k, f in enumerate(found) if f.delay} == {20: 0.15, 21: 0.15}


def test_chance_strikes_as_often_as_said_and_the_same_again():
    config = FaultsConfig(loss=FrameFault(probability=0.3))
    lost = [fate_of(config, index).lost for index in range(2000)]
    # Three deviations of 2000 draws.
    assert np.mean(lost) == pytest.approx(0.3, abs=0.031)
    assert lost == [fate_of(config, index).lost for index in range(2000)]
    assert lost != [fate_of(config, index, seed=5).lost for index in range(2000)]


def test_a_copy_of_the_state_copies_no_images():
    delivery = next_delivery(Delivery(), 0, frame(0), FrameFate())
    assert copy.deepcopy(delivery).newest is delivery.newest


def test_every_frame_of_a_gap_is_dropped_and_no_other():
    gap = FaultsConfig(loss=FrameFault(begin=0.95, end=1.55))
    # Those taken at 1.0 to 1.5 s.
    assert dropped_frames(gap, seed=3, period=PERIOD, count=40) == 6
    assert dropped_frames(FaultsConfig(), seed=3, period=PERIOD, count=40) == 0


def test_a_late_frame_is_dropped_only_if_a_newer_one_overtook_it():
    late = FaultsConfig(late=LateFault(begin=0.95, end=1.05, delay=0.25))
    assert dropped_frames(late, seed=3, period=PERIOD, count=40) == 1
    # All late by as much, none overtakes another; the last are still on their way.
    slow = FaultsConfig(late=LateFault(delay=0.25))
    assert dropped_frames(slow, seed=3, period=PERIOD, count=40) == 0


@given(seed=st.integers(0, 1000), probability=st.floats(0.0, 1.0))
def test_no_more_frames_are_dropped_than_lost_or_late(seed, probability):
    faults = FaultsConfig(
        loss=FrameFault(probability=probability),
        late=LateFault(probability=probability, delay=0.15),
    )
    fates = [frame_fate(faults, seed=seed, index=k, t=PERIOD * k) for k in range(30)]
    lost = sum(fate.lost for fate in fates)
    late = sum(fate.delay > 0.0 and not fate.lost for fate in fates)
    dropped = dropped_frames(faults, seed=seed, period=PERIOD, count=30)
    assert lost <= dropped <= lost + late
