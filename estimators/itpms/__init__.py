"""Tyre pressure without a pressure sensor: torsional vibration and rolling radius of the four wheels, fused by a
likelihood over the patterns of low tyres, with the published voting scheme beside it.
"""
