"""The images of the project: the chessboard pairs, Aloe, and Motorcycle with its depth.

Chessboard and Aloe are copied as they are. Motorcycle becomes grey JPEG of quality 90, its published disparities PNG in
steps of a quarter of a pixel, 0 without a disparity.
"""
import argparse
import pathlib
import shutil

import cv2
import numpy as np

import common

STEPS_PER_PX = 4


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--chess", required=True, help="folder of left01.jpg, right01.jpg, aloeL.jpg and others")
    parser.add_argument("--motorcycle", required=True, help="folder of motorcycle_left.png, _right.png and _disp.npz")
    parser.add_argument("--out", required=True, help="new folder of the images")
    args = parser.parse_args()

    chess, motorcycle, out = (pathlib.Path(folder) for folder in (args.chess, args.motorcycle, args.out))
    out.mkdir(parents=True)
    for side in ("left", "right"):
        shutil.copyfile(chess / f"{side}01.jpg", out / f"chess_01_{side}.jpg")
        (out / "chess").mkdir(exist_ok=True)
        for path in sorted(chess.glob(f"{side}[01][0-9].jpg")):
            shutil.copyfile(path, out / "chess" / path.name)
        (out / "aloe").mkdir(exist_ok=True)
        shutil.copyfile(chess / f"aloe{side[0].upper()}.jpg", out / "aloe" / f"{side}.jpg")
        image = common.read_gray(motorcycle / f"motorcycle_{side}.png")
        cv2.imwrite(str(out / f"motorcycle_{side}.jpg"), image, [cv2.IMWRITE_JPEG_QUALITY, 90])
    disparity = np.load(motorcycle / "motorcycle_disp.npz")["arr_0"]
    known = np.isfinite(disparity)
    steps = np.where(known, np.clip(np.round(np.where(known, disparity, 0) * STEPS_PER_PX), 1, 255), 0)
    path = out / "motorcycle_disparity_quarter_px.png"
    cv2.imwrite(str(path), steps.astype(np.uint8), [cv2.IMWRITE_PNG_COMPRESSION, 9])


main()
