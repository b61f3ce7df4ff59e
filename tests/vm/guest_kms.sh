#!/bin/busybox sh
# In the guest: the tests of page flips, one of them that must fail, and last the one that loses a card.
vm_kms --gtest_filter='-*Unplugged*' || exit
if FRINGETWIN_VM_WRONG=1 vm_kms --gtest_filter='*KmsPatterns*virtio' >wrong.log; then
  echo "a wrong expectation passes"
  exit 1
fi
grep -q "7 of 8 exact\|0 of 8 exact\|8 of 8 exact" wrong.log || { echo "it fails otherwise than it should"; cat wrong.log; exit 1; }
echo "a wrong expectation fails, as it must"
vm_kms --gtest_filter='*Unplugged*'
