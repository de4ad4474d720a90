#!/bin/sh
# SPDX-License-Identifier: MIT
# First process of the guest: loads modules, mounts the host's files, runs one command among them, says how it ended.
# run_in_guest.py puts into /job: modules (a line each: name, options), copy (files for tmpfs), command (a script), and
# network and out where they are wanted.
# Serial lines: ttyS0 this log, ttyS1 and ttyS2 the command's outputs, ttyS3 its exit code.
# shellcheck disable=SC2013,SC2015  # names have no spaces; nothing fails after what is tested
export PATH=/bin

answer() {
  echo "$1" >/dev/ttyS3
  poweroff -f
}
fail() {
  echo "guest: $*"
  dmesg | tail -n 40
  answer 125
}

# load NAME [OPTION=VALUE...]: the module after all that it needs.
load() {
  name=$1
  shift
  [ -e "/modules/order/$name" ] || fail "no module $name in the initrd (DEVICE_MODULES in build_guest.py)"
  for file in $(cat "/modules/order/$name"); do
    loaded=/sys/module/$(echo "${file%.ko}" | tr - _)
    [ -d "$loaded" ] && continue
    case "$(echo "$name.ko" | tr - _)" in
      "$(echo "$file" | tr - _)") insmod "/modules/$file" "$@" || fail "insmod $file $* failed" ;;
      *) insmod "/modules/$file" || fail "insmod $file failed" ;;
    esac
  done
}

mount -t proc proc /proc && mount -t sysfs sysfs /sys && mount -t devtmpfs dev /dev || fail "no /proc, /sys or /dev"
mkdir -p /dev/shm /dev/pts && mount -t tmpfs shm /dev/shm && mount -t devpts pts /dev/pts
ln -s /proc/self/fd /dev/fd
for line in 1 2 3; do stty raw -echo </dev/ttyS$line; done

for name in $(cat /modules/base); do load "$name"; done
over_virtio=trans=virtio,version=9p2000.L,msize=1048576
mount -t 9p -o $over_virtio,ro,cache=loose host /host || fail "the host's root cannot be mounted"
# shellcheck disable=SC2086  # the line is meant to be split into name and options
while read -r line; do load $line; done </job/modules
if [ -e /job/network ]; then
  load virtio_net
  ifconfig lo 127.0.0.1 && ifconfig eth0 10.0.2.15 netmask 255.255.255.0 || fail "no network"
fi

mount -t proc proc /host/proc && mount -t sysfs sysfs /host/sys && mount --bind /dev /host/dev &&
  mount -t tmpfs -o size=90% run /host/run || fail "the host's root cannot be entered"
mkdir -p /host/run/job/lib /host/run/tmp /host/run/out
# What runs must not wait for the host while the virtual clock runs on: it lies in memory before it starts.
while read -r from to; do
  cp "/host$from" "/host/run/job/$to" || fail "copying $from failed"
done </job/copy
cp /job/command /host/run/job/command

echo "guest: the command starts"
chroot /host /bin/sh /run/job/command </dev/null >/dev/ttyS1 2>/dev/ttyS2
result=$?
echo "guest: the command ended with $result"
[ $result = 0 ] || dmesg | tail -n 60
if [ -e /job/out ]; then
  mkdir /out && mount -t 9p -o $over_virtio out /out && cp -r /host/run/out/. /out/ || fail "results cannot be copied out"
fi
answer $result
