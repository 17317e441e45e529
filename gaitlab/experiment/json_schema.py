"""What may stand in each kind of file, as JSON Schema: `gaitlab schema`, for editors.

Made from the very declarations that files are read with. Names of shipped things are suggestions
where a file of the user's own may stand; the parameters of a shipped gait, robot or controller are
known as soon as the file names it, also as dotted paths of what is varied and searched.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path

from gaitlab.documents.json_schema import (
    Schema,
    chosen,
    document,
    file_schema,
    list_schema,
    mapping,
    name_schema,
    object_schema,
    value_schema,
)
from gaitlab.documents.outputs import write_text
from gaitlab.experiment.design import KEYS as DESIGN_KEYS
from gaitlab.experiment.json_schema_paths import CODED, FILLED_IN, is_closed, path_definitions
from gaitlab.experiment.loading import LARGEST_SEED, MOST_SEEDS
from gaitlab.experiment.parts import NO_BALANCE
from gaitlab.experiment.reading import LISTED, PATHS_AS_KEYS, WALKER_KEYS
from gaitlab.experiment.samplers import SAMPLERS
from gaitlab.experiment.schema import ReportSettings, Sections
from gaitlab.experiment.study import MISLEADING
from gaitlab.experiment.study_reading import (
    BESIDE,
    BOUNDS,
    COMPARED,
    CONFIDENCE,
    CONFIRM,
    DIRECTIONS,
    EARLY_STOP,
    PLAIN,
    SHARE,
    SHARED,
    WHOLE,
)
from gaitlab.metrics import lookup
from gaitlab.metrics import names as metric_names
from gaitlab.model.foreign.robot_file import ANGLE, FORWARD, KINDS, LUMP_MASS, MASS, PLACE, SOLE
from gaitlab.model.servo import Servo
from gaitlab.model.settings import SETTINGS
from gaitlab.parameters import parameter_table
from gaitlab.plugins import SUFFIXES, CodeKind, load_class, names
from gaitlab.surfaces import SURFACE_TYPES

TEXT: Schema = {"type": "string"}
NOTHING: Schema = {"type": "null"}
BESIDE_FILES = ".gaitlab"  # folder of the schemas beside files of a user's own
MODELINE = "# yaml-language-server: $schema="


def schema(kind: str) -> Schema:
    """The schema of a kind of files, one of `KINDS_OF_FILES`."""
    return KINDS_OF_FILES[kind]()


def schema_text(kind: str) -> str:
    """The same as the text of a file."""
    content = schema(kind)
    lines = [
        f"  {json.dumps(name)}: {json.dumps(definition)}"
        for name, definition in content.pop("definitions", {}).items()
    ]
    head = json.dumps(content, indent=1)
    if not lines:
        return f"{head}\n"
    return head[:-2] + ',\n "definitions": {\n' + ",\n".join(lines) + "\n }\n}\n"


def modeline(file: Path, place: Path) -> str:
    """The line in a file that tells an editor where its schema is.

    Args:
        file: The file.
        place: The file of the schema.
    """
    return f"{MODELINE}{Path(os.path.relpath(place, file.parent)).as_posix()}"


def put_beside(kind: str, file: Path) -> str:
    """Keep the schema of a kind in the folder `.gaitlab` beside a file, as this version has it.

    A path of its own folder stays right when the folder is moved, shared or checked in, which one
    of this machine would not.

    Returns:
        The line for the file that names it.

    Raises:
        StoreError: If it cannot be written.
    """
    place, text = file.parent / BESIDE_FILES / f"{kind}.json", schema_text(kind)
    if not place.is_file() or place.read_text(encoding="utf-8") != text:
        write_text(place, text)
    return modeline(file, place)


def _experiment() -> Schema:
    """An experiment, a study, a reproduction of several, or a base, which has no name."""
    alone = {"required": ["surfaces"], "anyOf": [{"required": ["walkers"]}, _both("robot", "gait")]}
    filled = {key: {"not": NOTHING} for key in (*Sections.__dataclass_fields__, "walkers")}
    needs_nothing = [{"required": [key]} for key in ("include", "reproduction")]
    return document(
        "An experiment or a study of gaitlab",
        {
            **_sections(),
            "allOf": [
                *_named_parts(),
                chosen({"anyOf": needs_nothing}, {}, {"properties": filled}),
                chosen(
                    {"required": ["name"], "not": {"anyOf": needs_nothing}},
                    alone,
                ),
                *(_not_both("study", key) for key in BESIDE),
                *(_not_both("walkers", key) for key in ("robot", "gait")),
            ],
        },
        _definitions(),
    )


def _both(*keys: str) -> Schema:
    return {"required": list(keys)}


def _not_both(*keys: str) -> Schema:
    """A key that is left empty is none."""
    return {"not": {**_both(*keys), "properties": {key: {"not": NOTHING} for key in keys}}}


def _sections() -> Schema:
    """The top-level keys of an experiment file."""
    listed = {"$ref": "#/definitions/listed"}
    table = parameter_table(Sections)
    own: dict[str, Schema] = {
        "include": {**TEXT, "description": "a base file; where both have a value this one wins"},
        "name": {**TEXT, "pattern": r"^[A-Za-z0-9{][A-Za-z0-9_.{}-]{0,99}$"},
        "robot": {"$ref": "#/definitions/robot"},
        "gait": {"$ref": "#/definitions/gait"},
        "balance": {"$ref": "#/definitions/balance"},
        "walkers": list_schema({"$ref": "#/definitions/walker"}),
        "depends": list_schema({**TEXT, "pattern": r"[/\\.]"}),
        "metrics": list_schema(file_schema(*SUFFIXES["metric"]), least=0),
        "surfaces": {**list_schema(name_schema("surface")), "uniqueItems": True},
        "surface": mapping(_surface_settings()),
        "servo": {"$ref": "#/definitions/servo"},
        "grid": listed,
        "zip": chosen({"type": "array"}, {"items": listed}, listed),
        "one_at_a_time": listed,
        "design": _design(),
        "study": _study(),
        "seeds": _seeds(),
        "report": _report(),
    }
    described = {
        key: {**content, "description": table[key].doc} if key in table else content
        for key, content in own.items()
    }
    reproduction = mapping({}, ("members", "sections"), closed=False, doc="several on one page")
    sections = object_schema(Sections, further={**described, "reproduction": reproduction})
    properties = {
        key: {"anyOf": [content, NOTHING], "description": content.get("description", "")}
        for key, content in sections["properties"].items()
    }
    return {**sections, "properties": properties}


def _seeds() -> Schema:
    several = list_schema({"type": "integer", "minimum": 0, "maximum": LARGEST_SEED})
    return {
        "anyOf": [
            {"type": "integer", "minimum": 1, "maximum": MOST_SEEDS},
            {**several, "uniqueItems": True},
        ]
    }


def _report() -> Schema:
    """A name alone stands for a list of one."""
    found = object_schema(ReportSettings)
    metric = {"anyOf": [{"enum": list(metric_names())}, TEXT]}
    for key in LISTED:
        item = metric if key == "metrics" else TEXT
        said = found["properties"][key]["description"]
        listed = {"type": "array", "items": item}
        found["properties"][key] = {"anyOf": [item, listed], "description": said}
    pair = list_schema(TEXT)
    maps = {"anyOf": [pair, {"type": "array", "items": pair}]}
    found["properties"]["maps"] |= {"type": "array", "items": {}, **maps}
    return found


def _design() -> Schema:
    keys = {name: value_schema(item) for name, item in DESIGN_KEYS.items()}
    return mapping({**keys, "box": {"$ref": "#/definitions/boxed"}}, ("points", "box"))


def _study() -> Schema:
    off: Schema = {"enum": ["off", False]}
    racing_off: Schema = {"enum": ["on", "off", True, False]}
    racing = mapping(
        {
            "rounds": list_schema({"type": "integer", "minimum": 1}),
            "confidence": value_schema(CONFIDENCE),
        }
    )
    options = [
        mapping({**object_schema(cls)["properties"], "type": {"const": name}}, ("type",))
        for name, cls in SAMPLERS.items()
    ]
    keys = {
        **{name: value_schema(item) for name, item in PLAIN.items()},
        "sampler": {"anyOf": [{"enum": list(SAMPLERS)}, *options]},
        "search": {"$ref": "#/definitions/searched"},
        "objectives": _one_or_more(_objective()),
        "constraints": _one_or_more(_constraint(), least=0),
        "racing": {"anyOf": [racing_off, racing]},
        "early_stop": {"anyOf": [off, NOTHING, value_schema(EARLY_STOP)]},
        "confirm": value_schema(CONFIRM),
    }
    return mapping(keys)


def _one_or_more(item: Schema, *, least: int = 1) -> Schema:
    return chosen({"type": "array"}, list_schema(item, least=least), item)


def _compared() -> Schema:
    """A metric that candidates can be compared by, or one of the user's own."""
    shipped = [name for name in metric_names() if lookup(name).kind is not str]
    numbers = [name for name in shipped if name not in MISLEADING]
    others = [name for name in metric_names() if name not in numbers]
    return {"anyOf": [{"enum": numbers}, {**TEXT, "not": {"enum": others}}]}


def _aggregated() -> dict[str, Schema]:
    shares = [mapping({kind: value_schema(SHARE)}, (kind,)) for kind in SHARED]
    over = {"anyOf": [{"enum": list(WHOLE)}, *shares]}
    return {"seeds": over, "surfaces": over, "fallen": {"type": "number"}}


def _objective() -> Schema:
    keys: dict[str, Schema] = {way: _compared() for way in DIRECTIONS}
    keys |= _aggregated()
    return {**mapping(keys), "oneOf": [{"required": [way]} for way in DIRECTIONS]}


def _constraint() -> Schema:
    bounds = {bound: {"type": "number"} for bound in BOUNDS}
    written = mapping({"metric": _compared(), **bounds, **_aggregated()}, ("metric",))
    one = {**written, "oneOf": [{"required": [bound]} for bound in BOUNDS]}
    return {"anyOf": [{**TEXT, "pattern": f"^{COMPARED.pattern}$"}, one]}


def _named_parts() -> Iterator[Schema]:
    """Dotted paths as the named gait, robot or controller has them."""
    for kind in CODED:
        for name in names(kind):
            own = f"{kind}_{name}"
            named = {"anyOf": [{"const": name}, _of_type(name)]}
            paths = {key: {"$ref": f"#/definitions/listed_{own}"} for key in PATHS_AS_KEYS}
            listed = paths["zip"]
            paths["zip"] = chosen({"type": "array"}, {"items": listed}, listed)
            searched = {"properties": {"search": {"$ref": f"#/definitions/searched_{own}"}}}
            boxed = {"properties": {"box": {"$ref": f"#/definitions/boxed_{own}"}}}
            yield chosen(
                {"required": [kind], "properties": {kind: named}},
                {"properties": {**paths, "study": searched, "design": boxed}},
            )


def _of_type(name: str) -> Schema:
    return {"type": "object", "required": ["type"], "properties": {"type": {"const": name}}}


@cache
def _definitions() -> Mapping[str, Schema]:
    found = path_definitions()
    for kind in CODED:
        for name in names(kind):
            found[f"{kind}_{name}"] = _coded(kind, name, load_class(kind, name))
        found[kind] = _section(kind)
    return {**found, "servo": _servo_section(), "walker": _walker()}


def _coded(kind: str, name: str, cls: type) -> Schema:
    """The section of a shipped gait, robot or controller."""
    further: dict[str, Schema] = {"type": {"const": name}}
    if hasattr(cls, "of"):
        further["walk"] = {"$ref": f"#/definitions/{kind}"}
    made = object_schema(cls, further=further, closed=is_closed(cls), leave_out=FILLED_IN)
    return {**made, "description": (cls.__doc__ or "").partition("\n")[0]}


def _section(kind: CodeKind) -> Schema:
    """A name, or a mapping with the `type` and its parameters; the base may have said the type."""
    switch = [NO_BALANCE] if kind == "balance" else []
    name = name_schema(kind, *switch)
    typed = [
        chosen(
            {"required": ["type"], "properties": {"type": {"const": known}}},
            {"$ref": f"#/definitions/{kind}_{known}"},
        )
        for known in names(kind)
    ]
    named = {"type": "object", "properties": {"type": name}, "minProperties": 1, "allOf": typed}
    return chosen({"type": "object"}, named, name)


def _servo_section() -> Schema:
    name = name_schema("servo")
    return chosen({"type": "object"}, object_schema(Servo, further={"type": name}), name)


def _walker() -> Schema:
    sections = {
        **{key: {"$ref": f"#/definitions/{key}"} for key in (*CODED, "servo")},
        "engine": object_schema(SETTINGS["engine"]),
    }
    return mapping({key: sections.get(key, TEXT) for key in WALKER_KEYS})


def _surface_settings() -> dict[str, Schema]:
    """Parameters of any ground: those of the section `surface` are set on every one."""
    found: dict[str, Schema] = {}
    for cls in SURFACE_TYPES.values():
        for name, item in parameter_table(cls).items():
            found.setdefault(name, value_schema(item))
    return found


def _surface() -> Schema:
    typed = [
        chosen(
            {"required": ["type"], "properties": {"type": {"const": name}}},
            object_schema(
                cls, further={"type": {"const": name}, "description": TEXT}, required=True
            ),
        )
        for name, cls in SURFACE_TYPES.items()
    ]
    kind = {"enum": list(SURFACE_TYPES), "description": "what the ground is made of"}
    content = {"type": "object", "required": ["type"], "properties": {"type": kind}}
    return document("A surface of gaitlab", {**content, "allOf": typed}, {})


def _servo() -> Schema:
    content = object_schema(Servo, further={"description": TEXT}, required=True)
    return document("A servo of gaitlab", content, {})


def _robot() -> Schema:
    numbers = object_schema(Servo)
    stated = {**numbers, "required": ["stall_torque", "no_load_speed"]}
    servo = chosen({"type": "object"}, stated, name_schema("servo"))
    rules: Schema = {"type": "object", "additionalProperties": servo, "minProperties": 1}
    point = {**list_schema(value_schema(PLACE), least=3), "maxItems": 3}
    lump = mapping({"mass": value_schema(LUMP_MASS), "at": point, "link": TEXT}, ("mass", "at"))
    sole = {name: value_schema(item) for name, item in SOLE.items()}
    keys = {
        "urdf": {**file_schema(".urdf", ".xacro"), "description": "what it is described by"},
        "description": TEXT,
        "servos": {
            **chosen({"type": "object"}, rules, name_schema("servo")),
            "description": "a servo for all joints, or one a pattern of their names and `default`",
        },
        "mass": value_schema(MASS, origin=True),
        "add": {"type": "object", "additionalProperties": lump},
        "posture": {"type": "object", "additionalProperties": value_schema(ANGLE)},
        "legs": mapping({"left": TEXT, "right": TEXT}, ("left", "right")),
        "sole": mapping({**sole, "kind": {"enum": list(KINDS)}}),
        "forward": {"enum": list(FORWARD)},
    }
    return document("A robot of gaitlab, beside its URDF", mapping(keys, ("urdf",)), {})


KINDS_OF_FILES: dict[str, Callable[[], Schema]] = {
    "experiment": _experiment,
    "surface": _surface,
    "servo": _servo,
    "robot": _robot,
}
