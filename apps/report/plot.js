// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Canvases that follow the width of the page, the colour scheme and the printer.

import { el } from "./dom.js";

export const plots = [];
let printing = false;

export function color(name) {
  return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
}

/**
 * A drawing. draw(context, width, height) is in CSS pixels and may return marks {x, y, text, choose}: what the pointer
 * names when it comes near, and what a click calls.
 */
export function plot({ aspect, label, draw }) {
  const canvas = el("canvas", { role: "img", "aria-label": label, style: "aspect-ratio:" + aspect });
  const item = { canvas, marks: [] };
  item.redraw = () => {
    const width = canvas.clientWidth, height = width / aspect;
    if (!width) return;
    const scale = pixelScale();
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    const context = canvas.getContext("2d");
    context.scale(scale, scale);
    context.font = "12px system-ui, 'DejaVu Sans', sans-serif";
    item.marks = draw(context, width, height) ?? [];
  };
  register(item);
  return item;
}

/** Pixels of a canvas for each CSS pixel. */
export function pixelScale() {
  return printing ? 2 : Math.max(1, window.devicePixelRatio || 1);
}

/** Lets a drawing {canvas, redraw, marks} follow its width and answer the pointer. It is drawn when it nears the screen. */
export function register(item) {
  let near = false, stale = true;
  item.refresh = () => {
    stale = !near && !printing;
    if (!stale) item.redraw();
  };
  plots.push(item);
  new ResizeObserver(() => { if (!printing) item.refresh(); }).observe(item.canvas);
  new IntersectionObserver((entries) => {
    near = entries[entries.length - 1].isIntersecting;
    if (near && stale) item.refresh();
  }, { rootMargin: "50%" }).observe(item.canvas);
  item.canvas.addEventListener("pointermove", (event) => showTip(item, event));
  item.canvas.addEventListener("pointerleave", hideTip);
  item.canvas.addEventListener("click", (event) => nearest(item, event)?.choose?.());
}

export function nearest(item, event) {
  const box = item.canvas.getBoundingClientRect();
  const x = event.clientX - box.left, y = event.clientY - box.top;
  let best = null, least = 12 * 12;
  for (const mark of item.marks) {
    const far = (mark.x - x) ** 2 + (mark.y - y) ** 2;
    if (far < least) [best, least] = [mark, far];
  }
  return best;
}

export const tip = el("div", { class: "tip", hidden: "", "aria-hidden": "true" });

export function hideTip() {
  tip.hidden = true;
}

export function showTip(item, event) {
  const mark = event.buttons ? null : nearest(item, event);
  tip.hidden = !mark;
  if (!mark) return;
  tip.textContent = typeof mark.text === "function" ? mark.text() : mark.text;
  tip.style.left = Math.max(4, Math.min(event.clientX + 12, window.innerWidth - tip.offsetWidth - 8)) + "px";
  tip.style.top = (event.clientY + 16 + tip.offsetHeight > window.innerHeight ? event.clientY - 12 - tip.offsetHeight : event.clientY + 16) + "px";
}

/** Draws everything again in the colours of paper. */
export function followPrinterAndScheme() {
  const redrawAll = () => plots.forEach((item) => item.refresh());
  const forPaper = (on) => {
    printing = on;
    document.documentElement.classList.toggle("print", on);
    redrawAll();
  };
  window.addEventListener("beforeprint", () => forPaper(true));
  window.addEventListener("afterprint", () => forPaper(false));
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
}

/** A figure with its heading and a sentence that says how to read it. */
export function figure(title, item, caption) {
  return el("figure", {}, el("h3", {}, title), el("div", { class: "drawing" }, item.canvas), el("figcaption", {}, caption));
}

/** 1, 2 or 5 times a power of ten, at most the value. */
export function niceBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}

/** 0.30000000000000004 -> "0.3" */
export function tickText(value) {
  return String(Number(value.toPrecision(6))).replace(/^-/, "−");
}

/** Axes with ticks; returns the maps from values to places. The vertical axis is named at its top. */
export function axes(context, width, height, { x, y, xName, yName }) {
  const box = { left: 44, right: width - 10, top: 24, bottom: height - 36 };
  const toX = (value) => box.left + ((value - x[0]) / (x[1] - x[0] || 1)) * (box.right - box.left);
  const toY = (value) => box.bottom - ((value - y[0]) / (y[1] - y[0] || 1)) * (box.bottom - box.top);
  const ticks = ([low, high], most) => {
    const step = niceBelow((2 * (high - low || 1)) / most), values = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) values.push(k * step);
    return values;
  };
  context.lineWidth = 1;
  context.strokeStyle = color("grid");
  context.fillStyle = color("muted");
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const value of ticks(y, 6)) {
    line(context, box.left, toY(value), box.right, toY(value));
    context.fillText(tickText(value), box.left - 6, toY(value));
  }
  context.textAlign = "center";
  context.textBaseline = "top";
  for (const value of ticks(x, 8)) context.fillText(tickText(value), toX(value), box.bottom + 5);
  context.fillText(xName, (box.left + box.right) / 2, box.bottom + 20);
  context.textAlign = "left";
  context.fillText(yName, 4, 2);
  context.strokeStyle = color("muted");
  line(context, box.left, box.bottom, box.right, box.bottom);
  return { toX, toY, box };
}

export function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
