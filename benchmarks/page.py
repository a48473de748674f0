"""How large the page on a branch of many points is, and how long a browser takes with it: ``make page-times``."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tempfile
import time
from pathlib import Path

from pddecont.model import parse_document
from pddecont.report import render_page
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute
from tests.browser.chromium import open_browser

ROOT = Path(__file__).parent.parent
SIZES = (100, 1_000, 10_000)
RUN = """
model: ../models/wall_oscillator.yaml
steps:
  - {{name: transient, simulate: {{t_end: 100*pi}}}}
  - {{name: orbit, orbit: {{from: transient, stability: true}}}}
  - name: in_wall
    continue:
      from: orbit
      free: [wall]
      range: {{wall: [0.1, 0.6]}}
      stability: true
      max_points: {points}
      step: {{initial: {step}, max: {step}}}
"""
# About how long the branch is, in arclength.
LENGTH = 1.3
# Times that something is done to be timed; the middle one counts.
TURNS = 9
# Milliseconds until what an action changes is on the screen.
TIMED = """async (act) => {
  const times = [];
  for (let k = 0; k < TURNS; k++) {
    const begun = performance.now();
    await window.actions[act](k);
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    times.push(performance.now() - begun);
  }
  return times.sort((a, b) => a - b)[TURNS >> 1];
}""".replace("TURNS", str(TURNS))
ACTIONS = """() => {
  const plot = document.getElementById("diagram");
  const press = (key, shiftKey) => plot.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, bubbles: true }));
  window.actions = {
    zoom: (k) => press(k % 2 ? "-" : "+"),
    shift: () => press("ArrowRight", true),
    along: () => press("ArrowRight"),
  };
}"""


def make_page(points: int, folder: Path) -> tuple[int, Path, float]:
    """Return how many points a branch has, where the page on it is, and how long that took to write."""
    text = RUN.format(points=points, step=LENGTH / points)
    plan = load_run_plan(parse_document(text, str(ROOT / "configs" / "page.yaml")))
    results, page = folder / f"p{points}.h5", folder / f"p{points}.html"
    execute(plan, results)
    begun = time.perf_counter()
    found = read_results(results)
    page.write_text(render_page(found), encoding="utf-8")
    return len(found.step("in_wall")), page, time.perf_counter() - begun


def main() -> None:
    """Print one line a size."""
    print(
        f"{'points':>7} {'page MB':>8} {'written s':>10} {'ready s':>8} {'zoom ms':>8} {'shift ms':>9} {'along ms':>9}"
    )
    with tempfile.TemporaryDirectory() as folder, open_browser() as browser:
        for size in SIZES:
            points, path, written = make_page(size, Path(folder))
            page = browser.new_page(viewport={"width": 1400, "height": 1000})
            begun = time.perf_counter()
            page.goto(path.as_uri())
            page.wait_for_selector("#explorer[data-ready]", timeout=120_000)
            ready = time.perf_counter() - begun
            page.evaluate(ACTIONS)
            zoom, shift, along = (page.evaluate(TIMED, act) for act in ("zoom", "shift", "along"))
            megabytes = path.stat().st_size / 1e6
            print(
                f"{points:7d} {megabytes:8.2f} {written:10.2f} {ready:8.2f} {zoom:8.0f} {shift:9.0f} {along:9.0f}",
                flush=True,
            )
            page.close()


if __name__ == "__main__":
    main()
