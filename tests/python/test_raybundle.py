#!/usr/bin/env python3
# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""The Python module as its users meet it; PYTHONPATH names the folder that it was built in."""

import json
import math
import tempfile
import unittest
from pathlib import Path

import numpy as np

import raybundle


def rotation(vector):
    """Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def transform(vector, translation):
    matrix = np.eye(4)
    matrix[:3, :3] = rotation(vector)
    matrix[:3, 3] = translation
    return matrix


def moved(b_from_a, points):
    return points @ b_from_a[:3, :3].T + b_from_a[:3, 3]


BOARD = np.array([[0.03 * column, 0.03 * row, 0.0] for row in range(8) for column in range(11)])
FISHEYE = [300.0, 301.0, 322.0, 238.0, -0.02, 0.005, -0.003, 0.0004]


def true_rig():
    """A pair of fisheyes, 12 cm apart."""
    left = raybundle.Camera("kannala_brandt", 640, 480, np.array(FISHEYE))
    right = raybundle.Camera("kannala_brandt", 640, 480, np.array(FISHEYE) * 1.01)
    return [
        raybundle.RigCamera("left", left),
        raybundle.RigCamera("right", right, transform([0.0, 0.05, 0.01], [-0.12, 0.001, 0.002])),
    ]


def problem_of(rig, noise_px, seed=1):
    """Boards before the pair, of which each camera sees what falls into its image."""
    draw = np.random.default_rng(seed)
    problem = raybundle.Problem()
    for camera in rig:
        problem.add_camera(camera.name, "kannala_brandt", 640, 480)
    problem.add_target("board", BOARD)
    for frame in range(25):
        place = [draw.uniform(-0.45, 0.15), draw.uniform(-0.35, 0.1), draw.uniform(0.2, 0.5)]
        rig_from_target = transform(draw.uniform(-0.5, 0.5, 3), place)
        for camera in rig:
            pixels = camera.camera.project(moved(camera.camera_from_rig @ rig_from_target, BOARD))
            seen = np.all(np.isfinite(pixels) & (pixels > 0) & (pixels < [639, 479]), axis=1)
            if seen.sum() < 12:
                continue
            measured = pixels[seen] + noise_px * draw.standard_normal((seen.sum(), 2))
            problem.add_view(camera.name, f"frame {frame}", np.flatnonzero(seen), measured, sigma_px=max(noise_px, 0.01))
    return problem


class Cameras(unittest.TestCase):
    def test_projects_what_it_unprojects(self):
        self.assertIn("kannala_brandt", raybundle.camera_models())
        self.assertEqual(raybundle.parameter_names("pinhole"), ["fx", "fy", "cx", "cy"])
        camera = raybundle.Camera("kannala_brandt", 640, 480, FISHEYE)
        self.assertEqual(camera.named_parameters()["k2"], 0.005)
        pixels = np.array([[320.0, 240.0], [100.5, 50.25], [600.0, 400.0]])
        rays = camera.unproject(pixels)
        np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0)
        np.testing.assert_allclose(camera.project(7.0 * rays), pixels, atol=1e-9)

    def test_what_is_not_seen_is_nan(self):
        pinhole = raybundle.Camera("pinhole", 640, 480, [500.0, 500.0, 319.5, 239.5])
        pixels = pinhole.project(np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]))
        self.assertTrue(np.isnan(pixels[0]).all() and np.isnan(pixels[2]).all())
        np.testing.assert_array_equal(pixels[1], [319.5, 239.5])

    def test_bad_parameters_are_refused_in_one_sentence(self):
        with self.assertRaisesRegex(raybundle.Error, "kannala_brandt has 8 parameters: fx fy cx cy k1 k2 k3 k4"):
            raybundle.Camera("kannala_brandt", 640, 480, [500.0])
        with self.assertRaisesRegex(raybundle.Error, "is no camera model; known: "):
            raybundle.Camera("fisheye", 640, 480, FISHEYE)
        with self.assertRaisesRegex(ValueError, "positive focal lengths"):
            raybundle.Camera("pinhole", 640, 480, [0.0, 1.0, 2.0, 3.0])
        with self.assertRaisesRegex(raybundle.Error, "has to be a rotation"):
            raybundle.RigCamera("left", raybundle.Camera("pinhole", 640, 480, [1.0, 1.0, 2.0, 3.0]), 2 * np.eye(4))
        by_rows = np.eye(4)
        by_rows[3, 0] = -0.1  # a transform of row vectors
        with self.assertRaisesRegex(raybundle.Error, "last row of a transform has to be 0 0 0 1"):
            raybundle.RigCamera("left", raybundle.Camera("pinhole", 640, 480, [1.0, 1.0, 2.0, 3.0]), by_rows)


class Calibrates(unittest.TestCase):
    def test_finds_the_truth_without_noise(self):
        rig = true_rig()
        result = raybundle.calibrate(problem_of(rig, noise_px=0.0))
        for camera in rig:
            found = result.calibration[camera.name]
            np.testing.assert_allclose(found.camera.parameters[:4], camera.camera.parameters[:4], rtol=1e-8)
            np.testing.assert_allclose(found.camera_from_rig, camera.camera_from_rig, atol=1e-8)
        self.assertLess(result.rms_px, 1e-8)

    def test_with_noise_lies_within_its_sigmas(self):
        rig = true_rig()
        problem = problem_of(rig, noise_px=0.1)
        result = raybundle.calibrate(problem, estimate_shape=False, threads=1)
        covariance = result.calibration.covariance
        for index, name in enumerate(["fx", "fy", "cx", "cy"]):
            sigma = covariance.sigma(f"left.{name}")
            self.assertGreater(sigma, 0)
            self.assertLess(abs(result.calibration["left"].camera.parameters[index] - FISHEYE[index]), 5 * sigma)
        self.assertAlmostEqual(result.rms_px, 0.1 * math.sqrt(2), delta=0.01)
        self.assertEqual(result.set_aside, [])
        self.assertEqual(len(problem), len([1 for view in range(len(problem)) if len(result.residuals(view))]))
        sigmas = result.calibration.projection_sigma("left", np.array([[320.0, 240.0], [20.0, 20.0]]))
        self.assertLess(sigmas[0], sigmas[1])
        asked = [result.calibration.projection_sigma("left", np.array([[320.0, 240.0]]), by=by)[0]
                 for by in ("corners", "frames", "larger")]
        self.assertEqual(asked[2], max(asked[:2]))
        for range_m in (0.0, -1.0, math.nan):
            with self.assertRaisesRegex(ValueError, "above 0"):
                result.calibration.projection_sigma("left", np.array([[320.0, 240.0]]), range_m=range_m)
        np.testing.assert_array_less(sigmas, 1.0)

    def test_rules_hold_parameters(self):
        problem = problem_of(true_rig(), noise_px=0.1)
        with self.assertRaises(TypeError):
            problem.fix("*.k4")  # at which value?
        problem.fix("*.k4", 0.0)
        with self.assertRaisesRegex(raybundle.Error, "tie_sigma is nan, but must be a positive number"):
            raybundle.calibrate(problem, tie_sigma=float("nan"))
        calibration = raybundle.calibrate(problem).calibration
        self.assertEqual(calibration["left"].camera.named_parameters()["k4"], 0.0)
        with self.assertRaisesRegex(raybundle.Error, "left.k4' is not among the names"):
            calibration.covariance.sigma("left.k4")
        for rule, values in (("fix", (math.nan,)), ("prior", (math.nan, 0.1))):
            problem = problem_of(true_rig(), noise_px=0.1)
            getattr(problem, rule)("*.k3", *values)
            with self.assertRaisesRegex(raybundle.Error, r"the value for '\*.k3' is not a finite number"):
                raybundle.calibrate(problem)

    def test_several_boards_are_told_apart_by_name(self):
        problem = raybundle.Problem()
        problem.add_camera("left", "kannala_brandt", 640, 480)
        view = ("left", "frame 1", [0], [[1.0, 2.0]])
        with self.assertRaisesRegex(raybundle.Error, "there is no target"):
            problem.add_view(*view)
        problem.add_target("board", BOARD)
        problem.add_view(*view)
        problem.add_target("other", BOARD)
        with self.assertRaisesRegex(raybundle.Error, "there are 2 targets; say which one the view shows"):
            problem.add_view(*view)
        problem.add_view(*view, target="other")
        self.assertEqual(len(problem), 2)

    def test_cameras_without_their_covariance_have_no_sigmas(self):
        calibration = raybundle.calibrate(problem_of(true_rig(), noise_px=0.1)).calibration
        alone = raybundle.Calibration([calibration["left"]])
        with self.assertRaisesRegex(raybundle.Error, "does not tell where the corners of camera left were"):
            alone.projection_sigma("left", np.array([[320.0, 240.0]]))

    def test_files_come_back(self):
        result = raybundle.calibrate(problem_of(true_rig(), noise_px=0.1), outlier_sigma=4.5)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "calibration.json"
            result.write_calibration(path)
            back = raybundle.read_calibration(path)
            self.assertEqual([camera.name for camera in back.cameras], ["left", "right"])
            np.testing.assert_array_equal(back["left"].camera.parameters,
                                          result.calibration["left"].camera.parameters)
            # One triangle is saved; the other may differ by rounding.
            np.testing.assert_allclose(back.covariance.matrix, result.calibration.covariance.matrix, rtol=1e-12)
            again = Path(folder) / "again.json"
            raybundle.write_calibration(back, again)
            self.assertEqual(again.read_bytes(), path.read_bytes())
            self.assertTrue("left" in back and "middle" not in back and len(back) == 2)
            result.write_report(Path(folder) / "report.json")
            report = json.loads((Path(folder) / "report.json").read_text())
            self.assertEqual(report["rms_px"], result.rms_px)
            for provenance in (report["provenance"], json.loads(path.read_text())["provenance"]):
                self.assertIn({"name": "outlier_sigma", "value": "4.5"}, provenance["options"])
                self.assertIn({"name": "estimate_shape", "value": "true"}, provenance["options"])
                self.assertEqual(provenance["versions"], [{"name": "raybundle", "value": raybundle.__version__}])

    def test_mistakes_are_told(self):
        problem = problem_of(true_rig(), noise_px=0.1)
        with self.assertRaisesRegex(TypeError, "knows these options: estimate_shape"):
            raybundle.calibrate(problem, shape=False)
        with self.assertRaisesRegex(TypeError, "threads has to be like 2"):
            raybundle.calibrate(problem, threads="x")
        with self.assertRaisesRegex(raybundle.Error, "no camera 'middle'"):
            problem.add_view("middle", "frame 1", [0], [[1.0, 2.0]])
        with self.assertRaisesRegex(raybundle.Error, "as many ids as pixels"):
            problem.add_view("left", "frame 1", [0, 1], [[1.0, 2.0]])
        with self.assertRaisesRegex(raybundle.Error, "no such file"):
            raybundle.read_calibration("nowhere.json")
        with self.assertRaises(raybundle.Error):
            raybundle.calibrate(raybundle.Problem())


if __name__ == "__main__":
    unittest.main()
