#include "net/bridge/robot_client.hpp"

#include <chrono>

#include "hal/platform.hpp"

namespace sinew::net {

using namespace std::chrono_literals;

std::int64_t wall_minus_monotonic() {
  const std::int64_t before = hal::system_os().now().ns;
  const std::int64_t wall =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  const std::int64_t after = hal::system_os().now().ns;
  return wall - (before + (after - before) / 2);
}

bool RobotClient::reach() {
  if (client_ && client_->ended()) drop();
  if (client_) return true;
  const hal::Time now = hal::system_os().now();
  if (now < try_again_) return false;
  try_again_ = now + 1s;
  std::string why;
  auto connected = tap::Client::connect(robot_, why);
  if (!connected) return false;
  client_ = std::move(*connected);
  is_monotonic_ = false;
  return true;
}

void RobotClient::drop() { client_.reset(); }

Json RobotClient::ask(const char* request, const Json& arguments, std::string& why) {
  why.clear();
  if (!client_) return why = "the robot is not there", Json();
  auto reply = client_->request(request, arguments.dump(-1, ' ', false, Json::error_handler_t::replace));
  if (!reply) {
    drop();
    return why = "the robot does not answer", Json();
  }
  Json json = Json::parse(*reply, nullptr, false);
  if (!json.is_object()) return why = "the robot's reply is none", Json();
  if (json.value("ok", false)) return json;
  const auto error = json.find("error");
  why = error != json.end() && error->is_object() ? error->value("why", "") : "";
  if (why.empty()) why = "the robot refuses";
  return Json();
}

std::int64_t RobotClient::clock_offset_ns() {
  if (is_monotonic_) return 0;
  std::string why;
  const std::int64_t before = hal::system_os().now().ns;
  const Json json = ask("clock", Json::object(), why);
  const std::int64_t after = hal::system_os().now().ns;
  const auto now = json.find("now_ns"), monotonic = json.find("monotonic");
  if (now == json.end() || !now->is_number_integer()) return 0;
  is_monotonic_ = monotonic != json.end() && monotonic->is_boolean() && monotonic->get<bool>();
  return is_monotonic_ ? 0 : now->get<std::int64_t>() - (before + (after - before) / 2);
}

}  // namespace sinew::net
