"""The ground a robot walks on, as numbers: a tufted pile, a fibre mat, a soft layer or a floor.

A surface is a YAML file in `surfaces/`; its `type` names one of the four classes here and its
other keys are their fields. Constants that no pedestal owns are defaults of `Pile`.

References:
    PedestalsEROS: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot Humanoid
        on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
    Toll1998: Toll, Packing mechanics of fiber reinforcements, Polymer Engineering & Science, 1998.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

from gaitlab.errors import WrongValue
from gaitlab.parameters import parameter
from gaitlab.surfaces.pile import PileLaw

FILAMENT_DENSITY = 920.0  # kg/m^3, linear low-density polyethylene
SOLID_MAT = 0.6  # solid fraction of a random mat of rods that cannot be pressed further


@dataclass(frozen=True, kw_only=True)
class _Ground:
    friction: float = parameter(
        unit="-", low=0.01, high=2.0, doc="Coulomb friction between sole and ground"
    )
    friction_scale: float = parameter(
        1.0, unit="-", low=0.1, high=3.0, doc="factor on friction, shared by all surfaces"
    )


@dataclass(frozen=True, kw_only=True)
class RigidFloor(_Ground):
    """A hard floor."""

    type: Literal["rigid"] = "rigid"

    @property
    def height(self) -> float:
        """Height of its top over the base, in [m]."""
        return 0.0


@dataclass(frozen=True, kw_only=True)
class SoftLayer(_Ground):
    """A hard base below a spring and damper at each support point, as simulators model grass."""

    type: Literal["layer"] = "layer"
    height: float = parameter(unit="m", low=0.0, high=0.2, doc="top of the layer over the base")
    stiffness: float = parameter(unit="N/m", low=1.0, high=1e7, doc="stiffness below a whole sole")
    damping: float = parameter(unit="N s/m", low=0.0, high=1e5, doc="damping below a whole sole")


@dataclass(frozen=True, kw_only=True)
class _Pile(_Ground):
    height: float = parameter(unit="m", low=5e-4, high=0.2, doc="pile height over the base")
    modulus: float = parameter(unit="Pa", low=1e7, high=1e10, doc="Young's modulus of the filament")
    nap: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=0.9,
        doc="share by which the plough force falls with the blades' lean and rises against it",
    )
    nap_direction: float = parameter(
        0.0, unit="rad", low=-pi, high=pi, doc="direction the blades lean to, from x to y"
    )
    height_noise: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=0.15,
        doc="standard deviation of the local pile height over its mean; energy leaks beyond 0.15",
    )
    density_noise: float = parameter(
        0.0,
        unit="-",
        low=0.0,
        high=1.0,
        doc="standard deviation of the log of local plough strength",
    )
    packing: float = parameter(
        0.17,
        unit="-",
        low=0.0,
        high=1.0,
        doc="factor k_n of the packing law",
        source="fitted range 0.04 to 0.7",
    )
    exponent: float = parameter(
        5.0,
        unit="-",
        low=2.0,
        high=15.0,
        doc="exponent n of the packing law: 3 random mat, 5 planar mat",
        source="[Toll1998]",
    )
    vertical_scale: float = parameter(
        1.0,
        unit="-",
        low=0.1,
        high=10.0,
        doc="factor c_v on all pile forces, shared by all surfaces",
        source="assumption",
    )
    toe_catch: float = parameter(
        3.0,
        unit="-",
        low=0.0,
        high=30.0,
        doc="factor c_e on the force a leading edge meets, shared by all surfaces; 1 is smooth",
        source="assumption, range 1 to 15",
    )
    hysteresis: float = parameter(
        0.33,
        unit="-",
        low=0.0,
        high=0.9,
        doc="largest share eta of pressure lost to blade friction",
        source="assumption, range 0.2 to 0.5",
    )
    relaxation_time: float = parameter(
        0.005,
        unit="s",
        low=0.0,
        high=0.1,
        doc="damping over stiffness tau",
        source="assumption, range 2 to 15 ms",
    )

    def _law(self, solid_fraction: float, p1: float) -> PileLaw:
        return PileLaw(
            height=self.height,
            exponent=self.exponent,
            p1=p1 * self.vertical_scale,
            p2=self.packing * self.modulus * solid_fraction**self.exponent * self.vertical_scale,
            solid_height=solid_fraction * self.height / SOLID_MAT,
        )


@dataclass(frozen=True, kw_only=True)
class TuftedPile(_Pile):
    """Synthetic grass: blades that stand in tufts, fold under load and pack into a mat."""

    type: Literal["tufts"] = "tufts"
    spacing: float = parameter(unit="m", low=1e-3, high=0.05, doc="distance between tufts")
    yarn: float = parameter(
        unit="kg/m",
        low=1e-5,
        high=1e-2,
        doc="linear density of one yarn end; 10 000 dtex is 1e-3 kg/m",
    )
    blades: float = parameter(unit="-", low=1, high=100, doc="blades in a tuft")
    blade_width: float = parameter(unit="m", low=1e-4, high=0.01, doc="width of a blade")
    blade_thickness: float = parameter(unit="m", low=1e-5, high=2e-3, doc="thickness of a blade")
    section: float = parameter(
        1.0, unit="-", low=1.0, high=8.0, doc="second moment of the blade over that of a flat tape"
    )
    bonding: float = parameter(
        5.0,
        unit="-",
        low=1.0,
        high=16.0,
        doc="stiffness gain c_B by friction between the blades of a tuft",
        source="assumption",
    )

    def __post_init__(self) -> None:
        if self.solid_fraction > SOLID_MAT:
            raise WrongValue(
                f"tufts {self.spacing:g} m apart of yarn of {self.yarn:g} kg/m fill "
                f"{self.solid_fraction:.2f} of the pile, at most {SOLID_MAT:g} is allowed; "
                "check spacing and yarn"
            )

    @property
    def solid_fraction(self) -> float:
        """Volume of filament over volume of pile at full height; two yarn ends a tuft."""
        return 2.0 * self.yarn / (FILAMENT_DENSITY * self.spacing**2)

    def law(self) -> PileLaw:
        """Pressure law: blades folded by 90 degrees store (pi/4) EI / h each, derived here."""
        second_moment = self.section * self.blade_width * self.blade_thickness**3 / 12.0
        bending = self.modulus * second_moment * self.blades / self.spacing**2
        p1 = self.bonding * (pi / 4.0) * bending / self.height**2
        return self._law(self.solid_fraction, p1)


@dataclass(frozen=True, kw_only=True)
class FibreMat(_Pile):
    """Carpet: a dense mat whose fibres only pack."""

    type: Literal["mat"] = "mat"
    solid_fraction: float = parameter(
        unit="-", low=1e-3, high=0.6, doc="volume of fibre over volume of pile at full height"
    )

    def law(self) -> PileLaw:
        """Pressure law of packing alone, [Toll1998]."""
        return self._law(self.solid_fraction, 0.0)


Surface = RigidFloor | SoftLayer | TuftedPile | FibreMat
SURFACE_TYPES: dict[str, type] = {
    "rigid": RigidFloor,
    "layer": SoftLayer,
    "tufts": TuftedPile,
    "mat": FibreMat,
}
