// What belongs to one point: its orbit, profiles, multipliers or roots, its row, its label's meaning, a file to go on
// from it.

const PAST = ["4px,3px", "1.5px,3px", "8px,3px,1.5px,3px"];
const SMALL = {
  margin: { l: 58, r: 10, t: 8, b: 44 },
  hovermode: "closest",
  font: { size: 12 },
  legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
};
const BUTTONS = {
  displaylogo: false,
  responsive: true,
  scrollZoom: true,
  modeBarButtonsToRemove: ["toImage", "select2d", "lasso2d"],
};
const AXIS = {
  zeroline: false,
  gridcolor: "#e8e8e8",
  showline: true,
  linecolor: "#666",
  ticks: "outside",
  exponentformat: "power",
};

class PointPanels {
  constructor(explorer, header) {
    this.explorer = explorer;
    this.header = header;
    for (const name of [
      "orbit",
      "profile",
      "spectrum",
      "row",
      "label",
      "start",
      "orbit-x",
      "orbit-y",
      "profile-of",
      "no-orbit",
      "no-spectrum",
      "spectrum-name",
      "copied",
    ])
      this[name] = document.getElementById(`point-${name}`);
    for (const select of [this["orbit-x"], this["orbit-y"], this["profile-of"]])
      select.addEventListener("change", () => this.drawOrbit());
    document.getElementById("point-copy-row").addEventListener("click", () => this.copy(this.rowText));
    document.getElementById("point-copy-start").addEventListener("click", () => this.copy(this.start.textContent));
  }

  async copy(text) {
    try {
      await navigator.clipboard.writeText(text);
      this.copied.textContent = "copied";
    } catch {
      this.copied.textContent = "this browser does not let pages copy: select the text instead";
    }
  }

  show({ step, place, x, y }) {
    this.step = step;
    this.place = place;
    const signals = step.data.orbits?.signals ?? (step.returns ? step.data.states : []);
    const offer = JSON.stringify([signals, Boolean(step.data.orbits)]);
    if (this.offer !== offer) {
      this.offer = offer;
      fillSelect(this["orbit-x"], signals, this["orbit-x"].value || signals[0]);
      fillSelect(
        this["orbit-y"],
        signals,
        this["orbit-y"].value || signals[Math.min(1, step.data.states.length - 1)],
      );
      fillSelect(
        this["profile-of"],
        step.data.orbits ? [ALL_STATES, ...step.data.states] : step.data.states,
        this["profile-of"].value,
      );
    }
    this.copied.textContent = "";
    this.writeRow(
      step.kind === "basin" && x !== undefined
        ? [
            [`${step.data.attractors.over[0]} at the start`, x],
            [`${step.data.attractors.over[1]} at the start`, y],
          ]
        : [],
    );
    this.writeLabel();
    this.start.textContent = step.start(place);
    this.drawOrbit();
    this.drawSpectrum();
  }

  writeRow(first) {
    const { step, place } = this;
    const cells = [
      ["step", step.title],
      ...first.map(([name, value]) => [name, writeNumber(value)]),
      ...Array.from(step.columns, ([name, { kind }]) => [name, writeValue(kind, step.value(name, place))]),
    ];
    if (step.returns)
      step
        .returnsOf(place)
        .forEach((values, k) =>
          cells.push([`${step.data.states[k]} at returns`, Array.from(values, writeNumber).join(", ")]),
        );
    this.rowText = cells.map((cell) => cell.join("\t")).join("\n") + "\n";
    this.row.replaceChildren(
      ...cells.map(([name, text]) => make("tr", {}, make("th", { scope: "row", text: name }), make("td", { text }))),
    );
  }

  writeLabel() {
    const { step, place } = this,
      kind = step.pointKind(place),
      note = step.columns.has("note") ? step.value("note", place) : "";
    const title = kind
      ? `${step.label(place)}: ${step.data.kinds[kind] ?? this.header.explanations[kind]?.split(/[:.]/)[0] ?? kind}`
      : "An ordinary point of the branch.";
    const parts = [make("strong", { text: title })];
    if (kind && this.header.explanations[kind]) parts.push(make("p", { text: this.header.explanations[kind] }));
    if (note) parts.push(make("p", { text: `Note: ${note}` }));
    if (kind) parts.push(make("p", {}, make("a", { href: "#kinds", text: "all kinds of special points" })));
    this.label.replaceChildren(...parts);
  }

  drawOrbit() {
    const { step, place } = this,
      segments = step.data.orbits ? step.orbit(place) : null;
    const rest = step.data.orbits
      ? "This page holds every few orbits of so long a branch: 'pddecont plot --view orbit' draws this one."
      : step.returns
        ? ""
        : "An equilibrium: nothing moves.";
    this["no-orbit"].textContent = segments ? "" : rest || "Returns of an attractor, from the row.";
    for (const part of document.querySelectorAll(".of-orbits")) part.hidden = !segments && !step.returns;
    if (segments) {
      this.drawPlane(segments);
      this.drawProfile(segments);
    } else if (step.returns) this.drawReturns();
  }

  drawPlane(segments) {
    const { step, place } = this,
      signals = step.data.orbits.signals;
    const [i, j] = [this["orbit-x"], this["orbit-y"]].map((select) => signals.indexOf(select.value));
    const names = [...new Set(segments.map((segment) => segment.name))],
      seen = new Set();
    const traces = segments.map(({ name, values }) => {
      const first = !seen.has(name);
      seen.add(name);
      return {
        type: "scatter",
        mode: "lines",
        x: values[i],
        y: values[j],
        name: escapeText(name),
        legendgroup: name,
        showlegend: first && names.length > 1,
        line: { color: this.header.colours[names.indexOf(name) % this.header.colours.length], width: 2 },
        hoverinfo: "x+y+name",
      };
    });
    segments.forEach(({ values }, k) => {
      const next = segments[(k + 1) % segments.length].values,
        ends = [i, j].map((n) => [values[n].at(-1), next[n][0]]);
      const size = Math.max(...ends.flat().map(Math.abs)),
        jump = Math.max(...ends.map(([a, b]) => Math.abs(a - b)));
      if (jump > 1e-5 * size)
        traces.push({
          type: "scatter",
          mode: "lines",
          x: ends[0],
          y: ends[1],
          line: { color: "#888", width: 1, dash: "4px,3px" },
          showlegend: false,
          hoverinfo: "skip",
        });
    });
    const shapes =
      i < step.data.states.length && j < step.data.states.length ? drawSurfaces(step, place, i, j, segments) : [];
    Plotly.react(
      this.orbit,
      traces,
      {
        ...SMALL,
        shapes,
        xaxis: { ...AXIS, title: { text: writeAxis(signals[i], [step]) } },
        yaxis: { ...AXIS, title: { text: writeAxis(signals[j], [step]) } },
      },
      BUTTONS,
    );
  }

  drawProfile(segments) {
    const { step } = this,
      { states } = step.data,
      signals = step.data.orbits.signals,
      chosen = this["profile-of"].value;
    const shown = chosen === ALL_STATES ? states : [chosen];
    const past =
      shown.length === 1 ? signals.slice(states.length).filter((name) => name.startsWith(`${shown[0]}(`)) : [];
    const lines = [
      ...shown.map((name, k) => [name, { color: this.header.colours[k % this.header.colours.length], width: 2 }]),
      ...past.map((name, k) => [name, { color: "#333", width: 1.6, dash: PAST[k % PAST.length] }]),
    ];
    const traces = lines.map(([name, line]) => {
      const x = [],
        y = [];
      for (const { time, values } of segments) {
        x.push(...time, null);
        y.push(...values[signals.indexOf(name)], null);
      }
      return { type: "scatter", mode: "lines", x, y, line, name: writeName(name), hoverinfo: "x+y+name" };
    });
    const shapes = segments.slice(1).map(({ time }) => ({
      type: "line",
      x0: time[0],
      x1: time[0],
      yref: "paper",
      y0: 0,
      y1: 1,
      layer: "below",
      line: { color: "#bbb", width: 1 },
    }));
    Plotly.react(
      this.profile,
      traces,
      {
        ...SMALL,
        shapes,
        showlegend: lines.length > 1,
        xaxis: { ...AXIS, title: { text: writeAxis("t", [step]) } },
        yaxis: {
          ...AXIS,
          title: { text: shown.length > 3 ? "states" : shown.map((name) => writeAxis(name, [step])).join(", ") },
        },
      },
      BUTTONS,
    );
  }

  // Of attractors, which hold no orbit: their returns in the plane of two states, and one after the other.
  drawReturns() {
    const { step, place } = this,
      { states } = step.data,
      returns = step.returnsOf(place);
    const [i, j, k] = ["orbit-x", "orbit-y", "profile-of"].map((name) => states.indexOf(this[name].value));
    const axes = (x, y) => ({
      ...SMALL,
      showlegend: false,
      xaxis: { ...AXIS, title: { text: x } },
      yaxis: { ...AXIS, title: { text: writeAxis(y, [step]) } },
    });
    const trace = (x, y, mode) => ({
      type: "scatter",
      mode,
      x,
      y,
      marker: { color: this.header.colours[0], size: 7 },
      line: { width: 1 },
    });
    Plotly.react(
      this.orbit,
      [trace(returns[i], returns[j], "markers")],
      axes(writeAxis(states[i], [step]), states[j]),
      BUTTONS,
    );
    Plotly.react(
      this.profile,
      [
        trace(
          Array.from(returns[k], (_, n) => n + 1),
          returns[k],
          "lines+markers",
        ),
      ],
      axes("number of the return", states[k]),
      BUTTONS,
    );
  }

  drawSpectrum() {
    const { step, place } = this,
      found = step.spectrum(place);
    for (const part of document.querySelectorAll(".of-spectra")) part.hidden = !step.isBranch;
    this.spectrum.hidden = !found;
    this["no-spectrum"].textContent = found
      ? ""
      : "None were computed for this point; a step computes them with 'stability: true'.";
    if (!found) return;
    const of = found.what === "multipliers";
    this["spectrum-name"].textContent = of ? "Floquet multipliers" : "Characteristic roots";
    const outside = Array.from(found.real, (re, k) => (of ? Math.hypot(re, found.imaginary[k]) > 1 : re > 0));
    const shape = of
      ? { type: "circle", x0: -1, x1: 1, y0: -1, y1: 1 }
      : { type: "line", x0: 0, x1: 0, yref: "paper", y0: 0, y1: 1 };
    Plotly.react(
      this.spectrum,
      [
        {
          type: "scatter",
          mode: "markers",
          x: found.real,
          y: found.imaginary,
          hoverinfo: "x+y",
          marker: {
            size: 9,
            symbol: outside.map((out) => (out ? "diamond" : "circle")),
            color: outside.map((out) => this.header.colours[out ? 1 : 0]),
            line: { color: "white", width: 1 },
          },
        },
      ],
      {
        ...SMALL,
        showlegend: false,
        shapes: [{ ...shape, layer: "below", line: { color: "#666", width: 1.2 } }],
        xaxis: { ...AXIS, title: { text: "real part" } },
        yaxis: { ...AXIS, title: { text: "imaginary part" }, ...(of ? { scaleanchor: "x" } : {}) },
      },
      BUTTONS,
    );
  }
}

const ALL_STATES = "all states";

// Event surfaces normal . z = level that depend on the two states that are shown alone.
function drawSurfaces(step, place, i, j, segments) {
  const line = { color: "#444", width: 1.4 },
    shapes = [];
  for (const { normal, level } of step.surfaces(place)) {
    const others = Array.from(normal).some((value, k) => k !== i && k !== j && value !== 0);
    if (
      others ||
      !Number.isFinite(level) ||
      !normal.every(Number.isFinite) ||
      (normal[i] === 0 && normal[j] === 0) ||
      i === j
    )
      continue;
    if (normal[j] === 0)
      shapes.push({
        type: "line",
        x0: level / normal[i],
        x1: level / normal[i],
        yref: "paper",
        y0: 0,
        y1: 1,
        layer: "below",
        line,
      });
    else if (normal[i] === 0)
      shapes.push({
        type: "line",
        xref: "paper",
        x0: 0,
        x1: 1,
        y0: level / normal[j],
        y1: level / normal[j],
        layer: "below",
        line,
      });
    else {
      const [x0, x1] = spread(
          segments.map(({ values }) => values[i]),
          0.05,
        ),
        at = (x) => (level - normal[i] * x) / normal[j];
      shapes.push({ type: "line", x0, x1, y0: at(x0), y1: at(x1), layer: "below", line });
    }
  }
  return shapes;
}
