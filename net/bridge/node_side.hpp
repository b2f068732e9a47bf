#pragma once
// Diagnostics, log and parameters of the node. Inside of the room only.
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "net/bridge/robot_client.hpp"
#include "net/bridge/robot_report.hpp"
#include "net/bridge/shared.hpp"
#include "net/dds/participant.hpp"

namespace sinew::net {

/// The endpoints of a node; those that are not wanted are null.
struct NodeEndpoints {
  std::unique_ptr<DdsWriter> rosout{}, diagnostics{}, parameter_events{};
  std::unique_ptr<DdsReader> parameter_set{};
  struct Service {
    ros2::ParameterService service;
    std::unique_ptr<DdsReader> requests;
    std::unique_ptr<DdsWriter> replies;
  };
  std::vector<Service> services{};
};

/// Thread:  owner; with a thread of its own from begin to end. shared.stop() comes before its end.
class NodeSide {
 public:
  NodeSide(BridgeShared& shared, NodeEndpoints endpoints);
  ~NodeSide();

 private:
  void run();
  void report();
  void read_parameters();
  void serve();
  void serve(NodeEndpoints::Service& service);
  /// "" or why not.
  std::string set(const ros2::Parameter& parameter);
  void log(ros2::LogLevel level, const std::string& text);
  std::int64_t ros_now_ns();

  BridgeShared& shared_;
  NodeEndpoints ends_;
  RobotClient robot_;
  RobotReport reports_;
  bool said_connected_ = false;
  std::vector<ros2::ParameterInfo> parameters_;
  DdsSample sample_;
  std::thread thread_;
};

}  // namespace sinew::net
