# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""mrcal-calibrate-cameras as a whole process, from a table of corners to a .cameramodel.

usage: peer_mrcal_program.py FOLDER RESULT.json
"""

import json
import pathlib
import re
import resource
import subprocess
import sys
import time

import numpy as np

import problem as bench

folder, result = sys.argv[1:3]
known = bench.read_problem(folder)
work = pathlib.Path(result).parent
with open(work / "corners.vnl", "w") as table:
    table.write("# filename x y level\n")
    for frame in range(known.info["frames"]):
        for u, v in known.pixels[0, frame]:
            table.write(f"frame{frame:05d}-cam0.png {u:.6f} {v:.6f} 0\n")
begin = time.perf_counter()
done = subprocess.run(
    [
        "mrcal-calibrate-cameras",
        "--corners-cache", "corners.vnl",
        "--lensmodel", "LENSMODEL_OPENCV8",
        "--focal", f"{known.cameras[0]['parameters'][0]:.0f}",
        "--object-spacing", str(known.info["square_m"]),
        "--object-width-n", str(known.info["columns"]),
        "--object-height-n", str(known.info["rows"]),
        "--imagersize", *map(str, known.size),
        "--outdir", ".",
        "frame*-cam0.png",
    ],
    capture_output=True,
    cwd=work,
)  # fmt: skip
wall = time.perf_counter() - begin
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
models = list(work.glob("*.cameramodel"))
if done.returncode or not models:
    sys.exit(done.stderr.decode() or "mrcal-calibrate-cameras wrote no .cameramodel")
out = {"cpu_s": usage.ru_utime + usage.ru_stime, "wall_s": wall, "peak_mb": usage.ru_maxrss / 1024, "before_mb": 0}
out["asked"] = "mrcal-calibrate-cameras, LENSMODEL_OPENCV8, the true focal length, as a whole process"
text = re.search(r"'intrinsics':\s*\[([^]]*)\]", models[0].read_text()).group(1)
values = np.array([float(word) for word in re.split(r"[,\s]+", text) if word])
figure, _ = bench.true_error(known.grid[0], lambda rays: bench.pixels_of_rational(values, rays))
out["cameras"], out["extrinsics"] = [figure], []
pathlib.Path(result).write_text(json.dumps(out, indent=1) + "\n")
