# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""pycolmap's bundle adjustment, from a start near the truth, with the board as constant points.

usage: peer_pycolmap.py FOLDER RESULT.json
"""

import numpy as np
import pycolmap

import problem as bench

HALF = 0.5  # COLMAP's pixel (0, 0) is the corner of the image
SENSOR = pycolmap.SensorType.CAMERA


def prepare(problem):
    """A reconstruction: the rig's cameras, the board's corners as points, a frame for each pose of the board."""
    made = pycolmap.Reconstruction()
    fisheye = problem.model == "kannala_brandt"
    rig = pycolmap.Rig(rig_id=1)
    for c, known in enumerate(problem.cameras):
        parameters = np.zeros(8 if fisheye else 12)
        parameters[:2] = 1.05 * np.array(known["parameters"][:2])
        parameters[2:4] = (known["width"] / 2, known["height"] / 2)
        camera = pycolmap.Camera(
            camera_id=c + 1,
            model="OPENCV_FISHEYE" if fisheye else "FULL_OPENCV",
            width=known["width"],
            height=known["height"],
            params=parameters,
        )
        made.add_camera(camera)
        if c == 0:
            rig.add_ref_sensor(camera.sensor_id)
        else:
            place = known["camera_from_rig"]
            rotation = bench.rotation_matrix(np.array([0.01, 0.02, -0.01])) @ bench.matrix_from_quaternion(place[:4])
            rig.add_sensor(camera.sensor_id, pycolmap.Rigid3d(pycolmap.Rotation3d(rotation), 1.05 * np.array(place[4:])))
    made.add_rig(rig)
    for point in problem.board:
        made.add_point3D(point, pycolmap.Track())
    identifiers = sorted(made.point3D_ids())
    image_id = 0
    for f in range(problem.info["frames"]):
        frame = pycolmap.Frame(frame_id=f + 1, rig_id=1)
        images = []
        for c in np.flatnonzero(problem.seen[:, f]):
            image_id += 1
            image = pycolmap.Image(f"{c}_{f}", problem.pixels[c, f] + HALF, int(c) + 1, image_id)
            image.frame_id = f + 1
            frame.add_data_id(image.data_id)
            images.append(image)
        frame.rig_from_world = pycolmap.Rigid3d(pycolmap.Rotation3d(problem.start[f, :4]), problem.start[f, 4:])
        made.add_frame(frame)
        for image in images:
            made.add_image(image)
            for i, identifier in enumerate(identifiers):
                made.add_observation(identifier, pycolmap.TrackElement(image.image_id, i))
        made.register_frame(f + 1)
    config = pycolmap.BundleAdjustmentConfig()
    for image_id in made.images:
        config.add_image(image_id)
    for identifier in identifiers:
        config.add_constant_point(identifier)
    options = pycolmap.BundleAdjustmentOptions()
    options.refine_principal_point = True
    options.print_summary = False
    options.ceres.solver_options.num_threads = bench.THREADS
    return made, config, options


def solve(prepared):
    made, config, options = prepared
    pycolmap.create_default_bundle_adjuster(options, config, made).solve()
    return made


def cameras(made):
    out = []
    rig = made.rigs[1]
    for identifier in sorted(made.cameras):
        camera = made.cameras[identifier]
        place = np.eye(4)
        if not rig.is_ref_sensor(camera.sensor_id):
            place[:3] = rig.sensor_from_rig(camera.sensor_id).matrix()
        parameters = np.array(camera.params)
        parameters[2:4] -= HALF
        known = bench.pixels_of_kannala_brandt if len(parameters) == 8 else bench.pixels_of_rational
        out.append(bench.EstimatedCamera(lambda rays, p=parameters, f=known: f(p, rays), place))
    return out


bench.run(
    f"pycolmap {pycolmap.__version__}, default options, principal point refined, board constant; from a start: "
    "focal length 5 % off, no distortion, boards 1.4 degrees and 2.3 cm off",
    prepare,
    solve,
    cameras,
)
