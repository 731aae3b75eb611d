"""Typed access to ports.

Drake lets any Python object through a ``Value[object]`` port and its stubs
type ``Eval`` as object; these helpers check, and name the port in the error.
"""

from typing import Any, TypeVar

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort

from bath_drake.notation import FloatArray

T = TypeVar("T")


def _eval(port: InputPort, context: Context) -> Any:
    # Asking first whether there is a value would evaluate it twice.
    try:
        return port.Eval(context)
    except RuntimeError as error:
        if port.HasValue(context):
            raise
        raise RuntimeError(f"{_describe(port)} is not connected") from error


def _describe(port: InputPort) -> str:
    system: Any = port.get_system()
    return f"input port '{port.get_name()}' of {system.get_name()}"


def eval_vector(port: InputPort, context: Context) -> FloatArray:
    """Returns the port's vector value, shape (size,)."""
    return np.asarray(_eval(port, context), dtype=np.float64)


def eval_value(port: InputPort, context: Context, kind: type[T]) -> T:
    """Returns the port's abstract value; TypeError unless it is a `kind`."""
    value = _eval(port, context)
    if not isinstance(value, kind):
        raise TypeError(
            f"{_describe(port)} takes {kind.__name__}, got {type(value).__name__}"
        )
    return value


def eval_scalar(port: InputPort, context: Context) -> float:
    """Returns the value of a port of size one."""
    return float(_eval(port, context)[0])


def drake_vector(value: Any) -> Any:
    """Returns `value` as the float array Drake takes.

    Its stubs spell array shapes in a way no checker matches, hence Any.
    """
    return np.asarray(value, dtype=np.float64)


def set_vector(output: BasicVector, value: Any) -> None:
    """Writes `value`, shape (size,), into `output`; a wrong size raises."""
    output.SetFromVector(drake_vector(value))
