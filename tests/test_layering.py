"""Imports point one way, and the pure packages know nothing of Drake."""

import ast
from pathlib import Path

import pytest

import bath_drake

PACKAGE = Path(bath_drake.__file__).parent
PURE = (
    "field",
    "certificate",
    "composition",
    "rhythm",
    "demonstrations",
    "learning",
    "perception",
    "rendering",
    "safety",
    "control",
    "patient",
    "carer",
    "faults",
    "washing",
)
# A module may import from its own room and from those before it.
ORDER = (
    ("errors", "notation", "resources", "shared", "doctor"),
    ("threads",),
    ("files", "folder_lock"),
    ("yaml_io", "yaml_block"),
    ("schema", "field"),
    ("certificate",),
    ("composition",),
    ("certificate_file", "field_file"),
    ("perception", "rhythm"),
    ("demonstrations", "rendering"),
    ("learning", "safety", "patient"),
    ("carer", "faults", "washing"),
    ("control",),
    ("branch_file", "rhythm_file"),
    ("skill_file",),
    ("systems",),
    ("scene",),
    ("scenario",),
    ("strokes",),
    ("diagrams",),
    ("reach",),
    ("simulation_log",),
    ("simulation",),
    ("carer_recording",),
    ("verification",),
    ("report",),
    ("learning_figures",),
    ("meshcat",),
    ("run_folder",),
    ("benchmarks",),
    ("commands",),
    ("cli",),
    ("__main__",),
)
LOOP = ("perception", "safety", "control", "systems", "diagrams")
# What films a carer: no robot is told anything there.
FILMED = {"systems/carer_motion.py", "diagrams/recording.py"}
RANK = {room: rank for rank, rooms in enumerate(ORDER) for room in rooms}
MODULES = sorted(PACKAGE.rglob("*.py"))


def imported_names(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield node.module or ""
            if node.module == "bath_drake":
                yield from (f"bath_drake.{alias.name}" for alias in node.names)


def room_of(path):
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return parts[0]


@pytest.mark.parametrize("room", PURE)
def test_pure_packages_import_no_pydrake(room):
    paths = list((PACKAGE / room).rglob("*.py"))
    assert paths
    for path in paths:
        guilty = [n for n in imported_names(path) if n.split(".")[0] == "pydrake"]
        assert not guilty, f"{path.relative_to(PACKAGE)} imports {guilty}"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_back_only(path):
    room = room_of(path)
    if room == "__init__":
        return
    assert room in RANK, f"{room} has no place in the order of rooms"
    for name in imported_names(path):
        parts = name.split(".")
        if parts[0] != "bath_drake" or len(parts) == 1 or parts[1] not in RANK:
            continue
        assert parts[1] == room or RANK[parts[1]] < RANK[room], (
            f"{path.relative_to(PACKAGE)} imports {name}"
        )


def test_the_loop_never_imports_the_true_person():
    rooms = (*LOOP, "field")
    rooms_of_truth = (
        "people",
        "skin",
        "wound",
        "rig",
        "true_back",
        "washed_skin",
        "touched_skin",
        "shell",
        "gltf",
    )
    truths = tuple(f"bath_drake.patient.{name}" for name in rooms_of_truth)
    for path in MODULES:
        place = str(path.relative_to(PACKAGE))
        if room_of(path) in rooms and place not in FILMED:
            known = [n for n in imported_names(path) if n.startswith(truths)]
            assert not known, f"{place} knows the true person"


def test_the_carer_is_in_front_of_the_camera_alone():
    """The filmed carer is laid on the true skin: no loop may learn of it."""
    rooms = (*LOOP, "simulation")
    for path in MODULES:
        place = str(path.relative_to(PACKAGE))
        if room_of(path) in rooms and place not in FILMED:
            known = [n for n in imported_names(path) if "carer" in n]
            assert not known, f"{place} imports {known}"
