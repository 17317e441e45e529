"""What a user wrote must never become mark-up, and a table must stay a table."""

from __future__ import annotations

import re

from hypothesis import given
from hypothesis import strategies as st

from gaitlab.report.markdown import code, escape, fenced, table

UNESCAPED_PIPE = re.compile(r"(?<!\\)(?:\\\\)*\|")


@given(st.text())
def test_escaped_text_is_one_line_without_live_markup(text: str) -> None:
    escaped = escape(text)
    assert len(escaped.splitlines()) <= 1
    bare = re.sub(r"\\.", "", escaped)
    assert not set(bare) & set("<>|*_`[]#~&$!")


@given(st.lists(st.text(), min_size=2, max_size=2), st.text())
def test_a_table_keeps_its_columns_whatever_the_text(cells: list[str], mono: str) -> None:
    text = table(["a", "b", "c"], [[*map(escape, cells), code(mono)]])
    lines = text.splitlines()
    assert len(lines) == 3
    assert {len(UNESCAPED_PIPE.findall(line)) for line in lines} == {4}


@given(st.text(alphabet="`ab \n"))
def test_no_text_ends_its_own_fence(text: str) -> None:
    block = fenced(text).splitlines()
    fence = block[0]
    assert all(not line.startswith(fence) for line in block[1:-1])
    assert block[-1] == fence


def test_escaping_leaves_plain_words_alone() -> None:
    assert escape("EROS on grass, 50 mm") == "EROS on grass, 50 mm"


def test_a_name_that_looks_like_a_list_stays_text() -> None:
    assert escape("- item") == r"\- item"
    assert escape("-0.04 m") == "-0.04 m"
    assert escape("1. item") == r"1\. item"
