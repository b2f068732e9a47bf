// The parent's way to joints on a bus behind a network that is slow.
#include "apps/run/device_stop.hpp"

#include <gmock/gmock.h>

#include <atomic>

#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "sim_hil/wire/sim_cia402.hpp"
#include "sim_hil/wire/socketcand_server.hpp"

namespace sinew::app::device_stop_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

hal::Os& os() { return hal::system_os(); }

class DeviceStopTest : public ::testing::Test {
 protected:
  DeviceStopTest() {
    listener = std::move(*hal::listen_stream("tcp:127.0.0.1:0"));  // the kernel takes calls; no server says "< hi >"
    prepared.robot.devices.buses.push_back(spec("can0", "socketcand", {{"address", address() + "/can0"}}));
    auto group = spec("body", "can_servos", {});
    group.joints.push_back(spec("pan", "cia402", {{"bus", "can0"}}));
    group.joints[0].keys["id"] = {std::int64_t{1}, 0};
    group.joints[0].keys["counts_per_turn"] = {65536.0, 0};
    group.joints[0].keys["rated_effort_nm"] = {2.0, 0};
    prepared.robot.devices.devices.push_back(group);
    rt::GraphSpec robot;
    robot.board = "linux";
    robot.actuators.emplace_back().name = "body";
    prepared.graph = std::make_unique<rt::Graph>(robot, prepared.types);
    add_stops_of_linux_devices(prepared, stops);
  }
  static drivers::DeviceSpec spec(const std::string& name, const std::string& driver,
                                  const std::map<std::string, std::string>& texts) {
    drivers::DeviceSpec s;
    s.name = name, s.driver = driver;
    for (const auto& [key, text] : texts) s.keys[key] = {text, 0};
    return s;
  }
  std::string address() const { return listener->endpoint().substr(4); }

  std::unique_ptr<hal::Listener> listener;
  Prepared prepared;
  std::vector<StopWay> stops;
};

TEST_F(DeviceStopTest, ABusThatConnectsSlowlyKeepsNobodyWaitingAndIsStoppedWhenItIsThere) {
  ASSERT_EQ(stops.size(), 1u);
  const auto line = stops[0].open();
  ASSERT_TRUE(line) << "it is not known yet whether the server will speak";
  line->poll();
  const hal::Status early = line->stop();
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().code, hal::Errc::timeout);
  EXPECT_THAT(early.error().where, HasSubstr("still being connected to"));

  // Now a server takes the calls that wait.
  auto server = std::move(*sim_hil::SocketcandServer::open(os(), std::move(listener), {"can0"}));
  const auto bus = std::move(*server->bus("can0"));
  sim_hil::SimServos sims(*bus);
  sim_hil::JointModel joint;
  sims.add<sim_hil::SimCia402>(joint, sim_hil::SimMount{}, sim_hil::SimCia402::Parameters{});
  std::atomic<bool> ends{false};
  auto drives = os().start_thread({}, [&] {
    for (; !ends.load(); os().sleep_until(os().now() + 1ms)) sims.poll(os().now());
  });
  ASSERT_TRUE(drives);
  hal::Status stopped = early;
  for (const hal::Time end = os().now() + 10s; !stopped && os().now() < end;) stopped = line->stop();
  EXPECT_TRUE(stopped) << stopped.error().where;
  EXPECT_THAT(line->last_report(), HasSubstr("1 of 1 joints are without torque"));
  EXPECT_FALSE(line->is_latching());
  ends = true;
  (*drives)->join();
}

TEST_F(DeviceStopTest, ABusWhereNobodyListensIsNoLine) {
  listener.reset();
  const auto line = stops[0].open();
  if (!line) return;  // known in time
  hal::Status stopped = line->stop();
  for (const hal::Time end = os().now() + 10s; os().now() < end && stopped.error().code == hal::Errc::timeout;)
    stopped = line->stop();
  EXPECT_EQ(stopped.error().code, hal::Errc::closed);
}

}  // namespace
}  // namespace sinew::app::device_stop_test
