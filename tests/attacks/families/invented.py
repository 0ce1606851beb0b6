"""Attacks with invented returns, and with digests and roots that hide them."""

from __future__ import annotations

from ..attack import REPLAYED, REPRODUCED, Attack
from ..forgeries.chosen_cells import (
    all_above,
    all_but_largest,
    before_training,
    later_ends,
    later_runs,
    missed,
    sequential,
)
from ..forgeries.edited_log import fewer, first_row, log_only, other_root
from ..forgeries.invented import (
    add,
    best_trace_everywhere,
    episodes_of_the_other_task,
    ground,
    in_cells,
    in_rows,
    invented_without_traces,
    later_runs_without_traces,
    one_episode,
    scale,
    scale_log,
    two_largest,
    without_commitment,
)
from ..judge import submission

ATTACKS = (
    Attack(
        "Two of 20 episodes of every cell are invented above all others.",
        submission(in_cells(two_largest)),
        "replay: trace-missing",
        quick=True,
    ),
    Attack(
        "Ten of 20 are invented below the largest; a digit is changed until the sample misses them.",
        submission(ground),
        "salted replay: trace-missing",
        quick=True,
    ),
    Attack(
        "All returns are invented, without traces.",
        submission(invented_without_traces),
        "board: 14 of 14 traces of the audit sample are missing.",
        quick=True,
    ),
    Attack(
        "All returns are invented in a log of the old form, without digests of traces.",
        submission(without_commitment),
        "board: The log does not commit to traces.",
        quick=True,
    ),
    Attack(
        "All returns are halved in the log; the digests stay.",
        submission(log_only(lambda row: row.update({"return": repr(float(row["return"]) / 2)}))),
        "replay: trace-malformed, trace-missing",
    ),
    Attack(
        "All returns are scaled by 1.1 in the log, with digests to match.",
        submission(in_rows(lambda forger, row: scale_log(forger, row, 1.1))),
        "replay: trace-malformed",
    ),
    Attack(
        "All returns are scaled by 1.1 in the log and in the traces.",
        submission(in_rows(lambda forger, row: scale(forger, row, 1.1))),
        "replay: replay-differs",
        quick=True,
    ),
    Attack(
        "A bonus of 50 is added to the first segment of every trace.",
        submission(in_rows(lambda forger, row: add(forger, row, 50.0))),
        "replay: replay-differs",
    ),
    Attack(
        "A bonus of 0.001 is added to the first segment of every trace.",
        submission(in_rows(lambda forger, row: add(forger, row, 1e-3))),
        "replay: replay-differs",
    ),
    Attack(
        "All returns are raised by a ten-millionth, less than the tolerance of replay.",
        submission(in_rows(lambda forger, row: scale(forger, row, 1 + 1e-7))),
        "not detected",
        REPRODUCED,
        REPRODUCED,
        "Nothing: the gain is below any difference on a board.",
    ),
    Attack(
        "The trace of the best episode of a cell is used for all of its episodes.",
        submission(in_cells(best_trace_everywhere)),
        "replay: replay-differs",
    ),
    Attack(
        "The episodes of one task are presented as those of another.",
        submission(episodes_of_the_other_task),
        "replay: replay-differs",
    ),
    Attack(
        "All cells R[s][j] with 0 < s < j are invented.",
        submission(sequential(before_training, all_above)),
        "replay: trace-missing",
    ),
    Attack(
        "All episodes of the cells R[s][j] with 0 < s < j but the largest are invented below it.",
        submission(sequential(before_training, all_but_largest)),
        "replay: trace-missing",
    ),
    Attack(
        "Two of 20 episodes of the cells R[s][j] with 0 < s < j are invented below the largest, and the salt "
        "draws none of them.",
        submission(missed(before_training, 2)),
        "repetition: differs",
        REPLAYED,
        REPLAYED,
        "Of an entry that cannot be repeated, a replay of all traces. Per stage and run, one of their "
        "episodes is drawn at most: with five runs, the probability of such a sample is 30 % for five tasks, "
        "68 % for two. Final performance does not use these cells.",
    ),
    Attack(
        "All episodes of R[s][s] and R[T][j] of the runs from 2 on but the largest are invented below it.",
        submission(sequential(later_runs, all_but_largest)),
        "replay: trace-missing",
    ),
    Attack(
        "Five of 20 episodes of R[s][s] and R[T][j] of the runs from 2 on are invented below the largest, "
        "and the salt draws none of them.",
        submission(missed(later_runs, 5)),
        "repetition: differs",
        REPLAYED,
        REPLAYED,
    ),
    Attack(
        "One of 20 episodes of R[T][1] of the runs from 2 on is invented above all others, and the salt "
        "draws another episode of each of these cells.",
        submission(missed(later_ends, 1, above=300.0)),
        "repetition: differs",
        REPLAYED,
        REPLAYED,
        "Of an entry that cannot be repeated, a replay of all traces. In runs from 2 on the drawn episode "
        "takes the place of the largest return of its cell: the probability of such a sample is 1/5 per run "
        "for five tasks, 1/2 for two. Each adds a twentieth of its excess to the mean of a cell.",
    ),
    Attack(
        "All returns of the runs from 2 on are invented, and these runs have no traces.",
        submission(later_runs_without_traces),
        "board: 6 of 14 traces of the audit sample are missing.",
        quick=True,
    ),
    Attack(
        "One episode of the log is invented, below the largest of its cell.",
        submission(one_episode),
        "not detected",
        REPRODUCED,
        REPRODUCED,
        "A replay of the archive of all traces. The level states how many of the episodes were replayed.",
    ),
    Attack(
        "A return is beyond what the task can give.",
        submission(first_row(**{"return": "1000000.0"})),
        "rules: impossible-return",
        quick=True,
    ),
    Attack(
        "A return is infinite.", submission(first_row(**{"return": "inf"})), "rules: not-finite", quick=True
    ),
    Attack(
        "An episode has more steps than the time limit.",
        submission(first_row(length="1001")),
        "rules: impossible-length",
        quick=True,
    ),
    Attack(
        "A fall is logged as the end of an episode that goes on.",
        submission(log_only(lambda row: row.update(terminated="false"))),
        "rules: unfinished-episode",
        quick=True,
    ),
    Attack(
        "The lengths of the log are one step longer.",
        submission(log_only(lambda row: row.update(length=str(int(row["length"]) + 1)))),
        "replay: trace-malformed, trace-missing",
    ),
    Attack(
        "The five worst episodes of every cell are left out.",
        submission(fewer),
        "rules: missing-cell",
        quick=True,
    ),
    Attack("The manifest states another root.", submission(other_root), "rules: different-root", quick=True),
    Attack(
        "A seed of the log is another one.",
        submission(first_row(seed="1")),
        "rules: wrong-seed",
        quick=True,
    ),
    Attack(
        "The fingerprint is that of another model.",
        submission(log_only(lambda row: row.update(fingerprint="0" * 16))),
        "rules: foreign-fingerprint",
        quick=True,
    ),
)
