// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// What the figures need, worked out of report.json once.

export function rotated([x, y, z, w], [a, b, c]) {
  const tx = 2 * (y * c - z * b), ty = 2 * (z * a - x * c), tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

/** x_in_b of x_in_a; transform is b_from_a. */
export function transformed(transform, point) {
  const t = transform.translation_m;
  return rotated(transform.rotation_xyzw, point).map((value, i) => value + t[i]);
}

/** a_from_b of b_from_a. */
export function inverse(transform) {
  const [x, y, z, w] = transform.rotation_xyzw;
  const rotation = [-x, -y, -z, w];
  return { rotation_xyzw: rotation, translation_m: rotated(rotation, transform.translation_m).map((value) => -value) };
}

export function quantile(sorted, part) {
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] : 0;
}

/** Rows of a view as objects; the names of the columns stand in the report. */
export function cornersOf(view, report) {
  const columns = report.observation_columns;
  const at = Object.fromEntries(columns.map((name, i) => [name, i]));
  return view.observations.map((row) => {
    const du = row[at.residual_u_px], dv = row[at.residual_v_px];
    return {
      view, id: row[at.point_id], u: row[at.u_px], v: row[at.v_px], du, dv,
      fate: report.fates[row[at.fate]], distance: du === null || dv === null ? NaN : Math.hypot(du, dv),
    };
  });
}

/** Adds to each corner its angle from the camera's axis [deg], which board pose and camera give without a lens model. */
export function addAngles(corners, camera, view, report) {
  if (!camera.camera_from_rig || view.pose < 0) return;
  const points = new Map(report.targets[view.target].points.map(([id, x, y, z]) => [id, [x, y, z]]));
  const rig_from_target = report.poses[view.pose].rig_from_target;
  for (const corner of corners) {
    const [x, y, z] = transformed(camera.camera_from_rig, transformed(rig_from_target, points.get(corner.id)));
    corner.angle = (Math.atan2(Math.hypot(x, y), z) * 180) / Math.PI;
  }
}

/** Adds the part of the residual that points away from the principal point [px]. */
export function addRadials(corners, camera) {
  const { cx, cy } = camera.parameters ?? { cx: (camera.width - 1) / 2, cy: (camera.height - 1) / 2 };
  for (const corner of corners) {
    const x = corner.u - cx, y = corner.v - cy, radius = Math.hypot(x, y);
    corner.radius = radius;
    corner.radial = radius > 0 ? (corner.du * x + corner.dv * y) / radius : 0;
  }
}

/** The image in so many square-ish cells across, with the used corners of each. */
export function cellsOf(camera, used, columns) {
  const rows = Math.max(1, Math.round((columns * camera.height) / camera.width));
  const cells = Array.from({ length: columns * rows }, () => ({ n: 0, du: 0, dv: 0 }));
  for (const corner of used) {
    const column = Math.floor(((corner.u + 0.5) / camera.width) * columns);
    const row = Math.floor(((corner.v + 0.5) / camera.height) * rows);
    if (column < 0 || row < 0 || column >= columns || row >= rows) continue;
    const cell = cells[row * columns + column];
    cell.n += 1;
    cell.du += corner.du;
    cell.dv += corner.dv;
  }
  return { columns, rows, cells, covered: cells.filter((cell) => cell.n > 0).length };
}

/** A sigma by the noise of the corners, or by how the frames scatter where that is larger; name as in sigma_ratio_by_frame. */
export function largerSigma(sigma, name, report) {
  return sigma * Math.max(1, report.sigma_ratio_by_frame?.[name] ?? 1);
}

/** One camera with its views, corners and cells, and the larger of its sigmas. */
export function cameraModel(camera, report) {
  const views = report.views.filter((view) => view.camera === camera.name);
  const reasons = report.set_aside.filter((entry) => entry.camera === camera.name && entry.scope !== "image");
  const entries = views.map((view) => {
    const corners = cornersOf(view, report);
    addAngles(corners, camera, view, report);
    addRadials(corners, camera);
    const used = corners.filter((corner) => corner.fate === "used");
    const reason = reasons.find((entry) => entry.frame === view.frame && (entry.target ?? 0) === view.target);
    const entry = { view, corners, used, name: viewName(view, report), reason: reason ? reason.reason : null };
    for (const corner of corners) corner.entry = entry;
    return entry;
  });
  const corners = entries.flatMap((entry) => entry.corners);
  const used = corners.filter((corner) => corner.fate === "used" && Number.isFinite(corner.distance));
  const distances = used.map((corner) => corner.distance).sort((a, b) => a - b);
  const angles = used.map((corner) => corner.angle).filter(Number.isFinite);
  const sigmas = Object.fromEntries(Object.entries(camera.sigmas ?? {}).map(([name, sigma]) => [name, largerSigma(sigma, `${camera.name}.${name}`, report)]));
  return {
    ...camera, sigmas, entries, corners, used, distances, cells: cellsOf(camera, used, 16),
    means: cellsOf(camera, used, Math.max(8, Math.min(24, Math.round(Math.sqrt(used.length / 8))))),
    leftOut: corners.filter((corner) => corner.fate === "outlier" || corner.fate === "unprojectable"),
    widest: angles.reduce((most, angle) => Math.max(most, angle), 0), hasAngles: angles.length > 0,
  };
}

export function viewName(view, report) {
  return report.targets.length > 1 ? view.frame + ", " + report.targets[view.target].name : view.frame;
}
