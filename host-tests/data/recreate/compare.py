"""Compare a re-created set with the committed one; exit with 1 if it differs.

Pair files have to be identical byte for byte. In meta.json, K, dist, R and t may differ by REL_TOL of the field's
largest element, the numbers measured along with them by MEASURED_TOL; everything else has to be equal. OpenCV's
calibration is not bit for bit the same from run to run: 4e-10 and 1e-8 were seen.
"""
import argparse
import json
import pathlib
import sys

import numpy as np

CALIBRATION = ("K_l", "K_r", "dist_l", "dist_r", "R", "t")
MEASURED = ("gt_sigma_R_deg", "gt_sigma_t_deg", "gt_sigma_R_given_K_deg", "gt_sigma_t_given_K_deg", "stereo_rms_px")
REL_TOL = 1e-8
MEASURED_TOL = 1e-6


def relative_difference(new, old):
    """The largest difference of two numbers, lists or matrices, relative to the old one's largest element."""
    new, old = np.asarray(new, float), np.asarray(old, float)
    if new.shape != old.shape:
        return np.inf
    return np.abs(new - old).max() / max(np.abs(old).max(), 1e-300) if (new != old).any() else 0.0


def compare_set(new, old):
    """Differences between two folders, as a list of texts, and the largest difference of K, dist, R and t."""
    if not (old / "meta.json").is_file():
        return ["there is no committed meta.json"], 0.0
    wrong, largest = [], 0.0
    new_meta, old_meta = (json.loads((folder / "meta.json").read_text()) for folder in (new, old))
    for field in sorted(new_meta.keys() | old_meta.keys()):
        a, b = new_meta.get(field), old_meta.get(field)
        if field in CALIBRATION + MEASURED and a is not None and b is not None:
            difference = relative_difference(a, b)
            if field in CALIBRATION:
                largest = max(largest, difference)
            if not difference <= (REL_TOL if field in CALIBRATION else MEASURED_TOL):
                wrong.append(f"meta.json: {field} differs by {difference:.1e} of its size")
        elif a != b:
            wrong.append(f"meta.json: {field} is {json.dumps(a)}, committed is {json.dumps(b)}")

    new_files, old_files = ({path.name: path.read_bytes() for path in (folder / "pairs").glob("*")}
                            for folder in (new, old))
    for name in sorted(new_files.keys() | old_files.keys()):
        if name not in old_files:
            wrong.append(f"pairs/{name} is not committed")
        elif name not in new_files:
            wrong.append(f"pairs/{name} is committed but was not re-created")
        elif new_files[name] != old_files[name]:
            a, b = new_files[name].splitlines(), old_files[name].splitlines()
            other = len(set(a) ^ set(b))
            wrong.append(f"pairs/{name}: {len(a) - 1} rows, committed {len(b) - 1}; {other} rows are in one only")
    return wrong, largest


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("new", type=pathlib.Path, help="folder of the re-created set")
    parser.add_argument("old", type=pathlib.Path, help="folder of the committed set")
    args = parser.parse_args()

    wrong, largest = compare_set(args.new, args.old)
    if wrong:
        print(f"  {args.new.name}: DIFFERENT")
        for text in wrong:
            print(f"    {text}")
        sys.exit(1)
    count = len(list((args.new / "pairs").iterdir()))
    print(f"  {args.new.name}: same (pair files byte for byte: {count}; K, dist, R, t "
          + (f"to {largest:.0e})" if largest else "equal)"))


main()
