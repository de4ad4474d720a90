#!/bin/sh
# SPDX-License-Identifier: MIT
# Instructions per frame set of the native detector on one thread, as a Markdown table: the same digits on every run,
# however busy the machine is.
#   callgrind.sh [BUILD]     BUILD: a folder with benchmarks/tick in it (default: build/bench)
# Exit code 77 without valgrind. KERNELS="AVX2 SSE2 portable", SCENES="0 20 200" and ITERATIONS=8 can be set.
set -eu
build=${1:-$(dirname "$0")/../build/bench}
tick=$build/benchmarks/tick
kernels=${KERNELS:-AVX2 SSE2 portable}
scenes=${SCENES:-0 20 200}
iterations=${ITERATIONS:-8}
if ! command -v valgrind >/dev/null 2>&1; then
  echo "SKIPPED: valgrind is not installed" >&2
  exit 77
fi
if [ ! -x "$tick" ]; then
  echo "callgrind.sh: $tick: no such program; cmake --workflow --preset bench builds it" >&2
  exit 1
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
printf '| instructions per frame set |'
for scene in $scenes; do printf ' %s blobs per camera |' "$scene"; done
printf '\n|---|'
for scene in $scenes; do printf -- '---:|'; done
printf '\n'
for kernel in $kernels; do
  printf '| %s |' "$kernel"
  for scene in $scenes; do
    # The scene is drawn and the detector warmed up outside of glint_tick(), so they do not count.
    if ! valgrind --tool=callgrind --toggle-collect=glint_tick --callgrind-out-file=/dev/null \
      "$tick" --kernels "$kernel" --threads 1 --scene "$scene" --iterations "$iterations" >"$log" 2>&1; then
      cat "$log" >&2
      exit 1
    fi
    collected=$(sed -n 's/.*Collected : \([0-9]*\).*/\1/p' "$log")
    printf ' %s |' "$((collected / iterations))"
  done
  printf '\n'
done
