"""Roads: surfaces z(x, y) from a text and a seed, the window of them that MuJoCo holds, friction and roughness
figures.

`make_road("C", seed, speed, duration)` gives a road; a new kind of road is one new file in this folder.
"""

from testbed.roads.registry import make_road, road_forms, road_kinds
from testbed.roads.road import Road, RoadKind

__all__ = ["Road", "RoadKind", "make_road", "road_forms", "road_kinds"]
