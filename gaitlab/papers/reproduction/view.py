"""A reproduction to look at: its page in HTML, which leads to cells and walks of each member."""

from __future__ import annotations

from pathlib import Path

from gaitlab.documents.steps import step
from gaitlab.experiment.plan import plan
from gaitlab.papers.reproduction.document import Reproduction
from gaitlab.papers.reproduction.page import write_reproduction
from gaitlab.papers.reproduction.swept import compares_switches
from gaitlab.report.forms import REPORTS
from gaitlab.report.forms.html import FILE
from gaitlab.report.view import Viewed, write_view
from gaitlab.store import Store


def view_reproduction(
    reproduction: Reproduction, store: Store, output: Path | None = None, *, force: bool = False
) -> tuple[Path, list[Viewed]]:
    """Write the page of a reproduction in HTML, and in a folder each what its members show.

    Args:
        reproduction: What was asked.
        store: Where the trials are; members of which nothing was run are left out, and sweeps of
            a box, whose section on the page says what their thousands of walks come to.
        output: Folder; by default `reports/<name>`.
        force: Also replace files that gaitlab did not write.

    Returns:
        The page, and what was written of each member.

    Raises:
        NothingRun: If the store holds no trial of any member.
        UsageError: If a file is there that gaitlab did not write.
        StoreError: If a log is damaged, or a file cannot be written.
    """
    folder = output or REPORTS / reproduction.name
    done = store.states()
    walked = [
        member
        for member in reproduction.members
        if not compares_switches(member)
        and any(item.trial.id in done for item in plan(member).trials())
    ]
    links = {member.name: f"{member.name}/{FILE}" for member in walked}
    page = write_reproduction(reproduction, store, folder, html=True, force=force, links=links)
    views = []
    for number, member in enumerate(walked, start=1):
        step(f"{member.name}, {number} of {len(walked)}")
        views.append(write_view(member, store, folder / member.name, force=force))
    return page, views
