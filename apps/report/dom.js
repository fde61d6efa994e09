// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Elements, tables and numbers.

/** An element; attributes that start with "on" are listeners, null ones are left out; children are nodes or texts. */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/**
 * A table in a box of its own that scrolls on narrow screens.
 * columns: [title, kind], kind one of "number", "words", "path", ""; the first column heads the rows.
 */
export function table(columns, rows, caption = null) {
  const head = columns.map(([title, kind]) => el("th", { scope: "col", class: kind || null }, title));
  const body = rows.map((row) => {
    const cells = row.map((cell, i) =>
      el(i === 0 ? "th" : "td", { scope: i === 0 ? "row" : null, class: columns[i][1] || null }, cell));
    return el("tr", {}, cells);
  });
  const parts = [el("thead", {}, el("tr", {}, head)), el("tbody", {}, body)];
  return el("div", { class: "scroll" }, el("table", { "aria-label": caption }, parts));
}

/** The same, as narrow as its content. */
export function narrowTable(...parameters) {
  const box = table(...parameters);
  box.classList.add("narrow");
  return box;
}

export function section(id, title, ...children) {
  const heading = el("h2", { id: id + "-title" }, title);
  return el("section", { id, "aria-labelledby": id + "-title" }, heading, ...children);
}

/** 1404 -> "1 404", with a narrow space that does not break. */
export function count(value) {
  return String(value).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
}

/** "1 view", "2 views" */
export function counted(value, noun) {
  return count(value) + " " + noun + (value === 1 ? "" : "s");
}

/** A clause as a sentence. */
export function sentence(clause) {
  return clause && clause[0].toUpperCase() + clause.slice(1) + (/[.!?]$/.test(clause) ? "" : ".");
}

export function fixed(value, digits) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return value.toFixed(digits).replace(/^-/, "−");
}

/** A length in pixels with three significant digits or so. */
export function px(value) {
  if (!Number.isFinite(value)) return "–";
  if (value > 0 && value < 5e-4) return value.toExponential(1).replace("-", "−");
  return fixed(value, value >= 100 ? 0 : value >= 10 ? 1 : value >= 1 ? 2 : 3);
}

/** [value, sigma] as texts with as many digits as the sigma's second one. Sigma missing: the parameter was fixed. */
export function withSigma(value, sigma) {
  if (!(sigma > 0)) return [Math.abs(value) >= 1e-4 || value === 0 ? fixed(value, 6).replace(/\.?0+$/, "") : value.toExponential(4), "held fixed"];
  const digits = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
  return [fixed(value, digits), "± " + fixed(sigma, digits)];
}

export function percent(part, whole) {
  if (!(whole > 0)) return "–";
  const value = (100 * part) / whole;
  return (value === 0 || value >= 10 ? value.toFixed(0) : value.toFixed(1)) + " %";
}

/** Address of an image, as seen from this page. */
export function imageAddress(path) {
  const whole = path.startsWith("/") ? path : document.body.dataset.images + path;
  return whole.split("/").map(encodeURIComponent).join("/");
}

export function imageLink(path, text = path) {
  return path ? el("a", { href: imageAddress(path), title: path }, text) : "";
}
