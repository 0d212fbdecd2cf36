# SPDX-License-Identifier: Apache-2.0
"""Commands for a board on a serial port, and the virtual board that takes its place."""

from __future__ import annotations

import math
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.shared import RUNS_DIR, CommandError, SetOption, make_folder, shown_stages
from wavehaptics.scene import find_scene, load_scene

if TYPE_CHECKING:
    from wavehaptics.host.capture import Captured, Plan, Progress
    from wavehaptics.host.client import Client
    from wavehaptics.host.identify.result import Row
    from wavehaptics.host.names import Place
    from wavehaptics.host.stream import Stream, Streamed

SCOPE_SCENE = "live_wall"
"""What the scope's virtual board has behind it unless another scene is named."""

SCOPE_HTTP_PORT = 8317

board = typer.Typer(
    help="Talk to a board over its serial line, or be one without hardware (--virtual).",
    invoke_without_command=True,
)
app = typer.Typer()
app.add_typer(board, name="board")


def _finite(value: float | None) -> float | None:
    """A number of an option: a range alone lets nan through, and one without an end inf."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"{value} is not a finite number.")
    return value


PortOption = Annotated[
    str, typer.Option("--port", metavar="PATH", envvar="WH_PORT", help="The serial port.")
]
UnitOption = Annotated[int, typer.Option(min=1, max=247, help="Unit of the device.")]
TimeoutOption = Annotated[
    float,
    typer.Option(min=0.01, max=3600, callback=_finite, help="Seconds to wait for an answer."),
]
MotorOption = Annotated[int, typer.Option(min=0, max=7, help="The motor whose words are meant.")]
CountsOption = Annotated[
    int | None, typer.Option(min=1, help="Of the encoder, for the position in rad.")
]
PresetOption = Annotated[
    str | None, typer.Option(metavar="MOTOR", help="A motor's preset, for the torque.")
]
TorqueOption = Annotated[
    float | None,
    typer.Option("--k-t", min=0, callback=_finite, help="Or its torque constant, N·m/A."),
]
RawOption = Annotated[bool, typer.Option("--raw", help="Raw words in place of values in SI units.")]
DEFAULT_TIMEOUT = 5.0
SCOPE_TIMEOUT = 2.0
STREAMED = ("position", "current", "voltage", "flags")
"""What a stream has by default."""
STILL_S = 30.0
"""Wall-clock time without a packet after which none comes, on a slow simulated board as well."""


@contextmanager
def _refusals() -> Iterator[None]:
    """What the host can't do, as refusals of the command."""
    from wavehaptics.host.names import HostError

    try:
        yield
    except HostError as error:
        raise CommandError(str(error)) from None


def _client(port: str, unit: int, timeout: float) -> Client:
    from wavehaptics.host.client import Client

    if not port:
        raise CommandError("no port: name one with --port PATH, or in WH_PORT")
    return Client(port, unit, timeout)


@board.callback()
def be_virtual(
    context: typer.Context,
    virtual: Annotated[
        str | None,
        typer.Option(metavar="SCENE", help="Be a board with this scene's motor and hand."),
    ] = None,
    overrides: SetOption = None,
    paced: Annotated[
        bool, typer.Option("--paced", help="With --virtual: no faster than real time.")
    ] = False,
    seconds: Annotated[
        float | None,
        typer.Option(
            min=0, callback=_finite, help="With --virtual: end after so much simulated time, s."
        ),
    ] = None,
    link: Annotated[
        Path | None,
        typer.Option(metavar="PATH", help="With --virtual: a symbolic link to its port."),
    ] = None,
    hand: Annotated[
        Path | None,
        typer.Option(metavar="PATH", help="With --virtual: a socket that leads the scene's hand."),
    ] = None,
    tied: Annotated[
        bool, typer.Option("--tied", help="With --virtual: end with the standard input.")
    ] = False,
) -> None:
    """Be a virtual board, or leave it to the command that follows."""
    if context.invoked_subcommand is not None:
        if virtual is not None:
            raise CommandError(
                f"board --virtual runs by itself; type `board {context.invoked_subcommand}` "
                "in another terminal"
            )
        return
    if virtual is None:
        raise CommandError(
            "board: give a command, or --virtual SCENE; wavehaptics board --help lists them"
        )
    loaded = load_scene(find_scene(virtual), overrides or ())
    if link is not None and link.exists() and not link.is_symlink():
        raise CommandError(f"--link {link}: is there and no link; name another path")
    if hand is not None and (hand.exists() and not hand.is_socket()):
        raise CommandError(f"--hand {hand}: is there and no socket; name another path")
    if hand is not None and (loaded.hand is None or loaded.hand.path == "impact"):
        raise CommandError(f"--hand {hand}: {loaded.scene.name} has no hand that can be led")

    from wavehaptics.host.led_hand import LedHand
    from wavehaptics.host.virtual import VirtualBoard
    from wavehaptics.ladder.linked_pins import LinkedPins

    if sys.stderr.isatty():
        print("building the simulated board: up to a minute the first time", file=sys.stderr)
    pins = LinkedPins(loaded)
    pins.elapse(1)  # compiles the loop
    asked = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: asked.append(True))
    with ExitStack() as kept:
        led = kept.enter_context(LedHand(hand, pins.hand_rad)) if hand is not None else None
        running = kept.enter_context(VirtualBoard(pins, link, led))
        print(running.path, flush=True)
        running.run(lambda: bool(asked) or (tied and _input_ended()), seconds, paced=paced)


def _input_ended() -> bool:
    """Whether the standard input has ended; what it holds is thrown away."""
    return bool(select.select([0], [], [], 0.0)[0]) and not os.read(0, 4096)


@board.command()
def info(
    port: PortOption = "", unit: UnitOption = 1, timeout: TimeoutOption = DEFAULT_TIMEOUT
) -> None:
    """Tell what the device is, and what its line has counted."""
    with _refusals():
        found = _client(port, unit, timeout).identification
    words = found.words
    shown = {
        "table of words": f"{words['table']:08x}",
        "build": f"{words['build']:08x}",
        "clock": f"{words['clock_hz'] / 1e6:g} MHz",
        "motors": words["motors"],
        "options": ", ".join(f"{name} {value}" for name, value in found.options.items() if value),
        **{
            name.replace("_", " "): words[name]
            for name in ("frames", "crc_errors", "framing_errors", "overruns")
        },
    }
    for name, value in shown.items():
        print(f"{name:<15} {value}")


def _shown(place: Place, raw: int, as_raw: bool) -> str:
    if as_raw:
        return f"0x{raw:08x}"
    value = place.value(raw)
    return f"{value:.9g}" if isinstance(value, float) else str(value)


@board.command()
def get(
    names: Annotated[list[str], typer.Argument(metavar="NAME...", help="NAME or NAME[INDEX].")],
    port: PortOption = "",
    motor: MotorOption = 0,
    raw: RawOption = False,
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Read words."""
    from wavehaptics.host.names import places, readable

    with _refusals():
        client = _client(port, unit, timeout)
        found = [readable(p) for name in names for p in places(name, client.shape, motor)]
        words = client.read(found)
    width = max(len(place.text) for place in found)
    for place, word in zip(found, words, strict=True):
        unit_text = "" if raw else place.word.row.unit
        print(f"{place.text:<{width}}  {_shown(place, word, raw)} {unit_text}".rstrip())


@board.command("set")
def set_words(
    values: Annotated[
        list[str], typer.Argument(metavar="NAME=VALUE...", help="In SI units, as docs/words.md.")
    ],
    port: PortOption = "",
    motor: MotorOption = 0,
    raw: RawOption = False,
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Write words; those of one group are given together."""
    from wavehaptics.host.names import HostError, number, places, settable

    with _refusals():
        client = _client(port, unit, timeout)
        words: dict[Place, int] = {}
        for text in values:
            name, _, value = text.partition("=")
            try:
                given = number(value.strip())
            except ValueError:
                raise HostError(f"{text}: write NAME=NUMBER, as in root=2.0") from None
            found = [settable(place) for place in places(name.strip(), client.shape, motor)]
            if len(found) > 1:
                raise HostError(f"{text}: which one? Take {found[0].text}...{found[-1].text}")
            if found[0] in words:
                raise HostError(f"{text}: {found[0].text} is there twice; leave one out")
            words[found[0]] = found[0].raw(given, is_raw=raw)
        frames = client.write(words.items())
    if frames > 1:
        print(f"{frames} frames, given one after another: the words aren't of one group")


@board.command()
def save(
    path: Annotated[Path, typer.Argument(metavar="FILE", help="A TOML file.")],
    port: PortOption = "",
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Save all settings of the device."""
    from wavehaptics.host import session

    with _refusals():
        count = session.save(_client(port, unit, timeout), path)
    print(f"{path}: {count} words")


@board.command()
def load(
    path: Annotated[Path, typer.Argument(metavar="FILE", help="A TOML file.")],
    port: PortOption = "",
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Give the device the settings of FILE: all of them, or none."""
    from wavehaptics.host import session

    with _refusals():
        changed, count = session.load(_client(port, unit, timeout), path)
    print(f"{path}: {count} words, of which {changed} were others")


@board.command()
def watch(
    names: Annotated[list[str], typer.Argument(metavar="NAME...", help="NAME or NAME[INDEX].")],
    port: PortOption = "",
    motor: MotorOption = 0,
    raw: RawOption = False,
    csv: Annotated[bool, typer.Option("--csv", help="Lines of CSV in place of a table.")] = False,
    count: Annotated[int | None, typer.Option("-n", min=1, help="So many times.")] = None,
    every: Annotated[
        float, typer.Option(min=0, max=3600, callback=_finite, help="Seconds between.")
    ] = 0.2,
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Read words again and again, until Ctrl-C."""
    from wavehaptics.host.names import places, readable

    with _refusals():
        client = _client(port, unit, timeout)
        found = [readable(p) for name in names for p in places(name, client.shape, motor)]
        start = time.monotonic()

        def samples() -> Iterator[tuple[float, list[str]]]:
            taken = 0
            while count is None or taken < count:
                if taken:
                    time.sleep(every)
                words = client.read(found)
                texts = [_shown(p, w, raw) for p, w in zip(found, words, strict=True)]
                yield time.monotonic() - start, texts
                taken += 1

        if csv:
            print(",".join(["t_s", *(place.text for place in found)]), flush=True)
            for moment, texts in samples():
                print(",".join([f"{moment:.3f}", *texts]), flush=True)
        else:
            _watch_table(found, raw, samples())


def _watch_table(found: list[Place], raw: bool, samples: Iterator[tuple[float, list[str]]]) -> None:
    from rich.live import Live
    from rich.table import Table

    with Live() as live:
        for moment, texts in samples:
            shown = Table("word", f"at {moment:.1f} s", "unit")
            for place, text in zip(found, texts, strict=True):
                shown.add_row(place.text, text, "" if raw else place.word.row.unit)
            live.update(shown, refresh=True)


@contextmanager
def _asked_to_end() -> Iterator[Callable[[], bool]]:
    """Whether SIGINT, SIGTERM or SIGHUP, of a terminal that is closed, came since."""
    asked: list[bool] = []
    kept = {n: signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    if kept[signal.SIGHUP] is signal.SIG_IGN:  # by nohup
        del kept[signal.SIGHUP]
    for number in kept:
        signal.signal(number, lambda *_: asked.append(True))
    try:
        yield lambda: bool(asked)
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)


@board.command()
def arm(
    port: PortOption = "",
    seconds: Annotated[
        float | None,
        typer.Option(min=0, callback=_finite, help="Disarm after so much time; else at Ctrl-C."),
    ] = None,
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Let the bridges on, and renew that until Ctrl-C; then disarm."""
    with _refusals():
        client = _client(port, unit, timeout)
        with _asked_to_end() as asked:
            try:
                _arm(client, asked, seconds)
            finally:
                _write_arm(client, 0)
    print("disarmed")


def _write_arm(client: Client, value: int) -> None:
    from wavehaptics.host.names import places

    client.write([(places("arm", client.shape)[0], value)])


def _arm(client: Client, asked: Callable[[], bool], seconds: float | None) -> None:
    from wavehaptics.host.client import RENEWAL_S, ZERO_S
    from wavehaptics.host.names import HostError, places
    from wavehaptics.words.faults import arm_refusal

    live = [places(name, client.shape)[0] for name in ("armed", "arm_refused")]
    if not client.identification.options["arm"]:
        raise HostError("the device can't be armed by a word; its switch alone lets it run")
    start, told = time.monotonic(), False
    _write_arm(client, 1)
    while not asked():
        armed, refused = client.read(live)
        passed = time.monotonic() - start
        if armed and not told:
            print("armed; Ctrl-C disarms", flush=True)
            told, start = True, time.monotonic()
        elif refused or (told and not armed):
            reason = arm_refusal(refused) or "somebody has disarmed it"
            cure = "`board faults` tells more, and --clear forgets what is over"
            raise HostError(f"{'disarmed' if told else 'not armed'}: {reason}; {cure}")
        elif not armed and passed > ZERO_S:
            raise HostError("not armed: the zero takes too long; are there ticks at all?")
        if told and seconds is not None and passed >= seconds:
            return
        time.sleep(RENEWAL_S)
        _write_arm(client, 2)


@board.command()
def disarm(
    port: PortOption = "", unit: UnitOption = 1, timeout: TimeoutOption = DEFAULT_TIMEOUT
) -> None:
    """Switch the bridges off."""
    with _refusals():
        _write_arm(_client(port, unit, timeout), 0)


@board.command()
def identify(
    counts: Annotated[
        int,
        typer.Option(min=4, max=4_000_000, help="Counts a turn of the encoder, all four edges."),
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A scene of it, and words for `load` beside."),
    ] = None,
    port: PortOption = "",
    motor: MotorOption = 0,
    current: Annotated[
        float | None, typer.Option(min=0.001, max=60, callback=_finite, help="Test current, A.")
    ] = None,
    travel: Annotated[
        float | None,
        typer.Option(
            min=0.01, callback=_finite, help="Room that the rotor has, rad; else it may turn."
        ),
    ] = None,
    expect: Annotated[
        str | None, typer.Option(metavar="PRESET", help="The motor that it should be.")
    ] = None,
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Identify the motor: it turns, for some seconds. Faults of the wiring are told by name."""
    from wavehaptics.host.identify.driver import Driver, EndedError
    from wavehaptics.host.identify.procedure import Wishes
    from wavehaptics.host.identify.procedure import identify as identified
    from wavehaptics.host.identify.result import rows, write
    from wavehaptics.parts.motors import PRESETS

    if expect is not None and expect not in PRESETS:
        raise CommandError(f"--expect {expect}: take {', '.join(PRESETS)}")
    wishes = Wishes(counts, current, travel, PRESETS[expect] if expect else None)
    with _refusals():
        client = _client(port, unit, timeout)
        with _asked_to_end() as asked:
            driver = Driver(client, motor, ended=asked)
            try:
                found = identified(driver, wishes, lambda line: print(line, flush=True))
            except EndedError:
                raise KeyboardInterrupt from None
    _identified_table(rows(found))
    if out is not None:
        with _refusals():
            print(*write(found, driver, out, motor), sep="\n")


def _identified_table(rows: Iterable[Row]) -> None:
    from rich.console import Console
    from rich.table import Table

    shown = Table("", "value", "±", "unit")
    for row in rows:
        shown.add_row(row.name, row.value, row.spread, row.unit)
    Console().print(shown)


@board.command()
def faults(
    clear: Annotated[bool, typer.Option("--clear", help="Forget those that are over.")] = False,
    port: PortOption = "",
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Tell what the guard found, and what disarmed the device."""
    from wavehaptics.host.names import places
    from wavehaptics.words.faults import FAULTS, arm_refusal, bits_of

    with _refusals():
        client = _client(port, unit, timeout)
        if clear:
            client.write([(places("clear", client.shape)[0], 1)])
        names = ("faults", "overrun", "armed", "arm_refused", "running")
        found = dict(
            zip(names, client.read(places(n, client.shape)[0] for n in names), strict=True)
        )
    for bit in bits_of(found["faults"]):
        name, meaning = FAULTS[bit]
        print(f"{name}: {meaning}" if meaning else name)
    if found["overrun"]:
        print("a tick is too short for its work, or ticks pass without")
    if found["arm_refused"]:
        print(f"not armed: {arm_refusal(found['arm_refused'])}")
    if not found["faults"] and not found["overrun"]:
        print("no faults")
    state = "on" if found["running"] else "armed, but off" if found["armed"] else "off"
    print(f"the bridges are {state}")


@board.command()
def capture(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Up to eight live words, or NAME@MOTOR; by default what a run's picture shows.",
        ),
    ] = None,
    trigger: Annotated[
        str,
        typer.Option(
            metavar="WHEN",
            help="now, contact, fault, NAME>VALUE, NAME<VALUE, 'NAME rises VALUE', "
            "'NAME falls VALUE', 'NAME changes'.",
        ),
    ] = "now",
    seconds: Annotated[
        float | None,
        typer.Option(min=0, callback=_finite, help="Of the device's time; else all that fits."),
    ] = None,
    pre: Annotated[
        float, typer.Option(min=0, callback=_finite, help="Seconds of these before the trigger.")
    ] = 0.0,
    decimate: Annotated[
        int | None,
        typer.Option(min=1, help="Ticks of a row, 1, 2, 4 ...; else the fewest that fit."),
    ] = None,
    counts_per_rev: CountsOption = None,
    preset: PresetOption = None,
    k_t: TorqueOption = None,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for trace.npz and capture.png.")
    ] = RUNS_DIR / "capture",
    port: PortOption = "",
    motor: MotorOption = 0,
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Capture live words at the tick's rate around a trigger; Ctrl-C takes what is there."""
    from wavehaptics.host import capture as captures
    from wavehaptics.host.captured_trace import device_of, save, trace_arrays

    constant = _torque_constant(preset, k_t)
    make_folder(out)
    with _refusals():
        client = _client(port, unit, timeout)
        plan = captures.plan(
            client, names or captures.PICTURED, seconds=seconds, decimation=decimate,
            trigger=trigger, before_s=pre, motor=motor,
        )  # fmt: skip
        device = device_of(client, motor, counts_per_rev, constant)
        with shown_stages() as show, _asked_to_end() as asked:
            captures.start(client, plan)

            def shown(progress: Progress) -> None:
                waits = progress.state == captures.WAITS
                show("waits for the trigger" if waits else "captures", progress.part)

            captures.wait(client, plan, shown, asked)
            found = captures.download(client, plan, lambda part: show("is read", part))
        if not len(found.t):
            raise CommandError("stopped before the first row: nothing was captured")
        arrays = trace_arrays(found, device)
        print(save(arrays, out))
        print(_capture_picture(plan, found, arrays, out / "capture.png"))
    for line in _capture_lines(plan, found):
        print(line)


@board.command()
def stream(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[WORD]...",
            help="Up to four live words: NAME or NAME@MOTOR, and :RANGE that it needs; by default "
            "position, current, voltage and flags.",
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(min=0, callback=_finite, help="Of the device's time; else until Ctrl-C."),
    ] = None,
    decimate: Annotated[
        int | None,
        typer.Option(min=1, help="Ticks of a row, 1, 2, 4 ...; else the fewest the line carries."),
    ] = None,
    arms: Annotated[
        bool, typer.Option("--arm", help="Arm meanwhile, as `board arm` does: the line is taken.")
    ] = False,
    counts_per_rev: CountsOption = None,
    preset: PresetOption = None,
    k_t: TorqueOption = None,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for trace.npz and stream.png.")
    ] = RUNS_DIR / "stream",
    port: PortOption = "",
    motor: MotorOption = 0,
    unit: UnitOption = 1,
    timeout: TimeoutOption = DEFAULT_TIMEOUT,
) -> None:
    """Receive live words row after row, as fast as the line is, until Ctrl-C."""
    from wavehaptics.host.captured_trace import device_of, save, trace_arrays
    from wavehaptics.host.stream import Stream

    constant = _torque_constant(preset, k_t)
    make_folder(out)
    with _refusals():
        client = _client(port, unit, timeout)
        device = device_of(client, motor, counts_per_rev, constant)
        with shown_stages() as show, _asked_to_end() as asked:
            live = Stream(client, names or STREAMED, decimation=decimate, motor=motor)
            with live:
                _receive(client, live, show, asked, seconds, arms=arms)
        found = live.found()
        if not len(found.t):
            raise CommandError("stopped before the first packet: nothing was received")
        arrays = trace_arrays(found, device)
        print(save(arrays, out))
        print(_capture_picture(found.plan, found, arrays, out / "stream.png"))
    for line in _stream_lines(found):
        print(line)


def _receive(
    client: Client,
    live: Stream,
    show: Callable[[str, float], None],
    asked: Callable[[], bool],
    seconds: float | None,
    *,
    arms: bool,
) -> None:
    """Wait until a stream is as long as it has to be, or somebody asks to end."""
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as pool:
        over: list[bool] = []
        try:
            arming = pool.submit(_arm, client, lambda: bool(over), None) if arms else None
            came, since = 0.0, time.monotonic()
            while not asked() and (seconds is None or live.seconds < seconds):
                live.check()
                if arming is not None and arming.done():
                    arming.result()
                if live.seconds > came:
                    came, since = live.seconds, time.monotonic()
                elif time.monotonic() - since > STILL_S:
                    raise CommandError("no packet comes; are there ticks, and is the ADC there?")
                stage = f"receives, {live.lost} packets lost" if live.lost else "receives"
                show(stage, live.seconds / seconds if seconds else 0.0)
                time.sleep(0.02)
        finally:
            over.append(True)
            if arms:
                pool.shutdown()
                _write_arm(client, 0)


def _stream_lines(found: Streamed) -> Iterator[str]:
    """What was received, and what wasn't."""
    plan = found.plan
    yield f"{len(found.t)} rows of {plan.row_s * 1e6:.6g} µs, {1 / plan.row_s:.6g} a second"
    yield from _channel_lines(plan, found)
    if found.lost_packets:
        yield (
            f"{found.lost_packets} packets were lost, {int(found.lost.sum())} rows: the device had "
            f"no room for {found.left_out}, {found.broken} frames came broken"
        )
    for name, rows in found.at_end.items():
        yield f"{name}: {rows} rows at the end of its 16 bits; take {name}:RANGE, a larger one"


def _torque_constant(preset: str | None, k_t: float | None) -> float | None:
    from wavehaptics.parts.motors import PRESETS

    if preset is None:
        return k_t
    if k_t is not None:
        raise CommandError("--preset and --k-t: give one of them")
    if preset not in PRESETS:
        raise CommandError(f"--preset {preset}: there is none; take {', '.join(PRESETS)}")
    return PRESETS[preset].k_t


def _capture_picture(plan: Plan, found: Captured, arrays: dict, path: Path) -> Path:
    from wavehaptics.trace.pictures import strips_picture

    bits = ("flags", "faults")
    shown = {
        name: (found[name], place.word.row.unit)
        for name, place in zip(plan.names, plan.channels, strict=True)
        if place.word.name not in bits or len(plan.names) == 1
    }
    title = f"{len(found.t)} rows of {plan.row_s * 1e6:.6g} µs"
    if plan.trigger.kind:
        title += f" · trigger: {plan.trigger.text}"
    return strips_picture(arrays, shown, title, path)


def _capture_lines(plan: Plan, found: Captured) -> Iterator[str]:
    """What was captured, a line for each channel."""
    at = "no trigger" if found.trigger_row is None else f"the trigger's is row {found.trigger_row}"
    yield f"{len(found.t)} rows of {plan.row_s * 1e6:.6g} µs; {at}"
    yield from _channel_lines(plan, found)


def _channel_lines(plan: Plan, found: Captured) -> Iterator[str]:
    width = max(len(name) for name in plan.names)
    for name, place in zip(plan.names, plan.channels, strict=True):
        values = found[name]
        if place.word.name in ("flags", "faults"):
            yield f"{name:<{width}}  {', '.join(_bit_names(place, values)) or 'none'}"
            continue
        there = values[values == values]  # a number; rows of a stream may be lost
        texts = (f"{value:.6g}" for value in (there.min(), there.mean(), there.max()))
        yield f"{name:<{width}}  {' ... '.join(texts)} {place.word.row.unit}".rstrip()


def _bit_names(place: Place, values: Iterable[int]) -> list[str]:
    """What was there in any row."""
    from wavehaptics.words.faults import FAULTS, FLAGS, bits_of

    there = 0
    for value in values:
        there |= int(value)
    if place.word.name == "flags":
        return [FLAGS[bit] for bit in bits_of(there)]
    return [FAULTS[bit][0] for bit in bits_of(there)]


@board.command()
def scope(
    port: PortOption = "",
    virtual: Annotated[
        str | None,
        typer.Option(
            metavar="SCENE",
            help=f"In place of a port: a virtual board of its own, by default with {SCOPE_SCENE}.",
        ),
    ] = None,
    scene: Annotated[
        str | None,
        typer.Option(metavar="SCENE", help="With a port: what motor, encoder and W are behind it."),
    ] = None,
    overrides: SetOption = None,
    k_t: Annotated[
        float | None,
        typer.Option(
            min=1e-4, max=10, callback=_finite, help="With a port: k_T of its motor, N·m/A."
        ),
    ] = None,
    counts: Annotated[
        int | None, typer.Option(min=4, help="With a port: its encoder's counts a turn.")
    ] = None,
    hand: Annotated[
        Path | None, typer.Option(metavar="PATH", help="With a port: the --hand of its board.")
    ] = None,
    http_port: Annotated[
        int, typer.Option(min=0, max=65535, help="Of the page; 0: any that is free.")
    ] = SCOPE_HTTP_PORT,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Open no browser with the page.")
    ] = False,
    motor: MotorOption = 0,
    unit: UnitOption = 1,
    timeout: TimeoutOption = SCOPE_TIMEOUT,
) -> None:
    """Show the board live on a page of this machine: push its wall, set it, stop it."""
    if virtual is not None and port:
        raise CommandError("--virtual is a board of its own: leave --port and WH_PORT out")
    told = {"--scene": scene, "--k-t": k_t, "--counts": counts, "--hand": hand}
    for option, value in told.items() if not port else ():
        if value is not None:
            raise CommandError(f"{option} goes with --port; a virtual board knows its own")
    if overrides and port and scene is None:
        raise CommandError("--set goes with a scene: name one with --scene")
    name = scene if port else virtual or SCOPE_SCENE
    path = find_scene(name) if name is not None else None
    if path is not None:
        load_scene(path, overrides or ())

    from wavehaptics.host.scope import command
    from wavehaptics.host.scope.bench import Known
    from wavehaptics.host.scope.plug import Plug, VirtualPlug

    known, sets = Known(), tuple(overrides or ())
    if path is not None:
        known = Known.of_scene(path, sets, starts=not port or hand is not None)
    known = known.but(k_t, counts)
    with _refusals():
        plug = Plug(port, hand) if port else VirtualPlug(str(path), sets)
        command.run(
            plug, known, http_port=http_port, browser=not no_browser, unit=unit, motor=motor,
            timeout_s=timeout,
        )  # fmt: skip
