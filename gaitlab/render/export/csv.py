"""A log as CSV: one row a tick, the unit in every column's name, every digit kept."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gaitlab.documents.printable import csv_cell
from gaitlab.log.columns import Column, columns
from gaitlab.render.export.recorded import ExportedTrial


def write_csv(shown: ExportedTrial, files: Sequence[Path]) -> None:
    """Write the columns of a log; read as float32, every number is the one that was recorded."""
    described = columns(shown.log.header.joints)
    texts = [_texts(shown.log.arrays[column.name]) for column in described]
    with files[0].open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([csv_cell(_title(column)) for column in described])
        writer.writerows(zip(*texts, strict=True))


def _title(column: Column) -> str:
    """`trunk_x [m]`; a name alone for what has no unit."""
    return column.name if column.unit == "-" else f"{column.name} [{column.unit}]"


def _texts(array: np.ndarray) -> list[str]:
    """Shortest texts that read back as the same number; NaN is an empty field, true is 1."""
    if array.dtype == bool:
        array = array.astype(np.int8)
    texts: list[str] = array.astype(str).tolist()
    return ["" if text == "nan" else text for text in texts]
