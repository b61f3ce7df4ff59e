// SPDX-License-Identifier: Apache-2.0
// Gives memory back to the system that the program has freed.
#pragma once

namespace fringetwin {

/// Gives back what the allocator keeps of freed memory to allocate again: worth it after a stage that freed
/// whole images, before one that lasts. Takes some milliseconds. Nothing happens without glibc.
void give_freed_memory_back();

}  // namespace fringetwin
