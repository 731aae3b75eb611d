"""`bath-drake certify`: is a field free of traps?"""

import argparse
import json
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the file and where the verdict goes."""
    parser.add_argument(
        "file", metavar="FILE.yaml", help="a skill, or any YAML with a field block"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="CERT.json",
        help="write the verdict here instead of printing it",
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 for 'numeric-pass', 1 otherwise.

    A skill's start must lie in free space too. The check is a numerical search: it
    can refute a field but not prove it, hence the verdict's name.
    """
    from bath_drake.errors import SkillFileError
    from bath_drake.field.critical_points import check_field
    from bath_drake.skill_file import (
        check_to_mapping,
        is_skill_file,
        load_field,
        load_skill,
    )
    from bath_drake.yaml_io import check_output, write_atomically

    if options.output is not None:
        check_output(options.output)
    if is_skill_file(options.file):
        skill = load_skill(options.file)
        check = check_field(skill.field, skill.start)
    else:
        check = check_field(load_field(options.file))
    data = check_to_mapping(check) | {"seconds": check.seconds}
    try:
        text = json.dumps(data, indent=2, allow_nan=False)
    except ValueError:
        # Strict JSON has no NaN; only numbers at the edge of float64 lead there.
        raise SkillFileError(
            f"{options.file}: field: its numbers are too large or small to check"
        ) from None
    if options.output is None:
        print(text)
    else:
        write_atomically(options.output, text + "\n")
        print(f"{check.verdict}: {check.reason}")
    return 0 if check.passed else 1
