"""The shipped grounds: their numbers, their sources, and the pressures that follow from them."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab.documents import load
from gaitlab.errors import FileError, UnknownName
from gaitlab.parameters import parameter_table
from gaitlab.plugins import locate, names
from gaitlab.surfaces import SURFACE_TYPES, FibreMat, RigidFloor, SoftLayer, TuftedPile
from gaitlab.surfaces.files import load_surface

# Folding and packing pressure [Pa], solid gap [mm] and the gaps [mm] under 2.5 and 5.0 kPa, as
# worked out by hand from height, spacing, yarn and modulus when the law was derived.
LAWS = [
    ("grass_50mm", 74, 0.66, 2.0, 11.3, 9.3),
    ("grass_30mm", 96, 71, 3.0, 15.0, 13.0),
    ("grass_10mm", 2510, 2.1, 0.4, 7.1, 5.8),
    ("carpet_4mm", 0, 17.3e3, 0.8, 3.8, 3.7),
]
GRASS = {
    **{"friction": "0.4", "height": "0.05", "modulus": "5e8", "spacing": "0.01", "yarn": "1.1e-3"},
    **{"blades": "16", "blade_width": "1.2e-3", "blade_thickness": "125e-6"},
}


@pytest.mark.parametrize(("name", "p1", "p2", "solid", "double", "single"), LAWS)
def test_pedestals_press_back_as_their_make_demands(name, p1, p2, solid, double, single) -> None:
    law = load_surface(name).law()
    assert law.p1 == pytest.approx(p1, rel=0.006)
    assert law.p2 == pytest.approx(p2, rel=0.025)
    assert 1e3 * law.solid_height == pytest.approx(solid, abs=0.05)
    assert 1e3 * law.gap_under(2500.0) == pytest.approx(double, abs=0.05)
    assert 1e3 * law.gap_under(5000.0) == pytest.approx(single, abs=0.05)


def test_each_kind_of_ground_has_a_file() -> None:
    kinds = {name: type(load_surface(name)) for name in names("surface")}
    assert kinds["grass_50mm"] is kinds["grass_30mm"] is kinds["grass_10mm"] is TuftedPile
    assert kinds["carpet_4mm"] is FibreMat
    assert kinds["hard_floor"] is RigidFloor
    assert kinds["webots_grass"] is SoftLayer


def test_what_the_paper_prints_of_the_pedestals_is_kept() -> None:
    heights = {50: 0.010, 30: 0.005, 10: 0.005}
    for height, spacing in heights.items():
        surface = load_surface(f"grass_{height}mm")
        assert (surface.height, surface.spacing) == (height / 1000, spacing)
    assert load_surface("carpet_4mm").height == 0.004


def test_the_webots_grass_is_four_of_its_contact_points_a_sole() -> None:
    cfm, erp, h = 0.03, 0.2, 0.008
    grass = load_surface("webots_grass")
    assert grass.stiffness / 4 == pytest.approx(erp / (cfm * h), abs=0.5)
    assert grass.damping / 4 == pytest.approx((1 - erp) / cfm, abs=0.5)


@pytest.mark.parametrize("name", names("surface"))
def test_every_number_of_a_shipped_ground_has_unit_and_source(name: str) -> None:
    root = load(locate("surface", name))
    table = parameter_table(SURFACE_TYPES[str(root.mapping["type"].value)])
    for key, node in root.without("type", "description").mapping.items():
        assert node.mapping["unit"].value == table[key].unit
        assert str(node.mapping["source"].value).startswith(
            ("published", "assumption", "derived", "Toll 1998")
        )


def test_a_copied_ground_with_another_height_is_another_ground(tmp_path: Path) -> None:
    text = locate("surface", "grass_30mm").read_text()
    own = tmp_path / "our_field.yaml"
    own.write_text(text.replace("{value: 0.030, unit: m", "{value: 0.025, unit: m"))
    ours, theirs = load_surface("./our_field.yaml", tmp_path), load_surface("grass_30mm")
    assert (ours.height, ours.spacing) == (0.025, theirs.spacing)
    assert ours.law().gap_under(5000.0) < theirs.law().gap_under(5000.0)


def grass(*changes: tuple[str, str]) -> str:
    """A ground of tufts as bare numbers, some of them changed."""
    numbers = dict(GRASS) | dict(changes)
    return "type: tufts\n" + "".join(f"{key}: {value}\n" for key, value in numbers.items())


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("friction: 0.5\n", ":1:1", "'type' is missing; add `type:` with one of: rigid, layer"),
        ("type: tuft\n", ":1:7", "did you mean 'tufts'?"),
        ("type: [rigid]\n", ":1:7", "found a list"),
        ("type: rigid\nfriction: {value: 0.5, unit: N}\n", ":2:30", "the unit is '-'"),
        ("type: rigid\nheight: 0.01\nfriction: 1\n", ":2:1", "unknown key 'height'"),
        ("type: rigid\nfriction: -1\n", ":2:11", "a number from 0.01 to 2"),
        ("type: rigid\n", ":1:1", "'friction' is missing"),
        (grass(("spacing", "0.001")), ":1:1", "fill 2.39 of the pile, at most 0.6 is allowed"),
        ("type: mat\nheight: {value: 4, unit: mm}\n", ":2:26", "the unit is 'm', convert it"),
    ],
)
def test_a_wrong_ground_is_refused_at_its_place(tmp_path, text, place, words) -> None:
    own = tmp_path / "ours.yaml"
    own.write_text(text)
    with pytest.raises(FileError) as caught:
        load_surface("./ours.yaml", tmp_path)
    assert any(
        str(problem).startswith(f"{own}{place}: ") and words in str(problem)
        for problem in caught.value.problems
    )


def test_an_unknown_ground_is_refused() -> None:
    with pytest.raises(UnknownName, match="grass_50mm"):
        load_surface("grass_5mm")
