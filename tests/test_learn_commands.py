import json
from dataclasses import replace

import numpy as np
import pytest
from made_up_skill import old_mapping, with_branch

from bath_drake.certificate.certify import certify, certify_from
from bath_drake.certificate_file import content_checksum
from bath_drake.cli import main
from bath_drake.demonstrations.canonical import CanonicalFrame
from bath_drake.demonstrations.recording import read_recording
from bath_drake.field_file import field_from_mapping
from bath_drake.resources import models_folder
from bath_drake.skill_file import certified, load_skill, save_skill
from bath_drake.yaml_io import dump_yaml

DEMONSTRATIONS = sorted(
    str(path) for path in (models_folder() / "demonstrations").glob("back_*.csv")
)
WORLD = {
    "workspace": {"centre": [0.0, 0.0], "semi_axes": [5.0, 5.0], "power": 2},
    "goal": [3.0, 0.0],
    "kappa": 4.0,
    "obstacles": [
        {"centre": [0.0, 0.0], "semi_axes": [1.0, 1.0], "angle": 0.0, "exponent": 1.0}
    ],
}
# A slit of 0.01 between two discs closes for the flow: it traps before them.
TRAP = WORLD | {
    "kappa": 20.0,
    "obstacles": [
        {"centre": [-0.5, y], "semi_axes": [0.8, 0.8], "angle": 0.0, "exponent": 1.0}
        for y in (0.805, -0.805)
    ],
}


@pytest.fixture(scope="module")
def arc(tmp_path_factory):
    """A planar recording in metres, off the origin: an arc from left to right."""
    path = tmp_path_factory.mktemp("arc") / "arc.csv"
    s = np.linspace(0.0, 1.0, 61)
    rows = zip(4.0 * s, 2.0 + 0.3 * s, 1.0 + 0.1 * np.sin(np.pi * s), strict=True)
    lines = [f"{t:.4f},{x:.6f},{y:.6f}" for t, x, y in rows]
    path.write_text("\n".join(["t_s,x_m,y_m", *lines]))
    return path


@pytest.fixture(scope="module")
def skill(arc, tmp_path_factory):
    """A quickly learned planar skill, its picture beside it."""
    path = tmp_path_factory.mktemp("skill") / "arc.yaml"
    assert (
        main(["learn", str(arc), "-o", str(path), "--quick", "--obstacles", "2"]) == 0
    )
    return path


def write_world(folder, world):
    path = folder / "world.yaml"
    path.write_text(dump_yaml({"field": world}))
    return str(path)


def with_field(skill, world):
    """The skill with another field and its certificate."""
    field = field_from_mapping(world)
    return certified(with_branch(skill, field=field), certify(field))


def refused(capsys, *words):
    """Runs a bad command; its one line on standard error."""
    try:
        code = main([str(word) for word in words])
    except SystemExit as stop:
        code = stop.code
    captured = capsys.readouterr()
    assert code == 2
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    return captured.err


def test_learning_writes_a_skill_that_knows_its_data_and_a_picture(skill, arc):
    learned = load_skill(skill)
    assert learned.demonstration_hashes == (read_recording(arc).sha256,)
    assert learned.canonical.kind == "planar"
    assert learned.certificate["verdict"] == "proved"
    assert learned.frechet["to_mean"] <= 0.1
    assert len(learned.field.obstacles) == 2
    assert sorted(path.name for path in skill.parent.iterdir()) == [
        "arc.png",
        "arc.yaml",
        "arc_fields.png",
        "arc_generalisation.png",
        "arc_population.png",
    ]
    for picture in skill.parent.glob("*.png"):
        assert picture.read_bytes().startswith(b"\x89PNG")


def test_holding_out_says_how_well_each_demonstration_is_foreseen(
    arc, tmp_path, capsys
):
    other = tmp_path / "arc_again.csv"
    # The same motion in another file: twice the same file would be one.
    other.write_text("#" + arc.read_text())
    output = tmp_path / "s.yaml"
    words = ["learn", str(arc), str(other), "-o", str(output), "--quick"]
    words += ["--obstacles", "2", "--held-out"]
    assert main([*words, "--pictures", "one"]) == 0
    said = capsys.readouterr().out
    assert "held out (learned from the others)" in said
    for line in said.splitlines():
        if line.startswith("  arc_again: 0."):
            # Both are the same recording: what is foreseen of it is what is learned.
            inside, outside = (float(x) for x in line.split(": ")[1].split(", "))
            assert abs(inside - outside) < 0.02
            break
    else:
        raise AssertionError("arc_again is not held out")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "arc_again.csv",
        "s.png",
        "s.yaml",
        "s_held_out.png",
    ]


def test_learning_prints_a_table_and_no_progress_in_a_pipe(arc, tmp_path, capsys):
    output = tmp_path / "s.yaml"
    words = ["learn", str(arc), "-o", str(output), "--quick", "--obstacles", "0"]
    words += ["--pictures", "one"]
    code = main(words)
    captured = capsys.readouterr()
    assert captured.err == ""
    for word in (
        "converged",
        "Frechet to mean",
        "obstacles        0",
        "verdict",
        "arc:",
        "near",
        "anywhere",
    ):
        assert word in captured.out
    # Without obstacles the flow goes straight, 0.33 off the arc: not converged.
    assert code == 1
    assert output.exists()


@pytest.mark.slow
def test_cycles_are_learned_and_reproduced_on_top(tmp_path, capsys):
    scrubbing = models_folder() / "demonstrations" / "scrubbing_1.csv"
    output, path = tmp_path / "s.yaml", tmp_path / "path.csv"
    words = ["--quick", "--obstacles", "0", "--pictures", "one"]
    main(["learn", str(scrubbing), "-o", str(output), *words])
    said = capsys.readouterr().out
    # Shown: 12.5 cycles in 14 s.
    assert "periodic         1.12 s a cycle" in said
    assert load_skill(output).periodic is not None
    start = [repr(float(value)) for value in load_skill(output).start]
    main(["reproduce", str(output), "--start", *start, "-o", str(path)])
    said = capsys.readouterr().out
    assert "cycles   1.12 s each" in said
    t, x, y = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    assert t[-1] > 10.0
    # Straight the way is 1.5 long; round 12 ovals it is several times that.
    assert np.hypot(np.diff(x), np.diff(y)).sum() > 4.0


@pytest.mark.slow
def test_the_shipped_strokes_are_learned_as_well_as_promised(tmp_path):
    outputs = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    for output in outputs:
        assert main(["learn", *DEMONSTRATIONS, "-o", str(output)]) == 0
    learned = load_skill(outputs[0])
    # The project's own limit for the paper's first experiment.
    assert learned.frechet["to_mean"] <= 0.03
    assert outputs[0].read_bytes() == outputs[1].read_bytes()


def test_bad_learning_input_is_refused_before_any_work(arc, tmp_path, capsys):
    out = tmp_path / "s.yaml"
    bad = tmp_path / "bad.csv"
    bad.write_text("t,x,y\n0,0,0\n1,nan,0\n")
    for words, message in [
        ((arc, "-o", tmp_path / "absent" / "s.yaml"), "does not exist"),
        ((arc, "-o", tmp_path), "expected a name ending .yaml"),
        ((arc, "-o", arc.with_suffix(".yaml")), "keeps its frame"),
        ((tmp_path / "absent.csv", "-o", out), "absent.csv: cannot be read"),
        ((bad, "-o", out), "bad.csv: line 3: found 'nan'"),
        ((arc, DEMONSTRATIONS[0], "-o", out), "3-D points, but"),
        ((arc, "-o", out, "--obstacles", "few"), "--obstacles: found 'few'"),
        ((arc, "-o", out, "--obstacles", "99"), "in 0..12, got 99"),
        ((arc, "-o", out, "--seed", "-1"), "--seed: found -1"),
        ((arc, "-o", out, "--held-out"), "--held-out: found one demonstration"),
        ((arc, "-o", out, "--method", "magic"), "invalid choice"),
        ((arc,), "-o"),
    ]:
        assert message in refused(capsys, "learn", *words)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv"]


def test_strokes_too_far_apart_once_their_ends_meet_are_refused(tmp_path, capsys):
    # Up and down one diagonal: laid onto one goal, they reach from corner to corner
    # of a box of twice the size, beyond the workspace.
    s = np.linspace(0.0, 1.0, 61)
    files = []
    for name, along in (("up", s), ("down", 1.0 - s)):
        lines = [f"{4 * t:.4f},{x:.6f},{x:.6f}" for t, x in zip(s, along, strict=True)]
        files.append(tmp_path / f"{name}.csv")
        files[-1].write_text("\n".join(["t,x,y", *lines]))
    out = tmp_path / "s.yaml"
    message = refused(capsys, "learn", *files, "-o", out)
    assert "up.csv: with its end on the common goal the stroke reaches 2.26" in message
    assert "allowed: 1.95" in message
    assert sorted(path.name for path in tmp_path.iterdir()) == ["down.csv", "up.csv"]


def test_a_skill_is_reproduced_from_its_start_to_its_goal(skill, tmp_path, capsys):
    learned = load_skill(skill)
    start = [repr(float(value)) for value in learned.start]
    path = tmp_path / "path.csv"
    assert main(["reproduce", str(skill), "--start", *start, "-o", str(path)]) == 0
    output = capsys.readouterr().out
    assert "arrived" in output
    assert "verdict  proved" in output
    header, *lines = path.read_text().splitlines()
    rows = np.array([line.split(",") for line in lines], dtype=np.float64)
    assert header == "t,x,y"
    np.testing.assert_allclose(rows[0], [0.0, *learned.start], atol=1e-8)
    # Roll-outs end within 1e-3 of the goal.
    assert np.linalg.norm(rows[-1, 1:] - learned.field.goal) <= 1e-3
    assert np.all(np.diff(rows[:, 0]) > 0.0)


def test_a_planar_skill_is_reproduced_in_the_demonstrations_coordinates(
    skill, arc, tmp_path
):
    demonstration = read_recording(arc).points
    path = tmp_path / "path.csv"
    words = ["reproduce", str(skill), "--frame", "demonstration", "-o", str(path)]
    words += ["--start", *(str(value) for value in demonstration[0])]
    assert main(words) == 0
    found = read_recording(path).points
    np.testing.assert_allclose(found[0], demonstration[0], atol=1e-8)
    # N's unit is 0.3 m / 1.6 here: 1e-3 of it, and what smoothing moved the goal.
    np.testing.assert_allclose(found[-1], demonstration[-1], atol=1e-3)


def test_another_goal_is_another_world_with_its_own_verdict(skill, capsys):
    learned = load_skill(skill)
    # Beside an obstacle, where its flat side may trap what comes from beyond.
    x, y, a, _, angle = learned.field.obstacles.theta[0]
    behind = np.array([x - 2 * a * np.sin(angle), y + 2 * a * np.cos(angle)])
    words = ["--start", "-0.5", "0.5", "--goal", *(repr(float(v)) for v in behind)]
    main(["reproduce", str(skill), *words])
    found = certify_from(learned.field.with_goal(behind), [-0.5, 0.5])
    assert f"verdict  {found.verdict}: {found.reason}" in capsys.readouterr().out


def test_a_trapped_roll_out_is_told_by_the_exit_code(skill, tmp_path, capsys):
    learned = load_skill(skill)
    path = tmp_path / "trap.yaml"
    save_skill(path, with_field(learned, TRAP))
    assert main(["reproduce", str(path), "--start", "-3", "0"]) == 1
    output = capsys.readouterr().out
    assert "trapped" in output
    assert "verdict  refuted" in output


def test_bad_reproduction_input_is_refused(skill, tmp_path, capsys):
    out = tmp_path / "p.csv"
    inside = load_skill(skill).field.obstacles.theta[0, :2]
    for words, message in [
        ((skill,), "--start"),
        ((skill, "--start", "nan", "0"), "--start: found"),
        ((skill, "--start", "0", "0", "--goal", "1", "inf"), "--goal: found"),
        ((skill, "--start", "9", "9"), "--start: (9, 9)"),
        ((skill, "--start", "0.9", "0.9", "--goal", *inside), "--goal: ("),
        ((skill, "--start", "0", "a"), "invalid float"),
        ((skill, "--start", "0", "0", "-o", tmp_path), "not the name of a file"),
        ((tmp_path / "absent.yaml", "--start", "0", "0"), "absent.yaml: cannot"),
    ]:
        assert message in refused(capsys, "reproduce", *words)
    assert not out.exists()


def test_a_skill_on_a_body_is_not_reproduced_in_recorded_coordinates(
    skill, tmp_path, capsys
):
    frame = CanonicalFrame("body_box", np.zeros(3), np.eye(3)[:2], np.ones(2))
    path = tmp_path / "body.yaml"
    save_skill(path, replace(load_skill(skill), canonical=frame))
    words = (path, "--start", "0", "0", "--frame", "demonstration")
    assert "body_box; allowed: canonical" in refused(capsys, "reproduce", *words)


def test_a_valid_world_passes_and_its_saddle_is_told(tmp_path, capsys):
    path = write_world(tmp_path, WORLD)
    assert main(["certify", path]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "proved"
    assert found["witness"] is None
    assert found["seconds"] > 0.0
    (saddle,) = found["critical_points"]
    assert saddle["kind"] == "saddle"
    # Known to five digits from a root search by hand.
    assert saddle["x"] == pytest.approx(-1.67172, abs=1e-5)
    assert saddle["y"] == pytest.approx(0.0, abs=1e-5)


def test_a_trap_is_refuted_and_its_minimum_is_the_witness(tmp_path, capsys):
    certificate = tmp_path / "certificate.json"
    path = write_world(tmp_path, TRAP)
    assert main(["certify", path, "-o", str(certificate)]) == 1
    assert "refuted" in capsys.readouterr().out
    found = json.loads(certificate.read_text())
    assert found["verdict"] == "refuted"
    (trap,) = found["traps"]
    for axis in ("x", "y"):
        low, high = trap["box"][axis]
        assert low <= trap[axis] <= high
        assert low <= found["witness"][axis] <= high
    assert (tmp_path / "certificate.png").read_bytes().startswith(b"\x89PNG")


def test_a_skill_whose_start_is_in_an_obstacle_is_refuted(skill, tmp_path, capsys):
    learned = load_skill(skill)
    assert main(["certify", str(skill)]) == 0
    path = tmp_path / "stuck.yaml"
    save_skill(path, with_branch(learned, start=learned.field.obstacles.theta[0, :2]))
    assert main(["certify", str(path), "-o", str(tmp_path / "c.json")]) == 1
    assert json.loads((tmp_path / "c.json").read_text())["verdict"] == "refuted"


def test_a_skill_in_a_field_that_traps_is_told_what_its_own_start_reaches(
    skill, tmp_path, capsys
):
    path = tmp_path / "skill.yaml"
    save_skill(path, with_branch(with_field(load_skill(skill), TRAP), start=[2.0, 1.0]))
    assert main(["certify", str(path)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "refuted"
    assert found["from_start"]["verdict"] == "proved"
    assert found["from_start"]["region"] is not None


def test_the_picture_goes_beside_the_certificate_or_where_it_is_told(
    skill, tmp_path, capsys
):
    world = write_world(tmp_path, WORLD)
    certificate, picture = tmp_path / "c.json", tmp_path / "p.png"
    words = ["certify", world, "-o", str(certificate), "--picture", str(picture)]
    assert main(words) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "c.png").exists()
    capsys.readouterr()
    # Alone, it leaves the JSON on standard output.
    assert main(["certify", str(skill), "--picture", str(picture)]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "proved"


def test_a_skill_of_version_1_is_renewed_and_its_field_kept(skill, tmp_path, capsys):
    old = old_mapping(load_skill(skill), version=1)
    old["certificate"] = {"verdict": "numeric-pass"}
    path = tmp_path / "old.yaml"
    path.write_text(dump_yaml(old | {"checksum": content_checksum(old)}))
    assert "certify --renew" in refused(capsys, "certify", path)
    assert main(["certify", str(path), "--renew"]) == 0
    assert path.read_bytes() == skill.read_bytes()


def test_bad_certification_input_is_refused(skill, tmp_path, capsys):
    world = write_world(tmp_path, WORLD)
    damaged = tmp_path / "damaged.yaml"
    damaged.write_text(skill.read_text().replace("kappa", "kapa"))
    for words, message in [
        ((tmp_path / "absent.yaml",), "absent.yaml: cannot be read"),
        ((tmp_path,), "found a directory"),
        ((damaged,), "checksum"),
        ((world, "-o", tmp_path / "absent" / "c.json"), "does not exist"),
        ((world, "-o", tmp_path), "not the name of a file"),
        ((world, "-o", tmp_path / "c.png"), "expected a name ending .json"),
        ((world, "--picture", tmp_path / "absent" / "c.png"), "does not exist"),
        ((world, "--renew"), "--renew is for skills"),
    ]:
        assert message in refused(capsys, "certify", *words)
