"""A wheel's speed for vibration analysis, from tooth edges (`edge_speed.EdgeSpeed`) or bus speed
(`bus_speed.BusSpeed`).

tracker.add(...)                          what came, in order
samples, complaints = tracker.advance(end)   speed at RATE (400 Hz), NaN where it is not known, up to `end` [s]
"""
