"""Tyre pressure from vibration: natural frequencies of the wheel's rotational modes, from its speed (SAE 2002-01-1250).

Interface for a fusion, `vibration.Vibration`, plain class without estimator's clothes:

    Vibration(car: Car).update(samples: Mapping[str, Signal], until: float) -> Heard(readings, flags)

readings: `wheel_vibration.Reading`s, per wheel and mode, `running` ones each second and independent `block` ones about
every 8 s with frequency, information of ln f from that block alone, mean speed, excitation. `modes.Mode` has the
sensitivity to pressure. `Vibration.calibration()` and `.use_calibration()` carry the learnt tooth rings.
"""
