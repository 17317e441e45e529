"""The figures of a page as HTML takes them in: drawings of its own ink, or pictures as they are."""

from __future__ import annotations

import base64
import re
from html import escape
from pathlib import Path
from xml.etree import ElementTree

PICTURES = {".png": "image/png", ".gif": "image/gif", ".jpg": "image/jpeg", ".webp": "image/webp"}
DROPPED = frozenset({"metadata", "style", "script"})  # said in the page's own style sheet, or noise
MOST_TINT = 12  # between the channels of a colour that still is a grey
DARKEST, LIGHTEST = 0x15, 0xE4  # of a dark page: its paper and its ink
_GREY = re.compile(r"(?<!\()#([0-9a-fA-F]{2})([0-9a-fA-F]{2})([0-9a-fA-F]{2})\b")
_REFERENCE = re.compile(r"url\(#([^)]+)\)")


def figure(file: str, alt: str, folder: Path, number: int) -> str:
    """A figure of the page as HTML; its drawing if there is one, else its picture, else its text.

    Args:
        file: As the page names it, relative to its folder.
        alt: What a reader gets who cannot see it.
        folder: Of the page; files elsewhere are not taken in.
        number: Position on the page, which keeps the ids of drawings apart.
    """
    path = (folder / file).resolve()
    inside = path.is_relative_to(folder.resolve())
    drawing = path.with_suffix(".svg")
    if inside and drawing.is_file():
        content = inlined(drawing, alt, f"f{number}-")
        kind = "drawing bright" if "<image" in content else "drawing"
        return f'<figure class="{kind}">{content}</figure>'
    if inside and path.is_file() and path.suffix.lower() in PICTURES:
        content = base64.b64encode(path.read_bytes()).decode()
        data = f"data:{PICTURES[path.suffix.lower()]};base64,{content}"
        return f'<figure><img src="{data}" alt="{escape(alt)}"></figure>'
    return f'<figure class="absent"><figcaption>{escape(alt)}</figcaption></figure>'


def inlined(drawing: Path, alt: str, prefix: str) -> str:
    """An SVG file as an element of HTML that a reader can focus, with ids of its own.

    On a dark page its greys turn about, unless there are pictures in it, which are bright.
    """
    root = ElementTree.parse(drawing).getroot()
    _strip(root)
    if root.find(".//image") is None:
        for element in root.iter():
            for name, value in element.attrib.items():
                element.set(name, _GREY.sub(_both_ways, value))
    used = set(_references(root))
    for element in root.iter():
        _rename(element, used, prefix)
    width, height = root.attrib.pop("width", ""), root.attrib.pop("height", "")
    if "viewBox" not in root.attrib:
        root.set("viewBox", f"0 0 {_number(width)} {_number(height)}")
    root.attrib |= {"role": "img", "aria-label": alt, "tabindex": "0"}
    root.set("style", f"max-width: {width}" if width else "")
    return ElementTree.tostring(root, encoding="unicode")


def _number(length: str) -> str:
    return re.sub(r"[^\d.]", "", length) or "100"


def _strip(element: ElementTree.Element) -> None:
    """Plain names without name spaces, as HTML wants them; what is no drawing is dropped."""
    element.tag = _local(element.tag)
    given = {_local(name): value for name, value in element.attrib.items()}
    element.attrib.clear()
    element.attrib |= {
        name: _shorter(value) if name == "d" else value
        for name, value in given.items()
        if not name.startswith("on")
    }
    element.text = element.text if element.text and element.text.strip() else None
    element.tail = None if not (element.tail and element.tail.strip()) else element.tail
    for child in list(element):
        if _local(child.tag) in DROPPED:
            element.remove(child)
        else:
            _strip(child)


def _both_ways(grey: re.Match[str]) -> str:
    """A grey, black or white as it is on a light page, and turned about on a dark one."""
    level = [int(pair, 16) for pair in grey.groups()]
    if max(level) - min(level) > MOST_TINT:
        return grey[0]
    dark = round(DARKEST + (LIGHTEST - DARKEST) * (1.0 - sum(level) / (3 * 255)))
    return f"light-dark({grey[0]}, #{dark:02x}{dark + 3:02x}{dark + 7:02x})"


def _local(name: str) -> str:
    return name.rpartition("}")[2]


def _shorter(outline: str) -> str:
    """An outline without line ends, to the hundredth of a point."""
    rounded = re.sub(r"\d+\.\d{3,}", lambda found: f"{float(found[0]):.2f}", outline)
    return " ".join(rounded.split())


def _references(root: ElementTree.Element) -> list[str]:
    """Ids that something in the drawing refers to."""
    found = []
    for element in root.iter():
        for name, value in element.attrib.items():
            found += _REFERENCE.findall(value)
            if name == "href" and value.startswith("#"):
                found.append(value[1:])
    return found


def _rename(element: ElementTree.Element, used: set[str], prefix: str) -> None:
    """Prefix the ids that are referred to, and forget the others."""
    for name, value in list(element.attrib.items()):
        if name == "id" and value not in used:
            del element.attrib[name]
        elif name == "id":
            element.set(name, prefix + value)
        elif name == "href" and value.startswith("#"):
            element.set(name, f"#{prefix}{value[1:]}")
        else:
            element.set(name, _REFERENCE.sub(rf"url(#{prefix}\1)", value))
