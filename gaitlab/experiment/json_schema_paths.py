"""What may stand at and behind the dotted paths of what is varied, searched and boxed.

The half of `gaitlab.experiment.json_schema` that knows every parameter of every shipped gait,
robot, controller, ground, servo and setting by its path, and in which form a file may give it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache

from gaitlab.documents.json_schema import Schema, chosen, list_schema, mapping, value_schema
from gaitlab.experiment.parts import SERVO_TYPE
from gaitlab.experiment.search_reading import FACTOR, LOG, RELATIVE
from gaitlab.model.servo import Servo
from gaitlab.model.settings import SETTINGS
from gaitlab.parameters import Parameter, parameter_table
from gaitlab.plugins import CodeKind, load_class, names
from gaitlab.surfaces import SURFACE_TYPES

CODED: tuple[CodeKind, ...] = ("gait", "robot", "balance")
OWN_KEYS = r"^(gait|robot|balance)\."  # dotted paths that code of the user's own may have
FILLED_IN = ("digest", "folder", "files")  # parameters that no file gives


def path_definitions() -> dict[str, Schema]:
    """Definitions that schemas refer to, by name: of values, and of each form of each owner."""
    found: dict[str, Schema] = {"searching": _searching(), "boxing": _boxing()}
    for path, items in _every_path().items():
        found[f"value {path}"] = _value(*items)
    for kind in CODED:
        for name in names(kind):
            cls = load_class(kind, name)
            table = dict(_paths(kind, cls))
            unlike = [path for path in table if len(_every_path()[path]) > 1]
            found.update({f"value {name} {path}": _value(table[path]) for path in unlike})
            for word, made in FORMS.items():
                exact = unlike if word == "listed" else []
                own = {path: made(path, _reference(f"{name} {path}")) for path in exact}
                only = [*table] if is_closed(cls) else []
                found[f"{word}_{kind}_{name}"] = _own_paths(kind, own, only)
    for word, made in FORMS.items():
        properties = {path: made(path) for path in _every_path()}
        found[word] = {
            **mapping(properties, closed=True),
            "patternProperties": {OWN_KEYS: {}},
            "minProperties": 1,
        }
    return found


def is_closed(cls: type) -> bool:
    """Whether its parameters are all that its section may have."""
    return not hasattr(cls, "declared")


def _paths(group: str, cls: type) -> Iterator[tuple[str, Parameter]]:
    for name, item in parameter_table(cls).items():
        if name not in FILLED_IN:
            yield f"{group}.{name}", item
    if group == "balance":
        yield f"{group}.type", SERVO_TYPE


@cache
def _owners() -> Mapping[str, Sequence[tuple[str, Parameter]]]:
    """What shipped code declares of each dotted path that can be varied, and by whom."""
    classes: list[tuple[str, str, type]] = [
        (kind, name, load_class(kind, name)) for kind in CODED for name in names(kind)
    ]
    classes += [("surface", name, cls) for name, cls in SURFACE_TYPES.items()]
    classes += [(group, group, cls) for group, cls in (("servo", Servo), *SETTINGS.items())]
    found: dict[str, list[tuple[str, Parameter]]] = {"servo.type": [("servo", SERVO_TYPE)]}
    for group, name, cls in classes:
        for path, item in _paths(group, cls):
            found.setdefault(path, []).append((name, item))
    return found


@cache
def _every_path() -> Mapping[str, tuple[Parameter, ...]]:
    """The same, each declaration once."""
    return {
        path: tuple(item for k, item in enumerate(items) if item not in items[:k])
        for path, items in ((p, [item for _, item in pairs]) for p, pairs in _owners().items())
    }


def _own_paths(kind: str, properties: Mapping[str, Schema], only: Sequence[str]) -> Schema:
    """The dotted paths of one gait, robot or controller: its own, and none beside them.

    Args:
        kind: What it is.
        properties: Of the paths that others of its kind have with other limits.
        only: All of its paths; empty if it may have more.
    """
    others = {"not": {"pattern": rf"^{kind}\."}}
    names = {"propertyNames": {"anyOf": [others, {"enum": list(only)}]}} if only else {}
    return {"properties": dict(properties), **names}


def _value(*items: Parameter) -> Schema:
    """A value of a path; where several parameters have its name, of any of them."""
    schemas = [value_schema(item) for item in items]
    for each in schemas:
        each.pop("default", None)
    if len(schemas) == 1:
        return schemas[0]
    said = " / ".join(dict.fromkeys(each["description"] for each in schemas))
    bare = [{key: v for key, v in each.items() if key != "description"} for each in schemas]
    unlike = [each for place, each in enumerate(bare) if each not in bare[:place]]
    return {**(unlike[0] if len(unlike) == 1 else {"anyOf": unlike}), "description": said}


def _reference(path: str) -> Schema:
    return {"$ref": f"#/definitions/value {path}".replace(" ", "%20")}


def _doc(path: str) -> str:
    """What a path is, in a line; its range stands with its values. Who differs is named."""
    meanings: dict[str, list[str]] = {}
    for name, item in _owners()[path]:
        unit = f", in {item.unit}" if item.unit not in ("-", "file") else ""
        meanings.setdefault(item.doc + unit, []).append(name)
    if len(meanings) == 1:
        return next(iter(meanings))
    return "; ".join(f"{', '.join(names)}: {doc}" for doc, names in meanings.items())


def _listed(path: str, value: Schema | None = None) -> Schema:
    """A list of values of a path."""
    return list_schema(value or _reference(path), doc=_doc(path))


def _searched(path: str, value: Schema | None = None) -> Schema:
    """How a path is searched: a list of its choices, or a range."""
    value = value or _reference(path)
    return {
        "description": _doc(path),
        "allOf": [{"$ref": "#/definitions/searching"}],
        "items": value,
        **chosen({"required": ["relative"]}, {}, {"properties": {"low": value, "high": value}}),
    }


def _searching() -> Schema:
    """The keys of a searched path; relative ends are times the value before the search."""
    factor, number = value_schema(FACTOR), {"type": "number"}
    ends = {"low": number, "high": number, "log": value_schema(LOG), "step": number}
    keys = {**ends, "relative": value_schema(RELATIVE), "choices": list_schema({}, least=2)}
    when: Schema = {"type": "object", "minProperties": 1, "maxProperties": 1}
    relative = {"properties": {"low": factor, "high": factor}}
    return {
        **mapping({**keys, "when": when}),
        "type": ["object", "array"],
        "minItems": 2,
        "anyOf": [{"required": ["low", "high"]}, {"required": ["choices"]}, {"type": "array"}],
        **chosen({"required": ["relative"]}, relative),
    }


def _boxed(path: str, value: Schema | None = None) -> Schema:
    """An edge of a box."""
    del path, value
    return {"$ref": "#/definitions/boxing"}


def _boxing() -> Schema:
    """The keys of an edge: its ends, and what moves along with it."""
    ends = {"low": {"type": "number"}, "high": {"type": "number"}, "log": value_schema(LOG)}
    return mapping({**ends, "with": {"type": "object"}}, ("low", "high"))


FORMS: Mapping[str, Callable[..., Schema]] = {
    "listed": _listed,
    "searched": _searched,
    "boxed": _boxed,
}
