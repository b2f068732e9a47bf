#include "apps/replay/drawn_again.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "apps/command/place.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostWaiting = 32;  // pictures of a camera of which the recording has no heads

}  // namespace

std::unique_ptr<DrawnAgain> DrawnAgain::start(const std::string& scenes, const std::string& robot,
                                              const rt::Graph& graph, std::string& why) {
  const std::string program = find_program("sinew-sim");
  if (program.empty()) {
    why = "--pictures: sinew-sim, which draws them, is neither beside this program nor in PATH";
    return nullptr;
  }
  if (std::error_code none; !std::filesystem::exists(scenes, none)) {
    why = "--pictures " + scenes + ": no such file";
    return nullptr;
  }
  std::unique_ptr<DrawnAgain> drawn(new DrawnAgain());
  for (const rt::GraphModule& m : graph.modules()) {
    if (m.spec.type != "drivers::CameraSource") continue;
    const auto given = m.spec.params.find("device");
    const auto* const name = given == m.spec.params.end() ? nullptr : std::get_if<std::string>(&given->second.value);
    for (std::size_t p = 0; p < m.topic.size(); ++p)
      if (m.topic[p] != rt::kNone && graph.topics()[m.topic[p]].type->has_bulk())
        drawn->device_[m.topic[p]] = name ? *name : "camera";
  }
  hal::ChildOptions how;
  how.piped = true;
  how.hears_terminal = false;
  how.killed_when_we_die = true;
  auto child = hal::ChildProcess::start({program, "--redraw", scenes, "--of", robot}, how);
  if (!child) {
    why = fmt::format("cannot start {}: {}", program, hal::to_string(child.error().code));
    return nullptr;
  }
  drawn->child_ = std::move(*child);
  if (drawn->read()) return drawn;
  const auto end = drawn->errors_.find('\n');
  why = "--pictures " + scenes + ": " +
        (drawn->errors_.empty() ? "no picture of " + robot : drawn->errors_.substr(0, end));
  return nullptr;
}

bool DrawnAgain::read() {
  std::size_t head = std::string::npos, bytes = 0;
  char device[64];
  unsigned number = 0;
  for (;;) {
    if (head == std::string::npos) head = output_.find('\n');
    if (head != std::string::npos && bytes == 0 &&
        (head > 120 || std::sscanf(output_.substr(0, head).c_str(), "%63s %u %zu", device, &number, &bytes) != 3 ||
         bytes == 0)) {
      errors_ += "not what sinew-sim writes\n";
      return false;
    }
    if (bytes > 0 && output_.size() >= head + 1 + bytes) break;
    const bool ended = child_->poll().has_value();
    if (child_->read_output(output_, errors_)) continue;
    if (ended) return false;
    std::vector<std::size_t> ready;
    hal::ChildProcess* const child = child_.get();
    hal::ChildProcess::wait_for_any({&child, 1}, 100ms, ready);
  }
  auto& waiting = waiting_[device];
  if (waiting.size() == kMostWaiting) waiting.pop_front();
  waiting.push_back({number, output_.substr(head + 1, bytes)});
  output_.erase(0, head + 1 + bytes);
  return true;
}

std::span<const std::byte> DrawnAgain::pixels(std::uint32_t topic, const record::ImageHead& head) {
  const auto device = device_.find(topic);
  if (device == device_.end()) return {};
  auto& waiting = waiting_[device->second];
  for (;;) {
    while (!waiting.empty() && waiting.front().number < head.frame_number) waiting.pop_front();
    if (!waiting.empty()) break;
    if (!read()) return {};
  }
  if (waiting.front().number != head.frame_number) return {};
  taken_ = std::move(waiting.front());
  waiting.pop_front();
  return std::as_bytes(std::span(taken_.bytes));
}

}  // namespace sinew::app
