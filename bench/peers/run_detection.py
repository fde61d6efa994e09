# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""Detectors on real images: images per second with two workers, and in how many the board was found.

`./dev bench detection` calls it; it writes build/peers/detection.md, which report.py puts into docs/benchmarks.md. The
images lie beside the project (../shared/data, or RAYBUNDLE_DATA); without them there is nothing to measure.
"""

import argparse
import json
import multiprocessing
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import cv2

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "peers"
WORKERS = 2


def grey(path):
    return cv2.imread(path, cv2.IMREAD_GRAYSCALE)


def chessboard_sb(job):
    path, columns, rows = job
    flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
    return columns * rows if cv2.findChessboardCornersSB(grey(path), (columns, rows), flags=flags)[0] else 0


def chessboard_sb_plain(job):
    path, columns, rows = job
    return columns * rows if cv2.findChessboardCornersSB(grey(path), (columns, rows))[0] else 0


def chessboard_classic(job):
    path, columns, rows = job
    image = grey(path)
    found, corners = cv2.findChessboardCorners(image, (columns, rows))
    if not found:
        return 0
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 30, 0.001)
    cv2.cornerSubPix(image, corners, (5, 5), (-1, -1), criteria)
    return columns * rows


def chessboard_either(job):
    """What somebody does who wants all of them: the classic one, and the sector-based one where it fails."""
    return chessboard_classic(job) or chessboard_sb_plain(job)


def aruco_two_bit(job):
    image = grey(job[0])
    parameters = cv2.aruco.DetectorParameters()
    parameters.markerBorderBits = 2
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36H11), parameters)
    return 4 * len(detector.detectMarkers(image)[0])


def pupil(job):
    import pupil_apriltags

    return 4 * len(pupil_apriltags.Detector(families="tag36h11").detect(grey(job[0])))


def one_thread():
    cv2.setNumThreads(1)


def measure_function(function, images, columns, rows):
    """Seconds, and corners found in each image; two processes, as the program has two threads."""
    jobs = [(str(path), columns, rows) for path in images]
    with multiprocessing.Pool(WORKERS, initializer=one_thread) as pool:
        pool.map(chessboard_fast_warm, range(WORKERS))
        begin, before = time.perf_counter(), children_cpu_s(pool)
        found = pool.map(function, jobs, chunksize=1)
        wall, cpu = time.perf_counter() - begin, children_cpu_s(pool) - before
        peak = sum(peak_of(worker.pid) for worker in pool._pool)
    return wall, cpu, peak, found


def chessboard_fast_warm(_):
    return 0


def children_cpu_s(pool):
    """Processor time that the workers have used so far; finer than the kernel's ticks, of which two images take few."""
    tasks = [task for worker in pool._pool for task in pathlib.Path(f"/proc/{worker.pid}/task").iterdir()]
    return 1e-9 * sum(int((task / "schedstat").read_text().split()[0]) for task in tasks)


def peak_of(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) / 1024
    return 0.0


def timed(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.perf_counter()
    done = subprocess.run(["/usr/bin/time", "-f", "%M", *command] if pathlib.Path("/usr/bin/time").exists() else command,
                          capture_output=True)
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return wall, cpu, done


def raybundle(build, images, target):
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        listed = pathlib.Path(folder) / "images"
        listed.mkdir()
        for number, path in enumerate(images):  # one camera, frames by number
            (listed / f"image{number:04d}{path.suffix}").symlink_to(path)
        output = pathlib.Path(folder) / "observations.json"
        command = [build / "raybundle", "detect", "--target", target, "--camera", f"camera={listed}/*", "--threads",
                   str(WORKERS), "--no-cache", "-o", output]
        starts = [timed([str(build / "raybundle"), "--version"])[:2] for _ in range(3)]  # the first may wait for the disk
        start_wall, start_cpu = min(wall for wall, _ in starts), min(cpu for _, cpu in starts)
        wall, cpu, done = timed([str(word) for word in command])
        wall, cpu = wall - start_wall, cpu - start_cpu
        if not output.exists():
            raise SystemExit(done.stderr.decode())
        views = json.loads(output.read_text())["views"]
    last = done.stderr.decode().strip().splitlines()[-1:]
    peak = int(last[0]) / 1024 if last and last[0].isdigit() else float("nan")
    found = [len(view["points"]) for view in views]
    return wall, cpu, peak, found + [0] * (len(images) - len(found))


def mrgingham(images, columns, rows):
    """It knows square boards only: every other one it cannot find."""
    if columns != rows:
        return None
    wall, cpu, done = timed(["mrgingham", "--jobs", str(WORKERS), "--gridn", str(columns), *map(str, images)])
    lines = [line.split() for line in done.stdout.decode().splitlines() if not line.startswith("#")]
    found = {}
    for words in lines:
        if words[1] != "-":
            found[words[0]] = found.get(words[0], 0) + 1
    return wall, cpu, float("nan"), [found.get(str(path), 0) for path in images]


def data_sets(data):
    """name, images, columns and rows of inner corners, target, detectors."""
    boards = {
        "findChessboardCorners + cornerSubPix": chessboard_classic,
        "findChessboardCornersSB": chessboard_sb_plain,
        "findChessboardCornersSB EXHAUSTIVE ACCURACY": chessboard_sb,
        "classic, then SB where it fails": chessboard_either,
    }
    tags = {"ArucoDetector, two-bit border": aruco_two_bit, "pupil-apriltags": pupil}
    kinds = {".png", ".jpg", ".jpeg", ".bmp", ".pgm"}

    def images(folder):
        return sorted(path for path in (data / folder).rglob("*") if path.suffix.lower() in kinds)

    yield "sourishg_fisheye_stereo", images("sourishg_fisheye_stereo"), 9, 6, "chessboard:9x6:24.23mm", boards
    yield "camodocal_fisheye", images("camodocal_fisheye"), 9, 6, "chessboard:9x6:120mm", boards
    yield "opencv_stereo_chess", images("opencv_stereo_chess"), 9, 6, "chessboard:9x6:25mm", boards
    yield "euroc_april", images("euroc_april"), 6, 6, "aprilgrid:6x6:88mm:0.3", tags


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=2)
    parser.add_argument("--sets", default="", help="only sets whose names hold this")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    options = parser.parse_args()
    data = pathlib.Path(os.environ.get("RAYBUNDLE_DATA", ROOT.parent / "shared" / "data")).resolve()
    if not data.is_dir():
        sys.exit(f"{data} is not there: RAYBUNDLE_DATA names the folder with the real images")
    lines = [
        "## Detection",
        "",
        f"`./dev bench detection`: two workers on two cores, from image files to corners; the best of {options.repetitions} runs in "
        "turn. Images per second of wall time and of processor time (two workers: up to twice that), both without the start of "
        "program or interpreter; memory of all workers, images in which the board was found, corners. OpenCV is PyPI's "
        f"{cv2.__version__}; Debian's stands above.",
        "",
        "| images | detector | images/s | images/cpu s | MB | found | corners |",
        "|---|---|---|---|---|---|---|",
    ]
    verdicts = []
    for name, images, columns, rows, target, functions in data_sets(data):
        if options.sets not in name or not images:
            continue
        best = {}
        for _ in range(options.repetitions):
            runs = {"raybundle detect": lambda: raybundle(options.build, images, target)}
            runs |= {label: lambda f=function: measure_function(f, images, columns, rows) for label, function in functions.items()}
            runs["mrgingham"] = lambda: mrgingham(images, columns, rows)
            for label, run in runs.items():
                figures = run()
                if figures and (label not in best or figures[1] < best[label][1]):
                    best[label] = figures
        for label, (wall, cpu, peak, found) in best.items():
            seen = sum(count > 0 for count in found)
            row = f"| {name}, {len(images)} | {label} | {len(images) / wall:.1f} | {len(images) / cpu:.1f} | {peak:.0f} | {seen} | {sum(found)} |"
            lines.append(row)
            print(row, flush=True)
        ours = best["raybundle detect"]
        seen = lambda figures: sum(count > 0 for count in figures[3])
        peer = max((label for label in best if label != "raybundle detect"), key=lambda l: (seen(best[l]), -best[l][1]))
        faster = best[peer][1] / ours[1]
        more = seen(ours) > seen(best[peer]) or seen(ours) == len(images)
        passed = faster >= 2 and more
        verdicts.append(f"- {'passed' if passed else 'FAILED'}: {name}: {faster:.2f}× the images per second of processor time of the "
                        f"detector that finds most ({peer}), bar 2×; found {seen(ours)}, it {seen(best[peer])}, bar: more, or all")
    (WORK / "detection.md").write_text("\n".join([*lines, "", *verdicts, ""]))
    print("\n".join(verdicts))


if __name__ == "__main__":
    main()
