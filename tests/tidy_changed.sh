#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# clang-tidy on the C++ files that differ from a commit, uncommitted and new ones included.
#   tests/tidy_changed.sh           against the last commit of main that this work started from
#   tests/tidy_changed.sh COMMIT
#   tests/tidy_changed.sh --all
# Exit code 77 without clang-tidy.
set -euo pipefail
cd "$(dirname "$0")/.."
if ! command -v clang-tidy >/dev/null; then
  echo "SKIPPED: clang-tidy is not installed (host/install_packages dev)"
  exit 77
fi
# Clang cannot read headers that GCC has precompiled, and each file is to be seen by itself.
cmake --preset dev -B build/tidy -DGLINT_PCH=OFF -DGLINT_UNITY=OFF --log-level=WARNING >/dev/null
cmake --build build/tidy --target glint_spirv >/dev/null
if [ "${1:-}" = --all ]; then
  mapfile -t files < <(find gpu host tests benchmarks -name '*.cpp' 2>/dev/null | sort)
else
  base=${1:-$(git merge-base HEAD origin/main 2>/dev/null || git rev-parse --verify -q 'HEAD~1' || echo)}
  mapfile -t files < <({
    if [ -n "$base" ]; then git diff --name-only --diff-filter=d "$base" -- '*.cpp'; else git ls-files '*.cpp'; fi
    git ls-files --others --exclude-standard '*.cpp'
  } | sort -u)
fi
# Only what the build knows: benchmarks are not built by the dev preset.
known=()
for file in "${files[@]}"; do
  if grep -q "\"$PWD/$file\"" build/tidy/compile_commands.json; then known+=("$file"); fi
done
echo "clang-tidy on ${#known[@]} files"
[ ${#known[@]} -gt 0 ] || exit 0
printf '%s\n' "${known[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/tidy --quiet --warnings-as-errors='*'
