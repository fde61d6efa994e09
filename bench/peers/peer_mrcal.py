# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""mrcal's Python API, in the steps of its own program mrcal-calibrate-cameras.

usage: peer_mrcal.py FOLDER RESULT.json [opencv8 | splined]
"""

import sys

import mrcal
import numpy as np

import problem as bench

SPLINED = "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx={}_Ny={}_fov_x_deg={}"
wanted = sys.argv[3] if len(sys.argv) > 3 else "opencv8"


def prepare(problem):
    indices, observations = [], []
    rows, columns = problem.info["rows"], problem.info["columns"]
    for frame in range(problem.info["frames"]):
        for c in np.flatnonzero(problem.seen[:, frame]):
            indices.append((frame, c, c - 1))
            pixels = problem.pixels[c, frame].reshape(rows, columns, 2)
            observations.append(np.concatenate([pixels, np.ones((rows, columns, 1))], axis=2))
    problem.indices = np.array(indices, np.int32)
    problem.observations = np.array(observations)
    problem.lens = "LENSMODEL_OPENCV8"
    if wanted == "splined":
        field = {"kb130": 150, "kb150": 170}.get(problem.info["family"].removeprefix("stereo_"), 90)
        problem.lens = SPLINED.format(24, 18, field)
    problem.focal = [camera["parameters"][0] for camera in problem.cameras]  # as its user would give
    return problem


def solve(problem):
    sizes = np.array([problem.size] * len(problem.cameras), np.int32)
    intrinsics, extrinsics, frames = mrcal.seed_stereographic(
        imagersizes=sizes,
        focal_estimate=problem.focal,
        indices_frame_camera=problem.indices[:, :2],
        observations=problem.observations,
        object_spacing=problem.info["square_m"],
    )
    observations = problem.observations.copy()
    common = {
        "imagersizes": sizes,
        "calibration_object_spacing": problem.info["square_m"],
        "verbose": False,
    }
    arrays = (extrinsics, frames, None, observations, problem.indices, None, None)
    for core in (False, True):
        mrcal.optimize(
            intrinsics,
            *arrays,
            "LENSMODEL_STEREOGRAPHIC",
            do_optimize_intrinsics_core=core,
            do_optimize_intrinsics_distortions=False,
            do_optimize_calobject_warp=False,
            do_apply_outlier_rejection=False,
            do_apply_regularization=False,
            **common,
        )
    count = mrcal.lensmodel_num_params(problem.lens) - intrinsics.shape[1]
    shapes = 2e-6 * (np.random.default_rng(0).random((len(sizes), count)) - 0.5)
    if "OPENCV8" in problem.lens:
        shapes[:, 5:8] *= 1e-3
    intrinsics = np.concatenate([intrinsics, shapes], axis=1)
    warp = np.zeros(2)
    core = "SPLINED" not in problem.lens
    for with_warp in (False, True):
        mrcal.optimize(
            intrinsics,
            *arrays,
            problem.lens,
            calobject_warp=warp if with_warp else None,
            do_optimize_intrinsics_core=core,
            do_optimize_calobject_warp=with_warp,
            do_apply_outlier_rejection=True,
            do_apply_regularization=True,
            **common,
        )
    return problem, intrinsics, extrinsics


def cameras(solution):
    problem, intrinsics, extrinsics = solution
    places = [np.eye(4)] + [bench.matrix(rt[:3], rt[3:]) for rt in extrinsics]
    out = []
    for values, place in zip(intrinsics, places):
        project = lambda rays, v=values: mrcal.project(np.ascontiguousarray(rays), problem.lens, v)
        out.append(bench.EstimatedCamera(project, place))
    return out


bench.run(
    f"mrcal 2.2, {wanted}: the steps of mrcal-calibrate-cameras, given the true focal length; outlier rejection, board warp, "
    "regularization on",
    prepare,
    solve,
    cameras,
)
