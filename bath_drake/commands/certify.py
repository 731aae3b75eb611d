"""`bath-drake certify`: are fields and chains proved free of traps?"""

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bath_drake.commands._certification import Certification


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

    A skill's starts must lie in free space too. Where a skill is not proved as a
    whole, `from_start` says what is proved of its starts alone. Composed skills, and
    lists of fields, are proved as chains.
    """
    from tqdm import tqdm

    from bath_drake.commands._certification import certify_file
    from bath_drake.files import write_atomically
    from bath_drake.skill_file import certified, save_skill

    picture = _check_outputs(options)
    with tqdm(
        desc="certifying",
        total=1 if picture is None else 2,
        unit="step",
        leave=False,
        disable=not sys.stderr.isatty(),
    ) as bar:
        found = certify_file(options.file, options.renew)
        text = _strict_json(options.file, found.to_mapping())
        bar.update()
        if picture is not None:
            _write_picture(picture, found)
            bar.update()
    if options.renew:
        assert found.skill is not None  # certify_file refused what is none
        save_skill(options.file, certified(found.skill, *found.certificates))
    if options.output is None:
        print(text)
    else:
        write_atomically(options.output, text + "\n")
        print(found.summary)
    return 0 if found.passed else 1


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
    from bath_drake.files import check_output

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


def _write_picture(path: Path, found: "Certification") -> None:
    from bath_drake.errors import BathDrakeError
    from bath_drake.files import write_atomically
    from bath_drake.report import style
    from bath_drake.report.certificate_figure import draw_certificate
    from bath_drake.report.chain_certificate_figure import draw_chain_certificates

    def save(temporary: Path) -> None:
        figure.savefig(temporary, format="png", dpi=130, metadata={"Software": None})

    with style.figure_style():
        if found.is_single:
            stage, start = found.certificates[0].stages[0], [*found.starts, None][0]
            figure = draw_certificate(found.chains[0].fields[0], stage, start)
        else:
            figure = draw_chain_certificates(
                found.chains, found.certificates, found.starts
            )
        write_atomically(path, save, error=BathDrakeError)
