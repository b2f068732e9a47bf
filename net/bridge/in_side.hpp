#pragma once
// Topics of DDS to the robot's mailbox. Inside of the room only.
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "net/bridge/picture_reader.hpp"
#include "net/bridge/robot_client.hpp"
#include "net/bridge/shared.hpp"
#include "net/dds/participant.hpp"

namespace sinew::net {

/// A topic that comes in, and its reader.
struct InLine {
  const ros2::BridgedTopic* spec = nullptr;
  std::unique_ptr<DdsReader> reader{};
  std::unique_ptr<ros2::Incoming> translate{};  // null: not connected, or impossible
  std::uint32_t bytes = 0, bulk_bytes = 0;      // of the robot's topic
  bool newest_only = false;                     // pictures: of several that wait the last
};

/// Thread:  owner; with a thread of its own from begin to end. shared.stop() comes before its end.
class InSide {
 public:
  InSide(BridgeShared& shared, std::vector<InLine> lines);
  ~InSide();

 private:
  /// A message in `place_` that is not with the robot yet.
  struct Waiting {
    const InLine* line;
    std::size_t offset, bytes;
    std::optional<std::int64_t> stamp_ns;  // on the robot's clock
  };

  void run();
  void connect();
  void drain(InLine& line);
  void pass(InLine& line);
  void hand_over();
  void refuse(const InLine& line, std::string why);

  BridgeShared& shared_;
  std::vector<InLine> lines_;
  RobotClient robot_;
  std::unique_ptr<hal::SharedMemory> place_;  // the robot copies from it; null: not connected
  std::vector<Waiting> waiting_;
  std::size_t used_ = 0;  // bytes of place_
  DdsSample sample_;
  PictureReader pictures_;
  std::thread thread_;
};

}  // namespace sinew::net
