// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Surveyed landmarks that took part: where each was seen against where it should be.

import { counted, el, fixed, narrowTable, px, section, table, withSigma } from "./dom.js";

const range = (metres) => (metres === null ? "far" : metres < 1000 ? `${fixed(metres, 1)} m` : `${fixed(metres / 1000, 3)} km`);

function imageTable(image) {
  const rows = image.landmarks.map((landmark) => [landmark.name, range(landmark.range_m), ...landmark.residual_px.map(px), px(landmark.sigma_px),
    landmark.sigmas === null ? "–" : fixed(landmark.sigmas, 1), landmark.used ? "" : "left out"]);
  return [el("h3", {}, `${image.image}, camera ${image.camera}`),
    el("p", {}, `${px(image.rms_px)} px rms${image.variance_factor === null ? "" : `, chi² ${fixed(image.variance_factor, 2)} for each degree of freedom`}.`),
    narrowTable([["landmark", ""], ["range", "number"], ["u px", "number"], ["v px", "number"], ["sigma px", "number"], ["sigmas", "number"], ["", ""]], rows,
      `Landmarks in ${image.image}`)];
}

/** What the landmarks moved most, in the sigmas that the boards alone left. */
function movedTable(parameters) {
  const moved = (each) => (each.sigma_without > 0 ? Math.abs(each.with - each.without) / each.sigma_without : 0);
  const most = [...parameters].sort((a, b) => moved(b) - moved(a)).slice(0, 8);
  const rows = most.map((each) => [el("code", {}, each.name), ...withSigma(each.without, each.sigma_without), fixed(each.with, 6), fixed(moved(each), 1)]);
  return table([["parameter", ""], ["boards alone", "number"], ["sigma", "number"], ["with landmarks", "number"], ["sigmas moved", "number"]], rows,
    "What the landmarks moved");
}

export function surveySection(report) {
  if (!report.survey) return null;
  const { images, parameters } = report.survey;
  const node = section("survey", "Surveyed landmarks",
    el("p", {}, `${counted(images.length, "image")} of landmarks took part in the solve; residuals are seen minus predicted.`),
    ...images.flatMap(imageTable), el("h3", {}, "What they moved"), movedTable(parameters));
  node.dataset.short = "Landmarks";
  return node;
}
