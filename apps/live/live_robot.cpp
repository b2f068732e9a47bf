#include "apps/live/live_robot.hpp"

#include <cstdio>

#include "apps/command/command.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

constexpr hal::Duration kRetry = std::chrono::milliseconds(50);

const char* words(const hal::Error& error) {
  if (error.code == hal::Errc::closed) return "ended";
  if (error.code == hal::Errc::timeout) return "does not answer";
  return error.where;
}

}  // namespace

std::optional<LiveRobot> LiveRobot::find(const LiveOptions& options) {
  hal::Os& os = hal::system_os();
  const hal::Time give_up = os.now() + hal::Duration{static_cast<std::int64_t>(options.wait_s * 1e9)};
  while (true) {
    std::string why;
    auto client = tap::Client::connect(options.robot, why);
    if (client) return LiveRobot(std::move(*client));
    if (client.error().code == hal::Errc::bad_argument || os.now() >= give_up || hal::stop_requested()) {
      fail(why);  // several run: waiting does not make them fewer
      return std::nullopt;
    }
    os.sleep_until(os.now() + kRetry);
  }
}

std::optional<LiveRobot> LiveRobot::try_find(const std::string& name) {
  std::string why;
  auto client = tap::Client::connect(name, why);
  if (!client) return std::nullopt;
  return LiveRobot(std::move(*client));
}

std::optional<Json> LiveRobot::ask(std::string_view request, const Json& arguments) {
  const auto text = client_->request(request, to_line(arguments));
  if (!text) {
    fail("robot " + name() + ": " + words(text.error()));
    return std::nullopt;
  }
  Json reply = Json::parse(*text, nullptr, false);
  const auto ok = reply.is_object() ? reply.find("ok") : reply.end();
  if (ok != reply.end() && *ok == true) return reply;
  const auto error = reply.is_object() ? reply.find("error") : reply.end();
  if (error == reply.end() || !error->is_object()) {
    fail("robot " + name() + ": a reply that cannot be understood");
    return std::nullopt;
  }
  fail("robot " + name() + ": " + error->value("why", "refused"));
  if (const auto reasons = error->find("reasons"); reasons != error->end() && reasons->is_array())
    for (const Json& reason : *reasons)
      if (reason.is_string()) std::fprintf(stderr, "  %s\n", reason.get_ref<const std::string&>().c_str());
  return std::nullopt;
}

const tap::SegmentReader* LiveRobot::reader() {
  const auto reader = client_->reader();
  if (reader) return *reader;
  fail("robot " + name() + ": " +
       (reader.error().code == hal::Errc::not_supported ? "its topics cannot be read from outside"
                                                        : words(reader.error())));
  return nullptr;
}

}  // namespace sinew::app
