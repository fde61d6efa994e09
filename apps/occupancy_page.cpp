// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_page.hpp"

#include <nlohmann/json.hpp>
#include <string_view>

#include "occupancy_answer.hpp"
#include "page_text.hpp"

namespace raybundle::apps {
namespace {

constexpr std::string_view kBegin = R"(<!doctype html><html lang="en"><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>Seat occupancy</title>
<style>
:root { color-scheme: light dark; --line: #8884; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 1.5rem; max-width: 90rem; }
main { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(28rem, 100%), 1fr)); gap: 1rem; }
figure { margin: 0; } figcaption { opacity: .75; margin-top: .3rem; }
svg { width: 100%; border: 1px solid var(--line); border-radius: 4px; display: block; }
.controls { display: flex; gap: .8rem; align-items: center; margin: .8rem 0; } .controls input { flex: 1; }
)";

constexpr std::string_view kBody = R"(</style>
<h1>Seat occupancy <span id="airbag" class="badge"></span></h1>
<div class="controls"><button id="play">Play</button><input id="at" type="range" min="0" value="0" aria-label="frame"><output id="name"></output></div>
<main>
<figure><svg id="side"></svg><figcaption>From the left: to the dashboard is right, up is up [m]. Red: critical zone, orange: outer zone.</figcaption></figure>
<figure><svg id="top"></svg><figcaption>From above: to the dashboard is right, the car's left is up [m].</figcaption></figure>
<figure><table id="reasons"></table><figcaption>What the decision rests on.</figcaption></figure>
</main>
<script type="application/json" id="data">)";

constexpr std::string_view kMiddle = "</script><script>\n'use strict';";

constexpr std::string_view kEnd =
    R"(const {vehicle: car, frames} = JSON.parse(document.getElementById('data').textContent);
const element = id => document.getElementById(id);
const make = (parent, tag, attributes, text) => {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text) node.textContent = text;
  return parent.appendChild(node);
};
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
const at = element('at');
at.max = frames.length - 1;
at.oninput = () => show(+at.value);
let timer = 0;
element('play').onclick = () => {
  element('play').textContent = timer ? 'Play' : 'Stop';
  if (timer) { clearInterval(timer); timer = 0; return; }
  timer = setInterval(() => { at.value = (+at.value + 1) % frames.length; show(+at.value); }, 300);
};
show(0);
</script></html>
)";

nlohmann::ordered_json json_of(const VehicleLayout& layout) {
  return {{"dashboard_x_m", layout.dashboard_x_m},
          {"zone_floor_m", layout.zone_floor_m},
          {"zone_half_width_m", layout.zone_half_width_m},
          {"critical_m", layout.critical_m},
          {"out_of_position_m", layout.out_of_position_m}};
}

}  // namespace

std::string occupancy_page(const VehicleLayout& layout, const nlohmann::ordered_json& frames) {
  std::string page;
  for (const std::string_view part : {kBegin, kAnswerStyle, kBody}) page += part;
  page += json_for_script(text_of_json(nlohmann::ordered_json{{"vehicle", json_of(layout)}, {"frames", frames}}));
  for (const std::string_view part : {kMiddle, kAnswerScript, kEnd}) page += part;
  return page;
}

nlohmann::ordered_json page_points(const std::vector<ScenePoint>& points) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const ScenePoint& point : points) {
    const Eigen::Vector3d& x = point.x_in_vehicle;
    json.push_back({{"ray", point.ray}, {"x_in_vehicle_m", {x.x(), x.y(), x.z()}}, {"sigma_m", point.sigma_m}});
  }
  return json;
}

}  // namespace raybundle::apps
