"""`bath-drake learn`: a skill from demonstration files."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bath_drake.demonstrations.canonical import CanonicalFrame
    from bath_drake.learning.config import LearnerConfig


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the demonstrations, the output and the learner's choices."""
    parser.add_argument("files", nargs="+", metavar="FILE", help="demonstrations (CSV)")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="SKILL.yaml",
        help="the skill; pictures go beside it as SKILL.png (what was learned, and "
        "the learning curve) and SKILL_NAME.png (fields, population or stages, "
        "cycle, generalisation, held_out)",
    )
    parser.add_argument("--method", choices=["auto", "paper"], default="auto")
    parser.add_argument(
        "--obstacles", default="auto", metavar="N", help="how many, or auto"
    )
    parser.add_argument(
        "--fields",
        choices=["auto", "one", "many"],
        default="auto",
        help="one field, a chain of many, or the better (auto)",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument(
        "--resume",
        action="store_true",
        help="continue a run that was stopped or killed, from SKILL.checkpoint",
    )
    parser.add_argument(
        "--held-out",
        action="store_true",
        help="then learn as often as there are demonstrations, each time without one, "
        "and say how well that one is foreseen",
    )
    parser.add_argument(
        "--pictures",
        choices=["all", "one"],
        default="all",
        help="all of them, or SKILL.png alone, which saves some seconds",
    )
    parser.add_argument(
        "--quick", action="store_true", help="a few seconds' effort, a worse fit"
    )


def run(options: argparse.Namespace) -> int:
    """Returns 0 if learning converged, 1 if not; the skill is written either way."""
    import os
    import sys
    from dataclasses import asdict, replace

    from bath_drake import __version__
    from bath_drake.commands._learning_lines import (
        held_out_lines,
        periodic_lines,
        result_lines,
        ring_lines,
    )
    from bath_drake.commands._progress import progress_bar
    from bath_drake.commands._signals import stopping
    from bath_drake.demonstrations.processing import (
        canonical_demonstrations,
        without_strays,
    )
    from bath_drake.demonstrations.recording import read_recording
    from bath_drake.errors import BathDrakeError
    from bath_drake.learning.checkpoint import Checkpoint
    from bath_drake.learning.generalisation import evaluate_generalisation
    from bath_drake.learning.held_out import leave_one_out
    from bath_drake.learning.learner import learn_skill
    from bath_drake.learning.periodic import learn_cycle
    from bath_drake.learning_figures.write import write_learning_figures
    from bath_drake.skill_file import save_skill, skill_from_result

    _check_outputs(options.output, options.files)
    config = _config(options)
    recordings = [read_recording(path) for path in options.files]
    found, frame = canonical_demonstrations(recordings)
    demonstrations = without_strays(found)
    hashes = [demonstration.sha256 for demonstration in demonstrations]
    identity = _identity(asdict(config), hashes, frame)
    kept = checkpoint_path(options.output)
    if options.held_out and len(demonstrations) < 2:
        raise BathDrakeError(
            "--held-out: found one demonstration, to hold one out needs two or more"
        )
    if (
        options.resume
        and not options.held_out
        and not kept.exists()
        and options.output.exists()
    ):
        code = _finished_before(options.output, identity)
        if code is not None:
            print(f"{options.output}: learned to its end already, nothing to resume")
            return code
    # The learner's messages are to name the files.
    strokes = [
        replace(demonstration, name=str(recording.path))
        for demonstration, recording in zip(found, recordings, strict=True)
        if not demonstration.stray
    ]
    with (
        Checkpoint(
            kept, {"version": __version__, **identity}, resume=options.resume
        ) as checkpoint,
        progress_bar(desc="learning", unit="step") as bar,
    ):

        def progress(done: int, total: int, cost: float) -> None:
            bar.total = total
            if cost < float("inf"):
                bar.set_postfix(C=f"{cost:.4f}", refresh=False)
            bar.update(done - bar.n)

        def stop() -> None:
            checkpoint.stop()
            if sys.stderr.isatty():  # unbuffered: the handler may interrupt a print
                os.write(2, b"\nstopping after this step; Ctrl-C again ends at once\n")

        with stopping(stop):
            result = learn_skill(strokes, config, progress, checkpoint)
        bar.close()
        periodic = learn_cycle(demonstrations)
        skill = skill_from_result(result, demonstrations, frame, periodic.cycle)
        save_skill(options.output, skill)
        held_out = None
        if options.held_out and result.finished:
            with (
                stopping(stop),
                progress_bar(desc="holding out", unit="%", total=100) as bar,
            ):

                def advance(share: float) -> None:
                    bar.update(round(100 * share) - bar.n)

                held_out = leave_one_out(demonstrations, result, advance, checkpoint)
        points = [demonstration.points for demonstration in demonstrations]
        generalised = evaluate_generalisation(result.branches, points)
        pictures = write_learning_figures(
            options.output,
            result,
            points,
            generalised,
            held_out,
            rhythm=(periodic.cycle, demonstrations) if periodic.cycle else None,
            overview_only=options.pictures == "one",
        )
        finished = result.finished and (held_out is None or held_out.finished)
        if finished:
            checkpoint.remove()
    lines = result_lines(result, demonstrations)
    lines += [f"  {d.name}: LEFT OUT, {d.stray}" for d in found if d.stray]
    lines += [*periodic_lines(periodic), *ring_lines(generalised)]
    if held_out is not None:
        lines += held_out_lines(held_out)
    print("\n".join(lines))
    print(f"skill            {options.output}")
    print("pictures         " + "\n                 ".join(map(str, pictures)))
    if result.finished and not finished:
        print(
            f"bath-drake learn: stopped; {options.output} is finished, holding out is "
            "not; the same command with --resume goes on",
            file=sys.stderr,
        )
    if not result.finished:
        print(
            f"bath-drake learn: stopped; {options.output} is unfinished, the best so "
            "far; the same command with --resume goes on",
            file=sys.stderr,
        )
    return 0 if result.converged and finished else 1


def checkpoint_path(output: Path) -> Path:
    """Where the run that learns the skill ``output`` keeps what it has computed."""
    return output.with_suffix(".checkpoint")


def _identity(
    config: dict[str, Any], hashes: Sequence[str], frame: "CanonicalFrame"
) -> dict[str, Any]:
    """What a learned skill depends on, as plain values."""
    return {
        "demonstration_hashes": list(hashes),
        "canonical": {
            "kind": frame.kind,
            "origin": frame.origin.tolist(),
            "axes": frame.axes.tolist(),
            "scales": frame.scales.tolist(),
        },
        "config": config,
    }


def _finished_before(path: Path, identity: dict[str, Any]) -> int | None:
    """The exit code of the skill at ``path``; None if it is unfinished itself.

    Raises:
        SkillFileError: The skill is not what this command would learn.
    """
    from bath_drake.errors import SkillFileError
    from bath_drake.learning.checkpoint import difference
    from bath_drake.learning.learner import CONVERGED_FRECHET
    from bath_drake.skill_file import load_skill

    skill = load_skill(path)
    if not skill.finished:
        return None
    found = _identity(skill.config, skill.demonstration_hashes, skill.canonical)
    differs = difference(found, identity)
    if differs is not None:
        raise SkillFileError(
            f"{path}: {differs}, and there is no checkpoint to resume; "
            "leave out --resume to replace the skill"
        )
    proved = skill.certificate["verdict"] == "proved"
    return 0 if proved and skill.frechet["to_mean"] <= CONVERGED_FRECHET else 1


def _check_outputs(output: Path, files: Sequence[str]) -> None:
    """Refuses an output that cannot be written or would spoil an input."""
    from bath_drake.errors import BathDrakeError
    from bath_drake.files import check_output
    from bath_drake.learning_figures.paths import NAMES, picture_path

    if output.suffix not in (".yaml", ".yml"):
        raise BathDrakeError(f"-o: found {str(output)!r}, expected a name ending .yaml")
    pictures = [picture_path(output, name) for name in NAMES]
    for path in (output, *pictures, checkpoint_path(output)):
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
            make(seed=options.seed, method=options.method),
            obstacles=obstacles,
            fields=options.fields,
        )
    except ValueError as problem:
        raise BathDrakeError(f"--{problem}") from None
