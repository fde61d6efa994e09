// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The frames of `occupancy classify`: points in the vehicle, zones, and what was decided.

const {vehicle: car, frames} = JSON.parse(document.getElementById('data').textContent);
const element = id => document.getElementById(id);
const view = {left: -0.8, width: 1.8}, dash = car.dashboard_x_m;
const zone = (svg, from, to, low, high, colour) => make(svg, 'rect',
  {x: dash - to, y: -high, width: to - from, height: high - low, fill: colour, 'fill-opacity': .25});
const plot = (id, low, high, axis, zoneLow, zoneHigh, frame) => {
  const svg = element(id);
  svg.replaceChildren();
  svg.setAttribute('viewBox', `${view.left} ${-high} ${view.width} ${high - low}`);
  for (let x = -0.75; x < 1; x += 0.25) {
    make(svg, 'path', {d: `M${x} ${-high}V${-low}`, stroke: 'currentColor', 'stroke-opacity': .12, 'stroke-width': .003});
    make(svg, 'text', {x: x + .005, y: -low - .01, 'font-size': .035, fill: 'currentColor'}, x.toFixed(2));
  }
  zone(svg, 0, car.critical_m, zoneLow, zoneHigh, '#e22');
  zone(svg, car.critical_m, car.out_of_position_m, zoneLow, zoneHigh, '#f90');
  make(svg, 'path', {d: `M${dash} ${-high}V${-low}`, stroke: 'currentColor', 'stroke-width': .006});
  for (const p of frame.points) {
    const [x, v] = [p.x_in_vehicle_m[0], p.x_in_vehicle_m[axis]], to = dash - x;
    const inside = p.x_in_vehicle_m[2] > car.zone_floor_m && Math.abs(p.x_in_vehicle_m[1]) < car.zone_half_width_m;
    const colour = inside && to < car.critical_m ? '#e22' : inside && to < car.out_of_position_m ? '#f90' : '#38c';
    const dot = make(svg, 'circle', {cx: x, cy: -v, r: frame.points.length > 1000 ? .004 : .01, fill: colour});
    make(dot, 'title', {}, `ray ${p.ray}: ${p.x_in_vehicle_m.map(c => c.toFixed(3)).join(', ')} m, sigma ${(1e3 * p.sigma_m).toFixed(1)} mm`);
  }
};
const show = index => {
  const frame = frames[index];
  element('name').textContent = `${index + 1} of ${frames.length}: ${frame.file}`;
  showAnswer(frame);
  plot('side', -0.35, 1.05, 2, car.zone_floor_m, 0.75, frame);
  plot('top', -0.55, 0.55, 1, -car.zone_half_width_m, car.zone_half_width_m, frame);
};
player(frames.length, 300, show);
