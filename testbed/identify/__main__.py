"""python -m testbed.identify NAME [--out FILE]: identifies what estimators of the default car start from.

NAME: quarter-cars (estimator vertical_pressure), axles (estimator axles), published (IMM of unscented filters, by road
class), steering-servo (estimator steering_actuator), steering-monitors (the thesis' monitors of the same). By default
the result becomes the file in models/ that drives read. Ten to fifteen minutes each.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from estimators.whole_file import check_writable, write_json
from models.identified import CLASS_QUARTER_CARS, QUARTER_CARS, STEERING_MONITORS, STEERING_SERVO, TWO_AXLES
from testbed.arguments import Parser
from testbed.identify import axles, published, quarter_cars, steering_monitors, steering_servo

KINDS = {
    "quarter-cars": (QUARTER_CARS, quarter_cars.document),
    "axles": (TWO_AXLES, axles.document),
    "published": (CLASS_QUARTER_CARS, published.document),
    "steering-servo": (STEERING_SERVO, steering_servo.document),
    "steering-monitors": (STEERING_MONITORS, steering_monitors.document),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0, or 2 when the file cannot be written."""
    layout = argparse.RawDescriptionHelpFormatter
    parser = Parser(prog="testbed.identify", description=__doc__, formatter_class=layout)
    parser.add_argument("name", choices=KINDS, metavar="NAME", help=", ".join(KINDS))
    parser.add_argument("--out", type=Path, metavar="FILE", help="the result (JSON; default: its file in models/)")
    options = parser.parse_args(arguments)
    place, identified = KINDS[options.name]
    out = options.out or place
    try:
        check_writable(out)
        document = identified()
        write_json(out, document)
    except OSError as error:
        print(f"testbed.identify: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    print(json.dumps(document, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
