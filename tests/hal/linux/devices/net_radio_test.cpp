#include "hal/linux/devices/net_radio.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "hal/can_waiting.hpp"
#include "hal/platform.hpp"
#include "hal/scaled_os.hpp"

namespace sinew::hal::net_radio_test {
namespace {

/// In place of `sinew net`: takes one robot.
class Program {
 public:
  explicit Program(const std::string& robot) : listen_(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    std::string why;
    const auto path = net_socket_path(robot, why);
    EXPECT_TRUE(path) << why;
    sockaddr_un own{};
    own.sun_family = AF_UNIX;
    std::copy(path->begin(), path->end(), own.sun_path);
    path_ = *path;
    EXPECT_EQ(bind(listen_, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0) << std::strerror(errno);
    EXPECT_EQ(listen(listen_, 1), 0);
  }
  ~Program() {
    close(listen_);
    unlink(path_.c_str());
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

 private:
  int listen_;
  std::string path_;
};

std::string trouble_of(const Radio& radio) { return dynamic_cast<const SelfReport&>(radio).trouble(); }

std::unique_ptr<Radio> opened(const std::string& robot, Os& os) {
  std::string why;
  auto radio = NetRadio::open(robot, os, why);
  EXPECT_TRUE(radio) << why;
  return radio ? std::move(*radio) : nullptr;
}

std::string own_name() { return "net-radio-" + std::to_string(getpid()); }

TEST(NetRadioTest, AProgramThatNeverCameIsStartingAndAfterABoundItDoesNotRun) {
  ScaledOs slow(system_os(), 1e-4), fast(system_os(), 50);  // ten seconds are a day, and 0.2 s
  const auto waits = opened(own_name(), slow), waited = opened(own_name(), fast);
  EXPECT_EQ(trouble_of(*waits), "sinew net of '" + own_name() + "' is starting");
  EXPECT_TRUE(
      eventually([&] { return trouble_of(*waited) == "sinew net of '" + own_name() + "' does not run: no DDS"; }));
  EXPECT_EQ(trouble_of(*waits), "sinew net of '" + own_name() + "' is starting") << "by its own clock";
}

TEST(NetRadioTest, AProgramThatWasThereAndEndedDoesNotRun) {
  ScaledOs slow(system_os(), 0.01);
  std::unique_ptr<Radio> radio;
  {
    const Program program(own_name());
    radio = opened(own_name(), slow);
    ASSERT_TRUE(eventually([&] { return trouble_of(*radio).empty(); }));
  }
  EXPECT_TRUE(eventually([&] {
    return trouble_of(*radio) == "sinew net of '" + own_name() + "' does not run: no DDS";
  })) << "also before the bound of one that starts";
}

}  // namespace
}  // namespace sinew::hal::net_radio_test
