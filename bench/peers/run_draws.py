# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""True error of Raybundle and of peers with the same model over many draws of the noise. `./dev bench peers` calls it.

On one draw the better estimator is often the worse one: what counts is the mean over draws that all of them were given.
Results lie in build/peers/draws.json.
"""

import argparse
import json
import math
import pathlib
import re
import statistics
import subprocess
import tempfile

import run_peers

STORED = run_peers.WORK / "draws.json"
OURS = "raybundle, flat board"
FLAT_PEERS = ("opencv 4.6", "opencv 5", "pycolmap")  # the same model of lens and a board that is known to be flat
BENT_PEERS = ("mrcal opencv8",)  # the same model where it is rational; its board may bend
TOO_SLOW = {"opencv 4.6"}  # for this many solves: the same least squares as opencv 5
PROBLEMS = (
    "kb130 20",
    "kb130 50",
    "rational70 20",
    "rational70 50",
    "kb150 20",
    "kb150 50",
    "stereo_kb130 20",
    "stereo_rational70 20",
    "rig4_kb130 20",
)
SLACK = 1.01  # solvers that stop at different tolerances differ by less


def rivals(problem):
    """(own, peer) of the comparisons that a problem allows."""
    family, _, *special = problem.split(" ")
    pairs = [("raybundle" if "bent" in " ".join(special) else OURS, peer) for peer in FLAT_PEERS]
    return pairs + ([("raybundle", peer) for peer in BENT_PEERS] if family.endswith("rational70") else [])


def true_error(run):
    """Root of the mean square over the cameras [px], None where a camera is not there or projects nothing."""
    errors = [camera["true_error_rms_px"] for camera in run.get("cameras", [])]
    if not errors or any(error is None or not math.isfinite(error) for error in errors):
        return None
    return math.sqrt(statistics.mean(error**2 for error in errors))


def draw(family, frames, seed, commands, options):
    """peer -> true error on one draw of the noise."""
    with tempfile.TemporaryDirectory(dir=run_peers.WORK) as folder:
        flags = ["--family", family, "--frames", frames, "--noise-seed", str(seed)]
        subprocess.run([options.build / "generate_problem", folder, *flags], check=True)
        return {
            peer: true_error(run_peers.run_once(([*command, folder], arguments), options.limit_s))
            for peer, (command, arguments) in commands.items()
        }


def compare(draws):
    """(problem, own, peer, ratio, its standard error, passed, draws, failures of own, of the peer) of every comparison.

    The ratio is that of the roots of the mean squared errors; it passes unless it lies above SLACK by more than two of
    its standard errors, which are those of the mean of the differences of the squares, draw by draw. The ratio is NaN
    where our own failures leave none; peers that leave none are not compared.
    """
    out = []
    for problem, by_peer in draws.items():
        for own, peer in rivals(problem):
            if own not in by_peer or peer not in by_peer:
                continue
            pairs = [(a, b) for a, b in zip(by_peer[own], by_peer[peer]) if a is not None and b is not None]
            failed = [sum(error is None for error in by_peer[name]) for name in (own, peer)]
            if len(pairs) < 2:
                if failed[0]:
                    out.append((problem, own, peer, math.nan, math.nan, False, len(pairs), *failed))
                continue
            theirs = statistics.mean(b**2 for _, b in pairs)
            ratio = math.sqrt(statistics.mean(a**2 for a, _ in pairs) / theirs)
            spread = statistics.stdev(a**2 - (ratio * b) ** 2 for a, b in pairs) / math.sqrt(len(pairs))
            sigma = spread / (2 * ratio * theirs)
            out.append((problem, own, peer, ratio, sigma, ratio - 2 * sigma <= SLACK, len(pairs), *failed))
    return out


def verdicts(draws):
    lines = []
    for problem, own, peer, ratio, sigma, passed, count, own_failed, peer_failed in compare(draws):
        lost = "".join(f", {n} of {name} failed" for n, name in ((own_failed, own), (peer_failed, peer)) if n)
        figure = "not measured" if math.isnan(ratio) else f"{ratio:.3f} ± {sigma:.3f}"
        lines.append(
            f"{'passed' if passed and not own_failed else 'FAILED'}: {problem} views, true error of {own} over that of {peer}, "
            f"{count} draws of the noise{lost}: {figure}, bar {SLACK}"
        )
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=24)
    parser.add_argument("--limit-s", type=float, default=20, help="of one solve")
    parser.add_argument("--problems", default=".", help="regular expression of the problems' names")
    parser.add_argument("--build", type=pathlib.Path, default=run_peers.ROOT / "build" / "release")
    options, _ = parser.parse_known_args()  # those of run_peers.py may stand beside them
    options.build = options.build.resolve()
    draws = {}
    for name in PROBLEMS:
        if not re.search(options.problems, name):
            continue
        wanted = {peer for pair in rivals(name) for peer in pair} - TOO_SLOW
        commands = {
            peer: (command, arguments)
            for peer, (command, arguments, able, _) in run_peers.peers(options.build).items()
            if peer in wanted and re.search(able, name)
        }
        print(f"{name}: {options.draws} draws of the noise for {', '.join(commands)}", flush=True)
        found = [draw(*name.split(" "), seed, commands, options) for seed in range(1, options.draws + 1)]
        draws[name] = {peer: [errors[peer] for errors in found] for peer in commands}
        STORED.write_text(json.dumps(draws, indent=1) + "\n")
        print("\n".join(f"  {line}" for line in verdicts({name: draws[name]})), flush=True)


if __name__ == "__main__":
    main()
