"""`bath-drake certify`: is a field proved free of traps?"""

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bath_drake.certificate.result import Certificate
    from bath_drake.field.navigation import NavigationField
    from bath_drake.learning.skill import Skill
    from bath_drake.notation import FloatArray


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the file and where certificate and picture go."""
    parser.add_argument(
        "file", metavar="FILE.yaml", help="a skill, or any YAML with a field block"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="CERT.json",
        help="write the certificate here instead of printing it, and CERT.png beside",
    )
    parser.add_argument(
        "--picture", type=Path, metavar="CERT.png", help="write the picture here"
    )
    parser.add_argument(
        "--renew",
        action="store_true",
        help="write the skill anew with this certificate; takes skills of version 1",
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if all free space is proved free of traps, 1 otherwise.

    A skill's start must lie in free space too. Where a skill's field is not proved as a
    whole, `from_start` says what is proved of its start alone.
    """
    from tqdm import tqdm

    from bath_drake.skill_file import certified, save_skill
    from bath_drake.yaml_io import write_atomically

    picture = _check_outputs(options)
    with tqdm(
        desc="certifying",
        total=1 if picture is None else 2,
        unit="step",
        leave=False,
        disable=not sys.stderr.isatty(),
    ) as bar:
        skill, field, certificate, data = _certify(options.file, options.renew)
        text = _strict_json(options.file, data)
        bar.update()
        if picture is not None:
            start = None if skill is None else skill.start
            _write_picture(picture, field, certificate, start)
            bar.update()
    if options.renew:
        assert skill is not None  # _certify refused what is none
        save_skill(options.file, certified(skill, certificate))
    if options.output is None:
        print(text)
    else:
        write_atomically(options.output, text + "\n")
        print(f"{certificate.verdict}: {certificate.reason}")
    return 0 if certificate.passed else 1


def _certify(
    path: str, renew: bool
) -> tuple["Skill | None", "NavigationField", "Certificate", dict[str, Any]]:
    """The file's skill, if it is one, its field, the certificate, and all to print."""
    from bath_drake.certificate.certify import certify
    from bath_drake.certificate_file import certificate_to_mapping
    from bath_drake.errors import SkillFileError
    from bath_drake.skill_file import (
        field_to_mapping,
        is_skill_file,
        load_field,
        load_skill,
    )

    if is_skill_file(path):
        skill = load_skill(path, renew=renew)
        certificate, data = _certify_skill(skill.field, skill.start)
        field = skill.field
    elif renew:
        raise SkillFileError(f"{path}: --renew is for skills, this is none")
    else:
        skill, field = None, load_field(path)
        certificate = certify(field)
        data = certificate_to_mapping(certificate, field_to_mapping(field))
    return skill, field, certificate, data | {"seconds": certificate.seconds}


def _strict_json(path: str, data: dict[str, Any]) -> str:
    from bath_drake.errors import SkillFileError

    try:
        return json.dumps(data, indent=2, allow_nan=False)
    except ValueError:
        # Strict JSON has no NaN; only numbers at the edge of float64 lead there.
        raise SkillFileError(
            f"{path}: field: its numbers are too large or small to certify"
        ) from None


def _check_outputs(options: argparse.Namespace) -> Path | None:
    """Refuses what cannot be written; returns where the picture goes, if anywhere."""
    from bath_drake.errors import BathDrakeError
    from bath_drake.yaml_io import check_output

    picture: Path | None = options.picture
    if options.output is not None:
        check_output(options.output)
        if picture is None:
            picture = options.output.with_suffix(".png")
            if picture == options.output:
                raise BathDrakeError(
                    f"-o: found {str(picture)!r}, the picture's name, expected a name "
                    "ending .json"
                )
    if picture is not None:
        check_output(picture)
    return picture


def _certify_skill(
    field: "NavigationField", start: "FloatArray"
) -> tuple["Certificate", dict[str, Any]]:
    """The whole field's certificate, unless the start is not free; and its mapping."""
    from bath_drake.certificate.certify import certify, certify_from
    from bath_drake.certificate_file import certificate_to_mapping
    from bath_drake.skill_file import field_to_mapping

    own = certify_from(field, start)
    # Without a region it is of the whole field, or says that the start is not free.
    certificate = own if own.region is None else certify(field)
    data = certificate_to_mapping(certificate, field_to_mapping(field))
    if own.region is not None:
        data["from_start"] = certificate_to_mapping(own, field_to_mapping(field))
    return certificate, data


def _write_picture(
    path: Path,
    field: "NavigationField",
    certificate: "Certificate",
    start: "FloatArray | None",
) -> None:
    from bath_drake.errors import BathDrakeError
    from bath_drake.report import style
    from bath_drake.report.certificate_figure import draw_certificate
    from bath_drake.yaml_io import write_atomically

    def save(temporary: Path) -> None:
        figure.savefig(temporary, format="png", dpi=130, metadata={"Software": None})

    with style.figure_style():
        figure = draw_certificate(field, certificate, start)
        write_atomically(path, save, error=BathDrakeError)
