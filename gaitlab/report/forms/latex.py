"""A table of a page in LaTeX, with booktabs, as one pastes it into a paper."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from markdown_it.token import Token

from gaitlab.report.forms.tokens import PageTable, plain

LONG = 36  # characters; cells with more are broken into lines
NARROWEST, WIDEST = 0.12, 0.34  # of the width of the text, a column of broken lines
PACKAGES = "array,booktabs,graphicx"
FITTED = r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"
MANY_COLUMNS = 6  # from which on a table is set smaller

_ESCAPED = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "%": r"\%",
    "#": r"\#",
    "_": r"\_",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': "''",  # the plain sign is missing from TeX's first encoding, and active in German
    "`": r"\textasciigrave{}",
    "\u00a0": "~",
    "–": "--",
    "—": "---",
    "…": r"\ldots{}",
    "→": r"$\rightarrow$",
    "←": r"$\leftarrow$",
    "±": r"$\pm$",
    "×": r"$\times$",
    "·": r"$\cdot$",
    "≠": r"$\neq$",
    "≤": r"$\leq$",
    "≥": r"$\geq$",
    "≈": r"$\approx$",
    "−": "$-$",
    "°": r"\textdegree{}",
    "²": "$^2$",
    "³": "$^3$",
    "√": r"$\surd$",
    "∞": r"$\infty$",
    "∆": r"$\Delta$",
    "µ": r"$\mu$",
}
# Capitals that look like Latin ones have no command of their own.
_GREEK = (
    *(("α", "alpha"), ("β", "beta"), ("γ", "gamma"), ("δ", "delta"), ("ε", "epsilon")),
    *(("ζ", "zeta"), ("η", "eta"), ("θ", "theta"), ("κ", "kappa"), ("λ", "lambda"), ("μ", "mu")),
    *(("ν", "nu"), ("ξ", "xi"), ("π", "pi"), ("ρ", "rho"), ("σ", "sigma"), ("τ", "tau")),
    *(("φ", "varphi"), ("χ", "chi"), ("ψ", "psi"), ("ω", "omega"), ("Γ", "Gamma")),
    *(("Δ", "Delta"), ("Θ", "Theta"), ("Λ", "Lambda"), ("Σ", "Sigma"), ("Φ", "Phi")),
    *(("Ψ", "Psi"), ("Ω", "Omega"), ("Π", "Pi"), ("Ξ", "Xi")),
)
_SET = {**_ESCAPED, **{letter: f"$\\{name}$" for letter, name in _GREEK}}
_POWER = re.compile(r"(-?\d+(?:\.\d+)?)e([+-]?)0*(\d+)")
_MINUS = re.compile(r"(?<![\w.\-])-(?=\d)")
_OPENED = {"strong_open": r"\textbf{", "em_open": r"\emph{", "strong_close": "}", "em_close": "}"}


def text(words: str) -> str:
    """Words that LaTeX sets as they are written, numbers as numbers.

    Letters beyond those of European languages are left as they are; LuaLaTeX sets them.
    """
    parts, end = [], 0
    for found in _POWER.finditer(words):
        parts += [_escaped(words[end : found.start()]), _power(*found.groups())]
        end = found.end()
    return "".join([*parts, _escaped(words[end:])])


def _power(number: str, sign: str, exponent: str) -> str:
    return rf"${number}\times10^{{{sign.removeprefix('+')}{exponent}}}$"


def _escaped(words: str) -> str:
    return "".join(_SET.get(letter, letter) for letter in _MINUS.sub("−", words))


def cell(inline: Token) -> str:
    """A cell with its bold, slanted and typewriter parts."""
    return "".join(_parts(inline.children or ()))


def _parts(children: Sequence[Token]) -> Iterator[str]:
    for child in children:
        if child.type == "code_inline":
            # Breaks after an underline, else a long name runs into the next column.
            yield rf"\texttt{{{_escaped(child.content)}}}".replace(r"\_", r"\_\allowbreak{}")
        elif child.type in _OPENED:
            yield _OPENED[child.type]
        elif child.type in ("softbreak", "hardbreak"):
            yield " "
        elif child.type != "html_inline":
            yield text(child.content)


def latex_table(table: PageTable, caption: str, label: str, notes: Sequence[str]) -> str:
    """A floating table with its caption; lines of notes stand above it as comments."""
    comments = [f"% {line}" for note in notes for line in note.splitlines()]
    small = r"\footnotesize" if len(table.header) >= MANY_COLUMNS else r"\small"
    rows = [table.header, *table.rows]
    head = [_line(table.header), r"\midrule"] if any(plain(c) for c in table.header) else []
    longest = [max(len(plain(row[i])) for row in rows) for i in range(len(table.align))]
    total = sum(longest)
    columns = "".join(
        letter if length <= LONG else _broken(length / total)
        for letter, length in zip(table.align, longest, strict=True)
    )
    return "\n".join(
        [
            *comments,
            r"\begin{table}",
            rf"\centering{small}\setlength{{\tabcolsep}}{{4pt}}",
            rf"\caption{{{text(caption)}}}",
            rf"\label{{tab:{label}}}",
            FITTED,
            rf"\begin{{tabular}}{{{columns}}}",
            r"\toprule",
            *head,
            *(_line(row) for row in table.rows),
            r"\bottomrule",
            r"\end{tabular}}",
            r"\end{table}",
            "",
        ]
    )


def _line(cells: Sequence[Token]) -> str:
    # LaTeX takes a bracket or a star that begins a row for an option of the row before.
    texts = [cell(item) for item in cells]
    guard = "{}" if texts and texts[0].startswith(("[", "*")) else ""
    return f"{guard}{' & '.join(texts)} \\\\"


def _broken(share: float) -> str:
    width = min(max(share, NARROWEST), WIDEST)
    return rf">{{\raggedright\arraybackslash}}p{{{width:.2f}\linewidth}}"
