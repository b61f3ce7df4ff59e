#!/bin/busybox sh
# In the guest: the tests on the kernel's drivers, then one of them that must fail.
vm_v4l2 || exit
if FRINGETWIN_VM_WRONG=1 vm_v4l2 --gtest_filter='*VividLoop*GREY' >wrong.log; then
  echo "a wrong expectation passes"
  exit 1
fi
grep -q "0 of 8 exact\|7 of 8 exact" wrong.log || { echo "it fails otherwise than it should"; cat wrong.log; exit 1; }
echo "a wrong expectation fails, as it must"
