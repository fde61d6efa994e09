// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// One image of `reconstruct structured-light`: its JSON is in `data`, its JPEG in `picture`.

const frame = JSON.parse(document.getElementById('data').textContent);
const picture = 'data:image/jpeg;base64,' + document.getElementById('picture').textContent;
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
const view = {yaw: 0.5, pitch: -0.35};
const middle = [0, 1, 2].map(k => points.reduce((sum, p) => sum + p[k], 0) / Math.max(1, points.length));
const reach = Math.max(0.1, ...points.map(p => Math.hypot(...p.map((x, k) => x - middle[k]))));
const draw = () => {
  const [w, h] = fitCanvas(canvas), scale = 0.45 * Math.min(w, h) / reach, turned = turnerOf(view);
  const seen = points.map(p => {
    const [x, y, z] = turned(...p.map((value, k) => value - middle[k]));
    return [w / 2 + scale * x, h / 2 + scale * y, z];
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
turnByHand(canvas, view, draw);
draw();
