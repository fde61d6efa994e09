// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The rig and the board poses in space, to be turned with pointer or keys.

/** The four corners of a board's outline in the rig frame. */
function outlineOf(pose, report) {
  const points = report.targets[pose.target].points;
  const range = (i) => [Math.min(...points.map((p) => p[i])), Math.max(...points.map((p) => p[i]))];
  const [[x0, x1], [y0, y1]] = [range(1), range(2)];
  return [[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0]].map((corner) => transformed(pose.rig_from_target, corner));
}

/** A camera as a pyramid of this depth in the rig frame: its centre, then the corners of its base. */
function pyramidOf(camera, depth) {
  const rig_from_camera = inverse(camera.camera_from_rig), half = (0.6 * depth * camera.height) / camera.width;
  const base = [[-0.6 * depth, -half, depth], [0.6 * depth, -half, depth], [0.6 * depth, half, depth], [-0.6 * depth, half, depth]];
  return [[0, 0, 0], ...base].map((corner) => transformed(rig_from_camera, corner));
}

/** Everything to draw, as closed or open lines of points in the rig frame, and the sphere that holds most of it. */
function sceneOf(report) {
  const cameras = report.cameras.filter((camera) => camera.camera_from_rig);
  const boards = report.poses.map((pose) => ({ pose, outline: outlineOf(pose, report) }));
  const centres = boards.map(({ outline }) => outline[0].map((value, i) => (value + outline[2][i]) / 2));
  const places = cameras.map((camera) => inverse(camera.camera_from_rig).translation_m);
  const middle = [0, 1, 2].map((i) => {
    const sorted = centres.map((p) => p[i]).sort((a, b) => a - b), held = [quantile(sorted, 0.05), quantile(sorted, 0.95)];
    const all = [...held, ...places.map((p) => p[i])];
    return (Math.min(...all) + Math.max(...all)) / 2;
  });
  const far = (points) => points.map((p) => Math.hypot(...p.map((value, i) => value - middle[i]))).sort((a, b) => a - b);
  const radius = 1.15 * Math.max(quantile(far(centres), 0.9), ...far(places)) || 1;
  return { boards, middle, radius, cameras: cameras.map((camera) => ({ name: camera.name, lines: pyramidOf(camera, 0.12 * radius) })) };
}

const firstLook = { yaw: 0.6, pitch: 0.45, zoom: 1 };

/** Orthographic map from the rig frame to the canvas; yaw about the y axis, then pitch. */
function projector(scene, look, width, height) {
  const [cy, sy, cp, sp] = [Math.cos(look.yaw), Math.sin(look.yaw), Math.cos(look.pitch), Math.sin(look.pitch)];
  const scale = (look.zoom * Math.min(width, height)) / (2 * scene.radius);
  return (point) => {
    const [x, y, z] = point.map((value, i) => value - scene.middle[i]);
    const across = cy * x + sy * z, away = -sy * x + cy * z;
    return [width / 2 + scale * across, height / 2 + scale * (cp * y - sp * away)];
  };
}

function drawRig(context, width, height, scene, look) {
  const place = projector(scene, look, width, height);
  context.lineWidth = 1;
  context.strokeStyle = context.fillStyle = color("muted");
  const marks = scene.boards.map(({ pose, outline }) => {
    const corners = outline.map(place);
    context.globalAlpha = scene.boards.length > 100 ? 0.35 : 0.7;
    context.beginPath();
    corners.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
    context.stroke();
    context.globalAlpha *= 0.12;
    context.fill();
    const [x, y] = [0, 1].map((i) => (corners[0][i] + corners[2][i]) / 2);
    return { x, y, text: `board at frame ${pose.frame}` };
  });
  context.globalAlpha = 1;
  scene.cameras.forEach(({ name, lines }, i) => {
    const [centre, ...base] = lines.map(place);
    context.strokeStyle = context.fillStyle = color("camera" + (i % 6));
    context.lineWidth = 2;
    base.forEach((corner, k) => {
      line(context, ...centre, ...corner);
      line(context, ...corner, ...base[(k + 1) % 4]);
    });
    context.textAlign = "center";
    context.textBaseline = "bottom";
    context.fillText(name, centre[0], Math.min(centre[1], ...base.map((corner) => corner[1])) - 3);
  });
  const bar = niceBelow(scene.radius / 2);
  const length = (bar * look.zoom * Math.min(width, height)) / (2 * scene.radius);
  scaleBar(context, width, height, length, bar >= 1 ? `${tickText(bar)} m` : `${tickText(1000 * bar)} mm`);
  return marks;
}

function rigFigure(report) {
  const scene = sceneOf(report), look = { ...firstLook };
  const label = `${counted(scene.cameras.length, "camera")} and ${counted(scene.boards.length, "board pose")} in space; turn with the arrow keys, zoom with plus and minus`;
  const item = plot({ aspect: 1.9, label, draw: (context, width, height) => drawRig(context, width, height, scene, look), attributes: { tabindex: "0" } });
  const turn = (yaw, pitch, zoom = 1) => {
    look.yaw += yaw;
    look.pitch = Math.max(-1.57, Math.min(1.57, look.pitch + pitch));
    look.zoom = Math.max(0.2, Math.min(20, look.zoom * zoom));
    item.redraw();
  };
  const keys = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1], "+": [0, 0, 1.2], "-": [0, 0, 1 / 1.2] };
  item.canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key]) return;
    event.preventDefault();
    turn(...keys[event.key]);
  });
  item.canvas.addEventListener("pointerdown", (event) => item.canvas.setPointerCapture(event.pointerId));
  item.canvas.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) turn(0.008 * event.movementX, -0.008 * event.movementY);
  });
  const button = (text, name, ...change) => el("button", { "aria-label": name, onclick: () => turn(...change) }, text);
  const reset = el("button", { onclick: () => { Object.assign(look, firstLook); item.redraw(); } }, "first view");
  const node = figure("Cameras and boards in space", item,
    "Seen from above and behind; drag to turn, or use the arrow keys. Grey: where the boards were held.");
  node.classList.add("rig");
  node.append(el("p", {}, button("+", "nearer", 0, 0, 1.25), " ", button("−", "farther", 0, 0, 0.8), " ", reset));
  return node;
}
