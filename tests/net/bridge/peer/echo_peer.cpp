// echo_peer DOMAIN: reads every type by generated code from rt/there/N and writes it again to rt/back/N, until stdin
// ends. echo_list.inc is made of what `ros2_echo list` prints: ECHO(sensor_msgs::msg::Imu) in the order of N.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <typesPubSubTypes.h>
#include "peer.hpp"

namespace {

template <class T>
class Echo final : public peer::dds::DataReaderListener {
 public:
  explicit Echo(peer::dds::DataWriter* back) : back_(back) {}
  void on_data_available(peer::dds::DataReader* reader) override {
    T sample;
    peer::dds::SampleInfo info;
    while (reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK)
      if (info.valid_data) back_->write(&sample);
  }

 private:
  peer::dds::DataWriter* back_;
};

template <class T, class PubSub>
void echo(peer::Node& node, int n) {
  for (const bool reliable : {true, false}) {
    const std::string end = (reliable ? "/" : "_fast/") + std::to_string(n);
    auto* const writer = node.writer<PubSub>("rt/back" + end, {reliable, false, 10});
    node.reader<PubSub>("rt/there" + end, {reliable, false, 10}, new Echo<T>(writer));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  peer::Node node(static_cast<std::uint32_t>(std::atoi(argv[1])));
  int n = 0;
#define ECHO(type) echo<type, type##PubSubType>(node, n++);
#include <echo_list.inc>
  std::printf("ready\n");
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  std::_Exit(0);  // Fast DDS takes seconds to end so many endpoints
}
