#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds a fuzz program, makes what it starts from, and runs it; goes on from where the last run ended.
#   tests/fuzz/run.sh jpeg|v4l2 SECONDS [LIBFUZZER OPTIONS...]
# Inputs that break something lie in build/fuzz/findings afterwards; exit code 0 if there are none.
set -euo pipefail
cd "$(dirname "$0")/../.."
case "${1:-}" in
  jpeg) options=(-dict=tests/fuzz/jpeg.dict -max_len=8192) ;;
  v4l2) options=(-max_len=2048 -entropic_scale_per_exec_time=1) ;;
  *) sed -n '3,5s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
name=$1
seconds=${2:?how many seconds?}
shift 2
build=build/fuzz
if [ ! -e "$build/build.ninja" ]; then cmake --preset fuzz; fi
cmake --build --preset fuzz
mkdir -p "$build/corpus/$name" "$build/findings"
"$build/tests/fuzz/make_seeds" "$build/seeds"
exec "$build/tests/fuzz/fuzz_$name" "${options[@]}" -timeout=25 -max_total_time="$seconds" -print_final_stats=1 \
  -artifact_prefix="$build/findings/$name-" "$@" "$build/corpus/$name" "$build/seeds/$name"
