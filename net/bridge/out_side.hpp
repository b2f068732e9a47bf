#pragma once
// Topics of the robot to DDS. Inside of the room only.
#include <memory>
#include <thread>
#include <vector>

#include "hal/os.hpp"
#include "images/encode.hpp"
#include "net/bridge/robot_client.hpp"
#include "net/bridge/shared.hpp"
#include "net/dds/participant.hpp"

namespace sinew::net {

/// Thread:  owner; with a thread of its own from begin() to its end.
class OutSide {
 public:
  /// `writers`: of spec.out, in its order. `clock`: of /clock, or null.
  OutSide(BridgeShared& shared, std::vector<std::unique_ptr<DdsWriter>> writers, std::unique_ptr<DdsWriter> clock);
  ~OutSide();
  /// shared.stop() came before: wakes the thread.
  void wake();

 private:
  struct Line {  // one of spec.out
    const ros2::BridgedTopic* spec = nullptr;
    std::unique_ptr<DdsWriter> writer{};
    std::unique_ptr<ros2::Outgoing> translate{};  // null: not connected, or impossible
    std::uint32_t topic = 0;                      // of the reader
    std::int64_t next_ns = 0;                     // before: beyond the rate
  };
  struct Source {  // a topic of the robot, of one or more lines
    std::uint32_t topic = 0;
    tap::Cursor cursor{};
    std::vector<std::size_t> lines{};
  };

  void run();
  void connect();
  void disconnect();
  void say_clock();
  void drain(Source& source);
  void send(Line& line, const rt::SlotHeader& header);
  std::span<const std::uint8_t> picture(const Line& line, const void* message);

  BridgeShared& shared_;
  std::vector<Line> lines_;
  std::unique_ptr<DdsWriter> clock_;
  RobotClient robot_;
  const tap::SegmentReader* reader_ = nullptr;
  std::vector<Source> sources_;
  std::int64_t robot_offset_ns_ = 0;
  std::optional<std::int64_t> to_ros_ns_;
  hal::Time next_offset_{}, next_clock_{};
  struct alignas(64) Block {
    std::byte bytes[64];
  };
  std::vector<Block> scratch_;  // a slot of the robot
  std::vector<std::uint8_t> cdr_;
  images::Encoder encoder_;
  hal::WakeWord word_{0};  // counts what wakes the thread besides messages
  std::thread thread_;
};

}  // namespace sinew::net
