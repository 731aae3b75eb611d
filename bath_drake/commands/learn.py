"""`bath-drake learn`: a skill from demonstration files."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bath_drake.demonstrations.canonical import (
        CanonicalDemonstration,
        CanonicalFrame,
    )
    from bath_drake.field.navigation import NavigationField
    from bath_drake.learning.config import LearnerConfig
    from bath_drake.learning.learner import LearningResult


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the demonstrations, the output and the learner's choices."""
    parser.add_argument("files", nargs="+", metavar="FILE", help="demonstrations (CSV)")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="SKILL.yaml",
        help="the skill; its learning curve goes beside it as SKILL.png",
    )
    parser.add_argument("--method", choices=["auto", "paper"], default="auto")
    parser.add_argument(
        "--obstacles", default="auto", metavar="N", help="how many, or auto"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument(
        "--resume", action="store_true", help="continue from the SKILL.yaml at -o"
    )
    parser.add_argument(
        "--quick", action="store_true", help="a few seconds' effort, a worse fit"
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if learning converged, 1 if not; the skill is written either way."""
    import sys
    from dataclasses import replace

    from tqdm import tqdm

    from bath_drake.demonstrations.processing import canonical_demonstrations
    from bath_drake.demonstrations.recording import read_recording
    from bath_drake.learning.learner import learn_skill
    from bath_drake.learning_report import write_learning_figure
    from bath_drake.skill_file import save_skill, skill_from_result

    _check_outputs(options.output, options.files)
    config = _config(options)
    recordings = [read_recording(path) for path in options.files]
    demonstrations, frame = canonical_demonstrations(recordings)
    initial = None
    if options.resume:
        initial = _field_to_continue(options.output, demonstrations, frame, config)
    # The learner's messages are to name the files.
    strokes = [
        replace(demonstration, name=str(recording.path))
        for demonstration, recording in zip(demonstrations, recordings, strict=True)
    ]
    with tqdm(desc="learning", unit="step", disable=not sys.stderr.isatty()) as bar:

        def progress(done: int, total: int, cost: float) -> None:
            bar.total = total
            bar.n = done
            bar.set_postfix(C=f"{cost:.4f}")

        result = learn_skill(strokes, config, progress, initial)
    save_skill(options.output, skill_from_result(result, demonstrations, frame))
    picture = options.output.with_suffix(".png")
    write_learning_figure(picture, result, demonstrations)
    print("\n".join(_table(result, demonstrations)))
    print(f"skill            {options.output}\nlearning curve   {picture}")
    return 0 if result.converged else 1


def _field_to_continue(
    path: Path,
    demonstrations: Sequence["CanonicalDemonstration"],
    frame: "CanonicalFrame",
    config: "LearnerConfig",
) -> "NavigationField":
    """The field of the skill at ``path``, if it was learned from the same data."""
    from bath_drake.errors import SkillFileError
    from bath_drake.skill_file import load_skill

    skill = load_skill(path)
    found = sorted(skill.demonstration_hashes)
    given = sorted(demonstration.sha256 for demonstration in demonstrations)
    if found != given:
        common = len(set(found) & set(given))
        raise SkillFileError(
            f"{path}: demonstration_hashes: found {len(found)} of which {common} are "
            f"of the {len(given)} files given, --resume needs the same demonstrations"
        )
    if skill.canonical != frame:
        raise SkillFileError(
            f"{path}: canonical: found another map to canonical space than that of "
            "the files given (a body box was changed, or the files' order), "
            "--resume needs the same"
        )
    count = len(skill.field.obstacles)
    if config.obstacles is not None and config.obstacles < count:
        raise SkillFileError(
            f"{path}: field.obstacles: found {count}, --resume with "
            f"--obstacles {config.obstacles} allows at most that many"
        )
    if (skill.field.obstacles.powers != 1.0).any():
        raise SkillFileError(
            f"{path}: field.obstacles: found exponents other than 1, "
            "the learner continues only from fields where all are 1"
        )
    return skill.field


def _check_outputs(output: Path, files: Sequence[str]) -> None:
    """Refuses an output that cannot be written or would spoil an input."""
    from bath_drake.errors import BathDrakeError
    from bath_drake.yaml_io import check_output

    if output.suffix not in (".yaml", ".yml"):
        raise BathDrakeError(f"-o: found {str(output)!r}, expected a name ending .yaml")
    for path in (output, output.with_suffix(".png")):
        check_output(path)
    for file in files:
        if output.resolve() == Path(file).with_suffix(".yaml").resolve():
            raise BathDrakeError(
                f"-o: {output} is where {file} keeps its frame and body box, "
                "expected another name"
            )


def _config(options: argparse.Namespace) -> "LearnerConfig":
    from dataclasses import replace

    from bath_drake.errors import BathDrakeError
    from bath_drake.learning.config import LearnerConfig

    if options.seed < 0:
        raise BathDrakeError(f"--seed: found {options.seed}, allowed: 0 or more")
    obstacles: int | None = None
    if options.obstacles != "auto":
        try:
            obstacles = int(options.obstacles)
        except ValueError:
            raise BathDrakeError(
                f"--obstacles: found {options.obstacles!r}, allowed: a number or auto"
            ) from None
    make = LearnerConfig.quick if options.quick else LearnerConfig
    try:
        return replace(
            make(seed=options.seed, method=options.method), obstacles=obstacles
        )
    except ValueError as problem:
        raise BathDrakeError(f"--obstacles: {problem}") from None


def _table(
    result: "LearningResult", demonstrations: Sequence["CanonicalDemonstration"]
) -> list[str]:
    from bath_drake.learning.learner import CONVERGED_FRECHET

    figures = result.frechet
    lines = [
        f"converged        {'yes' if result.converged else 'NO'}",
        f"Frechet to mean  {figures['to_mean']:.4f} (at most {CONVERGED_FRECHET})",
        f"C                {figures['cost']:.4f} (spread of the demonstrations "
        f"{figures['floor']:.4f})",
        f"obstacles        {len(result.field.obstacles)}",
        f"verdict          {result.certificate.verdict}: {result.certificate.reason}",
        f"seconds          {result.seconds:.1f}",
    ]
    for demonstration, distance in zip(
        demonstrations, result.per_demonstration, strict=True
    ):
        x, y = demonstration.goal_offset
        lines.append(
            f"  {demonstration.name}: Frechet {distance:.4f}, "
            f"goal moved by ({-x:+.4f}, {-y:+.4f})"
        )
    return lines
