// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "image_codec.hpp"
#include "occupancy_answer.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "state_name.hpp"

namespace raybundle::apps {
namespace {

constexpr int kPageWidth = 640;     // of pictures [px]
constexpr int kPagePoints = 12000;  // of a frame, about

constexpr std::string_view kBegin = R"(<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Stereo</title>
<style>
:root { color-scheme: light dark; }
body { font: 15px/1.4 system-ui, sans-serif; margin: 1.5rem; max-width: 100rem; }
main { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 1rem; }
figure { margin: 0; } figcaption { opacity: .75; margin-top: .3rem; }
img, canvas { width: 100%; border: 1px solid #8886; border-radius: 4px; display: block; background: #111; }
canvas { aspect-ratio: 4 / 3; touch-action: none; cursor: grab; }
nav { display: flex; gap: .7rem; align-items: center; margin: .7rem 0; } input { flex: 1; max-width: 40rem; }
)";

constexpr std::string_view kBody =
    R"(.state { padding: .1rem .6rem; border-radius: 4px; color: #fff; background: #2a7; }
.DEGRADED { background: #b70; } .INVALID { background: #c33; }
</style>
<h1>Stereo <span id="state" class="state"></span> <span id="airbag" class="badge"></span></h1>
<nav><button id="play">Play</button><input id="which" type="range" min="0" step="1" aria-label="frame"><span id="words"></span></nav>
<main>
<figure><img id="left" alt="left rectified image"><figcaption>Left image, rectified.</figcaption></figure>
<figure><img id="right" alt="right rectified image"><figcaption>Right image, rectified: the same rows.</figcaption></figure>
<figure><img id="disparity" alt="disparities"><figcaption>Disparities: near is red, far is blue, black has no match.</figcaption></figure>
<figure><canvas id="space" tabindex="0"></canvas><figcaption>Points, coloured by depth; drag or use the arrow keys to turn, the wheel to come near. In a car, to the front is right: safety zones red and orange, head white, boxes of the seat blue, grey until it was seen empty.</figcaption></figure>
<figure id="decision" hidden><table id="reasons"></table><figcaption>What the decision rests on.</figcaption></figure>
</main>
<script type="application/json" id="data">)";

constexpr std::string_view kMiddle = "</script><script>\n'use strict';";

constexpr std::string_view kEnd =
    R"(const frames = JSON.parse(document.getElementById('data').textContent), part = id => document.getElementById(id);
const canvas = part('space'), context = canvas.getContext('2d'), which = part('which');
which.max = frames.length - 1; which.value = 0;
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
let yaw = 0.4, pitch = -0.25, zoom = 1, timer = 0;
const draw = () => {
  const frame = frames[which.value], p = frame.points, n = p.length / 4;
  const w = canvas.width = canvas.clientWidth * devicePixelRatio, h = canvas.height = canvas.clientHeight * devicePixelRatio;
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const scale = 1.2 * zoom * Math.min(w, h), middle = frame.middle_m, eye = 3 * frame.reach, seen = [];
  for (let i = 0; i < n; ++i) {
    const x = p[4 * i] - middle[0], y = p[4 * i + 1] - middle[1], z = p[4 * i + 2] - middle[2];
    const a = cy * x + sy * z, b = cy * z - sy * x, depth = cp * b - sp * y + eye;
    if (depth > 0.05 * eye) seen.push([w / 2 + scale * a / depth, h / 2 + scale * (cp * y + sp * b) / depth, depth, frame.depths[i] / frame.reach, p[4 * i + 3]]);
  }
  seen.sort((a, b) => b[2] - a[2]);
  context.clearRect(0, 0, w, h);
  const size = Math.max(2, w / 300);
  for (const [u, v, , far, grey] of seen) {
    context.fillStyle = `hsl(${240 * far / (1 + far)} 90% ${30 + grey / 6}%)`;
    context.fillRect(u, v, size, size);
  }
  const place = (x, y, z) => {
    [x, y, z] = [x - middle[0], y - middle[1], z - middle[2]];
    const a = cy * x + sy * z, b = cy * z - sy * x, depth = cp * b - sp * y + eye;
    return depth > 0.05 * eye ? [w / 2 + scale * a / depth, h / 2 + scale * (cp * y + sp * b) / depth] : null;
  };
  context.lineWidth = Math.max(1, w / 500);
  for (const {colour, lines} of frame.drawn || []) {
    context.strokeStyle = colour;
    context.beginPath();
    for (let i = 0; i < lines.length; i += 6) {
      const from = place(...lines.slice(i, i + 3)), to = place(...lines.slice(i + 3, i + 6));
      if (from && to) { context.moveTo(...from); context.lineTo(...to); }
    }
    context.stroke();
  }
};
const show = () => {
  const frame = frames[which.value], state = part('state');
  part('left').src = 'data:image/jpeg;base64,' + frame.left;
  part('right').src = 'data:image/jpeg;base64,' + frame.right;
  part('disparity').src = 'data:image/png;base64,' + frame.disparity;
  state.textContent = (frame.answer || frame).state; state.className = 'state ' + state.textContent;
  part('words').textContent = `${frame.name}: ${frame.matched} matches (${+which.value + 1} of ${frames.length})` + (frame.cabin ? ', ' + frame.cabin : '');
  part('decision').hidden = !frame.answer;
  if (frame.answer) showAnswer(frame.answer);
  draw();
};
const step = by => { which.value = (+which.value + by + frames.length) % frames.length; show(); };
which.oninput = show;
part('play').onclick = () => {
  if (timer) { clearInterval(timer); timer = 0; } else { timer = setInterval(() => step(1), 200); }
  part('play').textContent = timer ? 'Stop' : 'Play';
};
canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
canvas.onpointermove = event => { if (event.buttons) { yaw += event.movementX / 200; pitch += event.movementY / 200; draw(); } };
canvas.onwheel = event => { zoom *= Math.exp(-event.deltaY / 500); event.preventDefault(); draw(); };
canvas.onkeydown = event => {
  const turn = {ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1]}[event.key];
  if (turn) { yaw += turn[0]; pitch += turn[1]; event.preventDefault(); draw(); }
};
addEventListener('resize', draw);
if (frames.length) show();
</script></html>
)";

// An image as wide as the page shows it.
cv::Mat for_page(cv::Mat image) {
  const double scale = std::min(1.0, static_cast<double>(kPageWidth) / image.cols);
  if (scale < 1.0) cv::resize(image, image, {}, scale, scale, cv::INTER_NEAREST);
  return image;
}

template <typename Value>
cv::Mat image_of(ImageView<const Value> view, int type) {
  return {view.height, view.width, type, const_cast<Value*>(view.pixels),
          static_cast<std::size_t>(view.stride) * sizeof(Value)};
}

// Nearest red, farthest blue.
cv::Mat coloured(ImageView<const float> disparity_px) {
  const cv::Mat values = image_of(disparity_px, CV_32F);
  double most = 0.0;
  cv::minMaxLoc(values, nullptr, &most);
  cv::Mat bytes, colours;
  values.convertTo(bytes, CV_8U, 255.0 / std::max(most, 1.0));
  cv::applyColorMap(bytes, colours, cv::COLORMAP_TURBO);
  colours.setTo(0, values == 0);
  return colours;
}

}  // namespace

nlohmann::json stereo_page_frame(const std::string& name, const StereoFrame& frame) {
  nlohmann::json points = nlohmann::json::array();
  std::array<std::vector<double>, 3> places;
  const int every = std::max(1, frame.disparity.matched / kPagePoints);
  const auto rounded = [](float metres) { return std::round(1e3 * static_cast<double>(metres)) / 1e3; };
  int matched = 0;
  for (int v = 0; v < frame.points.height; ++v) {
    for (int u = 0; u < frame.points.width; ++u) {
      const StereoPoint& point = frame.points.at(u, v);
      if (point.sigma_m == 0 || matched++ % every != 0) continue;
      points.insert(points.end(), {rounded(point.x_m), rounded(point.y_m), rounded(point.z_m), frame.left.at(u, v)});
      places[0].push_back(point.x_m);
      places[1].push_back(point.y_m);
      places[2].push_back(point.z_m);
    }
  }
  const auto middle = [](std::vector<double>& values) { return values.empty() ? 1.0 : median(values); };
  return {{"name", name},
          {"state", state_name(frame.state)},
          {"matched", frame.disparity.matched},
          {"middle_m", {middle(places[0]), middle(places[1]), middle(places[2])}},
          {"left", base64(jpeg_from(for_page(image_of(frame.left, CV_8U))))},
          {"right", base64(jpeg_from(for_page(image_of(frame.right, CV_8U))))},
          {"disparity", base64(png_from(for_page(coloured(frame.disparity_px()))))},
          {"points", std::move(points)}};
}

std::string stereo_page(const nlohmann::json& frames) {
  std::string page;
  for (const std::string_view part : {kBegin, kAnswerStyle, kBody}) page += part;
  page += json_for_script(text_of_json(frames));
  for (const std::string_view part : {kMiddle, kAnswerScript, kEnd}) page += part;
  return page;
}

}  // namespace raybundle::apps
