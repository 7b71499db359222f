# %% [markdown]
# # A robot: frames of a matcher, a loss of power, and a restart
#
# A matcher on the robot sends its matches as frames over a wire that damages bytes. The program saves its estimate as
# the firmware does, in a record of 400 bytes; after the loss of power it goes on from there.

# %%
import csv
import random
import tempfile
from pathlib import Path

import numpy as np

import stereo_selfcal as sc

DATA = Path(__file__).resolve().parents[2] / "data/opencv_chess_sift"
calibrated = sc.read_rig(DATA)
rig = sc.Rig(calibrated.left, calibrated.right)
flash = Path(tempfile.mkdtemp()) / "record"


# %% [markdown]
# ## The wire
#
# Frames of the recorded matches, in pieces as a serial port delivers them; one byte in 50,000 is wrong.

# %%
def wire(seed):
    """Pieces of the byte stream."""
    noise = random.Random(seed)
    for sequence, path in enumerate(sorted((DATA / "pairs").glob("*.csv"))):
        with path.open() as file:
            rows = np.array([[float(x) for x in row] for row in list(csv.reader(file))[1:]])
        frame = bytearray(sc.encode_frame(sequence, rows[:, :2], rows[:, 2:4], rows[:, 4], size=rig.left.size))
        for i in range(len(frame)):
            if noise.random() < 2e-5:
                frame[i] ^= 0x55
        for i in range(0, len(frame), 300):
            yield bytes(frame[i : i + 300])


# %% [markdown]
# ## The robot's loop

# %%
def run(calibrator, pieces, until=None):
    """Calibrate, apply and save, as the loop of a robot does."""
    for piece in pieces:
        for result in calibrator.feed_frames(piece):
            print(f"frame {result.frame.sequence:2}: {result}")
            before = calibrator.generation
            try:
                calibrator.apply()
            except sc.ApplyError as error:
                print(f"          not applied: {error}")
            if calibrator.generation != before:
                flash.write_bytes(calibrator.save())
            if result.frame.sequence == until:
                return


# %%
calibrator = sc.Calibrator(rig)
run(calibrator, wire(1), until=8)
print(f"saved: {flash.stat().st_size} bytes; then the power fails")

# %% [markdown]
# ## After the loss of power
#
# The restored calibration rectifies at once; it counts as suspect until a pair confirms it.

# %%
restarted = sc.Calibrator(rig)
restarted.load(flash.read_bytes())
assert np.allclose(restarted.in_use.R, calibrator.in_use.R, atol=1e-6) and restarted.state == "suspect"
print(restarted.in_use)
run(restarted, wire(2))
print(restarted.link)
assert restarted.state == "locked" and restarted.link["good"] >= 10

# %%
error = np.linalg.norm(restarted.apply().R - calibrated.calibration().R)
print(f"R is {np.degrees(error / np.sqrt(2)):.3f} degrees from that of a board calibration")
assert error < 5e-3
