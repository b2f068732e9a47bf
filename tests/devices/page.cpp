#include "page.hpp"

namespace sinew::test {
namespace {

constexpr const char* kHead = R"(# What each device does when it fails

This page is written by the test `devices_fault_test`, which plays every cell: the real board, drivers and `hal/linux` on a simulated
kernel, bus or line, in virtual time, in a robot that is armed and moves. `SINEW_WRITE_DOCS=1 devices_fault_test` writes it anew; the
test fails when it differs from what was just measured, and when a driver that a robot file can name has no table here.

- **Read**: what `sinew run` prints on standard error (`sinew: ...`), before it starts and while it runs, and after `NAME_...:` what `sinew arm`
  answers, word for word. N is a number that changes.
- **Guardian**: what it does, with `[[failsafe]]` conditions such as every robot should have ([safety](../safety.md)): a sensor that is silent for
  200 ms (a camera for 500 ms, a satellite or radio receiver for 1 s), that repeats itself for 400 ms (2 s), whose numbers cannot be, a pilot who
  is lost: all with `action = "stop"`, armed by hand. Times are from the fault to the stop.
- **Back**: what it takes after the fault is over, measured: the device's own return, and what lets commands pass again.
)";

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

}  // namespace

std::string section_of(const std::vector<Cell>& cells) {
  std::string text = "\n## " + cells.front().device + "\n\n| fault | read | guardian | back |\n|---|---|---|---|\n";
  for (const Cell& cell : cells) {
    std::string read;
    for (const std::string& line : cell.read) read += (read.empty() ? "" : "<br>") + escaped(line);
    text += "| " + cell.fault + " | " + read + " | " + escaped(cell.guardian) + " | " + escaped(cell.recovery) + " |\n";
  }
  return text;
}

std::string page_of(const std::vector<std::vector<Cell>>& devices) {
  std::string page = kHead;
  for (const auto& cells : devices) page += section_of(cells);
  return page;
}

}  // namespace sinew::test
