"""The hyperparameters of the continual-learning methods, in one table. Those of TRPO are the reference's.

No penalty depends on the scale of rewards or observations. Its coefficient is the same for all groups;
docs/learners.md has the measurements.
"""

from __future__ import annotations

L2 = 0.1  # docs/learners.md
L2_INIT = 0.01  # docs/learners.md
EWC = 0.1  # docs/learners.md
EWC_DECAY = 0.95  # this project, for γ of Schwarz et al. 2018
CLONING = 0.1  # docs/learners.md
STATES_PER_TASK = 1_000  # this project; the code of Wolczyk et al. 2021 uses 2,560 for EWC
PACKNET_RETRAIN_SHARE = 0.2  # this project; Wolczyk et al. 2021 retrain on stored transitions instead
