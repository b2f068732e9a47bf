#include "apps/run/run_setup.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "apps/robot_file/param_overlay.hpp"
#include "apps/run/ground_truth_source.hpp"
#include "hal/board.hpp"

namespace sinew::app::run_setup_test {
namespace {

rt::GraphSpec two_modules() {
  rt::GraphSpec graph;
  graph.modules = {{.name = "mixer", .type = "M"}, {.name = "lap", .type = "L"}};
  return graph;
}

TEST(Configuring, WhatADeviceSaysItselfIsNotSaidAgainForItsModules) {
  const std::vector<rt::Problem> problems{{3, "module.imu", "not ready", "device 'imu': not found"},
                                          {5, "module.baro", "not ready", "device 'baro': not found"},
                                          {7, "module.guardian", "not ready", "actuators 'head' of the board: PF_CAN"},
                                          {9, "module.camera", "not ready", "param 'gain': the camera has none"}};
  const auto rest =
      without_devices(problems, "device 'imu' (driver iio): no such\ndevice 'head' (driver can_servos): no");
  ASSERT_EQ(rest.size(), 2u);
  EXPECT_EQ(rest[0].key, "module.baro") << "nobody else says it";
  EXPECT_EQ(rest[1].key, "module.camera");
  EXPECT_EQ(without_devices(problems, "").size(), 4u);
}

/// A module whose device allows no gain but 0 to 100.
class Lens final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.param("gain", gain_, {.min = -1, .max = 1000}); }
  hal::Status configure(rt::Setup& setup) override { return setup.narrow("gain", {0, 100, -1, "device 'eye'"}); }
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }

 private:
  double gain_ = -1;
};

TEST(Configuring, WhatTheDeviceDoesNotAllowIsToldOfTheOptionThatSaysItAndNotOfTheRobotFile) {
  const auto told = [](const std::function<void(rt::GraphSpec&, OptionLines&)>& say) {
    Prepared prepared;
    prepared.types.add<Lens>("Lens");
    rt::GraphSpec spec;
    spec.modules = {{.name = "camera", .type = "Lens"}};
    spec.threads = {{.name = "main", .priority = 10, .period = rt::Duration{1'000'000}, .order = {{"camera", 0}}}};
    say(spec, prepared.options);
    prepared.graph = std::make_unique<rt::Graph>(spec, prepared.types);
    hal::EmptyBoard board;
    prepared.robot.path = "r.toml";
    testing::internal::CaptureStderr();
    EXPECT_FALSE(configure(prepared, board, {}));
    return testing::internal::GetCapturedStderr();
  };
  const std::string allowed = ": module.camera.params.gain: 101: a number from 0 to 100, or -1: device 'eye'\n";
  EXPECT_EQ(told([](auto& spec, auto&) { spec.modules[0].params["gain"] = {101.0, 7}; }), "r.toml:7" + allowed);
  EXPECT_EQ(told([](auto& spec, auto& lines) {
              EXPECT_EQ(apply_setting(spec, "camera.gain=101", lines.line_of("--set camera.gain=101")), "");
            }),
            "from --set camera.gain=101" + allowed);
  EXPECT_EQ(told([](auto& spec, auto& lines) {
              rt::ModuleTypes types;
              types.add<Lens>("Lens");
              const auto overlay = parse_overlay("[camera]\ngain = 101\n", "p.toml");
              EXPECT_TRUE(apply_overlay(overlay, types, spec, lines.line_of("--params p.toml")).empty());
            }),
            "from --params p.toml" + allowed);
}

TEST(Setting, BecomesAParameterOfItsModule) {
  rt::GraphSpec graph = two_modules();
  EXPECT_EQ(apply_setting(graph, "lap.laps=4"), "");
  EXPECT_EQ(graph.modules[1].params.at("laps").value, rt::ParamValue(std::int64_t{4}));
}

TEST(Setting, OfAnUnknownModuleIsRefusedWithThoseThatThereAre) {
  rt::GraphSpec graph = two_modules();
  EXPECT_EQ(apply_setting(graph, "lab.laps=4"),
            "--set lab.laps=4: no module lab; there are: mixer lap; did you mean lap?");
  EXPECT_EQ(apply_setting(graph, "laps"), "--set laps: module.param=value");
}

TEST(Setting, OfAnotherSectionIsRefusedWithTheWayToIt) {
  rt::GraphSpec graph = two_modules();
  EXPECT_EQ(apply_setting(graph, "guardian.arming=manual"),
            "--set guardian.arming=manual: --set is for parameters of modules; the keys of [guardian] are set in the "
            "robot file");
  EXPECT_EQ(apply_setting(graph, "thread.vision.priority=3"),
            "--set thread.vision.priority=3: --set is for parameters of modules; the keys of [[thread]] are set in the "
            "robot file");
  EXPECT_EQ(apply_setting(graph, "actuator.motors.lease_ms=3"),
            "--set actuator.motors.lease_ms=3: --set is for parameters of modules; the keys of [actuator.NAME] are set "
            "in the robot file");
}

TEST(Setting, OfAModuleThatIsNamedAsASectionIsTheModules) {
  rt::GraphSpec graph = two_modules();
  graph.modules[0].name = "sim";
  EXPECT_EQ(apply_setting(graph, "sim.seed=4"), "");
  EXPECT_EQ(graph.modules[0].params.size(), 1u);
}

TEST(Setting, OfADeviceTakesThePlaceOfItsKey) {
  drivers::DeviceSpecs devices;
  devices.buses = {{.name = "can0", .driver = "socketcan"}};
  devices.devices = {{.name = "head", .driver = "can_servos", .joints = {{.name = "pan", .driver = "cia402"}}}};
  EXPECT_EQ(apply_device_setting(devices, "bus.can0.driver=udp"), "");
  EXPECT_EQ(devices.buses[0].driver, "udp");
  EXPECT_EQ(apply_device_setting(devices, "device.head.rate_hz=250"), "");
  EXPECT_EQ(devices.devices[0].keys.at("rate_hz").value, rt::ParamValue(std::int64_t{250}));
  EXPECT_EQ(apply_device_setting(devices, "device.head.joint.pan.zero_rad=0.5"), "");
  EXPECT_EQ(devices.devices[0].joints[0].keys.at("zero_rad").value, rt::ParamValue(0.5));
  EXPECT_EQ(apply_device_setting(devices, "mixer.lag=1"), std::nullopt) << "a module's";
  EXPECT_EQ(apply_only_device_setting(devices, "bus.can0.driver=udp"), "");
  EXPECT_EQ(apply_only_device_setting(devices, "mixer.lag=1"),
            "--set mixer.lag=1: device.NAME.KEY=VALUE or bus.NAME.KEY=VALUE");
  EXPECT_EQ(apply_only_device_setting(devices, "bus.can1.bit_rate=1"),
            apply_device_setting(devices, "bus.can1.bit_rate=1"))
      << "the setting is named once";
}

TEST(Setting, OfADeviceThatIsNotThereIsRefused) {
  drivers::DeviceSpecs devices;
  devices.devices = {{.name = "head", .driver = "can_servos"}};
  EXPECT_EQ(apply_device_setting(devices, "bus.can1.bit_rate=1"),
            "--set bus.can1.bit_rate=1: the robot file has no [bus.can1]");
  EXPECT_EQ(apply_device_setting(devices, "device.head.joint.tilt.id=1"),
            "--set device.head.joint.tilt.id=1: [device.head] has no joint tilt");
  EXPECT_EQ(apply_device_setting(devices, "device.haed.rate_hz=1"),
            "--set device.haed.rate_hz=1: the robot file has no [device.haed]; did you mean head?");
}

TEST(RobotFileSections, HaveTheirHeaderButForThatOfTheModules) {
  const auto loaded = parse_robot("nothing = 1\n", "robot.toml");
  const auto unknown = std::find_if(loaded.problems.begin(), loaded.problems.end(),
                                    [](const rt::Problem& p) { return p.key == "nothing"; });
  ASSERT_NE(unknown, loaded.problems.end());
  std::istringstream known(unknown->allowed.substr(unknown->allowed.find(':') + 1));  // by the reader itself
  int sections = 0;
  for (std::string section; known >> section; ++sections)
    EXPECT_EQ(section_header(section).find(section) == std::string::npos, section == "module") << section;
  EXPECT_EQ(sections, 18);
  EXPECT_EQ(section_header("nothing"), "");
}

TEST(GroundTruth, IsAddedBehindAllThatTheRobotHasUnlessItHasItsOwn) {
  rt::GraphSpec robot = two_modules();
  add_ground_truth(robot);
  add_ground_truth(robot);
  ASSERT_EQ(robot.modules.size(), 3u) << "once";
  EXPECT_EQ(robot.modules.back().name, "ground_truth");
  EXPECT_EQ(robot.threads.back().priority, 0) << "below all loops";
  for (const char* const own : {"ground_truth.mocap", "ground_truth"}) {
    rt::GraphSpec other = two_modules();
    other.topics.push_back({.name = own});
    add_ground_truth(other);
    EXPECT_EQ(other.modules.size(), 2u) << own;
  }
}

TEST(GroundTruth, OfASimulatorIsUnknownWhereTheSimulatorSaysNothing) {
  sim_hil::Truth truth;
  truth.p_world_m = {1, 2, 3};
  truth.landed = 1;
  const msg::NavState state = true_state(truth, rt::Time{7});
  EXPECT_EQ(state.stamp.ns, 7);
  EXPECT_EQ(state.p_world_m.z, 3);
  EXPECT_EQ(state.at_rest, 1u);
  EXPECT_TRUE(std::isnan(state.gyro_bias_radps.x));
  EXPECT_TRUE(std::isnan(state.height_m));
}

TEST(GroundTruth, TooManyStatesThatWaitAreRefused) {
  GroundTruthSource source;
  int taken = 0;
  while (taken < 1000 && source.push({})) ++taken;
  EXPECT_EQ(taken, 64);
}

}  // namespace
}  // namespace sinew::app::run_setup_test
