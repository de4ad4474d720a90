#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs node with these arguments, after seeing to it that the packages of package-lock.json are there (npm ci, once).
#   with_node.sh ARGUMENT...
# Where node, npm or the packages cannot be had it says SKIPPED and ends with 77, or with 1 if GLINT_REQUIRE names board.
here=$(cd "$(dirname "$0")" && pwd)

missing() {
  case " $(echo "${GLINT_REQUIRE:-}" | tr ',' ' ') " in
    *" board "*)
      echo "$1 (GLINT_REQUIRE names board, so this is a failure)" >&2
      exit 1
      ;;
  esac
  echo "SKIPPED: $1"
  exit 77
}

command -v node >/dev/null || missing "node is not installed; run: host/install_packages board"
[ "$(node -p 'Number(process.versions.node.split(".")[0]) >= 18')" = true ] || missing "node $(node --version) is older than 18"

# One at a time, and only where what lies there is not what the lock file says.
(
  flock 9
  cmp -s "$here/package-lock.json" "$here/node_modules/.glint-installed" && exit 0
  command -v npm >/dev/null || missing "npm is not installed; run: host/install_packages board"
  cd "$here" && npm ci --ignore-scripts --no-audit --no-fund >node_modules.log 2>&1 || {
    tail -n 5 node_modules.log
    missing "npm cannot fetch the packages of tests/board/package-lock.json"
  }
  rm -f node_modules.log
  cp package-lock.json node_modules/.glint-installed
) 9>"$here/.lock" || exit $?
exec node "$@"
