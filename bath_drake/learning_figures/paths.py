"""What the pictures beside a skill are called."""

from pathlib import Path
from typing import Final

NAMES: Final = (
    "",
    "fields",
    "cycle",
    "population",
    "stages",
    "generalisation",
    "held_out",
)
"""Of all pictures; the first is the overview."""


def picture_path(skill: Path, name: str = "") -> Path:
    """SKILL.png, or SKILL_name.png, beside SKILL.yaml."""
    end = f"_{name}" if name else ""
    return skill.with_name(f"{skill.stem}{end}.png")
