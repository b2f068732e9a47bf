#pragma once
// A robot in memory, and a session on it whose clock and link a test sets.
#include <cstdlib>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "monitor/foxglove/session.hpp"

namespace sinew::foxglove {

using Json = nlohmann::ordered_json;
using namespace std::chrono_literals;

class FakeRobot final : public Robot, public std::enable_shared_from_this<FakeRobot> {
 public:
  explicit FakeRobot(std::string name) {
    facts_.name = std::move(name);
    Channel imu{"/imu.raw", "cdr", "sinew_msgs/msg/ImuSample", "int64 stamp\n", "ros2msg", Channel::Kind::messages,
                true};
    Channel image{"/camera.raw", "cdr", "sensor_msgs/msg/Image", "uint8[] data\n", "ros2msg"};
    Channel jpeg = image;
    jpeg.topic += "/jpeg", jpeg.kind = Channel::Kind::pictures;
    Channel status{"/sinew/status", "json", "sinew.status", "{}", "jsonschema", Channel::Kind::report};
    facts_.channels = {imu, image, jpeg, status};
    facts_.published = {{"/imu.raw", {"imu"}}, {"/camera.raw", {"camera"}}};
    facts_.subscribed = {{"/imu.raw", {"filter", "log"}}, {"/camera.raw", {}}};
    facts_.requests = {"arm", "record.status"};
    facts_.external = {"operator.setpoint"};
    facts_.threads = {"fast"};
  }
  const RobotFacts& facts() const override { return facts_; }
  std::shared_ptr<void> subscribe(std::size_t channel, std::shared_ptr<Inbox> inbox) override {
    inboxes[channel].push_back(inbox);
    return {nullptr, [self = shared_from_this(), channel, inbox](void*) { std::erase(self->inboxes[channel], inbox); }};
  }
  std::shared_ptr<PictureTap> look(std::size_t channel, std::shared_ptr<Inbox> inbox) override {
    struct Tap final : PictureTap {
      std::shared_ptr<FakeRobot> robot;
      std::shared_ptr<Inbox> inbox;
      void want(const PictureSize& size) override {
        robot->wanted.push_back(size);
        robot->viewer = inbox;
      }
    };
    auto tap = std::make_shared<Tap>();
    tap->robot = shared_from_this(), tap->inbox = std::move(inbox);
    if (channel != 2) std::abort();
    return tap;
  }
  void ask(std::string request, std::string arguments, Done done) override {
    asked.emplace_back(request, arguments);
    if (hold)
      held.push_back(std::move(done));
    else
      done(replies.contains(request) ? replies[request] : R"({"ok":true})");
  }
  void recent_status(Done done) override { ask("status", "{}", std::move(done)); }
  std::uint64_t time_ns() const override { return now_ns; }

  void publish(std::size_t channel, std::string_view payload, std::uint64_t at = 1) {
    for (const auto& inbox : inboxes[channel]) inbox->put({at, monitor::bytes_of(payload)});
  }
  void picture(std::size_t bytes) {
    const auto to = std::exchange(viewer, nullptr);
    if (to) to->put({1, std::make_shared<const std::vector<std::byte>>(bytes)});
  }

  RobotFacts facts_;
  std::map<std::size_t, std::vector<std::shared_ptr<Inbox>>> inboxes;
  std::vector<PictureSize> wanted;
  std::shared_ptr<Inbox> viewer;
  std::vector<std::pair<std::string, std::string>> asked;
  std::map<std::string, std::string> replies;
  bool hold = false;
  std::vector<Done> held;
  std::uint64_t now_ns = 0;
};

/// What a client received.
struct Received {
  bool binary = false;
  std::string bytes;
  Json json() const { return Json::parse(bytes, nullptr, false); }
  std::uint64_t number(std::size_t at, std::size_t size) const {
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
    return value;
  }
};

class Rig {
 public:
  explicit Rig(Session::Options options = {}) {
    Session::Host host;
    host.wake = [this] { ++woken; };
    host.wake_in = [this](std::chrono::milliseconds) { ++woken_later; };
    host.post = [this](std::function<void()> what) { posted.push_back(std::move(what)); };
    host.link = [this] { return std::optional<Link>(link); };
    host.now = [this] { return now; };
    host.refuses = [this](const std::string&, const std::string&) { return refusal; };
    options.name = "test", options.id = "7";
    session = std::make_unique<Session>(std::move(options), std::move(host));
  }
  bool text(const std::string& message) { return session->receive(false, std::as_bytes(std::span(message))); }
  bool json(const Json& message) { return text(message.dump()); }
  bool binary(std::string_view message) { return session->receive(true, std::as_bytes(std::span(message))); }
  void run_posted() {
    while (!posted.empty()) {
      auto all = std::exchange(posted, {});
      for (const auto& what : all) what();
    }
  }
  std::optional<Received> next() {
    run_posted();
    auto message = session->next();
    if (!message) return std::nullopt;
    Received r;
    r.binary = message->binary;
    for (const std::byte b : message->head) r.bytes += static_cast<char>(b);
    if (message->bytes)
      for (const std::byte b : *message->bytes) r.bytes += static_cast<char>(b);
    return r;
  }
  std::vector<Received> all() {
    std::vector<Received> list;
    while (auto r = next()) list.push_back(std::move(*r));
    return list;
  }
  /// The next JSON message with this op; null when there is none.
  Json of(std::string_view op) {
    for (const Received& r : all())
      if (!r.binary && r.json()["op"] == op) return r.json();
    return {};
  }
  std::string complaint() {
    const Json status = of("status");
    return status.is_object() ? status["message"].get<std::string>() : "none";
  }

  int woken = 0, woken_later = 0;
  std::vector<std::function<void()>> posted;
  Link link{};
  Session::Clock::time_point now{};
  std::string refusal;
  std::unique_ptr<Session> session;
};

inline std::string little(std::uint64_t value, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}

}  // namespace sinew::foxglove
