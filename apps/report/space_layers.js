// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// What stands in space, in the rig frame: lines and faces of cameras, boards and beams, each layer to be shown or hidden.

import { counted, fixed } from "./dom.js";
import { inverse, quantile, transformed } from "./model.js";

const loopOf = (corners) => corners.flatMap((corner, i) => [corner, corners[(i + 1) % corners.length]]);
const twoTriangles = ([a, b, c, d]) => [a, b, c, a, c, d];
const between = (a, b) => a.map((value, i) => (value + b[i]) / 2);

/** The four corners of a board's outline in the rig frame. */
export function outlineOf(rig_from_target, target) {
  const range = (i) => target.points.reduce(([low, high], p) => [Math.min(low, p[i]), Math.max(high, p[i])], [Infinity, -Infinity]);
  const [[x0, x1], [y0, y1]] = [range(1), range(2)];
  return [[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0]].map((corner) => transformed(rig_from_target, corner));
}

/** Middle and radius of a sphere that holds the cameras and nearly all of the boards. */
export function boundsOf(report) {
  const centres = report.poses.map((pose) => {
    const outline = outlineOf(pose.rig_from_target, report.targets[pose.target]);
    return between(outline[0], outline[2]);
  });
  const places = report.cameras.filter((camera) => camera.camera_from_rig).map((camera) => inverse(camera.camera_from_rig).translation_m);
  const middle = [0, 1, 2].map((i) => {
    const sorted = centres.map((p) => p[i]).sort((a, b) => a - b);
    const all = [quantile(sorted, 0.05), quantile(sorted, 0.95), ...places.map((p) => p[i])];
    return (Math.min(...all) + Math.max(...all)) / 2;
  });
  const far = (points) => points.map((p) => Math.hypot(...p.map((value, i) => value - middle[i]))).sort((a, b) => a - b);
  return { middle, radius: 1.15 * Math.max(quantile(far(centres), 0.9), ...far(places)) || 1 };
}

/** A camera as a pyramid of this depth: its centre, then the corners of its base, which has the shape of the image. */
function pyramidOf(camera, depth) {
  const rig_from_camera = inverse(camera.camera_from_rig), x = 0.6 * depth, y = (x * camera.height) / camera.width;
  return [[0, 0, 0], [-x, -y, depth], [x, -y, depth], [x, y, depth], [-x, y, depth]].map((corner) => transformed(rig_from_camera, corner));
}

function cameraLayers(report, radius) {
  return report.cameras.filter((camera) => camera.camera_from_rig).map((camera, i) => {
    const [centre, ...base] = pyramidOf(camera, 0.13 * radius);
    const edges = base.flatMap((corner) => [centre, corner]);
    return { title: null, color: "camera" + (i % 6), lines: [...edges, ...loopOf(base)], opacity: 1, faces: twoTriangles(base), faceOpacity: 0.25,
      labels: [{ at: between(base[0], base[1]), text: camera.name, color: "camera" + (i % 6) }], marks: [] };
  });
}

function boardLayer(report, chooseFrame) {
  const boards = report.poses.map((pose) => ({ pose, outline: outlineOf(pose.rig_from_target, report.targets[pose.target]) }));
  const crowd = boards.length > 100;
  return { title: counted(boards.length, "board pose"), color: "muted", lines: boards.flatMap(({ outline }) => loopOf(outline)), opacity: crowd ? 0.35 : 0.75,
    faces: boards.flatMap(({ outline }) => twoTriangles(outline)), faceOpacity: crowd ? 0.03 : 0.08, labels: [],
    marks: boards.map(({ pose, outline }) => ({ at: between(outline[0], outline[2]), text: `board at frame ${pose.frame}`, choose: () => chooseFrame(pose) })) };
}

function beamText(beam) {
  const depths = beam.depths.filter((depth) => depth.sigma_m !== null)
    .map((depth) => `± ${fixed(1e3 * depth.sigma_m, depth.sigma_m < 0.01 ? 2 : 0)} mm at ${depth.depth_m} m`);
  return [`beam of row ${beam.row}, column ${beam.column}: ${counted(beam.hits, "dot")}`, ...depths].join("\n");
}

/** Strong where dots were seen, faint from the projector to there. */
function beamLayers(report) {
  if (!report.laser?.beams?.length) return [];
  const beams = report.laser.beams.map((beam) => {
    const along = beam.point_m.reduce((sum, value, i) => sum + value * beam.direction[i], 0);
    return { beam, at: (range) => beam.point_m.map((value, i) => value + (range - along) * beam.direction[i]) };
  });
  const seen = { title: counted(beams.length, "laser beam"), color: "beam", opacity: 0.8, faces: [], labels: [],
    lines: beams.flatMap(({ beam, at }) => [at(beam.nearest_hit_m), at(beam.farthest_hit_m)]),
    marks: beams.map(({ beam, at }) => ({ at: at(beam.farthest_hit_m), text: beamText(beam) })) };
  const before = { ...seen, opacity: 0.2, lines: beams.flatMap(({ beam, at }) => [at(0), at(beam.nearest_hit_m)]), marks: [] };
  return [seen, before];
}

function nextViewLayer(report) {
  const views = report.next_views?.views ?? [];
  if (!views.length) return [];
  const outlines = views.map((view) => outlineOf(view.rig_from_target, report.targets[view.target]));
  return [{ title: "next best views", color: "second", opacity: 1, lines: outlines.flatMap(loopOf), faces: outlines.flatMap(twoTriangles), faceOpacity: 0.15,
    labels: outlines.map((outline, i) => ({ at: outline[0], text: String(i + 1), color: "second" })),
    marks: outlines.map((outline, i) => ({ at: between(outline[0], outline[2]), text: `next view ${i + 1}: ${views[i].text}` })) }];
}

/** A grid on the floor below everything; step is the side of its squares. */
export function floorLayer({ middle, radius }, step) {
  const half = Math.ceil(radius / step) * step, y = middle[1] + radius * 0.75, lines = [];
  const [x0, z0] = [Math.round(middle[0] / step) * step, Math.round(middle[2] / step) * step];
  for (let k = -half; k <= half + 1e-9; k += step) {
    lines.push([x0 + k, y, z0 - half], [x0 + k, y, z0 + half], [x0 - half, y, z0 + k], [x0 + half, y, z0 + k]);
  }
  return { title: null, color: "line", lines, opacity: 0.9, faces: [], labels: [], marks: [] };
}

/** Layers of the same title are shown and hidden together; those without one always stand. */
export function layersOf(report, bounds, chooseFrame) {
  return [...cameraLayers(report, bounds.radius), boardLayer(report, chooseFrame), ...beamLayers(report), ...nextViewLayer(report)];
}
