# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0
"""The bars that the solve is held against, judged on the figures of one run."""

import math
import statistics

import run_draws
from run_peers import TWO_CORES

OWN = ("raybundle, plain", "raybundle", "raybundle, flat board", "raybundle program")
PLAIN, WHOLE = "raybundle, plain", "raybundle"  # start and least squares, as the peers; all that calibrate() does


def median(by_peer, peer, key):
    """Median of a figure over the runs of a peer; None when it did not finish."""
    runs = by_peer.get(peer) or []
    if not runs or any("failed" in run for run in runs):
        return None
    return statistics.median(run[key] for run in runs)


def verdict(what, figure, bar, passed):
    return f"{'passed' if passed else 'FAILED'}: {what}: {figure}, bar {bar}"


def not_measured(what, bar):
    """A bar does not go away with its figure."""
    return verdict(what, "not measured", bar, False)


def time_of(by_peer, peer):
    """A peer's time on a problem, median: the processor's on one core, on two that on the wall."""
    return median(by_peer, peer, "wall_s" if peer.endswith(TWO_CORES) else "cpu_s")


def stopped_after(by_peer, peer):
    """What a peer that was stopped had taken by then, on the clock of time_of; None where that is not known.

    The limit is of processor time, of which two cores spend up to twice what passes on the wall.
    """
    run = (by_peer.get(peer) or [{}])[0]
    if not str(run.get("failed", "")).startswith(">"):
        return None
    return run.get("process_wall_s") if peer.endswith(TWO_CORES) else by_peer["truth"]["limit_s"]


def ratio_of_times(by_peer, peer, own):
    """How many times the peer's time is ours, and that as text; nothing where either is not known."""
    ours, theirs, more = time_of(by_peer, own), time_of(by_peer, peer), ""
    if theirs is None:
        theirs, more = stopped_after(by_peer, peer), "more than "
    return (theirs / ours, f"{more}{theirs / ours:.1f}×") if ours and theirs else None


def faster(results, problem, peer, bar):
    """On two cores what does the peers' work is judged; one thread, and what does much more besides, are told.

    Without a bar all is told. A peer without a figure is told, too; we have to have one.
    """
    by_peer = results.get(problem, {})
    out = []
    for their, own in ((peer + TWO_CORES, PLAIN + TWO_CORES), (peer, PLAIN), (peer, WHOLE)):
        found = ratio_of_times(by_peer, their, own)
        what = f"{problem} views, time of {their} over that of {own}"
        judged = bar and own.endswith(TWO_CORES)
        if judged and time_of(by_peer, own) is None:
            out.append(not_measured(what, f"{bar}×"))
        elif judged and found:
            out.append(verdict(what, found[1], f"{bar}×", found[0] >= bar))
        elif judged or found:
            out.append(f"information: {what}: {found[1] if found else 'the peer has no figure'}")
    return out


def growth(results, family, own):
    what = f"{family}, growth of the time of {own} with the views, fitted exponent"
    times = {
        int(name.split(" ")[1]): median(by_peer, own, "cpu_s")
        for name, by_peer in results.items()
        if name.split(" ")[0] == family and len(name.split(" ")) == 2
    }
    if len(times) < 3 or None in times.values():
        return [not_measured(what, "1.05")]
    x, y = ([math.log(value) for value in side] for side in (times, times.values()))
    slope = statistics.linear_regression(x, y).slope
    return [verdict(what, f"{slope:.3f}", "1.05", slope <= 1.05)]


def memory(results, problem):
    by_peer = results.get(problem, {})
    out = []
    for peer in OWN:
        what = f"{problem} views, peak memory of {peer}"
        peak = median(by_peer, peer, "peak_mb")
        if peak is None:
            out.append(not_measured(what, "50 MB and 200 bytes for each corner"))
            continue
        corners = by_peer["truth"]["views"] * by_peer["truth"]["rows"] * by_peer["truth"]["columns"]
        bar = 50 + 200 * corners / 2**20
        out.append(verdict(what, f"{peak:.0f} MB", f"{bar:.0f} MB", peak <= bar))
    return out


def costs_at_most(results, problem, plain, factor):
    slow = median(results.get(problem, {}), "raybundle", "cpu_s")
    fast = median(results.get(plain, {}), "raybundle, flat board", "cpu_s")
    what = f"{problem}, time against the flat board without outliers"
    if not slow or not fast:
        return [not_measured(what, f"{factor}×")]
    return [verdict(what, f"{slow / fast:.2f}×", f"{factor}×", slow <= factor * fast)]


def on_one_draw(results):
    """Against peers of the same model, on the one draw that was timed: the worse estimator wins many of these."""
    compared = worse = 0
    for name, by_peer in results.items():
        for own, peer in run_draws.rivals(name):
            ours, theirs = (run_draws.true_error((by_peer.get(who) or [{}])[0]) for who in (own, peer))
            if ours is None or theirs is None:
                continue
            compared += 1
            worse += ours > run_draws.SLACK * theirs
    what = "true error on the one draw of the noise that was timed, above that of a peer with the same model"
    return [f"information: {what}: {worse} of {compared} comparisons"]


def judge(results, draws):
    """Verdicts on the timed runs of run_peers.py and on the draws of run_draws.py."""
    lines = []
    for problem, peer, bar in (
        ("kb130 200", "opencv 4.6", 100),
        ("kb130 200", "opencv 5", 100),
        ("kb130 200", "mrcal opencv8", 100),
        ("rational70 200", "mrcal opencv8", 100),
        ("rational70 200", "opencv 4.6", None),  # calibrateCamera, of which no bar speaks
        ("rational70 200", "opencv 5", None),
        ("kb130 200", "pycolmap", 5),
        ("rational70 200", "pycolmap", 5),
        ("stereo_kb130 200", "pycolmap", 5),
        ("rig4_kb130 200", "pycolmap", 5),
    ):
        lines += faster(results, problem, peer, bar)
    for family in ("kb130", "rational70"):
        for own in (PLAIN, WHOLE):
            lines += growth(results, family, own)
        lines += memory(results, f"{family} 5000")
        lines += costs_at_most(results, f"{family} 200 outliers", f"{family} 200", 2)
        lines += costs_at_most(results, f"{family} 200 bent", f"{family} 200", 2)
    lines += on_one_draw(results) + run_draws.verdicts(draws)
    for problem in run_draws.PROBLEMS:
        if problem not in draws:
            lines.append(not_measured(f"{problem} views, true error over draws of the noise", run_draws.SLACK))
    return lines
