// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Figures with axes: residuals against the angle, their distribution, and the views one by one.

import { counted, px } from "./dom.js";
import { cornerMark, cross } from "./image_figures.js";
import { quantile } from "./model.js";
import { axes, color, figure, line, plot } from "./plot.js";

export const graphAspect = 1.6;
export const rayleighMedian = Math.sqrt(2 * Math.log(2));  // median distance of two normal components, in their sigma

/** Mean and rms of `value` in about 16 steps of `place`. */
export function steps(corners, place, value, low, high) {
  const bins = Array.from({ length: 16 }, () => ({ n: 0, sum: 0, squares: 0 }));
  for (const corner of corners) {
    const bin = bins[Math.min(15, Math.floor((16 * (corner[place] - low)) / (high - low || 1)))];
    bin.n += 1;
    bin.sum += corner[value];
    bin.squares += corner[value] ** 2;
  }
  return bins
    .map((bin, i) => ({ at: low + ((i + 0.5) * (high - low)) / 16, n: bin.n, mean: bin.sum / bin.n, rms: Math.sqrt(bin.squares / bin.n) }))
    .filter((bin) => bin.n >= 10);
}

export function path(context, points) {
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
}

/** Radial part of the residual against the angle from the axis or, without poses, the distance from the centre. */
export function radialFigure(camera, choose) {
  const place = camera.hasAngles ? "angle" : "radius";
  const corners = camera.used.filter((corner) => Number.isFinite(corner[place]));
  const high = corners.reduce((most, corner) => Math.max(most, corner[place]), 0) || 1;
  const reach = 1.25 * quantile(corners.map((corner) => Math.abs(corner.radial)).sort((a, b) => a - b), 0.99) || 1;
  const bins = steps(corners, place, "radial", 0, high);
  const name = camera.hasAngles ? "angle from the axis [°]" : "distance from the centre [px]";
  const draw = (context, width, height) => {
    const { toX, toY, box } = axes(context, width, height, { x: [0, high], y: [-reach, reach], xName: name, yName: "outward residual [px]" });
    const dot = corners.length > 5000 ? 1 : 1.8;
    context.fillStyle = color("accent");
    context.globalAlpha = corners.length > 5000 ? 0.45 : 0.7;
    const marks = [];
    for (const corner of corners) {
      const x = toX(corner[place]), y = Math.min(box.bottom, Math.max(box.top, toY(corner.radial)));
      context.fillRect(x - dot / 2, y - dot / 2, dot, dot);
      marks.push(cornerMark(corner, x, y, choose));
    }
    context.globalAlpha = 1;
    context.strokeStyle = color("second");
    context.lineWidth = 2.5;
    path(context, bins.map((bin) => [toX(bin.at), toY(bin.mean)]));
    context.lineWidth = 1;
    context.setLineDash([4, 4]);
    for (const side of [-1, 1]) path(context, bins.map((bin) => [toX(bin.at), toY(side * bin.rms)]));
    context.setLineDash([]);
    return marks;
  };
  const largest = bins.reduce((most, bin) => Math.max(most, Math.abs(bin.mean)), 0);
  const label = `Outward residual of ${camera.name} by ${name}; the mean stays within ${px(largest)} px of zero`;
  return figure(camera.hasAngles ? "By angle from the axis" : "By distance from the centre", plot({ aspect: graphAspect, label, draw }),
    `The line is the mean, which stays within ${px(largest)} px of zero; dashed is the rms. ` +
    "A line that wanders far from zero asks for another lens model, or for more corners there.");
}

export function histogramFigure(camera) {
  const high = 1.15 * quantile(camera.distances, 0.995) || 1, bins = new Array(40).fill(0);
  for (const distance of camera.distances) if (distance < high) bins[Math.floor((40 * distance) / high)] += 1;
  const sigma = camera.median_px / rayleighMedian, total = camera.distances.length;
  const expected = (r) => ((total * high) / 40) * (r / sigma ** 2) * Math.exp((-r * r) / (2 * sigma * sigma));
  const top = Math.max(1, ...bins, sigma > 0 ? expected(sigma) : 0) * 1.05;
  const draw = (context, width, height) => {
    const { toX, toY, box } = axes(context, width, height, { x: [0, high], y: [0, top], xName: "distance [px]", yName: "corners" });
    context.fillStyle = color("accent");
    bins.forEach((n, i) => context.fillRect(toX((i * high) / 40) + 0.5, toY(n), toX(high / 40) - toX(0) - 1, box.bottom - toY(n)));
    context.strokeStyle = color("second");
    context.lineWidth = 2;
    if (sigma > 0) path(context, Array.from({ length: 121 }, (_, i) => (i * high) / 120).map((r) => [toX(r), toY(expected(r))]));
    context.fillStyle = context.strokeStyle = color("ink");
    context.lineWidth = 1;
    context.textBaseline = "top";
    for (const [name, value, side] of [["median", camera.median_px, -1], ["rms", camera.rms_px, 1]]) {
      const x = toX(Math.min(value, high));
      line(context, x, box.top, x, box.bottom);
      context.textAlign = side < 0 ? "right" : "left";
      context.fillText(`${name} ${px(value)}`, x + 4 * side, box.top);
    }
    return bins.map((n, i) => ({ x: toX(((i + 0.5) * high) / 40), y: toY(n / 2), text: counted(n, "corner") }));
  };
  const label = `Distribution of the residuals of ${camera.name}: median ${px(camera.median_px)} px, rms ${px(camera.rms_px)} px`;
  return figure("How large the residuals are", plot({ aspect: graphAspect, label, draw }),
    "The line is what Gaussian noise with the same median would give. More than that on the right is blur, " +
    "wrong corners, a moving board, or a model that does not fit.");
}

export function viewBarsFigure(camera, choose) {
  const entries = camera.entries, top = Math.max(1e-9, ...entries.map((entry) => entry.view.rms_px)) * 1.1;
  const draw = (context, width, height) => {
    const { toX, toY, box } = axes(context, width, height, { x: [0, entries.length], y: [0, top], xName: "views in the order of the frames", yName: "rms [px]" });
    const wide = toX(1) - toX(0), gap = wide > 4 ? 1 : 0;
    const marks = entries.map((entry, i) => {
      const aside = entry.view.pose < 0, x = toX(i + 0.5), y = toY(entry.view.rms_px);
      context.fillStyle = color("accent");
      context.strokeStyle = color("bad");
      context.lineWidth = 2;
      if (aside) cross(context, x, box.bottom - 8, 4);
      else context.fillRect(toX(i) + gap / 2, y, Math.max(0.7, wide - gap), box.bottom - y);
      const text = aside ? "set aside" : `${px(entry.view.rms_px)} px rms, ${counted(entry.used.length, "corner")}`;
      return { x, y: aside ? box.bottom - 8 : (y + box.bottom) / 2, text: `frame ${entry.name}\n${text}`, choose: () => choose(entry) };
    });
    context.strokeStyle = color("ink");
    context.lineWidth = 1;
    context.setLineDash([2, 3]);
    line(context, box.left, toY(camera.rms_px), box.right, toY(camera.rms_px));
    context.setLineDash([]);
    return marks;
  };
  const label = `rms of the ${entries.length} views of ${camera.name}`;
  return figure("View by view", plot({ aspect: graphAspect, label, draw }),
    "Dotted: the rms of the camera. A cross is a view that was set aside. Choose a bar to see its view below.");
}
