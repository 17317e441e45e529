"""Keys of an experiment file, with what each takes. Their meaning stands in the package's text."""

from __future__ import annotations

from dataclasses import dataclass, field

from gaitlab.documents import Node
from gaitlab.model.settings import EngineSettings, Horizon, Push, Slope, Spread
from gaitlab.parameters import parameter


@dataclass(frozen=True, kw_only=True)
class LogSettings:
    """What is kept of every trial."""

    every: int = parameter(1, unit="-", low=1, high=1, doc="ticks between rows; every tick is kept")


@dataclass(frozen=True, kw_only=True)
class ReportSettings:
    """How the results are laid out."""

    title: str = parameter("", unit="-", doc="heading of the report")
    label: str = parameter("", unit="-", doc="what its rows are called beside other experiments")
    rows: str = parameter("", unit="-", doc="dotted path whose values are the rows")
    columns: str = parameter("surface", unit="-", doc="dotted path whose values are the columns")
    variants: tuple[str, ...] = parameter(
        (), unit="-", doc="dotted paths of which every combination gets a table of its own"
    )
    compare: str | None = parameter(
        None, unit="-", doc="reference table to print beside: eros_table7 or a file, ./ours.yaml"
    )
    metrics: tuple[str, ...] = parameter(
        (), unit="-", doc="metrics drawn for each surface; by default six"
    )
    maps: tuple[tuple[str, ...], ...] = parameter(
        (),
        unit="-",
        doc="pairs of dotted paths over which the stable share is mapped; by default chosen when "
        "more than two are varied",
    )
    distance_reading: str = parameter(
        "", unit="-", doc="which reading of that table's rows holds; by default its first"
    )


@dataclass(frozen=True, kw_only=True)
class Sections:
    """Top-level keys of an experiment file."""

    name: str = parameter("", unit="-", doc="name of the results; by default the file's")
    title: str = parameter("", unit="-", doc="one line: what is asked")
    description: str = parameter("", unit="-", doc="a paragraph")
    robot: Node = parameter(unit="-", doc="name, or `type` and parameters")
    gait: Node = parameter(unit="-", doc="name, or `type` and parameters")
    balance: Node | None = parameter(
        None, unit="-", doc="balance controller: name, or `type` and gains; by default none"
    )
    walkers: Node | None = parameter(
        None, unit="-", doc="robots with their gaits, instead of `robot` and `gait`"
    )
    depends: Node | None = parameter(
        None, unit="-", doc="files or folders that one's own code reads where it is not seen"
    )
    metrics: Node | None = parameter(
        None, unit="-", doc="files of one's own metrics, measured beside those of gaitlab"
    )
    surfaces: Node = parameter(unit="-", doc="list of names or files")
    surface: Node | None = parameter(None, unit="-", doc="parameters set on every surface")
    servo: Node | None = parameter(None, unit="-", doc="`type` and parameters for every servo")
    grid: Node | None = parameter(None, unit="-", doc="dotted paths, each with a list of values")
    zip: Node | None = parameter(None, unit="-", doc="dotted paths whose lists move together")
    one_at_a_time: Node | None = parameter(
        None, unit="-", doc="dotted paths, each varied while the others keep their base"
    )
    design: Node | None = parameter(
        None, unit="-", doc="points that fill a box of dotted paths, each with its range"
    )
    study: Node | None = parameter(
        None, unit="-", doc="parameters that are searched, instead of varied"
    )
    seeds: Node | None = parameter(None, unit="-", doc="number of replicates or list of seeds")
    horizon: Horizon = field(default_factory=Horizon)
    engine: EngineSettings = field(default_factory=EngineSettings)
    spread: Spread = field(default_factory=Spread)
    slope: Slope = field(default_factory=Slope)
    push: Push = field(default_factory=Push)
    log: LogSettings = field(default_factory=LogSettings)
    report: ReportSettings = field(default_factory=ReportSettings)
