# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""lensboy: its OpenCV model with the coefficients of the rational one, or its splined one for fisheye lenses.

usage: peer_lensboy.py FOLDER RESULT.json
"""

from importlib.metadata import version

import lensboy
import numpy as np

import problem as bench


def prepare(problem):
    ids = np.arange(len(problem.board))
    frames = [lensboy.Frame(ids, pixels) for pixels in problem.pixels[0]]
    width, height = problem.size
    if problem.model == "kannala_brandt":
        config = lensboy.PinholeSplinedConfig(height, width, 20, 15)
    else:
        kind = lensboy.OpenCVConfig
        config = kind(height, width, included_distortion_coefficients=kind.RADIAL_6 | kind.TANGENTIAL)
    return problem, frames, config


def solve(prepared):
    problem, frames, config = prepared
    return lensboy.calibrate_camera(problem.board, frames, config)


def cameras(result):
    return [bench.EstimatedCamera(lambda rays: result.camera_model.project_points(rays), np.eye(4))]


bench.run(
    f"lensboy {version('lensboy')}, default options (board warp, outlier filter); rational: RADIAL_6 and TANGENTIAL; fisheye: "
    "PinholeSplined with 20 x 15 knots",
    prepare,
    solve,
    cameras,
)
