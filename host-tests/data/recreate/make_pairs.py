"""Rectified image pairs with a published calibration: write their SIFT matches as a set.

The calibration file holds meta.json's fields as far as they are known beforehand (K, dist, R, t and the texts).
"""
import argparse
import json
import pathlib

import numpy as np

import common


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--left", required=True, nargs="+", help="left images")
    parser.add_argument("--right", required=True, nargs="+", help="right images, in the same order")
    parser.add_argument("--calib", required=True, help="calibration file")
    parser.add_argument("--out", required=True, help="folder of the new set")
    args = parser.parse_args()

    pairs = [[common.read_gray(path) for path in pair] for pair in zip(args.left, args.right, strict=True)]
    meta = json.loads(pathlib.Path(args.calib).read_text())
    for field in ("K_l", "K_r", "dist_l", "dist_r", "R", "t"):
        meta[field] = np.array(meta[field], float)
    meta["notes"] += "; sift matches, ratio 0.8 and mutual check only, natural outliers; score = 1 - d1/d2"
    meta["width"], meta["height"] = pairs[0][0].shape[::-1]
    meta["frames"] = [pathlib.Path(path).stem for path in args.left]
    common.write_set(args.out, meta, [common.match_sift(left, right) for left, right in pairs])


main()
