#!/bin/busybox sh
# First process of the guest; run_in_vm.sh appends what to load and to run.
/bin/busybox --install -s /bin
export PATH=/bin LD_LIBRARY_PATH=/lib/x86_64-linux-gnu:/usr/lib/x86_64-linux-gnu
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
exec </dev/ttyS0 >/dev/ttyS0 2>&1

load() {
  file=$1
  shift
  [ -d "/sys/module/$(echo "${file%.ko}" | tr - _)" ] || insmod "/modules/$file" "$@" || echo "$file does not load"
}
mount_host() {
  options=trans=virtio,version=9p2000.L,msize=262144
  mount -t 9p -o "$options,cache=none" host /host || echo "no 9p"
  [ -z "$1" ] || mount -t 9p -o "ro,$options,cache=loose" root /root || echo "no 9p of the root"
}
finish() {
  cd /
  sync
  umount /host
  echo "@@END $1"
  poweroff -f
}
