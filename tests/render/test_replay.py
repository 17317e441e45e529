from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import imageio.v2 as imageio
import numpy as np
import pytest
from PIL import Image, ImageColor, ImageSequence

from gaitlab.errors import StoreError, UsageError
from gaitlab.log import TrialLog
from gaitlab.render import Clip, Recorded, clip_of, write_replay
from gaitlab.render.clip import NoEncoder, frames
from gaitlab.render.figure_style import VERMILLION
from gaitlab.render.painter import Painter, Style
from gaitlab.render.replay import NoScreen, play
from gaitlab.render.scene import Scene, scene_of
from tests.walked import walked

SMALL = (240, 180)


@pytest.fixture(scope="module")
def shown() -> Recorded:
    walking, log = walked()
    return Recorded(walking.id, walking, log)


def clip(begin: float = 0.0, end: float = 0.2) -> Clip:
    return Clip(begin=begin, end=end, fps=25.0)


def painted(scene: Scene, view: str = "side") -> np.ndarray:
    style = Style(view=view, width=480, height=360, span=(0.0, 1.0))  # type: ignore[arg-type]
    return np.asarray(Painter((scene,), style).frame(0, 0.0)).astype(int)


def green(picture: np.ndarray) -> np.ndarray:
    red, middle, blue = np.moveaxis(picture, -1, 0)
    return (middle > red + 8) & (middle > blue + 8)


def test_a_gif_has_a_picture_for_every_instant_and_holds_the_last(
    shown: Recorded, tmp_path: Path
) -> None:
    written = write_replay([shown], tmp_path / "walk.gif", clip(), size=SMALL)
    with Image.open(written.path) as film:
        durations = [frame.info["duration"] for frame in ImageSequence.Iterator(film)]
        assert film.size == SMALL
    assert len(durations) == written.pictures == len(clip().instants)
    assert sum(durations) / 1000.0 == pytest.approx(written.duration, abs=0.01)
    assert durations[-1] == 1040
    assert written.size == written.path.stat().st_size


def test_a_video_plays_for_as_long_as_it_says_and_its_edges_are_even(
    shown: Recorded, tmp_path: Path
) -> None:
    written = write_replay([shown], tmp_path / "walk.mp4", clip(), size=(241, 181))
    with imageio.get_reader(written.path) as reader:
        facts = reader.get_meta_data()
        assert facts["codec"] == "h264"
        assert facts["size"] == (240, 180)
        assert "yuv420p" in facts["pix_fmt"]
        assert facts["duration"] == pytest.approx(written.duration, abs=0.05)


def test_two_trials_stand_side_by_side(shown: Recorded, tmp_path: Path) -> None:
    walking, log = walked("carpet_4mm")
    other = Recorded(walking.id, walking, log)
    write_replay([shown, other], tmp_path / "both.png", clip(), size=SMALL, panels=2)
    with Image.open(tmp_path / "both.png") as strip:
        assert strip.width == 2 * SMALL[0]
        assert strip.height > 2 * SMALL[1]


def test_a_drawing_is_an_svg(shown: Recorded, tmp_path: Path) -> None:
    write_replay([shown], tmp_path / "frame.svg", clip(0.1, 0.1))
    assert ElementTree.parse(tmp_path / "frame.svg").getroot().tag.endswith("svg")


def test_several_processes_paint_the_same_pictures_as_one(shown: Recorded) -> None:
    instants = np.linspace(0.0, 0.3, 31)
    style = Style(view="perspective", width=160, height=160, span=(0.0, 0.3))
    scenes = (scene_of(shown, instants),)
    alone, together = (list(frames(scenes, style, instants, jobs)) for jobs in (1, 2))
    for one, other in zip(alone, together, strict=True):
        assert np.array_equal(np.asarray(one), np.asarray(other))


def test_grass_stands_as_high_as_the_surface_says(shown: Recorded) -> None:
    """In the side view a tile of 10 cm gives the scale; blades differ by a few per cent."""
    scene = scene_of(shown, [0.0])
    rows = np.flatnonzero(green(painted(scene)).sum(axis=1) > 100)
    style = Style(view="side", width=480, height=360, span=(0.0, 1.0))
    pixels = Painter((scene,), style).camera(scene.focus[0]).scale / 2.0 * scene.surface.height
    assert np.ptp(rows) + 1 == pytest.approx(pixels, rel=0.25)


def test_a_hard_floor_has_no_grass() -> None:
    walking, log = walked("hard_floor")
    scene = scene_of(Recorded(walking.id, walking, log), [0.0])
    for view in ("perspective", "side", "front"):
        assert green(painted(scene, view)).sum() == 0


def test_the_picture_of_a_robot_that_has_fallen_is_framed(shown: Recorded) -> None:
    cause = np.zeros(len(shown.log), np.int8)
    cause[-1] = 1
    log = TrialLog(header=shown.log.header, arrays={**shown.log.arrays, "fall_cause": cause})
    fall = clip_of([log]).end
    edge = np.array(ImageColor.getrgb(VERMILLION))
    before, after = (
        painted(scene_of(shown._replace(log=log), [instant]))[100, 3]
        for instant in (fall - 0.1, fall)
    )
    assert np.abs(after - edge).max() < 40 < np.abs(before - edge).max()


def test_past_its_end_a_trial_stands_still(shown: Recorded) -> None:
    end = clip_of([shown.log]).end
    scene = scene_of(shown, [end, end + 5.0])
    assert scene.time[0] == scene.time[1] == pytest.approx(end)
    assert np.array_equal(scene.poses.position[0], scene.poses.position[1])


@pytest.mark.parametrize("name", ["walk.avi", "walk", "."])
def test_a_file_that_no_replay_writes_is_refused(
    shown: Recorded, name: str, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match=r"\.gif or \.mp4"):
        write_replay([shown], tmp_path / name, clip())


def test_an_unwritable_place_leaves_nothing_behind(shown: Recorded, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StoreError, match="another --output"):
        write_replay([shown], tmp_path / "file" / "walk.png", clip(), size=SMALL, panels=1)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_without_ffmpeg_the_message_says_what_still_works(
    shown: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "no-such-ffmpeg")
    with pytest.raises(NoEncoder, match=r"walk\.gif, strip\.png"):
        write_replay([shown], tmp_path / "walk.mp4", clip(), size=SMALL)


def test_without_a_screen_the_message_says_what_still_works(
    shown: Recorded, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(NoScreen, match=r"DISPLAY.*walk\.gif"):
        play(shown, clip())
