// SPDX-License-Identifier: Apache-2.0
// Nothing: the targets of this file hold the precompiled headers (fringetwin.cmake).
