#include "monitor/recordings.hpp"

#include <fmt/format.h>

#include <utility>

#include "monitor/json_reply.hpp"

namespace sinew::monitor {
namespace {

constexpr std::chrono::hours kNoEnd{24 * 3650};  // a recording stands until it is closed

}  // namespace

void Recordings::open(const std::string& path, Server::Reply reply) {
  if (!is_open(path) && robot_of(path).empty()) {
    if (open_.size() >= kMost)
      return reply(json_error(409, "busy", fmt::format("{} recorded runs are open: close one", open_.size())));
    start(path);
  }
  wait_for_robot(path, reply, Clock::now() + kPatience);
}

bool Recordings::close(const std::string& path) {
  const auto at = open_.find(path);
  if (at == open_.end()) return false;
  at->second.closing = true;
  at->second.program->end();
  return true;
}

void Recordings::stop() {
  for (const auto& [path, opened] : open_) opened.program->end();
  open_.clear();
}

/// Empty: no robot shows this file.
std::string Recordings::robot_of(const std::string& path) const {
  for (const auto& link : robots_.all()) {
    const Json hello = Json::parse(link->hello(), nullptr, false);
    if (!link->is_gone() && text_of(hello, "recording") == path) return link->robot();
  }
  return {};
}

void Recordings::start(const std::string& path) {
  const std::uint64_t number = ++last_;
  whys_.erase(path);
  auto program =
      std::make_unique<Program>(std::vector<std::string>{options_.sinew, "bag", "play", "--stay", "--paused", path},
                                ProgramLimits{kNoEnd}, [this, path, number](const ProgramEnd& end) {
                                  server_.post([this, path, number, end] { ended(path, number, end); });
                                });
  open_[path] = {number, std::move(program)};
}

void Recordings::ended(const std::string& path, std::uint64_t number, const ProgramEnd& end) {
  const auto at = open_.find(path);
  if (at == open_.end() || at->second.number != number) return;
  const bool closed = at->second.closing;
  open_.erase(at);  // its thread has called us and returns: nothing to wait for
  if (closed) return;
  const std::string why = reason(end);
  whys_[path] = why;
  if (options_.on_failure) options_.on_failure(path, why);
}

void Recordings::wait_for_robot(const std::string& path, const Server::Reply& reply, Clock::time_point until) {
  if (const std::string robot = robot_of(path); !robot.empty())
    return reply(json_response(200, to_text({{"ok", true}, {"robot", robot}})));
  if (!is_open(path)) return reply(json_error(502, "io", fmt::format("it cannot be played: {}", whys_[path])));
  if (Clock::now() > until)
    return reply(json_error(504, "timeout", "the recorded run did not stand up as a robot in time"));
  server_.after(kLook, [this, path, reply, until] { wait_for_robot(path, reply, until); });
}

}  // namespace sinew::monitor
