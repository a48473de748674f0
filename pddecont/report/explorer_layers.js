// What a diagram draws of steps: lines of branches, marks of special points, dots of sweeps, maps of basins.

// Of parts that are stable (or not known), unstable, not admissible.
const DASHES = ["solid", "6px,4px", "1.5px,3px"];
const WIDTHS = [2.2, 1.8, 1.3];
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
// Labels of more special points than these would hide the diagram.
const MOST_LABELS = 60;
// A branch of more points is smooth without curves between them.
const MOST_CURVED = 2000;
// Special points nearer than this share of the diagram have one text.
const SAME_PLACE = 0.012;
// What no axis can hold.
const LARGEST = 1e300;

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

// From the lowest to the highest value of some lists, and a share of that more on both sides; what no axis can hold is
// left out.
function spread(lists, share) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of lists)
    for (const value of values)
      if (Math.abs(value) < LARGEST) [low, high] = [Math.min(low, value), Math.max(high, value)];
  if (low > high) return [0, 1];
  const room = (high - low) * share || (high > low ? 0 : 0.05 * Math.abs(low) || 1);
  return [low - room, high + room];
}
