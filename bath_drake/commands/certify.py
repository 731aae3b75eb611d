"""`bath-drake certify`: is a field proved free of traps?"""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bath_drake.certificate.result import Certificate
    from bath_drake.field.navigation import NavigationField
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
    from bath_drake.certificate.certify import certify
    from bath_drake.certificate_file import certificate_to_mapping
    from bath_drake.errors import SkillFileError
    from bath_drake.skill_file import (
        certified,
        field_to_mapping,
        is_skill_file,
        load_field,
        load_skill,
        save_skill,
    )
    from bath_drake.yaml_io import write_atomically

    picture = _check_outputs(options)
    start = None
    if is_skill_file(options.file):
        skill = load_skill(options.file, renew=options.renew)
        field, start = skill.field, skill.start
        certificate, data = _certify_skill(field, start)
    elif options.renew:
        raise SkillFileError(f"{options.file}: --renew is for skills, this is none")
    else:
        field = load_field(options.file)
        certificate = certify(field)
        data = certificate_to_mapping(certificate, field_to_mapping(field))
    data["seconds"] = certificate.seconds
    try:
        text = json.dumps(data, indent=2, allow_nan=False)
    except ValueError:
        # Strict JSON has no NaN; only numbers at the edge of float64 lead there.
        raise SkillFileError(
            f"{options.file}: field: its numbers are too large or small to certify"
        ) from None
    if picture is not None:
        _write_picture(picture, field, certificate, start)
    if options.renew:
        save_skill(options.file, certified(skill, certificate))
    if options.output is None:
        print(text)
    else:
        write_atomically(options.output, text + "\n")
        print(f"{certificate.verdict}: {certificate.reason}")
    return 0 if certificate.passed else 1


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
