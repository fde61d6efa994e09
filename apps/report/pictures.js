// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Pictures that the report carries: what is straight in the world is straight in them, or the calibration is wrong.

import { el } from "./dom.js";

const namespace = "http://www.w3.org/2000/svg";

export function pictureAddress(picture) {
  return "data:image/jpeg;base64," + picture.jpeg;
}

/** The picture of that kind; frame is optional. */
export function findPicture(report, kind, camera, frame = null) {
  return (report.pictures ?? []).find((each) => each.kind === kind && each.camera === camera && (frame === null || each.frame === frame));
}

/** A picture with its lines drawn over it. */
function lined(picture, text) {
  const svg = document.createElementNS(namespace, "svg");
  svg.setAttribute("viewBox", `0 0 ${picture.width} ${picture.height}`);
  for (const [x1, y1, x2, y2] of picture.lines ?? []) {
    const line = document.createElementNS(namespace, "line");
    Object.entries({ x1, y1, x2, y2 }).forEach(([name, value]) => line.setAttribute(name, value + 0.5));
    svg.append(line);
  }
  return el("div", { class: "picture" }, el("img", { src: pictureAddress(picture), width: picture.width, height: picture.height, alt: text, loading: "lazy" }), svg);
}

/** The same image before and after, side by side; null without one. */
export function straightFigures(camera, report) {
  const before = findPicture(report, "distorted", camera.name), after = findPicture(report, "undistorted", camera.name);
  if (!before || !after) return null;
  const parts = [[before, "As it was taken", `Frame ${before.frame}.`],
    [after, "Undistorted", "Each line runs straight from the first to the last corner of a row of the board: the corners between have to lie on it."]];
  return el("div", { class: "figures" }, parts.map(([picture, title, words]) =>
    el("figure", {}, el("h3", {}, title), lined(picture, `${title}: frame ${picture.frame} of ${camera.name}`), el("figcaption", {}, words))));
}

/** Rectified pairs, one above the other. */
export function rectifiedFigures(report) {
  return (report.pictures ?? []).filter((picture) => picture.kind === "rectified").map((picture) =>
    el("figure", { class: "wide" }, el("h3", {}, `Rectified: ${picture.camera}`), lined(picture, `Frame ${picture.frame} of ${picture.camera}, rectified`),
      el("figcaption", {}, `Frame ${picture.frame}. The same point of the board lies on the same line in both.`)));
}
