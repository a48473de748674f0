"""Pictures of the page on five runs, docs/images/page_*.png: ``make page-pictures``."""

import io
import sys
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from pddecont import explore
from pddecont.model import parse_document
from pddecont.report import render_page
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute
from tests.browser.chromium import open_browser

ROOT = Path(__file__).parent.parent
IMAGES = ROOT / "docs" / "images"
WIDTH, HEIGHT = 1400, 1180
SIMULATED = """
model: ../models/impact_oscillator.yaml
effects: {off: [feedback]}
set: {beta: 40}
mesh: {degree: 8, tol: 1.0e-09}
steps:
  - {name: transient, simulate: {t_end: 200*2*pi/omega}}
  - {name: orbit, orbit: {from: transient, stability: true}}
  - {name: branch, continue: {from: orbit, free: [beta], range: {beta: [30, 45]}, stability: true}}
  - name: diagram
    sweep: {over: {beta: [30, 45, 61]}, initial: [{x: 0}, {x: -0.26, v: 1.74}], transient: 300*2*pi/omega}
  - {name: map, basin: {over: {x: [-2, 1.2, 60], v: [-2, 2, 60]}, transient: 150*2*pi/omega}}
"""


@dataclass(frozen=True)
class Shot:
    """A picture of a page: on which run, which view is chosen (empty: the first), and which keys are pressed."""

    name: str
    run: str
    view: str = ""
    keys: tuple[str, ...] = ()


SHOTS = (
    Shot("grazing", "fig4_6", keys=("Home", "PageDown", "PageDown")),
    Shot("delay", "mackey_glass", keys=("PageDown",)),
    Shot("lobes", "turning_lobes", "plane"),
    Shot("explored", "bouncing_ball"),
    Shot("basin", "simulated", "basins"),
)


def compute(name, path):
    """Do a run, or explore the ball, into the file at ``path``."""
    if name == "bouncing_ball":
        explore("bouncing_ball", {"G": [0.3, 1.2]}, output=path, overwrite=True)
        return
    places = [ROOT / folder / f"{name}.yaml" for folder in ("configs", "models")]
    place = next((p for p in places if p.exists()), ROOT / "configs" / f"{name}.yaml")
    text = place.read_text() if place.exists() else SIMULATED
    execute(load_run_plan(parse_document(text, str(place))), path, overwrite=True)


def take(browser, shot, folder):
    """Take one picture."""
    results, page = folder / f"{shot.run}.h5", folder / f"{shot.name}.html"
    if not results.exists():
        compute(shot.run, results)
    page.write_text(render_page(read_results(results)), encoding="utf-8")
    opened = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    opened.goto(page.as_uri())
    opened.wait_for_selector("#explorer[data-ready]")
    if shot.view:
        views = opened.eval_on_selector_all("#explorer-view option", "all => all.map((o) => o.value)")
        opened.select_option("#explorer-view", next(v for v in views if v.startswith(shot.view)))
        opened.wait_for_timeout(500)
    opened.focus("#diagram")
    for key in shot.keys:
        opened.keyboard.press(key)
    opened.evaluate("() => document.activeElement.blur()")
    opened.wait_for_timeout(500)
    image = Image.open(io.BytesIO(opened.screenshot()))
    image.quantize(64).save(IMAGES / f"page_{shot.name}.png", optimize=True)
    opened.close()


def main():
    """Take all of them; results that lie in the folder named on the command line are not computed again."""
    folder = Path(sys.argv[1]).absolute()
    with open_browser() as browser:
        for shot in SHOTS:
            take(browser, shot, folder)


if __name__ == "__main__":
    main()
