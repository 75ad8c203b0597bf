#!/bin/sh
# Passes the tests: those of the C++ core, then those of the Python package, the command line, the
# accuracy against other libraries, and the C++ consumer of the installed library.
set -eu
cd "$(dirname "$0")"

[ -x .venv/bin/genus ] || ./setup.sh
export CC="${CC:-cc}" CXX="${CXX:-c++}"

echo "== C++ tests"
cmake --preset release -Wno-dev >build-release.log 2>&1 || { cat build-release.log; exit 1; }
rm -f build-release.log
cmake --build --preset release
ctest --test-dir build/release --output-on-failure -j "$(nproc)"

echo "== Python tests"
.venv/bin/pip install --quiet --no-build-isolation --no-deps .
exec .venv/bin/python -m pytest
