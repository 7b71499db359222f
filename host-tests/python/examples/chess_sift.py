# %% [markdown]
# # Calibrate a rig from OpenCV's SIFT matches
#
# Thirteen pairs of a chessboard from OpenCV's samples, taken by two webcams. The cameras are calibrated, the rig is
# not: the calibrator starts side by side. Afterwards the rows of the rectified images agree.

# %%
from pathlib import Path

import cv2
import numpy as np

import stereo_selfcal as sc

DATA = Path(__file__).resolve().parents[2] / "data"
calibrated = sc.read_rig(DATA / "opencv_chess_sift")
rig = sc.Rig(calibrated.left, calibrated.right)
print(rig)


# %% [markdown]
# ## Matches
#
# A ratio test and a mutual check, without a geometric test: the calibrator handles wrong matches.

# %%
def sift_matches(left, right):
    """Points of both images, (n, 2), and a score, (n,)."""
    sift = cv2.SIFT_create(2000)
    (kl, dl), (kr, dr) = (sift.detectAndCompute(image, None) for image in (left, right))
    forth = cv2.BFMatcher().knnMatch(dl, dr, k=2)
    back = {m.queryIdx: m.trainIdx for m in cv2.BFMatcher().match(dr, dl)}
    kept = [(a, b) for a, b in forth if a.distance < 0.8 * b.distance and back[a.trainIdx] == a.queryIdx]
    uv_left = np.array([kl[a.queryIdx].pt for a, _ in kept])
    uv_right = np.array([kr[a.trainIdx].pt for a, _ in kept])
    return uv_left, uv_right, np.array([1 - a.distance / b.distance for a, b in kept])


def images():
    """Left and right image of each pair."""
    for path in sorted((DATA / "images/chess").glob("left*.jpg")):
        partner = path.with_name(path.name.replace("left", "right"))
        yield tuple(cv2.imread(str(p), cv2.IMREAD_GRAYSCALE) for p in (path, partner))


# %% [markdown]
# ## Calibrate

# %%
calibrator = sc.Calibrator(rig, capacity=1024)
matches = [sift_matches(*pair) for pair in images()]
results = [calibrator.fuse(*pair) for pair in matches]
for result in results:
    print(result)
calibration = calibrator.apply()
print(calibration)

# %% [markdown]
# ## Rectify, and compare rows

# %%
left, right = next(images())
before, after = rig.calibration(), calibration
for name, used in (("before", before), ("after", after)):
    maps = used.rectify_maps()
    views = [cv2.remap(image, *m, cv2.INTER_LINEAR) for image, m in zip((left, right), maps)]
    uv_left, uv_right, _ = sift_matches(*views)
    rows = np.abs(uv_left[:, 1] - uv_right[:, 1])
    print(f"{name}: matches of the rectified images are {np.median(rows):.2f} px off their rows")

# %% [markdown]
# A board calibration of the same images is the reference.

# %%
offsets = [np.abs(np.concatenate([of.row_offsets(*pair[:2]) for pair in matches])) for of in (before, after)]
medians = [float(np.nanmedian(px)) for px in offsets]
turn = cv2.Rodrigues(calibrated.calibration().R.T @ calibration.R)[0]
degrees = np.degrees(np.linalg.norm(turn))
print(f"median row offset {medians[0]:.2f} px before, {medians[1]:.2f} px after; R is {degrees:.3f} degrees from the board's")
assert result.state == "locked" and medians[1] < 1.0 < medians[0] and degrees < 0.3

# %%
try:
    figure = sc.plot(results, before, after, *matches[0][:2])
except ImportError:
    print("pip install stereo-selfcal[plot] for a picture")
