"""A page of a report as one HTML file that needs no other file and no network."""

from __future__ import annotations

import hashlib
import re
from base64 import b64encode
from collections.abc import Mapping, MutableMapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

from markdown_it.renderer import RendererHTML
from markdown_it.token import Token
from markdown_it.utils import OptionsDict

from gaitlab.report.cells import CELLS
from gaitlab.report.forms.drawings import figure
from gaitlab.report.forms.explorer import Explorer, plotly
from gaitlab.report.forms.tokens import SECTION, Heading, headings, parser, plain, whole_text

FILE = "index.html"
WIDE = 3  # columns of a table; one of more is a list on a narrow screen
BUTTON = '<button type="button" class="cell" data-cell="{}" aria-haspopup="dialog">'
BESIDE = "Cells and walks of each experiment"
LISTED = (2, 3)  # levels of headings in the table of contents

# Mark-up that the pages themselves write between their lines; whatever else looks like a tag
# stays text, whoever wrote it.
_TAG = re.compile(r"</?(?:details|summary|b|strong|em|i|code|br|sub|sup|kbd)(?: open)? ?/?>")
# A share and its interval, which stay on one line.
_INTERVAL = re.compile(r"(?:\d+ % )?\[[-+\d][^\[\]]{0,24}\]|\d+ %")
_NOTE = re.compile(r"<!--.*?-->", re.DOTALL)


def write_html(
    page: Path, explorer: Explorer | None = None, links: Mapping[str, str] | None = None
) -> Path:
    """Write index.html beside a page of Markdown; the same page gives the same bytes.

    Args:
        page: The page, in Markdown.
        explorer: The cells and trials of an experiment, which a reader then opens.
        links: Pages beside it that the contents lead to, by what they are called.
    """
    target = page.with_name(FILE)
    text = html_page(whole_text(page), page.parent, explorer, links)
    target.write_text(text, encoding="utf-8")
    return target


def html_page(
    markdown: str,
    folder: Path,
    explorer: Explorer | None = None,
    links: Mapping[str, str] | None = None,
) -> str:
    """The whole content of a page as HTML, its figures inside.

    Args:
        markdown: The page.
        folder: Where its figures are.
        explorer: The cells and trials of an experiment: their tables open the seeds, and what
            draws any measure of them takes the place of the picture of their shares.
        links: Pages beside it that the contents lead to, by what they are called.
    """
    made = parser()
    tokens = made.parse(markdown)
    titles = headings(tokens)
    renderer = _Page(folder, titles, explorer)
    body = renderer.render(_arranged(tokens, titles, explorer is not None), made.options, {})
    style, scripts = _resource("page.css"), [_resource("page.js")]
    libraries = []
    if explorer:
        body += explorer.blocks()
        scripts.append(_resource("explorer.js"))
        libraries.append(plotly())
    script = "\n".join(scripts)
    # Nothing is fetched, and no script runs but the page's own and the libraries that lie in it.
    allowed = " ".join(f"'sha256-{_digest(text)}'" for text in (script, *libraries))
    policy = f"default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src {allowed}"
    title = next((heading.text for heading in titles.values()), "gaitlab")
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<meta name="generator" content="gaitlab">',
            f"<title>{escape(title)}</title>",
            f"<style>\n{style}</style>",
            "</head>",
            "<body>",
            _contents(list(titles.values()), explorer.walks if explorer else "", links or {}),
            f"<main>\n{body}</main>",
            f"<script>{script}</script>",
            "</body>",
            "</html>",
            "",
        ]
    )


def _digest(script: str) -> str:
    return b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _resource(name: str) -> str:
    return resources.files("gaitlab.report.forms").joinpath(name).read_text(encoding="utf-8")


def _contents(titles: Sequence[Heading], walks: str, links: Mapping[str, str]) -> str:
    """The headings of a page, and before them the files beside it that belong to it."""
    items = [
        f'<li class="level{heading.level}"><a href="#{escape(heading.anchor)}">'
        f"{escape(heading.text)}</a></li>"
        for heading in titles
        if heading.level in LISTED
    ]
    link = f'<p><a class="walks" href="{escape(walks)}">Walks in 3-D</a></p>\n' if walks else ""
    if links:
        rows = (f'<li><a href="{escape(to)}">{escape(name)}</a></li>' for name, to in links.items())
        link += f"<details open>\n<summary>{BESIDE}</summary>\n<ol>\n{''.join(rows)}\n</ol>"
        link += "\n</details>\n"
    if not items and not link:
        return ""
    lines = "\n".join(items)
    return (
        f'<nav aria-label="Contents">\n{link}<details open>\n<summary>Contents</summary>\n'
        f"<ol>\n{lines}\n</ol>\n</details>\n</nav>"
    )


def _arranged(tokens: Sequence[Token], titles: Mapping[int, Heading], cells: bool) -> list[Token]:
    """Tokens as HTML wants them: anchors on headings, figures on their own, titles as such.

    Every cell of a table knows the title of its column, which a narrow screen sets beside it, and
    those of the tables of cells their number, if they are to be opened.
    """
    arranged = list(tokens)
    name, section, columns, column, count = "", "", [""], 0, 0
    for index, token in enumerate(arranged):
        if (heading := titles.get(index)) is not None:
            token.attrSet("id", heading.anchor)
            name, section = heading.text, heading.text if heading.level <= SECTION else section
        if [child.type for child in token.children or ()] == ["image"]:
            arranged[index - 1].hidden = arranged[index + 1].hidden = True
        if token.type == "thead_open":
            columns = []
        elif token.type == "tr_open":
            column = 0
        elif token.type == "th_open":
            token.attrSet("scope", "col")
            columns.append(plain(arranged[index + 1]))
        elif token.type == "td_open":
            if column == 0:
                token.tag = arranged[index + 2].tag = "th"
                token.attrSet("scope", "row")
            else:
                token.attrSet("data-label", columns[column])
                if cells and section == CELLS:
                    token.meta = arranged[index + 2].meta = {"cell": count}
                    count += 1
            column += 1
        elif token.type == "table_close":
            opening = next(t for t in reversed(arranged[:index]) if t.type == "table_open")
            opening.meta = {"columns": columns, "name": name}
    return [token for part in _without_empty_heads(arranged) for token in part]


def _without_empty_heads(tokens: Sequence[Token]) -> list[Sequence[Token]]:
    """Stretches of tokens, between them the heads of tables whose columns have no titles."""
    parts, start = [], 0
    for index, token in enumerate(tokens):
        if token.type == "thead_open":
            end = next(i for i in range(index, len(tokens)) if tokens[i].type == "thead_close")
            if not any(t.content for t in tokens[index:end]):
                parts.append(tokens[start:index])
                start = end + 1
    return [*parts, tokens[start:]]


class _Page(RendererHTML):
    """Renders tokens; methods are named after the token that they render."""

    def __init__(
        self, folder: Path, titles: Mapping[int, Heading], explorer: Explorer | None
    ) -> None:
        super().__init__()
        self._folder, self._explorer = folder, explorer
        self._figures = self._tables = self._drawn = 0
        self._anchors = iter([heading.anchor for heading in titles.values()])

    def image(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        token = tokens[idx]
        self._figures += 1
        alt = self.renderInlineAsText(token.children or [], options, env)
        if self._explorer and token.attrs["src"] == f"{self._explorer.picture}.png":
            self._drawn += 1
            return self._explorer.figure(alt) if self._drawn == 1 else ""
        return figure(str(token.attrs["src"]), alt, self._folder, self._figures) + "\n"

    def text(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        return _INTERVAL.sub(r'<span class="whole">\g<0></span>', escape(tokens[idx].content))

    def heading_close(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        anchor = escape(next(self._anchors))
        link = f'<a class="anchor" href="#{anchor}" aria-label="Link to this section">#</a>'
        return f" {link}</{tokens[idx].tag}>\n"

    def table_open(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        columns, name = tokens[idx].meta["columns"], escape(tokens[idx].meta["name"])
        self._tables += 1
        wide = ' class="wide"' if len(columns) > WIDE and any(columns) else ""
        label = f'aria-label="Table {self._tables}: {name}"'
        return f'<div class="scroll" tabindex="0" role="region" {label}>\n<table{wide}>\n'

    def table_close(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        return "</table>\n</div>\n"

    def td_open(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        number = tokens[idx].meta.get("cell")
        return self.renderToken(tokens, idx, options, env) + (
            "<div>" if number is None else BUTTON.format(number)
        )

    def td_close(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        closed, number = self.renderToken(tokens, idx, options, env), tokens[idx].meta.get("cell")
        if self._explorer is None or number is None:
            return f"</div>{closed}"
        return f"{self._explorer.bar(number)}</button>{closed}"

    def fence(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        return super().fence(tokens, idx, options, env).replace("<pre>", '<pre tabindex="0">', 1)

    def html_block(
        self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]
    ) -> str:
        text = _NOTE.sub("", tokens[idx].content)
        tags = [*_TAG.findall(text), ""]
        between = [part.replace("<", "&lt;").replace(">", "&gt;") for part in _TAG.split(text)]
        return "".join(part + tag for part, tag in zip(between, tags, strict=True))

    html_inline = html_block
