"""A chain as one vector of fixed length, for a Drake numeric parameter."""

import numpy as np

from bath_drake.composition.chain import Chain, Gate
from bath_drake.field.parameters import pack_field, parameter_size, unpack_field
from bath_drake.notation import FloatArray

_GATE = 5


def chain_parameter_size(max_stages: int, max_obstacles: int) -> int:
    """Length of the vector that holds up to ``max_stages`` fields.

    Raises:
        ValueError: There is no room for a field, or less than none for obstacles.
    """
    if max_stages < 1:
        raise ValueError(f"max_stages must be >= 1, got {max_stages}")
    return 1 + max_stages * (parameter_size(max_obstacles) + _GATE)


def pack_chain(chain: Chain, max_stages: int, max_obstacles: int) -> FloatArray:
    """Writes a chain into a vector of length 1 + max_stages (14 + 6 max_obstacles).

    In order: the number of stages; then for each stage its field, as
    `bath_drake.field.parameters.pack_field` writes it, and its gate (centre x, y,
    direction x, y, radius; zeros for the last stage's), zeros behind.

    Raises:
        ValueError: The chain has more stages than fit, or a field more obstacles.
    """
    vector = np.zeros(chain_parameter_size(max_stages, max_obstacles))
    if len(chain) > max_stages:
        raise ValueError(f"the chain has {len(chain)} stages, at most {max_stages} fit")
    vector[0] = len(chain)
    rows = vector[1:].reshape(max_stages, -1)
    for row, field in zip(rows, chain.fields, strict=False):
        row[:-_GATE] = pack_field(field, max_obstacles)
    for row, gate in zip(rows, chain.gates, strict=False):
        row[-_GATE:] = gate.as_array()
    return vector


def unpack_chain(vector: FloatArray, max_stages: int) -> Chain:
    """Reads back what `pack_chain` wrote, bit by bit.

    Raises:
        ValueError: The length or the number of stages cannot be, or a value is
            invalid.
    """
    vector = np.asarray(vector, dtype=np.float64)
    if vector.ndim != 1 or max_stages < 1 or (vector.size - 1) % max_stages:
        raise ValueError(
            f"length must be 1 + {max_stages} (14 + 6 n), got shape {vector.shape}"
        )
    count = float(vector[0])
    if not count.is_integer() or not 1 <= count <= max_stages:
        raise ValueError(
            f"the number of stages must be whole and in 1..{max_stages}, got {count}"
        )
    rows = vector[1:].reshape(max_stages, -1)[: int(count)]
    return Chain(
        tuple(unpack_field(row[:-_GATE]) for row in rows),
        tuple(Gate(row[-5:-3], row[-3:-1], row[-1]) for row in rows[:-1]),
    )
