"""What is installed, what is missing, and the line that mends it.

Runs with the standard library alone, also as a script before anything of the
project is installed (`make` does so).
"""

import ctypes
import importlib.metadata
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

OLDEST_PYTHON = (3, 11)

# Shared library -> Debian package. Drake's renderer and Open3D load them.
SYSTEM_LIBRARIES = {
    "libglib-2.0.so.0": "libglib2.0-0",
    "libX11.so.6": "libx11-6",
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libusb-1.0.so.0": "libusb-1.0-0",
    "libgomp.so.1": "libgomp1",
}
# Mesa's software rasteriser is opened by name at run time, not linked.
RASTERISERS = ("swrast_dri.so", "libgallium*.so", "kms_swrast_dri.so")
RASTERISER_PACKAGE = "libgl1-mesa-dri"

DISTRIBUTIONS = (
    "drake",
    "open3d-cpu",
    "numpy",
    "scipy",
    "numba",
    "opencv-python-headless",
    "matplotlib",
)


class Finding(NamedTuple):
    """One line of the doctor's report."""

    name: str
    found: str
    well: bool
    package: str = ""


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _has_rasteriser() -> bool:
    folders = [Path("/usr/lib"), Path("/usr/lib64"), Path("/usr/local/lib")]
    return any(
        next(folder.glob(f"{depth}{name}"), None) is not None
        for folder in folders
        if folder.is_dir()
        for depth in ("", "dri/", "*/", "*/dri/")
        for name in RASTERISERS
    )


def _has_venv() -> bool:
    try:
        import ensurepip  # noqa: F401 - Debian ships venv without it
    except ImportError:
        return False
    return True


def examine_system() -> list[Finding]:
    """Examines the interpreter and the system libraries."""
    version = ".".join(map(str, sys.version_info[:3]))
    oldest = ".".join(map(str, OLDEST_PYTHON))
    findings = [
        Finding(f"python >= {oldest}", version, sys.version_info >= OLDEST_PYTHON)
    ]
    for library, package in SYSTEM_LIBRARIES.items():
        well = _loads(library)
        findings.append(Finding(library, "found" if well else "missing", well, package))
    well = _has_rasteriser()
    findings.append(
        Finding(
            "software rasteriser",
            "found" if well else "missing",
            well,
            RASTERISER_PACKAGE,
        )
    )
    return findings


def examine_packages() -> list[Finding]:
    """Examines the Python packages, by their installed versions."""
    findings = []
    for name in DISTRIBUTIONS:
        try:
            findings.append(Finding(name, importlib.metadata.version(name), True))
        except importlib.metadata.PackageNotFoundError:
            findings.append(Finding(name, "missing", False))
    return findings


def fixing_line(findings: Sequence[Finding]) -> str:
    """Returns the one shell line that installs what is missing, or ''."""
    packages = sorted({f.package for f in findings if not f.well and f.package})
    if not packages:
        return ""
    sudo = "" if os.geteuid() == 0 else "sudo "
    return f"{sudo}apt-get update && {sudo}apt-get install -y {' '.join(packages)}"


def print_findings(findings: Sequence[Finding]) -> None:
    """Prints one line a finding."""
    for finding in findings:
        mark = "ok     " if finding.well else "MISSING"
        print(f"{mark} {finding.name:26s} {finding.found}")


def run_doctor() -> int:
    """Prints all findings; returns 0 if all is well, 1 if not."""
    findings = examine_system() + examine_packages()
    print_findings(findings)
    line = fixing_line(findings)
    if line:
        print(f"\nto mend the system:   {line}")
    if any(not f.well and not f.package for f in findings):
        print("\nto mend the packages: make setup")
    return 0 if all(f.well for f in findings) else 1


def prepare_machine() -> int:
    """Installs missing system libraries as root; otherwise says how.

    Returns 0 when nothing is missing any more, else 2.
    """
    findings = examine_system()
    if not _has_venv():
        package = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
        findings.append(Finding("venv", "missing", False, package))
    if all(f.well for f in findings):
        return 0
    missing = [f for f in findings if not f.well]
    print_findings(missing)
    line = fixing_line(missing)
    if any(not f.package for f in missing):
        print("set PYTHON=/path/to/python3.11 (or newer) for make", file=sys.stderr)
        return 2
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        print(f"system libraries are missing; run: {line}", file=sys.stderr)
        return 2
    print(f"installing: {line}")
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    done = subprocess.run(["sh", "-c", line], env=environment, check=False)
    return 0 if done.returncode == 0 else 2


if __name__ == "__main__":
    sys.exit(prepare_machine() if "--before-installation" in sys.argv else run_doctor())
