// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// What is said in words and numbers: warnings, cameras, parameters, places, boards, what was left out, how it was done.

import { count, counted, el, fixed, imageLink, narrowTable, percent, px, section, sentence, table, withSigma } from "./dom.js";
import { boardFigure } from "./board_figure.js";
import { largerSigma } from "./model.js";
import { rectifiedFigures } from "./pictures.js";
import { rigFigure } from "./space.js";

/** Sentences. */
export function warningsOf(report) {
  const ended = { iteration_limit: "The solve stopped at its limit of iterations before it converged.",
    blocked: "The solve ended before the optimum: each step to it would leave what a camera model projects.",
    failed: "The solve failed: do not use this calibration." }[report.termination];
  const missing = report.cameras.filter((camera) => !camera.parameters).map((camera) => `Camera ${camera.name} was not calibrated.`);
  return [ended, ...missing, ...report.warnings].filter(Boolean);
}

export function warningsSection(report) {
  const sentences = warningsOf(report);
  if (!sentences.length) return null;
  const node = section("warnings", sentences.length === 1 ? "One warning" : `${sentences.length} warnings`,
    el("ul", {}, sentences.map((sentence) => el("li", {}, sentence))));
  node.classList.add("warnings");
  return node;
}

export function tiles(report) {
  const sum = (key) => report.cameras.reduce((total, camera) => total + camera[key], 0);
  const used = sum("corners_used"), left = sum("corners_outlier");
  const tile = (name, value, unit) => el("div", {}, el("dt", {}, name), el("dd", {}, value, " ", el("small", {}, unit)));
  const ended = { converged: "converged", iteration_limit: "not converged", blocked: "not converged", failed: "failed" }[report.termination];
  return el("dl", { class: "tiles" },
    tile("rms, all cameras", px(report.rms_px), "px"),
    tile("views used", count(sum("views_used")), "of " + count(sum("views_total"))),
    tile("corners used", count(used), ""),
    tile("corners left out", count(left), percent(left, used + left)),
    tile("solve", ended, `in ${counted(report.iterations, "iteration")}`));
}

/** Whose sigmas stand in the tables. */
function sigmaWords(report) {
  return report.sigma_ratio_by_frame
    ? "± is one standard deviation, by the noise of the corners or by how the frames scatter, whichever is larger."
    : "± is one standard deviation, by the noise of the corners.";
}

export function camerasSection(cameras, report) {
  const rows = cameras.map((camera) => [
    el("a", { href: "#" + camera.anchor }, camera.name), camera.model, `${camera.width}\u00a0×\u00a0${camera.height}`,
    `${camera.views_used} / ${camera.views_total}`, count(camera.corners_used), count(camera.corners_outlier),
    px(camera.used.length ? camera.rms_px : NaN), px(camera.used.length ? camera.median_px : NaN), camera.parameters ? withSigma(camera.parameters.fx, camera.sigmas.fx).join(" ") : "–",
    percent(camera.cells.covered, camera.cells.cells.length),
  ]);
  return section("cameras", "Cameras", table([["camera", ""], ["lens model", ""], ["image", ""], ["views used", "number"],
    ["corners used", "number"], ["left out", "number"], ["rms px", "number"], ["median px", "number"], ["focal length px", "number"],
    ["image covered", "number"]], rows, "Cameras"),
    el("p", { class: "muted" }, "rms is the root of the mean squared distance per corner, as OpenCV defines it. " + sigmaWords(report)));
}

export function parametersTable(camera, report) {
  if (!camera.parameters) return el("p", {}, "This camera was not calibrated.");
  const unit = (name) => (["fx", "fy", "cx", "cy"].includes(name) ? "px" : "");
  const rows = Object.entries(camera.parameters).map(([name, value]) => {
    const [text, sigma] = withSigma(value, camera.sigmas[name]);
    return [el("code", {}, name), text, sigma, unit(name)];
  });
  return el("div", {},
    narrowTable([["parameter", ""], [camera.model, "number"], ["sigma", "number"], ["unit", ""]], rows, `Parameters of ${camera.name}`),
    el("p", { class: "muted" }, sigmaWords(report)));
}

/** As the report says it: the axes of a translation err together, so that their sigmas alone do not tell that of its length. */
function baselineText(camera, report) {
  const known = (report.baselines ?? []).find((baseline) => baseline.camera === camera.name);
  if (!known) return fixed(1e3 * Math.hypot(...camera.camera_from_rig.translation_m), 2);
  return withSigma(1e3 * known.length_m, 1e3 * known.sigma_m).join(" ");
}

export function extrinsicsTable(cameras, report) {
  const rows = cameras.slice(1).filter((camera) => camera.camera_from_rig).map((camera) => {
    const { rotation_xyzw: q, translation_m: t } = camera.camera_from_rig, sigma = (name) => camera.sigmas["camera_from_rig." + name];
    const turn = (2 * Math.atan2(Math.hypot(q[0], q[1], q[2]), Math.abs(q[3])) * 180) / Math.PI;
    const turn_sigma = (Math.hypot(...["x", "y", "z"].map((axis) => sigma("rotation_" + axis) ?? 0)) * 180) / Math.PI;
    const millimetres = ["x", "y", "z"].map((axis, i) => withSigma(1e3 * t[i], 1e3 * sigma("translation_" + axis)).join(" "));
    return [camera.name, baselineText(camera, report), fixed(turn, 3), fixed(turn_sigma, 4), ...millimetres];
  });
  return narrowTable([["camera", ""], ["baseline mm", "number"], ["turned by °", "number"], ["rotation sigma °", "number"], ["x mm", "number"],
    ["y mm", "number"], ["z mm", "number"]], rows, "Places of the cameras");
}

/** chooseFrame(pose) shows the view of a board that is clicked in space. */
export function rigSection(report, cameras, chooseFrame) {
  const first = cameras[0].name;
  const words = cameras.length > 1
    ? [extrinsicsTable(cameras, report), el("p", { class: "muted" },
      `Relative to ${first}, whose frame is the rig frame. x, y, z: translation of camera_from_rig. Rotation sigma: root of the summed squares over the three axes. ${sigmaWords(report)}`)]
    : [];
  const space = report.poses.length && cameras.some((camera) => camera.camera_from_rig) ? [rigFigure(report, chooseFrame)] : [];
  return section("rig", cameras.length > 1 ? "The rig" : "The poses", ...words, ...space, ...rectifiedFigures(report), el("p", { class: "muted" }, sentence(report.gauge)));
}

export function boardsSection(report) {
  const rows = report.targets.map((target) => {
    const shape = target.shape ?? {}, known = target.shape_sigmas ?? {};
    const sigmas = Object.fromEntries(Object.entries(known).map(([key, sigma]) => [key, largerSigma(sigma, `${target.name}.${key.replace(/_m$/, "")}`, report)]));
    const sag = (key) => (sigmas[key] > 0 ? withSigma(1e3 * shape[key], 1e3 * sigmas[key]).join(" ") : shape[key] ? fixed(1e3 * shape[key], 3) + " held fixed" : "taken as 0");
    return [target.name, count(target.points.length), sag("bend_x_m"), sag("bend_y_m"), sag("twist_m")];
  });
  return section("boards", report.targets.length === 1 ? "The board" : "The boards",
    narrowTable([["board", ""], ["points", "number"], ["bend along x mm", "number"], ["bend along y mm", "number"], ["twist mm", "number"]], rows, "Boards"),
    el("div", { class: "figures" }, report.targets.map(boardFigure)),
    el("p", { class: "muted" }, "Bend: how far the middle stands off the plane through the edges; twist: how far the corners do."));
}

/** What other measurements moved most, in the sigmas that the boards alone left. */
export function movedTable(parameters, withOthers) {
  const moved = (each) => (each.sigma_without > 0 ? Math.abs(each.with - each.without) / each.sigma_without : 0);
  const most = [...parameters].sort((a, b) => moved(b) - moved(a)).slice(0, 8);
  const rows = most.map((each) => [el("code", {}, each.name), ...withSigma(each.without, each.sigma_without), fixed(each.with, 6), fixed(moved(each), 1)]);
  return table([["parameter", ""], ["boards alone", "number"], ["sigma", "number"], [withOthers, "number"], ["sigmas moved", "number"]], rows,
    "What they moved");
}

export function setAsideSection(report) {
  const kinds = { view: "Views set aside", extrinsics: "Views that count for their camera, but not for its place on the rig", image: "Images without a view" };
  const parts = Object.entries(kinds).flatMap(([scope, title]) => {
    const entries = report.set_aside.filter((entry) => entry.scope === scope);
    if (!entries.length) return [];
    const rows = entries.map((entry) => [entry.camera, entry.frame, imageLink(entry.image), entry.reason]);
    return [el("h3", {}, `${title} (${entries.length})`), table([["camera", ""], ["frame", ""], ["image", "path"], ["why", "words"]], rows, title)];
  });
  if (!parts.length) parts.push(el("p", {}, "Nothing: every image gave a view, and every view was used."));
  const node = section("aside", "What was set aside, and why", ...parts,
    report.outlier_rule ? el("p", { class: "muted" }, sentence(report.outlier_rule)) : null);
  node.dataset.short = "Set aside";
  return node;
}

export function runSection(report) {
  const total = report.stages.reduce((sum, stage) => sum + stage.seconds, 0);
  const longest = Math.max(1e-9, ...report.stages.map((stage) => stage.seconds));
  const stages = report.stages.map((stage) => [stage.name, fixed(stage.seconds, 2), el("span", { class: "bar", style: `width:${((12 * stage.seconds) / longest).toFixed(2)}rem` })]);
  const { command, inputs, options, versions } = report.provenance;
  const pairs = (entries, title) => narrowTable([[title, ""], ["", "path"]], entries.map(({ name, value }) => [name, el("code", {}, value)]), title);
  return section("run", "How it was done",
    command ? el("p", {}, el("code", {}, command)) : null,
    narrowTable([["stage", ""], ["seconds", "number"], ["", ""]], [...stages, ["together", fixed(total, 2), ""]], "Time by stage"),
    el("p", { class: "muted" }, `Variance factor ${fixed(report.variance_factor, 3)}: chi² per degree of freedom, by which all sigmas have been scaled.`),
    el("details", {}, el("summary", {}, "Options and versions"), pairs(options, "option"), pairs(versions, "version")),
    el("details", {}, el("summary", {}, `Inputs and their SHA-256 (${inputs.length})`),
      table([["file", "path"], ["SHA-256", "path"]], inputs.map(({ path, sha256 }) => [path, el("code", {}, sha256)]), "Inputs")));
}
