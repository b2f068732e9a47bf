// sinew-ros2: a robot as a node of a ROS 2 graph. docs/ros2.md.
#include <poll.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/command/command.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "net/bridge/ros2_bridge.hpp"
#include "net/dds/participant.hpp"
#include "rt/graph_spec.hpp"

namespace {

using namespace sinew;
using namespace std::chrono_literals;

struct Options {
  std::string robot;
  net::ParticipantOptions network;
  bool domain_given = false, no_multicast = false, status = false;
};

int fail(const std::string& why) {
  std::fprintf(stderr, "sinew-ros2: %s\n", why.c_str());
  return app::kNotBegun;
}

/// Until a signal: the bridge has its own threads, and is only told that something came.
void serve(net::Participant& participant, net::Ros2Bridge& bridge, bool status) {
  hal::Time next{};
  while (!hal::stop_requested()) {
    pollfd wait{participant.wake_fd(), POLLIN, 0};
    ::poll(&wait, 1, 100);
    participant.begin_look();
    bridge.look();
    for (const std::string& line : net::take_dds_log()) std::fprintf(stderr, "dds: %s\n", line.c_str());
    if (!status || hal::system_os().now() < next) continue;
    next = hal::system_os().now() + 1s;
    nlohmann::json json;
    bridge.add_status(json);
    std::printf("%s\n", json.dump().c_str());
    std::fflush(stdout);
  }
}

/// What the command line does not say comes from [net].
void use_net(const app::NetTable& net, Options& o) {
  net::ParticipantOptions& network = o.network;
  if (!o.domain_given) network.domain = net.domain;
  if (network.interfaces.empty()) network.interfaces = net.interfaces;
  if (network.peers.empty()) network.peers = net.peers;
  network.multicast = net.multicast;
  network.most_on_a_machine = net.most_on_a_machine;
  network.extra = net.extra;
  network.security = {net.identity_ca,    net.certificate, net.private_key,
                      net.permissions_ca, net.governance,  net.permissions};
}

int run(Options& o) {
  const app::LoadedRobot loaded = app::load_robot(o.robot);
  for (const rt::Problem& p : loaded.problems) std::fprintf(stderr, "%s\n", app::to_string(p, loaded.robot).c_str());
  if (!loaded.problems.empty()) return app::kNotBegun;
  if (!loaded.robot.ros2) return fail(o.robot + ": no table [ros2], which says what the graph sees");
  if (loaded.robot.net) use_net(*loaded.robot.net, o);
  o.network.multicast = o.network.multicast && !o.no_multicast;
  o.network.user_data = "enclave=/;";
  std::string why;
  const auto participant = net::Participant::open(o.network, why);
  if (!participant) return fail(why);
  net::Ros2Bridge bridge(loaded.robot.graph.robot, *loaded.robot.ros2);
  if (!bridge.start(**participant, why)) return fail(why);
  hal::stop_requested();  // from now on a signal only asks
  serve(**participant, bridge, o.status);
  return app::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App options("Shows a running robot to a ROS 2 graph, as [ros2] of its robot file says.", "sinew-ros2");
  options.add_option("ROBOT", o.robot, "robot file")->required();
  const CLI::Option* const domain =
      options.add_option("--domain", o.network.domain, "ROS_DOMAIN_ID of the graph")->envname("ROS_DOMAIN_ID");
  options.add_option("--interface", o.network.interfaces,
                     "name or address of a network interface; several are allowed");
  options.add_option("--peer", o.network.peers, "address of another machine, where multicast does not reach it");
  options.add_flag("--no-multicast", o.no_multicast, "only peers are looked for");
  options.add_flag("--status", o.status, "prints counts of all topics once a second, as a line of JSON");
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail(app::usage_error(options, e));
    return options.exit(e);
  }
  o.domain_given = !domain->empty();
  return run(o);
}
