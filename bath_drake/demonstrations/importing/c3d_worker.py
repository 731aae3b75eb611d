"""Reads one C3D file in a process of its own: `python -m ...c3d_worker FILE`.

The library is C++ that believes what a file says: a damaged one can crash it or make it
ask for any memory. Here that ends this process alone. What was read goes to standard
output as an .npz of points (3, markers, frames), labels, unit, rate and first frame.
"""

import io
import os
import resource
import sys
from typing import Any

import ezc3d
import numpy as np

# Address space, bytes, and time, s.
MEMORY, SECONDS = 4 * 1024**3, 60


def main(path: str) -> int:
    """Returns 0, or 1 with the reason on standard error."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # The library prints warnings where the archive is to go.
    out = os.dup(1)
    os.dup2(2, 1)
    try:
        content = ezc3d.c3d(path)
        group = content["parameters"]["POINT"]
        unit = group["UNITS"]["value"] if "UNITS" in group else []
        header = content["header"]["points"]
        archive = io.BytesIO()
        np.savez(
            archive,
            points=np.asarray(content["data"]["points"], dtype=np.float64)[:3],
            labels=np.array(_labels(group), dtype=str),
            unit=np.array(str(unit[0]) if len(unit) else "mm"),
            rate=np.array(float(header["frame_rate"])),
            first=np.array(int(header["first_frame"])),
        )
    # Whatever it is, the file made the library raise it.
    except Exception as problem:
        reason = str(problem).splitlines()
        print(reason[0] if reason else type(problem).__name__, file=sys.stderr)
        return 1
    with os.fdopen(out, "wb") as stream:
        stream.write(archive.getvalue())
    return 0


def _labels(group: Any) -> list[str]:
    """Names of the markers: 255 in LABELS, the next ones in LABELS2 and so on."""
    names = [str(name) for name in group["LABELS"]["value"]]
    while (more := f"LABELS{len(names) // 255 + 1}") in group:
        if not len(group[more]["value"]):
            break
        names += [str(name) for name in group[more]["value"]]
        if len(names) % 255:
            break
    return names


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
