"""A headless Chromium that tests steer through a pair of pipes, without any driver."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import tarfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--remote-debugging-pipe",
)
AXE = "axe-core@4.14.1"
# Pictures in 3-D without a graphics card.
SOFTWARE_GL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


class Browser:
    """One tab. Messages are JSON, each ended by a zero byte."""

    def __init__(self, to: int, back: int) -> None:
        self._to, self._back, self._rest = to, back, b""
        self._number, self._session = 0, ""
        self.events: list[dict[str, Any]] = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        attached = self.ask("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{domain}.enable")

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Answer of the browser to one command."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return dict(answer["result"])
            self.events.append(answer)

    def _message(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            assert select.select([self._back], [], [], 60.0)[0], "the browser is silent"
            more = os.read(self._back, 1 << 20)
            assert more, "the browser has gone"
            self._rest += more
        line, _, self._rest = self._rest.partition(b"\0")
        return dict(json.loads(line))

    def open(self, page: Path, place: str = "") -> None:
        """Load a file, at a place in it, and wait until it is there; forget what was before."""
        # Another place of the page that is open would not be loaded.
        for address in ("about:blank", page.resolve().as_uri() + place):
            self.events.clear()
            self.ask("Page.navigate", url=address)
            while not any(event["method"] == "Page.loadEventFired" for event in self.events):
                self.events.append(self._message())

    def value(self, script: str) -> Any:
        """What a line of JavaScript gives, or promises."""
        answer = self.ask(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Move, press, release or wheel at a place of the window, in pixels."""
        self.ask("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, **more)

    def click(self, x: float, y: float, times: int = 1) -> None:
        """Press and release the left button."""
        for count in range(1, times + 1):
            for kind in ("Pressed", "Released"):
                self.mouse(kind, x, y, button="left", clickCount=count)

    def press(self, key: str) -> None:
        """Press and release a key."""
        for kind in ("keyDown", "keyUp"):
            self.ask("Input.dispatchKeyEvent", type=kind, key=key)

    def shot(self, file: Path, whole: bool = False) -> None:
        """Save what the window shows as PNG."""
        data = self.ask("Page.captureScreenshot", captureBeyondViewport=whole)["data"]
        file.write_bytes(base64.b64decode(data))

    @property
    def problems(self) -> list[dict[str, Any]]:
        """Errors and warnings of the page so far."""
        kinds = ("Log.entryAdded", "Runtime.exceptionThrown", "Runtime.consoleAPICalled")
        return [event for event in self.events if event["method"] in kinds]

    @property
    def fetched(self) -> list[str]:
        """Addresses that the page asked for so far, data inside the page left out."""
        asked = (e for e in self.events if e["method"] == "Network.requestWillBeSent")
        addresses = (str(event["params"]["request"]["url"]) for event in asked)
        return [address for address in addresses if not address.startswith("data:")]


@contextmanager
def browser(
    profile: Path, width: int = 1280, height: int = 900, more: Sequence[str] = ()
) -> Iterator[Browser]:
    """A Chromium with a profile and options of its own; ended at the end."""
    assert CHROMIUM is not None
    commands, to = os.pipe()
    back, answers = os.pipe()
    # Chromium reads its commands from descriptor 3 and answers on 4.
    start = f'exec 3<&{commands} 4>&{answers}; exec "$0" "$@"'
    options = (*OPTIONS, *more, f"--user-data-dir={profile}", f"--window-size={width},{height}")
    process = subprocess.Popen(
        ["/bin/bash", "-c", start, CHROMIUM, *options],
        pass_fds=(commands, answers),
        stderr=subprocess.DEVNULL,
    )
    os.close(commands)
    os.close(answers)
    try:
        yield Browser(to, back)
    finally:
        process.kill()
        process.wait(30.0)
        os.close(to)
        os.close(back)


def accessibility_rules(folder: Path) -> str:
    """The script of axe-core, brought by npm into a folder; a test is skipped without it."""
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("no npm on this machine, which brings axe-core")
    try:
        asked = [npm, "pack", AXE, "--silent"]
        subprocess.run(asked, cwd=folder, check=True, timeout=120, capture_output=True)
        (packed,) = folder.glob("*.tgz")
        with tarfile.open(packed) as files:
            content = files.extractfile("package/axe.min.js")
            assert content is not None
            return content.read().decode()
    except (subprocess.SubprocessError, OSError) as error:
        pytest.skip(f"axe-core cannot be had: {error}")


def serious(tab: Browser, rules: str) -> list[list[str]]:
    """What axe-core finds wrong with the page that is open, and matters: rule and element."""
    tab.value(f"{rules}; 0")
    found: list[list[str]] = tab.value(
        "axe.run().then(r => r.violations.filter(v => ['serious', 'critical'].includes("
        "v.impact)).map(v => [v.id, v.nodes[0].html]))"
    )
    return found
