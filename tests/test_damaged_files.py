"""Whatever is done to a file: it is read, or refused on one line, and soon."""

import resource
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_up_carer import write_recording
from made_up_run import write_run

from bath_drake.demonstrations.metadata import read_metadata
from bath_drake.demonstrations.recording import read_recording
from bath_drake.demonstrations.rgbd.folder import open_rgbd
from bath_drake.errors import BathDrakeError
from bath_drake.patient.people import load_person
from bath_drake.patient.rig import bending_skin
from bath_drake.patient.skin import TrueSkin
from bath_drake.patient.skin_parts import skin_parts
from bath_drake.report.run_data import load_run
from bath_drake.resources import diagrams_folder, models_folder
from bath_drake.scenario import Scenario, load_scenario
from bath_drake.skill_file import load_skill

# The issue's: seconds for a file, and growth of the whole process, kilobytes.
SECONDS, GROWTH_KB = 5.0, 1_000_000

# What breaks readers of numbers, of YAML, of tables and of what is counted.
TOKENS = (
    *(b"nan", b"-inf", b"1e999", b"-1", b"0", b"1e-320", b"9" * 30, b"0x1f", b"1:2:3"),
    *(b"", b"\x00", b"\xff\xfe", b"\xc3\x28", b"\n", b"\r", b"\t", b",", b":", b"- "),
    *(b"[" * 3000, b"{a: " * 99, b"&a [*a]", b"<<: *a", b"? ", b'"', b"'"),
    *(b"!!python/object:os.system", b"%YAML 9.9\n---\n", b"yes", b"null", b"true"),
    b"a: &a [x,x]\nb: &b [*a,*a]\nc: &c [*b,*b]\n",
)

SHARE = st.floats(0.0, 1.0, exclude_max=True)
CHANGE = st.one_of(
    st.tuples(st.just("token"), SHARE, st.sampled_from(TOKENS)),
    st.tuples(st.just("byte"), SHARE, st.binary(min_size=1, max_size=4)),
    st.tuples(st.just("cut"), SHARE, st.integers(1, 2000)),
    st.tuples(st.just("end"), SHARE, st.none()),
    st.tuples(st.just("twice"), SHARE, st.integers(1, 2000)),
    st.tuples(st.just("number"), SHARE, st.sampled_from(TOKENS)),
    st.tuples(st.just("line"), SHARE, SHARE),
)

CHANGES = st.lists(CHANGE, min_size=1, max_size=3)


def damaged(content: bytes, changes) -> bytes:
    """The content after each change, at its share of the length."""
    for kind, share, what in changes:
        k = int(share * len(content))
        if kind == "token":
            content = content[:k] + what + content[k:]
        elif kind == "byte":
            content = content[:k] + what + content[k + len(what) :]
        elif kind == "cut":
            content = content[:k] + content[k + what :]
        elif kind == "end":
            content = content[:k]
        elif kind == "twice":
            content = content[: k + what] + content[k:]
        elif kind == "number":  # the word there, such as a number, for another
            left = max(content.rfind(c, 0, k) for c in (b" ", b",", b"\n", b"[")) + 1
            ends = [content.find(c, k) for c in (b" ", b",", b"\n", b"]")]
            right = min((e for e in ends if e >= 0), default=len(content))
            content = content[:left] + what + content[right:]
        elif kind == "line":
            lines = content.split(b"\n")
            lines.insert(int(what * len(lines)), lines.pop(int(share * len(lines))))
            content = b"\n".join(lines)
    return content


def read_person(folder: Path) -> None:
    person = load_person(folder)
    TrueSkin(person).under(np.zeros((1, 2)))
    if person.rigged:
        bending_skin(person)
        skin_parts(person, None)


def read_film(folder: Path) -> None:
    for _ in open_rgbd(folder):
        pass


@dataclass(frozen=True)
class Kind:
    """What can be damaged: how it is made, which files, and who reads it."""

    make: Callable[[Path], Path]
    files: tuple[str, ...]
    read: Callable[[Path], object]


def copied(source: Path) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        target = folder / source.name
        shutil.copytree(source, target) if source.is_dir() else shutil.copy(
            source, target
        )
        return target

    return make


def with_everything(folder: Path) -> Path:
    path = folder / "restricted_area.yaml"
    text = (diagrams_folder() / "restricted_area.yaml").read_text()
    more = "perception: {restricted_areas: [[[0, 0], [0.2, 0], [0, 0.2]]]}\n"
    path.write_text(text + more)
    load_scenario(path)
    return path


DEMONSTRATIONS = models_folder() / "demonstrations"
KINDS = {
    "recording": Kind(
        copied(DEMONSTRATIONS / "scrubbing_1.csv"), ("",), read_recording
    ),
    "metadata": Kind(copied(DEMONSTRATIONS / "scrubbing_1.yaml"), ("",), read_metadata),
    "skill": Kind(
        copied(models_folder() / "skills" / "scrubbing.yaml"), ("",), load_skill
    ),
    "skill renewed": Kind(
        copied(models_folder() / "skills" / "figure_eight.yaml"),
        ("",),
        lambda path: load_skill(path, renew=True),
    ),
    "scenario": Kind(with_everything, ("",), load_scenario),
    "person": Kind(
        copied(models_folder() / "people" / "f_thin"),
        ("person.yaml", "mesh.npz", "rig.npz", "back.gltf", "trunks.gltf"),
        read_person,
    ),
    "film": Kind(
        lambda folder: write_recording(folder / "film", frames=2),
        ("intrinsics.json", "timestamps.csv", "depth/000000.png", "color/000001.png"),
        read_film,
    ),
    "run": Kind(
        lambda folder: write_run(folder / "run", Scenario()),
        ("scenario.yaml", "skill.yaml", "log.npz", "metrics.json"),
        load_run,
    ),
}


@dataclass(frozen=True)
class Whole:
    """What is damaged, as it was; told briefly where a test fails."""

    kind: Kind
    path: Path
    contents: dict[str, bytes] = field(repr=False)


@pytest.fixture(scope="module", params=KINDS)
def whole(request, tmp_path_factory):
    kind = KINDS[request.param]
    path = kind.make(tmp_path_factory.mktemp("whole"))
    kind.read(path)
    contents = {
        file: (path / file if file else path).read_bytes() for file in kind.files
    }
    return Whole(kind, path, contents)


def check(whole, which, changes) -> None:
    kind, path, contents = whole.kind, whole.path, whole.contents
    file = kind.files[int(which * len(kind.files))]
    target = path / file if file else path
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # Of this process: other work on the machine is not the reader's.
    begin = time.process_time()
    said = ""
    try:
        target.write_bytes(damaged(contents[file], changes))
        kind.read(path)
    except BathDrakeError as error:
        said = str(error)
    finally:
        target.write_bytes(contents[file])
    assert "\n" not in said
    assert len(said) < 1000
    assert time.process_time() - begin < SECONDS
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < GROWTH_KB


QUICK = settings(suppress_health_check=[HealthCheck.too_slow])


@given(which=SHARE, changes=CHANGES)
@settings(QUICK, max_examples=25)
def test_a_damaged_file_is_read_or_refused_on_one_line(whole, which, changes):
    check(whole, which, changes)


@pytest.mark.exhaustive
@given(which=SHARE, changes=CHANGES)
@settings(QUICK, max_examples=2500)
def test_twenty_thousand_damaged_files_are_read_or_refused_on_one_line(
    whole, which, changes
):
    check(whole, which, changes)
