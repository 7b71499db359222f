# %% [markdown]
# # The verdict as a MAVLink message and as ROS 2 diagnostics
#
# An autopilot shows texts with a severity (`STATUSTEXT`) and plots named numbers (`NAMED_VALUE_FLOAT`); ROS 2 collects
# `diagnostic_msgs/DiagnosticArray`. The first needs ``pip install pymavlink``, the second a plain dictionary.

# %%
from pathlib import Path

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

import stereo_selfcal as sc

DATA = Path(__file__).resolve().parents[2] / "data/opencv_chess_sift"


# %% [markdown]
# ## MAVLink
#
# The text goes out when the answer or its reasons change, the numbers after each pair. `send` writes to a serial port or
# a socket, as `mavutil.mavlink_connection` does.

# %%
class Mavlink:
    """Messages of a companion computer."""

    def __init__(self, send):
        self.mav = mavlink.MAVLink(self, srcSystem=1, srcComponent=mavlink.MAV_COMP_ID_ONBOARD_COMPUTER)
        self.write = send
        self.last = None

    def tell(self, verdict, boot_ms):
        """Send the messages of a verdict."""
        for name, value in (("ROWS_PX", verdict.rows_px), ("DEPTH_PX", verdict.depth_px), ("COVER", verdict.coverage)):
            self.mav.named_value_float_send(boot_ms, name.encode(), value)
        answer = (verdict.may_arm, verdict.reasons, verdict.cause)
        if answer != self.last:
            self.last = answer
            severity = mavlink.MAV_SEVERITY_INFO if verdict.may_arm else mavlink.MAV_SEVERITY_WARNING
            why = verdict.cause or ", ".join(verdict.reasons)
            text = "Stereo: calibration good" if verdict.may_arm else f"Stereo: {why}"
            self.mav.statustext_send(severity, text.encode()[:50])


# %% [markdown]
# ## ROS 2
#
# `DiagnosticStatus` has the levels 0 (OK), 1 (warning), 2 (error), 3 (stale). A rig that must not arm is an error; a
# better estimate than the calibration in use is a warning. The fields fill a message of `rclpy` one by one.

# %%
def diagnostics(verdict, rig="front stereo"):
    """`diagnostic_msgs/DiagnosticArray` as a dictionary."""
    level = 2 if not verdict.may_arm else 1 if verdict.should_apply else 0
    numbers = {name: getattr(verdict, name) for name in ("rows_px", "depth_px", "coverage", "image_coverage")}
    values = {name: f"{value:.3f}" for name, value in numbers.items()}
    values |= {"reasons": ", ".join(verdict.reasons), "cause": verdict.cause or ""}
    status = {"level": level, "name": f"{rig}: calibration", "message": verdict.text, "hardware_id": rig}
    return {"status": [status | {"values": [{"key": k, "value": v} for k, v in values.items()]}]}


# %% [markdown]
# ## A recorded rig that starts from its calibration

# %%
sent = []
link = Mavlink(lambda data: sent.append(bytes(data)))
calibrator = sc.Calibrator(sc.read_rig(DATA / "meta.json"))
for number, file in enumerate(sorted((DATA / "pairs").glob("*.csv"))):
    matches = np.loadtxt(file, delimiter=",", skiprows=1)
    verdict = calibrator.fuse(matches[:, :2], matches[:, 2:4], matches[:, 4]).verdict
    link.tell(verdict, boot_ms=100 * number)
    levels = diagnostics(verdict)["status"][0]
    print(f"pair {number:2}: level {levels['level']}, {levels['message']}")

received = mavlink.MAVLink(None).parse_buffer(b"".join(sent))
texts = [(message.severity, message.text) for message in received if message.get_type() == "STATUSTEXT"]
print(*texts, sep="\n")
assert texts[0][0] == mavlink.MAV_SEVERITY_WARNING and texts[-1][1] == "Stereo: calibration good"
assert levels["level"] == 0 and len(received) == 3 * (number + 1) + len(texts)
