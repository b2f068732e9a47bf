// bridge_program ROBOT.toml DOMAIN: the robot's bridge on the loopback interface, without multicast. Prints its status
// once a second, as one line of JSON; ends on SIGTERM.
#include <poll.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "apps/robot_file/robot_file.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "net/bridge/ros2_bridge.hpp"

using namespace sinew;
using namespace std::chrono_literals;

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const app::LoadedRobot loaded = app::load_robot(argv[1]);
  for (const rt::Problem& p : loaded.problems) std::fprintf(stderr, "%s\n", app::to_string(p, loaded.robot).c_str());
  if (!loaded.problems.empty() || !loaded.robot.ros2) return 1;
  net::ParticipantOptions options;
  options.domain = static_cast<std::uint32_t>(std::atoi(argv[2]));
  options.interfaces = {"127.0.0.1"};
  options.multicast = false;
  options.peers = {"127.0.0.1"};
  options.user_data = "enclave=/;";
  std::string why;
  const auto participant = net::Participant::open(options, why);
  if (!participant) return std::fprintf(stderr, "%s\n", why.c_str()), 1;
  net::Ros2Bridge bridge(loaded.robot.graph.robot, *loaded.robot.ros2);
  if (!bridge.start(**participant, why)) return std::fprintf(stderr, "%s\n", why.c_str()), 1;
  hal::stop_requested();  // from now on a signal only asks
  hal::Time next{};
  while (!hal::stop_requested()) {
    pollfd wait{(*participant)->wake_fd(), POLLIN, 0};
    ::poll(&wait, 1, 100);
    (*participant)->begin_look();
    bridge.look();
    if (hal::system_os().now() < next) continue;
    next = hal::system_os().now() + 1s;
    nlohmann::json status;
    bridge.add_status(status);
    std::printf("%s\n", status.dump().c_str());
    std::fflush(stdout);
  }
  return 0;
}
