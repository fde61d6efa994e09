// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Figures in the frame of the image: where the corners are, and where the residuals point.

import { count, fixed, percent, px } from "./dom.js";
import { quantile } from "./model.js";
import { color, figure, line, niceBelow, plot, tickText } from "./plot.js";

/** Draws the frame of the image and returns the map from pixels to places. */
export function imageFrame(context, camera, width, height) {
  const scale = width / camera.width;
  context.strokeStyle = color("muted");
  context.lineWidth = 1;
  context.strokeRect(0.5, 0.5, width - 1, height - 1);
  return { scale, toX: (u) => (u + 0.5) * scale, toY: (v) => (v + 0.5) * scale };
}

export function cornerText(corner) {
  const where = Number.isFinite(corner.angle) ? `, ${fixed(corner.angle, 0)}° off axis` : "";
  const residual = Number.isFinite(corner.distance)
    ? `${px(corner.distance)} px (${fixed(corner.du, 2)}, ${fixed(corner.dv, 2)})`
    : "no residual";
  return `frame ${corner.entry.name}, corner ${corner.id}\n${residual}${where}\n${fateText(corner.fate)}`;
}

export function fateText(fate) {
  return { used: "used", outlier: "left out as an outlier", unprojectable: "left out: the model does not reach it",
    view_set_aside: "its view was set aside" }[fate] ?? fate;
}

export function cornerMark(corner, x, y, choose) {
  return { x, y, text: () => cornerText(corner), choose: () => choose(corner.entry) };
}

export function cross(context, x, y, size) {
  line(context, x - size, y - size, x + size, y + size);
  line(context, x - size, y + size, x + size, y - size);
}

export function coverageFigure(camera, choose) {
  const { columns, rows, cells, covered } = camera.cells;
  const most = cells.reduce((n, cell) => Math.max(n, cell.n), 1);
  const draw = (context, width, height) => {
    context.fillStyle = color("accent");
    cells.forEach((cell, i) => {
      if (!cell.n) return;
      context.globalAlpha = 0.1 + 0.5 * Math.sqrt(cell.n / most);
      context.fillRect(((i % columns) * width) / columns, (Math.floor(i / columns) * height) / rows, width / columns + 0.5, height / rows + 0.5);
    });
    context.globalAlpha = 1;
    const { toX, toY } = imageFrame(context, camera, width, height);
    const dot = camera.corners.length > 5000 ? 1 : 1.6;
    context.fillStyle = color("ink");
    context.strokeStyle = color("bad");
    context.lineWidth = 1.5;
    return camera.corners.map((corner) => {
      const x = toX(corner.u), y = toY(corner.v);
      if (corner.fate === "used") context.fillRect(x - dot / 2, y - dot / 2, dot, dot);
      else cross(context, x, y, 3);
      return cornerMark(corner, x, y, choose);
    });
  };
  const share = percent(covered, columns * rows);
  const reach = camera.hasAngles ? ` and reach ${fixed(camera.widest, 0)}° from the axis` : "";
  const label = `Corners in the image of ${camera.name}: they cover ${share} of it`;
  return figure("Where the corners are", plot({ aspect: camera.width / camera.height, label, draw }),
    `The used corners fall into ${share} of the image${reach}. The stronger a cell's colour, the more of them, up to ${count(most)}. ` +
    "Crosses were left out. Where there are none, the lens model extrapolates.");
}

/** How much to stretch residuals so that a large one takes some part of the width, and a bar that tells it. */
export function stretchFor(lengths, camera) {
  const typical = quantile([...lengths].sort((a, b) => a - b), 0.9) || 1;
  const stretch = niceBelow((0.035 * camera.width) / typical);
  return { stretch, bar: niceBelow((0.12 * camera.width) / stretch) };
}

export function scaleBar(context, width, height, length, text) {
  const x = 12, y = height - 12, room = Math.max(length, context.measureText(text).width) + 16;
  context.globalAlpha = 0.85;
  context.fillStyle = color("sheet");
  context.fillRect(x - 8, y - 24, room, 32);
  context.globalAlpha = 1;
  context.strokeStyle = context.fillStyle = color("ink");
  context.lineWidth = 2;
  line(context, x, y, x + length, y);
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.fillText(text, x, y - 7);
}

export function residualFigure(camera, choose) {
  const { stretch, bar } = stretchFor(camera.distances, camera);
  const draw = (context, width, height) => {
    const { scale, toX, toY } = imageFrame(context, camera, width, height);
    context.strokeStyle = color("accent");
    context.lineWidth = 1;
    context.globalAlpha = camera.used.length > 5000 ? 0.45 : 0.8;
    context.beginPath();
    const marks = camera.used.map((corner) => {
      const x = toX(corner.u), y = toY(corner.v);
      context.moveTo(x, y);
      context.lineTo(x + corner.du * stretch * scale, y + corner.dv * stretch * scale);
      return cornerMark(corner, x, y, choose);
    });
    context.stroke();
    context.globalAlpha = 1;
    context.strokeStyle = color("bad");
    for (const corner of camera.leftOut) {
      cross(context, toX(corner.u), toY(corner.v), 3);
      marks.push(cornerMark(corner, toX(corner.u), toY(corner.v), choose));
    }
    scaleBar(context, width, height, bar * stretch * scale, `${tickText(bar)} px, drawn × ${tickText(stretch)}`);
    return marks;
  };
  const label = `Residual of every corner of ${camera.name}, drawn ${tickText(stretch)} times as long; 90 % are below ${px(quantile(camera.distances, 0.9))} px`;
  return figure("Residual of every corner", plot({ aspect: camera.width / camera.height, label, draw }),
    "From where the model puts a corner towards where it was measured. Good ones point everywhere at random. " +
    "Choose one with the pointer to see its view.");
}

export function arrow(context, x, y, dx, dy) {
  const length = Math.hypot(dx, dy), head = Math.min(5, 0.4 * length);
  const ux = dx / (length || 1), uy = dy / (length || 1);
  context.moveTo(x, y);
  context.lineTo(x + dx, y + dy);
  context.moveTo(x + dx - head * (ux - 0.6 * uy), y + dy - head * (uy + 0.6 * ux));
  context.lineTo(x + dx, y + dy);
  context.lineTo(x + dx - head * (ux + 0.6 * uy), y + dy - head * (uy - 0.6 * ux));
}

export const fewestInCell = 5;

export function meanResidualFigure(camera) {
  const { columns, rows, cells } = camera.means;
  const means = cells.map((cell, i) => ({ n: cell.n, du: cell.du / cell.n, dv: cell.dv / cell.n,
    u: (((i % columns) + 0.5) * camera.width) / columns - 0.5, v: ((Math.floor(i / columns) + 0.5) * camera.height) / rows - 0.5,
  })).filter((mean) => mean.n >= fewestInCell);
  const lengths = means.map((mean) => Math.hypot(mean.du, mean.dv));
  const { stretch, bar } = stretchFor(lengths, camera);
  const draw = (context, width, height) => {
    const { scale, toX, toY } = imageFrame(context, camera, width, height);
    context.strokeStyle = color("second");
    context.lineWidth = 1.5;
    context.beginPath();
    const marks = means.map((mean, i) => {
      const x = toX(mean.u), y = toY(mean.v);
      arrow(context, x, y, mean.du * stretch * scale, mean.dv * stretch * scale);
      return { x, y, text: `mean of ${mean.n} corners: ${px(lengths[i])} px` };
    });
    context.stroke();
    scaleBar(context, width, height, bar * stretch * scale, `${tickText(bar)} px, drawn × ${tickText(stretch)}`);
    return marks;
  };
  const largest = lengths.reduce((a, b) => Math.max(a, b), 0);
  const label = `Mean residual in each part of the image of ${camera.name}; the largest is ${px(largest)} px`;
  return figure("What the lens model leaves over", plot({ aspect: camera.width / camera.height, label, draw }),
    `Mean residual of each cell with at least ${fewestInCell} corners: noise averages out, so neighbours that point the same ` +
    `way show what the model cannot follow. The largest is ${px(largest)} px.`);
}
