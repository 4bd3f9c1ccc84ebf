"""How long until the page shows its map, and after a change the next one? In a browser.

Usage: python benchmarks/page.py [--changes 30] [--only TEXT] [--cores N]

Writes the page of ``vibro explore``, opens it in Chromium, moves a slider, and waits until the page has drawn
a map and the browser a frame. Needs the extra ``test`` and a Chromium.
"""

from __future__ import annotations

import argparse
import json
import shutil
import statistics
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Final

from playwright.sync_api import ViewportSize, sync_playwright

import vibro

if TYPE_CHECKING:
    from playwright.sync_api import Page

OPTIONS: Final = ("--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")
WINDOW: Final = ViewportSize(width=1400, height=900)
EXAMPLES: Final = Path(__file__).parents[1] / "examples"

# What is shown, which slider moves, and between which values.
CHANGES: Final = {
    "speed, contact alone": ("view=speed&x_range=5:14", "drive angle", 15.0, 30.0),
    "regimes, amplitude x frequency": ("", "drive angle", 15.0, 30.0),
    "speed, the same, flights at e = 0": ("view=speed", "drive angle", 15.0, 30.0),
    "speed, drive angle x static friction": (
        "view=speed&x=drive_angle_deg&y=static_friction", "frequency", 12.0, 20.0,
    ),
    "speed, restitution 0.3": ("view=speed&restitution=0.3", "drive angle", 15.0, 30.0),
    "speed of a friction band, sampled": (
        "view=speed&static_friction_band=0.6:0.8", "drive angle", 15.0, 30.0,
    ),
    "speed, ellipse": ("drive=ellipse&view=speed", "normal amplitude", 0.2, 0.5),
    "speed, second harmonic": ("drive=harmonics&view=speed", "normal amplitude", 0.2, 0.5),
}  # fmt: skip
MACHINE: Final = {
    "machine: speed, setting x voltage, empty": (
        "view=speed&x=setting_percent&y=voltage_percent&filling_kg=0", "natural frequency", 52.0, 60.0,
    ),
    "machine: regimes, frequency x filling": ("x=frequency_hz&y=filling_kg", "setting", 40.0, 90.0),
}  # fmt: skip

# Moves a slider, and returns how long it took until a map was drawn, and until that of all cells was [ms].
MOVE: Final = """
([name, value]) => new Promise((resolve) => {
  const slider = document.querySelector(`input[type=range][aria-label="${name}, slider"]`);
  const frame = document.querySelector("#frame");
  const start = performance.now();
  let first = 0;
  const seen = new MutationObserver(() => {
    const isWhole = !frame.textContent.includes("preview");
    requestAnimationFrame(() => setTimeout(() => {
      first ||= performance.now() - start;
      if (isWhole) { seen.disconnect(); resolve([first, performance.now() - start]); }
    }));
  });
  seen.observe(frame, { childList: true });
  slider.value = value;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
})
"""
#: When the page's map was first drawn, since it was asked for [ms].
START: Final = """
window.began = new Promise((resolve) => {
  const seen = new MutationObserver(() => {
    if (!document.querySelector("#frame > g")) return;
    seen.disconnect();
    requestAnimationFrame(() => setTimeout(() => resolve(performance.now())));
  });
  seen.observe(document, { childList: true, subtree: true });
});
"""


def moved(page: Page, slider: str, low: float, high: float, changes: int) -> list[tuple[float, float]]:
    """Move a slider so many times, and return how long each took until a map, and a whole one, was seen."""
    times = []
    for number in range(changes):
        value = low + (high - low) * ((7 * number) % changes) / changes
        times.append(tuple(page.evaluate(MOVE, [slider, f"{value:.3f}"])))
        page.wait_for_timeout(50)
    return times


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--changes", type=int, default=30)
    parser.add_argument("--only", default="", metavar="TEXT", help="in the names of what is measured")
    parser.add_argument("--cores", type=int, help="as many as the page is told of")
    given = parser.parse_args()
    program = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(OPTIONS))
        for name, changes in (("safety_nut", CHANGES), ("full_feeder", MACHINE)):
            path = Path(folder, f"{name}.html")
            vibro.page(EXAMPLES / f"{name}.toml").write(path)
            context = browser.new_context(viewport=WINDOW)
            context.add_init_script(START)
            if given.cores:
                cores = json.dumps(given.cores)
                context.add_init_script(
                    f"Object.defineProperty(navigator, 'hardwareConcurrency', {{value: {cores}}})"
                )
            page = context.new_page()
            starts = []
            for _ in range(5):
                page.goto("about:blank")
                page.goto(path.as_uri())
                starts.append(page.evaluate("window.began"))
            size = path.stat().st_size / 1000.0
            print(f"{name}: {size:.0f} kB, first picture {statistics.median(starts):.0f} ms after opening")
            print(
                f"{'from a change to its picture [ms]':42} {'first':>7} {'whole':>7} {'90 %':>7} {'most':>7}"
            )
            for case, (fragment, *slider) in changes.items():
                if given.only not in case:
                    continue
                page.goto("about:blank")
                page.goto(f"{path.as_uri()}#{fragment}")
                page.evaluate("window.began")
                page.wait_for_timeout(1000)
                moved(page, *slider, 3)
                times = moved(page, *slider, given.changes)
                firsts, wholes = (sorted(x) for x in zip(*times, strict=True))
                most = statistics.quantiles(wholes, n=10)[-1] if len(wholes) > 1 else wholes[0]
                numbers = (statistics.median(firsts), statistics.median(wholes), most, wholes[-1])
                print(f"{case:42} {' '.join(f'{x:7.0f}' for x in numbers)}")
            context.close()
        browser.close()


if __name__ == "__main__":
    main()
