#!/bin/sh
# Sets genus up in .venv and builds the bearing block, printing its report. For Debian 12 and
# Ubuntu 24.04 and later; elsewhere, install the tools named below by hand first.
set -eu
cd "$(dirname "$0")"

packages="ca-certificates ccache cmake fonts-liberation g++ libeigen3-dev libexpat1-dev libfreetype-dev libgtest-dev libharfbuzz-dev make ninja-build python3 python3-dev python3-venv zlib1g-dev"

missing() {
    for package in $packages; do
        dpkg-query -W -f '${Status}\n' "$package" 2>/dev/null | grep -q '^install ok installed' ||
            printf '%s ' "$package"
    done
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo "$@"
    else
        echo "setup.sh: run as root, or install sudo; needed: $packages" >&2
        exit 1
    fi
}

if command -v apt-get >/dev/null; then
    needed=$(missing)
    if [ -n "$needed" ]; then
        echo "== packages: $needed"
        as_root apt-get update -qq
        # shellcheck disable=SC2086  # a list of words
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
            $needed </dev/null
    fi
fi

# One name for the compiler here and in test.sh: what one of them compiled, ccache has for the other.
export CC="${CC:-cc}" CXX="${CXX:-c++}"

echo "== Python package into .venv"
# The system's interpreter, whose headers the packages above bring.
python=${PYTHON:-/usr/bin/python3}
[ -x .venv/bin/pip ] || "$python" -m venv .venv
.venv/bin/pip install --quiet 'scikit-build-core>=1.1' 'pybind11>=3.0'
# Without isolation, so that a second run compiles only what changed.
.venv/bin/pip install --quiet --no-build-isolation '.[test]'

echo "== models/bearing_block.scad"
.venv/bin/genus build models/bearing_block.scad -o bearing_block.stl --tolerance 0.05
