"""Slow leaks in records of direct pressure sensors over weeks and months: see `monitor` and `record`."""
