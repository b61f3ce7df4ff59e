#!/bin/busybox sh
# In the guest: the tests of page flips, then one of them that must fail.
vm_kms || exit
if FRINGETWIN_VM_WRONG=1 vm_kms --gtest_filter='*KmsPatterns*virtio' >wrong.log; then
  echo "a wrong expectation passes"
  exit 1
fi
echo "a wrong expectation fails, as it must"
