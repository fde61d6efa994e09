// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_page.hpp"

#include "page_text.hpp"

namespace raybundle::apps {
namespace {

constexpr std::string_view kBegin = R"(<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Laser points</title>
<style>
:root { color-scheme: light dark; --line: #8886; --far: #36c; --near: #e80; }
body { font: 15px/1.4 system-ui, sans-serif; margin: 1.5rem; max-width: 90rem; }
main { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(28rem, 100%), 1fr)); gap: 1rem; }
figure { margin: 0; } figcaption { opacity: .75; margin-top: .3rem; }
svg, canvas { width: 100%; max-height: 42rem; border: 1px solid var(--line); border-radius: 4px; display: block; }
canvas { aspect-ratio: 4 / 3; touch-action: none; cursor: grab; }
.state { padding: .1rem .6rem; border-radius: 4px; color: #fff; background: #2a7; }
.DEGRADED { background: #b70; } .INVALID { background: #c33; }
</style>
<h1>Laser points <span id="state" class="state"></span></h1><p id="words"></p>
<main>
<figure><svg id="image"></svg><figcaption>Dots: coloured by depth with row, column; crossed out where no beam is sure.</figcaption></figure>
<figure><canvas id="space" tabindex="0"></canvas><figcaption>Points and mesh; drag or use the arrow keys to turn.</figcaption></figure>
<figure><svg id="side"></svg><figcaption>From the side: depth to the right, y down [m]; bars are one sigma of depth.</figcaption></figure>
<figure><svg id="top"></svg><figcaption>From above: depth to the right, x down [m].</figcaption></figure>
</main>
<script type="application/json" id="data">)";

constexpr std::string_view kMiddle = R"(</script><script>
'use strict';
const frame = JSON.parse(document.getElementById('data').textContent), picture = 'data:image/jpeg;base64,)";

constexpr std::string_view kEnd = R"(';
const make = (parent, tag, attributes, text) => {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text) node.textContent = text;
  return parent.appendChild(node);
};
const points = frame.points.map(p => p.x_in_camera_m), depths = points.map(p => p[2]);
const low = Math.min(...depths), high = Math.max(...depths, low + 1e-9);
const colour = z => `hsl(${30 + 200 * (z - low) / (high - low)} 90% 50%)`;
const state = document.getElementById('state');
state.textContent = frame.state; state.classList.add(frame.state);
const watched = frame.health.log_wavelength_sigma > 0 ? `wavelength ${(100 * frame.health.log_wavelength).toFixed(3)} ± ` +
  `${(100 * frame.health.log_wavelength_sigma).toFixed(3)} % off its calibration` :
  `${frame.health.dots} labelled dots so far, too few to watch the calibration by`;
document.getElementById('words').textContent = `${frame.image}: ${frame.dots.length} dots, ${points.length} labelled, ` +
  `${frame.triangles.length} triangles; ${watched}`;

const loaded = new Image();
loaded.onload = () => {
  const svg = document.getElementById('image'), w = loaded.width, h = loaded.height;
  svg.setAttribute('viewBox', `-0.5 -0.5 ${w} ${h}`);
  make(svg, 'image', {x: -0.5, y: -0.5, width: w, height: h, href: picture});
  const depthOf = new Map(frame.points.map(p => [p.dot, p.x_in_camera_m[2]]));
  frame.dots.forEach((dot, i) => {
    const [u, v] = dot.pixel;
    if (!depthOf.has(i)) {
      make(svg, 'path', {d: `M${u - 4} ${v - 4}l8 8m0-8l-8 8`, stroke: '#f33', 'stroke-width': 1});
      return;
    }
    const circle = make(svg, 'circle', {cx: u, cy: v, r: 5, fill: 'none', stroke: colour(depthOf.get(i)), 'stroke-width': 1.5});
    make(circle, 'title', {}, `row ${dot.row}, column ${dot.column}, ${depthOf.get(i).toFixed(3)} m`);
    make(svg, 'text', {x: u + 6, y: v + 2, 'font-size': 6, fill: colour(depthOf.get(i))}, `${dot.row},${dot.column}`);
  });
};
loaded.src = picture;

const plot = (id, axis) => {
  const svg = document.getElementById(id), all = points.map(p => p[axis]);
  if (!all.length) return;
  const least = Math.min(...all) - 0.1, most = Math.max(...all) + 0.1, width = high + 0.15;
  svg.setAttribute('viewBox', `0 ${least} ${width} ${most - least}`);
  for (let z = 0; z <= width; z += 0.25) {
    make(svg, 'path', {d: `M${z} ${least}V${most}`, stroke: 'currentColor', 'stroke-opacity': .15, 'stroke-width': .002 * width});
    make(svg, 'text', {x: z + 0.01 * width, y: most - 0.015 * width, 'font-size': .03 * width, fill: 'currentColor'}, z.toFixed(2));
  }
  for (let y = Math.ceil(least / 0.25) * 0.25; y <= most - 0.05; y += 0.25) {
    make(svg, 'path', {d: `M0 ${y}H${width}`, stroke: 'currentColor', 'stroke-opacity': .15, 'stroke-width': .002 * width});
    make(svg, 'text', {x: 0.01 * width, y: y - 0.01 * width, 'font-size': .03 * width, fill: 'currentColor'}, y.toFixed(2));
  }
  frame.points.forEach(p => {
    const [z, y, s] = [p.x_in_camera_m[2], p.x_in_camera_m[axis], Math.sqrt(p.covariance_m2[8])];
    make(svg, 'path', {d: `M${z - s} ${y}H${z + s}`, stroke: colour(z), 'stroke-width': .003 * width});
    make(svg, 'circle', {cx: z, cy: y, r: .006 * width, fill: colour(z)});
  });
};
plot('side', 1); plot('top', 0);

const canvas = document.getElementById('space'), context = canvas.getContext('2d');
let yaw = 0.5, pitch = -0.35;
const middle = [0, 1, 2].map(k => points.reduce((sum, p) => sum + p[k], 0) / Math.max(1, points.length));
const reach = Math.max(0.1, ...points.map(p => Math.hypot(...p.map((x, k) => x - middle[k]))));
const draw = () => {
  const w = canvas.width = canvas.clientWidth * devicePixelRatio, h = canvas.height = canvas.clientHeight * devicePixelRatio;
  const scale = 0.45 * Math.min(w, h) / reach, [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const seen = points.map(p => {
    const [x, y, z] = p.map((value, k) => value - middle[k]), a = cy * x + sy * z, b = cy * z - sy * x;
    return [w / 2 + scale * a, h / 2 + scale * (cp * y + sp * b), cp * b - sp * y];
  });
  context.clearRect(0, 0, w, h);
  const depth = t => t.reduce((sum, i) => sum + seen[i][2], 0);
  for (const t of [...frame.triangles].sort((a, b) => depth(b) - depth(a))) {
    context.beginPath();
    t.forEach((i, k) => k ? context.lineTo(seen[i][0], seen[i][1]) : context.moveTo(seen[i][0], seen[i][1]));
    context.closePath();
    context.fillStyle = colour(t.reduce((sum, i) => sum + points[i][2], 0) / 3);
    context.strokeStyle = '#0006';
    context.fill(); context.stroke();
  }
  seen.forEach((s, i) => { context.fillStyle = colour(points[i][2]); context.fillRect(s[0] - 2, s[1] - 2, 4, 4); });
};
canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
canvas.onpointermove = event => { if (event.buttons) { yaw += event.movementX / 150; pitch += event.movementY / 150; draw(); } };
canvas.onkeydown = event => {
  const turn = {ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1]}[event.key];
  if (turn) { yaw += turn[0]; pitch += turn[1]; event.preventDefault(); draw(); }
};
addEventListener('resize', draw); draw();
</script></html>
)";

}  // namespace

std::string laser_page(std::string_view json, std::string_view jpeg) {
  return std::string(kBegin) + json_for_script(json) + std::string(kMiddle) + base64(jpeg) + std::string(kEnd);
}

}  // namespace raybundle::apps
