#!/usr/bin/env bash
# run_in_vm.sh OUT [options] -- COMMAND...: boots Debian's kernel in QEMU (no KVM, virtual time: what the guest sees
# does not depend on this machine's load), runs COMMAND there in a shell and returns its exit code.
#   --load "MODULE [parameter=value...]"  in this order; with what it needs
#   --program FILE [--program FILE...]    copied to /bin in the guest, with its shared libraries
#   --qemu "ARGUMENTS"                    further devices; files of theirs lie in OUT
#   --memory MB  --timeout SECONDS
#   --cache FOLDER                        for the guest's kernel; FRINGETWIN_VM_CACHE is used instead where it is set
# OUT is /host in the guest, read and write; its console is OUT/serial.log. / of this machine is /root there, read only,
# when --root is given.
# Exit 77: skipped, with the reason; an error instead where CI or FRINGETWIN_REQUIRE_DEVICE is set. Exit 99: the guest
# did not come to an end.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$1
shift
loads=() programs=() qemu=() memory=768 limit=500 root= cache=$here/../../build
while [ "$1" != -- ]; do
  case "$1" in
    --load) loads+=("$2") && shift 2 ;;
    --program) programs+=("$2") && shift 2 ;;
    --qemu) read -ra more <<<"$2" && qemu+=("${more[@]}") && shift 2 ;;
    --memory) memory=$2 && shift 2 ;;
    --timeout) limit=$2 && shift 2 ;;
    --cache) cache=$2 && shift 2 ;;
    --root) root=1 && shift ;;
    *) echo "run_in_vm.sh: unknown option $1" >&2 && exit 2 ;;
  esac
done
shift
command=$*

skip() {
  if [ -n "${CI:-}${FRINGETWIN_REQUIRE_DEVICE:-}" ]; then
    echo "run_in_vm.sh: $1" >&2
    exit 1
  fi
  echo "skipped: $1"
  exit 77
}
for tool in qemu-system-x86_64 busybox cpio modprobe apt-get dpkg-deb flock; do
  PATH=$PATH:/usr/sbin:/sbin command -v "$tool" >/dev/null || skip "$tool is missing (packages.txt names its package)"
done
export PATH=$PATH:/usr/sbin:/sbin

now() { date +%s.%N; }
t0=$(now)
cache=${FRINGETWIN_VM_CACHE:-$cache}/vm
mkdir -p "$cache" "$out"
cache=$(cd "$cache" && pwd) out=$(cd "$out" && pwd)
status=0
"$here/get_guest.sh" "$cache" || status=$?
[ "$status" -ne 3 ] || skip "apt does not deliver the guest's kernel ($cache/apt.log)"
[ "$status" -eq 0 ] || exit "$status"
guest=$cache/guest
version=$(cat "$guest/version")
t1=$(now)

# --- the guest's file system
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
mkdir -p "$tree"/{bin,proc,sys,dev,tmp,host,root,modules}
cp "$(command -v busybox)" "$tree/bin/busybox"
order() { modprobe -d "$guest" -S "$version" --show-depends "$1" | awk '$1 == "insmod" { print $2 }'; }
add_module() { # "NAME parameters": what it needs first, then itself with its parameters
  local name parameters
  read -r name parameters <<<"$1"
  local file
  for file in $(order "$name"); do
    cp -n "$file" "$tree/modules/"
    [ "$(basename "$file" .ko | tr - _)" = "$(tr - _ <<<"$name")" ] && echo "load $(basename "$file") $parameters" ||
      echo "load $(basename "$file")"
  done
}
{
  cat "$here/init.sh"
  for module in virtio_pci 9pnet_virtio 9p ${loads[@]+"${loads[@]}"}; do add_module "$module"; done
  echo "mount_host ${root:-}"
  printf 'cd /host\n(\n%s\n)\nfinish $?\n' "$command"
} >"$tree/init"
chmod +x "$tree/init"
strip --strip-debug "$tree"/modules/*.ko
for program in ${programs[@]+"${programs[@]}"}; do
  cp "$program" "$tree/bin/"
  { ldd "$program" 2>/dev/null || true; } | awk '/=>/ { print $3 } $1 ~ /^\// { print $1 }' | while read -r library; do
    mkdir -p "$tree$(dirname "$library")"
    cp -Ln "$library" "$tree$library"
  done
done
(cd "$tree" && find . | cpio -o -H newc --quiet) >"$out/initramfs"
t2=$(now)

# --- the machine: one processor whose clock counts instructions
[ -z "$root" ] || qemu+=(-fsdev "local,id=root,path=/,security_model=none,readonly=on,multidevs=remap"
  -device virtio-9p-pci,fsdev=root,mount_tag=root)
rm -f "$out/serial.log"
cd "$out" # names of sockets are short
timeout "$limit" qemu-system-x86_64 -machine q35 -accel tcg,thread=single -icount shift=0,sleep=off -cpu max -smp 1 \
  -m "$memory" -display none -nodefaults -no-reboot -chardev "file,id=serial,path=$out/serial.log" -serial chardev:serial \
  -kernel "$guest/boot/vmlinuz-$version" -initrd "$out/initramfs" \
  -append "console=ttyS0 quiet panic=-1 mitigations=off nokaslr" \
  -fsdev "local,id=host,path=$out,security_model=none" -device virtio-9p-pci,fsdev=host,mount_tag=host \
  ${qemu[@]+"${qemu[@]}"} || echo "run_in_vm.sh: qemu ended with $? (124: after $limit s)" >&2
rm -f "$out/initramfs"
tr -d '\r' <"$out/serial.log" | sed '/^@@/d'
awk -v a="$t0" -v b="$t1" -v c="$t2" -v d="$(now)" -v v="$version" \
  'BEGIN { printf "guest Linux %s: fetch %.1f s, pack %.1f s, run %.1f s\n", v, b - a, c - b, d - c }'
code=$(tr -d '\r' <"$out/serial.log" | sed -n 's/^@@END \([0-9]*\)$/\1/p')
exit "${code:-99}"
