"""The tables of docs/guard.md are those of the program."""

from pathlib import Path

from bath_drake.safety.reasons import RESPONSES, Mode, Reason

PAGE = (Path(__file__).parents[2] / "docs" / "guard.md").read_text(encoding="utf-8")


def rows():
    lines = PAGE.split("<!-- reasons:")[1].split("\n\n")[0].splitlines()
    return [[c.strip() for c in r.strip("|").split("|")] for r in lines[3:]]


def test_the_page_has_every_reason_with_its_mode_and_what_ends_it():
    expected = [
        [
            str(reason.value),
            f"`{reason.name}`",
            response.meaning,
            response.mode.name,
            "by itself" if response.resumes else "after a reset",
        ]
        for reason, response in RESPONSES.items()
        if reason is not Reason.NONE
    ]
    assert rows() == expected


def test_the_page_has_every_mode():
    for mode in Mode:
        assert f"\n| {mode.name} | " in PAGE


def test_the_page_says_what_it_is_not():
    assert "Research software, not certified." in PAGE
