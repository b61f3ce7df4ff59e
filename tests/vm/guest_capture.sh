#!/bin/busybox sh
# guest_capture.sh PROGRAM: in the guest, the program as built on the host, with the host's libraries: its root is the
# host's (run_in_vm.sh --root), /mnt the folder that both can write to. Two recordings of one twin.
program=$1
for folder in dev proc sys; do mount --bind "/$folder" "/root/$folder"; done
mount --bind /host /root/mnt
export HOME=/mnt
set -o pipefail
run() { env -u LD_LIBRARY_PATH chroot /root "$program" capture "$@" 2>&1 | cat; } # no terminal, no bar
record() { # DIR SECOND-INSTANCE options...
  set_folder=$1 second=$2
  shift 2
  run /mnt/twin.toml --out "/mnt/$set_folder" --camera left=/dev/video0 --camera "right=/dev/video$((2 * second))" \
    --display "v4l2:/dev/video1@Y12+v4l2:/dev/video$((2 * second + 1))@Y12" --format Y12 "$@"
}
expect() { # EXIT-CODE WHAT
  code=$?
  echo "$2: exit code $code"
  [ $code -eq "$1" ] || exit 1 # what runs beside ends with the guest
}

vivid_control setup 3 || exit
run --list >/host/list.txt
expect 0 list
record plain 1
expect 0 "undisturbed"

# Streams refused, broken, and an input without signal for a while: tried again until all is there.
(while [ ! -e /host/broken/left/0001.png ] && [ ! -e /tmp/broken.ended ]; do usleep 20000; done
for button in inject_vidioc_streamon_error inject_vidioc_reqbufs_error inject_vidioc_qbuf_error inject_fatal_streaming_error; do
  vivid_control push 0 $button
  usleep 300000
done
vivid_control set 0 dv_timings_signal_mode 1
usleep 500000
vivid_control set 0 dv_timings_signal_mode 0) &
record broken 1
expect 0 "streams broken, signal lost"
touch /tmp/broken.ended
wait

# Every seventh frame lost, some marked as corrupt: taken again. Then a camera is unplugged, with some images there,
# and another takes its place.
vivid_control set 0 percentage_of_dropped_buffers 15
vivid_control set 1 percentage_of_dropped_buffers 15
(while [ ! -e /host/disturbed/left/0005.png ] && [ ! -e /tmp/ended ]; do
  vivid_control push 0 inject_v4l2_buf_flag_error
  usleep 300000
done
vivid_control push 1 disconnect) &
record disturbed 1 --settle 6 # so many frames that some are lost for sure
expect 4 "unplugged"
touch /tmp/ended
wait
vivid_control set 0 percentage_of_dropped_buffers 0
ls /host/disturbed/left >/host/before_resume.txt
record disturbed 2 --resume
expect 0 "resumed"
