#!/usr/bin/env bash
# get_guest.sh CACHE: Debian's kernel with the modules the tests load, and v4l2loopback built for it, unpacked into
# CACHE/guest. Nothing is installed; the second call needs no network. Prints nothing but what goes wrong.
# Exit 3: apt could not deliver.
set -euo pipefail
cache=$1
guest=$cache/guest
mkdir -p "$cache"
exec 9>"$cache/lock"
flock 9 # tests run side by side
[ -e "$guest/complete" ] && exit 0

work=$cache/work
rm -rf "$work" "$guest"
mkdir -p "$work/headers" "$guest"

fetch() {
  (cd "$work" && apt-get -qq -o APT::Sandbox::User="$(id -un)" download "$@") >"$cache/apt.log" 2>&1
}
# The lists may name a kernel that the archive has replaced since.
kernel_version() {
  apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/.*Depends: linux-image-//p' | head -1
}
packages() {
  local version
  version=$(kernel_version)
  [ -n "$version" ] || return 1
  fetch "linux-image-$version" "linux-headers-$version" "linux-headers-${version%-amd64}-common" \
    "linux-kbuild-$(cut -d. -f1,2 <<<"$version")" v4l2loopback-dkms
}
if ! packages; then
  apt-get -qq update >>"$cache/apt.log" 2>&1 || true
  packages || { cat "$cache/apt.log" >&2; exit 3; }
fi
version=$(kernel_version)

unpack_kernel() { # a * of tar's also stands for slashes
  dpkg --fsys-tarfile "$work/linux-image-$version"_*.deb |
    tar -x -C "$guest" --wildcards --exclude='*/drm/amd/*' --exclude='*/drm/i915/*' --exclude='*/drm/nouveau/*' \
      --exclude='*/drm/radeon/*' './boot/vmlinuz-*' './lib/modules/*/modules.*' '*/kernel/drivers/media/*' \
      '*/kernel/drivers/virtio/*' '*/kernel/drivers/gpu/drm/*' '*/kernel/drivers/i2c/algos/*' '*/kernel/net/9p/*' \
      '*/kernel/fs/9p/*' '*/kernel/fs/netfs/*' '*/kernel/fs/fscache/*'
}

# The headers' own makefiles name /usr/src and /usr/lib.
build_loopback() {
  local root=$work/headers deb
  for deb in "$work"/linux-headers-*.deb "$work"/linux-kbuild-*.deb "$work"/v4l2loopback-dkms_*.deb; do
    dpkg-deb -x "$deb" "$root"
  done
  sed -i "s#/usr/src/#$root/usr/src/#" "$root"/usr/src/linux-headers-*-amd64/Makefile
  sed -i "s#/usr/src/#$root/usr/src/#g; s#/usr/lib/#$root/usr/lib/#g" "$root"/usr/src/linux-headers-*-amd64/.kernelvariables
  local source
  source=$(echo "$root"/usr/src/v4l2loopback-*)
  make -s -C "$root/usr/src/linux-headers-$version" M="$source" modules >"$cache/loopback.log" 2>&1 ||
    { cat "$cache/loopback.log" >&2; return 1; }
  install -D -m 644 "$source/v4l2loopback.ko" "$guest/lib/modules/$version/kernel/drivers/media/v4l2loopback.ko"
}

unpack_kernel
build_loopback
depmod -b "$guest" "$version"
echo "$version" >"$guest/version"
rm -rf "$work"
touch "$guest/complete"
