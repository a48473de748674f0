// What the page holds: compressed text in the document, with a header and arrays of numbers behind it.

async function inflate(id) {
  const text = document.getElementById(id).textContent.trim();
  const letters = atob(text),
    bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const ARRAYS = { f8: Float64Array, f4: Float32Array, u4: Uint32Array, i4: Int32Array, u2: Uint16Array };

// The header, and a function that returns the array at a place [first byte, number of elements, type].
function readBlock(block) {
  const length = new DataView(block.buffer).getUint32(0, true),
    start = 4 + length;
  const header = JSON.parse(new TextDecoder().decode(block.subarray(4, start)));
  const known = new Map();
  const read = ([at, n, type]) => {
    if (!known.has(at + type)) {
      const size = ARRAYS[type].BYTES_PER_ELEMENT,
        bytes = new Uint8Array(n * size);
      for (let j = 0; j < size; j++) for (let i = 0; i < n; i++) bytes[i * size + j] = block[start + at + j * n + i];
      known.set(at + type, new ARRAYS[type](bytes.buffer));
    }
    return known.get(at + type);
  };
  return { header, read };
}

// Where each of several pieces begins in an array that holds them one after the other, and where the last one ends.
function findStarts(counts) {
  const starts = new Uint32Array(counts.length + 1);
  for (let i = 0; i < counts.length; i++) starts[i + 1] = starts[i] + counts[i];
  return starts;
}

// A step with its arrays; what is long is unpacked when it is first asked for.
class Step {
  constructor(file, data, number, read) {
    Object.assign(this, { file, data, number, read, name: data.name, kind: data.kind, n: data.points.n });
    this.columns = new Map(data.points.columns.map(([name, kind, values]) => [name, { kind, values }]));
    this.isBranch = Boolean(data.branch);
    this.returns = data.attractors && read(data.attractors.returns);
    this.returnStarts = data.attractors && findStarts(read(data.attractors.n_returns));
  }

  has(name) {
    return this.columns.has(name) && this.columns.get(name).kind !== "text";
  }
  column(name) {
    return this.read(this.columns.get(name).values);
  }
  value(name, place) {
    const { kind, values } = this.columns.get(name);
    return kind === "text" ? values[place] : this.read(values)[place];
  }
  label(place) {
    return this.value("label", place);
  }
  pointKind(place) {
    return this.columns.has("kind") ? this.value("kind", place) : this.label(place) ? "A" : "";
  }
  get title() {
    return this.file.several ? `${this.file.name}: ${this.name}` : this.name;
  }

  // Highest and lowest values of a state of each orbit; the value itself of equilibria.
  extents(state) {
    const k = this.data.states.indexOf(state);
    if (k < 0 || !this.data.orbits) return null;
    return this.data.orbits.extents.map((place) => this.read(place).subarray(k * this.n, (k + 1) * this.n));
  }

  // What is shown over one column: lists of values of the points, one for a column, two for a state's extents.
  heights(name) {
    return this.has(name) ? [this.column(name)] : this.extents(name);
  }

  parts() {
    const numbers = this.read(this.data.branch.parts),
      parts = [];
    for (let i = 0; i < numbers.length; i += 4)
      parts.push({ start: numbers[i], n: numbers[i + 1], style: numbers[i + 2], family: numbers[i + 3] });
    return parts;
  }

  // The orbit of a point: segments with their name, times and one list of values a signal; null if the page has none.
  orbit(place) {
    const own = this.data.orbits;
    if (!own) return null;
    const held = this.read(own.held)[place];
    if (held < 0) return null;
    this.segmentStarts ??= findStarts(this.read(own.segments));
    this.sampleStarts ??= findStarts(this.read(own.samples));
    const time = this.read(own.time),
      values = this.read(own.values);
    const names = own.signatures[this.read(own.signature)[held]].split(" ");
    const segments = [];
    for (let s = this.segmentStarts[held]; s < this.segmentStarts[held + 1]; s++) {
      const from = this.sampleStarts[s],
        to = this.sampleStarts[s + 1];
      segments.push({
        name: names[s - this.segmentStarts[held]] ?? "",
        time: time.subarray(from, to),
        values: own.signals.map((_, k) => values.subarray(k * time.length + from, k * time.length + to)),
      });
    }
    return segments;
  }

  // Event surfaces of a point: normal (one number a state) and level.
  surfaces(place) {
    const own = this.data.orbits,
      size = this.data.states.length + 1,
      values = this.read(own.surfaces);
    return Array.from({ length: own.n_surfaces }, (_, k) => {
      const numbers = values.subarray((place * own.n_surfaces + k) * size, (place * own.n_surfaces + k + 1) * size);
      return { name: own.events[k] ?? "", normal: numbers.subarray(0, size - 1), level: numbers[size - 1] };
    });
  }

  spectrum(place) {
    const own = this.data.spectra;
    if (!own) return null;
    this.spectrumStarts ??= findStarts(this.read(own.n));
    const [from, to] = [this.spectrumStarts[place], this.spectrumStarts[place + 1]];
    if (from === to) return null;
    return {
      what: own.what,
      real: this.read(own.real).subarray(from, to),
      imaginary: this.read(own.imaginary).subarray(from, to),
    };
  }

  // Returns of an attractor to the section, one list a state.
  returnsOf(place) {
    const n = this.returns.length / this.data.states.length;
    const [from, to] = [this.returnStarts[place], this.returnStarts[place + 1]];
    return this.data.states.map((_, k) => this.returns.subarray(k * n + from, k * n + to));
  }

  // A run file that goes on from a point.
  start(place) {
    if (!this.data.start) return "";
    const label = this.label(place);
    const where = /^\w+$/.test(label) ? `point: ${label}` : `index: ${this.value("index", place)}`;
    return this.data.start[0] + where + this.data.start[1];
  }
}
