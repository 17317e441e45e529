"""A trial in 3-D: what the page holds, and what a real browser shows of it."""

from __future__ import annotations

import base64
import gzip
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from gaitlab.errors import StoreError
from gaitlab.log import TrialLog
from gaitlab.log.columns import columns
from gaitlab.plugins import load_class, names
from gaitlab.render import Recorded, clip_of
from gaitlab.render.replay_page import NoViewer, Replay, three_js, write_replay_page
from gaitlab.render.scene import link_poses, ticks_at
from gaitlab.render.track import LEVELS, packed, verdict_of
from tests.report.browser import (
    CHROMIUM,
    SOFTWARE_GL,
    Browser,
    accessibility_rules,
    browser,
    serious,
)
from tests.synthetic import header
from tests.trials import trial
from tests.walked import walked

NASTY = "</script><script>alert(1)</script> & 'A'"
SETTLED = "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))"
MILLIMETRE = 1e-3
BROWSERS = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")


def recorded(surface: str = "grass_50mm", cell: str = "") -> Recorded:
    walking, log = walked(surface)
    return Recorded(walking.id, walking, log, cell)


def fallen(shown: Recorded) -> Recorded:
    cause = np.zeros(len(shown.log), np.int8)
    cause[-1] = 1
    log = TrialLog(header=shown.log.header, arrays={**shown.log.arrays, "fall_cause": cause})
    return shown._replace(log=log)


def one_row(shown: Recorded) -> Recorded:
    rows = {name: values[:1] for name, values in shown.log.arrays.items()}
    return shown._replace(log=TrialLog(header=shown.log.header, arrays=rows))


def tumbling(name: str, rows: int = 600) -> Recorded:
    """A robot whose trunk and joints turn at random, smoothly."""
    robot = load_class("robot", name)()
    random, time = np.random.default_rng(3), 0.01 * np.arange(rows)
    joints = tuple(joint.name for joint in robot.tree.joints)
    table = {
        column.name: np.sin(random.uniform(0.5, 3.0) * time + random.uniform(0.0, 6.0))
        for column in columns(joints)
    }
    turn = np.stack([table[f"trunk_q{axis}"] for axis in "xyzw"])
    turn /= np.linalg.norm(turn, axis=0)
    table |= {f"trunk_q{axis}": row for axis, row in zip("xyzw", turn, strict=True)}
    table |= {"time": time, "fall_cause": np.zeros(rows), "contact": np.ones(rows)}
    limits = tuple(1.0 for _ in joints)
    head = header(joints=joints, torque_limits=limits, startup_time=0.0, fsr_positions=())
    kinds = {column.name: column.dtype for column in columns(joints)}
    held = {name: table[name].astype(kind) for name, kind in kinds.items()}
    walking = replace(trial(), robot=robot)
    return Recorded(walking.id, walking, TrialLog(header=head, arrays=held))


def page(path: Path, *shown: Recorded, **options: object) -> Path:
    clip = clip_of([trial.log for trial in shown])
    write_replay_page([Replay(trial, clip) for trial in shown], path, **options)  # type: ignore[arg-type]
    return path


def unpacked(channels: list[tuple[str, float, float]], data: str, n: int) -> np.ndarray:
    """As the page does it."""
    low, high = np.frombuffer(zlib.decompress(base64.b64decode(data)), np.uint8).reshape(2, -1)
    differences = (low + 256 * high.astype(int)).reshape(len(channels), n)
    levels = np.cumsum(differences, axis=1) % 65536
    begin, step = (np.array([channel[k] for channel in channels])[:, None] for k in (1, 2))
    return np.where(levels == 65535, np.nan, begin + step * levels)


@given(
    arrays(
        float,
        st.tuples(st.integers(1, 5), st.integers(1, 30)),
        elements=st.floats(-1e6, 1e6) | st.sampled_from([np.nan, np.inf, -np.inf]),
    )
)
def test_packed_numbers_come_back_to_half_a_level_and_the_others_as_none(table: np.ndarray) -> None:
    channels, data = packed({str(k): row for k, row in enumerate(table)})
    known = np.isfinite(table)
    back = unpacked([tuple(channel) for channel in channels], data, table.shape[1])
    assert np.array_equal(np.isfinite(back), known)
    spans = [float(np.ptp(row[np.isfinite(row)])) if np.isfinite(row).any() else 0 for row in table]
    level = np.broadcast_to(np.array(spans)[:, None] / LEVELS, table.shape)
    assert (np.abs(back - table)[known] <= 0.5 * level[known] + 1e-9).all()


def test_a_page_of_ten_seconds_is_small(tmp_path: Path) -> None:
    shown = tumbling("nao", rows=1000)  # joints that all move, which a walk's do not
    file = page(tmp_path / "fall.html", shown)
    assert len(gzip.compress(file.read_bytes())) < 2_000_000
    both = page(tmp_path / "both.html", shown, shown._replace(trial_id="other"))
    trials = both.stat().st_size - file.stat().st_size
    assert 80 * trials < 8_000_000  # worst and median seed of 40 cells, and the library once


def test_the_same_trial_gives_the_same_page(tmp_path: Path) -> None:
    first, second = (page(tmp_path / name, recorded()) for name in ("a.html", "b.html"))
    assert first.read_bytes() == second.read_bytes()


def test_a_trimesh_without_its_viewer_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    three_js.cache_clear()
    monkeypatch.setattr("gaitlab.render.replay_page.TEMPLATE", ("nowhere", "viewer.zip"))
    with pytest.raises(NoViewer):
        page(tmp_path / "fall.html", recorded())
    assert not (tmp_path / "fall.html").exists()


def test_a_folder_in_the_place_of_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(StoreError):
        page(tmp_path / "file" / "fall.html", recorded())
    assert (tmp_path / "file").read_text() == "mine"


def test_what_became_of_a_trial_is_said() -> None:
    from gaitlab.render.scene import scene_of

    shown = recorded()
    down = fallen(shown)
    up, fell = (verdict_of(each.log, scene_of(each, [0.0])) for each in (shown, down))
    assert up != fell
    assert f"{clip_of([down.log]).end:.2f} s" in fell


class Stage:
    """A page in a browser, and pictures of where its robots are drawn."""

    def __init__(self, tab: Browser, folder: Path) -> None:
        self.tab, self._folder = tab, folder

    def open(self, file: Path, place: str = "#&t=0") -> None:
        self.tab.open(file, place)
        for _ in range(200):
            if self.tab.value("document.body.dataset.ready || ''"):
                return
            self.tab.value("new Promise(r => setTimeout(() => r(1), 50))")
        raise AssertionError(self.tab.problems)

    def seek(self, instant: float) -> None:
        self.tab.value(f"replay.seek({instant})")

    def state(self, name: str) -> object:
        return self.tab.value(f"JSON.parse(JSON.stringify(replay.state())).{name}")

    def picture(self) -> np.ndarray:
        self.tab.value(SETTLED)
        self.tab.shot(self._folder / "shot.png")
        return np.asarray(Image.open(self._folder / "shot.png").convert("RGB")).astype(int)

    def inside(self, element: str) -> tuple[slice, slice]:
        """Middle third of an element, in pixels."""
        box = self.tab.value(
            f"(b => [b.left, b.top, b.width, b.height])({element}.getBoundingClientRect())"
        )
        left, top, width, height = box
        across = slice(int(left + width / 3), int(left + 2 * width / 3))
        return slice(int(top + height / 3), int(top + 2 * height / 3)), across

    def click(self, name: str) -> None:
        self.tab.value(f"document.getElementById('{name}').click()")


CANVAS = "document.getElementById('canvas')"


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("no Chromium is installed")
    with browser(tmp_path_factory.mktemp("profile"), 1000, 700, SOFTWARE_GL) as opened:
        yield opened


@pytest.fixture
def stage(tab: Browser, tmp_path: Path) -> Stage:
    return Stage(tab, tmp_path)


def robot_pixels(picture: np.ndarray) -> np.ndarray:
    """Where something grey and neither grass nor sky is."""
    spread = np.ptp(picture, axis=-1)
    return (spread < 24) & (picture.mean(axis=-1) < 215)


def test_the_canvas_shows_the_robot_and_it_moves(stage: Stage, tmp_path: Path) -> None:
    shown = recorded()
    stage.open(page(tmp_path / "fall.html", shown))
    middle = stage.inside(CANVAS)
    clip = clip_of([shown.log])
    stage.seek(clip.begin)
    first = stage.picture()[middle]
    assert robot_pixels(first).mean() > 0.05
    corner = stage.picture()[60:80, -60:-40]
    assert not robot_pixels(corner).any(), "the sky is empty"
    stage.seek(clip.end)
    second = stage.picture()[middle]
    assert (np.abs(first - second).max(axis=-1) > 40).mean() > 0.01
    stage.seek(clip.begin)
    assert np.array_equal(stage.picture()[middle], first), "back is where it came from"


def test_nothing_is_fetched_and_nothing_complains(stage: Stage, tmp_path: Path) -> None:
    file = page(tmp_path / "fall.html", recorded(cell=NASTY), title=NASTY)
    stage.open(file)
    stage.picture()
    assert [address.partition("#")[0] for address in stage.tab.fetched] == [file.as_uri()]
    kinds = ("error", "warning", "assert")
    told = [
        event
        for event in stage.tab.problems
        if event["method"] == "Runtime.exceptionThrown"
        or event["params"].get("type") in kinds
        or event["params"].get("entry", {}).get("level") in kinds
    ]
    # What software instead of a graphics card costs is Chromium's own remark.
    assert not [event for event in told if "GPU stall" not in str(event)]
    assert stage.tab.value("document.querySelector('.cell').textContent") == NASTY
    assert stage.tab.value("document.title") == NASTY


@pytest.mark.parametrize("name", names("robot"))
def test_links_are_where_the_log_has_them(name: str, stage: Stage, tmp_path: Path) -> None:
    shown = tumbling(name)
    stage.open(page(tmp_path / "fall.html", shown))
    instants = clip_of([shown.log]).instants[[0, 20, 77, -1]]
    expected = link_poses(shown.trial.robot.tree, shown.log, ticks_at(shown.log, instants))
    for instant, places in zip(instants, expected.position, strict=True):
        stage.seek(float(instant))
        links = stage.tab.value("replay.links()")
        drawn = [links[link.name] for link in shown.trial.robot.tree.links]
        assert np.abs(np.array(drawn) - places).max() < MILLIMETRE


def test_two_trials_stand_side_by_side(stage: Stage, tmp_path: Path) -> None:
    file = page(tmp_path / "both.html", recorded(), fallen(recorded("hard_floor")))
    stage.open(file)
    picture = stage.picture()
    for panel in range(2):
        part = stage.inside(f"document.querySelectorAll('.panel')[{panel}]")
        assert robot_pixels(picture[part]).mean() > 0.05
    identity = recorded("hard_floor").trial_id
    stage.open(file, f"#{identity[:8]}&t=0.1")
    assert stage.state("trials") == [identity]
    assert stage.state("now") == pytest.approx(0.1)


@pytest.mark.parametrize("name", ["target", "load", "support", "zmp", "pile"])
def test_what_is_drawn_over_can_be_left_out(name: str, stage: Stage, tmp_path: Path) -> None:
    stage.open(page(tmp_path / "fall.html", recorded()))
    stage.seek(clip_of([recorded().log]).end - 0.05)
    before = stage.picture()
    stage.click(name)
    after = stage.picture()
    assert stage.state(f"shown.{name}") is False
    high, across = stage.inside(CANVAS)
    low = slice(high.start, high.stop + high.stop - high.start)  # feet are below the middle
    assert (before[low, across] != after[low, across]).any()


def test_the_clock_is_moved_by_keys_by_hand_and_by_itself(stage: Stage, tmp_path: Path) -> None:
    shown = recorded()
    stage.open(page(tmp_path / "fall.html", fallen(shown)))
    clip = clip_of([shown.log])
    for key, instant in (("Home", clip.begin), ("ArrowRight", clip.instants[1]), ("End", clip.end)):
        stage.tab.press(key)
        assert stage.state("now") == pytest.approx(instant, abs=1e-4)
    stage.tab.press("ArrowLeft")
    assert clip.begin < stage.state("now") < clip.end  # type: ignore[operator]
    stage.tab.value("(t => { t.value = 0.1; t.dispatchEvent(new Event('input')); })(time)")
    assert stage.state("now") == pytest.approx(0.1, abs=1e-3)
    assert stage.state("playing") is False
    play_at = "(s => {{ s.value = {}; s.dispatchEvent(new Event('change')); }})(speed)"
    stage.tab.value(play_at.format(0.05))  # so slowly that the end is far away
    stage.tab.press(" ")
    assert stage.state("playing") is True
    stage.tab.value(play_at.format(4))
    for _ in range(200):
        if not stage.state("playing"):
            break
        stage.tab.value(SETTLED)
    assert stage.state("now") == pytest.approx(clip.end, abs=1e-4)
    stage.tab.value(play_at.format(0.05))
    stage.tab.value("document.querySelector('.fall').click()")
    assert stage.state("playing") is True


def test_the_camera_goes_round(stage: Stage, tmp_path: Path) -> None:
    stage.open(page(tmp_path / "fall.html", recorded()))
    before = stage.state("view"), stage.picture()
    stage.tab.mouse("Pressed", 500, 300, button="left", clickCount=1)
    stage.tab.mouse("Moved", 620, 340, button="left", buttons=1)
    stage.tab.mouse("Released", 620, 340, button="left", clickCount=1)
    stage.tab.mouse("Wheel", 500, 300, deltaX=0, deltaY=300)
    after = stage.state("view"), stage.picture()
    for name in ("azimuth", "elevation", "distance"):
        assert before[0][name] != after[0][name]  # type: ignore[index]
    assert (before[1] != after[1]).any()
    stage.click("reset")
    assert stage.state("view") == before[0]


def test_a_fall_of_no_length_is_a_picture(stage: Stage, tmp_path: Path) -> None:
    stage.open(page(tmp_path / "fall.html", fallen(one_row(recorded()))), "")
    assert stage.state("playing") is False
    assert robot_pixels(stage.picture()[stage.inside(CANVAS)]).mean() > 0.05


def test_no_trial_at_all_is_a_page(stage: Stage, tmp_path: Path) -> None:
    write_replay_page([], tmp_path / "none.html", menu="<p>Every trial failed.</p>")
    stage.open(tmp_path / "none.html", "")
    assert stage.tab.value("document.querySelector('#menu p').innerText") == "Every trial failed."


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_rules_of_accessibility_hold(
    scheme: str, stage: Stage, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    rules = accessibility_rules(tmp_path_factory.mktemp("axe"))
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    stage.tab.ask("Emulation.setEmulatedMedia", features=features)
    menu = (
        "<h1>Walks</h1><table><tr><td class='unstable'><b>U</b> <a href='#1234'>worst</a></table>"
    )
    stage.open(page(tmp_path / "both.html", recorded(), fallen(recorded("hard_floor")), menu=menu))
    assert serious(stage.tab, rules) == []
    stage.tab.ask("Emulation.setEmulatedMedia", features=[])


@BROWSERS
def test_it_fits_a_phone(tmp_path: Path) -> None:
    file = page(tmp_path / "both.html", recorded(), recorded("hard_floor"))
    with browser(tmp_path / "profile", 500, 844, SOFTWARE_GL) as opened:
        opened.ask(
            "Emulation.setDeviceMetricsOverride",
            width=390, height=844, deviceScaleFactor=1, mobile=True,
        )  # fmt: skip
        stage = Stage(opened, tmp_path)
        stage.open(file)
        assert opened.value("document.documentElement.scrollWidth") <= 390
        assert opened.value("document.documentElement.scrollHeight") <= 844
        for panel in range(2):
            part = stage.inside(f"document.querySelectorAll('.panel')[{panel}]")
            assert robot_pixels(stage.picture()[part]).mean() > 0.03


@BROWSERS
def test_a_browser_without_3d_is_told_so(tmp_path: Path) -> None:
    file = page(tmp_path / "fall.html", recorded())
    with browser(tmp_path / "profile", more=["--disable-3d-apis"]) as opened:
        stage = Stage(opened, tmp_path)
        stage.open(file)
        assert opened.value("!document.getElementById('trouble').hidden")
        assert "WebGL" in opened.value("document.getElementById('trouble').textContent")


def test_the_plots_say_what_the_log_says_and_lead_to_an_instant(
    stage: Stage, tmp_path: Path
) -> None:
    shown = recorded()
    stage.open(page(tmp_path / "fall.html", shown))
    clip = clip_of([shown.log])
    instant = clip.instants[len(clip.instants) // 2]
    stage.seek(instant)
    stage.tab.value(SETTLED)
    said = stage.tab.value("document.querySelectorAll('#strip span')[1].textContent")
    (tick,) = ticks_at(shown.log, np.array([instant]))
    margin = 1000.0 * shown.log["zmp_margin"][tick]
    assert float(said.split()[-2]) == pytest.approx(margin, abs=1.5)  # mm, written without decimals
    box = stage.tab.value(
        "(b => [b.left, b.top, b.width, b.height])"
        "(document.getElementById('strip').getBoundingClientRect())"
    )
    stage.tab.click(box[0] + box[2] / 2, box[1] + box[3] / 2)
    middle = 0.5 * (clip.begin + clip.end)
    assert stage.state("now") == pytest.approx(middle, abs=0.02)
    stage.click("plots")
    assert stage.tab.value("document.getElementById('strip').offsetHeight") == 0
