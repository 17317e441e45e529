"""How the answers to a paper's printed tables agree with it by other counts, and with each other.

The order of the grounds, strict scores, every way to count the efficiency, and what two engines
tell differently.
"""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.papers.reproduction.answers import agreement, answers, forward_only
from gaitlab.papers.reproduction.efficiency import Simulated, claims, differing
from gaitlab.papers.reproduction.headline import (
    Scored,
    count_text,
    efficiencies,
    engines_agree,
    order_sentence,
    scored,
)
from gaitlab.papers.reproduction.section import Context, Section
from gaitlab.report.agreement import agreement_blocks
from gaitlab.report.markdown import escape, table
from gaitlab.report.words import interval, percent

STRICT = """\
*Strict* counts a walk as stable only if it also covered half of the commanded distance; the paper
asks for no fall alone."""
CLAIMS = """\
The text states 32 → 80 %; counting the printed cells gives 50 → 80 %. With 0, 0, 0 and 2 stable
backward rows in Table 7 the same counting gives the pedestals' stated 10, 10, 30 and 80 %, which
suggests that its backward block was printed from Table 8; nothing in the paper proves it. The
intervals are of the seeds alone, cells taken as independent."""


def agreement_section(section: Section, context: Context) -> str:
    """Order of the grounds, strict scores, efficiencies and the engines' agreement, as Markdown."""
    columns = scored(answers(context.results, section.experiments, context.experiments), {})
    columns = [one for one in columns if one.cells]
    engines = engines_agree(columns)
    told = (
        agreement_blocks(columns[0].side.answers[0].results, engines)[1:]  # the first is in front
        if engines
        else []
    )
    blocks = [
        _orders(columns),
        _strict(columns),
        STRICT,
        _efficiency(columns),
        *_missing(columns),
        *told,
    ]
    return "\n\n".join(block for block in blocks if block)


def _orders(columns: Sequence[Scored]) -> str:
    """How each column orders the grounds, a line a table."""
    told = (
        (one.side.label, order_sentence(answer, [c for c in one.cells if c.table is answer.table]))
        for one in columns
        for answer in one.side.answers
    )
    return "\n".join(f"- {escape(label)}, {text}" for label, text in told if text)


def _strict(columns: Sequence[Scored]) -> str:
    """All cells as printed, by both scores."""
    rows = [
        [
            f"{escape(one.side.label)}: {answer.table.title}",
            *(count_text(agreement(cells, score)) for score in ("stable", "stable_strict")),
        ]
        for one in columns
        for answer in one.side.answers
        if (cells := [cell for cell in one.cells if cell.table is answer.table])
    ]
    return table(["all cells as printed [95 %]", "stable", "strict"], rows, "l")


def _efficiency(columns: Sequence[Scored]) -> str:
    """The paper's percentages under every way of counting, and ours over all and forward rows."""
    rows = [
        [
            f"paper, {c.name}",
            f"{c.without:.3g} %",
            f"{c.with_:.3g} %",
            f"{c.with_ - c.without:+.3g}",
        ]
        for c in claims()
    ]
    paired = True
    for one in columns:
        if len(one.side.answers) != 2:
            continue
        label = f"**{escape(one.side.label)}"
        ours = efficiencies(*one.side.answers)
        paired = paired and ours.paired
        rows.append(_simulated_row(f"{label}, all rows**", ours))
        forward = [forward_only(answer) for answer in one.side.answers]
        if all(
            len(part.results.trials) < len(whole.results.trials)
            for part, whole in zip(forward, one.side.answers, strict=True)
        ):
            rows.append(_simulated_row(f"{label}, forward rows**", efficiencies(*forward)))
    if len(rows) == len(claims()):
        return ""
    head = ["efficiency", "without [95 %]", "with [95 %]", "gain, points [95 %]"]
    pairs = "drawn in pairs of equal cell and seed" if paired else "without common seeds"
    return f"{table(head, rows, 'l')}\n\n{CLAIMS} That of a gain is {pairs}."


def _missing(columns: Sequence[Scored]) -> list[str]:
    """Which cells make the gain another one than the printed; columns with the same together."""
    alike: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for one in columns:
        found = differing(one.cells) if len(one.side.answers) == 2 else []
        if found:
            total = sum(each.points for each in found)
            rows = [(each.text, f"{each.points:+.3g}") for each in found]
            label = escape(one.side.label)
            alike.setdefault((*rows, ("all", f"{total:+.3g}")), []).append(label)
    return [
        table(
            [
                f"{' and '.join(labels)}, cells otherwise than printed",
                "gain less the printed [points]",
            ],
            rows,
            "lr",
        )
        for rows, labels in alike.items()
    ]


def _simulated_row(name: str, found: Simulated) -> list[str]:
    return [
        name,
        f"{percent(found.without)} {interval(found.without_interval)}",
        f"{percent(found.with_)} {interval(found.with_interval)}",
        f"{found.gain:+.0f} {interval(found.gain_interval)}",
    ]
