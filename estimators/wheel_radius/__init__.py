"""Tyre pressure from rolling radius: wheel speeds against each other and against the gyro (Persson et al., SAE
2002).
"""
