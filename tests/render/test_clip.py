from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.errors import UsageError
from gaitlab.render import Clip, clip_of
from tests.synthetic import fall, walk


@given(
    st.floats(-3.0, 3.0), st.floats(0.0, 9.0), st.sampled_from([10.0, 25.0, 30.0]),
    st.sampled_from([0.1, 0.5, 1.0, 2.0]),
)  # fmt: skip
def test_instants_are_evenly_spaced_and_end_at_the_end(
    begin: float, length: float, fps: float, speed: float
) -> None:
    instants = Clip(begin=begin, end=begin + length, fps=fps, speed=speed).instants
    assert instants[0] == begin
    assert instants[-1] == pytest.approx(begin + length, abs=1e-2 * speed / fps)
    steps = instants[1:-1] - instants[:-2]
    assert steps == pytest.approx([speed / fps] * len(steps))


def test_half_the_speed_takes_twice_the_pictures() -> None:
    fast, slow = (Clip(begin=0.0, end=4.0, speed=speed) for speed in (1.0, 0.5))
    assert len(slow.instants) - 1 == 2 * (len(fast.instants) - 1)


def test_two_trials_share_the_clock_of_the_longer_one() -> None:
    short, long = fall(at=1.0), walk(cycles=6.0)
    clip = clip_of([short, long])
    assert clip.end == pytest.approx(long["time"][-1] - long.header.startup_time)
    assert clip.begin == pytest.approx(long["time"][0] - long.header.startup_time)


@pytest.mark.parametrize(
    "asked",
    [
        {"begin": 50.0},
        {"begin": 2.0, "end": 1.0},
        {"begin": float("nan")},
        {"fps": 0.0},
        {"fps": float("nan")},
        {"speed": -1.0},
        {"fps": 240.0, "speed": 1e-4},
    ],
)
def test_a_clip_without_pictures_is_refused_with_what_is_allowed(asked: dict[str, float]) -> None:
    with pytest.raises(UsageError, match=r"allowed|recorded in between|frames"):
        clip_of([walk()], **asked)
