// SPDX-License-Identifier: Apache-2.0
// volk's implementation: it loads libvulkan at run time, so that the program starts without it.
#define VOLK_IMPLEMENTATION
#include <volk.h>
