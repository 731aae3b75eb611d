"""What can be wrong with a user's input, as one family of exceptions.

Every message names the file, row or key, what was found and what is allowed;
the command line prints it on one line and exits with code 2.
"""


class BathDrakeError(ValueError):
    """Base of all errors a user can mend."""


class DemonstrationError(BathDrakeError):
    """A demonstration file cannot be used."""


class SkillFileError(BathDrakeError):
    """A skill file, or a field block in a YAML file, cannot be used."""


class ScenarioError(BathDrakeError):
    """A scenario file, or a person folder it names, cannot be used."""


class LimitsError(BathDrakeError):
    """A file of the guard's limits cannot be used."""


class RunFolderError(BathDrakeError):
    """A run folder lacks a file or holds a damaged one."""


class CheckpointError(BathDrakeError):
    """The checkpoint of a run cannot be used."""


class SegmenterError(BathDrakeError):
    """A segmenter's model cannot be used."""


def shown(text: str) -> str:
    """Returns what was found as a short piece of one line, for a message."""
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."
