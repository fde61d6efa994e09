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


def aruco_two_bit():
    parameters = cv2.aruco.DetectorParameters()
    parameters.markerBorderBits = 2
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36H11), parameters)
    return lambda job: 4 * len(detector.detectMarkers(grey(job[0]))[0])


def pupil():
    import pupil_apriltags

    detector = pupil_apriltags.Detector(families="tag36h11")
    return lambda job: 4 * len(detector.detect(grey(job[0])))


def start_worker(make, all_started):
    """What is paid once: the detector, and that OpenCV keeps to one thread."""
    global detect
    cv2.setNumThreads(1)
    detect = make()
    all_started.wait()


def run_job(job):
    return detect(job)


def measure_function(make, images, columns, rows):
    """Seconds, and corners found in each image; two processes, as the program has two threads."""
    jobs = [(str(path), columns, rows) for path in images]
    all_started = multiprocessing.Barrier(WORKERS + 1, timeout=60)
    with multiprocessing.Pool(WORKERS, initializer=start_worker, initargs=(make, all_started)) as pool:
        all_started.wait()
        begin, before = time.perf_counter(), children_cpu_s(pool)
        found = pool.map(run_job, jobs, chunksize=1)
        wall, cpu = time.perf_counter() - begin, children_cpu_s(pool) - before
        peak = sum(peak_of(worker.pid) for worker in pool._pool)
    return wall, cpu, peak, found


def children_cpu_s(pool):
    """Processor time that the workers have used so far; finer than the kernel's ticks, of which two images take few."""
    tasks = [task for worker in pool._pool for task in pathlib.Path(f"/proc/{worker.pid}/task").iterdir()]
    return 1e-9 * sum(int((task / "schedstat").read_text().split()[0]) for task in tasks)


def peak_of(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) / 1024
    return 0.0


# Runs a command and then says what it took. A process begins with the peak memory of the one that it was started from,
# and this one, with OpenCV in it, is larger than what it measures.
LAUNCHER = """
import os, sys, time
begin = time.perf_counter()
_, status, usage = os.wait4(os.posix_spawnp(sys.argv[1], sys.argv[1:], os.environ), 0)
print(time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, file=sys.stderr)
sys.exit(os.waitstatus_to_exitcode(status))
"""


def timed(command):
    """Seconds on the wall, of the processor, peak MB, and what the process printed; stops when it fails."""
    launched = [sys.executable, "-I", "-S", "-c", LAUNCHER, *map(str, command)]
    done = subprocess.run(launched, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    wall, cpu, peak = map(float, done.stderr.splitlines()[-1].split())
    return wall, cpu, peak, done.stdout


def raybundle(build, images, target):
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        listed = pathlib.Path(folder) / "images"
        listed.mkdir()
        for number, path in enumerate(images):  # one camera, frames by number
            (listed / f"image{number:04d}{path.suffix}").symlink_to(path)
        output = pathlib.Path(folder) / "observations.json"
        command = [build / "raybundle", "detect", "--target", target, "--camera", f"camera={listed}/*", "--threads",
                   str(WORKERS), "--no-cache", "-o", output]
        starts = [timed([build / "raybundle", "--version"])[:2] for _ in range(3)]  # the first may wait for the disk
        start_wall, start_cpu = min(wall for wall, _ in starts), min(cpu for _, cpu in starts)
        wall, cpu, peak, _ = timed(command)
        wall, cpu = wall - start_wall, cpu - start_cpu
        views = json.loads(output.read_text())["views"]
    found = [len(view["points"]) for view in views]
    return wall, cpu, peak, found + [0] * (len(images) - len(found))


def mrgingham(images, columns, rows, target):
    """It knows square chessboards only: every other board it cannot find."""
    if columns != rows or not target.startswith("chessboard:"):
        return None
    wall, cpu, peak, text = timed(["mrgingham", "--jobs", WORKERS, "--gridn", columns, *images])
    lines = [line.split() for line in text.splitlines() if not line.startswith("#")]
    found = {}
    for words in lines:
        if words[1] != "-":
            found[words[0]] = found.get(words[0], 0) + 1
    return wall, cpu, peak, [found.get(str(path), 0) for path in images]


def data_sets(data):
    """name, images, columns and rows of inner corners, target, what makes the detectors, once for each worker."""
    boards = {
        "findChessboardCorners + cornerSubPix": chessboard_classic,
        "findChessboardCornersSB": chessboard_sb_plain,
        "findChessboardCornersSB EXHAUSTIVE ACCURACY": chessboard_sb,
        "classic, then SB where it fails": chessboard_either,
    }
    boards = {label: lambda function=function: function for label, function in boards.items()}
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
    for name, images, columns, rows, target, makers in data_sets(data):
        if options.sets not in name:
            continue
        if not images:
            verdicts.append(f"- FAILED: {name}: not measured, its images are not in {data.name}")
            continue
        best = {}
        for _ in range(options.repetitions):
            runs = {"raybundle detect": lambda: raybundle(options.build, images, target)}
            runs |= {label: lambda m=make: measure_function(m, images, columns, rows) for label, make in makers.items()}
            runs["mrgingham"] = lambda: mrgingham(images, columns, rows, target)
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
