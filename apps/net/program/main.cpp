// sinew-net: DDS for a robot, in a program of its own beside it. docs/net.md.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "apps/command/command.hpp"
#include "apps/command/usage_error.hpp"
#include "apps/net/supervisor.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "net/bridge/ros2_part.hpp"
#include "net/service.hpp"
#include "net/team_radio.hpp"

namespace {

using namespace sinew;
int fail_net(const std::string& why) {
  std::fprintf(stderr, "sinew-net: %s\n", why.c_str());
  return app::kNotBegun;
}

/// That of [net]; without such a table that of the environment, as for any ROS 2 program.
std::optional<std::uint32_t> domain_of(const app::RobotFile& robot, std::string& why) {
  const char* const given = robot.net ? nullptr : std::getenv("ROS_DOMAIN_ID");
  if (!given || !*given) return robot.net.value_or(app::NetTable()).domain;
  const std::string_view text(given);
  std::uint32_t domain = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), domain);
  if (error == std::errc() && end == text.data() + text.size() && domain <= net::ParticipantOptions::kMostDomain)
    return domain;
  why = "ROS_DOMAIN_ID is '" + std::string(text) + "', and not a number from 0 to " +
        std::to_string(net::ParticipantOptions::kMostDomain);
  return std::nullopt;
}

net::ServiceOptions options_of(const app::RobotFile& robot, std::uint32_t domain) {
  const app::NetTable from = robot.net.value_or(app::NetTable());
  net::ServiceOptions o;
  if (robot.ros2) o.dds.user_data = "enclave=/;";  // without it ROS 2 shows no node
  o.robot = robot.graph.robot;
  o.dds.domain = domain;
  o.dds.interfaces = from.interfaces;
  o.dds.multicast = from.multicast;
  o.dds.peers = from.peers;
  o.dds.most_on_a_machine = from.most_on_a_machine;
  o.dds.extra = from.extra;
  o.dds.security = {from.identity_ca,    from.certificate, from.private_key,
                    from.permissions_ca, from.governance,  from.permissions};
  o.stop = [] { return hal::stop_requested(); };
  o.say = [](const std::string& line) { std::fprintf(stderr, "sinew-net: %s\n", line.c_str()); };
  return o;
}

bool has_dds_radio(const app::RobotFile& robot) {
  const auto& devices = robot.devices.devices;
  return std::any_of(devices.begin(), devices.end(), [](const auto& d) { return d.driver == "dds"; });
}

/// What our own process tells this one.
struct AsWorker {
  int attempt = 0;  // how often it has failed before
  int beat = -1;    // where it shows that it does not hang; -1: nobody looks
};

int work(const app::RobotFile& robot, std::uint32_t domain, const AsWorker& as) {
  std::string why;
  auto link = net::LocalLink::open(robot.graph.robot, why);
  if (!link) return fail_net(why);
  net::ServiceOptions options = options_of(robot, domain);
  options.attempt = as.attempt;
  if (as.beat >= 0) options.alive = [fd = as.beat] { app::beat(fd); };
  std::vector<std::unique_ptr<net::Part>> parts;
  if (has_dds_radio(robot))
    parts.push_back(std::make_unique<net::TeamRadio>(robot.team ? robot.team->link.team : 0, **link));
  if (robot.ros2) parts.push_back(std::make_unique<net::Ros2Part>(robot.graph.robot, *robot.ros2));
  auto service = std::make_unique<net::Service>(std::move(options), **link, std::move(parts));
  const net::Service::End end = service->run();
  link->reset();  // the socket's file goes
  // Cyclone is not asked to end where it would not: the addresses that it has are gone.
  if (end != net::Service::End::stopped) _exit(end == net::Service::End::anew ? app::kNetAnew : app::kNetFailed);
  std::fflush(nullptr);
  _exit(app::kDone);
}

}  // namespace

int main(int argc, char** argv) {
  std::string file;
  bool worker = false;
  AsWorker as;
  double patience_s = std::chrono::duration<double>(app::kNetHangs).count();
  CLI::App options("DDS and ROS 2 for a robot, in a program of its own beside it.", "sinew net");
  options.add_option("file", file, "robot file")->required()->type_name(app::kRobotFileHint);
  options.add_flag("--worker", worker)->group("");
  options.add_option("--attempt", as.attempt)->group("");
  options.add_option("--beat", as.beat)->group("");
  options.add_option("--patience", patience_s, "s without a sign of life")->check(CLI::Range(1., 3600.))->group("");
  try {
    options.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) return fail_net(app::usage_error(options, e));
    return options.exit(e);  // prints the help
  }
  hal::stop_requested();  // from now on a signal only asks
  if (as.beat >= 0) app::beat(as.beat);
  const app::LoadedRobot loaded = app::load_robot(file);
  if (!loaded.problems.empty()) {
    for (const rt::Problem& p : loaded.problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
    return app::kNotBegun;
  }
  if (!loaded.robot.net && !loaded.robot.ros2)
    return fail_net(file + ": there is neither a table [net] nor [ros2]; docs/net.md");
  std::string why;
  const auto domain = domain_of(loaded.robot, why);
  if (!domain) return fail_net(why);
  if (worker) return work(loaded.robot, *domain, as);
  const auto patience = std::chrono::milliseconds(static_cast<std::int64_t>(patience_s * 1000));
  return app::supervise_net(hal::program_path(), file, patience);
}
