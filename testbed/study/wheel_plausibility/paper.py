"""Figures of the thesis (Razavi, Lund 2006, Tables 6.2 to 6.4 and 6.9 to 6.12).

CONSTANT: seconds to the first accusation of a constant error [km/h] in one wheel or two, by method; None where the
thesis has none. RESIDUALS: means [km/h] in the order of the six and the seven residuals, by geometry."""

_ERRORS = ("4", "6", "13", "20", "50", "13+20", "15+13")


def _column(*seconds: float | None) -> dict[str, float | None]:
    return dict(zip(_ERRORS, seconds, strict=True))


CONSTANT = {
    "monitor": _column(None, None, None, None, None, None, None),
    "A": _column(56.24, 15.42, 6.38, 3.51, 1.11, 3.01, 6.63),
    "B": _column(30.61, 15.42, 5.80, 2.51, 0.84, 2.18, 5.74),
    "average": _column(20.52, 14.35, 4.85, 2.87, 1.19, 3.27, 5.83),
    "average_and_b": _column(None, None, None, None, None, None, None),
    "diagonal": _column(3.05, 1.95, 0.98, 0.71, 0.38, 1.68, 8.51),
}
RESIDUALS = {
    "none": (0.6422, 0.1733, 0.6974, 0.6816, 0.1777, 0.6215, 0.4700, 0.4627, 0.4476, 0.4602, 0.1622, 0.6301, 0.0347),
    "simple": (0.5924, 0.3389, 0.7319, 0.7422, 0.3677, 0.5902, 0.4800, 0.4998, 0.4916, 0.4974, 0.3501, 0.5887, 0.0460),
    "exact": (0.7852, 0.4342, 0.6675, 0.7052, 0.4586, 0.5937, 0.5479, 0.5624, 0.4939, 0.4906, 0.3412, 0.6447, 0.3888),
    "circle.none": (
        2.7121, 0.2842, 2.9927, 2.4280, 0.2805, 2.7085, 1.9963, 1.6199, 1.6174, 1.9939, 0.2824, 2.7103, 0.0081,
    ),
    "circle.simple": (
        0.2058, 0.8225, 0.6443, 1.0284, 0.8502, 0.1782, 0.4203, 0.6948, 0.6764, 0.4388, 0.8364, 0.1920, 0.0146,
    ),
    "circle.exact": (
        1.1607, 1.2354, 0.9323, 0.0747, 0.2283, 0.3030, 1.1095, 0.4381, 0.5377, 0.1337, 0.5035, 0.4288, 0.7318,
    ),
}  # fmt: skip
