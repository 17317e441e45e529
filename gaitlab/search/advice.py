"""What a search found that a user should act on: edges of ranges, and nothing that is allowed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from math import log

from gaitlab.experiment.study import Numbers, Study
from gaitlab.search import Candidate, History
from gaitlab.search.objectives import misses
from gaitlab.search.tally import missed_by, nearest_misses

NEAR = 0.05  # of its range; a value so close to an end asks for a wider range
NEAREST = 5  # misses that are looked at
SHOWN = 3


def edges(study: Study, candidate: Candidate) -> dict[str, str]:
    """Searched numbers of a candidate that lie at an end of their range, and at which."""
    found = {}
    for item in study.search:
        value = candidate.values.get(item.path)
        if isinstance(item, Numbers) and isinstance(value, int | float):
            share = _share(item, float(value))
            if share <= NEAR:
                found[item.path] = f"lower end {item.low:g}"
            elif share >= 1.0 - NEAR:
                found[item.path] = f"upper end {item.high:g}"
    return found


def _share(item: Numbers, value: float) -> float:
    if item.log:
        return log(value / item.low) / log(item.high / item.low)
    return (value - item.low) / (item.high - item.low)


def nothing_allowed(history: History) -> list[str]:
    """Lines about a search in which no candidate is both finished and allowed."""
    candidates = history.candidates
    if not candidates or history.front:
        return []
    return [
        *_what_happened(candidates),
        *_misses(history),
        *_widen(history.study, nearest_misses(candidates, NEAREST)),
    ]


def _what_happened(candidates: Sequence[Candidate]) -> Iterator[str]:
    stuck = [candidate for candidate in candidates if candidate.state == "infeasible"]
    yield f"No candidate of {len(candidates)} fulfils what the study asks for."
    if stuck:
        yield f"{len(stuck)} of them cannot be walked at all; the commonest reason:"
        reasons = Counter(candidate.reason for candidate in stuck)
        yield f"  {reasons.most_common(1)[0][0]}"


def _misses(history: History) -> Iterator[str]:
    yield "Nearest misses, in brackets by how much, 1 being the size of the bound:"
    for candidate in nearest_misses(history.candidates, SHOWN):
        values = ", ".join(f"{path} = {value}" for path, value in candidate.values.items())
        broken = misses(history.study, candidate.objectives, candidate.violations)
        yield f"  candidate {candidate.number}: {values}"
        yield f"    misses {'; '.join(broken)}"


def _widen(study: Study, nearest: Sequence[Candidate]) -> Iterator[str]:
    if not nearest or missed_by(nearest[0]) == 0.0:
        return
    ends = Counter(end for candidate in nearest for end in edges(study, candidate).items())
    if not ends:
        relax = "relax a constraint, or " if study.constraints else ""
        yield f"None of them lies at an end of a range: {relax}search another one."
    for (path, end), count in ends.most_common(SHOWN):
        yield f"Widen {path}: {count} of the {len(nearest)} nearest lie at its {end}."
