# %% [markdown]
# # Depth judged by LiDAR, with public data
#
# Makes data sets with true depths from your own download of a public recording, and judges by them the depth of a
# calibrator whose rig is knocked or drifts. No image and no point of these recordings is part of this project.
#
#     python lidar_depth.py                                       # a made recording of each kind
#     python lidar_depth.py kitti dataset/sequences/06 set_06     # KITTI odometry, or a synced drive of KITTI raw
#     python lidar_depth.py argoverse rectified_stereo_images_v1.1/train/LOG set_log
#     python lidar_depth.py judge set_06 --out set_06.csv
#
# - **KITTI** (cvlibs.net): CC BY-NC-SA 3.0. Images, calibration and Velodyne points, of odometry or raw.
# - **Argoverse 1 stereo** (argoverse.org): CC BY-NC-SA 4.0. Another rig: 5 megapixels, 0.3 m. Its disparity maps are
#   accumulated LiDAR, in `disparity_maps_v1.1` beside the images.
#
# A data set is `meta.json`, `pairs/`, `truth/` and `quads/`, as `host-tests/data/README.md` describes it; `selfcal replay`
# reads it too. The matches pass a ratio test and a mutual check, and no geometric test.

# %%
import argparse
import csv
import json
import tempfile
from pathlib import Path

import cv2
import numpy as np

import stereo_selfcal as sc

# LiDAR points of a depth: within this of the pixel, px, and at least so many.
REACH_PX, LEAST_POINTS = 8, 6
# Largest distance of such a point from the plane through all of them, relative.
FLATNESS = 0.02
# A match with a larger error of disparity and of rows under the true calibration is wrong, px.
WRONG_PX = (6, 3)


# %% [markdown]
# ## Recordings
#
# Each function returns what `meta.json` has, and the frames: name, left and right image, and a function that returns
# left pixels, (n, 2), and their depths along the left axis, m.

# %%
def kitti(folder, cameras=(0, 1)):
    """A sequence of KITTI odometry, or a synced and rectified drive of KITTI raw."""
    odometry = (folder / "calib.txt").exists()
    if odometry:
        found = numbers(folder / "calib.txt")
        if "Tr" not in found:
            raise ValueError(f"{folder}/calib.txt has no Tr: data_odometry_calib.zip has it")
        projections = [found[f"P{number}"].reshape(3, 4) for number in cameras]
        to_camera = np.vstack([found["Tr"].reshape(3, 4), [0, 0, 0, 1]])
        names, clouds = [f"image_{number}" for number in cameras], folder / "velodyne"
    else:
        found = numbers(folder.parent / "calib_cam_to_cam.txt") | numbers(folder.parent / "calib_velo_to_cam.txt")
        projections = [found[f"P_rect_0{number}"].reshape(3, 4) for number in cameras]
        rectified, to_camera = np.eye(4), np.eye(4)
        rectified[:3, :3] = found["R_rect_00"].reshape(3, 3)
        to_camera[:3] = np.c_[found["R"].reshape(3, 3), found["T"]]
        to_camera = rectified @ to_camera
        names, clouds = [f"image_0{number}/data" for number in cameras], folder / "velodyne_points/data"
    # P = K [I | c]: the camera sees points that are moved by c.
    K_l, K_r = (projection[:, :3] for projection in projections)
    c_l, c_r = (np.linalg.solve(projection[:, :3], projection[:, 3]) for projection in projections)

    def depths(cloud):
        if not cloud.exists():  # a few scans of KITTI raw are missing
            return np.empty((0, 2)), np.empty(0)
        points = np.fromfile(cloud, np.float32).reshape(-1, 4)[:, :3].astype(float)
        points = points @ to_camera[:3, :3].T + to_camera[:3, 3] + c_l
        points = points[points[:, 2] > 1]
        pixels = points @ K_l.T
        return pixels[:, :2] / pixels[:, 2:], points[:, 2]

    frames = [
        (left.stem, left, folder / names[1] / left.name, lambda cloud=clouds / f"{left.stem}.bin": depths(cloud))
        for left in sorted((folder / names[0]).glob("*.png"))
    ]
    kind = "odometry" if odometry else "raw"
    about = {"source": f"KITTI {kind} {folder.name}, cameras {cameras}", "license": "CC BY-NC-SA 3.0 (KITTI)"}
    return about | rig(K_l, K_r, c_r - c_l), frames


def argoverse(folder):
    """A log of Argoverse 1 stereo: `rectified_stereo_images_v1.1/SPLIT/LOG`."""
    maps = folder.parents[2] / "disparity_maps_v1.1" / folder.parent.name / folder.name
    left, right = "stereo_front_left_rect", "stereo_front_right_rect"
    found = json.loads((folder / "vehicle_calibration_stereo_info.json").read_text())["camera_data_"]
    cameras = [next(one["value"] for one in found if one["key"].endswith(name)) for name in (left, right)]
    K_l, K_r = (
        np.array([
            [one["focal_length_x_px_"], 0, one["focal_center_x_px_"]],
            [0, one["focal_length_y_px_"], one["focal_center_y_px_"]],
            [0, 0, 1],
        ])
        for one in cameras
    )
    places = [np.array(one["vehicle_SE3_camera_"]["translation"]) for one in cameras]
    baseline_m = np.linalg.norm(places[1] - places[0])

    def depths(file):
        disparities = cv2.imread(str(file), cv2.IMREAD_UNCHANGED) / 256.0
        v, u = np.nonzero(disparities)
        shift = K_l[0, 2] - K_r[0, 2]
        return np.c_[u, v].astype(float), K_l[0, 0] * baseline_m / (disparities[v, u] - shift)

    frames = []
    for file in sorted((maps / "stereo_front_left_rect_disparity").glob("*.png")):
        time = file.stem.rsplit("_", 1)[1]
        images = [folder / name / f"{name}_{time}.jpg" for name in (left, right)]
        frames.append((time, *images, lambda file=file: depths(file)))
    about = {"source": f"Argoverse 1 stereo {folder.name}", "license": "CC BY-NC-SA 4.0 (Argoverse)"}
    return about | rig(K_l, K_r, np.array([-baseline_m, 0, 0])), frames


def rig(K_l, K_r, t):
    """The rig of rectified images, with a baseline of `t`, m."""
    length = float(np.linalg.norm(t))
    extrinsics = {"R": np.eye(3).tolist(), "t": (t / length).tolist(), "baseline_m": length}
    return {"K_l": K_l.tolist(), "K_r": K_r.tolist(), "dist_l": [0.0] * 5, "dist_r": [0.0] * 5} | extrinsics


def numbers(path):
    """Lines `key: numbers` of a file; other lines are left out."""
    found = {}
    for line in path.read_text().splitlines():
        key, _, rest = line.partition(":")
        try:
            found[key] = np.array(rest.split(), float)
        except ValueError:
            continue
    return found


# %% [markdown]
# ## From images to matches
#
# A match has a depth if the LiDAR points around its left pixel lie on one plane: the inverse depth of a plane is linear in
# the pixel. Points of the background that the LiDAR sees past an edge are not on it.

# %%
def features(path):
    """Points, (n, 2), and descriptors of an image."""
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise ValueError(f"cannot read {path}")
    points, descriptors = cv2.SIFT_create(4000).detectAndCompute(image, None)
    return np.array([point.pt for point in points]).reshape(-1, 2), descriptors


def matched(one, other):
    """Indices and score of the matches of two images, by the index in the first."""
    forth = cv2.BFMatcher().knnMatch(one[1], other[1], k=2)
    back = {m.queryIdx: m.trainIdx for m in cv2.BFMatcher().match(other[1], one[1])}
    certain = [a for a, b in forth if a.distance < 0.8 * b.distance and back[a.trainIdx] == a.queryIdx]
    second = {a.queryIdx: b.distance for a, b in forth}
    return {a.queryIdx: (a.trainIdx, 1 - a.distance / second[a.queryIdx]) for a in certain}


def depth_at(pixel, points, inverse):
    """Depth of a pixel, m, from the plane through the points around it; NaN without one."""
    near = (np.abs(points - pixel) <= REACH_PX).all(axis=1)
    offsets, inverse = points[near] - pixel, inverse[near]
    if len(offsets) < LEAST_POINTS or (offsets.min(axis=0) > 0).any() or (offsets.max(axis=0) < 0).any():
        return np.nan
    terms = np.c_[np.ones(len(offsets)), offsets]
    plane, _, rank, _ = np.linalg.lstsq(terms, inverse, rcond=None)
    flat = np.abs(terms @ plane - inverse).max() <= FLATNESS * plane[0]
    return 1 / plane[0] if rank == 3 and flat else np.nan


def make_set(recording, out, every=2, pairs=None):
    """Write a data set of each `every`th frame. Its quads are matches of a pair that the next pair shows too."""
    about, frames = recording
    frames = frames[::every][:pairs]
    if not frames:
        raise ValueError("no images")
    height, width = cv2.imread(str(frames[0][1]), cv2.IMREAD_GRAYSCALE).shape
    out.mkdir(parents=True)
    names = [name for name, *_ in frames]
    meta = about | {"width": width, "height": height, "frames": names}
    (out / "meta.json").write_text(json.dumps(meta, indent=1) + "\n")
    last = None
    for number, (_, left, right, depths) in enumerate(frames):
        views = [features(left), features(right)]
        found = matched(*views)
        rows = [(*views[0][0][a], *views[1][0][b], score) for a, (b, score) in found.items()]
        write(out / f"pairs/{number:04}.csv", "ul,vl,ur,vr,score", rows)
        points, depth_m = depths()
        of = [(row, depth_at(np.array(match[:2]), points, 1 / depth_m)) for row, match in enumerate(rows)]
        write(out / f"truth/{number:04}.csv", "match,depth_m", [(row, z) for row, z in of if np.isfinite(z)])
        if last:
            (before, was), tracked = last, matched(last[0][0], views[0])
            quads = [
                (*before[0][0][a], *before[1][0][was[a][0]], *views[0][0][b], *views[1][0][found[b][0]])
                for a, (b, _) in tracked.items()
                if a in was and b in found
            ]
            write(out / f"quads/{number - 1:04}.csv", "ul1,vl1,ur1,vr1,ul2,vl2,ur2,vr2", quads)
        last = views, found


def write(path, heading, rows):
    path.parent.mkdir(exist_ok=True)
    text = [",".join(f"{x:.3f}" if isinstance(x, float) else str(x) for x in row) for row in rows]
    path.write_text("\n".join([heading, *text]) + "\n")


def read(path):
    """Rows of numbers of a CSV file, without its heading; empty without a file."""
    heading, *rows = path.read_text().splitlines() if path.exists() else [""]
    return np.array([row.split(",") for row in rows], float).reshape(len(rows), heading.count(",") + 1)


# %% [markdown]
# ## Depth before and after knocks and drift
#
# The calibrator starts at the published calibration, and its estimate is applied after each pair. It sees all pairs, and
# then all pairs again, with the right camera turned: at once, or more and more up to the last pair.

# %%
AXES = {"pitch": (1, 0, 0), "yaw": (0, 1, 0), "roll": (0, 0, 1), "mixed": (0.6, 0.5, 0.6)}
KNOCKS = [(axis, degrees) for degrees in (0.3, 1, 3) for axis in AXES] + [("yaw", d) for d in (-0.1, 0.1, -0.3, -1, -3)]
CASES = [("at rest", "pitch", 0, False)]
CASES += [(f"knock {axis} {degrees}", axis, degrees, False) for axis, degrees in KNOCKS]
CASES += [(f"drift {axis} {degrees}", axis, degrees, True) for axis in ("yaw", "mixed") for degrees in (-0.3, 0.3)]
COLUMNS = "case true_px before_px after_px reported_px may_arm".split()


def turn(axis, degrees):
    """Rotation of the right camera about an axis, (3, 3)."""
    return cv2.Rodrigues(np.radians(degrees) * np.array(AXES[axis], float))[0]


class Judged:
    """Matches of a data set, and those of known depth."""

    def __init__(self, folder):
        self.rig = sc.read_rig(folder / "meta.json")
        files = sorted((folder / "pairs").glob("*.csv"))
        self.pairs = [read(file) for file in files]
        depths = [read(folder / "truth" / file.name) for file in files]
        known = [np.c_[pair[of[:, 0].astype(int), :4], of[:, 1]] for pair, of in zip(self.pairs, depths) if len(of)]
        if not known:
            raise ValueError(f"{folder}/truth has no depths")
        self.known = np.concatenate(known)

    def errors(self, calibration, turned):
        """Errors of disparity and of rows of the matches of known depth, px, with the right camera turned."""
        left, right = self.rig.left, self.rig.right
        focal = (left.K[0, 0] + left.K[1, 1] + right.K[0, 0] + right.K[1, 1]) / 4
        R1, R2, *_ = calibration.stereo_rectify()
        a, b = (np.c_[rays, np.ones(len(rays))] for rays in (left.rays(self.known[:, :2]), right.rays(self.known[:, 2:4])))
        a, b = a @ R1.T, b @ turned.T @ R2.T
        disparity, row = (a[:, :2] / a[:, 2:] - b[:, :2] / b[:, 2:]).T
        return focal * (disparity * a[:, 2] - self.rig.baseline_m / self.known[:, 4]), focal * row

    def run(self, axis, degrees, drifts):
        """Numbers of a case, in the order of `COLUMNS`."""
        calibrator = sc.Calibrator(self.rig, capacity=1024)
        for pair in self.pairs:
            take(calibrator, pair[:, :2], pair[:, 2:4], pair[:, 4])
        before = calibrator.in_use
        for number, pair in enumerate(self.pairs, 1):
            by = turn(axis, degrees * number / len(self.pairs) if drifts else degrees)
            rays = self.rig.right.rays(pair[:, 2:4])
            rays = np.c_[rays, np.ones(len(rays))] @ by.T
            right = self.rig.right.pixels(rays[:, :2] / rays[:, 2:])
            take(calibrator, pair[:, :2], right, pair[:, 4])
        last = turn(axis, degrees)
        R, t = last @ self.rig.factory[0], last @ self.rig.factory[1]
        truth = sc.Rig(self.rig.left, self.rig.right, (R, t)).calibration()
        of_truth, rows = self.errors(truth, last)
        right = (np.abs(of_truth) <= WRONG_PX[0]) & (np.abs(rows) <= WRONG_PX[1])
        used = (truth, before, calibrator.in_use)
        medians = [np.median(np.abs(self.errors(one, last)[0][right])) for one in used]
        return *medians, calibrator.verdict.depth_px, calibrator.verdict.may_arm


def take(calibrator, left, right, score):
    calibrator.fuse(left, right, score)
    try:
        calibrator.apply()
    except sc.ApplyError:  # normal until four pairs agree
        pass


def judge(folder, out=None, cases=CASES):
    """Print and return the rows of all cases; `out`: a CSV file for them."""
    judged = Judged(folder)
    print(f"{folder.name}: {len(judged.pairs)} pairs, {len(judged.known)} matches of known depth; median errors, px of disparity")
    print("{:18} {:>8} {:>9} {:>8} {:>11}  {}".format(*COLUMNS))
    rows = []
    for name, *case in cases:
        row = dict(zip(COLUMNS, (name, *judged.run(*case))))
        rows.append(row)
        print("{:18} {:8.2f} {:9.2f} {:8.2f} {:11.2f}  {}".format(*row.values()))
    if out:
        with out.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows([f"{x:.2f}" if isinstance(x, float) else x for x in row.values()] for row in rows)
    return rows


# %% [markdown]
# ## Made recordings
#
# A street of textured boards, seen by a rig that drives forward, written in the layout of each recording.

# %%
SIZE, FOCAL, GROUND = (400, 132), 300.0, 1.6
BOARDS = [(7.0, -5.0, -1.5), (9.0, 1.5, 5.0), (13.0, -9.0, -3.5), (16.0, 3.0, 9.0), (22.0, -5.0, 2.0), (40.0, -60.0, 60.0)]
K = np.array([[FOCAL, 0, 200.0], [0, FOCAL, 66.0], [0, 0, 1]])


def texture():
    """Noise of all scales, which repeats at its borders."""
    rng = np.random.default_rng(3)
    layers = [cv2.resize(rng.normal(size=(s, s)), (1024, 1024), interpolation=cv2.INTER_CUBIC) for s in (16, 64, 128, 256, 512)]
    return np.clip(sum(layers) * 24 + 128, 0, 255).astype(np.float32)


def see(texels, x, z):
    """Image and depths of a camera at `x` to the side and `z` ahead, m."""
    u, v = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    rays = np.stack([(u - K[0, 2]) / FOCAL, (v - K[1, 2]) / FOCAL])
    depth = GROUND / np.maximum(rays[1], 0.02)
    across, along = rays[0] * depth + x, depth + z
    for number, (far, begin, end) in enumerate(BOARDS):
        side = rays[0] * (far - z) + x
        seen = (far - z < depth) & (side >= begin) & (side <= end)
        depth = np.where(seen, far - z, depth)
        across, along = np.where(seen, side, across), np.where(seen, rays[1] * (far - z) + 7 * number, along)
    maps = [(one * 30 % 1024).astype(np.float32) for one in (across, along)]
    return cv2.remap(texels, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP).astype(np.uint8), depth


def make_recordings(folder, count=6, baseline_m=0.54):
    """The same drive as KITTI odometry, KITTI raw and Argoverse; returns the folders of the three."""
    odometry, raw = folder / "sequences/00", folder / "2011_09_26/2011_09_26_drive_0001_sync"
    log = folder / "rectified_stereo_images_v1.1/train/a_log"
    maps = folder / "disparity_maps_v1.1/train/a_log/stereo_front_left_rect_disparity"
    names = [f"stereo_front_{side}_rect" for side in ("left", "right")]
    places = [odometry / "image_0", odometry / "image_1", odometry / "velodyne", raw / "image_00/data", raw / "image_01/data"]
    for place in [*places, raw / "velodyne_points/data", maps, log / names[0], log / names[1]]:
        place.mkdir(parents=True)
    # The axes of the LiDAR are forward, left, up.
    R, T = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([0, -0.08, -0.27])
    P = [np.c_[K, [-FOCAL * x, 0, 0]] for x in (0, baseline_m)]
    texts = [" ".join(map(str, matrix.ravel())) for matrix in (*P, np.c_[R, T], np.eye(3), R, T)]
    (odometry / "calib.txt").write_text("P0: {}\nP1: {}\nTr: {}\n".format(*texts))
    of_cameras = "calib_time: 09-Jan-2012 13:57:47\nP_rect_00: {0}\nP_rect_01: {1}\nR_rect_00: {3}\n"
    (raw.parent / "calib_cam_to_cam.txt").write_text(of_cameras.format(*texts))
    (raw.parent / "calib_velo_to_cam.txt").write_text("R: {4}\nT: {5}\n".format(*texts))
    camera = {"focal_length_x_px_": FOCAL, "focal_length_y_px_": FOCAL}
    camera |= {"focal_center_x_px_": K[0, 2], "focal_center_y_px_": K[1, 2]}
    of = [
        {"key": f"image_raw_{name}", "value": camera | {"vehicle_SE3_camera_": {"translation": [1.6, y, 1.4]}}}
        for name, y in zip(names, (baseline_m / 2, -baseline_m / 2))
    ]
    (log / "vehicle_calibration_stereo_info.json").write_text(json.dumps({"camera_data_": of}))
    texels = texture()
    for number in range(count):
        (left, depth), (right, _) = (see(texels, x, number * 0.6) for x in (0, baseline_m))
        v, u = np.mgrid[1 : SIZE[1] : 4, 1 : SIZE[0] : 2].reshape(2, -1)
        points = np.c_[(u - K[0, 2]) / FOCAL, (v - K[1, 2]) / FOCAL, np.ones(len(u))] * depth[v, u][:, None]
        cloud = np.c_[(points - T) @ R, np.zeros(len(u))].astype(np.float32)
        for place, name in ((odometry, f"{number:06}"), (raw, f"{number:010}")):
            images, clouds = ("image_0{}/data", "velodyne_points/data") if place is raw else ("image_{}", "velodyne")
            for camera, image in enumerate((left, right)):
                cv2.imwrite(str(place / images.format(camera) / f"{name}.png"), image)
            cloud.tofile(place / clouds / f"{name}.bin")
        for name, image in zip(names, (left, right)):
            cv2.imwrite(str(log / name / f"{name}_{number}.jpg"), image, [cv2.IMWRITE_JPEG_QUALITY, 95])
        disparities = np.zeros(depth.shape)
        disparities[v, u] = FOCAL * baseline_m / depth[v, u]
        cv2.imwrite(str(maps / f"stereo_front_left_rect_disparity_{number}.png"), np.round(disparities * 256).astype(np.uint16))
    return odometry, raw, log


def made():
    """Make, read and judge a recording of each kind."""
    few = [case for case in CASES if case[0] in ("at rest", "knock pitch 1", "knock yaw 1", "knock roll 1")]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        odometry, raw, log = make_recordings(folder)
        make_set(kitti(raw), folder / "raw", every=1)
        for name, recording in (("odometry", kitti(odometry)), ("argoverse", argoverse(log))):
            out = folder / name
            make_set(recording, out, every=1)
            meta = json.loads((out / "meta.json").read_text())
            assert abs(meta["baseline_m"] - 0.54) < 1e-9 and len(read(out / "quads/0002.csv")) > 20
            for row in judge(out, out.with_suffix(".csv"), few):
                assert row["true_px"] < 0.5 and row["after_px"] < row["true_px"] + 0.5, row
                knocked = row["case"] != "at rest"
                assert not knocked or row["before_px"] > 2 * row["after_px"], row
            assert len(out.with_suffix(".csv").read_text().splitlines()) == 1 + len(few)
        for file in ("pairs/0005.csv", "truth/0005.csv", "quads/0004.csv"):
            assert (folder / "raw" / file).read_text() == (folder / "odometry" / file).read_text()


# %%
def main():
    parser = argparse.ArgumentParser(description="Depth judged by LiDAR, with public data.")
    commands = parser.add_subparsers(dest="command")
    for name, help in (("kitti", "KITTI odometry or raw"), ("argoverse", "Argoverse 1 stereo")):
        command = commands.add_parser(name, help=f"make a data set of {help}")
        command.add_argument("recording", type=Path)
        command.add_argument("out", type=Path, help="folder that is made")
        command.add_argument("--every", type=int, default=2, help="take one of so many frames")
        command.add_argument("--pairs", type=int, help="take at most so many pairs")
    commands.choices["kitti"].add_argument("--cameras", type=int, nargs=2, default=(0, 1), help="2 3: the colour cameras")
    command = commands.add_parser("judge", help="knock a data set, and print the errors of depth")
    command.add_argument("set", type=Path)
    command.add_argument("--out", type=Path, help="CSV file")
    args = parser.parse_args()
    if args.command == "judge":
        judge(args.set, args.out)
    elif args.command:
        recording = argoverse(args.recording) if args.command == "argoverse" else kitti(args.recording, args.cameras)
        make_set(recording, args.out, args.every, args.pairs)
    else:
        made()


if __name__ == "__main__":
    main()
