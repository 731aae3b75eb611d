"""What figures depend on: the machine, how busy it is, and versions."""

import importlib.metadata
import os
import platform
from pathlib import Path
from typing import Any

from bath_drake import __version__
from bath_drake.doctor import DISTRIBUTIONS


def machine() -> dict[str, Any]:
    """The processor, the cores this process may use, the platform, and the load.

    The load is the average number of busy cores over the last minute, this process's
    own among them.
    """
    return {
        "cpu": _cpu(Path("/proc/cpuinfo")) or platform.processor() or "unknown",
        "cores": len(os.sched_getaffinity(0)),
        "platform": platform.platform(),
        "load": os.getloadavg()[0],
    }


def versions() -> dict[str, str]:
    """Versions of the project, of Python and of the packages a figure depends on."""
    found = {"bath_drake": __version__, "python": platform.python_version()}
    for name in DISTRIBUTIONS:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "missing"
    return found


def _cpu(path: Path) -> str:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError:
        return ""
    names = (line.partition(":") for line in lines)
    return next((v.strip() for k, _, v in names if k.strip() == "model name"), "")
