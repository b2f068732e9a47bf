#include "apps/robot/doctor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/module_list.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "source_dir.hpp"

namespace sinew::app::doctor_test {
namespace {

using hal::CheckState;
using ::testing::HasSubstr;

const std::vector<hal::SystemCheck> kChecks{{"fine", CheckState::ok, "as it should be", ""},
                                            {"odd", CheckState::warning, "not quite", "do this"},
                                            {"bad", CheckState::problem, "missing \"x\"", "do that"},
                                            {"dark", CheckState::unknown, "nobody knows", ""}};

TEST(Doctor, TellsPeopleEverythingAndAStartOnlyWhatAils) {
  EXPECT_THAT(doctor_text(kChecks), HasSubstr("bad           missing \"x\"\n"));
  EXPECT_THAT(doctor_text(kChecks), HasSubstr("-> do that\n"));
  EXPECT_THAT(doctor_text(kChecks), HasSubstr("4 checks: 1 problem, 1 warning, 1 unknown\n"));
  EXPECT_EQ(doctor_lines(kChecks), "warning: odd: not quite\nproblem: bad: missing \"x\"\n");
}

TEST(Doctor, TellsProgramsTheSame) {
  const auto j = nlohmann::json::parse(doctor_json(kChecks));
  EXPECT_EQ(j["problems"], 1);
  EXPECT_EQ(j["warnings"], 1);
  ASSERT_EQ(j["checks"].size(), 4u);
  EXPECT_EQ(j["checks"][2]["id"], "bad");
  EXPECT_EQ(j["checks"][2]["state"], "problem");
  EXPECT_EQ(j["checks"][2]["seen"], "missing \"x\"");
  EXPECT_EQ(j["checks"][2]["advice"], "do that");
}

TEST(Doctor, StrictCountsWarnings) {
  EXPECT_TRUE(ails({kChecks[2]}, false));
  EXPECT_FALSE(ails({kChecks[1]}, false));
  EXPECT_TRUE(ails({kChecks[1]}, true));
  EXPECT_FALSE(ails({kChecks[0], kChecks[3]}, true)) << "what nobody knows refuses nothing";
}

TEST(Doctor, ARobotsDemandIsThatOfItsFile) {
  const LoadedRobot loaded = load_robot(sinew::test::source_dir() + "/robots/quad/quad.toml");
  rt::Graph graph(loaded.robot.graph, all_modules());
  const hal::SystemDemand demand = system_demand(graph, true);
  ASSERT_EQ(demand.threads.size(), graph.threads().size());
  ASSERT_GE(demand.threads.size(), 3u);
  EXPECT_EQ(demand.threads[0].name, "guardian");
  EXPECT_EQ(demand.threads[0].fifo_priority, 99);
  EXPECT_FALSE(demand.threads[0].reads_devices);
  EXPECT_EQ(demand.threads[1].name, "stabilise");
  EXPECT_TRUE(demand.threads[1].reads_devices) << "the IMU";
  EXPECT_FALSE(demand.threads[2].reads_devices) << "navigation has none";
  EXPECT_FALSE(system_demand(graph, false).threads[1].reads_devices) << "a simulator interrupts nobody";
  EXPECT_GT(demand.locked_bytes, 2u << 20) << "slots of the camera";
}

TEST(Doctor, DevicesOfTheBoardLinuxAreLookedFor) {
  RobotFile robot;
  robot.graph.board = "linux";
  robot.graph.device_boards["range"].value = "sim";
  robot.parent.watchdog = "/dev/watchdog";
  const auto spec = [](const char* name, const char* driver, const char* key, const char* text) {
    drivers::DeviceSpec s;
    s.name = name, s.driver = driver, s.keys[key].value = std::string(text);
    return s;
  };
  robot.devices.buses = {spec("arms", "socketcan", "address", "can0")};
  robot.devices.buses[0].keys["bit_rate"].value = std::int64_t{500'000};
  robot.devices.devices = {spec("imu", "iio", "name", "mpu6050"), spec("gps", "ublox", "path", "/dev/ttyS1"),
                           spec("range", "tfmini", "path", "/dev/ttyS2")};
  hal::SystemDemand demand;
  add_devices(robot, demand);
  EXPECT_TRUE(demand.real_board && demand.iio);
  EXPECT_EQ(demand.device_priority, 95) << "the thread that watches descriptors";
  ASSERT_EQ(demand.can.size(), 1u);
  EXPECT_EQ(demand.can[0].interface, "can0");
  EXPECT_EQ(demand.can[0].bit_rate, 500'000u);
  ASSERT_EQ(demand.nodes.size(), 2u) << "the range finder is simulated";
  EXPECT_EQ(demand.nodes[0].path, "/dev/ttyS1");
  EXPECT_EQ(demand.nodes[0].used_by, "device.gps");
  EXPECT_EQ(demand.nodes[1].used_by, "parent.watchdog");
  robot.devices.devices[0].keys["priority"].value = std::int64_t{97};
  robot.devices.devices[0].keys["root"].value = std::string("/tmp/iio");
  demand = {};
  add_devices(robot, demand);
  EXPECT_EQ(demand.device_priority, 97);
  EXPECT_FALSE(demand.iio) << "its files are not the kernel's";
  robot.graph.board = "sim";
  demand = {};
  add_devices(robot, demand);
  EXPECT_FALSE(demand.real_board);
}

class DoctorCommand : public ::testing::Test {
 protected:
  DoctorCommand() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew_doctor_XXXXXX").string();
    options.root = ::mkdtemp(pattern.data());
  }
  ~DoctorCommand() override { std::filesystem::remove_all(options.root); }
  void file(const std::string& name, const std::string& text) {
    const auto path = std::filesystem::path(options.root) / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text << "\n";
  }
  DoctorOptions options;
};

TEST_F(DoctorCommand, ExitCodesSayHowBadItIs) {
  EXPECT_EQ(doctor_command(options, all_modules()), 0);
  file("proc/version", "#1 SMP PREEMPT");
  EXPECT_EQ(doctor_command(options, all_modules()), 0) << "a warning";
  options.strict = true;
  EXPECT_EQ(doctor_command(options, all_modules()), 1);
  options.strict = false;
  file("proc/self/status", "CapEff: 0\nCpus_allowed_list: 0");
  file("proc/self/limits", "Max realtime priority     0   0\nMax locked memory  unlimited unlimited bytes");
  EXPECT_EQ(doctor_command(options, all_modules()), 1);
  options.robot = sinew::test::source_dir() + "/robots/quad/quad.toml";
  EXPECT_EQ(doctor_command(options, all_modules()), 1);
  options.robot = "no_such.toml";
  EXPECT_EQ(doctor_command(options, all_modules()), 2);
  options.robot.clear();
  options.root += "/no/such/folder";
  EXPECT_EQ(doctor_command(options, all_modules()), 2);
  options.root.resize(options.root.size() - 15);
}

}  // namespace
}  // namespace sinew::app::doctor_test
