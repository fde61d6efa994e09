// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The beams of a dot projector: how many there are, how well they tell depth, and what their dots did to the cameras.

import { count, counted, el, fixed, narrowTable, percent, px, section, sentence } from "./dom.js";
import { quantile } from "./model.js";
import { color, figure, plot } from "./plot.js";
import { ramp, rampColor } from "./ramp.js";
import { movedTable } from "./tables.js";

const mm = (metres) => fixed(1e3 * metres, metres < 0.01 ? 2 : 1);

/** Of each beam at one of the stated depths: [row, column, sigma in metres], where the camera sees it. */
function sigmasAt(laser, depth) {
  return laser.beams.flatMap(({ row, column, depths }) => {
    const found = depths.find((each) => each.depth_m === depth);
    return found?.sigma_m > 0 ? [[row, column, found]] : [];
  });
}

function depthTable(laser, depths) {
  const rows = depths.flatMap((depth) => {
    const seen = sigmasAt(laser, depth);
    if (!seen.length) return [];
    const sigmas = seen.map(([, , each]) => each.sigma_m).sort((a, b) => a - b), perPx = seen.map(([, , each]) => each.per_px_m).sort((a, b) => a - b);
    return [[`${depth} m`, count(seen.length), mm(quantile(sigmas, 0.5)), mm(quantile(sigmas, 0.9)), mm(quantile(perPx, 0.5))]];
  });
  return narrowTable([["depth", ""], ["beams that are seen", "number"], ["median ± mm", "number"], ["90 % within ± mm", "number"], ["mm for a pixel of a dot", "number"]],
    rows, "Depth by the beams");
}

/** The grid of beams; what was not calibrated is crossed out. */
function beamsFigure(laser, depth) {
  const { rows, columns } = laser, known = new Map(sigmasAt(laser, depth).map(([row, column, each]) => [row * columns + column, each.sigma_m]));
  const hits = new Map(laser.beams.map((beam) => [beam.row * columns + beam.column, beam.hits]));
  const all = [...known.values()].sort((a, b) => a - b);
  const low = quantile(all, 0), high = Math.max(quantile(all, 0.9), 1.01 * low);
  const draw = (context, width, height) => {
    const [w, h] = [width / columns, (height - 26) / rows], marks = [];
    for (let row = 0; row < rows; ++row) {
      for (let column = 0; column < columns; ++column) {
        const at = row * columns + column, [x, y] = [column * w, row * h], sigma = known.get(at);
        const name = `row ${row}, column ${column}`;
        if (sigma !== undefined) {
          context.fillStyle = rampColor(Math.log(sigma / low) / Math.log(high / low));
          context.fillRect(x + 0.5, y + 0.5, w - 1, h - 1);
        } else {
          context.strokeStyle = color("muted");
          context.strokeRect(x + 0.5, y + 0.5, w - 1, h - 1);
          if (!hits.has(at)) cross(context, x, y, w, h);
        }
        const seen = hits.has(at) ? `${counted(hits.get(at), "dot")}, ${sigma === undefined ? `not seen at ${depth} m` : `± ${mm(sigma)} mm at ${depth} m`}` : "not calibrated";
        marks.push({ x: x + w / 2, y: y + h / 2, text: `${name}: ${seen}` });
      }
    }
    ramp(context, `± ${mm(low)} mm`, `${mm(high)} mm or more`, width, height - 20);
    return marks;
  };
  return figure("How well each beam tells depth", plot({ aspect: columns / (rows + 0.09 * columns), label: `Sigma of the depth at ${depth} m of ${counted(all.length, "beam")}`, draw }),
    `One standard deviation at ${depth} m, by the calibration alone. Columns count to the right and rows down; empty: the camera does not see the beam there; crossed out: it was not calibrated.`);
}

function cross(context, x, y, w, h) {
  context.beginPath();
  context.moveTo(x + 2, y + 2);
  context.lineTo(x + w - 2, y + h - 2);
  context.moveTo(x + w - 2, y + 2);
  context.lineTo(x + 2, y + h - 2);
  context.stroke();
}

function labelWords(advice) {
  if (!advice) return null;
  const turn = advice.best_turn, better = turn && turn.single_candidate_share > advice.single_candidate_share + 0.01;
  return el("p", {}, `Within ${px(advice.tolerance_px)} px a dot alone tells its beam for ${percent(advice.single_candidate_share, 1)} of the depths` +
    (better ? `; with the grating turned by ${fixed((turn.turn_rad * 180) / Math.PI, 0)}° it would be ${percent(turn.single_candidate_share, 1)}.` : "."));
}

export function laserSection(report) {
  const laser = report.laser;
  if (!laser?.beams?.length) return null;
  const depths = laser.beams[0].depths.map((each) => each.depth_m);
  const shown = depths.reduce((best, depth) => (Math.abs(Math.log(depth)) < Math.abs(Math.log(best)) ? depth : best), depths[0]);
  const moved = laser.parameters.map((each) => ({ name: each.name, without: each.without_dots, with: each.with_dots, sigma_without: each.sigma_without_dots }));
  const node = section("laser", "The laser",
    el("p", {}, `${count(laser.beams.length)} of ${counted(laser.rows * laser.columns, "beam")} from ${counted(laser.dots_used, "dot")}, rms ${px(laser.rms_px)} px; ` +
      `${count(laser.dots_outlier)} left out as outliers, ${count(laser.dots_unlabelled)} without a label. What says which beam is which: ${sentence(laser.label_origin)}`),
    el("div", { class: "figures" }, sigmasAt(laser, shown).length ? beamsFigure(laser, shown) : null), el("h3", {}, "Depth"), depthTable(laser, depths), labelWords(laser.label_advice),
    el("h3", {}, "What the dots moved"), movedTable(moved, "with dots"));
  node.dataset.short = "Laser";
  return node;
}
