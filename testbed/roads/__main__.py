"""`python -m testbed.roads SPEC [--length M] [--seed N]`: what a road is like, per track."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from testbed.arguments import Parser
from testbed.roads.iri import iri
from testbed.roads.registry import make_road, road_forms
from testbed.roads.road import ISO_SPACING
from testbed.roads.spectrum import fitted_gd, iso_class

TRACK = 1.6  # [m]
_LENGTHS = (20.0, 20000.0)  # [m]


def report(spec: str, length: float, seed: int) -> list[str]:
    """The lines to print; ValueError in one line for bad input."""
    if not _LENGTHS[0] <= length <= _LENGTHS[1]:
        raise ValueError(f"--length {length:g} must be {_LENGTHS[0]:g} to {_LENGTHS[1]:g} m")
    road = make_road(spec, seed, speed=length / 66.0 if length < 6000.0 else 100.0, duration=60.0).raw
    x = ISO_SPACING * np.arange(round(length / ISO_SPACING) + 1, dtype=np.float64)
    tracks = road.heights(x, np.array([-0.5 * TRACK, 0.5 * TRACK]))
    lines = [f"road {road.name}, seed {seed}, spacing {road.spacing:g} m, {length:g} m long"]
    for name, z in (("left", tracks[1]), ("right", tracks[0])):
        gd = fitted_gd(z, ISO_SPACING)
        lines.append(
            f"{name:5s} track: IRI {iri(z, ISO_SPACING):6.2f} m/km, "
            f"Gd(0.1) {1e6 * gd:9.4g}e-6 m^3, class {iso_class(gd)}, "
            f"heights {z.min():+.3f} to {z.max():+.3f} m"
        )
    return lines


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the report; exit status 2 and one line on bad input."""
    parser = Parser(prog="testbed.roads", description=__doc__)
    parser.add_argument("spec", metavar="SPEC", help=road_forms())
    parser.add_argument("--length", type=float, default=1000.0, metavar="M", help="length to look at [m], default 1000")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of a synthetic road, default 1")
    given = parser.parse_args(arguments)
    try:
        lines = report(given.spec, given.length, given.seed)
    except ValueError as error:
        print(f"testbed.roads: {error}", file=sys.stderr)
        return 2
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
