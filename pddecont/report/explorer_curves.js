// Branches as curves between their points: piecewise cubic in the arclength by the modified method of Akima, which
// overshoots neither at kinks nor at jumps (as pddecont/plot/smooth_lines.py).

// Points nearer to the one before than this share of a part's length add nothing to its shape but rounding.
const SAME_POINT = 1e-6;
// From a point to the next a line has so many straight pieces.
const PIECES = 6;

function curve(along, xs, ys) {
  const kept = [];
  if (along)
    for (let i = 0; i < along.length; i++)
      if (!kept.length || along[i] - along[kept.at(-1)] > SAME_POINT * Math.abs(along.at(-1) - along[0]))
        kept.push(i);
  const finite = (values) => values.every(Number.isFinite);
  if (kept.length < 3 || !finite(along) || !finite(xs) || !finite(ys)) return [xs, ys];
  const places = kept.map((i) => along[i]);
  return [xs, ys].map((values) => {
    const own = kept.map((i) => values[i]),
      slopes = findSlopes(places, own),
      line = [];
    for (let i = 0; i + 1 < own.length; i++) {
      const h = places[i + 1] - places[i];
      for (let k = 0; k < PIECES; k++) {
        const s = k / PIECES,
          r = 1 - s;
        line.push(
          own[i] * (1 + 2 * s) * r * r +
            own[i + 1] * s * s * (3 - 2 * s) +
            h * s * r * (slopes[i] * r - slopes[i + 1] * s),
        );
      }
    }
    line.push(own.at(-1));
    return line;
  });
}

function findSlopes(places, values) {
  const n = values.length,
    m = [];
  for (let i = 0; i + 1 < n; i++) m.push((values[i + 1] - values[i]) / (places[i + 1] - places[i]));
  // Two slopes more on each side continue the parabola there.
  const before = 2 * m[0] - m[1],
    after = 2 * m.at(-1) - m.at(-2);
  const all = [2 * before - m[0], before, ...m, after, 2 * after - m.at(-1)];
  return values.map((_, i) => {
    const [a, b, c, d] = all.slice(i, i + 4);
    const left = Math.abs(d - c) + Math.abs(d + c) / 2,
      right = Math.abs(b - a) + Math.abs(b + a) / 2;
    return left + right > 0 ? (left * b + right * c) / (left + right) : 0;
  });
}
