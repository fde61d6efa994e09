# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""Makes docs/benchmarks.md and docs/benchmarks.svg of build/peers/*.json, and says which bars are met.

usage: report.py [--docs FOLDER]
"""

import argparse
import json
import math
import pathlib
import platform
import re
import statistics
import subprocess

import bars
import run_draws
import run_peers

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "peers"
LICENCE = "<!-- SPDX-FileCopyrightText: The Raybundle authors -->\n<!-- SPDX-License-Identifier: Apache-2.0 -->\n"


def machine():
    cpu = next(line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name"))
    cores = subprocess.run(["nproc"], capture_output=True, text=True).stdout.strip()
    compiler = subprocess.run(["c++", "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    system = next(line.split("=")[1].strip().strip('"') for line in open("/etc/os-release") if line.startswith("PRETTY_NAME"))
    kernel = platform.release().split("-")[0]
    return f"{cpu}, {cores} cores, {system}, Linux {kernel}, {compiler}"


def seconds_text(seconds):
    return f"{1e3 * seconds:.1f} ms" if seconds < 0.1 else f"{1e3 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.1f} s"


def ratio_text(ratio):
    return f"{ratio:.2f}×" if ratio < 10 else f"{ratio:,.0f}×"


def time_cell(by_peer, peer):
    runs = by_peer.get(peer)
    if not runs:
        return ""
    if "failed" in runs[0]:
        return runs[0]["failed"] if runs[0]["failed"].startswith(">") else "failed"
    seconds, ours = bars.time_of(by_peer, peer), bars.median(by_peer, "raybundle", "cpu_s")
    return f"{seconds_text(seconds)} ({ratio_text(seconds / ours)})" if ours else seconds_text(seconds)


def error_cell(by_peer, peer):
    runs = by_peer.get(peer)
    if not runs or "failed" in runs[0]:
        return ""
    cameras = runs[0]["cameras"]
    if any(camera["true_error_rms_px"] is None for camera in cameras):
        return "projects nothing"
    root = math.sqrt(statistics.mean(camera["true_error_rms_px"] ** 2 for camera in cameras))
    lost = sum(camera["unprojectable"] for camera in cameras)
    return f"{root:.4f} / {max(c['true_error_max_px'] for c in cameras):.3f}" + (f", {lost} lost" if lost else "")


def memory_cell(by_peer, peer):
    runs = by_peer.get(peer)
    if not runs or "failed" in runs[0]:
        return ""
    return f"{bars.median(by_peer, peer, 'peak_mb'):.0f} ({statistics.median(r['peak_mb'] - r['before_mb'] for r in runs):.0f})"


def extrinsics_cell(by_peer, peer):
    runs = by_peer.get(peer)
    if not runs or "failed" in runs[0] or not runs[0].get("extrinsics"):
        return ""
    errors = runs[0]["extrinsics"]
    return f"{max(e['place_mm'] for e in errors):.3f} mm / {max(e['rotation_deg'] for e in errors):.4f}°"


def table(results, names, cell, last_row=None):
    """Rows: the peers that did any of these problems; columns: the problems, by what follows the family's name."""
    seen = [peer for name in names for peer in results[name] if peer != "truth"]
    order = list(dict.fromkeys(seen))
    lines = ["| | " + " | ".join(name.split(" ", 1)[1] for name in names) + " |", "|---" * (len(names) + 1) + "|"]
    for peer in order:
        lines.append(f"| {peer} | " + " | ".join(cell(results[name], peer) for name in names) + " |")
    if last_row:
        lines.append(f"| **{last_row[0]}** | " + " | ".join(last_row[1](results[name]) for name in names) + " |")
    return "\n".join(lines) + "\n"


def bound_text(by_peer):
    def root(key):
        return math.sqrt(statistics.mean(c[key] ** 2 for c in by_peer["truth"]["cameras"]))

    return f"{root('bound_rms_px'):.4f}, bent {root('bound_with_shape_rms_px'):.4f}"


def plot(results, path):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "raybundle"
    import matplotlib.pyplot as plt

    families = ["kb130", "rational70"]
    figure, axes = plt.subplots(1, len(families), figsize=(11, 4.6), sharey=True)
    for axis, family in zip(axes, families):
        lines = {}
        for name, by_peer in results.items():
            if name.split(" ")[0] != family or len(name.split(" ")) != 2:
                continue
            for peer in by_peer:
                one_core = peer != "truth" and not peer.endswith(run_peers.TWO_CORES)
                seconds = bars.median(by_peer, peer, "cpu_s") if one_core else None
                if seconds:
                    lines.setdefault(peer, []).append((int(name.split(" ")[1]), seconds))
        for peer, points in lines.items():
            ours = peer.startswith("raybundle")
            axis.plot(*zip(*sorted(points)), marker="o", ms=4, lw=2.4 if ours else 1.2, label=peer, ls="-" if ours else "--")
        axis.set(xscale="log", yscale="log", xlabel="views of 14 × 10 corners", title=family)
        axis.grid(True, which="both", lw=0.3)
    axes[0].set_ylabel("processor time of one calibration [s]")
    for axis in axes:
        axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None, "Creator": None})


def asked(results):
    said = {}
    for by_peer in results.values():
        for peer, runs in by_peer.items():
            if peer != "truth" and runs and "asked" in runs[0]:
                said.setdefault(peer, runs[0]["asked"])
    failures = {}
    for name, by_peer in results.items():
        for peer, runs in by_peer.items():
            if peer != "truth" and runs and "failed" in runs[0] and not runs[0]["failed"].startswith(">"):
                failures.setdefault((peer, runs[0]["failed"]), []).append(name)
    lines = [f"- **{peer}**: {text}." for peer, text in said.items()]
    if failures:
        lines += ["", "What failed, in the words of the peer:", ""]
        lines += [f"- {peer} on {', '.join(names)}: `{why}`" for (peer, why), names in failures.items()]
    return "\n".join(lines) + "\n"


INTRODUCTION = """# Benchmarks beside the peers

Written by `./dev bench peers`{full} on {machine}. The machine may have had other work: figures are **processor time** of
one calibration on one thread, from observations in memory, start values included (pycolmap has none: it is given a start
near the truth), and where a name says two cores, what passed on the wall; medians of runs in which the peers took turns, each
run a process of its own; in brackets the ratio to `raybundle`. `>` means that the solve was stopped, or by its smaller sizes
would have been.

Problems come from one generator (`bench/peers/generate_problem.cpp`): boards of 14 × 10 corners, 25 mm, seen whole, 0.3 px
noise, 1280 × 960 images; `kb130` and `kb150` are Kannala-Brandt lenses with 130° and 150° across the image, `rational70` a
rational one with 70°; `outliers`: 1 % of the corners are off by 5 to 50 px; `bent`: the board sags by 1 mm. Columns are
numbers of views (frames for pairs and rigs).

**True error**: every peer projects the true rays of a grid over the image as far as boards covered it; the best rotation of
the rays, which board poses take up, is removed; rms / largest distance to the true pixels. **Bound**: the Cramér-Rao bound of
that rms from the information of all corners at the truth, when the board is known to be flat, and when its bend is estimated
too. One draw of the noise lies around the bound, and the better of two estimators is often the worse on it: averages over many
draws, ours against the bound and against peers with the same model, are among the bars. `raybundle` is `calibrate()`: outliers,
other optima, the bend where the data can carry it, sigmas; `raybundle, flat board` is that without the bend; `raybundle, plain` is
start values and least squares only, which is what most peers do; OpenCV and pycolmap take the board as flat, mrcal and lensboy estimate it.
**Memory**: peak of the process in MB, in brackets what the solve added to it.

![Processor time against views](benchmarks.svg)
"""


# What other programs of bench/ printed in the same run, and whether they judge it.
OTHER_PROOFS = (
    ("True error against the bound, over many draws of the noise", "true_error.txt", True),
    ("Start values against one plain solve from them", "start.txt", True),
    ("The bundle alone: a hand-written limit, growth, threads, what else it may have to do", "bundle.txt", True),
    ("Detectors on one thread beside Debian's OpenCV", "detect.txt", False),
    ("A laser of 304 beams beside a camera", "laser.txt", True),
)


def all_bars(results):
    """The bars judged on this run's figures, and those that the other programs judged themselves."""
    stored = run_draws.STORED
    lines = bars.judge(results, json.loads(stored.read_text()) if stored.exists() else {})
    for _, name, judges in OTHER_PROOFS:
        text = (WORK / name).read_text() if (WORK / name).exists() else ""
        proof, verdicts = name.removesuffix(".txt"), []
        for line in text.splitlines():
            verdict = re.search(r"passed|holds|FAILED|MISSED", line)
            if verdict:
                passed = verdict.group() in ("passed", "holds")
                verdicts.append(f"{'passed' if passed else 'FAILED'}: {proof}: {' '.join(line.split())}")
        lines += verdicts or ([f"FAILED: {proof}: not measured"] if judges else [])
    return lines


def coverage(results, full):
    """How many runs a figure stands on, and what was left out of the problems of the command."""
    counts = [len(runs) for by_peer in results.values() for peer, runs in by_peer.items() if peer != "truth"]
    missing = [name for name in run_peers.problems(full) if name not in results]
    absent = [peer for peer in run_peers.peers(ROOT) if not any(peer in by_peer for by_peer in results.values())]
    text = f"Each time is the median of {min(counts)} to {max(counts)} runs; an empty cell was not run."
    for what, names in (("problems", missing), ("peers", absent)):
        if names:
            text += f" This page was made of a narrowed run, without the {what} {', '.join(names)}."
    return text + "\n"


def page(results):
    full = any(by_peer["truth"].get("full") for by_peer in results.values())
    parts = [LICENCE + INTRODUCTION.format(full=" --full" if full else "", machine=machine())]
    parts.append(coverage(results, full))
    parts.append("## Bars\n\n" + "\n".join(f"- {line}" for line in all_bars(results)) + "\n")
    for family in dict.fromkeys(name.split(" ")[0] for name in results):
        names = [name for name in results if name.split(" ")[0] == family]
        parts.append(f"## {family}\n\nProcessor time\n\n" + table(results, names, time_cell))
        parts.append("True error, rms / largest [px]\n\n" + table(results, names, error_cell, ("bound", bound_text)))
        if len(results[names[0]]["truth"]["cameras"]) > 1:
            parts.append("Worst place / rotation of a camera against the first\n\n" + table(results, names, extrinsics_cell))
        parts.append("Memory [MB]\n\n" + table(results, names, memory_cell))
    parts.append("## What each was asked for\n\n" + asked(results))
    for heading, name, _ in OTHER_PROOFS:
        if (WORK / name).exists():
            parts.append(f"## {heading}\n\n```\n{(WORK / name).read_text()}```\n")
    detection = WORK / "detection.md"
    if detection.exists():
        parts.append(detection.read_text())
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--docs", type=pathlib.Path, default=ROOT / "docs")
    options = parser.parse_args()
    results = json.loads((WORK / "results.json").read_text())
    plot(results, options.docs / "benchmarks.svg")
    (options.docs / "benchmarks.md").write_text(page(results))
    for line in all_bars(results):
        print(line)
    print(f"the whole: {options.docs / 'benchmarks.md'}")


if __name__ == "__main__":
    main()
