"""Variants of several members side by side, as the results of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import pandas as pd

from gaitlab.errors import UsageError, WrongValue
from gaitlab.papers.printed import eros_tables
from gaitlab.plugins import suggestion
from gaitlab.report.cells import STEP
from gaitlab.report.results import Results
from gaitlab.report.variants import Variant

PRINTED = "printed distance"  # column that stands for the step length where readings of it differ


@dataclass(frozen=True, kw_only=True, eq=False)
class Shown:
    """A variant of a member.

    Attributes:
        label: What the page calls it; no two of a section are called alike.
        experiment: Name of the member.
        results: Of the member.
        variant: As the member has it.
    """

    label: str
    experiment: str
    results: Results
    variant: Variant

    @property
    def names(self) -> tuple[str, ...]:
        """What a file can call it by: with its member, alone, or by its label."""
        return (f"{self.experiment}/{self.variant.label}", self.variant.label, self.label)


def shown_variants(
    results: Mapping[str, Results], experiments: Sequence[str], labels: Mapping[str, str]
) -> list[Shown]:
    """Every variant of the members, in their order, no two called alike.

    Args:
        results: Of each member by name.
        experiments: Members that are shown.
        labels: Words for a variant, under `member/variant` or `variant`, and for a member, under
            its name: those stand in front of a label that variants of several members share, and
            are, as without them the member's name, the label of a member's only variant.
    """
    pairs = [(name, variant) for name in experiments for variant in results[name].variants]
    plain = []
    for name, variant in pairs:
        alone = labels.get(name, name) if len(results[name].variants) == 1 else None
        found = labels.get(f"{name}/{variant.label}") or alone or labels.get(variant.label)
        plain.append(found or variant.label)
    return [
        Shown(
            label=own if plain.count(own) == 1 else f"{labels.get(name, name)}: {own}",
            experiment=name,
            results=results[name],
            variant=variant,
        )
        for (name, variant), own in zip(pairs, plain, strict=True)
    ]


def require_labels(shown: Sequence[Shown], names: Iterable[str]) -> None:
    """Refuse words for what there is not.

    Raises:
        WrongValue: If no variant and no member has one of the names.
    """
    known = {one.experiment for one in shown}
    known |= {name for one in shown for name in one.names[:2]}
    for name in names:
        if name not in known:
            raise WrongValue(f"labels: found {name!r}{suggestion(name, sorted(known))}")


def called(shown: Sequence[Shown], name: str, beside: Shown | None = None) -> Shown:
    """The variant of a name, the one of the same member first if several have it.

    Raises:
        WrongValue: If none has it; names those there are.
    """
    fitting = [one for one in shown if name in one.names]
    if not fitting:
        known = list(dict.fromkeys(one.names[0] for one in shown))
        raise WrongValue(f"no variant is called {name!r}{suggestion(name, known)}")
    near = (one for one in fitting if beside and one.experiment == beside.experiment)
    return next(near, fitting[0])


def together(shown: Sequence[Shown]) -> Results:
    """One table of trials with a variant for each that is shown.

    Rows are the members' own; where the members read a printed distance differently they are the
    printed distances, so that like stands beside like.

    Raises:
        UsageError: If the members have different rows or columns.
    """
    first = shown[0].results
    _require_one_layout(shown)
    differ = len({one.results.reading for one in shown}) > 1
    frames = [_frame(one, differ) for one in shown]
    variants = [replace(one.variant, label=one.label) for one in shown]
    return replace(
        first,
        rows=PRINTED if differ else first.rows,
        variants=tuple(variants),
        trials=pd.concat(frames, ignore_index=True),
        units={path: unit for one in reversed(shown) for path, unit in one.results.units.items()},
    )


def _require_one_layout(shown: Sequence[Shown]) -> None:
    first = shown[0]
    for other in shown[1:]:
        for key in ("rows", "columns"):
            here, there = (getattr(one.results, key) for one in (first, other))
            if here != there:
                raise UsageError(
                    f"{first.experiment} has {key} {here!r} and {other.experiment} {there!r}; "
                    f"variants share a section when these agree: set report.{key} in one of them"
                )


def _frame(one: Shown, differ: bool) -> pd.DataFrame:
    """Trials of a variant, their rows by printed distance if asked for."""
    trials = one.results.of(one.variant).assign(variant=one.label)
    if not differ or one.results.rows != STEP:
        return trials
    printed = (
        trials[STEP].astype(float) / eros_tables()[0].readings[one.results.reading].one
    ).round(6)
    return trials.assign(**{PRINTED: printed}).drop(columns=STEP)
