// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The views of a camera, worst first, and one of them with its image and residuals.

import { count, counted, el, imageAddress, imageLink, px, table } from "./dom.js";
import { cornerText, cross, imageFrame, scaleBar, stretchFor } from "./image_figures.js";
import { findPicture, pictureAddress } from "./pictures.js";
import { color, plot, tickText } from "./plot.js";

export const viewsAtFirst = 12;

/** Set aside first, then by falling rms. */
export function worstFirst(entries) {
  const weight = (entry) => (entry.view.pose < 0 ? Infinity : entry.view.rms_px);
  return [...entries].sort((a, b) => (weight(b) === weight(a) ? 0 : weight(b) > weight(a) ? 1 : -1));
}

/** Shows one view; show(entry) puts another in its place. */
export function viewDetail(camera, report) {
  const state = { entry: null };
  const caption = el("figcaption", { "aria-live": "polite" });
  const image = el("img", { alt: "", onerror: () => (image.hidden = true), onload: () => (image.hidden = false) });
  const item = plot({ aspect: camera.width / camera.height, label: "", draw: (context, width, height) =>
    state.entry ? drawView(context, camera, state.entry, width, height) : [] });
  const show = (entry) => {
    state.entry = entry;
    image.hidden = true;
    const picture = findPicture(report, "view", camera.name, entry.view.frame);
    if (picture) image.src = pictureAddress(picture);
    else if (entry.view.image) image.src = imageAddress(entry.view.image);
    else image.removeAttribute("src");
    caption.replaceChildren(...viewWords(entry));
    item.canvas.setAttribute("aria-label", `Corners and residuals of frame ${entry.name} of ${camera.name}`);
    item.redraw();
  };
  return { show, node: el("figure", {}, el("div", { class: "photo" }, image, item.canvas), caption) };
}

export function viewWords(entry) {
  const left = entry.corners.filter((corner) => corner.fate === "outlier" || corner.fate === "unprojectable");
  const words = entry.view.pose < 0
    ? `set aside: ${entry.reason ?? "it did not fit"}. `
    : `${px(entry.view.rms_px)} px rms over ${counted(entry.used.length, "corner")}. ` +
      (entry.reason ? `Not used for the camera's place on the rig: ${entry.reason}. ` : "");
  const worst = [...entry.used].sort((a, b) => b.distance - a.distance).slice(0, 5);
  const list = worst.map((corner) => `${corner.id} (${px(corner.distance)} px)`).join(", ");
  return [el("strong", {}, `Frame ${entry.name}: `), words,
    left.length ? `Left out: ${left.map((corner) => corner.id).join(", ")}. ` : "",
    list ? `Largest: ${list}. ` : "", imageLink(entry.view.image)];
}

export function drawView(context, camera, entry, width, height) {
  const { stretch, bar } = stretchFor(camera.distances, camera);
  const { scale, toX, toY } = imageFrame(context, camera, width, height);
  const marks = entry.corners.map((corner) => {
    const x = toX(corner.u), y = toY(corner.v), used = corner.fate === "used";
    // A halo first, so that the line is seen on any image.
    for (const [name, wide] of [["sheet", 4], [used ? "accent" : "bad", 1.75]]) {
      context.strokeStyle = color(name);
      context.lineWidth = wide;
      context.beginPath();
      if (used) {
        context.arc(x, y, 2.5, 0, 7);
        context.moveTo(x, y);
        context.lineTo(x + corner.du * stretch * scale, y + corner.dv * stretch * scale);
        context.stroke();
      } else {
        cross(context, x, y, 4);
      }
    }
    return { x, y, text: () => cornerText(corner) };
  });
  if (entry.used.length) scaleBar(context, width, height, bar * stretch * scale, `${tickText(bar)} px, drawn × ${tickText(stretch)}`);
  return marks;
}

/** The table beside the detail. Returns {node, choose}: choose(entry) shows a view wherever it was picked. */
export function viewsPanel(camera, report) {
  const detail = viewDetail(camera, report);
  const order = worstFirst(camera.entries), rowOf = new Map();
  let chosen = null;
  const mark = () => rowOf.forEach((row, entry) => row.classList.toggle("chosen", entry === chosen));
  const choose = (entry) => {
    chosen = entry;
    mark();
    detail.show(entry);
  };
  const list = el("div", { class: "list" });
  const fill = (entries) => {
    const rows = entries.map((entry) => [
      el("button", { class: "link", onclick: () => choose(entry) }, entry.name),
      entry.view.pose < 0 ? "set aside" : px(entry.view.rms_px),
      count(entry.used.length) + " / " + count(entry.corners.length),
      imageLink(entry.view.image, entry.view.image.split("/").pop()),
    ]);
    const node = table([["frame", ""], ["rms px", "number"], ["used / seen", "number"], ["image", "path"]], rows, `Views of ${camera.name}, worst first`);
    rowOf.clear();
    node.querySelectorAll("tbody tr").forEach((row, i) => rowOf.set(entries[i], row));
    mark();
    list.replaceChildren(node);
  };
  fill(order.slice(0, viewsAtFirst));
  const more = order.length <= viewsAtFirst ? null : el("p", {}, el("button", { onclick: () => {
    fill(order);
    more.remove();
  } }, `Show all ${order.length} views`));
  if (order.length) choose(order[0]);
  return { choose, node: el("div", { class: "views" }, el("div", {}, list, more), detail.node) };
}
