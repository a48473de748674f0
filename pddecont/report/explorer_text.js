// Numbers and names as text.

// A number with all its digits, in the form that Python writes.
function writeNumber(value) {
  if (Number.isNaN(value)) return "not computed";
  if (!Number.isFinite(value)) return value > 0 ? "inf" : "-inf";
  if (value === 0) return Object.is(value, -0) ? "-0.0" : "0.0";
  const [digits, exponent] = value
    .toExponential()
    .split("e")
    .map((part, k) => (k ? Number(part) : part));
  if (exponent < -4 || exponent >= 16)
    return `${digits}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
  const text =
    exponent < 0 ? value.toFixed(Math.min(100, digits.replace(/[-.]/g, "").length - 1 - exponent)) : String(value);
  return text.includes(".") ? text : `${text}.0`;
}

function writeValue(kind, value) {
  if (kind === "text") return value;
  if (Number.isNaN(value)) return "not computed";
  if (kind === "truth") return value ? "yes" : "no";
  return kind === "whole" ? String(value) : writeNumber(value);
}

function escapeText(text) {
  return String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

const GREEK = Object.fromEntries(
  (
    "alpha α beta β gamma γ delta δ epsilon ε zeta ζ eta η theta θ kappa κ lambda λ mu μ nu ν xi ξ " +
    "pi π rho ρ sigma σ tau τ phi φ chi χ psi ψ omega ω"
  )
    .split(" ")
    .map((_, k, all) => [all[k], all[k + 1]])
    .filter((_, k) => k % 2 === 0),
);

// A name as it is written in mathematics, in the few tags that plotly reads; all else in it is escaped.
function writeName(name) {
  const parts = name.split("_"),
    first = parts[0];
  if (parts.length > 2 || name.includes("(") || !(first in GREEK || first.length === 1))
    return escapeText(name.replaceAll("_", " "));
  return (
    `<i>${escapeText(GREEK[first] ?? first)}</i>` + (parts.length > 1 ? `<sub>${escapeText(parts[1])}</sub>` : "")
  );
}

function writeAxis(name, steps) {
  const key = name === "period" ? "t" : name.split("(")[0];
  const unit = steps.map((step) => step.data.units[name] ?? step.data.units[key]).find(Boolean);
  return writeName(name) + (unit ? ` (${escapeText(unit)})` : "");
}

function make(tag, texts = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(texts)) {
    if (name === "text") element.textContent = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

function fillSelect(select, names, chosen) {
  select.replaceChildren(...names.map((name) => make("option", { value: name, text: name })));
  if (names.includes(chosen)) select.value = chosen;
}
