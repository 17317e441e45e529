"""Passwords in the address of a database reach no message, no page and no command line."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

import pytest

from gaitlab.cli import run_command_line
from gaitlab.errors import StoreError
from gaitlab.search.storage import server_storage, shown, understood, without_secrets

PASSWORD = "hunter2/@:%&x"
ESCAPED = quote(PASSWORD, safe="")
ADDRESSES = [
    f"postgresql://lab:{ESCAPED}@127.0.0.1:1/walks",
    f"postgresql://lab@127.0.0.1:1/walks?password={ESCAPED}",
    f"postgresql://lab@127.0.0.1:1/walks?sslmode=require&sslpassword={ESCAPED}",
    f"postgresql://lab@127.0.0.1:1/walks?PassWord={ESCAPED}&password={ESCAPED}2",
    f"postgresql://lab@/walks?passfile=/home/lab/{ESCAPED}",
    f"mysql://lab:{ESCAPED}@127.0.0.1:1/walks?passwd={ESCAPED}&ssl_key_passphrase={ESCAPED}",
    f"postgresql://lab:{PASSWORD}@127.0.0.1:1/walks",
    f"postgresql://lab:{ESCAPED}@127.0.0.1:port/walks",
    f"postgresql:/lab:{ESCAPED}@127.0.0.1/walks",
    f"lab:{ESCAPED}@127.0.0.1/walks",
    f"nosuch://lab:{ESCAPED}@127.0.0.1/walks",
    f"password={ESCAPED} host=127.0.0.1",
    f"://lab:{ESCAPED}@127.0.0.1/walks",
    f"postgresql://[lab:{ESCAPED}@::1/walks",
]


def leaks(text: str) -> bool:
    return "hunter" in text


@pytest.mark.parametrize("address", ADDRESSES)
def test_no_password_is_shown_or_in_what_a_database_refuses(address: str) -> None:
    assert not leaks(shown(address))
    with pytest.raises(StoreError) as refused:
        server_storage(address)
    assert not leaks(str(refused.value))


@pytest.mark.parametrize("address", [ADDRESSES[1], ADDRESSES[7], ADDRESSES[9]])
def test_no_command_prints_a_password(
    address: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    where = ["--storage", address, "--store", str(tmp_path / "data")]
    for words in (
        ["optimize", "eros_small", "-n"],
        ["optimize", "eros_small"],
        ["report", "eros_small"],
    ):
        assert run_command_line([*words, *where]) in (2, 3, 7), words
        told = capfd.readouterr()
        assert not leaks(told.out + told.err)
    assert not any(
        leaks(path.read_text(errors="replace")) for path in tmp_path.rglob("*") if path.is_file()
    )


def test_what_says_where_a_database_is_stays_readable() -> None:
    address = "postgresql://lab:hunter2@server:5432/walks?sslmode=require"
    assert shown(address) == "postgresql://lab:***@server:5432/walks?sslmode=require"
    assert shown("sqlite:///walks.db") == "sqlite:///walks.db"


@pytest.mark.parametrize(
    "told",
    [
        'invalid connection option "x": password=hunter2 host=server',
        "could not connect to postgresql://lab:hunter2@server/walks",
        "{'passwd': 'hunter2', 'host': 'server'}",
        'sslpassword = "hunter2 with words"',
    ],
)
def test_a_driver_that_repeats_a_password_is_not_quoted(told: str) -> None:
    assert not leaks(without_secrets(told))
    with pytest.raises(StoreError) as refused, understood("server"):
        raise RuntimeError(told)
    assert not leaks(str(refused.value))
