// TFmini, satellite and radio receivers on /dev/ttyUSB0.
#include <cerrno>
#include <cmath>
#include <cstdio>

#include "rig.hpp"
#include "wire/crsf.hpp"
#include "wire/rc_channels.hpp"
#include "wire/sbus.hpp"
#include "wire/tfmini.hpp"
#include "wire/ubx.hpp"

namespace sinew::test {
namespace {

constexpr const char* kPath = "/dev/ttyUSB0";
using Bytes = std::vector<std::uint8_t>;

/// The device at the far end of the line.
struct Sender {
  std::string driver, measures;
  Duration period;
  /// Frame `number`; stuck: the same numbers, as measured at the instant given.
  Bytes (*frame)(Time now, bool stuck);
  std::vector<Way> duplicate{{.cannot = {Reason::no_number}}};
  std::string title = "`" + driver + "`";
};

class SerialRig final : public Rig {
 public:
  explicit SerialRig(const Sender& sender) : sender_(sender) {
    device = measures = sender.measures;
    names = {kPath};
    specs.devices.push_back(table(device, sender.driver, {{"path", std::string(kPath)}}));
    // An inverter is in front of the line.
    if (sender.driver == "sbus") specs.devices[0].keys["inverted"] = {rt::ParamValue{false}, 0};
    plug();
  }
  std::vector<Way> ways(Fault fault) const override {
    if (fault == Fault::duplicate) return sender_.duplicate;
    if (fault == Fault::garbage) return {{.label = "noise"}, {.label = "wrong bit rate"}};
    return {{}};
  }
  void inject(Fault fault, std::size_t way) override {
    fault_ = fault, way_ = way;
    if (fault == Fault::absent || fault == Fault::unplugged) unplug();
    if (fault == Fault::denied) kernel.refuse(kPath, EACCES);
    if (fault == Fault::busy) node_->held = true;
  }
  void heal() override {
    fault_.reset();
    if (!plugged_) plug();
    kernel.refuse(kPath, 0);
    node_->held = false;
  }
  void advance(Time now) override {
    if (next_.ns == 0) next_ = now;
    for (; next_ <= now; next_ = next_ + sender_.period) send(next_);
  }

 private:
  void plug() {
    node_ = std::make_shared<SerialNode>();
    kernel.add(kPath, node_);
    plugged_ = true;
  }
  void unplug() {
    node_->unplug();
    kernel.remove(kPath);
    plugged_ = false;
  }
  void send(Time now) {
    ++number_;
    if (!plugged_ || fault_ == Fault::silent || (fault_ == Fault::slow && number_ % kSlower != 0)) return;
    Bytes bytes = sender_.frame(fault_ == Fault::stuck ? Time{1} : now, fault_ == Fault::stuck);
    if (fault_ == Fault::garbage)
      for (std::uint8_t& b : bytes) b = way_ == 0 ? noise() : static_cast<std::uint8_t>(b | 0xF0);
    node_->send(bytes);
    if (fault_ == Fault::duplicate) node_->send(bytes);
  }
  std::uint8_t noise() {
    random_ = random_ * 1664525 + 1013904223;
    return static_cast<std::uint8_t>(random_ >> 24);
  }

  static constexpr int kSlower = 40;
  const Sender sender_;
  std::shared_ptr<SerialNode> node_;
  bool plugged_ = false;
  std::optional<Fault> fault_;
  std::size_t way_ = 0;
  Time next_{};
  int number_ = 0;
  std::uint32_t random_ = 1;
};

double wave(Time now) { return std::sin(7 * msg::seconds(now - Time{})); }

Bytes range_frame(Time now, bool) {
  const auto frame = wire::encode_tfmini(static_cast<std::uint16_t>(250 + 20 * wave(now)), 1000);
  return {frame.begin(), frame.end()};
}

std::string closed(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum);
  return "$" + body + end;
}

/// Five times a second the two sentences of one instant; stuck: the receiver's clock stands, too.
Bytes position_frame(Time now, bool) {
  const double t = std::floor(msg::seconds(now - Time{}) * 10 + 0.5) / 10;
  char clock[16], north[16], east[16];
  std::snprintf(clock, sizeof clock, "12%02d%05.2f", static_cast<int>(t / 60) % 60, std::fmod(t, 60));
  std::snprintf(north, sizeof north, "47%07.4f", 30 + 0.01 * wave(now));
  std::snprintf(east, sizeof east, "008%07.4f", 30 + 0.01 * wave(now));
  const std::string text =
      closed(std::string("GNGGA,") + clock + "," + north + ",N," + east + ",E,1,12,1.0,450.0,M,47.0,M,,") +
      closed(std::string("GNRMC,") + clock + ",A," + north + ",N," + east + ",E,10.0,090.0,010126,,,A");
  return {text.begin(), text.end()};
}

/// Five times a second a solution of a u-blox receiver; stuck: of the same instant.
Bytes solution_frame(Time now, bool) {
  wire::UbxPvt pvt;
  pvt.time_of_week_ms = static_cast<std::uint32_t>(now.ns / 1'000'000);
  pvt.sample.fix = msg::GnssFix::full;
  pvt.sample.satellites = 12;
  pvt.sample.latitude_deg = 47.5 + 1e-4 * wave(now), pvt.sample.longitude_deg = 8.5;
  Bytes frame(128);
  frame.resize(wire::encode_nav_pvt(pvt, frame));
  return frame;
}

wire::RcCounts sticks(Time now) {
  wire::RcCounts counts{};
  counts.fill(wire::kRcMiddle);
  counts[0] = wire::rc_count(0.5 * wave(now));
  return counts;
}

Bytes sbus_frame(Time now, bool) {
  wire::SbusFrame f;
  f.channel = sticks(now);
  const auto bytes = wire::encode_sbus(f);
  return {bytes.begin(), bytes.end()};
}

Bytes crsf_frame(Time now, bool) {
  const auto frame = wire::encode_crsf_channels(sticks(now));
  return {frame.begin(), frame.end()};
}

RigKind rig(const Sender& sender) {
  return {sender.driver, sender.title, [sender] { return std::make_unique<SerialRig>(sender); }};
}

}  // namespace

std::vector<RigKind> serial_rigs() {
  return {rig({"tfmini", "range", 10ms, range_frame}), rig({"gnss", "gnss", 200ms, position_frame, {{}}}),
          rig({"gnss", "gnss", 200ms, solution_frame, {{}}, "`gnss`, UBX"}), rig({"sbus", "rc", 14ms, sbus_frame}),
          rig({"crsf", "rc", 14ms, crsf_frame})};
}

}  // namespace sinew::test
