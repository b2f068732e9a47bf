// usage: canopen_trace OUT.pcap
// Runs a simulated CiA 402 drive through bring-up, motion, a fault and the end, and writes every frame of the bus to
// OUT.pcap. Prints the meaning of each frame by our own codecs, one line a frame:
//   COB-ID KIND NODE ...     the rest depends on KIND; canopen_tshark_test.py compares it with tshark.
#include <cstdio>
#include <memory>

#include "drivers/joints/cia402_servo.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "sim_hil/wire/sim_cia402.hpp"
#include "wire/canopen.hpp"
#include "wire/pcap_can.hpp"

using namespace sinew;
using namespace std::chrono_literals;

namespace {

class ToBus final : public drivers::FrameSink {
 public:
  explicit ToBus(hal::CanBus& bus) : bus_(bus) {}
  void send(const msg::CanFrame& frame) noexcept override {
    if (!bus_.send(frame, hal::kNever)) std::fprintf(stderr, "a frame was lost\n");
  }

 private:
  hal::CanBus& bus_;
};

void say_bytes(const msg::CanFrame& frame, std::size_t from = 0) {
  std::printf(" ");
  for (const std::uint8_t b : frame.bytes().subspan(from)) std::printf("%02x", b);
}

bool say_sdo(const char* kind, std::uint32_t node, const std::optional<wire::Sdo>& sdo) {
  if (!sdo) return false;
  std::printf("%s %u", kind, node);
  using Kind = wire::Sdo::Kind;
  const bool no_object = sdo->kind == Kind::segment || sdo->kind == Kind::read_segment;
  if (no_object) {
    std::printf(" segment");
    return true;
  }
  std::printf(" %04x %02x", unsigned{sdo->object.index}, unsigned{sdo->object.sub});
  if (sdo->kind == Kind::abort) std::printf(" abort %08x", sdo->abort_code);
  if (sdo->kind == Kind::write || sdo->kind == Kind::value) {
    std::printf(" data ");
    for (std::size_t i = 0; i < sdo->size; ++i) std::printf("%02x", unsigned{sdo->data[i]});
  }
  return true;
}

/// One line; false: our own codecs do not know the frame.
bool say(const msg::CanFrame& frame) {
  const wire::CanopenId id = wire::canopen_id(frame.id);
  std::printf("%03x ", frame.id);
  bool known = true;
  switch (id.kind) {
    case wire::CanopenKind::nmt: {
      const auto nmt = wire::decode_nmt(frame);
      known = nmt.has_value();
      if (known) std::printf("nmt %u %u", static_cast<unsigned>(nmt->command), nmt->node);
      break;
    }
    case wire::CanopenKind::sync:
      std::printf("sync 0");
      break;
    case wire::CanopenKind::emergency: {
      const auto emergency = wire::decode_emergency(frame);
      known = emergency.has_value();
      if (known)
        std::printf("emcy %u %04x %02x", id.node, unsigned{emergency->code}, unsigned{emergency->error_register});
      break;
    }
    case wire::CanopenKind::tpdo:
    case wire::CanopenKind::rpdo:
      std::printf("pdo %u", id.node);
      say_bytes(frame);
      break;
    case wire::CanopenKind::sdo_request:
      known = say_sdo("sdo_request", id.node, wire::decode_sdo_request(frame));
      break;
    case wire::CanopenKind::sdo_reply:
      known = say_sdo("sdo_reply", id.node, wire::decode_sdo_reply(frame));
      break;
    case wire::CanopenKind::heartbeat: {
      const auto state = wire::decode_heartbeat(frame);
      known = state.has_value();
      if (known) std::printf("heartbeat %u %u", id.node, static_cast<unsigned>(*state));
      break;
    }
    default:
      known = false;
  }
  std::printf("\n");
  return known;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s OUT.pcap\n", argv[0]);
    return 2;
  }
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(argv[1], "wb"), std::fclose);
  if (!file) {
    std::perror(argv[1]);
    return 1;
  }
  const auto head = wire::pcap_can_head();
  std::fwrite(head.data(), 1, head.size(), file.get());

  hal::ManualClock clock;
  clock.set({1'000'000'000});
  sim_hil::MemoryCan bus(1'000'000, &clock);
  auto &ours = bus.attach(), &theirs = bus.attach(), &ear = bus.attach();
  ToBus out(ours);
  sim_hil::SimServos sims(theirs);
  sim_hil::JointModel joint;
  sim_hil::SimCia402::Parameters parameters;
  parameters.node_id = 4;
  auto& sim = sims.add<sim_hil::SimCia402>(joint, sim_hil::SimMount{}, parameters);
  drivers::ServoConfig config;
  config.name = "pan", config.node_id = 4, config.counts_per_turn = 65536;
  config.limits.velocity_radps = 10, config.limits.effort_nm = 2;
  config.device_timeout = 100ms;
  drivers::CanopenMaster master;
  drivers::Cia402Servo servo(config, {});

  bool known = true;
  const auto record = [&] {
    msg::CanFrame frame;
    for (auto got = ear.read(frame); got && *got; got = ear.read(frame)) {
      std::array<std::uint8_t, wire::kPcapCanMax> bytes{};
      const std::size_t size = wire::pcap_can_record(frame, bytes);
      known = std::fwrite(bytes.data(), 1, size, file.get()) == size && size > 0 && say(frame) && known;
    }
  };
  int enabled = 0;
  std::uint32_t number = 0;
  for (int tick = 0; tick < 1500; ++tick) {
    const hal::Time now = clock.now();
    msg::CanFrame frame;
    for (auto got = ours.read(frame); got && *got; got = ours.read(frame)) servo.on_frame(frame, now);
    drivers::ServoCommand command;
    command.intent = tick < 1400 ? drivers::ServoCommand::Intent::follow : drivers::ServoCommand::Intent::off;
    command.setpoint = 0.3, command.number = ++number;
    if (tick == 900) sim.fail(0x4210);  // CiA 301: device temperature
    master.begin(now, out);
    servo.tick(now, command, out);
    master.end(now, out);
    sims.poll(now);
    record();
    enabled += servo.feedback().mode == msg::JointMode::enabled ? 1 : 0;
    clock.set(now + 2ms);
  }
  servo.farewell(out);
  record();
  if (enabled == 0) {
    std::fprintf(stderr, "the drive was never enabled: this trace would show nothing\n");
    return 1;
  }
  if (!known) {
    std::fprintf(stderr, "a frame that our own codecs do not know\n");
    return 1;
  }
  return 0;
}
