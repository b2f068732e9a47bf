// Simulated drives on a CAN bus, in a process of their own.
//   can_drives TRANSPORT:ADDRESS SERVO...       SERVO: cia402:ID, mit:ID (ak80_9), cybergear:ID, actuator:NODE:INDEX,
//                                               esc:NODE:INDEX, asks:NODE:INDEX (an actuator that has no node id yet)
// TRANSPORT:ADDRESS may be socketcand-server:PORT: then this is the server (PORT 0: any).
// TRANSPORT:ADDRESS may be socketcand-server:PORT: then this is the server (PORT 0: any).
// Prints "ready ENDPOINT", then "I live" or "I off" whenever servo I (from 0) gets or loses its torque. Takes lines "I
// silent", "I fail", "I power off", "I hot", which set a fault of servo I; it answers "I at" with "I at RAD". Ends with
// its input.
#include <poll.h>
#include <unistd.h>

#include <charconv>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "hal/linux/can/can.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "sim_hil/wire/sim_cia402.hpp"
#include "sim_hil/wire/sim_dronecan.hpp"
#include "sim_hil/wire/sim_impedance.hpp"
#include "sim_hil/wire/socketcand_server.hpp"

using namespace sinew;
using namespace std::chrono_literals;

namespace {

struct Drives {
  explicit Drives(hal::CanBus& bus) : sims(bus) {}
  sim_hil::SimServos sims;
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints;
  std::vector<sim_hil::SimServo*> servos;
  std::vector<bool> live;

  bool add(const std::string& text) {
    std::istringstream in(text);
    std::string kind, number;
    std::vector<std::uint32_t> numbers;
    std::getline(in, kind, ':');
    while (std::getline(in, number, ':')) {
      std::uint32_t value = 0;
      if (std::from_chars(number.data(), number.data() + number.size(), value).ec != std::errc()) return false;
      numbers.push_back(value);
    }
    const bool dronecan = kind == "actuator" || kind == "esc" || kind == "asks";
    if (numbers.size() != (dronecan ? 2u : 1u)) return false;
    joints.push_back(std::make_unique<sim_hil::JointModel>());
    sim_hil::SimJoint& joint = *joints.back();
    if (kind == "cia402") {
      sim_hil::SimCia402::Parameters p;
      p.node_id = numbers[0];
      servos.push_back(&sims.add<sim_hil::SimCia402>(joint, sim_hil::SimMount{}, p));
    } else if (kind == "mit") {
      servos.push_back(&sims.add<sim_hil::SimMitMotor>(
          joint, sim_hil::SimMount{},
          sim_hil::SimMitMotor::Parameters{numbers[0], 0, *wire::mit_motor_type("ak80_9"), 0s}));
    } else if (kind == "cybergear") {
      servos.push_back(&sims.add<sim_hil::SimCyberGear>(
          joint, sim_hil::SimMount{}, sim_hil::SimCyberGear::Parameters{.motor = numbers[0], .serial = 0xC0FFEE}));
    } else if (dronecan) {
      sim_hil::SimDronecanServo::Parameters p;
      p.node_id = static_cast<std::uint8_t>(kind == "asks" ? 0 : numbers[0]);
      p.actuator_id = static_cast<std::uint8_t>(numbers[1]);
      p.esc = kind == "esc";
      p.timeout = 30s;
      p.unique_id.fill(static_cast<std::uint8_t>(numbers[0]));
      servos.push_back(&sims.add<sim_hil::SimDronecanServo>(joint, sim_hil::SimMount{}, p));
    } else {
      return false;
    }
    live.push_back(false);
    return true;
  }

  void tell() {
    for (std::size_t i = 0; i < servos.size(); ++i) {
      if (servos[i]->live() == live[i]) continue;
      live[i] = servos[i]->live();
      std::printf("%zu %s\n", i, live[i] ? "live" : "off");
      std::fflush(stdout);
    }
  }

  void obey(const std::string& line) {
    std::istringstream in(line);
    std::size_t i = 0;
    std::string what, more;
    in >> i >> what >> more;
    if (i >= servos.size()) return;
    if (what == "silent") servos[i]->faults.silent = true;
    if (what == "fail") servos[i]->fail(1);
    if (what == "hot") servos[i]->temperature_c = 70;
    if (what == "power") servos[i]->power(more != "off");
    if (what == "at") {
      std::printf("%zu at %.4f\n", i, joints[i]->position_rad());
      std::fflush(stdout);
    }
  }
};

}  // namespace

int main(int argc, char** argv) {
  const std::string address = argc > 1 ? argv[1] : "";
  const auto colon = address.find(':');
  hal::Os& os = hal::system_os();
  auto watch = hal::FdWatch::start(os, {"drives", 0, {}, std::size_t{64} * 1024, 0});
  std::string why;
  const hal::CanSpec spec{address.substr(0, colon), colon == std::string::npos ? "" : address.substr(colon + 1)};
  std::unique_ptr<sim_hil::SocketcandServer> server;
  hal::Result<std::unique_ptr<hal::CanBus>> bus = hal::Error{};
  if (spec.transport == "socketcand-server") {  // of buses can0 and can1; the drives are on can0
    auto listener = hal::listen_stream("tcp:127.0.0.1:" + spec.address);
    auto opened =
        listener ? sim_hil::SocketcandServer::open(os, std::move(*listener), {"can0", "can1"}) : listener.error();
    if (!opened) {
      std::fprintf(stderr, "can_drives: %s\n", opened.error().where);
      return 2;
    }
    server = std::move(*opened);
    bus = server->bus("can0");
  } else if (watch) {
    bus = hal::open_can(spec, os, *watch, why);
  }
  if (!bus) {
    std::fprintf(stderr, "can_drives: %s\n", why.c_str());
    return 2;
  }
  Drives drives(**bus);
  for (int i = 2; i < argc; ++i)
    if (!drives.add(argv[i])) {
      std::fprintf(stderr, "can_drives: '%s' is no servo\n", argv[i]);
      return 2;
    }
  std::printf("ready %s\n", server ? server->endpoint().c_str() : "");
  std::fflush(stdout);
  for (;;) {
    drives.sims.poll(os.now());
    drives.tell();
    pollfd input{0, POLLIN, 0};
    if (poll(&input, 1, 1) == 1) {
      std::string line;
      if (!std::getline(std::cin, line)) return 0;
      drives.obey(line);
    }
  }
}
