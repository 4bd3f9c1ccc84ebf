"""How long after a change is a map seen, and when is it exact? In a browser.

Usage: python benchmarks/explore.py [--changes 30] [--sessions 10] [--only TEXT]

Starts ``vibro explore`` and Chromium, moves a slider, and waits until the page has drawn the answer and the
browser a frame. Needs the extra ``test`` and a Chromium.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, StorageState, ViewportSize, sync_playwright

OPTIONS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
WINDOW = ViewportSize(width=1400, height=900)
TIRED = 90.0  # [s] after which nobody waits any longer

# What is shown, which slider moves, and between which values.
CHANGES = {
    "regimes, amplitude x frequency": ("", "drive angle", 15.0, 30.0),
    "speed, the same": ("view=speed", "drive angle", 15.0, 30.0),
    "speed, contact alone": ("view=speed&x_range=5:14", "drive angle", 15.0, 30.0),
    "speed, drive angle x static friction": (
        "view=speed&x=drive_angle_deg&y=static_friction", "frequency", 12.0, 20.0,
    ),
    "regimes of a friction band": ("static_friction_band=0.6:0.8", "drive angle", 15.0, 30.0),
    "guaranteed speed of it": (
        "view=speed&static_friction_band=0.6:0.8", "drive angle", 15.0, 30.0,
    ),
    "speed, restitution .3": ("view=speed&restitution=0.3", "drive angle", 15.0, 30.0),
    "speed, ellipse": ("drive=ellipse&view=speed", "normal amplitude", 0.2, 0.5),
    "speed, second harmonic": ("drive=harmonics&view=speed", "normal amplitude", 0.2, 0.5),
}  # fmt: skip
# Until every cell is exact, or shows a load that is close to its own.
REFINED = {
    "amplitude x frequency": ("view=speed", ""),
    "drive angle x static friction, 30 Hz, 1.5 mm": (
        "view=speed&x=drive_angle_deg&y=static_friction&frequency_hz=30&amplitude_mm=1.5", "",
    ),
    "amplitude x frequency, restitution .3, a line of loads": ("view=speed&restitution=0.3", "within"),
    "amplitude x frequency, restitution .6, a line of loads": ("view=speed&restitution=0.6", "within"),
    "ellipse": ("drive=ellipse&view=speed", ""),
    "second harmonic": ("drive=harmonics&view=speed", ""),
}  # fmt: skip

# The same with the machine of a scene file.
FEEDER = Path(__file__).parents[1] / "examples" / "full_feeder.toml"
MACHINE_CHANGES = {
    "machine: regimes, frequency x filling": ("x=frequency_hz&y=filling_kg", "setting", 40.0, 90.0),
    "machine: speed, setting x filling": (
        "view=speed&x=setting_percent&y=filling_kg", "voltage", 90.0, 110.0,
    ),
    "machine: speed, setting x voltage, empty": (
        "view=speed&x=setting_percent&y=voltage_percent&filling_kg=0", "natural frequency", 52.0, 60.0,
    ),
}  # fmt: skip
MACHINE_REFINED = {
    "machine: frequency x filling": ("x=frequency_hz&y=filling_kg", ""),
    "machine: setting x filling": ("view=speed&x=setting_percent&y=filling_kg", ""),
}

# Moves a slider, and returns how long it took until the map was drawn anew, and a frame after it [ms].
MOVE = """
([name, value]) => new Promise((resolve) => {
  const slider = document.querySelector(`input[type=range][aria-label="${name}, slider"]`);
  const frame = document.querySelector("#stage svg > g");
  const start = performance.now();
  const seen = new MutationObserver(() => {
    seen.disconnect();
    requestAnimationFrame(() => setTimeout(() => resolve(performance.now() - start)));
  });
  seen.observe(frame, { childList: true });
  slider.value = value;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
})
"""
TEXT = "() => document.querySelector('#stage').textContent"


@contextmanager
def served(*arguments: str) -> Iterator[str]:
    """Start the explorer, and give its first address."""
    command = [sys.executable, "-m", "vibro", "explore", *arguments, "--no-open", "-q"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            yield server.stdout.readline().strip()
        finally:
            server.terminate()


def shown(page: Page, url: str, fragment: str) -> None:
    """Go to a state, and wait until its map is there."""
    page.goto("about:blank")
    page.goto(f"{url}#{fragment}")
    page.wait_for_selector("#stage svg > g > text")


def settled(page: Page, wanted: str = "") -> float:
    """Wait until a map is exact, or says what is wanted; return how long it took [s]."""
    start = time.perf_counter()
    while time.perf_counter() - start < TIRED:
        text = page.evaluate(TEXT)
        if (wanted and wanted in text) or not ("exact" in text or "preview" in text):
            return time.perf_counter() - start
        page.wait_for_timeout(10)
    return float("inf")


def moved(page: Page, url: str, case: tuple[str, str, float, float], changes: int) -> list[float]:
    """Move a slider so many times, and return how long each took [ms]."""
    fragment, slider, low, high = case
    shown(page, url, fragment)
    times = []
    for number in range(changes):
        value = low + (high - low) * ((7 * number) % changes) / changes
        times.append(page.evaluate(MOVE, [slider, f"{value:.3f}"]))
        page.wait_for_timeout(50)
    return times


def told(name: str, times: list[float]) -> None:
    """Print one line of the table of changes."""
    most = statistics.quantiles(times, n=10)[-1] if len(times) > 1 else times[0]
    print(f"{name:46} {statistics.median(times):7.0f} {most:7.0f} {max(times):7.0f}")


def crowded(browser: Browser, url: str, state: StorageState, sessions: int) -> list[float]:
    """Let many pages refine maps of bodies that bounce, and move a slider in one of them."""
    context = browser.new_context(storage_state=state, viewport=WINDOW)
    pages = [context.new_page() for _ in range(sessions)]
    for number, page in enumerate(pages):
        shown(page, url, f"view=speed&restitution=0.5&drive_angle_deg={20 + number}")
    case = CHANGES["speed, contact alone"]
    pages[0].bring_to_front()
    times = moved(pages[0], url, case, 10)
    context.close()
    return times


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--changes", type=int, default=30)
    parser.add_argument("--sessions", type=int, default=10)
    parser.add_argument("--only", default="", metavar="TEXT", help="in the names of what is measured")
    arguments = parser.parse_args()
    program = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(OPTIONS))
        for changes, refined, sessions, *scene in (
            (CHANGES, REFINED, arguments.sessions),
            (MACHINE_CHANGES, MACHINE_REFINED, 0, str(FEEDER)),
        ):
            some = {name: case for name, case in changes.items() if arguments.only in name}
            finer = {name: case for name, case in refined.items() if arguments.only in name}
            if some or finer:
                measure(browser, some, finer, arguments.changes, sessions, *scene)
        browser.close()


def measure(
    browser: Browser,
    changes: Mapping[str, tuple[str, str, float, float]],
    refined: Mapping[str, tuple[str, str]],
    number: int,
    sessions: int,
    *scene: str,
) -> None:
    """Print both tables of one scene."""
    with served(*scene) as first:
        context = browser.new_context(viewport=WINDOW)
        page = context.new_page()
        page.goto(first)
        page.wait_for_selector("#tables caption")
        url = first.partition("#")[0]
        shown(page, url, "")
        print(f"{'from a change to its picture [ms]':46} {'median':>7} {'90 %':>7} {'most':>7}")
        for name, case in changes.items():
            moved(page, url, case, 3)
            told(name, moved(page, url, case, number))
        if sessions:
            times = crowded(browser, url, context.storage_state(), sessions)
            told(f"speed, contact alone, {sessions} pages refine", times)
        print("\nfrom opening a map until it is exact [s]")
        for name, (fragment, wanted) in refined.items():
            # Another frequency each time: maps are kept.
            shown(page, url, f"{fragment}&trough_angle_deg=-{0.1 * (1 + len(name) % 7):.1f}")
            print(f"{name:56} {settled(page, wanted):6.2f}")
        context.close()


if __name__ == "__main__":
    main()
