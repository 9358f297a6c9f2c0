"""Figures measured on the history of a drive: comfort, resonances."""
