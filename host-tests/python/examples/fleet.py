# %% [markdown]
# # A fleet: one row for each recording
#
# Recordings are folders with ``meta.json`` and ``pairs/*.csv``. Dask judges them side by side: on the cores of this
# machine, or on the cluster of an address. Rows go into a CSV file as they are done, so a second run goes on where the
# first one stopped. A broken recording is a row with its error.
#
#     python fleet.py                                             # 50 made recordings
#     python fleet.py recordings/ --out fleet.csv --workers 8
#     python fleet.py recordings/ --scheduler tcp://10.0.0.1:8786  # the workers see the same files
#
# ``pip install stereo-selfcal[fleet]`` has what it needs. For Parquet: ``pandas.read_csv("fleet.csv").to_parquet(..)``.

# %%
import argparse
import csv
import json
import tempfile
import time
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from dask.distributed import Client, as_completed

import stereo_selfcal as sc

COLUMNS = "recording date rig pairs verdict may_arm rows_px depth_px coverage knocks reasons error".split()


# %% [markdown]
# ## One recording

# %%
def judge(folder):
    """The row of a recording: the calibrator runs as on a vehicle, from the rig's calibration."""
    folder = Path(folder)
    row = dict.fromkeys(COLUMNS, "") | {"recording": folder.name}
    try:
        files = sorted((folder / "pairs").glob("*.csv"))
        if not files:
            raise ValueError("no pairs/*.csv")
        date = datetime.fromtimestamp(files[-1].stat().st_mtime, timezone.utc)
        row |= {"date": date.isoformat(timespec="seconds"), "rig": read_name(folder)}
        calibrator = sc.Calibrator(sc.read_rig(folder / "meta.json"))
        knocks = []
        for number, file in enumerate(files):
            matches = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
            result = calibrator.fuse(matches[:, :2], matches[:, 2:4], matches[:, 4])
            if result.fused in ("renewed", "took_over"):
                knocks.append(number)
            if result.verdict.should_apply:
                calibrator.apply()
        verdict = calibrator.verdict
        row |= {
            "pairs": len(files),
            "verdict": verdict.text,
            "may_arm": verdict.may_arm,
            "rows_px": round(verdict.rows_px, 3),
            "depth_px": round(verdict.depth_px, 3),
            "coverage": round(verdict.coverage, 3),
            "knocks": " ".join(map(str, knocks)),
            "reasons": ", ".join([*verdict.reasons, *filter(None, [verdict.cause])]),
        }
    except Exception as error:  # any failure is the row of this recording, and the others go on
        row["error"] = f"{type(error).__name__}: {error}"
    return row


def read_name(folder):
    """Name of the rig, if the recording has one."""
    return json.loads((folder / "meta.json").read_text()).get("rig", "")


# %% [markdown]
# ## All recordings

# %%
def fleet(folders, out, client):
    """Judges the recordings that `out` does not have yet, and appends their rows."""
    done = {row["recording"] for row in read(out)} if out.exists() else set()
    todo = [str(folder) for folder in folders if folder.name not in done]
    with out.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if not done:
            writer.writeheader()
        for _, row in as_completed(client.map(judge, todo, pure=False), with_results=True):
            writer.writerow(row)
            file.flush()
    return len(todo)


def read(out):
    """The rows of a file."""
    with out.open(newline="") as file:
        return list(csv.DictReader(file))


def picture(rows, file):
    """Error of rows and of depth of each rig, by what the verdict permits, and the default limits."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4.5))
    for may_arm, color, name in (("True", "tab:green", "may arm"), ("False", "tab:red", "must not arm")):
        of = [row for row in rows if row["may_arm"] == may_arm]
        px = np.array([[float(row["rows_px"]), float(row["depth_px"])] for row in of]).reshape(-1, 2)
        axes.scatter(*np.clip(px, 0.013, 70).T, color=color, label=f"{name}: {len(of)}", alpha=0.7)
    broken = sum(bool(row["error"]) for row in rows)
    limits = (1e-2, 1e2)
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=limits, xlabel="rows in use, px", ylabel="expected error of disparities, px")
    axes.axvline(1, color="grey", linestyle=":")
    axes.axhline(2, color="grey", linestyle=":")
    axes.set_title(f"{len(rows)} recordings, {broken} broken")
    axes.legend()
    figure.savefig(file)


# %% [markdown]
# ## Made recordings
#
# Rigs that were knocked by up to a degree in mid recording, or not; the last one is broken.

# %%
def make(folder, count, pairs=16, matches=128):
    """Recordings of a pinhole rig."""
    rng = np.random.default_rng(1)
    focal, size = 700.0, np.array([1280, 720])
    camera = [[focal, 0, 639.5], [0, focal, 359.5], [0, 0, 1]]
    meta = {"width": 1280, "height": 720, "K_l": camera, "K_r": camera, "dist_l": [0] * 5, "dist_r": [0] * 5}
    meta |= {"R": np.eye(3).tolist(), "t": [-1, 0, 0], "baseline_m": 0.3, "calibrated": True}
    for number in range(count):
        recording = folder / f"flight_{number:03}"
        (recording / "pairs").mkdir(parents=True)
        (recording / "meta.json").write_text(json.dumps(meta | {"rig": f"rig {number % 10}"}))
        knock = rng.normal(scale=0.005, size=3) * (number % 2)
        for pair in range(pairs):
            left = rng.uniform(0, size, (4 * matches, 2))
            points = np.c_[(left - size / 2 + 0.5) / focal, np.ones(len(left))] * rng.uniform(3, 60, (len(left), 1))
            right = points + [-1, 0, 0]
            right += np.cross(knock, right) * (pair >= pairs // 2)
            right = right[:, :2] / right[:, 2:] * focal + size / 2 - 0.5
            seen = ((right > 0) & (right < size - 1)).all(axis=1) & (left < size - 1).all(axis=1)
            both = np.c_[left, right + rng.normal(scale=0.3, size=right.shape), np.ones(len(left))][seen][:matches]
            np.savetxt(recording / f"pairs/{pair:04}.csv", both, "%.3f", ",", header="ul,vl,ur,vr,score", comments="")
    (recording / "meta.json").write_text("{")


# %%
def main():
    parser = argparse.ArgumentParser(description="One row for each recording of a fleet.")
    parser.add_argument("folder", nargs="?", type=Path, help="folder of recordings; default: 50 are made")
    parser.add_argument("--out", type=Path, help="CSV file; rows that it has are not judged again")
    parser.add_argument("--scheduler", help="address of a Dask cluster; default: processes on this machine")
    parser.add_argument("--workers", type=int, default=2, help="number of processes on this machine")
    args = parser.parse_args()
    made = args.folder is None
    if made:
        args.folder = Path(tempfile.mkdtemp())
        make(args.folder, 50)
    out = args.out or args.folder / "fleet.csv"
    folders = sorted(path for path in args.folder.iterdir() if path.is_dir())
    where = {"address": args.scheduler} if args.scheduler else {"n_workers": args.workers, "threads_per_worker": 1}
    with Client(**where, **({} if args.scheduler else {"dashboard_address": None})) as client:
        start = time.monotonic()
        judged = fleet(folders, out, client)
        print(f"{judged} recordings in {time.monotonic() - start:.1f} s, {len(folders) - judged} were done")
        again = fleet(folders, out, client)
    rows = read(out)
    picture(rows, out.with_suffix(".png"))
    print(f"{out}: {len(rows)} rows, {sum(row['may_arm'] == 'True' for row in rows)} may arm")
    if made:
        knocked = [row for row in rows if row["knocks"]]
        assert len(rows) == 50 and again == 0 and len(knocked) >= 20
        assert [row["recording"] for row in rows if row["error"]] == ["flight_049"]


if __name__ == "__main__":
    main()
