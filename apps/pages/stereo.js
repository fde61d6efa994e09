// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The pairs of `reconstruct stereo`, or of `occupancy classify` for stereo.

const frames = JSON.parse(document.getElementById('data').textContent), part = id => document.getElementById(id);
const canvas = part('space'), context = canvas.getContext('2d');
// Points and lines as they are looked at: of a car from its side.
for (const frame of frames) {
  frame.reach = frame.middle_m[2];
  frame.depths = frame.points.filter((_, i) => i % 4 === 2);
  const turn = (list, stride) => {
    for (let i = 0; i < list.length; i += stride) {
      const [x, y, z] = list.slice(i, i + 3);
      for (let k = 0; k < 3; ++k) list[i + k] = frame.turn[3 * k] * x + frame.turn[3 * k + 1] * y + frame.turn[3 * k + 2] * z;
    }
  };
  if (!frame.turn) continue;
  turn(frame.points, 4); turn(frame.middle_m, 3);
  for (const {lines} of frame.drawn) turn(lines, 3);
}
const view = {yaw: 0.4, pitch: -0.25, zoom: 1};
let frame;  // that is shown
const draw = () => {
  const [w, h] = fitCanvas(canvas), turned = turnerOf(view);
  const scale = 1.2 * view.zoom * Math.min(w, h), [mx, my, mz] = frame.middle_m, eye = 3 * frame.reach;
  // Pixel and depth of a point, or null where it is behind the eye.
  const place = (x, y, z) => {
    const [right, down, away] = turned(x - mx, y - my, z - mz), depth = away + eye;
    return depth > 0.05 * eye ? [w / 2 + scale * right / depth, h / 2 + scale * down / depth, depth] : null;
  };
  const p = frame.points, seen = [];
  for (let i = 0; 4 * i < p.length; ++i) {
    const at = place(p[4 * i], p[4 * i + 1], p[4 * i + 2]);
    if (at) seen.push([...at, frame.depths[i] / frame.reach, p[4 * i + 3]]);
  }
  seen.sort((a, b) => b[2] - a[2]);
  context.clearRect(0, 0, w, h);
  const size = Math.max(2, w / 300);
  for (const [u, v, , far, grey] of seen) {
    context.fillStyle = `hsl(${240 * far / (1 + far)} 90% ${30 + grey / 6}%)`;
    context.fillRect(u, v, size, size);
  }
  context.lineWidth = Math.max(1, w / 500);
  for (const {colour, lines} of frame.drawn || []) {
    context.strokeStyle = colour;
    context.beginPath();
    for (let i = 0; i < lines.length; i += 6) {
      const from = place(...lines.slice(i, i + 3)), to = place(...lines.slice(i + 3, i + 6));
      if (from && to) { context.moveTo(from[0], from[1]); context.lineTo(to[0], to[1]); }
    }
    context.stroke();
  }
};
const show = index => {
  frame = frames[index];
  const state = part('state');
  part('left').src = 'data:image/jpeg;base64,' + frame.left;
  part('right').src = 'data:image/jpeg;base64,' + frame.right;
  part('disparity').src = 'data:image/png;base64,' + frame.disparity;
  state.textContent = (frame.answer || frame).state; state.className = 'state ' + state.textContent;
  part('words').textContent = `${frame.name}: ${frame.matched} matches (${index + 1} of ${frames.length})` +
    (frame.cabin ? ', ' + frame.cabin : '');
  part('decision').hidden = !frame.answer;
  if (frame.answer) showAnswer(frame.answer);
  draw();
};
const step = player(frames.length, 200, show);
if (frames.length) turnByHand(canvas, view, draw);
canvas.onwheel = event => { view.zoom *= Math.exp(-event.deltaY / 500); event.preventDefault(); draw(); };
