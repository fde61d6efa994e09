# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""multical's workspace from corners in memory: intrinsics by OpenCV, then its bundle adjustment.

usage: peer_multical.py FOLDER RESULT.json. Its command line does not start on Python 3.11 (a mutable default of a
dataclass), its library does.
"""

from importlib.metadata import version

import numpy as np

np.bool = bool  # multical uses the name, which numpy 1.24 took away

import multical.tables
from multical.board.board import Board
from multical.board.common import estimate_pose_points
from multical.workspace import Workspace
from structs.struct import struct

import problem as bench


class Grid(Board):
    """A board of which the corners are known; multical's own kinds detect markers."""

    def __init__(self, points):
        self.adjusted_points = points

    points = property(lambda self: self.adjusted_points)
    num_points = property(lambda self: len(self.adjusted_points))
    ids = property(lambda self: np.arange(self.num_points))
    params = property(lambda self: self.adjusted_points)

    def __str__(self):
        return f"Grid of {self.num_points} points"

    def has_min_detections(self, detections):
        return detections.ids.size > 15

    def estimate_pose_points(self, camera, detections):
        return estimate_pose_points(self, camera, detections)

    @property
    def param_vec(self):
        return self.adjusted_points.ravel()

    def with_param_vec(self, vector):
        return Grid(vector.reshape(-1, 3))


def prepare(problem):
    work = Workspace(".")
    ids = np.arange(len(problem.board))
    names = [camera["name"] for camera in problem.cameras]
    work.names = struct(camera=names, image=[str(f) for f in range(problem.info["frames"])], board=["board"])
    work.boards = [Grid(problem.board)]
    work.image_size = [problem.size] * len(names)
    work.detected_points = [
        [[struct(corners=pixels.astype(np.float32), ids=ids)] for pixels in camera] for camera in problem.pixels
    ]
    work.point_table = multical.tables.make_point_table(work.detected_points, work.boards)
    return work


def solve(work):
    work.calibrate_single("rational", 0.5)
    work.initialise_poses()
    return work.calibrate("calibration", cameras=True)


def cameras(calibration):
    out = []
    for camera in calibration.cameras:
        k, d = camera.intrinsic, np.ravel(camera.dist)[:8]
        values = np.concatenate([[k[0, 0], k[1, 1], k[0, 2], k[1, 2]], d])
        out.append(bench.EstimatedCamera(lambda rays, v=values: bench.pixels_of_rational(v, rays), np.eye(4)))
    return out


bench.run(
    f"multical {version('multical')}, rational, its defaults, but intrinsics from all views: its choice of 50 fails where all boards "
    "are seen whole; OpenCV's calibrateCamera, then its own bundle adjustment",
    prepare,
    solve,
    cameras,
)
