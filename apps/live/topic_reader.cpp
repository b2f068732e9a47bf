#include "apps/live/topic_reader.hpp"

#include "apps/command/command.hpp"
#include "hal/did_you_mean.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kTopicLook = 200ms;  // for Ctrl-C
constexpr hal::Duration kSilence = 500ms;    // without a message: is the robot still there?

}  // namespace

std::optional<TopicReader> TopicReader::open(LiveRobot& robot, const std::string& topic) {
  const tap::SegmentReader* reader = robot.reader();
  if (!reader) return std::nullopt;
  const auto index = reader->find(topic);
  if (!index) {
    std::string known;
    std::vector<std::string> names;
    for (const auto& t : reader->topics()) known += " " + t.name, names.push_back(t.name);
    fail("robot " + robot.name() + ": no topic " + topic + "; it has" + known + hal::did_you_mean(topic, names));
    return std::nullopt;
  }
  if (auto asked = robot.client().subscribe(std::span(&topic, 1)); !asked) {
    fail("robot " + robot.name() + ": " + asked.error().where);
    return std::nullopt;
  }
  return TopicReader(robot, *reader, *index);
}

TopicReader::TopicReader(LiveRobot& robot, const tap::SegmentReader& reader, std::uint32_t index)
    : robot_(&robot), reader_(&reader), index_(index), blocks_((reader.bytes(index) + 63) / 64) {
  copy_ = std::as_writable_bytes(std::span(blocks_)).first(reader.bytes(index));
}

bool TopicReader::take() {
  while (const auto message = reader_->next(index_, cursor_)) {
    if (reader_->copy(*message, copy_)) return true;
    ++cursor_.lost;  // overwritten while it was read
  }
  return false;
}

TopicReader::Got TopicReader::next(hal::Time deadline) {
  hal::Os& os = hal::system_os();
  while (true) {
    const std::uint32_t bell = robot_->client().bell(index_);
    const bool taken = take();
    const hal::Time now = os.now();
    if (taken || !heard_) heard_ = now;
    if (taken) return Got::message;
    if (hal::stop_requested()) return Got::end;
    if (now - *heard_ > kSilence) {
      if (!robot_->ask("hello")) return Got::end;
      heard_ = now;
    }
    if (now >= deadline) return Got::nothing;
    robot_->client().wait(index_, bell, std::min(deadline, now + kTopicLook));
  }
}

}  // namespace sinew::app
