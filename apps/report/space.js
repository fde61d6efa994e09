// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The rig in space, drawn with three.js, to be turned with pointer or keys.

import { BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, PerspectiveCamera,
  Scene, Vector3, WebGLRenderer } from "three";

import { el } from "./dom.js";
import { color, figure, niceBelow, pixelScale, register, tickText } from "./plot.js";
import { boundsOf, floorLayer, layersOf } from "./space_layers.js";

const firstLook = { yaw: 0.55, pitch: 0.42, zoom: 1 };
const aspect = 1.9, viewAngle = 35;  // of the onlooker [deg]

function geometryOf(points) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points.flat()), 3));
  return geometry;
}

/** Lines and faces of a layer; their materials are in `materials` with the names of their colours. */
function groupOf(layer, materials) {
  const group = new Group();
  const add = (Kind, material, points) => {
    materials.push([material, layer.color]);
    group.add(new Kind(geometryOf(points), material));
  };
  const look = (opacity) => ({ transparent: true, opacity, depthWrite: false });
  if (layer.faces.length) add(Mesh, new MeshBasicMaterial({ ...look(layer.faceOpacity), side: DoubleSide }), layer.faces);
  add(LineSegments, new LineBasicMaterial(look(layer.opacity)), layer.lines);
  return group;
}

/** An onlooker on a sphere about the middle; y points down, as in the rig frame. */
function placeOnlooker(onlooker, bounds, look) {
  const distance = (1.05 * bounds.radius) / Math.tan((viewAngle * Math.PI) / 360) / look.zoom;
  const [x, y, z] = bounds.middle, flat = distance * Math.cos(look.pitch);
  onlooker.position.set(x - flat * Math.sin(look.yaw), y - distance * Math.sin(look.pitch), z - flat * Math.cos(look.yaw));
  onlooker.near = distance / 100;
  onlooker.far = 20 * (distance + bounds.radius);
  onlooker.up.set(0, -1, 0);
  onlooker.lookAt(x, y, z);
  onlooker.updateProjectionMatrix();
  onlooker.updateMatrixWorld();
}

/** {x, y} on the canvas of a point in the rig frame; null behind the onlooker. */
function placeOf(point, onlooker, width, height) {
  const p = new Vector3(...point).project(onlooker);
  return p.z < 1 ? { x: ((p.x + 1) / 2) * width, y: ((1 - p.y) / 2) * height } : null;
}

function spaceItem(layers, bounds, label) {
  const canvas = el("canvas", { role: "img", "aria-label": label, tabindex: "0", style: "aspect-ratio:" + aspect });
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
  const scene = new Scene(), onlooker = new PerspectiveCamera(viewAngle, aspect), materials = [];
  const groups = layers.map((layer) => groupOf(layer, materials));
  scene.add(...groups);
  const tags = layers.map((layer) => layer.labels.map((tag) => ({ ...tag, node: el("span", { style: `color:var(--${tag.color})` }, tag.text) })));
  const overlay = el("div", { class: "tags", "aria-hidden": "true" }, tags.flat().map((tag) => tag.node));
  const item = { canvas, overlay, groups, look: { ...firstLook }, marks: [] };
  item.redraw = () => {
    const width = canvas.clientWidth, height = width / aspect;
    if (!width) return;
    renderer.setPixelRatio(pixelScale());
    renderer.setSize(width, height, false);
    for (const [material, name] of materials) material.color.set(color(name));
    placeOnlooker(onlooker, bounds, item.look);
    renderer.render(scene, onlooker);
    const shown = (i) => groups[i].visible;
    tags.forEach((list, i) => list.forEach(({ at, node }) => {
      const place = shown(i) ? placeOf(at, onlooker, width, height) : null;
      node.hidden = !place;
      if (place) node.style.transform = `translate(-50%, -100%) translate(${place.x.toFixed(1)}px, ${(place.y - 3).toFixed(1)}px)`;
    }));
    item.marks = layers.flatMap((layer, i) => (shown(i) ? layer.marks : []).map((mark) => ({ ...mark, ...placeOf(mark.at, onlooker, width, height) })))
      .filter((mark) => mark.x !== undefined);
  };
  register(item);
  return item;
}

/** Keys, drag, and pinch or the wheel with Ctrl, so that a plain wheel still scrolls the page. */
function listen(item, turn) {
  const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1], "+": [0, 0, 1.2], "-": [0, 0, 1 / 1.2] };
  item.canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key]) return;
    event.preventDefault();
    turn(...keys[event.key]);
  });
  item.canvas.addEventListener("pointerdown", (event) => item.canvas.setPointerCapture(event.pointerId));
  item.canvas.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) turn(0.008 * event.movementX, 0.008 * event.movementY);
  });
  item.canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    turn(0, 0, Math.exp(-0.003 * event.deltaY));
  }, { passive: false });
}

function toggles(item, layers) {
  const titles = [...new Set(layers.map((layer) => layer.title).filter(Boolean))];
  return titles.map((title) => {
    const flip = (event) => {
      layers.forEach((layer, i) => { if (layer.title === title) item.groups[i].visible = event.target.checked; });
      item.redraw();
    };
    return el("label", {}, el("input", { type: "checkbox", checked: "", onchange: flip }), " " + title);
  });
}

/** chooseFrame(pose) is called for a board that is clicked. */
export function rigFigure(report, chooseFrame) {
  const bounds = boundsOf(report), step = niceBelow(bounds.radius / 2);
  const layers = [floorLayer(bounds, step), ...layersOf(report, bounds, chooseFrame)];
  const titles = [...new Set(layers.map((layer) => layer.title).filter(Boolean))].join(", ");
  const names = report.cameras.filter((camera) => camera.camera_from_rig).map((camera) => camera.name).join(", ");
  let item;
  try {
    item = spaceItem(layers, bounds, `In space: cameras ${names}; ${titles}. Turn with the arrow keys, zoom with plus and minus`);
  } catch (error) {
    return el("p", { class: "muted" }, `This browser offers no WebGL, so the rig cannot be drawn in space (${error.message}).`);
  }
  const turn = (yaw, pitch, zoom = 1) => {
    item.look.yaw += yaw;
    item.look.pitch = Math.max(-1.5, Math.min(1.5, item.look.pitch + pitch));
    item.look.zoom = Math.max(0.2, Math.min(20, item.look.zoom * zoom));
    item.redraw();
  };
  listen(item, turn);
  const button = (text, name, ...change) => el("button", { "aria-label": name, onclick: () => turn(...change) }, text);
  const reset = el("button", { onclick: () => { Object.assign(item.look, firstLook); item.redraw(); } }, "first view");
  const size = step >= 1 ? `${tickText(step)} m` : `${tickText(1000 * step)} mm`;
  const node = figure("In space", item, `Drag to turn, or use the arrow keys; choose a board to see its view. The squares of the floor are ${size} wide.` +
    (report.laser?.beams?.length ? " A beam is strong where its dots were seen, faint between the projector and there." : ""));
  node.classList.add("rig");
  node.querySelector(".drawing").append(item.overlay);
  node.append(el("div", { class: "controls" }, button("+", "nearer", 0, 0, 1.25), button("−", "farther", 0, 0, 0.8), reset, toggles(item, layers)));
  return node;
}
