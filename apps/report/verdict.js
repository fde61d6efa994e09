// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// What comes first: whether the calibration is good enough, why, and what to do.

import { counted, el, fixed, px, section, sentence } from "./dom.js";
import { imageFrame } from "./image_figures.js";
import { color, figure, plot } from "./plot.js";
import { warningsOf } from "./tables.js";

const words = { pass: "Good enough", marginal: "Just good enough", fail: "Not good enough" };
const marks = { pass: "✓", marginal: "!", fail: "✗" };

function gradeTag(grade, text = grade) {
  return el("span", { class: "grade " + grade }, el("span", { "aria-hidden": "true" }, marks[grade] + " "), text);
}

/** One line under the title of the page. */
export function headline(report) {
  const verdict = report.verdict;
  if (!verdict) return null;
  const warnings = warningsOf(report).length;
  if (!verdict.grade) {
    const lacks = verdict.findings.filter((finding) => !finding.good).length + warnings;
    return el("p", { class: "headline" }, lacks ? gradeTag("marginal", `${counted(lacks, "thing")} to look at`) : gradeTag("pass", "Nothing speaks against it"),
      " Nothing was required of this calibration; say what it is for with ", el("code", {}, "--require"), ".");
  }
  const missed = verdict.judgements.filter((judgement) => judgement.grade !== "pass").length;
  const text = missed ? ` ${missed} of ${counted(verdict.judgements.length, "requirement")} ${verdict.grade === "fail" ? "missed or close" : "close or in doubt"}.`
    : ` ${verdict.judgements.length === 1 ? "The requirement is" : `All ${verdict.judgements.length} requirements are`} met.`;
  return el("p", { class: "headline" }, gradeTag(verdict.grade, words[verdict.grade]), text, warnings ? ` ${counted(warnings, "warning")} to read.` : "");
}

function judgementCard(judgement) {
  return el("li", { class: "card " + judgement.grade },
    el("p", {}, gradeTag(judgement.grade), " ", el("strong", {}, judgement.require), ", ", judgement.subject),
    el("p", {}, sentence(judgement.reason)),
    judgement.advice ? el("p", { class: "advice" }, "→ ", sentence(judgement.advice)) : null);
}

function findingsList(findings) {
  const line = (finding) => el("li", { class: finding.good ? "good" : "look" },
    el("span", { "aria-hidden": "true" }, finding.good ? "✓ " : "! "), el("strong", {}, finding.subject), ", ", finding.topic, ": ", sentence(finding.text),
    finding.advice ? el("span", { class: "advice" }, " → ", sentence(finding.advice)) : null);
  const good = findings.filter((finding) => finding.good), look = findings.filter((finding) => !finding.good);
  return [look.length ? el("ul", { class: "findings" }, look.map(line)) : null,
    good.length ? el("details", {}, el("summary", {}, `${counted(good.length, "check")} of the data without complaint`), el("ul", { class: "findings" }, good.map(line))) : null];
}

export function verdictSection(report) {
  const verdict = report.verdict;
  if (!verdict) return null;
  const worstFirst = ["fail", "marginal", "pass"].flatMap((grade) => verdict.judgements.filter((judgement) => judgement.grade === grade));
  return section("verdict", "Verdict", worstFirst.length ? el("ul", { class: "cards" }, worstFirst.map(judgementCard)) : null,
    el("h3", {}, "What the data are good for"), ...findingsList(verdict.findings));
}

/** The outlines of the suggested boards in the image of one camera, over the corners that there are. */
function nextViewFigure(camera, views) {
  const draw = (context, width, height) => {
    const { toX, toY } = imageFrame(context, camera, width, height);
    context.fillStyle = color("muted");
    context.globalAlpha = 0.5;
    for (const corner of camera.used) context.fillRect(toX(corner.u) - 0.5, toY(corner.v) - 0.5, 1, 1);
    context.lineWidth = 2;
    context.font = "bold 14px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    return views.flatMap((view, i) => {
      const outline = (view.outlines_px[camera.name] ?? []).map(([u, v]) => [toX(u), toY(v)]);
      if (!outline.length) return [];
      context.strokeStyle = context.fillStyle = color("second");
      context.beginPath();
      outline.forEach((p, k) => (k ? context.lineTo(...p) : context.moveTo(...p)));
      context.closePath();
      context.globalAlpha = 1;
      context.stroke();
      context.globalAlpha = 0.12;
      context.fill();
      context.globalAlpha = 1;
      const [x, y] = [0, 1].map((axis) => outline.reduce((sum, p) => sum + p[axis], 0) / outline.length);
      context.fillText(String(i + 1), Math.min(width - 10, Math.max(10, x)), Math.min(height - 10, Math.max(10, y)));
      return [{ x, y, text: `next view ${i + 1}` }];
    });
  };
  return figure(camera.name, plot({ aspect: camera.width / camera.height, label: `Where the next best views lie in the image of ${camera.name}`, draw }), "");
}

export function nextViewsSection(report, cameras) {
  const next = report.next_views;
  if (!next?.views.length) return null;
  const text = (value) => (next.unit === "m" ? `${fixed(1e3 * value, value < 0.01 ? 2 : 1)} mm` : `${px(value)} px`);
  const items = next.views.map((view) => el("li", {}, sentence(view.text), " ",
    el("span", { class: "muted" }, `${text(view.before)} → ${text(view.after)}, ${fixed(100 * (1 - view.after / view.before), 0)} % less`)));
  const figures = cameras.filter((camera) => next.views.some((view) => view.outlines_px[camera.name])).map((camera) => nextViewFigure(camera, next.views));
  const node = section("next", "Next best views",
    el("p", {}, `Of board poses all over the images, near and far, facing and tilted, these reduce most ${next.objective}. Each counts on those before it; the figures are predicted by the same covariance.`),
    el("ol", {}, items), el("div", { class: "figures" }, figures));
  node.dataset.short = "Next views";
  return node;
}
