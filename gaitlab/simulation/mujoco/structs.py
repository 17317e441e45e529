"""MuJoCo's C functions and what lies in its structs, for compiled code.

Constraint rows are made by `mj_makeConstraint`, given their physics by us and solved by
`mj_fwdConstraint`, every tick. Nothing public does that without Python in between: a control
callback of `mj_step` comes at the right moment but is handed the same raw structs. The stages
called from Python with the barest change of rows, without servos, ground, record and fall rule,
take five sixths of the time of the whole tick that is compiled here. So functions are called by
address, and rows and contacts, which lie elsewhere after every tick, are found through the pointers
in `mjData`.

The layout is that of `mujoco.introspect`, which is generated from the headers, and every number of
it that is used here is compared with the public arrays before anything is simulated.
"""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from llvmlite import ir
from mujoco.introspect import ast_nodes
from mujoco.introspect.structs import STRUCTS
from numba import carray, types
from numba.extending import intrinsic

from gaitlab.errors import NoEngine
from gaitlab.kinematics.compiled import njit

VERSION = "4.0"

STAGES = (
    *("mj_kinematics", "mj_comPos", "mj_comVel", "mj_makeM", "mj_factorM", "mj_collision"),
    *("mj_makeConstraint", "mj_passive", "mj_referenceConstraint", "mj_fwdAcceleration"),
    *("mj_fwdConstraint", "mj_Euler"),
)  # take a model and its data
RNE = "mj_rne"  # takes two more
(
    KINEMATICS, COM_POS, COM_VEL, MAKE_M, FACTOR_M, COLLISION, MAKE_CONSTRAINT, PASSIVE, REFERENCE,
    ACCELERATION, CONSTRAINT, EULER, BIAS,
) = range(len(STAGES) + 1)  # fmt: skip

_COUNTS = ("ncon", "nefc")
_ROWS = (
    *("efc_type", "efc_id", "efc_pos", "efc_vel", "efc_diagA", "efc_frictionloss", "efc_R"),
    *("efc_D", "efc_aref", "efc_force"),
)
_OF_CONTACT = ("dist", "pos", "frame", "friction", "mu", "geom", "efc_address")
(
    NCON, NEFC, CONTACT, TYPE, ID, POS, VEL, DIAG_A, FRICTIONLOSS, R, D, AREF, FORCE,
    C_DIST, C_POS, C_FRAME, C_FRICTION, C_MU, C_GEOM, C_ROW, C_SIZE,
) = range(len(_COUNTS) + len(_ROWS) + len(_OF_CONTACT) + 2)  # fmt: skip

_C_TYPES: dict[str, Any] = {
    **{"mjtNum": ctypes.c_double, "double": ctypes.c_double, "float": ctypes.c_float},
    **{"int": ctypes.c_int, "mjtByte": ctypes.c_ubyte, "mjtBool": ctypes.c_bool},
    **{"mjtSize": ctypes.c_int64, "size_t": ctypes.c_size_t, "uintptr_t": ctypes.c_size_t},
    **{"uint64_t": ctypes.c_uint64, "int64_t": ctypes.c_int64},
}
# No two of its counts are equal.
_PROBE = """<mujoco><option cone="elliptic"/><worldbody><geom type="plane" size="1 1 1"/><body>
<joint type="slide" axis="0 0 1" frictionloss="1"/><joint type="slide" axis="1 0 0"/>
<geom size="0.1"/><geom size="0.1" pos="1 0 0"/><geom size="0.1" pos="2 0 0"/>
</body></worldbody></mujoco>"""


class Layout(NamedTuple):
    """What compiled code needs to know of MuJoCo.

    Attributes:
        calls: Addresses of the functions, by KINEMATICS and so on. Shape (functions,).
        offsets: In bytes: of counts and pointers in `mjData`, of fields in `mjContact`, and its
            size; by NCON and so on. Shape (fields,).
    """

    calls: np.ndarray
    offsets: np.ndarray


@cache
def layout() -> Layout:
    """The layout of the MuJoCo that is installed.

    Raises:
        NoEngine: If it is another version, or a struct is not where it is said to be.
    """
    if not mujoco.__version__.startswith(f"{VERSION}."):
        raise _wrong_version()
    try:
        library = _library()
        names = (*STAGES, RNE)
        calls = [ctypes.cast(getattr(library, n), ctypes.c_void_p).value or 0 for n in names]
        data, contact = _struct("mjData"), _struct("mjContact")
        of_data = [getattr(data, name).offset for name in (*_COUNTS, "contact", *_ROWS)]
        of_contact = [getattr(contact, name).offset for name in _OF_CONTACT]
    except (AttributeError, KeyError, OSError) as error:
        raise _wrong_version() from error
    offsets = np.array([*of_data, *of_contact, ctypes.sizeof(contact)], dtype=np.int64)
    _check(offsets)
    return Layout(np.array(calls, dtype=np.int64), offsets)


def address(struct: mujoco.MjModel | mujoco.MjData) -> int:
    """Where a model or its data lie."""
    found: int = struct._address
    return found


def _library() -> ctypes.CDLL:
    """The library that the package has loaded already."""
    folder = Path(mujoco.__file__).parent
    patterns = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
    return ctypes.CDLL(str(next(file for p in patterns for file in sorted(folder.glob(p)))))


def _struct(name: str) -> type[ctypes.Structure]:
    """A struct of the headers."""
    fields = [(field.name, _c_type(field.type)) for field in STRUCTS[name].fields]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _c_type(kind: Any) -> Any:
    if isinstance(kind, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(kind, ast_nodes.ArrayType):
        made = _c_type(kind.inner_type)
        for extent in reversed(kind.extents):
            made = made * extent
        return made
    return _C_TYPES[kind.name] if kind.name in _C_TYPES else _struct(kind.name)


def _check(offsets: np.ndarray) -> None:
    """Compare offsets with where the public arrays are.

    Raises:
        NoEngine: If one differs.
    """
    model = mujoco.MjModel.from_xml_string(_PROBE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = address(data)
    counts = [ctypes.c_int.from_address(start + int(at)).value for at in offsets[[NCON, NEFC]]]
    arrays = [data.contact.dist, *(getattr(data, name) for name in _ROWS)]
    there = [ctypes.c_int64.from_address(start + int(at)).value for at in offsets[CONTACT:C_DIST]]
    first = there[0]
    there[0] += int(offsets[C_DIST])
    fields = [getattr(data.contact, name) for name in _OF_CONTACT]
    right = (
        counts == [data.ncon, data.nefc] == [3, 10]
        and there == [array.ctypes.data for array in arrays]
        and [first + int(at) for at in offsets[C_DIST:C_SIZE]] == [f.ctypes.data for f in fields]
        and all(f.strides[0] == offsets[C_SIZE] for f in fields)
    )
    if not right:
        raise _wrong_version()


def _wrong_version() -> NoEngine:
    return NoEngine(
        f"engine mujoco knows the inside of MuJoCo {VERSION}.x, and this is {mujoco.__version__} "
        f"with another one: `pip install 'mujoco=={VERSION}.*'`"
    )


def _pointer_to(kind: Any) -> Any:
    @intrinsic
    def pointer(typing: Any, at: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            wanted = context.get_value_type(signature.return_type)
            return builder.inttoptr(args[0], wanted)

        return types.CPointer(kind)(types.int64), generate

    return pointer


_float_pointer, _int_pointer = _pointer_to(types.float64), _pointer_to(types.int32)


@intrinsic
def _call_stage(typing: Any, function: Any, model: Any, data: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = _function(args[1:])
        return builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])

    return types.void(types.int64, types.int64, types.int64), generate


@intrinsic
def _call_rne(typing: Any, function: Any, model: Any, data: Any, flag: Any, result: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = _function(args[1:])
        return builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])

    words = (types.int64, types.int64, types.int64, types.int32, types.int64)
    return types.void(*words), generate


def _function(args: Any) -> Any:
    """The C type of a function of such arguments that returns nothing; pointers are words."""
    return ir.FunctionType(ir.VoidType(), [arg.type for arg in args])


@njit
def stage(function: int, model: int, data: int) -> None:
    """Call one of MuJoCo's stages by their addresses."""
    _call_stage(function, model, data)  # type: ignore[call-arg]


@njit
def bias(function: int, model: int, data: int, result: int) -> None:
    """Call `mj_rne` for what gravity and velocity ask of the joints."""
    _call_rne(function, model, data, np.int32(0), result)  # type: ignore[call-arg]


@njit
def floats(at: int, length: int) -> np.ndarray:
    """The floats that lie at an address. Shape (length,)."""
    return carray(_float_pointer(at), (length,))


@njit
def ints(at: int, length: int) -> np.ndarray:
    """The C integers that lie at an address. Shape (length,)."""
    return carray(_int_pointer(at), (length,))


@njit
def word(at: int) -> int:
    """The pointer that lies at an address."""
    return carray(_float_pointer(at), (1,)).view(np.int64)[0]
