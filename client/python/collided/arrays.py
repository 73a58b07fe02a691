"""How numbers reach the library: numpy arrays as they lie in memory, or an error that says what to do; never a copy that
nobody asked for. Quaternions name their order."""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ._native import ffi

Floats: TypeAlias = npt.NDArray[np.float64]
Vector: TypeAlias = Sequence[float] | Floats
"""A few numbers, as a tuple, a list or an array: these are copied."""


def doubles(name: str, array: Floats, rows: int, columns: int) -> Any:
    """A pointer to the numbers of an array of so many rows and columns, without a copy."""
    if not isinstance(array, np.ndarray) or array.dtype != np.float64 or not array.flags.c_contiguous:
        is_a = f"{array.dtype} array" if isinstance(array, np.ndarray) else type(array).__name__
        if isinstance(array, np.ndarray) and array.dtype == np.float64:
            is_a += " that is not C-contiguous"
        raise TypeError(f"{name} is a {is_a}: a C-contiguous float64 array is needed, since nothing is copied here. Make it "
                        f"once, and write into it, or say np.ascontiguousarray({name}, dtype=np.float64)")
    if array.shape != (rows, columns):
        raise ValueError(f"{name} has the shape {array.shape}: ({rows}, {columns}) is needed")
    return ffi.from_buffer("double[]", array)


def one_order(wxyz: Any, xyzw: Any) -> None:
    """Exactly one of the two keywords is given."""
    if (wxyz is None) == (xyzw is None):
        raise TypeError("give the orientation as either wxyz= or xyzw=: the keyword says in which order its numbers are")


def vector(name: str, numbers: Vector, count: int) -> list[float]:
    """So many numbers."""
    values = [float(number) for number in numbers]
    if len(values) != count:
        raise ValueError(f"{name} has {len(values)} numbers: {count} are needed")
    return values


def quaternion(wxyz: Vector | None, xyzw: Vector | None) -> list[float]:
    """As (w, x, y, z), which is the identity if neither is given."""
    if wxyz is None and xyzw is None:
        return [1.0, 0.0, 0.0, 0.0]
    one_order(wxyz, xyzw)
    if wxyz is not None:
        return vector("wxyz", wxyz, 4)
    assert xyzw is not None
    x, y, z, w = vector("xyzw", xyzw, 4)
    return [w, x, y, z]
