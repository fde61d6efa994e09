// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Odd against even frames, and the second opinion of another optimiser: where two calibrations project differently.

import { el, fixed, narrowTable, percent, px, section, sentence } from "./dom.js";
import { arrow, imageFrame, scaleBar, stretchFor } from "./image_figures.js";
import { color, figure, plot, tickText } from "./plot.js";

/** The cells of a difference map that exist, with their places in the image. */
function arrowsOf(map, camera) {
  const rows = map.u_px.length, columns = map.u_px[0]?.length ?? 0, arrows = [];
  map.u_px.forEach((row, i) => row.forEach((du, k) => {
    const dv = map.v_px[i][k], sigma = map.summed_sigma_px[i][k];
    if (du === null || dv === null) return;
    arrows.push({ du, dv, sigma, u: ((k + 0.5) * camera.width) / columns - 0.5, v: ((i + 0.5) * camera.height) / rows - 0.5, length: Math.hypot(du, dv) });
  }));
  return arrows;
}

function differenceFigure(projection, camera, mostSigmas) {
  if (projection.largest_px < 5e-4) return el("p", {}, `${camera.name}: nowhere more than ${px(projection.largest_px)} px apart.`);
  const arrows = arrowsOf(projection.map, camera);
  if (!arrows.length) return null;
  const { stretch, bar } = stretchFor(arrows.map((each) => each.length), camera);
  const draw = (context, width, height) => {
    const { scale, toX, toY } = imageFrame(context, camera, width, height);
    const marks = arrows.map((each) => {
      const x = toX(each.u), y = toY(each.v), within = each.length <= mostSigmas * each.sigma;
      context.strokeStyle = color(within ? "accent" : "bad");
      context.lineWidth = within ? 1 : 1.75;
      context.beginPath();
      arrow(context, x, y, each.du * stretch * scale, each.dv * stretch * scale);
      context.stroke();
      return { x, y, text: `${px(each.length)} px apart, summed sigma ${px(each.sigma)} px` };
    });
    scaleBar(context, width, height, bar * stretch * scale, `${tickText(bar)} px, drawn × ${tickText(stretch)}`);
    return marks;
  };
  const where = projection.range_m === null ? "at infinity" : `at ${projection.range_m} m`;
  const words = `${px(projection.rms_px)} px apart rms, ${px(projection.largest_px)} px at most; ${percent(projection.share_within, 1)} of the covered image within ${mostSigmas} summed sigmas`;
  return figure(`${camera.name}, ${where}`, plot({ aspect: camera.width / camera.height, label: `${camera.name}, ${where}: ${words}`, draw }), `${words}. Red: farther apart than that.`);
}

function comparisonFigures(comparison, cameras) {
  const figures = comparison.projections.map((projection) =>
    differenceFigure(projection, cameras.find((camera) => camera.name === projection.camera), comparison.most_summed_sigmas));
  return el("div", { class: "figures" }, figures);
}

function trialsTable(trials) {
  if (!trials.length) return null;
  const rows = trials.map((trial) => [trial.camera, trial.model, px(trial.rms_px), percent(trial.share_within, 1), trial.agrees ? "agrees" : "differs"]);
  return narrowTable([["camera", ""], ["lens model", ""], ["rms px", "number"], ["within", "number"], ["", ""]], rows, "Other lens models");
}

function crossValidationParts(found, cameras) {
  const shown = found.by_frames ?? found.by_corners;
  return [el("h3", {}, "Odd against even frames"), el("p", {}, sentence(found.words)), trialsTable(found.trials),
    shown ? comparisonFigures(shown, cameras) : null];
}

function secondOpinionParts(opinions, cameras) {
  const parts = opinions.flatMap((opinion) => opinion.comparison
    ? [el("p", {}, `${opinion.source}, rms ${fixed(opinion.rms_px, 3)} px, from the same corners. ${opinion.remark ? sentence(opinion.remark) : ""}`),
      comparisonFigures(opinion.comparison, cameras)]
    : [el("p", {}, sentence(opinion.why_not))]);
  return [el("h3", {}, "Second opinion"), ...parts];
}

/** Null when the calibration was not compared with anything. */
export function comparisonSection(report, cameras) {
  const parts = [...(report.cross_validation ? crossValidationParts(report.cross_validation, cameras) : []),
    ...(report.second_opinion ? secondOpinionParts(report.second_opinion, cameras) : [])];
  return parts.length ? section("comparison", "Comparison", ...parts) : null;
}
