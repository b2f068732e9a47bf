// For team_frame_test.py: reads datagrams from standard input, one a line in hexadecimal, and prints one line for each:
// what the reader says, and the frame as the writer writes it again.
//   ok robot team start sequence sent | robot start sequence sent received | topic type sequence stamp cdr | ... =
//   frame no WHY
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "wire/team_frame.hpp"

namespace {

using namespace sinew::wire;

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string out;
  char two[3];
  for (const std::uint8_t b : bytes) std::snprintf(two, sizeof two, "%02x", b), out += two;
  return out;
}

std::string answer(const std::vector<std::uint8_t>& bytes) {
  TeamReader frame;
  if (const char* why = frame.open(bytes)) return std::string("no ") + why;
  const TeamHead& h = frame.head();
  std::vector<std::uint8_t> space(bytes.size());
  TeamWriter again(space, h);
  std::string out = "ok " + std::to_string(h.robot) + ' ' + std::to_string(h.team) + ' ' + std::to_string(h.start) +
                    ' ' + std::to_string(h.sequence) + ' ' + std::to_string(h.sent_ns);
  for (std::size_t i = 0; i < frame.echoes(); ++i) {
    const TeamEcho e = frame.echo(i);
    again.add(e);
    out += " | " + std::to_string(e.robot) + ' ' + std::to_string(e.start) + ' ' + std::to_string(e.sequence) + ' ' +
           std::to_string(e.sent_ns) + ' ' + std::to_string(e.received_ns);
  }
  while (const auto m = frame.next()) {
    again.add(*m);
    out += " | " + std::string(m->topic) + ' ' + std::to_string(m->type_hash) + ' ' + std::to_string(m->sequence) +
           ' ' + std::to_string(m->stamp_ns) + ' ' + hex(m->cdr);
  }
  return out + " = " + hex(again.finish());
}

}  // namespace

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i + 1 < line.size(); i += 2)
      bytes.push_back(static_cast<std::uint8_t>(std::stoi(line.substr(i, 2), nullptr, 16)));
    std::puts(answer(bytes).c_str());
  }
}
