#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Everything that must pass before a change is done, from installing packages to sanitizers; CI runs this too.
#   tests/run_all.sh              all of it
#   tests/run_all.sh --no-asan    without the second build for the sanitizers
# GLINT_TEST_DATA   folder of recordings; default ../shared/data where that exists, else such tests are skipped
# GLINT_REQUIRE     what must be there: default "gpu board", a Vulkan device (a software one will do) and the simulated
#                   sync board; with "vm" beside them, device tests in a guest kernel run too, some minutes; empty: nothing
set -euo pipefail
cd "$(dirname "$0")/.."
with_asan=1
case "${1:-}" in
  '') ;;
  --no-asan) with_asan=0 ;;
  *) sed -n '3,8s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
# CI gives half an hour on two cores, and the sanitizers take some eight minutes of it, although only for the tests of
# what runs at every exposure: a run of them that starts later than this might not end in time.
asan_latest_start_s=$((13 * 60))
jobs=$(nproc)

if [ -z "${GLINT_TEST_DATA+set}" ] && [ -d ../shared/data ]; then
  GLINT_TEST_DATA=$(cd ../shared/data && pwd)
  export GLINT_TEST_DATA
fi
export GLINT_REQUIRE="${GLINT_REQUIRE-gpu board}"

say() { printf '\n== %s (%d s)\n' "$*" "$SECONDS"; }
logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT
failed=()
notes=()

# ctest PRESET NAME OPTIONS...: one part of a test run; its log is kept for the totals.
run_tests() {
  local preset=$1 name=$2
  shift 2
  say "test $preset: $name"
  if ! ctest --preset "$preset" --no-tests=error "$@" | tee -a "$logs/ctest.txt"; then failed+=("$preset: $name"); fi
  cp "build/$preset/Testing/Temporary/LastTest.log" "$logs/$preset-$name.log" 2>/dev/null || true
}

# build PRESET TARGET
build() {
  say "build $1"
  if [ ! -e "build/$1/build.ninja" ]; then cmake --preset "$1"; fi
  cmake --build --preset "$1" --target "$2"
}

say "packages"
host/install_packages run build target test board
build dev all
run_tests dev steps -LE 'system|device' -j "$jobs"
# Tests of whole runs are paced by a clock: nothing else may run beside them.
if ctest --preset dev -N -L system | grep -q '^  *Test *#'; then run_tests dev system -L system; fi
case $GLINT_REQUIRE in
  *vm*)
    host/install_packages vm
    run_tests dev device -L device ;;
  *) notes+=("device tests: run them with: ctest --preset dev -L device") ;;
esac

if [ "$with_asan" = 0 ]; then
  notes+=("sanitizers: left out by --no-asan")
elif [ "$SECONDS" -gt "$asan_latest_start_s" ]; then
  notes+=("sanitizers: $((SECONDS / 60)) minutes are gone already; run them with: cmake --workflow --preset asan")
else
  build asan run_time_test_programs
  run_tests asan steps -L run-time -j "$jobs"
  notes+=("sanitizers for tests not labelled run-time: run them with: cmake --workflow --preset asan")
fi

say "totals"
passed_cases=$(cat "$logs"/*.log | sed -n 's/^\[  PASSED  \] \([0-9]*\) tests\{0,1\}\.$/\1/p' | awk '{ n += $1 } END { print n + 0 }')
failed_cases=$(cat "$logs"/*.log | sed -n 's/^\[  FAILED  \] \([A-Za-z0-9_/]*\.[A-Za-z0-9_/]*\).*(.*ms)$/\1/p' | sort -u)
skipped_cases=$(cat "$logs"/*.log | sed -n 's/^\[  SKIPPED \] \([A-Za-z0-9_/]*\.[A-Za-z0-9_/]*\).*(.*ms)$/\1/p' | sort -u)
skipped_programs=$(sed -n 's/.*Test *#[0-9]*: \([^ ]*\) \.*\*\*\*Skipped.*/\1/p' "$logs/ctest.txt" | sort -u)
programs=$(grep -c -E '^ *[0-9]+/[0-9]+ Test +#' "$logs/ctest.txt" || true)
echo "$programs test programs ran, with $passed_cases passed GoogleTest cases, in $SECONDS s"
for name in $skipped_programs $skipped_cases; do echo "SKIPPED: $name"; done
for note in ${notes[@]+"${notes[@]}"}; do echo "SKIPPED: $note"; done
for name in $failed_cases; do echo "FAILED: $name"; done
if [ ${#failed[@]} -gt 0 ]; then
  for part in "${failed[@]}"; do echo "FAILED: $part"; done
  exit 1
fi
echo "All passed."
