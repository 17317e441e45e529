"""Pages of what experiments and studies found: Markdown with figures beside it, and other forms.

Numbers come from the rooms that compute them (`statistics`, `search`, `store`); what knows a paper
is in `gaitlab.papers`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from gaitlab.documents.steps import expect, step
from gaitlab.errors import UsageError
from gaitlab.experiment import Experiment
from gaitlab.report.forms import REPORTS, publish
from gaitlab.report.forms.explorer import CellExplorer, replays_beside
from gaitlab.report.gather import gather
from gaitlab.report.page import write_page
from gaitlab.report.sources import sources
from gaitlab.store import Store

__all__ = ["write_report"]


def write_report(
    experiments: Sequence[Experiment],
    store: Store,
    output: Path | None = None,
    *,
    html: bool = False,
    tables: bool = False,
    force: bool = False,
    replays: Mapping[str, str] | None = None,
) -> Path:
    """Write the report of one or several experiments; the same store gives the same bytes.

    Args:
        experiments: What was asked. Several share one page, each adding its variants.
        store: Where the trials are.
        output: Folder of the page and its figures; by default `reports/<names>`.
        html: Also write the page as one file of HTML.
        tables: Also write every table as LaTeX and CSV.
        force: Also write into a folder that holds files of somebody else.
        replays: Link to the replay of a trial by its id, relative to the page in HTML; by default
            to those that lie beside it, `replays/ID.html`.

    Returns:
        The page, in HTML if that was asked for.

    Raises:
        UsageError: If there is no experiment, none of its trials was run, or the experiments
            cannot share a page.
        UnknownName: If `report.compare` is no reference table.
    """
    if not experiments:
        raise UsageError("a report needs at least one experiment; `gaitlab list experiments`")
    for experiment in experiments:
        store.require_one_file(experiment)
    expect(1)
    step(f"reading the trials of {' and '.join(e.listed_as for e in experiments)}")
    results = gather(experiments, store)
    folder = output or REPORTS / "+".join(one.listed_as for one in experiments)
    where = sources(experiments, store, results)
    if replays is None:
        replays = replays_beside(folder, list(map(str, results.trials["trial_id"])))
    return publish(
        folder,
        partial(write_page, results, where),
        html=html,
        tables=tables,
        force=force,
        results=results,
        explorer=CellExplorer(results=results, replays=replays, options=where.options),
    )
