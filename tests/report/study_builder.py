"""Findings of a made-up study, for the tests of its page: no robot walks."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Literal

import numpy as np

from gaitlab.experiment import Experiment, Value, load_experiment
from gaitlab.experiment.study import (
    Aggregate,
    Choices,
    Condition,
    Constraint,
    Numbers,
    Objective,
    Racing,
    Study,
)
from gaitlab.report.study.findings import Findings
from gaitlab.search import Candidate
from gaitlab.search.fresh import DEFAULT, RANDOM, WINNER, Rerun
from gaitlab.search.margins import Margin, Margins, Reach, Switch
from gaitlab.search.objectives import TrialOutcome

GROUNDS = ("carpet_4mm", "hard_floor", "grass_10mm", "grass_30mm", "grass_50mm")
TUNED = "carpet_4mm"
SPEED = Objective(metric="walking_speed", direction="maximize")
SWAY = Objective(metric="roll_amplitude", direction="minimize")
SEARCH = (
    Numbers(path="gait.step_length", low=0.01, high=0.08),
    Numbers(path="gait.step_height", low=0.01, high=0.06),
    Numbers(path="gait.tick_increment", low=0.03, high=0.12, log=True),
    Choices(path="gait.heel_strike", options=("none", "add")),
    Numbers(
        path="gait.trunk_pitch",
        low=0.0,
        high=0.2,
        when=Condition(path="gait.heel_strike", values=("add",)),
    ),
)


def study(objectives: tuple[Objective, ...] = (SPEED,)) -> Study:
    bound = Constraint(
        metric="stable", bound=0.75, at_least=True, over_surfaces=Aggregate(kind="worst")
    )
    return Study(
        sampler="tpe",
        sampler_options={},
        trials=40,
        seed=0,
        batch=8,
        search=SEARCH,
        objectives=objectives,
        constraints=(bound,),
        racing=Racing(rounds=(2, 4, 8)),
        early_stop=None,
    )


def toy_experiment(objectives: tuple[Objective, ...] = (SPEED,)) -> Experiment:
    read = load_experiment("eros_quick", ["surfaces=[carpet_4mm]"], seeds=8)
    title = "EROS on carpet: fastest gait"
    return replace(read, name="toy_study", title=title, axes=(), study=study(objectives))


def tried(count: int = 40, objectives: int = 1) -> list[Candidate]:
    """Candidates that get better; every seventh cannot be walked, every third is given up."""
    generator = np.random.default_rng(1)
    found = []
    for number in range(count):
        values: dict[str, Value] = {
            item.path: float(generator.uniform(item.low, item.high))
            for item in SEARCH[:3]
            if isinstance(item, Numbers)
        }
        values["gait.heel_strike"] = "add" if number % 2 else "none"
        if number % 2:
            values["gait.trunk_pitch"] = float(generator.uniform(0.0, 0.2))
        state: Literal["done", "pruned", "infeasible"] = "done"
        if number % 7 == 6:
            state = "infeasible"
        elif number % 3 == 1:
            state = "pruned"
        speed = 2.0 * float(str(values["gait.step_length"])) - 0.05 * float(generator.random())
        broken = 0.4 - 0.02 * number if number < 20 else -0.3
        numbers = (speed, 0.3 - speed + 0.05 * float(generator.random()))[:objectives]
        found.append(
            Candidate(
                number=number,
                values=values,
                state=state,
                objectives=() if state == "infeasible" else numbers,
                violations=(inf,) if state == "infeasible" else (broken, 0.0),
                feasible=state != "infeasible" and broken <= 0,
                seeds={"done": 8, "pruned": 2, "infeasible": 0}[state],
                trial_ids=(),
                batch=8 * (number // 8),
                simulated=0.0,
            )
        )
    return found


def walks(speed: float, falls: dict[str, int], seeds: int = 10) -> tuple[TrialOutcome, ...]:
    """Trials on every ground, of which the first seeds fall; the others differ a little."""
    found = []
    for ground in GROUNDS:
        for seed in range(seeds):
            up = seed >= falls.get(ground, 0)
            metrics: dict[str, float | bool | int | str | None] = {
                "stable": up,
                "fell": not up,
                "walked_time": 6.0 if up else 1.0 + seed,
                "walking_speed": speed + 0.002 * ((seed * 7) % 5),
                "roll_amplitude": 0.1 + 0.001 * seed,
            }
            seed_id = 1_000_000 + seed
            found.append(
                TrialOutcome(
                    trial_id=f"{ground}-{seed}",
                    surface=ground,
                    seed=seed_id,
                    state="DONE",
                    metrics=metrics,
                )
            )
    return tuple(found)


def toy_margins() -> Margins:
    numbers = (
        Margin(
            path="gait.step_length",
            value=0.075,
            below=Reach(holds=0.01, fails=None, ending="no fall found"),
            above=Reach(holds=0.08, fails=0.084, ending="fell"),
        ),
        Margin(
            path="gait.step_height",
            value=0.03,
            below=Reach(holds=0.029, fails=0.0281, ending="fell"),
            above=Reach(holds=0.045, fails=0.05, ending="out of reach"),
        ),
        Margin(
            path="gait.tick_increment",
            value=0.06,
            below=Reach(holds=0.05, fails=0.047, ending="fell"),
            above=Reach(holds=0.1, fails=None, ending="limit of the parameter"),
        ),
    )
    switch = Switch(path="gait.heel_strike", value="none", holds={"add": False})
    return Margins(numbers=numbers, switches=(switch,), seeds=4)


def toy_findings(objectives: tuple[Objective, ...] = (SPEED,), baseline: bool = True) -> Findings:
    """A study that found something."""
    experiment = toy_experiment(objectives)
    candidates = tried(objectives=len(objectives))
    good = [c for c in candidates if c.feasible and c.state == "done"]
    good.sort(key=lambda c: -c.objectives[0])
    front = tuple(good[:1]) if len(objectives) == 1 else tuple(good[:4])
    chosen = front[len(front) // 2]
    reruns = [
        Rerun(label=WINNER, values=chosen.values, walks=walks(0.12, {"grass_50mm": 9})),
        Rerun(label=DEFAULT, values={}, walks=walks(0.06, {"grass_50mm": 10, "grass_30mm": 4})),
    ]
    if baseline:
        reruns.append(Rerun(label=RANDOM, values={}, walks=walks(0.119, {"grass_50mm": 7})))
    shares = {"gait.step_length": 0.6, "gait.step_height": 0.25, "gait.heel_strike": 0.15}
    return Findings(
        experiment=experiment,
        candidates=candidates,
        best=chosen if len(objectives) == 1 else None,
        front=front,
        chosen=chosen,
        importance=[shares] * len(objectives),
        used=900.0,
        planned=2400.0,
        wall=180.0,
        defaults={item.path: experiment.parts.base_values(item.path)[0] for item in SEARCH},
        reruns=tuple(reruns),
        margins=toy_margins(),
        drawn=40 if baseline else 0,
        called="toy_study",
        facts={"study": "digest `abc`", "sampler": "tpe"},
        commands=["gaitlab optimize toy_study", "gaitlab report toy_study"],
    )


def hopeless() -> Findings:
    """A study in which nothing is good enough."""
    found = toy_findings()
    spoilt = [replace(c, feasible=False, violations=(0.5, 0.1)) for c in tried()]
    return replace(
        found, candidates=spoilt, best=None, front=(), chosen=None, reruns=(), margins=None
    )
