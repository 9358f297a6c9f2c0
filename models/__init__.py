"""The car and its tyres: numbers with their sources, and the MuJoCo model composed from them."""

import os

os.environ.setdefault("MUJOCO_GL", "disable")  # composing needs no screen; without this dm_control looks for one
