#!/bin/sh
# Format, lint, types, warnings as errors, sanitizers. Stops at the first fault.
#   .ci/check.sh            all of it
#   .ci/check.sh --quick    without the sanitizers: seconds
set -eu
cd "$(dirname "$0")/.."

[ -x .venv/bin/pip ] || ./setup.sh
echo "== tools"
.venv/bin/pip install --quiet 'ruff>=0.5' 'mypy>=1.8' 'clang-format==14.0.6'

echo "== format"
find core bindings tests -name '*.h' -o -name '*.cpp' | sort |
    xargs .venv/bin/clang-format --dry-run -Werror
.venv/bin/ruff format --check --quiet .

echo "== lint"
.venv/bin/ruff check --quiet .
.venv/bin/mypy --no-error-summary

[ "${1:-}" = --quick ] && exit 0

# The thread sanitizer needs a fixed address layout on kernels that spread it widely.
without_aslr() {
    if setarch -R true 2>/dev/null; then setarch -R "$@"; else "$@"; fi
}

echo "== address and undefined-behaviour sanitizers, warnings as errors"
cmake --preset asan -Wno-dev >/dev/null
cmake --build --preset asan
ctest --test-dir build/asan --output-on-failure -j "$(nproc)"

echo "== thread sanitizer, on the tests that run threads against each other"
cmake --preset tsan -Wno-dev >/dev/null
cmake --build --preset tsan --target thread_test
GENUS_THREADS=4 without_aslr build/tsan/tests/core/thread_test --gtest_brief=1 \
    --gtest_filter='*Thread*:*Cancel*:*Parallel*'
