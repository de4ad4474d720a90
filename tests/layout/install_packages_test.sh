#!/bin/sh
# SPDX-License-Identifier: MIT
# host/install_packages against made-up dpkg-query, apt-get, id and sudo: nothing is really installed.
set -eu
cd "$(dirname "$0")/../.."
script=$PWD/host/install_packages
box=$(mktemp -d)
trap 'rm -rf "$box"' EXIT
bin=$box/bin
mkdir "$bin"
for tool in sh awk tr cat dirname env mktemp rm; do ln -s "$(command -v $tool)" "$bin/$tool"; done
# Installed is what the file lists, a package on each line and after it what it provides, as dpkg-query prints it.
cat >"$bin/dpkg-query" <<EOF
#!/bin/sh
[ "\$*" = '-W -f \${db:Status-Status} \${Package} \${Provides}\\n' ] || { echo "asked: \$*"; exit 1; }
while read -r line; do echo "installed \$line"; done <$box/installed
echo "config-files cmake "
EOF
cat >"$bin/apt-get" <<EOF
#!/bin/sh
echo "\$@" >>$box/calls
exit \$(cat $box/apt_result)
EOF
printf '#!/bin/sh\ncat %s/user\n' "$box" >"$bin/id"
chmod +x "$bin"/*
echo 0 >"$box/user"
echo 0 >"$box/apt_result"
all=$(awk -F '\t' '$1 == "run" || $1 == "build" { print $2 }' docs/dependencies.tsv)
bad=0

# expect NAME RESULT TEXT ARGUMENTS...: the script ends with RESULT and its output holds TEXT.
expect() {
  name=$1 result=$2 text=$3
  shift 3
  : >"$box/calls"
  got=0
  env -i PATH="$bin" "$script" "$@" >"$box/out" 2>&1 || got=$?
  if [ "$got" != "$result" ] || { [ -n "$text" ] && ! grep -qF -- "$text" "$box/out"; }; then
    echo "FAILED $name: result $got, wanted $result, and the text '$text' in:"
    cat "$box/out"
    bad=1
  fi
}
called() { grep -qF -- "$1" "$box/calls" || { echo "FAILED: no call with '$1' among:"; cat "$box/calls"; bad=1; }; }

echo "$all" >"$box/installed"
expect 'all is there' 0 '' run build
[ ! -s "$box/calls" ] || { echo "FAILED: apt-get was called though all is there"; bad=1; }

echo "$all" | grep -vx cmake >"$box/installed"
expect 'one is missing' 0 'Installing: cmake' run build
called 'update'
called 'install -y --no-install-recommends cmake'

echo "$all" | sed 's/^cmake$/kitware-cmake libfoo (= 1), cmake (= 3.30), cmake-data/' >"$box/installed"
expect 'another package provides it' 0 '' run build
[ ! -s "$box/calls" ] || { echo "FAILED: apt-get was called for what another package provides"; bad=1; }
echo "$all" | sed 's/^cmake$/my-cmake cmake-extras, libcmake (= 1)/' >"$box/installed"
expect 'nearly its name' 0 'Installing: cmake' run build

echo "$all" | grep -vx cmake >"$box/installed"
echo 100 >"$box/apt_result"
expect 'apt-get fails' 1 'apt-get failed' build
echo 0 >"$box/apt_result"

echo 1000 >"$box/user"
expect 'no root, no sudo' 1 'apt-get install --no-install-recommends cmake' build
printf '#!/bin/sh\necho sudo >>%s/calls\nexec "$@"\n' "$box" >"$bin/sudo"
chmod +x "$bin/sudo"
expect 'no root but sudo' 0 'Installing: cmake' build
called sudo
called 'install -y'

expect 'unknown group' 2 "no group 'everything'" everything
expect 'no group' 2 'usage'
rm "$bin/apt-get"
expect 'no Debian' 1 'no Debian-like system' build
[ "$bad" = 0 ] && echo "All as expected."
exit $bad
