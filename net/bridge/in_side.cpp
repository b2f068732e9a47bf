#include "net/bridge/in_side.hpp"

#include <algorithm>
#include <cstring>

#include "hal/linux/shared_memory.hpp"
#include "hal/platform.hpp"
#include "msg/image.hpp"

namespace sinew::net {
namespace {

constexpr std::size_t next_place(std::size_t bytes) { return (bytes + 63) / 64 * 64; }

}  // namespace

using namespace nlohmann::literals;

InSide::InSide(BridgeShared& shared, std::vector<InLine> lines)
    : shared_(shared), lines_(std::move(lines)), robot_(shared.robot) {
  thread_ = std::thread([this] { run(); });
}

InSide::~InSide() { thread_.join(); }

void InSide::run() {
  std::uint64_t seen = 0;
  while (!shared_.stopped()) {
    if (!robot_.reach()) place_.reset();
    if (robot_ && !place_) connect();
    for (InLine& line : lines_) drain(line);
    hand_over();
    shared_.wait(seen, kLongestLook);
  }
}

void InSide::connect() {
  const auto reader = robot_->reader();
  if (!reader) return robot_.drop();
  std::size_t largest = 1, several = 0;
  for (InLine& line : lines_) {
    std::string why;
    line.translate.reset();
    const auto topic = (*reader)->find(line.spec->topic);
    const tap::Topic* about = topic ? &(*reader)->topics()[*topic] : nullptr;
    if (!about)
      why = "the robot has no such topic";
    else if (!about->info)
      why = "the robot's type " + about->type + " is not known here, or another version of it";
    else
      line.translate =
          ros2::Incoming::make(shared_.spec.distro, line.spec->type, *about->info, line.spec->options, why);
    if (!line.translate) {
      shared_.count(line.spec->key, [&](BridgedCounts& c) { c.why = why; });
      continue;
    }
    line.bytes = about->message_bytes, line.bulk_bytes = about->bulk_bytes;
    line.newest_only = about->info->has_bulk();
    const std::size_t bytes = next_place(std::size_t{line.bytes} + line.bulk_bytes);
    largest = std::max(largest, bytes);
    if (!line.newest_only) several = std::max(several, tap::kMostBytesAtOnce * bytes);
  }
  auto place = hal::create_shared_memory("sinew ros2", std::max(largest, several));
  if (!place) return robot_.drop();
  const auto reply = robot_->request_with_memory("publish.memory", "{}", **place);
  const Json json = reply ? Json::parse(*reply, nullptr, false) : Json();
  if (!json.is_object() || !json.value("ok", false)) return robot_.drop();
  place_ = std::move(*place);
  waiting_.clear();
  used_ = 0;
}

void InSide::drain(InLine& line) {
  while (line.reader->take(sample_)) {
    if (line.newest_only && line.reader->take(sample_)) {
      std::uint64_t skipped = 1;
      while (line.reader->take(sample_)) ++skipped;
      shared_.count(line.spec->key, [&](BridgedCounts& c) { c.skipped += skipped; });
    }
    if (place_ && (waiting_.size() == tap::kMostBytesAtOnce || used_ + line.bytes + line.bulk_bytes > place_->size()))
      hand_over();
    if (!place_)
      refuse(line, "the robot is not there");
    else if (line.translate)
      pass(line);
  }
}

void InSide::pass(InLine& line) {
  const std::int64_t robot_offset_ns = robot_.clock_offset_ns();  // asks the robot only in virtual time
  if (!robot_) return place_.reset(), refuse(line, "the robot is not there");
  const auto to_ros_ns = shared_.to_ros_ns(robot_offset_ns);
  if (!to_ros_ns) return refuse(line, "no /clock was heard in the last five seconds");
  void* const message = place_->data() + used_;
  const auto result = line.translate->decode(
      sample_.cdr, *to_ros_ns, message, line.bulk_bytes,
      [this](std::span<const std::uint8_t> file, msg::Image& out) { return pictures_.read(file, out); });
  if (result.skipped) return shared_.count(line.spec->key, [](BridgedCounts& c) { ++c.skipped; });
  if (!result) return refuse(line, std::string(result.error));
  std::size_t bytes = line.bytes;
  if (line.newest_only) bytes += static_cast<const msg::Image*>(message)->bulk_used();
  Waiting& waiting = waiting_.emplace_back(Waiting{&line, used_, bytes, std::nullopt});
  used_ += next_place(bytes);
  if (!result.stamp_ns) return;
  // Never later than its arrival; what is older than the robot's start cannot be said.
  const std::int64_t now_ns = hal::system_os().now().ns + robot_offset_ns;
  waiting.stamp_ns = std::clamp<std::int64_t>(*result.stamp_ns - *to_ros_ns, 1, std::max<std::int64_t>(now_ns, 1));
}

/// In one request: the robot takes 200 of them a second from one client, and a simulator's IMU has 1000 samples.
void InSide::hand_over() {
  if (waiting_.empty()) return;
  Json messages = Json::array();
  for (const Waiting& w : waiting_) {
    Json& message =
        messages.emplace_back(Json{{"topic", w.line->spec->topic}, {"offset", w.offset}, {"bytes", w.bytes}});
    if (w.stamp_ns) message["stamp_ns"] = *w.stamp_ns;
  }
  std::string why;
  const Json reply = robot_.ask("publish.bytes", {{"messages", std::move(messages)}}, why);
  std::vector<std::string> refused(waiting_.size(), why);
  if (reply.is_object())
    for (const Json& one : reply.value("refused", Json::array()))
      if (const std::size_t at = one.value("at", refused.size()); at < refused.size())
        refused[at] = one.value("/error/why"_json_pointer, std::string("the robot refuses"));
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (refused[i].empty())
      shared_.count(waiting_[i].line->spec->key, [](BridgedCounts& c) { ++c.messages; });
    else
      refuse(*waiting_[i].line, refused[i]);
  }
  waiting_.clear();
  used_ = 0;
  if (!robot_) place_.reset();
}

void InSide::refuse(const InLine& line, std::string why) {
  shared_.count(line.spec->key, [&](BridgedCounts& c) { ++c.refused, c.why = std::move(why); });
}

}  // namespace sinew::net
