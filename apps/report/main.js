// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Puts the page together from the report that stands in it.

import "./notice.js";
import { count, counted, el, px, section } from "./dom.js";
import { comparisonSection } from "./comparison.js";
import { histogramFigure, radialFigure, viewBarsFigure } from "./graphs.js";
import { coverageFigure, meanResidualFigure, residualFigure } from "./image_figures.js";
import { laserSection } from "./laser.js";
import { cameraModel } from "./model.js";
import { straightFigures } from "./pictures.js";
import { followPrinterAndScheme, tip } from "./plot.js";
import { surveySection } from "./survey.js";
import { boardsSection, camerasSection, parametersTable, rigSection, runSection, setAsideSection, tiles, warningsSection } from "./tables.js";
import { uncertaintyFigure } from "./uncertainty.js";
import { headline, nextViewsSection, verdictSection } from "./verdict.js";
import { viewsPanel } from "./views.js";

/** camera.choose(entry) shows one of its views. */
function cameraSection(camera, report) {
  const panel = viewsPanel(camera, report);
  const choose = (entry) => {
    panel.choose(entry);
    panel.node.scrollIntoView({ block: "nearest" });
  };
  camera.choose = choose;
  const unreached = camera.corners.filter((corner) => corner.fate === "unprojectable").length;
  const beyond = unreached ? `, ${count(unreached)} because the model does not reach them` : "";
  const figures = camera.used.length
    ? el("div", { class: "figures" }, coverageFigure(camera, choose), residualFigure(camera, choose), uncertaintyFigure(camera, report), meanResidualFigure(camera),
      radialFigure(camera, choose), histogramFigure(camera), viewBarsFigure(camera, choose))
    : el("p", {}, "None of its corners was used.");
  return section(camera.anchor, `Camera ${camera.name}`,
    el("p", {}, `${camera.views_used} of ${counted(camera.views_total, "view")} and ${counted(camera.corners_used, "corner")} used, ` +
      `${count(camera.corners_outlier)} left out as outliers${beyond}; rms ${px(camera.rms_px)} px, median ${px(camera.median_px)} px.`),
    figures, straightFigures(camera, report), el("h3", {}, "Views, worst first"), panel.node, el("h3", {}, "Parameters"), parametersTable(camera, report));
}

function navigation(sections) {
  const links = sections.map((node) => el("li", {}, el("a", { href: "#" + node.id }, node.dataset.short ?? node.querySelector("h2").textContent)));
  return el("nav", { "aria-label": "Parts of the report" }, el("ul", {}, links));
}

function drawPage(report) {
  const cameras = report.cameras.map((camera, i) => ({ ...cameraModel(camera, report), anchor: "camera-" + i }));
  const names = cameras.map((camera) => camera.name).join(", ");
  const chooseFrame = (pose) => {
    const seen = (entry) => entry.view.pose >= 0 && report.poses[entry.view.pose] === pose;
    const camera = cameras.find((each) => each.entries.some(seen));
    camera?.choose(camera.entries.find(seen));
  };
  const warnings = warningsSection(report);
  const sections = [verdictSection(report), warnings, nextViewsSection(report, cameras), camerasSection(cameras, report),
    ...cameras.map((camera) => cameraSection(camera, report)), rigSection(report, cameras, chooseFrame), boardsSection(report), laserSection(report), surveySection(report), comparisonSection(report, cameras),
    setAsideSection(report), runSection(report)].filter(Boolean);
  const version = report.provenance.versions.find(({ name }) => name === "raybundle");
  document.title = `Calibration of ${names}`;
  document.getElementById("page").replaceWith(
    el("header", {}, el("h1", {}, "Calibration report"), el("p", { class: "muted" }, names), headline(report), tiles(report)),
    navigation(sections), el("main", { id: "main" }, sections),
    el("footer", {}, "Drawn from report.json, which this page carries whole", version ? `; Raybundle ${version.value}` : "", "."), tip);
  followPrinterAndScheme();
}

try {
  drawPage(JSON.parse(document.getElementById("report").textContent));
  document.documentElement.dataset.drawn = "yes";
} catch (error) {
  document.documentElement.dataset.drawn = "no";
  document.body.prepend(el("main", { role: "alert" }, el("h1", {}, "This report could not be drawn"), el("p", {}, String(error)),
    el("p", {}, "The numbers are in report.json; please report this together with that file.")));
}
