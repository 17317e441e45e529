"""The page of an experiment with a design: a sweep is read by its effects and not cell by cell."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.experiment import Experiment
from gaitlab.papers.reproduction.document import Reproduction
from gaitlab.papers.reproduction.section import Section
from gaitlab.papers.reproduction.swept import compares_switches


def sweep_page(
    experiments: Sequence[Experiment], settings: Sequence[str] = (), seeds: int | None = None
) -> Reproduction | None:
    """A page with one section on the sensitivity; None for anything but one sweep with a switch.

    Args:
        experiments: What is asked for.
        settings: `path=value` each, as the experiment was read with.
        seeds: Number of replicates that was asked for.
    """
    if len(experiments) != 1 or not compares_switches(experiments[0]):
        return None
    (experiment,) = experiments
    options = [word for setting in settings for word in ("--set", setting)]
    return Reproduction(
        name=experiment.listed_as,
        title=experiment.title or experiment.name,
        description=experiment.description,
        path=experiment.path,
        members=(experiment,),
        sections=(_section(experiment.name),),
        options=(*options, *(() if seeds is None else ("--seeds", str(seeds)))),
    )


def _section(name: str) -> Section:
    return Section(
        kind="sensitivity",
        title="What was assumed, and what hangs on it",
        text="",
        experiments=(name,),
        options={"labels": {}},
    )
