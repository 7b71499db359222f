#!/usr/bin/env bash
# Re-creates the five data sets and the images beside this folder from their public sources, and compares them with the committed files.
set -euo pipefail

usage() {
    cat <<'EOF'
usage: recreate.sh [--write] [--help]

Re-creates the data sets opencv_chess_corners, opencv_chess_sift, motorcycle_sift, aloe_sift and
oak_sift and the images from their public sources, and compares them with the committed ones: pair files and
images byte for byte, numbers in meta.json to rounding.

  --write   overwrite the committed sets and images that differ with the re-created ones
  --help    print this

Needs Debian 12 (bookworm; a container will do) on an x86-64 processor with AVX2, with python3
(3.11 or newer) and its venv module, apt-get, dpkg-deb, unzip and sha256sum, and the network: it
downloads about 200 MB with apt-get and pip. All of it goes into a temporary folder (about 700 MB)
that is removed at the end. Nothing is installed, root is not needed. It takes about a minute.

exit status: 0 all the same (or written), 1 something differs, 2 it could not run
EOF
}

say() { printf '%s\n' "$*"; }
fail() {
    printf 'error: %s\n' "$@" >&2
    exit 2
}

write=no
for arg in "$@"; do
    case "$arg" in
        --write) write=yes ;;
        -h | --help) usage; exit 0 ;;
        *) usage >&2; fail "unknown argument: $arg" ;;
    esac
done

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
data=$(dirname "$here")
sets=(opencv_chess_corners opencv_chess_sift motorcycle_sift aloe_sift oak_sift)

debian_package=opencv-doc=4.6.0+dfsg-12
debian_sha256=4b12681df35878207ac7097dc66184b2ae552e4bf4ddd2af04a0f03ed0b8682a
wheel=scikit-image==0.16.2
wheel_sha256=41e28db0136f29ecd305bef0408fdfc64be9d415e54f5099a95555c65f5c1865
sdist=stereodemo==0.7
sdist_sha256=61fca7415763af9e4a2a68060466f470d2ca1dbf3b3aa4fc82124bc696c97e54

say "1/7 checking tools"
need() { # need TOOL DEBIAN-PACKAGE
    command -v "$1" >/dev/null || missing+=("$1 is missing: apt-get install $2")
}
missing=()
command -v apt-get >/dev/null || missing+=("apt-get is missing: run this on Debian 12 (bookworm) or in a container of it")
need dpkg-deb dpkg
need unzip unzip
need sha256sum coreutils
need python3 "python3 python3-venv"
if command -v python3 >/dev/null; then
    python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
        missing+=("python3 has to be 3.11 or newer, not $(python3 --version 2>&1 || true)")
    python3 -c 'import venv, ensurepip' 2>/dev/null ||
        missing+=("python3 has no venv module with pip: apt-get install python3-venv")
fi
[ "${#missing[@]}" -eq 0 ] || fail "${missing[@]}"

# OpenCV's SIFT rounds differently in its AVX2 code, which made the sets, than in its other code; so do Intel's
# primitives in the calibration.
grep -qw avx2 /proc/cpuinfo ||
    fail "this processor has no AVX2: OpenCV would find slightly different SIFT features on it"
export OPENCV_IPP=avx2
if grep -qw avx512f /proc/cpuinfo; then
    export OPENCV_CPU_DISABLE=AVX512-SKX
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT # these two wait for the command that runs, so that it does not write to a folder being removed
trap 'exit 143' TERM
mkdir "$work/download" "$work/new"

# Run a command quietly; if it fails, show its output and exit with the given message.
quiet() { # quiet MESSAGE COMMAND...
    local message=$1
    shift
    if ! "$@" >"$work/log" 2>&1; then
        cat "$work/log" >&2
        fail "$message"
    fi
}
check_sum() { # check_sum FILE SHA256
    printf '%s  %s\n' "$2" "$1" | sha256sum --check --status ||
        fail "${1##*/} is not the file that the sets were made from (its SHA-256 differs)"
}

say "2/7 setting up Python packages (about 80 MB): $(sed '/^#/d' "$here/requirements.txt" | tr '\n' ' ')"
quiet "could not make a Python environment" python3 -m venv "$work/venv"
pip=("$work/venv/bin/python" -m pip --disable-pip-version-check --quiet)
quiet "pip could not install requirements.txt; is the network there?" \
    "${pip[@]}" install --only-binary=:all: -r "$here/requirements.txt"

say "3/7 downloading the Debian package $debian_package (96 MB)"
cd "$work/download"
# Only root needs the sandbox option: apt's own user may not enter root's temporary folder.
quiet "apt-get could not download $debian_package; it needs Debian 12 (bookworm) and a package list: apt-get update" \
    apt-get download -o APT::Sandbox::User=root "$debian_package"
deb=$(echo "$work"/download/opencv-doc_*.deb)
check_sum "$deb" "$debian_sha256"
dpkg-deb -x "$deb" "$work/opencv-doc"
opencv_images=$work/opencv-doc/usr/share/doc/opencv-doc/examples/data

say "4/7 downloading the Python wheel $wheel (26 MB, only its images are used)"
# The wheel is for an old Python; it is unpacked, not installed, so it works on any machine.
quiet "pip could not download $wheel; is the network there?" \
    "${pip[@]}" download --no-deps --only-binary=:all: --python-version 3.8 --platform manylinux2014_x86_64 "$wheel"
whl=$(echo "$work"/download/scikit_image-*.whl)
check_sum "$whl" "$wheel_sha256"
unzip -q "$whl" 'skimage/data/motorcycle_*' -d "$work/wheel"
skimage_images=$work/wheel/skimage/data

say "5/7 downloading the Python source package $sdist (4 MB, only its images are used)"
quiet "pip could not download $sdist; is the network there?" \
    "${pip[@]}" download --no-deps --no-binary=:all: "$sdist"
tgz=$(echo "$work"/download/stereodemo-*.tar.gz)
check_sum "$tgz" "$sdist_sha256"
tar -xzf "$tgz" -C "$work"
oak_images=$(echo "$work"/stereodemo-*/stereodemo/datasets/oak-d)

say "6/7 re-creating the sets and the images"
make_set() { # make_set SCRIPT ARGUMENTS...
    "$work/venv/bin/python" -B "$here/$1" "${@:2}" || fail "$1 failed"
}
make_set make_chess.py --images "$opencv_images" \
    --corners "$work/new/opencv_chess_corners" --matches "$work/new/opencv_chess_sift"
make_set make_pairs.py --out "$work/new/motorcycle_sift" --calib "$here/calib/motorcycle.json" \
    --left "$skimage_images/motorcycle_left.png" --right "$skimage_images/motorcycle_right.png"
make_set make_pairs.py --out "$work/new/aloe_sift" --calib "$here/calib/aloe.json" \
    --left "$opencv_images/aloeL.jpg" --right "$opencv_images/aloeR.jpg"
make_set make_pairs.py --out "$work/new/oak_sift" --calib "$here/calib/oak.json" \
    --left "$oak_images"/*_left.png --right "$oak_images"/*_right.png

make_set make_images.py --out "$work/new/images" --chess "$opencv_images" --motorcycle "$skimage_images"

say "7/7 comparing with the committed sets"
different=()
for name in "${sets[@]}"; do
    "$work/venv/bin/python" -B "$here/compare.py" "$work/new/$name" "$data/$name" || different+=("$name")
done
diff -rq "$work/new/images" "$data/images" || different+=(images)

if [ "${#different[@]}" -eq 0 ]; then
    say "PASS: all ${#sets[@]} sets and the images are the same as the committed ones"
elif [ "$write" = yes ]; then
    for name in "${different[@]}"; do
        rm -rf "${data:?}/$name"
        cp -r "$work/new/$name" "$data/$name"
    done
    say "WRITTEN: ${different[*]}"
else
    printf 'FAIL: %s\n' "not the same as committed (see above): ${different[*]}" >&2
    exit 1
fi
