"""Study `vertical-pressure`: tyre pressure from hub and body accelerometers. Brancati & Tufano, Machines 2022, 10,
1221, Tables 2 to 4, Figures 5 to 13: what the published filters tell, with which road, and what can be told at all.

Drives of the multibody car on roads, seeds and levels that no identification saw (`tasks`). Rows by method:

    single_ukf, imm_ukf_oracle, imm_ukf_synthetic, imm_ukf_state    the published filters by their road, see `published`
    bank                         the estimator `vertical_pressure`: a bank of linear filters over stiffness and level
    axles                        both axles over the same road; `difference_rmse_pct_2s`: ln k_front / k_rear of a side
    bound, axles_bound           limit of every RMSE: Cramer-Rao with the prior, see `limits`, `limits_of_axles`

    METHOD.rmse_kpa_2s, _10s, _60s     integer classes (Table 4); `_levels`: levels between; `_wrong`: the same drives,
                                       estimators told masses, stiffnesses, lengths off by up to 10 %, the law by 20 %
    METHOD.bias_kpa_10s                worst of the classes, levels and short drives counted to the nearest; each class
                                       in `_class_X`
    METHOD.nees_10s                    mean squared error in reported variances: 1
    bank.rmse_over_bound_10s, bank.nees_10s_all    over all drives that know rightly, short ones too
    changes, load, measured road       see `changes`; Table 3: `identified_rows`
    axles.detect_15pct_1_tyre_p95_s    one low tyre named at one false alarm in 100 h, see `axle_alarm`
    METHOD.waviness_X_bias_kpa         over roads of one other slope, see `waviness`; waviness_X.believer_bias_kpa: who
                                       believes in slope -2 there

Bank and `axles` are told that pressures lie between 130 and 230 kPa, by mean and std; the published filters begin at a
draw of std 30 kN/m, 43 kPa, about the truth, as published. Their numbers for what the paper does not state (P_0, Q) are
declared in `estimators/unscented_imm/settings.py`. In Figures 7 and 8 the paper's modes part; here they cannot: 3 % of
each goes over into the others at every step of 1 ms.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from testbed.study.study import Row, Study, StudyRow, Task
from testbed.study.vertical_pressure import changes, errors, identified_rows, waviness
from testbed.study.vertical_pressure.axle_alarm import alarm_table
from testbed.study.vertical_pressure.tasks import tasks
from testbed.study.vertical_pressure.work import work

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class VerticalPressureStudy(Study):
    name = "vertical-pressure"
    about = "What do hub and body accelerometers tell of a tyre's pressure in 2, 10 and 60 s, on a road nobody knows?"
    paper = "Brancati, Tufano, Machines 2022, 10, 1221, Tables 2 to 4, Figures 5 to 13."
    runs = 100
    data = Path(__file__).resolve().parents[4] / "shared" / "data" / "iri_utia_profile_1.txt"

    @property
    def work(self) -> Callable[[Task], Row]:
        return work

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        measured = self.data if self.data is not None and self.data.is_file() else None
        return [task for number in range(runs) for task in tasks(seed, number, small, measured)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        drives = errors.decoded(rows)
        scored = [drive for drive in drives if drive["task"]["kind"] != "fit"]
        return [
            *errors.table(scored), *changes.table(scored), *alarm_table(rows), *waviness.table(scored),
            *identified_rows.table(),
        ]  # fmt: skip

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.vertical_pressure.figures import figures  # matplotlib, only where something is drawn

        return figures(errors.decoded(rows))
