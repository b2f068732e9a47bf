#pragma once
// The faults, and the outcome of one cell of the matrix.
#include <array>
#include <string>
#include <vector>

namespace sinew::test {

/// The last two are of servos on a serial line alone.
enum class Fault { absent, denied, busy, unplugged, silent, garbage, slow, stuck, duplicate, reboots, alarm };
/// Of every device.
inline constexpr std::array kFaults{Fault::absent,  Fault::denied, Fault::busy,  Fault::unplugged, Fault::silent,
                                    Fault::garbage, Fault::slow,   Fault::stuck, Fault::duplicate};
inline const char* to_string(Fault fault) {
  constexpr const char* kNames[] = {"absent at start",
                                    "permission denied",
                                    "busy",
                                    "unplugged",
                                    "silent",
                                    "garbage",
                                    "slow",
                                    "stuck",
                                    "duplicate",
                                    "reboots",
                                    "says that it is faulty"};
  return kNames[static_cast<int>(fault)];
}
/// These are there before the run starts; the others strike while it is armed.
inline bool at_start(Fault fault) { return fault <= Fault::busy; }

/// Why a device cannot have a fault. There are no other reasons.
enum class Reason {
  shared,       // any number of programs may have it open
  no_number,    // its bytes do not show that two measurements are the same one
  kernel_only,  // only a kernel's own device can play it
};
inline const char* to_string(Reason reason) {
  constexpr const char* kTexts[] = {
      "cannot be: any number of programs may have it open at once",
      "cannot be told: nothing in what it sends says that two equal measurements are one; both count",
      "not played: only a kernel's own camera can; what was tried with one: [camera.md](../camera.md#what-was-tried)",
  };
  return kTexts[static_cast<int>(reason)];
}

/// How a rig plays a fault. Several ways have labels.
struct Way {
  std::string label{};
  std::vector<Reason> cannot{};  // empty: it can
  bool harmless = false;         // nobody has to notice it
};

struct Cell {
  std::string device, fault;      // title of the rig; fault and way
  std::vector<std::string> read;  // the texts that the user reads
  std::string guardian, recovery;
};

}  // namespace sinew::test
