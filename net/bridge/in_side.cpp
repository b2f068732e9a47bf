#include "net/bridge/in_side.hpp"

#include <algorithm>
#include <cstring>

#include "hal/linux/shared_memory.hpp"
#include "hal/platform.hpp"
#include "msg/image.hpp"

namespace sinew::net {

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
    shared_.wait(seen, kLongestLook);
  }
}

void InSide::connect() {
  const auto reader = robot_->reader();
  if (!reader) return robot_.drop();
  std::size_t bytes = 1;
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
    bytes = std::max(bytes, std::size_t{line.bytes} + line.bulk_bytes);
  }
  auto place = hal::create_shared_memory("sinew ros2", bytes);
  if (!place) return robot_.drop();
  const auto reply = robot_->request_with_memory("publish.memory", "{}", **place);
  const Json json = reply ? Json::parse(*reply, nullptr, false) : Json();
  if (!json.is_object() || !json.value("ok", false)) return robot_.drop();
  place_ = std::move(*place);
}

void InSide::drain(InLine& line) {
  while (line.reader->take(sample_)) {
    if (line.newest_only && line.reader->take(sample_)) {
      std::uint64_t skipped = 1;
      while (line.reader->take(sample_)) ++skipped;
      shared_.count(line.spec->key, [&](BridgedCounts& c) { c.skipped += skipped; });
    }
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
  void* const message = place_->data();
  const auto result = line.translate->decode(sample_.cdr, *to_ros_ns, message, line.bulk_bytes);
  if (result.skipped) return shared_.count(line.spec->key, [](BridgedCounts& c) { ++c.skipped; });
  if (!result) return refuse(line, std::string(result.error));
  std::size_t bytes = line.bytes;
  if (line.newest_only) bytes += static_cast<const msg::Image*>(message)->bulk_used();
  Json arguments{{"topic", line.spec->topic}, {"offset", 0}, {"bytes", bytes}, {"wait", false}};
  if (result.stamp_ns) {
    // Never later than its arrival; what is older than the robot's start cannot be said.
    const std::int64_t now_ns = hal::system_os().now().ns + robot_offset_ns;
    arguments["stamp_ns"] =
        std::clamp<std::int64_t>(*result.stamp_ns - *to_ros_ns, 1, std::max<std::int64_t>(now_ns, 1));
  }
  std::string why;
  if (robot_.ask("publish.bytes", arguments, why).is_object()) {
    shared_.count(line.spec->key, [](BridgedCounts& c) { ++c.messages; });
    return;
  }
  if (!robot_) place_.reset();
  refuse(line, std::move(why));
}

void InSide::refuse(const InLine& line, std::string why) {
  shared_.count(line.spec->key, [&](BridgedCounts& c) { ++c.refused, c.why = std::move(why); });
}

}  // namespace sinew::net
