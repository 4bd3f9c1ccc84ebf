"""The form of the page: inputs named by the keys of the state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from urllib.parse import urlencode

from vibro.explore.controls import BANDS, CONTROLS, DRIVEN, PRESETS, VIEWS, drives_of
from vibro.explore.markup import Html, tag
from vibro.explore.state import typed_number
from vibro.explore.words import symbol_of, unit_of
from vibro.quantities import LEAST_SPEED, MACHINE, QUANTITIES, SWEPT

if TYPE_CHECKING:
    from vibro.explore.state import State

__all__ = ["form_html"]

_NO_BANDS: Final = {f"{name}_band": "" for name in BANDS}
_NO_AXES: Final = {"x": "", "y": "", "x_range": "", "y_range": ""}


def form_html(initial: State) -> str:
    """Return the fieldsets of the form, with the drives of the initial state and sliders that reach it."""
    drives = initial.drives
    rows = {
        name: _quantity(name, initial)
        for name in CONTROLS
        if name != "friction_ratio" and drives_of(name, drives)
    }
    frictions = [rows.pop("static_friction"), rows.pop("kinetic_friction")]
    of_machine = [rows.pop(name) for name in MACHINE if name in rows]
    of_machine[-1:-1] = _packs(initial)
    of_drive = {"frequency", *(name for drive in drives.values() for name in drive.quantities)}
    return "\n".join(
        [
            _fieldset(
                "Map",
                _pair("view", "Show", _select("view", [_option(*view) for view in VIEWS.items()])),
                _axis("x", "Horizontal axis", "Across", initial),
                _axis("y", "Vertical axis", "Up", initial),
                _pair("target", "Target speed", _measure("target", unit_of(LEAST_SPEED), placeholder="none")),
            ),
            _fieldset(
                "Drive",
                _pair("preset", "Preset", _select("preset", _presets())),
                tag("input", type="hidden", name="motion"),
                _pair("drive", "Motion", _select("drive", _drives(initial))),
                *(row for name, row in rows.items() if name in of_drive),
            ),
            *([_fieldset("Machine", *of_machine, data_drives=DRIVEN)] if of_machine else []),
            _fieldset(
                "Friction",
                *frictions,
                _tick("follow", "kinetic friction follows static friction"),
                _tick("bands", "friction is not known exactly", aria_describedby="no-bands"),
                tag(
                    "p",
                    "only for drives along a line, and for frictions that are not an axis",
                    id="no-bands",
                    class_="note",
                ),
                *(_band(name, initial) for name in BANDS),
            ),
            _fieldset("Trough and body", *(row for name, row in rows.items() if name not in of_drive)),
        ]
    )


def _fieldset(legend: str, *rows: str, **attributes: object) -> Html:
    return tag("fieldset", tag("legend", legend), *rows, **attributes)


def _input(key: str, **attributes: object) -> Html:
    return tag("input", name=key, aria_describedby=f"note-{key}", spellcheck="false", **attributes)


def _measure(key: str, unit: str, **attributes: object) -> Html:
    box = _input(key, id=key, **attributes)
    return tag("span", box, tag("i", unit), class_="measure")


def _select(key: str, options: list[Html]) -> Html:
    return tag("select", *options, id=key, name=key, aria_describedby=f"note-{key}")


def _option(value: str, label: str, **attributes: object) -> Html:
    return tag("option", label, value=value, **attributes)


def _presets() -> list[Html]:
    given = [
        _option(name, preset.label, data_patch=urlencode({**_NO_BANDS, **preset.state}))
        for name, preset in PRESETS.items()
    ]
    return [_option("", "choose one", data_patch=""), *given]


def _drives(initial: State) -> list[Html]:
    return [
        _option(name, drive.label, data_patch=urlencode({**_NO_AXES, **_NO_BANDS, "drive": name}))
        for name, drive in initial.drives.items()
    ]


def _packs(initial: State) -> list[Html]:
    """Write the choice of a spring pack, which sets its natural frequency; none without packs."""
    machine, column = initial.file.machine, QUANTITIES["natural"].column
    packs = [
        _option(name, name, data_patch=urlencode({column: typed_number(natural)}))
        for name, natural in (machine.packs if machine else {}).items()
    ]
    if not packs:
        return []
    other = _option("", "another one", data_patch="")
    return [_pair("pack", "Spring pack", _select("pack", [*packs, other]))]


def _note(key: str) -> Html:
    return tag("p", id=f"note-{key}", class_="note error")


def _tick(key: str, label: str, **attributes: object) -> Html:
    box = tag("input", type="checkbox", id=key, name=key, **attributes)
    return tag("label", box, label, class_="tick")


def _pair(key: str, label: str, box: Html) -> Html:
    return tag("div", tag("label", label, for_=key), box, _note(key), class_="pair")


def _axis(key: str, name: str, label: str, initial: State) -> Html:
    drives = {name: drives_of(name, initial.drives) for name in CONTROLS if name in SWEPT}
    quantities = [QUANTITIES[name] for name, several in drives.items() if several]
    options = [
        _option(
            quantity.column,
            f"{quantity.label} [{unit_of(quantity)}]" if quantity.unit else quantity.label,
            data_drives=" ".join(drives[quantity.name]),
        )
        for quantity in quantities
    ]
    ends = [
        part
        for number, end in enumerate(("from", "to"))
        for part in (
            tag("label", end, for_=f"{key}-{end}"),
            _input(f"{key}_range", id=f"{key}-{end}", data_part=number),
        )
    ]
    log = _input(f"{key}_range", type="checkbox", id=f"{key}-log", data_part=2, value="log")
    return tag(
        "div",
        tag("label", label, for_=key),
        _select(key, options),
        *ends,
        tag("label", log, "log", class_="tick"),
        _note(f"{key}_range"),
        _note(key),
        class_="axis",
        role="group",
        aria_label=name,
    )


def _slider(key: str, name: str, label: str, initial: State, **attributes: object) -> Html:
    own = initial.drives[initial.texts["drive"]].controls
    low, high, step, _ = own.get(name, CONTROLS[name])
    value = float(initial.texts.get(QUANTITIES[name].column) or low)
    if not low <= value <= high:
        allowed = QUANTITIES[name].allowed
        low = max(min(low, value, 2.0 * value), allowed.low)
        high = min(max(high, value, 2.0 * value), allowed.high)
    label = f"{label}, slider"
    return _input(key, type="range", min=low, max=high, step=step, aria_label=label, **attributes)


def _quantity(name: str, initial: State) -> Html:
    """Write a text with a unit, and a slider."""
    quantity = QUANTITIES[name]
    key, unit = quantity.column, unit_of(quantity)
    symbol = tag("i", symbol_of(quantity))
    return tag(
        "div",
        tag("label", f"{quantity.label} ", symbol, for_=key, title=quantity.meaning),
        _measure(key, unit),
        _slider(key, name, quantity.label, initial, data_unit=unit),
        _note(key),
        class_="quantity",
        id=f"row-{key}",
        data_drives=" ".join(drives_of(name, initial.drives)),
    )


def _band(name: str, initial: State) -> Html:
    """Write two texts and two sliders: the ends of a band of friction."""
    key, label = f"{name}_band", QUANTITIES[name].label
    texts, sliders = [], []
    for number, end in enumerate(("least", "most")):
        texts.append(tag("label", end, for_=f"{key}-{end}"))
        texts.append(_input(key, id=f"{key}-{end}", data_part=number, placeholder="exact"))
        sliders.append(_slider(key, name, f"{end} {label}", initial, data_part=number, data_unit=""))
    return tag(
        "div",
        tag("span", label),
        *texts,
        *sliders,
        _note(key),
        class_="band",
        id=f"row-{key}",
        role="group",
        aria_label=f"band of {label}",
    )
