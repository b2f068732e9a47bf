#include "monitor/robot_api.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

#include "monitor/json_reply.hpp"

namespace sinew::monitor {
namespace {

constexpr std::string_view kRobots = "/api/robots";
// Requests of docs/robot-socket.md that change nothing; those that hand out memory are for programs of this machine.
constexpr std::string_view kLooks[] = {"hello", "topics", "status", "params", "timeline", "record.status", "playback"};
constexpr std::string_view kOfMemory[] = {"memory", "doorbells", "subscribe"};
// Obeyed also while somebody else has control: what makes a robot safe must not depend on a lease.
constexpr std::string_view kAlways[] = {"disarm", "stop"};
constexpr std::string_view kPlayback = "playback.";  // steers a recorded run: commands no robot

template <class List>
bool is_one_of(std::string_view what, const List& list) {
  return std::find(std::begin(list), std::end(list), what) != std::end(list);
}

std::int64_t now_ns() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

/// "last_ms=100" as a number, other values as text.
Json arguments_of(const Request& request) {
  Json arguments = Json::object();
  for (const auto& [name, value] : request.query) {
    Json number = Json::parse(value, nullptr, false);
    arguments[name] = number.is_number() || number.is_boolean() ? number : Json(value);
  }
  return arguments;
}

RobotLink::Done pass_on(Server::Reply reply) {
  return [reply = std::move(reply)](const std::string& answer) {
    const Json json = Json::parse(answer, nullptr, false);
    if (json.is_object())
      reply(json_response(status_of(json), answer));
    else
      reply(json_error(502, "bad_data", "the robot's reply is no JSON object"));
  };
}

}  // namespace

void RobotApi::answer(const Request& request, Server::Reply reply) {
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (!reads && request.method != "POST") return reply(json_error(405, "bad_argument", "GET looks, POST changes"));
  if (request.path == "/api" && reads) return about(std::move(reply));
  if (request.path == kRobots && reads) return robots(std::move(reply));
  if (!request.path.starts_with(std::string(kRobots) + "/"))
    return reply(json_error(404, "not_found", "known are /api, /api/robots, /api/robots/ROBOT/REQUEST"));
  const std::string_view rest = std::string_view(request.path).substr(kRobots.size() + 1);
  const std::size_t slash = rest.find('/');
  const std::string robot(rest.substr(0, slash));
  const std::string what(slash == std::string_view::npos ? "hello" : rest.substr(slash + 1));
  if (is_one_of(what, kOfMemory))
    return reply(json_error(403, "denied", what + ": for programs of the robot's machine only"));
  if (reads) return look(request, robot, what, std::move(reply));
  if (what == "control") return control(request, robot, std::move(reply));
  change(request, robot, what, std::move(reply));
}

void RobotApi::about(Server::Reply reply) const {
  reply(json_response(200, to_text({{"ok", true},
                                    {"version", 1},
                                    {"program", "sinew-monitor"},
                                    {"now_ns", now_ns()},
                                    {"commands", gate_.takes_commands()},
                                    {"panels", options_.panels},
                                    {"runs", options_.runs},
                                    {"monitors", true}})));
}

void RobotApi::robots(Server::Reply reply) {
  const auto now = std::chrono::steady_clock::now();
  Json list = Json::array();
  for (const auto& link : robots_.all()) {
    Json robot = Json::parse(link->hello(), nullptr, false);
    if (!robot.is_object()) continue;
    robot.erase("ok");
    if (!robot.contains("recording")) robot["recording"] = nullptr;
    const auto control = controls_.find(link->robot());
    const std::string who = control == controls_.end() ? "" : control->second.who(now);
    robot["control"] = {{"who", who.empty() ? Json() : Json(who)},
                        {"asked", who.empty() ? Json::array() : Json(control->second.asked(now))}};
    list.push_back(std::move(robot));
  }
  Json whole{{"ok", true}, {"now_ns", now_ns()}, {"robots", std::move(list)}};
  if (const std::string problem = robots_.problem(); !problem.empty()) whole["problem"] = problem;
  reply(json_response(200, to_text(whole)));
}

void RobotApi::look(const Request& request, const std::string& robot, const std::string& what, Server::Reply reply) {
  if (!is_one_of(what, kLooks))
    return reply(json_error(405, "bad_argument",
                            fmt::format("{}: GET only looks ({}); POST changes", what, fmt::join(kLooks, ", "))));
  const auto link = robots_.find(robot);
  if (!link) return reply(json_error(404, "not_found", fmt::format("no robot '{}' runs", robot)));
  if (what == "status") return link->look(what, kStatusAge, pass_on(std::move(reply)));
  link->ask(what, to_text(arguments_of(request)), pass_on(std::move(reply)));
}

void RobotApi::change(const Request& request, const std::string& robot, const std::string& what, Server::Reply reply) {
  const bool is_playback = what.starts_with(kPlayback);
  if (!is_playback)
    if (const auto refusal = gate_.refuses_command(request))
      return reply(json_error(refusal->status, "denied", refusal->why));
  Response refusal;
  const auto body = json_body(request, refusal);
  if (!body) return reply(std::move(refusal));
  if (!request.until_ns.empty()) {
    std::int64_t until = 0;
    const char* const end = request.until_ns.data() + request.until_ns.size();
    if (std::from_chars(request.until_ns.data(), end, until).ptr != end)
      return reply(json_error(400, "bad_argument", "x-sinew-until-ns: nanoseconds of the monitor's clock"));
    if (now_ns() > until) return reply(json_error(408, "timeout", "the command came too late, and was not passed on"));
  }
  const auto link = robots_.find(robot);
  if (!link) return reply(json_error(404, "not_found", fmt::format("no robot '{}' runs", robot)));
  if (const std::string why = busy_with(robot, what, request.control_key); !why.empty())
    return reply(json_error(409, "busy", why));
  link->ask(what, to_text(*body), pass_on(std::move(reply)));
}

std::string RobotApi::busy_with(const std::string& robot, std::string_view what, std::string_view control_key) const {
  const auto control = controls_.find(robot);
  const auto now = std::chrono::steady_clock::now();
  if (what.starts_with(kPlayback) || is_one_of(what, kAlways) || control == controls_.end() ||
      control->second.allows(control_key, now))
    return {};
  return fmt::format("{} has control of {}", control->second.who(now), robot);
}

void RobotApi::control(const Request& request, const std::string& robot, Server::Reply reply) {
  if (const auto refusal = gate_.refuses_command(request))
    return reply(json_error(refusal->status, "denied", refusal->why));
  Response refusal;
  const auto body = json_body(request, refusal);
  if (!body) return reply(std::move(refusal));
  const std::string action = text_of(*body, "action"), who = text_of(*body, "who"), key = text_of(*body, "key");
  if (!robots_.find(robot)) return reply(json_error(404, "not_found", fmt::format("no robot '{}' runs", robot)));
  if ((action == "take" || action == "ask") && who.empty())
    return reply(json_error(400, "bad_argument", "who: a name that people know"));
  std::erase_if(controls_, [this](const auto& entry) { return !robots_.find(entry.first); });
  Control& control = controls_[robot];
  const auto now = std::chrono::steady_clock::now();
  const auto done = [&] { reply(json_response(200, to_text({{"ok", true}}))); };
  const auto busy = [&](std::string_view why) { reply(json_error(409, "busy", why)); };
  if (action == "take") {
    const std::string taken = control.take(who, key, new_token(), now);
    if (taken.empty()) return busy(fmt::format("{} has control of {}", control.who(now), robot));
    return reply(json_response(200, to_text({{"ok", true}, {"key", taken}})));
  }
  if (action == "keep") return control.keep(key, now) ? done() : busy("this key has no control any more");
  if (action == "release") return control.release(key, now) ? done() : busy("this key has no control any more");
  if (action == "ask") return control.ask(who, now) ? done() : busy("nobody has control, or too many have asked");
  reply(json_error(400, "bad_argument", "action: take, keep, release or ask"));
}

}  // namespace sinew::monitor
