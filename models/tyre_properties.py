"""Tyre property sets: every number of one tyre, read from one file in which each has a value, a unit and a source.

    load_tyre("suv-235-60r18")   a set of models/tyres/, by name
    load_tyre("folder/my.toml")  the same format, anywhere
    load_tyre("folder/my.tir")   a standard Magic Formula property file (models/tir.py)

Names are those of the Magic Formula 6.1 property file and of Pacejka, Tire and Vehicle Dynamics, 3rd ed. (MF 6.1 and
rigid ring, App. 3) in lower case. SI; pressures are gauge. Derived, not stored: the belt's suspension on the rim,
k = (2 pi f)^2 m, d = 2 zeta (2 pi f) m, and the same about the spin axis with the belt's inertia.
No public source gives the carcass laws, the heat balance and the share of re_pressure_share: the files declare them.
"""

from __future__ import annotations

import dataclasses
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.slip_coefficients import SLIP_NAMES, SlipCoefficients

FOLDER = Path(__file__).with_name("tyres")
DEFAULT_TYRE = "suv-235-60r18"


@dataclass(frozen=True, kw_only=True)
class TyreProperties(SlipCoefficients):
    """One tyre. The slip coefficients (fz0, p0, r0 among them) are inherited."""

    name: str
    # dimension and reference
    width: float  # [m]
    rim_radius: float  # [m]
    v0: float  # reference speed [m/s]
    valid_pressure_min: float  # range of the measurements behind the set, gauge [Pa]
    valid_pressure_max: float
    # belt ring
    belt_mass: float  # [kg]
    belt_iyy: float  # about the spin axis [kg m^2]
    belt_ixx: float  # about a diameter [kg m^2]
    freq_long: float  # rim fixed, in the wheel's plane [Hz]
    freq_lat: float
    freq_yaw: float
    freq_windup: float
    damp_long: float  # damping ratios [-]
    damp_lat: float
    damp_yaw: float
    damp_windup: float
    # vertical law
    cz0: float  # stiffness at fz0, p0 and rest [N/m]
    pfz1: float
    q_v2: float
    q_fz2: float
    q_fcx: float
    q_fcy: float
    carcass_fraction: float  # vertical stiffness without pressure over that at p0 [-]
    bottom_offset: float  # the rim touches when its centre is rim_radius + bottom_offset above the road [m]
    bottom_stiffness: float  # [N/m]
    # free and effective rolling radius
    q_re0: float
    q_v1: float
    breff: float
    dreff: float
    freff: float
    re_pressure_share: float  # factor on the pressure dependence inside Re alone [-]
    # contact patch and enveloping
    q_ra1: float
    q_ra2: float
    ellips_shift: float  # cam spacing over contact length, p_ls [-]
    ellips_length: float  # semi-axes over r0 [-]
    ellips_height: float
    ellips_order: float
    # overall horizontal stiffness of the standing tyre
    cx: float  # [N/m]
    cy: float  # [N/m]
    pcfx3: float  # relative change per dpi [-]
    pcfy3: float
    torsion_base: float  # torsional stiffness = c (torsion_base + (1 - torsion_base) p/p0) [-]
    # rolling resistance
    qsy1: float
    qsy2: float
    qsy3: float
    qsy4: float
    qsy5: float
    qsy6: float
    qsy7: float
    qsy8: float
    # heat of tyre and gas
    heat_capacity: float  # [J/K]
    thermal_time_constant: float  # [s]
    heat_share: float  # share of the drag power that warms the tyre [-]
    # what a reader had to assume, one sentence each
    notes: tuple[str, ...] = ()

    @property
    def sidewall_stiffness(self) -> float:
        """Belt against rim in the wheel's plane at p0, c_bx = c_bz [N/m]."""
        return (2.0 * math.pi * self.freq_long) ** 2 * self.belt_mass

    @property
    def sidewall_damping(self) -> float:
        """Belt against rim in the wheel's plane [N s/m]."""
        return 2.0 * self.damp_long * 2.0 * math.pi * self.freq_long * self.belt_mass

    @property
    def lateral_sidewall_stiffness(self) -> float:
        """Belt against rim along the spin axis at p0, c_by [N/m]."""
        return (2.0 * math.pi * self.freq_lat) ** 2 * self.belt_mass

    @property
    def lateral_sidewall_damping(self) -> float:
        """Belt against rim along the spin axis [N s/m]."""
        return 2.0 * self.damp_lat * 2.0 * math.pi * self.freq_lat * self.belt_mass

    @property
    def torsional_stiffness(self) -> float:
        """Belt against rim about the spin axis at p0, c_b,theta [N m/rad]."""
        return (2.0 * math.pi * self.freq_windup) ** 2 * self.belt_iyy

    @property
    def torsional_damping(self) -> float:
        """Belt against rim about the spin axis [N m s/rad]."""
        return 2.0 * self.damp_windup * 2.0 * math.pi * self.freq_windup * self.belt_iyy

    @property
    def cx_pressure(self) -> float:
        """Relative change of Cx per dpi [-] (PCFX3)."""
        return self.pcfx3

    @property
    def cy_pressure(self) -> float:
        """Relative change of Cy per dpi [-] (PCFY3)."""
        return self.pcfy3

    def slip_array(self) -> NDArray[np.float64]:
        """The slip kernel's parameters, shape (len(SLIP_NAMES),), in the order of SLIP_NAMES."""
        return np.array([getattr(self, name) for name in SLIP_NAMES], dtype=np.float64)


NUMBERS: tuple[str, ...] = tuple(f.name for f in dataclasses.fields(TyreProperties) if f.name not in ("name", "notes"))
POSITIVE = (
    "fz0", "p0", "r0", "width", "rim_radius", "v0", "valid_pressure_min", "valid_pressure_max", "belt_mass", "belt_iyy",
    "belt_ixx", "freq_long", "freq_lat", "freq_yaw", "freq_windup", "cz0", "bottom_stiffness", "q_re0", "breff",
    "ellips_shift", "ellips_length", "ellips_height", "ellips_order", "cx", "cy", "heat_capacity",
    "thermal_time_constant", "pcx1", "pcy1", "pdx1", "pkx1", "pky2", "pky4", "qcz1",
)  # fmt: skip
SHARE = ("carcass_fraction", "torsion_base", "re_pressure_share", "heat_share")
NOT_NEGATIVE = ("bottom_offset", "q_ra1", "q_ra2", "damp_long", "damp_lat", "damp_yaw", "damp_windup")


def checked(tyre: TyreProperties, where: str) -> TyreProperties:
    """The same tyre, or ValueError naming `where`, the number and what it must be."""
    for name in NUMBERS:
        value = getattr(tyre, name)
        if not math.isfinite(value):
            raise ValueError(f"{where}: {name} = {value} is not a finite number")
        if name in POSITIVE and value <= 0.0:
            raise ValueError(f"{where}: {name} = {value} must be positive")
        if name in NOT_NEGATIVE and value < 0.0:
            raise ValueError(f"{where}: {name} = {value} must not be negative")
        if name in SHARE and not 0.0 <= value <= 1.0:
            raise ValueError(f"{where}: {name} = {value} must lie between 0 and 1")
    if tyre.pdy1 * tyre.pky1 == 0.0:
        raise ValueError(f"{where}: pdy1 = {tyre.pdy1} and pky1 = {tyre.pky1} must not be zero")
    if tyre.rim_radius + tyre.bottom_offset >= tyre.r0:
        raise ValueError(f"{where}: rim_radius + bottom_offset must be less than r0 = {tyre.r0} m")
    if not tyre.valid_pressure_min < tyre.valid_pressure_max:
        raise ValueError(f"{where}: valid_pressure_min must be less than valid_pressure_max")
    if (tyre.cz0 * tyre.r0 / tyre.fz0) ** 2 <= 4.0 * tyre.q_fz2:
        raise ValueError(f"{where}: q_fz2 = {tyre.q_fz2} leaves no linear stiffness; it must be below (cz0 r0/fz0)^2/4")
    if 1.0 / tyre.cz0 <= 1.0 / tyre.sidewall_stiffness:
        raise ValueError(
            f"{where}: cz0 = {tyre.cz0} N/m must be less than the belt's {tyre.sidewall_stiffness:.0f} N/m"
        )
    return tyre


def tyre_names() -> tuple[str, ...]:
    """Names of the property sets in models/tyres/."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def load_tyre(name_or_path: str | Path = DEFAULT_TYRE) -> TyreProperties:
    """A tyre by its name in models/tyres/, or from a `.toml` or `.tir` file. ValueError of one line if it cannot be."""
    text = str(name_or_path)
    if text in tyre_names():
        return _load_toml(FOLDER / f"{text}.toml")
    path = Path(text)
    if path.suffix.lower() not in (".toml", ".tir"):
        raise ValueError(f"unknown tyre {text!r}; valid: {', '.join(tyre_names())}, or a .toml or .tir file")
    if not path.is_file():
        raise ValueError(f"no tyre file {text!r}; valid names: {', '.join(tyre_names())}, or a .toml or .tir file")
    if path.suffix.lower() == ".tir":
        from models.tir import load_tir  # here, since it builds on this module

        return load_tir(path)
    return _load_toml(path)


def _load_toml(path: Path) -> TyreProperties:
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ValueError(f"{path}: not a readable TOML file: {error}") from None
    entries: dict[str, Any] = {}
    for group, table in tables.items():
        if not isinstance(table, dict):
            raise ValueError(f"{path}: {group} stands outside a group such as [dimension]")
        entries.update(table)
    unknown = sorted(set(entries) - set(NUMBERS))
    if unknown:
        raise ValueError(f"{path}: unknown {', '.join(unknown)}; valid: the names of models/tyre_properties.py")
    missing = [name for name in NUMBERS if name not in entries]
    if missing:
        raise ValueError(f"{path}: missing {', '.join(missing)}")
    values = {name: _number(entries[name], name, path) for name in NUMBERS}
    return checked(TyreProperties(name=path.stem, notes=(), **values), str(path))


def _number(entry: Any, name: str, path: Path) -> float:
    """The value of `{ value = , unit = , source = }`."""
    if not isinstance(entry, dict) or set(entry) != {"value", "unit", "source"}:
        raise ValueError(f"{path}: {name} must be {{ value = number, unit = text, source = text }}")
    value = entry["value"]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{path}: {name} = {value!r} is not a number")
    if not str(entry["source"]).strip():
        raise ValueError(f"{path}: {name} has no source")
    return float(value)
