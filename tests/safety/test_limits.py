import pytest

from bath_drake.errors import LimitsError
from bath_drake.safety.limits import (
    GuardLimits,
    check_limits,
    dump_limits,
    load_limits,
    shipped_limits,
)


def test_the_limits_that_ship_are_the_defaults():
    assert load_limits() == GuardLimits()


def test_the_file_that_ships_names_every_limit():
    shipped = shipped_limits().read_text(encoding="utf-8")
    for block, limits in vars(GuardLimits()).items():
        for key in (f"{block}:", *(f"{name}:" for name in vars(limits))):
            assert key in shipped


def test_the_careful_figures_near_people_are_those_of_the_facts():
    limits = load_limits()
    assert limits.canonical.skin_speed == 0.10
    assert limits.nozzle.approach_speed == 0.05
    assert (limits.frames.hold_age, limits.frames.retreat_age) == (0.1, 0.5)
    assert (limits.force.retreat, limits.force.stop) == (15.0, 25.0)
    assert limits.joints.margin == 0.1
    assert (limits.joints.condition_slow, limits.joints.condition_stop) == (17.0, 30.0)


def test_written_limits_read_back_the_same(tmp_path):
    limits = GuardLimits()
    limits.force.retreat = 7.5
    limits.joints.velocity[3] = 0.5
    path = tmp_path / "limits.yaml"
    path.write_text(dump_limits(limits), encoding="utf-8")
    assert load_limits(path) == limits


def test_what_is_left_out_is_as_it_ships(tmp_path):
    path = tmp_path / "limits.yaml"
    path.write_text("force: {stop: 20}\n", encoding="utf-8")
    expected = GuardLimits()
    expected.force.stop = 20.0
    assert load_limits(path) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("speed: 1\n", "speed: unknown key, allowed: canonical"),
        ("force: {pull: 1}\n", "force.pull: unknown key, allowed: retreat, stop"),
        ("force: {stop: 26}\n", "force.stop: found 26.0, allowed 1 to 25"),
        ("force: {stop: strong}\n", "force.stop: found 'strong', expected a number"),
        ("force: {stop: .nan}\n", "line 1: number .nan is not finite"),
        (
            "force: {stop: 10}\n",
            "force.retreat: found 15.0, allowed less than force.stop (10.0)",
        ),
        ("canonical: {skin_speed: 0.2}\n", "skin_speed: found 0.2, allowed 0.001 to"),
        ("joints: {velocity: [1, 1]}\n", "joints.velocity: found 2 numbers, allowed 7"),
        (
            "joints: {velocity: [1, 1, 1, 9, 1, 1, 1]}\n",
            "joints.velocity[3]: found 9.0, allowed 0.001 to 2.62",
        ),
        ("frames: {hold_age: 0.5}\n", "frames.hold_age: found 0.5, allowed less than"),
        ("- a\n", "found list"),
    ],
)
def test_a_bad_file_is_refused_by_file_and_key(tmp_path, text, message):
    path = tmp_path / "limits.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(LimitsError) as caught:
        load_limits(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(LimitsError, match=r"nowhere\.yaml"):
        load_limits(tmp_path / "nowhere.yaml")


def test_numbers_that_are_none_are_refused_in_the_program_too():
    limits = GuardLimits()
    limits.loop.resume_time = float("nan")
    with pytest.raises(ValueError, match=r"loop\.resume_time: found nan"):
        check_limits(limits)
