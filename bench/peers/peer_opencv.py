# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""OpenCV: fisheye.calibrate or calibrateCamera; for pairs stereoCalibrate on top; for rigs calibrateMultiview.

usage: peer_opencv.py FOLDER RESULT.json [focal]. Which OpenCV: that of the interpreter. With `focal` it is given the
true focal length, which some of its starts need.
"""

import sys

import cv2
import numpy as np

import problem as bench

cv2.setNumThreads(bench.THREADS)
focal_given = "focal" in sys.argv[3:]


def constant(name):
    """Since OpenCV 5 the flags of cv2.fisheye are those of cv2."""
    return getattr(cv2, name) if hasattr(cv2, name) else getattr(cv2.fisheye, name)


def lens_flags(model):
    if model == "kannala_brandt":
        return constant("CALIB_RECOMPUTE_EXTRINSIC") | constant("CALIB_FIX_SKEW")
    return cv2.CALIB_RATIONAL_MODEL


def prepare(problem):
    problem.views = []
    for c in range(len(problem.cameras)):
        frames = np.flatnonzero(problem.seen[c])
        shape = (1, -1) if problem.model == "kannala_brandt" else (-1, 1)
        board = problem.board.reshape(*shape, 3)
        if problem.model != "kannala_brandt":
            board = board.astype(np.float32)
        pixels = [problem.pixels[c, f].reshape(*shape, 2).astype(board.dtype) for f in frames]
        problem.views.append(([board] * len(frames), pixels))
    return problem


def calibrate_one(problem, c):
    objects, pixels = problem.views[c]
    flags, intrinsics, distortion = lens_flags(problem.model), None, None
    if focal_given:
        flags |= constant("CALIB_USE_INTRINSIC_GUESS")
        focal, (width, height) = problem.cameras[c]["parameters"][0], problem.size
        intrinsics = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        distortion = np.zeros(4 if problem.model == "kannala_brandt" else 8)
    calibrate = cv2.fisheye.calibrate if problem.model == "kannala_brandt" else cv2.calibrateCamera
    return calibrate(objects, pixels, problem.size, intrinsics, distortion, flags=flags)[1:3]


def solve_pair(problem):
    (k0, d0), (k1, d1) = calibrate_one(problem, 0), calibrate_one(problem, 1)
    objects, left = problem.views[0]
    right = problem.views[1][1]
    flags = lens_flags(problem.model) | constant("CALIB_USE_INTRINSIC_GUESS")
    if problem.model == "kannala_brandt":
        found = cv2.fisheye.stereoCalibrate(objects, left, right, k0, d0, k1, d1, problem.size, flags=flags)
    else:
        found = cv2.stereoCalibrate(objects, left, right, k0, d0, k1, d1, problem.size, flags=flags)
    _, k0, d0, k1, d1, rotation, translation = found[:7]
    return [(k0, d0, np.eye(4)), (k1, d1, bench.matrix(rotation, translation))]


def solve_rig(problem):
    fisheye = problem.model == "kannala_brandt"
    count = len(problem.cameras)
    pixels = np.nan_to_num(problem.pixels, nan=-1.0).astype(np.float32)
    # By itself calibrateMultiview cannot start fisheye lenses in OpenCV 5.0 (its issue 29692): each camera first.
    alone = [calibrate_one(problem, c) for c in range(count)] if fisheye else None
    found = cv2.calibrateMultiview(
        [problem.board.astype(np.float32)] * problem.info["frames"],
        [list(camera) for camera in pixels],
        [problem.size] * count,
        problem.seen.astype(np.uint8),
        np.full(count, cv2.CALIB_MODEL_FISHEYE if fisheye else cv2.CALIB_MODEL_PINHOLE, np.uint8),
        [k for k, _ in alone] if fisheye else None,
        [d for _, d in alone] if fisheye else None,
        None,
        None,
        flags=cv2.CALIB_USE_INTRINSIC_GUESS if fisheye else 0,
        flagsForIntrinsics=np.full(count, lens_flags(problem.model), np.int32),
    )
    _, intrinsics, distortions, rotations, translations = found[:5]
    places = [bench.matrix(np.squeeze(r), t) for r, t in zip(rotations, translations)]
    return list(zip(intrinsics, distortions, places))


def solve(problem):
    if len(problem.cameras) == 1:
        return problem, [(*calibrate_one(problem, 0), np.eye(4))]
    return problem, solve_pair(problem) if len(problem.cameras) == 2 else solve_rig(problem)


def cameras(solution):
    problem, found = solution
    project = bench.pixels_of_kannala_brandt if problem.model == "kannala_brandt" else bench.pixels_of_rational
    count = 4 if problem.model == "kannala_brandt" else 8
    out = []
    for k, d, place in found:
        parameters = np.concatenate([[k[0, 0], k[1, 1], k[0, 2], k[1, 2]], np.ravel(d)[:count]])
        out.append(bench.EstimatedCamera(lambda rays, p=parameters: project(p, rays), place))
    return out


bench.run(
    f"OpenCV {cv2.__version__}, {'given the true focal length, ' if focal_given else ''}default criteria; Kannala-Brandt: RECOMPUTE_EXTRINSIC and FIX_SKEW; rational: "
    "RATIONAL_MODEL; pairs: each camera first, then stereoCalibrate from there; rigs: calibrateMultiview",
    prepare,
    solve,
    cameras,
)
