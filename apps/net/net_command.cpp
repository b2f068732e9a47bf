#include "apps/net/net_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/command/place.hpp"
#include "hal/linux/devices/net_radio.hpp"

namespace sinew::app {
namespace {

using nlohmann::json;

int become_net(const std::string& file) {
  std::string program = find_program("sinew-net");
  if (program.empty())
    return fail(
        "sinew-net is missing beside sinew and in PATH; it is built where Cyclone DDS is (Debian: cyclonedds-dev)");
  std::string name = file;
  char* argv[] = {program.data(), name.data(), nullptr};
  execv(argv[0], argv);
  return fail(program + ": " + std::strerror(errno));
}

std::string words_of(const json& j, const char* key) { return j.value(key, std::string()); }

void print_status(const json& j) {
  fmt::print("{}: DDS domain {}, {}{}\n", words_of(j, "robot"), j.value("domain", 0),
             j.value("open", false) ? "open" : "not open", j.value("secure", false) ? ", secure" : "");
  if (const std::string trouble = words_of(j, "trouble"); !trouble.empty()) fmt::print("trouble: {}\n", trouble);
  for (const json& one : j.value("addresses", json::array())) fmt::print("on {}\n", one.get<std::string>());
  for (const json& p : j.value("participants", json::array())) {
    const std::string robot = words_of(p, "robot");
    fmt::print("hears {}{}\n", words_of(p, "guid"), robot.empty() ? "" : ", the robot " + robot);
  }
  for (const json& u : j.value("unmatched", json::array()))
    fmt::print("no match: {}: {} {}{}: {}\n", words_of(u, "topic"), words_of(u, "is"), words_of(u, "endpoint"),
               words_of(u, "of"), words_of(u, "why"));
  if (const auto others = j.find("other_domains"); others == j.end() || others->is_null()) {
    fmt::print("other domains: unknown\n");
  } else {
    for (const json& h : *others)
      fmt::print("in domain {}: {} at {}\n", h.value("domain", 0), words_of(h, "vendor"), words_of(h, "address"));
  }
  if (const auto radio = j.find("radio"); radio != j.end())
    fmt::print("radio {}: {} readers, {} writers, said {}, heard {}, lost to the robot {}\n", words_of(*radio, "topic"),
               radio->value("readers", 0), radio->value("writers", 0), radio->value("said", 0),
               radio->value("heard", 0), radio->value("lost_to_robot", 0));
}

int net_status(const std::string& robot, bool as_json) {
  std::string why;
  const auto text = hal::ask_net(robot, std::chrono::seconds(2), why);
  if (!text) return fail(why, kFailed);
  const json j = json::parse(*text, nullptr, false);
  if (!j.is_object()) return fail("sinew net of '" + robot + "' answered no JSON", kFailed);
  if (as_json)
    fmt::print("{}\n", j.dump(2));
  else
    print_status(j);
  return kDone;
}

struct NetOptions {
  std::string file, robot;
  bool as_json = false;
};

}  // namespace

void add_net_command(CLI::App& app, CommandContext& context) {
  const auto o = std::make_shared<NetOptions>();
  CLI::App* net = app.add_subcommand("net", kNetAbout);
  CLI::App* status = net->add_subcommand(
      "status", "How it is: whom it hears, endpoints of others that cannot match and why, what is wrong");
  status->add_option("robot", o->robot, "whose")->required()->type_name(kRobotHint);
  status->add_flag("--json", o->as_json, "for programs");
  net->add_option("file", o->file, "robot file")->type_name(kRobotFileHint);
  status->callback([&context, o] { context.action = [o] { return net_status(o->robot, o->as_json); }; });
  net->callback([&context, o, net] {
    if (!net->get_subcommands().empty()) return;
    if (o->file.empty()) throw CLI::RequiredError("file");
    context.action = [o] { return become_net(o->file); };
  });
}

}  // namespace sinew::app
