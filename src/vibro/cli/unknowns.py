"""What ``vibro solve`` finds where a quantity is left out: an amplitude, a frequency or a friction."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final, NamedTuple

from vibro.answers.unknowns import FRICTIONS, USUAL, Ratio, friction_answer, onset_answer, rest_answer
from vibro.cli.exit_codes import ExitCode
from vibro.cli.outputs import Outputs
from vibro.cli.request import request_of
from vibro.errors import InputError
from vibro.files.scene_files import SceneFile, read_scene_file
from vibro.quantities import (
    AMPLITUDES,
    DURATION,
    LEAST_SPEED,
    LOAD,
    QUANTITIES,
    RATES,
    SCALE,
    STANDS_FOR,
    checked_number,
    exact_number,
    given_unit,
    quantity_meant,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from vibro.answers.answer import Answer
    from vibro.cli.options import Options
    from vibro.quantities import Quantity

_NO_MACHINE: Final = (
    "--speed asks for an amplitude, which follows from the machine; vibro map FILE setting=10:100 --speed X"
    " shows the settings that reach a speed, and a typed setting=50 makes it find friction"
)
# In place of what is asked for, which has no effect on the answer; with the large friction fillings stick.
_ANY: Final = {"amplitude": "1", "frequency": "10"}
_SMALL, _LARGE = "1", "1e6"
_PAIR: Final = {"static_friction", "kinetic_friction"}
_TIME: Final = replace(DURATION, name="time")
# What says, if it is typed, that the drive is known; with a machine.
_DRIVES: Final = {False: {"amplitude", "stroke"}, True: {"setting", "voltage"}}


class _Known(NamedTuple):
    """Names of the quantities that are typed, and that stand in the scene file, and the file."""

    typed: set[str]
    own: set[str]
    file: SceneFile

    @classmethod
    def of(cls, options: Options) -> _Known:
        file = read_scene_file(options.scene) if options.scene else SceneFile("", {}, {})
        return cls({*options.given}, {*file.scene}, file)

    @property
    def slots(self) -> set[str]:
        """What the quantities describe: a stroke is an amplitude, a ratio a kinetic friction."""
        return {STANDS_FOR.get(name, name) for name in self.typed | self.own}

    @property
    def missing(self) -> set[str]:
        """What is not given of a line's amplitude and angle, of the frequency, and of friction."""
        moves = self.file.motion is not None or self.file.machine is not None
        is_line = not moves and self.slots.isdisjoint({*AMPLITUDES} - {"amplitude"})
        needed = {"frequency", *_PAIR, *(("amplitude",) if is_line else ())}
        return (needed | ({"drive_angle"} if is_line else set())) - self.slots

    @property
    def frictions(self) -> set[str]:
        """What is not given of friction; nothing where kinetic friction has a value, without static."""
        return set() if "kinetic_friction" in self.typed | self.own else self.missing & _PAIR


def sought(options: Options) -> str:
    """Return which of amplitude, frequency and friction is left out; empty unless it is one of them alone."""
    if len(options.files) > 1:
        return ""
    known = _Known.of(options)
    missing, machine, motion = known.missing, known.file.machine, known.file.motion
    own = {name: spec.quantity for name, spec in known.file.scene.items()}
    own |= {name: quantity_meant((text,), QUANTITIES[name]) for name, text in options.given.items()}
    sizes = [q.name for name, q in own.items() if STANDS_FOR.get(name, name) == "amplitude"]
    has_list = any({",", ":"} & {*text} for text in options.given.values())
    if has_list or ("filling" in known.typed and machine is None):
        return ""
    if "static_friction" in known.frictions and missing <= _PAIR:
        return "friction"
    is_free = machine is None and motion is None and RATES.keys().isdisjoint(sizes[-1:])
    if missing == {"amplitude"} or (missing == {"frequency"} and is_free):
        return missing.pop()
    return ""


def begins(name: str, options: Options, *, every: bool) -> int:
    """Tell where each motion begins, or of friction at which nothing slips, and print it."""
    if name == "friction":
        ratio, changed = _without_friction(options, _Known.of(options), _LARGE)
        request = request_of(changed, FRICTIONS)
        return _answered(lambda: rest_answer(request, ratio), request.name, options, every=every)
    changed = options.of(*options.files, given={**options.given, name: _ANY[name]})
    request = request_of(changed, (name, LOAD.name))
    return _answered(lambda: onset_answer(request, name), request.name, options, every=every)


def target(
    speed_text: str | None,
    time_text: str | None,
    options: Options,
    unused: Sequence[str],
    *,
    every: bool,
    hopping: bool,
) -> int:
    """Find the amplitudes, or the frictions, for a speed, and print them."""
    from vibro.answers.target import target_answer

    if speed_text is not None and time_text is not None:
        raise InputError("--speed and --time are given", hint="give one of them")
    option = "--speed" if time_text is None else "--time"
    if len(options.files) > 1:
        raise InputError(
            f"{option} with {len(options.files)} files: it takes one", hint="leave the others out"
        )
    known = _Known.of(options)
    missing = known.missing
    if "static_friction" in missing and not known.frictions and missing <= _PAIR:
        hint = f"add it, or leave --mu-d out: {option} then finds friction"
        raise InputError("missing: static friction (--mu-s)", hint=hint)
    is_typed = not known.typed.isdisjoint(_DRIVES[known.file.machine is not None])
    is_pair = "kinetic_friction" in known.typed or {"static_friction", "friction_ratio"} <= known.typed
    finds_friction = bool(known.frictions) or (is_typed and not is_pair)
    if finds_friction and "amplitude" in missing:
        if missing <= {"amplitude", *_PAIR}:
            raise InputError(
                f"neither amplitude nor friction is given: {option} finds one of them",
                hint="add -A 1, or --mu-s 0.5 --mu-ratio 0.8",
            )
        finds_friction = False  # the error lists all that is missing
    if "filling" in options.given and known.file.machine is None:
        unused = [*unused, "filling="]
    if unused:
        what = "friction" if finds_friction else "amplitudes"
        raise InputError(f"{option} finds {what}: {', '.join(unused)} cannot be used with it")
    quantity = LEAST_SPEED if time_text is None else _TIME
    text = speed_text or time_text or ""
    value = checked_number(text, quantity)
    if finds_friction:
        ratio, changed = _without_friction(options, known, _SMALL)
        request = request_of(changed, FRICTIONS)
    else:
        request = request_of(
            options, (LOAD.name,), asked_for=("amplitude", SCALE), without_machine=_NO_MACHINE
        )
    asked = _in_given_unit(text, quantity)
    if time_text is not None:
        if request.length is None:
            raise InputError("--time needs the length of the trough", hint="add -L 600, in mm")
        asked, value = f"{request.length:.10g} mm in {asked}", request.length / value

    def make() -> Answer:
        if finds_friction:
            return friction_answer(request, value, asked, ratio, hopping=hopping)
        return target_answer(request, value, asked, hopping=hopping)

    return _answered(make, request.name, options, every=every)


def _without_friction(options: Options, known: _Known, static: str) -> tuple[Ratio, Options]:
    """Return the ratio of frictions, and the options with any friction in place of that asked for."""
    given = {name: text for name, text in options.given.items() if name not in FRICTIONS}
    own, where = known.file.scene, options.scene.name if options.scene else ""
    is_typed = "static_friction" in known.typed and "friction_ratio" not in known.typed
    if is_typed or known.frictions == {"kinetic_friction"}:
        given |= {name: options.given[name] for name in ("static_friction",) if is_typed}
        given["friction_ratio"] = "1"
        return Ratio(None, "as it is given"), options.of(*options.files, given=given)
    ratio = USUAL
    if "friction_ratio" in options.given:
        value = checked_number(options.given["friction_ratio"], QUANTITIES["friction_ratio"])
        ratio = Ratio(value, f"at the ratio {value:g} that is given")
    elif "friction_ratio" in own or {"static_friction", "kinetic_friction"} <= {*own}:
        value = (
            own["friction_ratio"].value
            if "friction_ratio" in own
            else own["kinetic_friction"].value / own["static_friction"].value
        )
        ratio = Ratio(value, f"at the ratio {value:.4g} of {where}")
    given |= {"static_friction": static, "kinetic_friction": static}
    return ratio, options.of(*options.files, given=given)


def _in_given_unit(text: str, quantity: Quantity) -> str:
    """Write a valid number in the unit that it was given in."""
    unit, size = given_unit(text, quantity)
    return f"{float(exact_number(text, quantity) / size):.15g} {unit}"


def _answered(make: Callable[[], Answer], name: str | None, options: Options, *, every: bool) -> int:
    with Outputs(options, name or "vibro-solve", forms=("json", "html"), pictures=()) as outputs:
        with options.console.progress("searching", None):
            answer = make()
        outputs.write_answer(answer)
    outputs.print_answer(answer, every=every)
    return ExitCode.DONE if answer.record.get("met", True) else ExitCode.NOT_MET
