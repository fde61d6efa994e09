# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""Raybundle and its peers on the same observations: time, memory, true error. `./dev bench peers` calls it.

Every solve is a process of its own, on one thread unless its name says two cores, and the peers take turns. A peer that is too slow for a size is left
out of the larger ones, and the table says so. Results lie in build/peers/results.json; report.py makes the page of them.
"""

import argparse
import json
import math
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time

import problem

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
WORK = ROOT / "build" / "peers"
SHORT_S, SHORT_RUNS = 0.02, 10  # solves that are over so soon are run so often, or chance decides what they take
TWO_CORES = ", two cores"  # ends the name of a peer that may use them; its figure is the time on the wall
DEBIAN = "/usr/bin/python3"
PYPI = str(WORK / "venv" / "bin" / "python")


def problems(full):
    """name -> arguments of generate_problem; name is FAMILY FRAMES [what is special]."""
    named = {}

    def add(family, frames, special="", *flags):
        named[f"{family} {frames}{' ' + special if special else ''}"] = ["--family", family, "--frames", str(frames), *flags]

    outliers, bend = ("outliers", "--outliers", "0.01"), ("bent", "--bend-m", "0.001")
    for family in ("kb130", "rational70", "kb150"):
        for frames in (20, 50, 200, 1000, 5000):
            if full or family != "kb150" or frames in (20, 200):
                add(family, frames)
            if full or (frames == 200 and family != "kb150"):
                add(family, frames, *outliers)
                add(family, frames, *bend)
                add(family, frames, "bent+outliers", *outliers[1:], *bend[1:])
    for family in ("stereo_kb130", "stereo_rational70", "rig4_kb130"):
        for frames in (20, 50, 200, 1000) if full else (50, 200):
            add(family, frames)
    return named


def peers(build):
    """name -> (command before FOLDER RESULT, arguments after, which problems it can do).

    And the most frames that it is given without --full, where it alone would take longer than all others together.
    """
    ours, script = str(build / "solve_raybundle"), lambda name: str(HERE / name)
    barred = r"^(kb130|rational70|stereo_kb130|rig4_kb130) 200$"  # where bars of speed stand
    every, plain = ".", r"^(kb130|kb150|rational70) \d+$"
    most = 10**6
    return {
        "raybundle": ([ours], [], every, most),
        "raybundle, plain": ([ours], ["--plain"], r"^\w+ \d+$", most),
        "raybundle, plain" + TWO_CORES: ([ours], ["--plain", "--threads", "2"], barred, most),
        "raybundle, flat board": ([ours], ["--estimate-shape", "false"], every, most),
        "raybundle program": ([sys.executable, script("peer_program.py"), str(build / "raybundle")], [], every, most),
        "opencv 4.6": ([DEBIAN, script("peer_opencv.py")], [], "^(?!rig)", 200),
        "opencv 4.6" + TWO_CORES: ([DEBIAN, script("peer_opencv.py")], [], "^kb130 200$", 200),
        "opencv 4.6, focal given": ([DEBIAN, script("peer_opencv.py")], ["focal"], r"^(stereo_)?kb\d+ \d+$", 50),
        "opencv 5": ([PYPI, script("peer_opencv.py")], [], every, 200),
        "opencv 5" + TWO_CORES: ([PYPI, script("peer_opencv.py")], [], "^(kb130|rational70) 200$", 200),
        "mrcal opencv8": ([DEBIAN, script("peer_mrcal.py")], ["opencv8"], every, 200),
        "mrcal opencv8" + TWO_CORES: ([DEBIAN, script("peer_mrcal.py")], ["opencv8"], "^(kb130|rational70) 200$", 200),
        "mrcal splined": ([DEBIAN, script("peer_mrcal.py")], ["splined"], r"^kb\d+ \d+$", 50),
        "mrcal program": ([sys.executable, script("peer_mrcal_program.py")], [], r"^rational70 \d+$", 50),
        "pycolmap": ([PYPI, script("peer_pycolmap.py")], [], every, 200),
        "pycolmap" + TWO_CORES: ([PYPI, script("peer_pycolmap.py")], [], barred, 200),
        "lensboy": ([PYPI, script("peer_lensboy.py")], [], plain + r"|^(kb130|rational70) \d+ bent\+outliers", 200),
        "multical": ([str(WORK / "multical" / "bin" / "python"), script("peer_multical.py")], [], "^rational70", 50),
    }


def threads_in_environment(peer):
    count = "2" if peer.endswith(TWO_CORES) else "1"
    return {name: count for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


def run_once(command, limit_s, peer=""):
    """One solve: the figures that the peer wrote, or {"failed": why}. The limit is of processor time."""
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        result = pathlib.Path(folder) / "result.json"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        begin = time.perf_counter()
        try:
            done = subprocess.run(
                [*command[0], str(result), *command[1]],
                env={**os.environ, **threads_in_environment(peer)},
                capture_output=True,
                timeout=10 * limit_s,
                cwd=folder,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit_s), math.ceil(limit_s) + 1)),
            )
        except subprocess.TimeoutExpired:
            return {"failed": f"> {limit_s:.0f} s", "process_wall_s": 10 * limit_s, "process_cpu_s": limit_s}
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        process = {
            "process_wall_s": time.perf_counter() - begin,
            "process_cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        }
        if -done.returncode in (signal.SIGXCPU, signal.SIGKILL):
            return {"failed": f"> {limit_s:.0f} s", **process}
        if done.returncode or not result.exists():
            lines = [line for line in done.stderr.decode(errors="replace").splitlines() if line.strip()]
            return {"failed": lines[-1][:200] if lines else f"exit code {done.returncode}", **process}
        return {**json.loads(result.read_text()), **process}


def predicted_s(results, problem, peer):
    """What the peer will take at least, from the next smaller size of the same family; None when that is not known."""
    family, frames, *special = problem.split(" ")
    smaller = [int(name.split(" ")[1]) for name in results if name.split(" ")[0] == family and name.split(" ")[2:] == []]
    smaller = [n for n in smaller if n < int(frames) or (special and n <= int(frames))]
    if not smaller:
        return None
    runs = results[f"{family} {max(smaller)}"].get(peer)
    if not runs:
        return float("inf") if max(smaller) < int(frames) and peer_was_too_slow(results, family, peer) else None
    if str(runs[0].get("failed", "")).startswith(">"):
        return float("inf")
    return min(run["process_cpu_s"] for run in runs) * int(frames) / max(smaller)


def peer_was_too_slow(results, family, peer):
    return any(
        str(run.get("failed", "")).startswith(">")
        for name, by_peer in results.items()
        if name.split(" ")[0] == family
        for run in by_peer.get(peer, [])
    )


def measure(name, folder, results, options):
    """All peers in turn, again and again: what disturbs the machine then disturbs all of them."""
    frames = int(name.split(" ")[1])
    spent = {}
    by_peer = results.setdefault(name, {})
    for peer in [peer for peer in by_peer if peer != "truth" and re.search(options.peers, peer)]:
        del by_peer[peer]
    for repetition in range(max(options.repetitions, SHORT_RUNS)):
        for peer, (command, arguments, able, most) in peers(options.build).items():
            if not re.search(options.peers, peer) or not re.search(able, name):
                continue
            if frames > most and not options.full:
                continue
            runs = by_peer.setdefault(peer, [])
            if repetition >= options.repetitions and not all(run.get("wall_s", 1) < SHORT_S for run in runs):
                continue
            if any("failed" in run for run in runs) or (runs and spent[peer] * (1 + 1 / len(runs)) > options.budget_s):
                continue
            predicted = predicted_s(results, name, peer)
            if not runs and predicted is not None and predicted > options.limit_s:
                by_peer[peer] = [{"failed": f"> {options.limit_s:.0f} s (foreseen)"}]
                continue
            run = run_once(([*command, str(folder)], arguments), options.limit_s, peer)
            add_extrinsics(run, folder)
            runs[:] = [run] if "failed" in run else [*runs, run]
            spent[peer] = spent.get(peer, 0) + run["process_cpu_s"]
            told = run.get("failed") or f"{1e3 * run['cpu_s']:.1f} ms cpu, {1e3 * run['wall_s']:.1f} ms wall"
            if repetition == 0:
                print(f"  {peer:24s} {told}", flush=True)


def add_extrinsics(run, folder):
    """Our own program writes places of cameras and the rotations that its true errors are without."""
    if "extrinsics" in run or "cameras" not in run:
        return
    places = [problem.matrix(problem.matrix_from_quaternion(c["rotation_xyzw"]), c["translation_m"]) for c in run["cameras"]]
    removed = [problem.matrix_from_quaternion(c["removed_rotation_xyzw"]) for c in run["cameras"]]
    known = json.loads((folder / "problem.json").read_text())["cameras"]
    run["extrinsics"] = problem.extrinsic_error(known, places, removed)


def problem_folder(name, flags, build):
    folder = WORK / "problems" / re.sub(r"[ +]", "_", name)
    program, wanted = build / "generate_problem", json.dumps(flags)
    made_of = folder / "flags.json"  # written last
    if made_of.exists() and made_of.read_text() == wanted and made_of.stat().st_mtime > program.stat().st_mtime:
        return folder
    made_of.unlink(missing_ok=True)
    subprocess.run([program, folder, *flags], check=True)
    made_of.write_text(wanted)
    return folder


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="every size with outliers and a bent board; slow peers up to 120 s")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--limit-s", type=float, help="of one solve; default 20, with --full 120")
    parser.add_argument("--budget-s", type=float, default=6, help="of all repetitions of one peer on one problem")
    parser.add_argument("--problems", default=".", help="regular expression of the problems' names")
    parser.add_argument("--peers", default=".", help="regular expression of the peers' names")
    parser.add_argument("--keep", action="store_true", help="results of earlier runs of other problems and peers")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    options = parser.parse_args()
    options.build = options.build.resolve()
    options.limit_s = options.limit_s or (120 if options.full else 20)
    stored = WORK / "results.json"
    results = json.loads(stored.read_text()) if options.keep and stored.exists() else {}
    wanted = {n: flags for n, flags in problems(options.full).items() if re.search(options.problems, n)}
    for count, (name, flags) in enumerate(wanted.items(), 1):
        print(f"[{count}/{len(wanted)}] {name}", flush=True)
        folder = problem_folder(name, flags, options.build)
        measure(name, folder, results, options)
        known = json.loads((folder / "problem.json").read_text())
        results[name]["truth"] = {k: v for k, v in known.items() if k != "frames"}
        results[name]["truth"] |= {"limit_s": options.limit_s, "full": options.full}
        stored.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
