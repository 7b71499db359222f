"""Times of the package on this machine: ``python host-tests/python/benchmark.py SET``.

``SET`` is a generated data set: ``cargo selfcal synth near --pairs 21 --outliers 0.3 --rotation 3,-2,4 --baseline 3,-3
--out SET``. 20 of its pairs lock a calibrator, and the last one is timed, as ``cargo bench -p evidence --bench
stages`` times the calls of the core alone.
"""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

import stereo_selfcal as sc

RUNS = 300
MANY = 10_000


def main(folder: Path) -> None:
    given = sc.read_rig(folder)
    rig = sc.Rig(given.left, given.right)
    rows = [np.loadtxt(path, delimiter=",", skiprows=1) for path in sorted((folder / "pairs").glob("*.csv"))]
    pairs = [(pair[:, :2].astype(np.float32), pair[:, 2:4].astype(np.float32)) for pair in rows]
    *locking, last = pairs
    times = []
    for _ in range(RUNS):
        calibrator = sc.Calibrator(rig)
        for pair in locking:
            calibrator.fuse(*pair)
        start = perf_counter()
        calibrator.fuse(*last)
        times.append(perf_counter() - start)
    print(f"fuse, a pair of a locked rig, {len(last[0])} matches: {1e6 * median(times):.2f} us")
    many = [pairs[i % len(pairs)] for i in range(MANY)]
    sc.solve_pairs(rig, many[:100])
    start = perf_counter()
    solved = sc.solve_pairs(rig, many)
    seconds = perf_counter() - start
    count = sum(result.fused is not None for result in solved)
    print(f"solve_pairs, {MANY} pairs: {seconds:.2f} s, {MANY / seconds:.0f} a second, {count} solved")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
