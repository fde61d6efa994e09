# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""What every peer's script shares: reading a problem, timing a solve, measuring its true error.

A peer's script calls run(asked, prepare, solve, cameras). Needs numpy alone, so that it runs in every interpreter.
"""

import json
import os
import pathlib
import resource
import sys
import time
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

THREADS = int(os.environ.get("OMP_NUM_THREADS", "1"))  # that a peer may use


@dataclass
class EstimatedCamera:
    project: object  # (n, 3) rays in the camera -> (n, 2) pixels, NaN where there is none
    camera_from_rig: np.ndarray  # 4 x 4


def read_problem(folder):
    """The problem that generate_problem wrote into a folder."""
    folder = pathlib.Path(folder)
    info = json.loads((folder / "problem.json").read_text())
    count = (len(info["cameras"]), info["frames"], info["rows"] * info["columns"], 2)
    ids = np.arange(count[2])
    board = np.stack([ids % info["columns"], ids // info["columns"], 0 * ids], axis=1) * info["square_m"]
    grid = np.fromfile(folder / "grid.f64").reshape(-1, 5)
    ends = np.cumsum([camera["grid_points"] for camera in info["cameras"]])
    pixels = np.fromfile(folder / "pixels.f64").reshape(count)
    return SimpleNamespace(
        folder=folder,
        info=info,
        cameras=info["cameras"],
        size=(info["cameras"][0]["width"], info["cameras"][0]["height"]),
        model=info["cameras"][0]["model"],
        board=board,
        pixels=pixels,  # camera x frame x corner x 2
        seen=~np.isnan(pixels[:, :, 0, 0]),  # camera x frame: boards are seen whole or not at all
        start=np.fromfile(folder / "start.f64").reshape(-1, 7),
        grid=[(part[:, :3], part[:, 3:]) for part in np.split(grid, ends[:-1])],
    )


def matrix(rotation, translation):
    """4 x 4 of a rotation vector or matrix and a translation."""
    out = np.eye(4)
    rotation = np.asarray(rotation, float)
    out[:3, :3] = rotation if rotation.shape == (3, 3) else rotation_matrix(rotation.ravel())
    out[:3, 3] = np.asarray(translation, float).ravel()
    return out


def rotation_matrix(vector):
    """Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def matrix_from_quaternion(xyzw):
    x, y, z, w = xyzw
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def true_error(grid, project):
    """rms and largest distance over the grid [px] once the best rotation of the rays is removed, and that rotation.

    The rotation is what board poses take up: it is no error of the camera.
    """
    rays, pixels = grid
    rotation, step = np.eye(3), 1e-6
    for _ in range(8):
        turned = rays @ rotation.T
        off = project(turned) - pixels
        good = np.isfinite(off).all(axis=1)
        if not good.any():
            return {"true_error_rms_px": None, "true_error_max_px": None, "unprojectable": len(rays)}, rotation
        columns = []
        for axis in np.eye(3):
            moved = project(turned @ rotation_matrix(step * axis).T) - project(turned @ rotation_matrix(-step * axis).T)
            columns.append((moved / (2 * step))[good].ravel())
        jacobian = np.nan_to_num(np.stack(columns, axis=1))
        change = -np.linalg.lstsq(jacobian, off[good].ravel(), rcond=None)[0]
        rotation = rotation_matrix(change) @ rotation
        if np.linalg.norm(change) < 1e-10:
            break
    off = project(rays @ rotation.T) - pixels
    good = np.isfinite(off).all(axis=1)
    distance = np.linalg.norm(off[good], axis=1)
    figures = {
        "true_error_rms_px": float(np.sqrt(np.mean(distance**2))),
        "true_error_max_px": float(distance.max()),
        "unprojectable": int((~good).sum()),
    }
    return figures, rotation


def extrinsic_error(true_cameras, estimated, removed):
    """Error of each camera's place [mm] and rotation [deg] against the first one, without the removed rotations.

    The cameras of the rig are compared in the frames of the true cameras, and the first true camera is the rig.
    """
    errors = []
    for c in range(1, len(true_cameras)):
        known = true_cameras[c]["camera_from_rig"]
        true = matrix(matrix_from_quaternion(known[:4]), known[4:])
        into_true = matrix(removed[c].T, np.zeros(3)) @ estimated[c] @ matrix(removed[0], np.zeros(3))
        cosine = (np.trace(into_true[:3, :3] @ true[:3, :3].T) - 1) / 2
        errors.append(
            {
                "place_mm": float(1e3 * np.linalg.norm(into_true[:3, 3] - true[:3, 3])),
                "rotation_deg": float(np.degrees(np.arccos(min(1.0, cosine)))),
            }
        )
    return errors


def pixels_of_kannala_brandt(parameters, rays):
    fx, fy, cx, cy, k1, k2, k3, k4 = parameters
    rho = np.maximum(np.hypot(rays[:, 0], rays[:, 1]), 1e-15)
    angle = np.arctan2(rho, rays[:, 2])
    a2 = angle**2
    radius = angle * (1 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))
    return np.stack([fx * radius * rays[:, 0] / rho + cx, fy * radius * rays[:, 1] / rho + cy], axis=1)


def pixels_of_rational(parameters, rays):
    """fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6, as cv::projectPoints."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 = parameters
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]
        r2 = x * x + y * y
        scale = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        u = fx * (x * scale + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx
        v = fy * (y * scale + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy
    out = np.stack([u, v], axis=1)
    out[rays[:, 2] <= 0] = np.nan
    return out


def peak_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def run(asked, prepare, solve, cameras):
    """Solves the problem of argv[1] and writes what it took, and how far off it is, to argv[2].

    prepare(problem) puts the observations into the peer's own containers: not timed. solve(prepared) is timed; what it
    was asked for stands in `asked`. cameras(solution) gives EstimatedCameras.
    """
    problem = read_problem(sys.argv[1])
    prepared = prepare(problem)
    before_mb = peak_mb()
    cpu, wall = time.process_time(), time.perf_counter()
    solution = solve(prepared)
    out = {"cpu_s": time.process_time() - cpu, "wall_s": time.perf_counter() - wall, "asked": asked}
    out["before_mb"], out["peak_mb"] = before_mb, peak_mb()
    found = cameras(solution)
    figures = [true_error(grid, camera.project) for grid, camera in zip(problem.grid, found)]
    out["cameras"] = [figure for figure, _ in figures]
    places = [camera.camera_from_rig for camera in found]
    out["extrinsics"] = extrinsic_error(problem.cameras, places, [removed for _, removed in figures])
    pathlib.Path(sys.argv[2]).write_text(json.dumps(out, indent=1) + "\n")
