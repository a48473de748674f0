// The diagram: branches as lines, dots of sweeps and maps of basins on a canvas behind them, the chosen point before them.

const DASHES = ["solid", "6px,4px", "1.5px,3px"],
  WIDTHS = [2.2, 1.8, 1.3];
const SYMBOLS = {
  GR: "circle",
  LP: "square",
  BP: "x",
  PD: "triangle-up",
  TR: "star",
  VS: "diamond",
  HB: "hexagon",
  UF: "cross-thin-open",
  EP: "line-ns-open",
  BE: "pentagon",
  EQ: "circle-open",
};
const MOST_LABELS = 60,
  NEAR = 30,
  MOST_CURVED = 2000,
  PIECES = 6,
  SAME_PLACE = 0.012;

class Diagram {
  constructor(place, explorer) {
    this.plot = make("div", {
      class: "plot",
      id: "diagram",
      tabindex: "0",
      role: "application",
      "aria-label":
        "Diagram. Left and right arrows move along a branch, up and down to another step, page up and page down between special points, plus and minus zoom, 0 shows all.",
    });
    this.behind = make("canvas", { class: "behind" });
    this.before = make("canvas", { class: "before" });
    place.append(this.behind, this.plot, this.before);
    this.explorer = explorer;
    this.layers = [];
  }

  // Draw what is switched on; 'keep' keeps the part of the plane that is shown.
  async draw(keep) {
    const { steps, x, y, basin, colourBy } = this.explorer.view();
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
    const ranges =
      keep && this.plot.layout ? [this.plot.layout.xaxis.range, this.plot.layout.yaxis.range] : this.findRanges();
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
    const [x, y] = this.findRanges();
    return Plotly.relayout(this.plot, { "xaxis.range": x, "yaxis.range": y });
  }

  // Zoom by a factor about the middle, and move by shares of what is shown.
  zoom(factor, right = 0, up = 0) {
    const change = ([a, b], share) => {
      const middle = (a + b) / 2 + share * (b - a),
        half = ((b - a) / 2) * factor;
      return [middle - half, middle + half];
    };
    return Plotly.relayout(this.plot, {
      "xaxis.range": change(this.plot.layout.xaxis.range, right),
      "yaxis.range": change(this.plot.layout.yaxis.range, up),
    });
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

// Points of a step in the plane of two columns: {step, xs, ys, places: whose points they are (none: one each)}.
function makeLayers(step, x, y) {
  if (!step.has(x)) return [];
  const xs = step.column(x),
    heights = step.heights(y);
  if (heights) return heights.map((ys) => ({ step, xs, ys }));
  const state = step.data.states.indexOf(y);
  if (!step.returns || state < 0) return [];
  const places = [],
    dots = [],
    across = [];
  for (let place = 0; place < step.n; place++) {
    if (!step.label(place)) continue;
    for (const value of step.returnsOf(place)[state]) {
      places.push(place);
      dots.push(value);
      across.push(xs[place]);
    }
  }
  return [{ step, xs: Float64Array.from(across), ys: Float64Array.from(dots), places }];
}

function drawLines(layer, explorer, colourBy) {
  const { step, xs, ys } = layer,
    traces = new Map(),
    joined = step.data.branch.joined;
  const along = joined && step.has("arclength") && step.n <= MOST_CURVED ? step.column("arclength") : null;
  for (const part of step.parts()) {
    const colour = explorer.colourOf(step, part.family, colourBy),
      key = `${part.style} ${colour}`;
    if (!traces.has(key)) traces.set(key, { x: [], y: [], style: part.style, colour });
    const trace = traces.get(key),
      end = part.start + part.n;
    const [px, py] = curve(
      along?.subarray(part.start, end),
      xs.subarray(part.start, end),
      ys.subarray(part.start, end),
    );
    for (const value of px) trace.x.push(value);
    for (const value of py) trace.y.push(value);
    trace.x.push(null);
    trace.y.push(null);
  }
  const alone = !joined || step.n < 3;
  return Array.from(traces.values(), ({ x, y, style, colour }) => ({
    type: "scatter",
    x,
    y,
    mode: alone ? "lines+markers" : "lines",
    line: { color: colour, width: WIDTHS[style], dash: DASHES[style], simplify: true },
    marker: {
      color: style ? "white" : colour,
      size: 8,
      line: { color: colour, width: 2 },
      symbol: style === 2 ? "x" : "circle",
    },
    connectgaps: false,
  }));
}

// Special points; what lies in one place has one text.
function markSpecial(layers) {
  const x = [],
    y = [],
    symbols = [],
    texts = [];
  const branches = layers.filter((layer) => layer.step.isBranch),
    ranges = ["xs", "ys"].map((name) =>
      spread(
        branches.map((layer) => layer[name]),
        0,
      ),
    );
  const [width, height] = ranges.map(([low, high]) => (high - low) * SAME_PLACE || 1);
  for (const { step, xs, ys } of branches) {
    for (let i = 0; i < step.n; i++) {
      const label = step.label(i);
      if (!label || step.pointKind(i) === "EP" || !Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) continue;
      const near = x.findIndex(
        (other, k) => texts[k].length && Math.abs(other - xs[i]) < width && Math.abs(y[k] - ys[i]) < height,
      );
      x.push(xs[i]);
      y.push(ys[i]);
      symbols.push(SYMBOLS[step.pointKind(i)] ?? "triangle-down");
      texts.push(near < 0 ? [label] : []);
      if (near >= 0 && !texts[near].includes(label)) texts[near].push(label);
    }
  }
  const text = texts.map((own) => escapeText(own.join(", ")));
  const mode = text.filter(Boolean).length <= MOST_LABELS ? "markers+text" : "markers";
  return x.length
    ? [
        {
          type: "scatter",
          x,
          y,
          text,
          mode,
          textposition: "top center",
          textfont: { size: 11, color: "#111" },
          cliponaxis: true,
          marker: { symbol: symbols, size: 8, color: "#111", line: { width: 1, color: "#111" } },
        },
      ]
    : [];
}

function paintDots(diagram, context, { step, xs, ys, places }) {
  const own = step.data.attractors,
    classes = step.read(own.class),
    size = xs.length > 5000 ? 1.6 : xs.length > 1000 ? 2.6 : 4;
  for (let i = 0; i < xs.length; i++) {
    const number = classes[places ? places[i] : i];
    context.fillStyle = own.colours[number];
    const [px, py] = diagram.toPixels(xs[i], ys[i]);
    context.fillRect(px - size / 2, py - size / 2, size, size);
  }
}

function paintBasin(diagram, context) {
  const step = diagram.basin,
    own = step.data.attractors,
    [xs, ys] = [step.read(own.x), step.read(own.y)],
    map = step.read(own.map);
  const colours = own.colours.map((colour) => [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16)));
  const image = new ImageData(xs.length, ys.length);
  for (let j = 0; j < ys.length; j++)
    for (let i = 0; i < xs.length; i++)
      image.data.set([...colours[map[j * xs.length + i]], 190], 4 * ((ys.length - 1 - j) * xs.length + i));
  const small = new OffscreenCanvas(xs.length, ys.length);
  small.getContext("2d").putImageData(image, 0, 0);
  const half = (values) => (values.length > 1 ? (values.at(-1) - values[0]) / (values.length - 1) / 2 : 0.5);
  const [left, top] = diagram.toPixels(xs[0] - half(xs), ys.at(-1) + half(ys));
  const [right, bottom] = diagram.toPixels(xs.at(-1) + half(xs), ys[0] - half(ys));
  context.imageSmoothingEnabled = false;
  context.drawImage(small, left, top, right - left, bottom - top);
  const states = own.over.map((name) => step.data.states.indexOf(name));
  for (let place = 0; place < step.n; place++) {
    if (!step.label(place)) continue;
    const returns = step.returnsOf(place),
      [us, vs] = states.map((k) => returns[k]);
    us.forEach((u, i) => {
      const [px, py] = diagram.toPixels(u, vs[i]);
      context.beginPath();
      context.arc(px, py, 5, 0, 2 * Math.PI);
      context.fillStyle = own.colours[place];
      context.fill();
      context.strokeStyle = "white";
      context.lineWidth = 1.5;
      context.stroke();
    });
  }
}

function findIndex(values, value) {
  let best = 0;
  for (let i = 1; i < values.length; i++) if (Math.abs(values[i] - value) < Math.abs(values[best] - value)) best = i;
  return best;
}

// From the lowest to the highest value of some lists, and a share of that more on both sides; what no axis can hold is left out.
const LARGEST = 1e300;

function spread(lists, share) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of lists)
    for (const value of values)
      if (Math.abs(value) < LARGEST) [low, high] = [Math.min(low, value), Math.max(high, value)];
  if (low > high) return [0, 1];
  const room = (high - low) * share || (high > low ? 0 : 0.05 * Math.abs(low) || 1);
  return [low - room, high + room];
}
