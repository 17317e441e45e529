"""The films of the README, drawn from simulated walks.

python docs/make_images.py
"""

from __future__ import annotations

from pathlib import Path

from gaitlab.experiment import load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.render import Recorded, clip_of, write_replay
from gaitlab.simulation.simulate import simulate

FOLDER = Path(__file__).parent / "images"
FILMS = {  # what is simulated, and the piece of it that is shown, in [s]
    "walk": (["surfaces=[grass_30mm]", "grid={gait.step_length: [0.04]}", "seeds=[1]"], 3.0, 5.0),
    "fall": (["surfaces=[grass_50mm]", "grid={gait.step_length: [0.08]}", "seeds=[2]"], 0.5, None),
}
SIZE = (440, 340)  # pixels


def main() -> None:
    """Draw everything."""
    for name, (settings, begin, end) in FILMS.items():
        draw_film(name, settings, begin, end)


def draw_film(name: str, settings: list[str], begin: float, end: float | None) -> None:
    """A piece of a walk, as `gaitlab replay` shows it."""
    trial = next(iter(plan(load_experiment("eros_table7", settings)).trials())).trial
    log = simulate(trial)
    clip = clip_of([log], begin=begin, end=end, fps=20.0)
    write_replay(
        [Recorded(trial.id, trial, log)], FOLDER / f"{name}.gif", clip, size=SIZE, force=True
    )


if __name__ == "__main__":
    main()
