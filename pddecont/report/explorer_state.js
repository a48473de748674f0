// What is shown, in the page's address: it is the same when the page is read anew, and an address can be passed on.

// A browser takes no more than a few hundred changes of an address in half a minute.
const SAVED_AFTER = 300;

function readState() {
  try {
    const state = JSON.parse(decodeURIComponent(location.hash.slice(1)));
    return state !== null && typeof state === "object" ? state : {};
  } catch {
    return {};
  }
}

function saveState(explorer) {
  history.replaceState(null, "", `#${encodeURIComponent(JSON.stringify(describeState(explorer)))}`);
}

function describeState({ inputs, view, on, chosen, diagram }) {
  return {
    view: inputs.view.value,
    x: inputs.x.value,
    y: inputs.y.value,
    colour: inputs.colour.value,
    // What differs from the view, in which there may be more steps the next time.
    added: [...on].filter((step) => !view.steps.includes(step)).map((step) => step.title),
    removed: view.steps.filter((step) => !on.has(step)).map((step) => step.title),
    // Points before it may be more the next time too, its row stays.
    chosen: chosen && [chosen.step.title, chosen.step.value("index", chosen.place)],
    ranges: diagram.showsAll() ? null : diagram.ranges(),
    scroll: window.scrollY,
  };
}

// Show what was shown; what an address says that there is not is passed over.
async function restoreState(explorer, state) {
  const { inputs, steps } = explorer;
  const offers = (input, value) => Array.from(input.options).some((option) => option.value === value);
  const list = (titles) => steps.filter((step) => Array.isArray(titles) && titles.includes(step.title));
  if (!offers(inputs.view, state.view)) return;
  inputs.view.value = state.view;
  await explorer.showView();
  for (const name of ["x", "y", "colour"]) if (offers(inputs[name], state[name])) inputs[name].value = state[name];
  list(state.added).forEach((step) => explorer.on.add(step));
  list(state.removed).forEach((step) => explorer.on.delete(step));
  explorer.listSteps();
  await explorer.diagram.draw(false);
  const [title, row] = Array.isArray(state.chosen) ? state.chosen : [];
  const step = explorer.shown().find((own) => own.title === title);
  const place = step ? step.column("index").indexOf(row) : -1;
  if (place >= 0) explorer.select({ step, place });
  if (areRanges(state.ranges)) await explorer.diagram.showRanges(state.ranges);
  if (Number.isFinite(state.scroll)) window.scrollTo(0, state.scroll);
}

function areRanges(ranges) {
  const isOne = (range) => Array.isArray(range) && range.length === 2 && range.every(Number.isFinite);
  return Array.isArray(ranges) && ranges.length === 2 && ranges.every(isOne);
}

// Save what is shown whenever it has changed and stays so for a moment.
function keepState(explorer) {
  let waiting = null;
  return () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => saveState(explorer), SAVED_AFTER);
  };
}
