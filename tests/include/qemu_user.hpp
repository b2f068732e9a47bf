#pragma once
// Tests of boards run here in qemu-user, a processor's emulator on this machine's kernel. Tests of features that it
// lacks are skipped there, by name; the list is in docs/boards.md.
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

namespace sinew::test {

/// The command line of qemu-user for this program ("qemu-arm -L SYSROOT"), as our toolchain files set it; null: not in
/// qemu-user.
inline const char* qemu_user() { return std::getenv("SINEW_QEMU_USER"); }

/// The command line of another program of this build: the kernel only starts it on the right machine.
inline std::vector<std::string> command(const std::string& program, std::vector<std::string> arguments) {
  std::vector<std::string> words;
  if (qemu_user()) {
    std::istringstream emulator(qemu_user());
    words.push_back("/usr/bin/env");  // looks for the emulator, as a shell would
    for (std::string word; emulator >> word;) words.push_back(word);
  }
  words.push_back(program);
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

}  // namespace sinew::test

/// Skips the test there; `lacks` says what qemu-user does not do.
#define SINEW_SKIP_UNDER_QEMU_USER(lacks) \
  if (sinew::test::qemu_user()) GTEST_SKIP() << "qemu-user: " << (lacks)
