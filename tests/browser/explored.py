"""A page in a browser, as somebody uses it: clicks and keys, and what can be read then."""

import numpy as np

PIXELS = """([x, y]) => {
  const plot = document.getElementById("diagram"), box = plot.getBoundingClientRect();
  const { xaxis, yaxis } = plot._fullLayout;
  return [box.left + xaxis._offset + xaxis.d2p(x), box.top + yaxis._offset + yaxis.d2p(y)];
}"""
TRACES = """(id) => document.getElementById(id).data.map((t) => ({
  mode: t.mode, x: Array.from(t.x), y: Array.from(t.y), text: Array.from(t.text ?? []) }))"""


class Explored:
    """A page, with what its console said and what it asked for."""

    def __init__(self, page):
        self.page, self.problems, self.asked = page, [], []
        page.on("console", lambda message: self.problems.append(message.text))
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))

    def choose(self, name, value):
        self.page.select_option(f"#explorer-{name}", value)
        self.wait()

    def wait(self):
        self.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 50)))")

    def click(self, x, y):
        """Click where a point with these values on the axes is drawn."""
        left, top = self.page.evaluate(PIXELS, [float(x), float(y)])
        self.page.mouse.click(left, top)
        self.wait()

    def press(self, *keys):
        self.page.focus("#diagram")
        for key in keys:
            self.page.keyboard.press(key)
        self.wait()

    def row(self):
        """Return the row that is shown: names with texts."""
        cells = self.page.eval_on_selector_all(
            "#point-row tr", "rows => rows.map((r) => Array.from(r.cells, (c) => c.textContent))"
        )
        assert len({name for name, _ in cells}) == len(cells)
        return dict(cells)

    def traces(self, where):
        return self.page.evaluate(TRACES, where)

    def values(self, where, number=0):
        """Return the points of a line that is drawn, shape (2, n)."""
        trace = self.traces(where)[number]
        return np.array([[np.nan if v is None else v for v in trace[axis]] for axis in "xy"])

    def ranges(self):
        return self.page.evaluate(
            "() => ['xaxis', 'yaxis'].map((axis) => Array.from(document.getElementById('diagram').layout[axis].range))"
        )

    def options(self, name):
        return self.page.eval_on_selector_all(f"#explorer-{name} option", "all => all.map((o) => o.value)")

    def text(self, where):
        return self.page.text_content(where)


def write_value(value):
    """Return how a row writes a value of a table."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return "not computed"
    return value if isinstance(value, str) else repr(value)
