#include "apps/live/running_names.hpp"

#include "apps/command/command.hpp"
#include "apps/live/live_robot.hpp"

namespace sinew::app {
namespace {

struct Source {
  const char *hint, *request, *list, *name;
};

constexpr Source kSources[] = {{kTopicHint, "topics", "topics", "name"},
                               {kModuleHint, "status", "modules", "name"},
                               {kThreadHint, "status", "threads", "name"},
                               {kParamHint, "params", "params", "param"}};

std::vector<std::string> robots() {
  std::string why;
  const auto all = tap::running(why);
  std::vector<std::string> names;
  if (all)
    for (const auto& r : *all) names.push_back(r.robot);
  return names;
}

// For `topic pub`: only external topics take messages from outside.
bool fits(std::string_view hint, const Json& one) {
  return hint != kExternalHint || (one.contains("external") && one["external"] == true);
}

}  // namespace

std::vector<std::string> running_names(std::string_view hint, const std::string& robot) {
  if (hint == kRobotHint) return robots();
  const std::string_view asked = hint == kExternalHint ? kTopicHint : hint;
  for (const Source& source : kSources) {
    if (asked != source.hint) continue;
    auto live = LiveRobot::try_find(robot);
    const auto reply = live ? live->ask(source.request) : std::nullopt;
    std::vector<std::string> names;
    if (!reply || !reply->contains(source.list)) return names;
    for (const Json& one : reply->at(source.list))
      if (fits(hint, one))
        names.push_back((hint == kParamHint ? one.value("module", "") + "." : "") + one.value(source.name, ""));
    return names;
  }
  return {};
}

}  // namespace sinew::app
