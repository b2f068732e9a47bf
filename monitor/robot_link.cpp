#include "monitor/robot_link.hpp"

#include <fmt/format.h>

#include <utility>

namespace sinew::monitor {
namespace {

std::string refusal(const char* code, const char* why) {
  return fmt::format(R"({{"ok": false, "error": {{"code": "{}", "why": "{}"}}}})", code, why);
}

}  // namespace

RobotLink::RobotLink(std::string robot, int holder, std::unique_ptr<tap::Client> client)
    : robot_(std::move(robot)), holder_(holder), client_(std::move(client)) {
  if (auto hello = client_->request("hello")) hello_ = std::move(*hello);
}

void RobotLink::ask(std::string request, std::string arguments, Done done) {
  const bool taken = worker_.post([this, request = std::move(request), arguments = std::move(arguments), done] {
    done(answer(request, arguments));
  });
  if (!taken) done(refusal("busy", "too many requests wait for this robot"));
}

void RobotLink::look(const std::string& request, std::chrono::milliseconds age, Done done) {
  std::string reply;
  {
    const std::lock_guard lock(mutex_);
    Shared& shared = shared_[request];
    if (!shared.reply.empty() && std::chrono::steady_clock::now() - shared.at <= age && !is_gone()) {
      reply = shared.reply;
    } else {
      shared.waiting.push_back(std::move(done));
      if (shared.waiting.size() > 1) return;
    }
  }
  if (!reply.empty()) return done(std::move(reply));
  ask(request, "{}", [this, request](const std::string& text) {
    std::vector<Done> waiting;
    {
      const std::lock_guard lock(mutex_);
      Shared& shared = shared_[request];
      shared.reply = text, shared.at = std::chrono::steady_clock::now();
      waiting.swap(shared.waiting);
    }
    for (const Done& each : waiting) each(text);
  });
}

std::string RobotLink::answer(const std::string& request, const std::string& arguments) {
  if (is_gone()) return refusal("closed", "the robot has ended");
  auto reply = client_->request(request, arguments);
  if (reply) return std::move(*reply);
  switch (reply.error().code) {
    case hal::Errc::bad_argument:
      return refusal("bad_argument", "arguments: a JSON object of at most 64 KiB");
    case hal::Errc::bad_data:
      return refusal("bad_data", "the robot's reply is none");
    default:  // after a timeout the late reply would be taken for the next one's
      gone_.store(true, std::memory_order_relaxed);
      return reply.error().code == hal::Errc::timeout ? refusal("timeout", "the robot does not answer")
                                                      : refusal("closed", "the robot has ended");
  }
}

}  // namespace sinew::monitor
