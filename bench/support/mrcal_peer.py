# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""mrcal on many rigs, in the steps of its own program mrcal-calibrate-cameras, each in a process of its own.

usage: mrcal_peer.py RIGS ANSWERS

A rig: lens model, width, height, focal length to start from, columns, rows, square, number of views; of each view the
number of corners and then point id, u and v of each. An answer: one line of intrinsics and rotation vector and
translation of each view, or the word `none`.
"""

import os
import signal
import sys

import mrcal
import numpy as np

LONGEST_S = 60


def read_rigs(path):
    words = iter(open(path).read().split())
    for lens in words:
        size = [int(next(words)) for _ in range(2)]
        focal = float(next(words))
        columns, rows = int(next(words)), int(next(words))
        square = float(next(words))
        observations = np.zeros((int(next(words)), rows, columns, 3))
        observations[..., 2] = -1
        for view in observations:
            for _ in range(int(next(words))):
                row, column = divmod(int(next(words)), columns)
                view[row, column] = float(next(words)), float(next(words)), 1
        yield lens, size, focal, square, observations


def solve(lens, size, focal, square, observations):
    views = len(observations)
    indices = np.array([(view, 0, -1) for view in range(views)], np.int32)
    sizes = np.array([size], np.int32)
    seen = observations.copy()
    seen[seen[..., 2] < 0] = np.nan, np.nan, -1
    intrinsics, extrinsics, frames = mrcal.seed_stereographic(
        imagersizes=sizes,
        focal_estimate=focal,
        indices_frame_camera=indices[:, :2],
        observations=seen,
        object_spacing=square,
    )
    arrays = (extrinsics, frames, None, observations, indices, None, None)
    common = {"imagersizes": sizes, "calibration_object_spacing": square, "verbose": False}
    common["do_optimize_calobject_warp"] = False
    common["do_apply_outlier_rejection"] = False
    for core in (False, True):
        mrcal.optimize(
            intrinsics,
            *arrays,
            "LENSMODEL_STEREOGRAPHIC",
            do_optimize_intrinsics_core=core,
            do_optimize_intrinsics_distortions=False,
            do_apply_regularization=False,
            **common,
        )
    count = mrcal.lensmodel_num_params(lens) - intrinsics.shape[1]
    shapes = 2e-6 * (np.random.default_rng(0).random((1, count)) - 0.5)
    shapes[:, 5:8] *= 1e-3
    intrinsics = np.concatenate([intrinsics, shapes], axis=1)
    mrcal.optimize(intrinsics, *arrays, lens, do_apply_regularization=True, **common)
    return np.concatenate([intrinsics.ravel(), frames.ravel()])


def answer_of(rig):
    """In a process of its own: some inputs end the process."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(LONGEST_S)
        text = "none"
        try:
            values = solve(*rig)
            if np.isfinite(values).all():
                text = " ".join(f"{value:.17g}" for value in values)
        except Exception:
            pass
        os.write(write, text.encode())
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return text or "none"


with open(sys.argv[2], "w") as answers:
    for rig in read_rigs(sys.argv[1]):
        print(answer_of(rig), file=answers)
