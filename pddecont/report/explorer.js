// The explorer: which steps and axes are shown, which point is chosen, and the keys that move it.

// Of branches among the dots of a sweep, whose colours tell classes of motions.
const BESIDE_DOTS = "#3b3b3b";

class Explorer {
  constructor({ header, read }) {
    this.header = header;
    const several = header.files.length > 1;
    let number = 0;
    this.steps = header.files.flatMap((file) =>
      file.steps.map((step) => new Step({ name: file.name, several }, step, number++, read)),
    );
    this.views = listViews(this.steps);
    this.on = new Set();
    this.chosen = null;
    this.inputs = Object.fromEntries(
      ["view", "x", "y", "colour"].map((name) => [name, document.getElementById(`explorer-${name}`)]),
    );
    this.status = document.getElementById("explorer-status");
    this.stepList = document.getElementById("explorer-steps");
    this.panels = new PointPanels(this, header);
    this.diagram = new Diagram(document.getElementById("explorer-diagram"), this);
    this.changed = keepState(this);
  }

  async start() {
    fillSelect(
      this.inputs.view,
      this.views.map((view) => view.title),
      chooseView(this.views).title,
    );
    this.inputs.view.addEventListener("change", () => this.showView());
    for (const input of [this.inputs.x, this.inputs.y])
      input.addEventListener("change", () => this.diagram.draw(false));
    this.inputs.colour.addEventListener("change", () => {
      this.listSteps();
      this.diagram.draw(true);
    });
    document.getElementById("explorer-all").addEventListener("click", () => this.diagram.showAll());
    document.getElementById("explorer-diagram").addEventListener("keydown", (event) => this.press(event));
    await this.showView();
    await restoreState(this, readState());
    followRun(this);
  }

  // The axes and steps of the view that is chosen by name; both can be changed after that.
  async showView() {
    const view = this.views.find(({ title }) => title === this.inputs.view.value);
    this.view = view;
    this.basin = view.basin ?? null;
    this.on = new Set(view.steps);
    fillSelect(this.inputs.x, listAxes(this.steps, false), view.x);
    fillSelect(this.inputs.y, listAxes(this.steps, true), view.y);
    if (this.basin)
      [this.inputs.x, this.inputs.y].forEach((input, k) => fillSelect(input, [this.basin.data.attractors.over[k]]));
    this.inputs.x.disabled = this.inputs.y.disabled = this.inputs.colour.disabled = Boolean(this.basin);
    this.inputs.colour.value = view.steps.filter((step) => step.isBranch).length > 1 ? "step" : "motion";
    this.listSteps();
    await this.diagram.draw(false);
    if (!this.chosen || !this.shown().includes(this.chosen.step)) this.chosen = null;
    if (!this.chosen && this.shown().length)
      this.select(this.diagram.findFirst() ?? { step: this.shown()[0], place: 0 });
  }

  shownAs() {
    return {
      steps: this.shown(),
      x: this.inputs.x.value,
      y: this.inputs.y.value,
      basin: this.basin,
      colourBy: this.inputs.colour.value,
    };
  }

  shown() {
    return this.steps.filter((step) => this.on.has(step));
  }

  // A family of motions has its colour if steps have none of their own.
  colourOf(step, family, by) {
    const { colours } = this.header;
    if (by === "step") return colours[step.number % colours.length];
    if (this.shown().some((own) => own.returns)) return BESIDE_DOTS;
    const names = [
      ...new Set(
        this.shown()
          .filter((own) => own.isBranch)
          .flatMap((own) => own.data.branch.families.map(nameFamily)),
      ),
    ];
    return colours[names.indexOf(nameFamily(step.data.branch.families[family])) % colours.length];
  }

  listSteps() {
    const items = this.steps
      .filter((step) => !step.data.attractors?.over)
      .map((step) => {
        const box = make("input", { type: "checkbox", id: `step-on-${step.number}` });
        box.checked = this.on.has(step);
        box.disabled = Boolean(this.basin);
        box.addEventListener("change", () => {
          if (box.checked) this.on.add(step);
          else this.on.delete(step);
          this.diagram.draw(true);
        });
        const swatch = make("span", { class: "swatch" });
        swatch.style.background = step.isBranch ? this.colourOf(step, 0, "step") : "none";
        const curve = step.data.branch?.curve
          ? ` of ${step.data.kinds[step.data.branch.curve] ?? step.data.branch.curve}`
          : "";
        return make(
          "li",
          {},
          box,
          make(
            "label",
            { for: `step-on-${step.number}` },
            swatch,
            `${step.title} `,
            make("small", { text: `${step.kind}${curve}, ${step.n}` }),
          ),
        );
      });
    const attractors = [
      ...new Map(
        (this.basin ? [this.basin] : this.shown()).flatMap((step) =>
          step.data.attractors
            ? step.data.attractors.classes.map((name, k) => [name, step.data.attractors.colours[k]])
            : [],
        ),
      ),
    ];
    const families = this.basin
      ? []
      : [
          ...new Set(
            this.shown()
              .filter((step) => step.isBranch)
              .flatMap((step) => step.data.branch.families.map(nameFamily)),
          ),
        ];
    this.stepList.replaceChildren(...items);
    const key = document.getElementById("explorer-classes");
    const motions =
      this.inputs.colour.value === "motion" && families.length > 1 && !attractors.length
        ? families.map((name, k) => [name, this.header.colours[k % this.header.colours.length]])
        : [];
    key.replaceChildren(
      ...[...motions, ...attractors].map(([name, colour]) => {
        const swatch = make("span", { class: "swatch" });
        swatch.style.background = colour;
        return make("li", {}, swatch, name);
      }),
    );
  }

  select(chosen) {
    this.chosen = chosen;
    this.panels.show(chosen);
    this.diagram.paint();
    this.changed();
    this.status.textContent = describePlace(chosen, this.inputs);
  }

  hover(found) {
    const place = found ?? this.chosen;
    if (place) this.status.textContent = describePlace(place, this.inputs);
  }

  press(event) {
    const action = this.keys()[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey || event.target.closest("a, select, input")) return;
    event.preventDefault();
    action(event.shiftKey);
  }

  keys() {
    const { diagram } = this;
    return {
      ArrowRight: (shift) => (shift ? diagram.zoom(1, 0.1) : this.move(1)),
      ArrowLeft: (shift) => (shift ? diagram.zoom(1, -0.1) : this.move(-1)),
      ArrowUp: (shift) => (shift ? diagram.zoom(1, 0, 0.1) : this.change(-1)),
      ArrowDown: (shift) => (shift ? diagram.zoom(1, 0, -0.1) : this.change(1)),
      PageDown: () => this.jump(1),
      PageUp: () => this.jump(-1),
      Home: () => this.place(0),
      End: () => this.place(Infinity),
      "+": () => diagram.zoom(0.8),
      "-": () => diagram.zoom(1.25),
      0: () => diagram.showAll(),
    };
  }

  place(place) {
    if (!this.chosen) return;
    const { step } = this.chosen;
    this.select({ step, place: Math.max(0, Math.min(step.n - 1, place)) });
  }

  move(by) {
    if (this.chosen) this.place(this.chosen.place + by);
  }

  // Another step that is switched on.
  change(by) {
    const shown = this.shown();
    if (!shown.length) return;
    const at = shown.indexOf(this.chosen?.step);
    this.select({ step: shown[(at + by + shown.length) % shown.length], place: 0 });
  }

  // The next or the previous point with a label.
  jump(by) {
    if (!this.chosen) return;
    const { step } = this.chosen;
    for (let place = this.chosen.place + by; place >= 0 && place < step.n; place += by)
      if (step.label(place)) return this.place(place);
  }
}

function nameFamily([signature, periods]) {
  return `${signature || "no events"}${periods > 1 ? `, ${periods} periods` : ""}`;
}

function describePlace({ step, place, x, y }, inputs) {
  const names = [inputs.x.value, inputs.y.value],
    values = [x, y];
  const texts = names.map((name, k) =>
    values[k] !== undefined
      ? `${name} = ${writeNumber(values[k])}`
      : step.has(name)
        ? `${name} = ${writeNumber(step.value(name, place))}`
        : "",
  );
  const label = step.label(place);
  return [
    `${step.title}${label ? `, ${label}` : ""}, point ${place + 1} of ${step.n}`,
    ...texts.filter(Boolean),
  ].join(";  ");
}

// Names that axes may show: all columns but texts; upwards states too.
function listAxes(steps, upwards) {
  const names = steps.flatMap((step) => [
    ...(upwards ? step.data.states : []),
    ...Array.from(step.columns.keys()).filter((name) => step.has(name)),
  ]);
  return [...new Set(names)];
}

// Views that a file offers: a diagram for each parameter, a plane for each two, a map for each basin; or single points.
function listViews(steps) {
  const views = [],
    groups = new Map();
  for (const step of steps) {
    if (!step.data.free.length) continue;
    const key = [...step.data.free].sort().join(", ");
    groups.set(key, [...(groups.get(key) ?? []), step]);
  }
  for (const own of groups.values()) {
    const free = own[0].data.free,
      plane = free.length > 1;
    views.push({
      title: plane ? `plane of ${free.join(" and ")}` : `over ${free[0]}`,
      steps: own,
      x: free[0],
      y: plane ? free[1] : chooseHeight(own),
    });
  }
  for (const basin of steps.filter((step) => step.data.attractors?.over))
    views.push({ title: `basins: ${basin.title}`, steps: [basin], basin });
  const single = steps.filter((step) => ["orbit", "equilibrium"].includes(step.kind));
  if (single.length)
    views.push({ title: "single points", steps: single, x: single[0].data.parameters[0], y: chooseHeight(single) });
  return views;
}

// The first monitor that is known on all of some steps, else the first state.
function chooseHeight(steps) {
  const known = steps[0].data.monitors.filter((name) =>
    steps.every((step) => step.has(name) && step.column(name).some(Number.isFinite)),
  );
  return known[0] ?? steps[0].data.states[0];
}

function chooseView(views) {
  return (
    views.find((view) => view.steps.some((step) => step.kind === "continue" && step.data.free.length === 1)) ??
    views[0]
  );
}

async function startExplorer() {
  const element = make("script");
  element.textContent = new TextDecoder().decode(await inflate("explorer-library"));
  document.head.append(element);
  const explorer = new Explorer(readBlock(await inflate("explorer-data")));
  document.getElementById("explorer").hidden = false;
  await explorer.start();
  document.getElementById("explorer").dataset.ready = "yes";
}

startExplorer().catch((error) => {
  document.getElementById("explorer-problem").textContent =
    `The explorer could not start: ${error.message}. It needs a browser of 2023 or later.`;
  throw error;
});
