#!/bin/busybox sh
# guest_capture.sh PROGRAM ARGUMENTS...: in the guest, the program as built on the host, with the host's libraries:
# the host's / (run_in_vm.sh --root), where /mnt is the folder that both can write to.
for folder in dev proc sys; do mount --bind "/$folder" "/root/$folder"; done
mount --bind /host /root/mnt
export HOME=/mnt LD_LIBRARY_PATH=
exec chroot /root "$@"
