"""Modes of the rolling car, from the linearised step of the very loop that drives it.

The one-step map x(k+1) = f(x(k)) of the whole car, coasting on a flat road, is differentiated by central differences in
the 69 + 8 states (positions without the free joint's redundancy, velocities, contact shear of the tyres). An eigenvalue
l of the Jacobian is a continuous eigenvalue s = ln(l)/step: frequency |s|/2 pi, damping ratio -Re(s)/|s|. So what the
integrator and the held forces do to a mode is in it.

The two rotational modes of a wheel, of which an indirect pressure monitor listens to one:
    in phase    rim and belt turn together against the contact patch and the sidewall's torsion
    antiphase   rim against belt
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from testbed import driver, loop, trace
from testbed.simulation import Simulation
from testbed.tyre.contact import SHEAR_X, SHEAR_Y

_SMALL = 1e-6  # relative perturbation; a tenth of it gives the same frequencies to 1e-5
_STIFFEST = 0.9  # largest decay per step of an oscillation that counts


@dataclass(frozen=True)
class Mode:
    """frequency: undamped natural frequency [Hz]; damping: ratio [-]; shares: of the kinetic energy by degree of
    freedom, shape (nv,); shape: complex velocities, shape (nv,)."""

    frequency: float
    damping: float
    shares: NDArray[np.float64]
    shape: NDArray[np.complex128]


class _Step:
    """One step of the loop as a function of the reduced state."""

    def __init__(self, simulation: Simulation) -> None:
        self.s = simulation
        self.data = simulation.data
        plan = simulation.constants.plan
        coast = plan._replace(mode=np.full_like(plan.mode, driver.COAST))
        self.constants = simulation.constants._replace(plan=coast)
        self.qpos, self.qvel = self.data.qpos.copy(), self.data.qvel.copy()
        self.state = [part.copy() for part in simulation.state]
        self.rows, self.poses = np.empty((1, trace.WIDTH)), np.empty((0, simulation.model.nbody, 7))
        self.nv = simulation.model.nv
        self.size = 2 * self.nv + 8

    def __call__(self, change: NDArray[np.float64]) -> NDArray[np.float64]:
        """Reduced state after one step from the working point plus `change`, as a difference from the working point."""
        nv, model, state = self.nv, self.s.model, self.s.state
        self.data.qpos[:] = self.qpos
        mujoco.mj_integratePos(model, self.data.qpos, change[:nv], 1.0)
        self.data.qvel[:] = self.qvel + change[nv : 2 * nv]
        for part, kept in zip(state, self.state, strict=True):
            part[...] = kept
        state.tyres[:, SHEAR_X] += change[2 * nv : 2 * nv + 4]
        state.tyres[:, SHEAR_Y] += change[2 * nv + 4 :]
        w = self.s.window
        loop.run(
            self.s.views,
            self.s.index,
            self.constants,
            state,
            w.heights,
            w.origin,
            (1e9, 1e9),
            self.rows,
            self.poses,
            1 << 30,
        )
        out = np.empty(self.size)
        mujoco.mj_differentiatePos(model, out[:nv], 1.0, self.qpos, self.data.qpos)
        out[nv : 2 * nv] = self.data.qvel - self.qvel
        out[2 * nv : 2 * nv + 4] = state.tyres[:, SHEAR_X] - self.state[loop.State._fields.index("tyres")][:, SHEAR_X]
        out[2 * nv + 4 :] = state.tyres[:, SHEAR_Y] - self.state[loop.State._fields.index("tyres")][:, SHEAR_Y]
        return out

    def restore(self) -> None:
        self.data.qpos[:], self.data.qvel[:] = self.qpos, self.qvel
        for part, kept in zip(self.s.state, self.state, strict=True):
            part[...] = kept


def modes(simulation: Simulation) -> list[Mode]:
    """Every oscillation of the car at its present state (a drive on a flat road, settled), slowest first."""
    step = _Step(simulation)
    nv = step.nv
    jacobian = np.empty((step.size, step.size))
    for i in range(step.size):
        change = np.zeros(step.size)
        change[i] = _SMALL
        jacobian[:, i] = (step(change) - step(-change)) / (2.0 * _SMALL)
    step.restore()
    mass = np.empty((nv, nv))
    mujoco.mj_forward(simulation.model, simulation.data)
    for column, unit in zip(mass, np.eye(nv), strict=True):
        mujoco.mj_mulM(simulation.model, simulation.data, column, unit)
    values, vectors = np.linalg.eig(jacobian)
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag <= 1e-9 or abs(value) < 1.0 - _STIFFEST:
            continue
        s = np.log(value) / simulation.scenario.step
        shape = vector[nv : 2 * nv]
        energy = np.real(np.conj(shape) * (mass @ shape))
        found.append(Mode(abs(s) / (2.0 * np.pi), -s.real / abs(s), energy / energy.sum(), shape))
    return sorted(found, key=lambda mode: mode.frequency)


def rotational_modes(simulation: Simulation) -> dict[str, dict[str, Mode]]:
    """`in_phase` and `antiphase` by axle, `front` and `rear`: of each kind the lowest that has half of its energy in
    the turning of rims and belts (a higher one is the belt's fore-aft mode, which turns with it)."""
    nv_of = {
        name: [int(simulation.model.joint(f"{w}/{name}").dofadr[0]) for w in WHEELS] for name in ("spin", "belt_spin")
    }
    result: dict[str, dict[str, Mode]] = {"front": {}, "rear": {}}
    for mode in modes(simulation):
        for axle, wheels in (("front", (0, 1)), ("rear", (2, 3))):
            spins = [nv_of["spin"][w] for w in wheels]
            belts = [nv_of["belt_spin"][w] for w in wheels]
            if mode.frequency < 5.0 or mode.shares[spins].sum() + mode.shares[belts].sum() < 0.5:
                continue
            together = sum(np.real(mode.shape[r] * np.conj(mode.shape[b])) for r, b in zip(spins, belts, strict=True))
            kind = "in_phase" if together > 0.0 else "antiphase"
            result[axle].setdefault(kind, mode)  # modes come in order of frequency
    return result
