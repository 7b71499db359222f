# %% [markdown]
# # Images of two folders to disparities, before and after
#
# OpenCV's block matcher searches along rows. With a misaligned rig it finds little; with the calibrated rig it finds
# the scene. The matches come from this package: calibration needs no other matcher.

# %%
from pathlib import Path

import cv2
import numpy as np

import stereo_selfcal as sc

DATA = Path(__file__).resolve().parents[2] / "data"
left_files = sorted((DATA / "images/chess").glob("left*.jpg"))
right_files = sorted((DATA / "images/chess").glob("right*.jpg"))
cameras = sc.read_rig(DATA / "opencv_chess_sift")
rig = sc.Rig(cameras.left, cameras.right)

# %% [markdown]
# ## Is the rig as it should be?

# %%
print(sc.check(tuple(str(DATA / f"images/chess/{side}*.jpg") for side in ("left", "right")), rig))

# %% [markdown]
# ## Calibrate

# %%
calibrator = sc.Calibrator(rig, capacity=1024)
for left, right in zip(left_files, right_files):
    result = calibrator.fuse(*sc.match(left, right, rig))
print(result)
calibration = calibrator.apply()


# %% [markdown]
# ## Disparities

# %%
def disparities(used, left, right):
    """Share of the pixels of a textured scene that have a consistent disparity, and the disparities, px."""
    pair = [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in (left, right)]
    views = [cv2.remap(image, *maps, cv2.INTER_LINEAR) for image, maps in zip(pair, used.rectify_maps())]
    sgbm = cv2.StereoSGBM_create(
        minDisparity=0, numDisparities=128, blockSize=5, P1=200, P2=800, disp12MaxDiff=1, uniquenessRatio=15,
        speckleWindowSize=100, speckleRange=2,
    )
    found = sgbm.compute(*views).astype(np.float32) / 16
    return float((found > 0).mean()), found


shares = {}
for name, used in (("before", rig.calibration()), ("after", calibration)):
    shares[name] = np.mean([disparities(used, *files)[0] for files in zip(left_files, right_files)])
    print(f"{name}: {100 * shares[name]:.0f} % of the pixels have a disparity")
assert result.state == "locked" and shares["after"] > 1.2 * shares["before"]

# %% [markdown]
# ## Depth
#
# In baselines, because the length of this rig's baseline is unknown; with ``Rig(.., baseline_m=..)`` in m.

# %%
found = disparities(calibration, left_files[0], right_files[0])[1]
points = cv2.reprojectImageTo3D(found, calibration.stereo_rectify()[4])
print(f"the middle of the scene is {np.median(points[found > 0][:, 2]):.1f} baselines away")
