import os
import runpy
from pathlib import Path

import pytest

TUTORIALS = sorted((Path(__file__).parent.parent / "tutorials").glob("*.py"))
# Half a minute and more each, of what other tests do too.
LONG = (
    "02_the_papers_learner",
    "03_strokes_no_single_field_can_hold",
    "05_from_a_recording_to_circles",
)
RUN = [
    pytest.param(path, marks=pytest.mark.exhaustive) if path.stem in LONG else path
    for path in TUTORIALS
]


@pytest.fixture
def no_window(monkeypatch):
    # Chosen before pyplot is imported, and for those who imported it already.
    monkeypatch.setitem(os.environ, "MPLBACKEND", "Agg")
    import matplotlib.pyplot as plt

    backend = plt.get_backend()
    plt.switch_backend("Agg")
    # Agg's `show` warns that there is nothing to show on.
    monkeypatch.setattr(plt, "show", lambda: None)
    yield
    plt.close("all")
    plt.switch_backend(backend)


@pytest.mark.tutorial
@pytest.mark.slow
@pytest.mark.render
@pytest.mark.parametrize("path", RUN, ids=lambda path: path.stem)
def test_the_tutorial_runs_from_top_to_bottom(path, no_window, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(path), run_name="__main__")
    assert list(tmp_path.iterdir()) == []
    assert names["__doc__"] is None  # prose is in cells


@pytest.mark.tutorial
@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_is_cells_of_prose_and_code(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "# %% [markdown]"
    assert lines[1].startswith("# # ")
    kinds = {line for line in lines if line.startswith("# %%")}
    assert kinds == {"# %%", "# %% [markdown]"}


def test_there_are_tutorials():
    assert TUTORIALS
