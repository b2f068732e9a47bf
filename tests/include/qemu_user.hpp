#pragma once
// Tests of boards run here in qemu-user, a processor's emulator on this machine's kernel. What it does not do as a board
// would is left out there, by name; the list is in docs/boards.md.
#include <gtest/gtest.h>

#include <cstdlib>

namespace sinew::test {

/// Is this program run by qemu-user? Our toolchain files let it say so.
inline bool under_qemu_user() { return std::getenv("SINEW_QEMU_USER") != nullptr; }

}  // namespace sinew::test

/// Ends the test there, skipped, with what qemu-user does not do.
#define SINEW_SKIP_UNDER_QEMU_USER(lacks) \
  if (sinew::test::under_qemu_user()) GTEST_SKIP() << "qemu-user: " << (lacks)
