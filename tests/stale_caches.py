"""Drops compiled kernels that are older than a source they were made from.

numba's cache on disk notices changes of a kernel's own file only, not of the files
whose kernels it calls. A stale kernel must not decide a test.
"""

import ast
from functools import cache
from pathlib import Path

import bath_drake

PACKAGE = Path(bath_drake.__file__).parent


@cache
def _imported(path: Path) -> frozenset[Path]:
    """The package's own files that a file imports from, at first and second hand."""
    found: set[Path] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or node.module is None:
            continue
        for name in (node.module, *(f"{node.module}.{a.name}" for a in node.names)):
            parts = name.split(".")
            source = PACKAGE.joinpath(*parts[1:]).with_suffix(".py")
            if parts[0] == PACKAGE.name and source.is_file() and source != path:
                found |= {source} | _imported(source)
    return frozenset(found)


def drop_stale_caches() -> list[Path]:
    """Removes what is stale; returns the index files that were removed."""
    removed = []
    for index in PACKAGE.rglob("__pycache__/*.nbi"):
        source = index.parent.parent / f"{index.name.split('.')[0]}.py"
        if not source.is_file():
            continue
        newest = max(p.stat().st_mtime for p in (source, *_imported(source)))
        if newest > index.stat().st_mtime:
            index.unlink(missing_ok=True)
            removed.append(index)
    return removed
