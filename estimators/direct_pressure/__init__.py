"""Tyre pressure from sensors in the tyres: the published leak detector and one that works."""
