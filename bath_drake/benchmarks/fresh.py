"""What must be measured in an interpreter of its own.

`python -m bath_drake.benchmarks.fresh TASK` is the other side: it does one task and
prints its seconds as JSON.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np

SEED = 2025


def first_calls(warm: int) -> list[dict[str, float]]:
    """A first call without compiled code on disk, then `warm` ones with it.

    Each is the first certificate, flow and roll-outs of a fresh interpreter: `numba`
    holds the seconds its import took, `call` those of the project's own imports and
    of the call, whatever it had to compile or load, and `cpu` what the processor
    spent on these.
    """
    with tempfile.TemporaryDirectory() as folder:
        return [
            _run("first-call", NUMBA_CACHE_DIR=folder, NUMBA_DISABLE_JIT="0")
            for _ in range(1 + warm)
        ]


def uncompiled_proof_seconds(worlds: int) -> list[float]:
    """Seconds that each of `proof_worlds` takes without a compiler: plain Python."""
    found = _run("uncompiled-proof", str(worlds), NUMBA_DISABLE_JIT="1")
    return [found[str(i)] for i in range(worlds)]


def proof_worlds(count: int) -> list[Any]:
    """Worlds of 12 disjoint ellipses, to prove on either side."""
    from bath_drake.benchmarks.random_worlds import disjoint_world

    rng = np.random.default_rng(SEED)
    return [disjoint_world(rng, 12, rng.uniform(2.0, 150.0)) for _ in range(count)]


def _run(*words: str, **environment: str) -> dict[str, float]:
    done = subprocess.run(
        [sys.executable, "-m", "bath_drake.benchmarks.fresh", *words],
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    found: dict[str, float] = json.loads(done.stdout)
    return found


def _first_call() -> dict[str, float]:
    begin = time.perf_counter()
    import numba  # noqa: F401 - its import is what is timed

    imported, work = time.perf_counter(), time.process_time()
    from bath_drake.benchmarks.random_worlds import RADIUS, disjoint_world
    from bath_drake.certificate.certify import certify
    from bath_drake.field.navigation import flow_direction
    from bath_drake.field.rollout import rollout, rollouts

    field = disjoint_world(np.random.default_rng(SEED), 12, 100.0)
    certify(field)
    q = np.array([[0.0, 0.9 * RADIUS], [0.0, -0.9 * RADIUS]])
    flow_direction(q, field)
    rollout(q[0], field)
    rollouts(q, field)
    return {
        "numba": imported - begin,
        "call": time.perf_counter() - imported,
        "cpu": time.process_time() - work,
    }


def _uncompiled_proof(worlds: int) -> dict[str, float]:
    from bath_drake.benchmarks.timing import seconds
    from bath_drake.certificate.certify import certify

    return {
        str(i): seconds(lambda field=field: certify(field))  # type: ignore[misc]
        for i, field in enumerate(proof_worlds(worlds))
    }


if __name__ == "__main__":
    task = sys.argv[1]
    found = (
        _first_call() if task == "first-call" else _uncompiled_proof(int(sys.argv[2]))
    )
    print(json.dumps(found))
