// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// How well projections are known all over an image, at a distance that can be chosen.

import { el, px } from "./dom.js";
import { imageFrame } from "./image_figures.js";
import { quantile } from "./model.js";
import { color, figure, plot } from "./plot.js";
import { ramp, rampColor } from "./ramp.js";

function rangeText(range) {
  return range === null ? "infinity" : `${range} m`;
}

/** Null when the report has no maps of the camera. */
export function uncertaintyFigure(camera, report) {
  const maps = (report.uncertainty_maps ?? []).filter((map) => map.camera === camera.name);
  if (!maps.length) return null;
  let map = maps[0];
  const all = maps.flatMap((each) => each.sigma_px.flat().filter((value) => value !== null)).sort((a, b) => a - b);
  const low = quantile(all, 0), high = Math.max(quantile(all, 0.9), 1.01 * low);
  const aspect = camera.width / (camera.height + 0.07 * camera.width);
  const draw = (context, width, height) => {
    const tall = (width * camera.height) / camera.width, rows = map.sigma_px.length, columns = map.sigma_px[0].length;
    const marks = map.sigma_px.flatMap((row, i) => row.map((value, k) => {
      const [x, y, w, h] = [(k * width) / columns, (i * tall) / rows, width / columns, tall / rows];
      if (value === null) return null;
      context.fillStyle = rampColor(Math.log(value / low) / Math.log(high / low));
      context.fillRect(x, y, w + 0.5, h + 0.5);
      return { x: x + w / 2, y: y + h / 2, text: `± ${px(value)} px` };
    })).filter(Boolean);
    hatchUnseen(context, camera, width, tall);
    imageFrame(context, camera, width, tall);
    ramp(context, `${px(low)} px`, `${px(high)} px or more`, width, tall + 6);
    return marks;
  };
  const item = plot({ aspect, label: `Uncertainty of projections of ${camera.name}: ${px(low)} px at best, 90 % below ${px(high)} px`, draw });
  const choice = maps.length < 2 ? null : el("label", { class: "choice" }, "at a distance of ",
    el("select", { onchange: (event) => { map = maps[event.target.value]; item.redraw(); } }, maps.map((each, i) => el("option", { value: i }, rangeText(each.range_m)))));
  const node = figure("How well projections are known", item,
    "One standard deviation of where a point lands, after the rotation that no board can tell from a shift of the image is taken out; by the noise of the corners or by how the frames scatter, whichever is larger. " +
    "Hatched: no corner was seen there, so that nothing tests the lens.");
  if (choice) node.querySelector("h3").after(choice);
  return node;
}

function hatchUnseen(context, camera, width, height) {
  const { columns, rows, cells } = camera.cells;
  context.save();
  context.beginPath();
  cells.forEach((cell, i) => {
    if (!cell.n) context.rect(((i % columns) * width) / columns, (Math.floor(i / columns) * height) / rows, width / columns, height / rows);
  });
  context.clip();
  context.strokeStyle = color("sheet");
  context.globalAlpha = 0.75;
  context.beginPath();
  for (let x = -height; x < width; x += 7) {
    context.moveTo(x, height);
    context.lineTo(x + height, 0);
  }
  context.stroke();
  context.restore();
}
