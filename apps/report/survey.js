// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Surveyed landmarks that took part: where each was seen against where it should be.

import { counted, el, fixed, narrowTable, px, section } from "./dom.js";
import { movedTable } from "./tables.js";

const range = (metres) => (metres === null ? "far" : metres < 1000 ? `${fixed(metres, 1)} m` : `${fixed(metres / 1000, 3)} km`);

function imageTable(image) {
  const rows = image.landmarks.map((landmark) => [landmark.name, range(landmark.range_m), ...landmark.residual_px.map(px), px(landmark.sigma_px),
    landmark.sigmas === null ? "–" : fixed(landmark.sigmas, 1), landmark.used ? "" : "left out"]);
  return [el("h3", {}, `${image.image}, camera ${image.camera}`),
    el("p", {}, `${px(image.rms_px)} px rms${image.variance_factor === null ? "" : `, chi² ${fixed(image.variance_factor, 2)} for each degree of freedom`}.`),
    narrowTable([["landmark", ""], ["range", "number"], ["u px", "number"], ["v px", "number"], ["sigma px", "number"], ["sigmas", "number"], ["", ""]], rows,
      `Landmarks in ${image.image}`)];
}

export function surveySection(report) {
  if (!report.survey) return null;
  const { images, parameters } = report.survey;
  const node = section("survey", "Surveyed landmarks",
    el("p", {}, `${counted(images.length, "image")} of landmarks took part in the solve; residuals are seen minus predicted.`),
    ...images.flatMap(imageTable), el("h3", {}, "What they moved"), movedTable(parameters, "with landmarks"));
  node.dataset.short = "Landmarks";
  return node;
}
