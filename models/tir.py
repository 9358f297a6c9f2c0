"""Standard Magic Formula property files (`.tir`; MF 5.0, 5.2 / PAC2002, 6.1, 6.2) as tyre property sets.

Same coefficients, same formulas: MF 5.2 is MF 6.1 with PKY4 = 2, PKY6 = PVY3, PKY7 = PVY4 and its PHY3 kept. The file's
scaling factors are folded into the coefficients they multiply (4.E7-4.E67, A_mu = 1). A file measured on a right-hand
tyre is mirrored, since a set stands for the left one. What a file does not hold is filled in and told in `notes`:
    pressure terms of slip and drag  zero: pressure then acts through stiffness, radius and contact length alone
    vertical law against pressure    PFZ1 of the book tyre, since a tyre is not a tyre without it
    belt mass and inertia            the book's by r0^3 and m r0^2; its frequencies such that sidewall stiffness keeps
                                     the book's ratio to the vertical stiffness; Cx and Cy likewise
    weights of combined slip         the book's where the file has none (RBX1 or RCX1, RBY1 or RCY1 zero)
Left out: deflection and bottoming curves (the stiffness counts), turn slip, overturning moment, ranges of validity.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

from models.slip_coefficients import SLIP_NAMES
from models.tir_file import TirFile, read_tir_file
from models.tyre_properties import DEFAULT_TYRE, TyreProperties, checked, load_tyre

BOOK_TYRE = "book-205-60r15"

# Keys whose name differs from the property set's.
RENAMED = {
    "r0": "UNLOADED_RADIUS", "fz0": "FNOMIN", "v0": "LONGVL", "cz0": "VERTICAL_STIFFNESS",
    "cx": "LONGITUDINAL_STIFFNESS", "cy": "LATERAL_STIFFNESS", "bottom_offset": "BOTTOM_OFFST",
    "bottom_stiffness": "BOTTOM_STIFF",
}  # fmt: skip

# Every version's core: a file without these is cut short or of another kind.
MANDATORY = (
    "r0", "fz0",
    "pcx1", "pdx1", "pdx2", "pex1", "pex2", "pex3", "pex4", "pkx1", "pkx2", "pkx3", "phx1", "phx2", "pvx1", "pvx2",
    "pcy1", "pdy1", "pdy2", "pdy3", "pey1", "pey2", "pey3", "pey4", "pky1", "pky2", "pky3", "phy1", "phy2",
    "pvy1", "pvy2", "pvy3", "pvy4",
    "qbz1", "qbz2", "qbz3", "qbz4", "qbz5", "qbz9", "qcz1", "qdz1", "qdz2", "qdz3", "qdz4", "qdz6", "qdz7", "qdz8",
    "qdz9", "qez1", "qez2", "qez3", "qez4", "qez5", "qhz1", "qhz2", "qhz3", "qhz4",
)  # fmt: skip
PRESSURE_TERMS = ("ppx1", "ppx2", "ppx3", "ppx4", "ppy1", "ppy2", "ppy3", "ppy4", "ppy5", "ppz1", "ppz2")
WEIGHTS = {
    "longitudinal": ("rbx1", "rbx2", "rbx3", "rcx1", "rex1", "rex2", "rhx1"),
    "side": ("rby1", "rby2", "rby3", "rby4", "rcy1", "rey1", "rey2", "rhy1", "rhy2"),
}

# Coefficients that a scaling factor multiplies.
SCALED = {
    "LFZO": ("fz0",), "LCZ": ("cz0",),
    "LCX": ("pcx1",), "LMUX": ("pdx1", "pdx2", "pvx1", "pvx2"), "LEX": ("pex1", "pex2", "pex3"),
    "LKX": ("pkx1", "pkx2"),
    "LHX": ("phx1", "phx2"), "LVX": ("pvx1", "pvx2"), "LCY": ("pcy1",),
    "LMUY": ("pdy1", "pdy2", "pvy1", "pvy2", "pvy3", "pvy4", "qdz6", "qdz7", "qdz8", "qdz9", "qdz10", "qdz11"),
    "LEY": ("pey1", "pey2"), "LKY": ("pky1", "qbz1", "qbz2", "qbz3", "qbz9"), "LKYC": ("pky6", "pky7", "pvy3", "pvy4"),
    "LHY": ("phy1", "phy2"), "LVY": ("pvy1", "pvy2"), "LTR": ("qdz1", "qdz2"), "LRES": ("qdz6", "qdz7"),
    "LKZC": ("qdz8", "qdz9", "qdz10", "qdz11"), "LXAL": ("rbx1", "rbx3"), "LYKA": ("rby1", "rby4"),
    "LVYKA": ("rvy1", "rvy2", "rvy3"), "LS": ("ssz1", "ssz2", "ssz3", "ssz4"),
    "LMY": ("qsy1", "qsy2", "qsy3", "qsy4", "qsy5", "qsy6"),
}  # fmt: skip
DIVIDED = {"LMUY": ("qbz1", "qbz2", "qbz3", "qbz9")}
UNUSED_FACTORS = ("LGAX", "LGAY", "LGAZ", "LMUV")

# Coefficients that change sign in the mirror: ply steer and conicity.
ODD = (
    "rhx1", "pey3", "phy1", "phy2", "pvy1", "pvy2", "rby3", "rvy1", "rvy2", "qbz4", "qdz3", "qdz6", "qdz7", "qez4",
    "qhz1", "qhz2", "ssz1",
)  # fmt: skip


def load_tir(path: str | Path) -> TyreProperties:
    """A `.tir` file as a property set whose `notes` tell what was filled in. ValueError of one line if unusable."""
    file = read_tir_file(path)
    book = load_tyre(BOOK_TYRE)
    fields = [f.name for f in dataclasses.fields(TyreProperties) if f.name not in ("name", "notes")]
    keys = {name: RENAMED.get(name, name.upper()) for name in fields}
    values = {name: file.numbers[key] for name, key in keys.items() if key in file.numbers}
    for key in keys.values():
        if key in file.texts:
            raise ValueError(f"{file.path}: {key} = {file.texts[key]!r} is not a number")
    notes: list[str] = []
    _vertical_stiffness(values, file)
    missing = [keys[name] for name in (*MANDATORY, "cz0") if name not in values]
    if missing:
        more = f" and {len(missing) - 8} more" if len(missing) > 8 else ""
        raise ValueError(f"{file.path}: missing {', '.join(missing[:8])}{more}; cut short, or no Magic Formula file")
    for name in ("r0", "fz0", "cz0"):
        if values[name] <= 0.0:
            raise ValueError(f"{file.path}: {keys[name]} = {values[name]} must be positive")
    _pressure(values, file, book, notes)
    _slip(values, book, notes)
    _body(values, book, notes)
    _vertical_law(values, book, notes)
    _scale(values, file, notes)
    _side(values, file, notes)
    if "DEFLECTION_LOAD_CURVE" in file.sections:
        notes.append("The deflection-load curve is not used: VERTICAL_STIFFNESS is.")
    return checked(TyreProperties(name=file.path.stem, notes=tuple(notes), **values), str(file.path))


def _vertical_stiffness(values: dict[str, float], file: TirFile) -> None:
    """cz0 from Q_FZ1 where a file (MF 6.2) gives that in its place."""
    if "cz0" not in values and "Q_FZ1" in file.numbers and {"r0", "fz0"} <= set(values):
        square = file.numbers["Q_FZ1"] ** 2 + 4.0 * values.get("q_fz2", 0.0)
        values["cz0"] = values["fz0"] / values["r0"] * math.sqrt(max(square, 0.0))


def _pressure(values: dict[str, float], file: TirFile, book: TyreProperties, notes: list[str]) -> None:
    """p0 and its range [Pa]."""
    for key in ("NOMPRES", "IP_NOM", "INFLPRES", "IP"):
        if key in file.numbers:
            values["p0"] = file.numbers[key]
            break
    else:
        stated = file.numbers.get("INFLATION_PRESSURE")
        if stated is not None and 0.0 < stated < 20.0:
            values["p0"] = stated * 1e5
            notes.append(f"Nominal pressure from INFLATION_PRESSURE = {stated:g}, taken as bar.")
        else:
            values["p0"] = book.p0
            notes.append(f"No nominal pressure in the file: {book.p0 / 1e3:g} kPa of the book tyre.")
    if {"PRESMIN", "PRESMAX"} <= set(file.numbers):
        values["valid_pressure_min"], values["valid_pressure_max"] = file.numbers["PRESMIN"], file.numbers["PRESMAX"]
    if not 0.0 < values.get("valid_pressure_min", 0.0) < values.get("valid_pressure_max", 0.0):
        values["valid_pressure_min"], values["valid_pressure_max"] = 0.8 * values["p0"], 1.2 * values["p0"]
        notes.append("No range of pressures in the file: 0.8 to 1.2 of the nominal one.")


def _slip(values: dict[str, float], book: TyreProperties, notes: list[str]) -> None:
    """Slip coefficients that older formats lack."""
    if "pky6" not in values:
        values["pky6"], values["pky7"] = values["pvy3"], values["pvy4"]
        notes.append("Magic Formula 5: PKY4 = 2, camber through PHY3, PVY3 and PVY4.")
    values.setdefault("pky4", 2.0)
    if not any(name in values for name in PRESSURE_TERMS):
        notes.append("No pressure terms of slip: zero.")
    for force, names in WEIGHTS.items():
        slope, shape = names[0], next(name for name in names if name.startswith("rc"))
        if not values.get(slope) or not values.get(shape):
            values.update({name: getattr(book, name) for name in names})
            notes.append(f"No weights of combined slip for the {force} force: the book tyre's.")
    for name in SLIP_NAMES:
        values.setdefault(name, 0.0)


def _body(values: dict[str, float], book: TyreProperties, notes: list[str]) -> None:
    """Dimensions, belt, horizontal stiffness, contact patch and heat, from the book tyre where absent (or zero)."""
    length, stiffness = values["r0"] / book.r0, values["cz0"] / book.cz0
    mass = length**3
    frequency = math.sqrt(stiffness / mass)
    scale = {
        "width": length, "rim_radius": length, "belt_mass": mass, "belt_iyy": mass * length**2,
        "belt_ixx": mass * length**2, "freq_long": frequency, "freq_lat": frequency, "freq_yaw": frequency,
        "freq_windup": frequency, "cx": stiffness, "cy": stiffness, "bottom_stiffness": stiffness,
        "heat_capacity": mass,
    }  # fmt: skip
    filled = []
    for name, factor in scale.items():
        if not values.get(name):
            values[name] = getattr(book, name) * factor
            filled.append(name)
    if filled:
        notes.append(f"Scaled from the book tyre by r0 and cz0: {', '.join(filled)}.")
    same = (
        "v0", "damp_long", "damp_lat", "damp_yaw", "damp_windup", "bottom_offset", "q_ra1", "q_ra2", "ellips_shift",
        "ellips_length", "ellips_height", "ellips_order", "torsion_base", "pcfx3", "pcfy3", "thermal_time_constant",
        "heat_share", "carcass_fraction",
    )  # fmt: skip
    filled = [name for name in same if name not in values]
    values.update({name: getattr(book, name) for name in filled})
    if filled:
        notes.append(f"As the book tyre: {', '.join(filled)}.")


def _vertical_law(values: dict[str, float], book: TyreProperties, notes: list[str]) -> None:
    """Vertical law, radius and drag where the file has none."""
    if "pfz1" not in values:
        values["pfz1"] = book.pfz1
        notes.append(f"Vertical stiffness against pressure: PFZ1 = {book.pfz1} of the book tyre.")
    for name in ("breff", "dreff", "freff"):
        if name not in values:
            values[name] = getattr(book, name)
            notes.append(f"{name.upper()} = {values[name]} of the book tyre.")
    values.setdefault("re_pressure_share", load_tyre(DEFAULT_TYRE).re_pressure_share)
    notes.append(
        f"Rolling radius takes {values['re_pressure_share']:.2f} of the pressure's effect, as the default tyre."
    )
    for name in ("q_v1", "q_v2", "q_fz2", "q_fcx", "q_fcy", "qsy2", "qsy3", "qsy4", "qsy5", "qsy6", "qsy8"):
        values.setdefault(name, 0.0)
    values.setdefault("q_re0", 1.0)
    values.setdefault("qsy7", 1.0)
    if not values.get("qsy1"):
        values["qsy1"] = book.qsy1
        notes.append(f"Rolling resistance: QSY1 = {book.qsy1} of the book tyre.")


def _scale(values: dict[str, float], file: TirFile, notes: list[str]) -> None:
    """Fold the scaling factors in."""
    for factor in (*SCALED, *UNUSED_FACTORS):
        value = file.numbers.get(factor, 1.0)
        if value < 0.0 or (value == 0.0 and factor in ("LFZO", "LCZ", "LMUX", "LMUY", "LKX", "LKY", "LCX", "LCY")):
            raise ValueError(f"{file.path}: scaling factor {factor} = {value:g} must be positive")
        for name in SCALED.get(factor, ()):
            values[name] *= value
        for name in DIVIDED.get(factor, ()):
            values[name] /= value
        if factor in UNUSED_FACTORS and value != (0.0 if factor == "LMUV" else 1.0) and factor in file.numbers:
            notes.append(f"Scaling factor {factor} = {value:g} is not applied.")


def _side(values: dict[str, float], file: TirFile, notes: list[str]) -> None:
    """Turn a right-hand set into a left-hand one."""
    side = file.text("TYRESIDE")
    sign = {"RIGHT": -1.0, "SYMMETRIC": 0.0}.get(side, 1.0)
    for name in ODD:
        values[name] *= sign
    if side == "RIGHT":
        notes.append("Measured on the right-hand side: mirrored.")
    elif side != "LEFT":
        notes.append("Symmetric tyre." if sign == 0.0 else "Mounted side unknown: taken as left.")
