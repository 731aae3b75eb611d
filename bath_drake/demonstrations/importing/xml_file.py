"""XML from outside: no entities, no huge files, numbers that are numbers."""

from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError

import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from bath_drake.errors import DemonstrationError
from bath_drake.files import read_bytes
from bath_drake.notation import FloatArray

MAX_BYTES = 128 * 1024 * 1024
# A tag takes far more memory than its bytes. Five minutes of 100 Hz have a million.
MAX_TAGS = 4_000_000


def read_xml(path: Path) -> Any:
    """The root element of a file.

    Raises:
        DemonstrationError: It cannot be read, is too large, is no XML, or declares
            entities or a document type.
    """
    data = read_bytes(path, limit=MAX_BYTES, error=DemonstrationError)
    if (tags := data.count(b"<")) > MAX_TAGS:
        raise DemonstrationError(f"{path}: has {tags} tags, allowed: {MAX_TAGS}")
    try:
        return fromstring(data, forbid_dtd=True)
    except DefusedXmlException as problem:
        raise DemonstrationError(
            f"{path}: declares entities or a document type, which are not allowed "
            f"({type(problem).__name__})"
        ) from None
    except (ParseError, ValueError, LookupError) as problem:
        raise DemonstrationError(f"{path}: not XML ({problem})") from None


def text_of(path: Path, parent: Any, tag: str) -> Any:
    """The child of this tag; raises DemonstrationError if there is none."""
    child = parent.find(tag)
    if child is None:
        raise DemonstrationError(f"{path}: {parent.tag}: has no {tag}")
    return child


def numbers(path: Path, element: Any, count: int) -> FloatArray:
    """The numbers in an element's text, (count,), all finite.

    Raises:
        DemonstrationError: There are others, or another number of them.
    """
    words = (element.text or "").split()
    if len(words) != count:
        raise DemonstrationError(
            f"{path}: {element.tag}: found {len(words)} numbers, expected {count}"
        )
    try:
        found = np.array([float(word) for word in words], dtype=np.float64)
    except ValueError:
        raise DemonstrationError(
            f"{path}: {element.tag}: found {element.text[:40]!r}, expected numbers"
        ) from None
    if not np.isfinite(found).all():
        raise DemonstrationError(
            f"{path}: {element.tag}: found {element.text[:40]!r}, expected finite "
            "numbers"
        )
    return found


def attribute(path: Path, element: Any, name: str, default: float) -> float:
    """A finite number of an element's attribute; raises DemonstrationError."""
    told = element.get(name)
    if told is None:
        return default
    try:
        value = float(told)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise DemonstrationError(
            f"{path}: {element.tag}: found {name} {told[:40]!r}, expected a number"
        )
    return value
