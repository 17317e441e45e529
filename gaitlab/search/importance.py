"""Which parameters decide.

References:
    Watanabe2023: Watanabe et al., PED-ANOVA: Efficiently Quantifying Hyperparameter Importance in
        Arbitrary Subspaces, IJCAI 2023.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from math import isfinite

from gaitlab.search.candidates import History

FEWEST = 10  # candidates; of fewer the best tenth is one


def importance(history: History, objective: int = 0) -> Mapping[str, float]:
    """Share of each parameter in how the better candidates differ from all, [Watanabe2023].

    PED-ANOVA compares where the best tenth lies with where everything lies, one parameter at a
    time; it is blind to interactions, and to regions that the search left early. A candidate that
    has no value counts as bad as the worst that has one.

    Args:
        history: The search.
        objective: Position of the objective.

    Returns:
        Share by dotted path, the largest first; they add up to one. Empty if there are fewer than
        ten candidates, or none is better than the others.
    """
    import optuna
    from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
    from optuna.trial import create_trial

    from gaitlab.search.space import distributions

    values = [candidate.objectives[objective] for candidate in history.candidates]
    finite = [value for value in values if isfinite(value)]
    if len(values) < FEWEST or len(set(finite)) < 2:
        return {}
    study, direction = history.study, history.study.objectives[objective].direction
    worst = min(finite) if direction == "maximize" else max(finite)
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        memory = optuna.create_study(direction=direction)
        for candidate, value in zip(history.candidates, values, strict=True):
            trial = create_trial(
                params=dict(candidate.values),
                distributions=distributions(study, candidate.values),
                value=value if isfinite(value) else worst,
            )
            memory.add_trial(trial)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = get_param_importances(memory, evaluator=PedAnovaImportanceEvaluator())
    finally:
        optuna.logging.set_verbosity(before)
    return {path: float(share) for path, share in found.items() if isfinite(share)}
