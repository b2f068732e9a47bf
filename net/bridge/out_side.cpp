#include "net/bridge/out_side.hpp"

#include <algorithm>
#include <cstring>

#include "hal/linux/shared_memory.hpp"
#include "hal/platform.hpp"
#include "net/ros2/system.hpp"

namespace sinew::net {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kClockPeriod = 10ms;
constexpr hal::Duration kOffsetPeriod =
    1s;  // a robot's clock runs as the monotonic one, or (virtual time) is asked each time
constexpr std::int64_t kSecondNs = 1'000'000'000;

}  // namespace

OutSide::OutSide(BridgeShared& shared, std::vector<std::unique_ptr<DdsWriter>> writers,
                 std::unique_ptr<DdsWriter> clock)
    : shared_(shared), clock_(std::move(clock)), robot_(shared.robot) {
  for (std::size_t i = 0; i < writers.size(); ++i) lines_.push_back({&shared.spec.out[i], std::move(writers[i])});
  thread_ = std::thread([this] { run(); });
}

OutSide::~OutSide() {
  wake();
  thread_.join();
}

void OutSide::wake() {
  word_.fetch_add(1, std::memory_order_release);
  hal::wake_shared(word_);
}

void OutSide::run() {
  std::uint64_t seen = 0;
  std::vector<tap::Client::Heard> heard;
  while (!shared_.stopped()) {
    const bool was_connected = reader_ != nullptr;
    if (!robot_.reach()) {
      if (was_connected) disconnect();
      shared_.wait(seen, kLongestLook);
      continue;
    }
    if (!was_connected) connect();
    if (!reader_) continue;  // the robot is gone again, or has no shared memory
    const hal::SeenWord own{&word_, word_.load(std::memory_order_acquire)};
    const hal::Time now = hal::system_os().now();
    if (now >= next_offset_) {
      robot_offset_ns_ = robot_.clock_offset_ns();
      to_ros_ns_ = shared_.to_ros_ns(robot_offset_ns_);
      next_offset_ = now + (to_ros_ns_ ? kOffsetPeriod : kLongestLook);
    }
    heard.clear();
    for (const Source& source : sources_) heard.push_back({source.topic, robot_ ? robot_->bell(source.topic) : 0});
    for (Source& source : sources_)
      if (to_ros_ns_) drain(source);
    say_clock();
    if (!robot_) {
      disconnect();
      continue;
    }
    robot_->wait_any(heard, own, hal::system_os().now() + (clock_ ? kClockPeriod : kLongestLook));
  }
}

void OutSide::connect() {
  const auto reader = robot_->reader();
  if (!reader) {
    robot_.drop();
    return;
  }
  std::vector<std::string> names;
  sources_.clear();
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    std::string why;
    const auto topic = (*reader)->find(line.spec->topic);
    const msg::TypeInfo* type = topic ? (*reader)->topics()[*topic].info : nullptr;
    if (!topic)
      why = "the robot has no such topic";
    else if (!type)
      why = "the robot's type " + (*reader)->topics()[*topic].type + " is not known here, or another version of it";
    else
      line.translate = ros2::Outgoing::make(shared_.spec.distro, line.spec->type, *type, line.spec->options, why);
    if (!line.translate) {
      shared_.count(line.spec->key, [&](BridgedCounts& c) { c.why = why; });
      continue;
    }
    line.topic = *topic;
    const auto same =
        std::find_if(sources_.begin(), sources_.end(), [&](const Source& s) { return s.topic == *topic; });
    Source& source = same == sources_.end() ? sources_.emplace_back() : *same;
    if (source.lines.empty()) names.push_back(line.spec->topic);
    source.topic = *topic;
    source.lines.push_back(i);
  }
  if (!names.empty() && !robot_->subscribe(names)) return robot_.drop();
  reader_ = *reader;
  next_offset_ = {};
  shared_.set_connected(true);
}

void OutSide::disconnect() {
  reader_ = nullptr;
  sources_.clear();
  for (Line& line : lines_) line.translate.reset(), line.next_ns = 0;
  shared_.set_connected(false);
}

void OutSide::say_clock() {
  const hal::Time now = hal::system_os().now();
  if (!clock_ || now < next_clock_) return;
  next_clock_ = now + kClockPeriod;
  const std::int64_t offset = robot_.clock_offset_ns();  // asks the robot only in virtual time
  const std::vector<std::uint8_t> cdr = ros2::clock_message(hal::system_os().now().ns + offset);
  static_cast<void>(clock_->write(cdr));  // the next one comes in 10 ms
}

void OutSide::drain(Source& source) {
  const std::uint64_t lost = source.cursor.lost;
  while (const auto message = reader_->next(source.topic, source.cursor)) {
    const bool wanted = std::any_of(source.lines.begin(), source.lines.end(), [&](std::size_t i) {
      const Line& line = lines_[i];
      // A late reader gets the newest only where it may: others are not worth translating while nobody listens.
      return line.writer->matched() > 0 || line.spec->qos.transient_local;
    });
    if (!wanted) continue;
    const std::size_t bytes = reader_->bytes(source.topic);
    scratch_.resize((bytes + sizeof(Block) - 1) / sizeof(Block));
    auto* const copy = reinterpret_cast<std::byte*>(scratch_.data());
    if (!reader_->copy(*message, {copy, bytes})) {
      ++source.cursor.lost;
      continue;
    }
    const auto& header = *reinterpret_cast<const rt::SlotHeader*>(copy);
    for (const std::size_t i : source.lines) send(lines_[i], header);
  }
  if (source.cursor.lost != lost)
    for (const std::size_t i : source.lines)
      shared_.count(lines_[i].spec->key, [&](BridgedCounts& c) { c.lost += source.cursor.lost - lost; });
}

void OutSide::send(Line& line, const rt::SlotHeader& header) {
  if (line.writer->matched() == 0 && !line.spec->qos.transient_local) return;
  const double rate = line.spec->rate_hz;
  const std::int64_t published = header.published.ns;
  if (rate > 0 && published < line.next_ns) {
    shared_.count(line.spec->key, [](BridgedCounts& c) { ++c.skipped; });
    return;
  }
  if (rate > 0) {
    const auto period = static_cast<std::int64_t>(static_cast<double>(kSecondNs) / rate);
    // On the grid of the rate, so that 50 Hz of a 1 kHz topic are 50 and not 47; anew after a pause.
    line.next_ns = line.next_ns + 2 * period > published ? line.next_ns + period : published + period;
  }
  const void* const message = header.message();
  const auto file = line.translate->wants_picture() ? picture(line, message) : std::span<const std::uint8_t>();
  if (!line.translate->encode(message, *to_ros_ns_, cdr_, file)) {
    shared_.count(line.spec->key, [](BridgedCounts& c) { ++c.skipped; });
    return;
  }
  const hal::Status written = line.writer->write(cdr_);
  shared_.count(line.spec->key, [&](BridgedCounts& c) {
    if (written)
      ++c.messages;
    else
      ++c.refused,
          c.why = written.error().code == hal::Errc::busy ? "no room: a reader is too slow" : "DDS does not take it";
  });
}

std::span<const std::uint8_t> OutSide::picture(const Line& line, const void* message) {
  const auto file = encoder_.encode(images::view(*static_cast<const msg::Image*>(message)), images::Kind::jpeg);
  if (file) return {reinterpret_cast<const std::uint8_t*>(file->data()), file->size()};
  shared_.count(line.spec->key, [&](BridgedCounts& c) { c.why = file.error().where; });
  return {};
}

}  // namespace sinew::net
