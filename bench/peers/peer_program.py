# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""`raybundle calibrate --observations` as a whole process: reading, solving, writing all of its files.

usage: peer_program.py PROGRAM FOLDER RESULT.json
"""

import json
import pathlib
import resource
import subprocess
import sys
import time

import numpy as np

import problem as bench

program, folder, result = sys.argv[1:4]
known = bench.read_problem(folder)
output = pathlib.Path(result).parent / "calibration"
begin = time.perf_counter()
done = subprocess.run(
    [program, "calibrate", "--observations", f"{folder}/observations.json", "--threads", "1", "--json", "-o", str(output)],
    capture_output=True,
)
wall = time.perf_counter() - begin
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
if done.returncode:
    sys.exit(done.stderr.decode())
report = json.loads(done.stdout)
out = {"cpu_s": usage.ru_utime + usage.ru_stime, "wall_s": wall, "peak_mb": usage.ru_maxrss / 1024, "before_mb": 0}
out["asked"] = "the whole program, from observations.json to calibration.json, report.json and report.html"
out["stages"] = {stage["name"]: stage["seconds"] for stage in report["stages"]}
calibration = json.loads((output / "calibration.json").read_text())
figures, places = [], []
for grid, camera in zip(known.grid, calibration["cameras"]):
    values = np.array(list(camera["parameters"].values()))
    kinds = {"kannala_brandt": bench.pixels_of_kannala_brandt, "rational": bench.pixels_of_rational}
    figures.append(bench.true_error(grid, lambda rays: kinds[camera["model"]](values, rays)))
    place = camera["camera_from_rig"]
    places.append(bench.matrix(bench.matrix_from_quaternion(place["rotation_xyzw"]), place["translation_m"]))
out["cameras"] = [figure for figure, _ in figures]
out["extrinsics"] = bench.extrinsic_error(known.cameras, places, [removed for _, removed in figures])
pathlib.Path(result).write_text(json.dumps(out, indent=1) + "\n")
