#!/bin/sh
# SPDX-License-Identifier: MIT
# All C++ files are as clang-format 14 leaves them. Exit code 77 (skipped) without clang-format.
#   check_format.sh          names the files that are not
#   check_format.sh --fix    formats them
set -eu
cd "$(dirname "$0")/../.."
tool=
for candidate in clang-format-14 clang-format; do
  if command -v "$candidate" >/dev/null 2>&1; then
    tool=$candidate
    break
  fi
done
if [ -z "$tool" ]; then
  echo "SKIPPED: clang-format is not installed (host/install_packages test)"
  exit 77
fi
version=$("$tool" --version | sed -n 's/.*version \([0-9]*\).*/\1/p')
if [ "$version" != 14 ]; then
  echo "SKIPPED: the files are formatted with clang-format 14, here is $version"
  exit 77
fi
files() { find gpu host shaders/interface firmware usb-sync tests benchmarks -name '*.cpp' -o -name '*.hpp' -o -name '*.h' 2>/dev/null | grep -v node_modules | sort; }
if [ "${1:-}" = --fix ]; then
  files | xargs "$tool" -i
  exit 0
fi
bad=$(files | xargs "$tool" --dry-run -Werror 2>&1 | sed -n 's/^\([^:]*:[0-9]*\):.*error:.*/\1/p' | sort -u -t : -k 1,1)
[ -n "$bad" ] || exit 0
echo "$bad" | sed 's|$|: not as clang-format leaves it; run tests/layout/check_format.sh --fix|'
exit 1
