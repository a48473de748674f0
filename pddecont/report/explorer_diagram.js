// The diagram: branches as lines, dots of sweeps and maps of basins on a canvas behind them, the chosen point before
// them.

// A click chooses the nearest point within so many pixels.
const NEAR = 30;
const HELP =
  "Diagram. Left and right arrows move along a branch, up and down to another step, page up and page down between " +
  "special points, plus and minus zoom, 0 shows all.";

class Diagram {
  constructor(place, explorer) {
    this.plot = make("div", {
      class: "plot",
      id: "diagram",
      tabindex: "0",
      role: "application",
      "aria-label": HELP,
    });
    this.behind = make("canvas", { class: "behind" });
    this.before = make("canvas", { class: "before" });
    place.append(this.behind, this.plot, this.before);
    this.explorer = explorer;
    this.layers = [];
  }

  // Draw what is switched on; 'keep' keeps the part of the plane that is shown.
  async draw(keep) {
    const { steps, x, y, basin, colourBy } = this.explorer.shownAs();
    this.layers = basin ? [] : steps.flatMap((step) => makeLayers(step, x, y));
    this.basin = basin;
    const traces = basin
      ? []
      : [
          ...this.layers
            .filter((layer) => layer.step.isBranch)
            .flatMap((layer) => drawLines(layer, this.explorer, colourBy)),
          ...markSpecial(this.layers),
        ];
    const ranges = keep && this.plot.layout ? this.ranges() : this.findRanges();
    const axis = (name, range, suffix) => ({
      title: { text: name === null ? "" : writeAxis(name, steps) + suffix, standoff: 8 },
      range,
      autorange: false,
      zeroline: false,
      showgrid: !basin,
      gridcolor: "#e8e8e8",
      showline: true,
      linecolor: "#666",
      ticks: "outside",
      exponentformat: "power",
    });
    const at = basin ? " at the start" : "";
    await Plotly.react(
      this.plot,
      [...traces, { x: [null], y: [null], mode: "markers", type: "scatter" }],
      {
        xaxis: axis(x, ranges[0], at),
        yaxis: axis(y, ranges[1], at),
        dragmode: "pan",
        hovermode: false,
        showlegend: false,
        margin: { l: 70, r: 14, t: 10, b: 52 },
        paper_bgcolor: "rgba(0,0,0,0)",
        plot_bgcolor: "rgba(0,0,0,0)",
        font: { size: 13 },
      },
      {
        scrollZoom: true,
        displaylogo: false,
        responsive: true,
        doubleClick: false,
        modeBarButtonsToRemove: ["toImage", "select2d", "lasso2d", "autoScale2d", "resetScale2d"],
      },
    );
    if (!this.listens) this.listen();
    this.paint();
    this.explorer.changed();
  }

  findRanges() {
    const basin = this.basin?.data.attractors,
      read = this.basin?.read;
    const xs = basin ? [read(basin.x)] : this.layers.map((layer) => layer.xs);
    const ys = basin ? [read(basin.y)] : this.layers.map((layer) => layer.ys);
    return [spread(xs, basin ? 0 : 0.04), spread(ys, basin ? 0 : 0.06)];
  }

  listen() {
    this.listens = true;
    for (const event of ["plotly_afterplot", "plotly_relayouting", "plotly_relayout"])
      this.plot.on(event, () => this.paint());
    this.plot.on("plotly_relayout", () => this.explorer.changed());
    let down = null;
    this.plot.addEventListener(
      "mousedown",
      (event) => {
        down = [event.clientX, event.clientY];
      },
      true,
    );
    window.addEventListener(
      "mouseup",
      (event) => {
        if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) this.click(event);
        down = null;
      },
      true,
    );
    this.plot.addEventListener("mousemove", (event) => {
      if (!event.buttons) this.explorer.hover(this.findNearest(event));
    });
    this.plot.addEventListener("dblclick", () => this.showAll());
  }

  showAll() {
    return this.showRanges(this.findRanges());
  }

  showRanges([x, y]) {
    return Plotly.relayout(this.plot, { "xaxis.range": x, "yaxis.range": y });
  }

  // The parts of both axes that are shown.
  ranges() {
    return [this.plot.layout.xaxis.range, this.plot.layout.yaxis.range].map((range) => Array.from(range));
  }

  showsAll() {
    return String(this.ranges()) === String(this.findRanges());
  }

  // Zoom by a factor about the middle, and move by shares of what is shown.
  zoom(factor, right = 0, up = 0) {
    const change = ([a, b], share) => {
      const middle = (a + b) / 2 + share * (b - a),
        half = ((b - a) / 2) * factor;
      return [middle - half, middle + half];
    };
    const [x, y] = this.ranges();
    return this.showRanges([change(x, right), change(y, up)]);
  }

  // Pixels of the plot from its left upper corner.
  toPixels(x, y) {
    const { xaxis, yaxis } = this.plot._fullLayout;
    return [xaxis._offset + xaxis.d2p(x), yaxis._offset + yaxis.d2p(y)];
  }

  isInside(left, top) {
    const { xaxis, yaxis } = this.plot._fullLayout;
    return (
      left >= xaxis._offset &&
      left <= xaxis._offset + xaxis._length &&
      top >= yaxis._offset &&
      top <= yaxis._offset + yaxis._length
    );
  }

  click(event) {
    const found = this.findNearest(event);
    if (found) this.explorer.select(found);
  }

  findNearest(event) {
    const box = this.plot.getBoundingClientRect(),
      left = event.clientX - box.left,
      top = event.clientY - box.top;
    if (!this.plot._fullLayout || !this.isInside(left, top)) return null;
    if (this.basin) return this.findCell(left, top);
    let best = null,
      least = NEAR * NEAR;
    for (const layer of this.layers) {
      for (let i = 0; i < layer.xs.length; i++) {
        const [px, py] = this.toPixels(layer.xs[i], layer.ys[i]),
          distance = (px - left) ** 2 + (py - top) ** 2;
        if (distance < least)
          [best, least] = [
            { step: layer.step, place: layer.places ? layer.places[i] : i, x: layer.xs[i], y: layer.ys[i] },
            distance,
          ];
      }
    }
    return best;
  }

  findCell(left, top) {
    const { xaxis, yaxis } = this.plot._fullLayout,
      own = this.basin.data.attractors,
      read = this.basin.read;
    const [xs, ys] = [read(own.x), read(own.y)];
    const [i, j] = [findIndex(xs, xaxis.p2d(left - xaxis._offset)), findIndex(ys, yaxis.p2d(top - yaxis._offset))];
    return { step: this.basin, place: read(own.map)[j * xs.length + i], x: xs[i], y: ys[j] };
  }

  // The first point that can be seen.
  findFirst() {
    for (const { step, xs, ys, places } of this.layers)
      for (let i = 0; i < xs.length; i++)
        if (Number.isFinite(xs[i]) && Number.isFinite(ys[i])) return { step, place: places ? places[i] : i };
    return null;
  }

  paint() {
    const { width, height } = this.plot._fullLayout ?? {};
    if (!width) return;
    const [behind, before] = [this.behind, this.before].map((canvas) => {
      canvas.width = width * devicePixelRatio;
      canvas.height = height * devicePixelRatio;
      canvas.style.width = `${width}px`;
      canvas.style.height = `${height}px`;
      const context = canvas.getContext("2d"),
        { xaxis, yaxis } = this.plot._fullLayout;
      context.scale(devicePixelRatio, devicePixelRatio);
      context.beginPath();
      context.rect(xaxis._offset, yaxis._offset, xaxis._length, yaxis._length);
      context.clip();
      return context;
    });
    if (this.basin) paintBasin(this, behind);
    for (const layer of this.layers) if (!layer.step.isBranch) paintDots(this, behind, layer);
    const chosen = this.explorer.chosen;
    for (const [x, y] of chosen ? this.placesOf(chosen) : []) {
      const [px, py] = this.toPixels(x, y);
      for (const [colour, line] of [
        ["white", 5],
        ["black", 2.5],
      ]) {
        before.strokeStyle = colour;
        before.lineWidth = line;
        before.beginPath();
        before.arc(px, py, 8, 0, 2 * Math.PI);
        before.stroke();
      }
    }
  }

  placesOf({ step, place, x, y }) {
    if (this.basin) return step === this.basin && x !== undefined ? [[x, y]] : [];
    const places = [];
    for (const layer of this.layers.filter((own) => own.step === step))
      for (let i = 0; i < layer.xs.length; i++)
        if ((layer.places ? layer.places[i] : i) === place) places.push([layer.xs[i], layer.ys[i]]);
    return places;
  }
}
