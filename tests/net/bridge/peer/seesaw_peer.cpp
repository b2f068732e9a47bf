// seesaw_peer DOMAIN SECONDS: a foreign simulator of the seesaw on Fast DDS: /imu at 1 kHz and /clock out, /motor in,
// with a clock of its own that begins at 100 s. Prints one object of JSON: the largest tilt of the last two seconds,
// and what it heard.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <typesPubSubTypes.h>
#include "peer.hpp"

namespace {

std::atomic<double> command{0};
std::atomic<int> commands{0};

class Motor final : public peer::dds::DataReaderListener {
 public:
  void on_data_available(peer::dds::DataReader* reader) override {
    std_msgs::msg::Float64MultiArray sample;
    peer::dds::SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK)
      if (info.valid_data && sample.data().size() == 1) command = sample.data()[0], ++commands;
  }
};

template <class Time>
void put(Time& time, double s) {
  time.sec(static_cast<int>(s));
  time.nanosec(static_cast<unsigned>((s - std::floor(s)) * 1e9));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  peer::Node node(static_cast<std::uint32_t>(std::atoi(argv[1])));
  auto* const imu = node.writer<sensor_msgs::msg::ImuPubSubType>("rt/imu", {false, false, 50});
  auto* const clock = node.writer<rosgraph_msgs::msg::ClockPubSubType>("rt/clock", {false, false, 1});
  Motor motor;
  node.reader<std_msgs::msg::Float64MultiArrayPubSubType>("rt/motor", {true, false, 10}, &motor);

  constexpr double kStep_s = 1e-3, kFall_radps2 = 4, kMotor_radps2 = 12, kStop_rad = 0.3, kGravity = 9.80665;
  double pitch = kStop_rad, rate = 0, worst = 0;
  const int steps = std::atoi(argv[2]) * 1000;
  auto next = std::chrono::steady_clock::now();
  for (int i = 0; i < steps; ++i) {
    rate += (kFall_radps2 * pitch + kMotor_radps2 * command) * kStep_s;
    pitch += rate * kStep_s;
    if (std::fabs(pitch) > kStop_rad) pitch = pitch > 0 ? kStop_rad : -kStop_rad, rate = 0;
    if (i >= steps - 2000) worst = std::max(worst, std::fabs(pitch));
    const double now_s = 100 + i * kStep_s;
    if (i % 10 == 0) {
      rosgraph_msgs::msg::Clock said;
      put(said.clock(), now_s);
      clock->write(&said);
    }
    sensor_msgs::msg::Imu sample;
    put(sample.header().stamp(), now_s);
    sample.header().frame_id("beam");
    sample.angular_velocity().y(rate);
    sample.linear_acceleration().x(-kGravity * std::sin(pitch));
    sample.linear_acceleration().z(kGravity * std::cos(pitch));
    imu->write(&sample);
    next += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(next);
  }
  std::printf("{\"worst_rad\": %.6f, \"commands\": %d, \"last\": %.6f}\n", worst, commands.load(), command.load());
  std::fflush(stdout);
  std::_Exit(0);
}
