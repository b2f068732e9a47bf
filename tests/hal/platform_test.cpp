// Rules for every system under the runtime: Linux, and the calls that Windows CE has.
#include "hal/platform.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace sinew::hal::platform_test {
namespace {

using namespace std::chrono_literals;

TEST(SystemOs, SleepNeverEndsBeforeItsTime) {
  Os& os = system_os();
  for (int i = 0; i < 20; ++i) {
    const Time until = os.now() + 200us;
    os.sleep_until(until);
    EXPECT_GE(os.now(), until);
  }
}

TEST(SystemOs, WaitReturnsAtOnceWhenTheWordDiffers) {
  WakeWord word{7};
  system_os().wait(word, 6, kNever);  // would hang for ever if it slept
}

TEST(SystemOs, WaitEndsAtItsDeadline) {
  WakeWord word{0};
  const Time deadline = system_os().now() + 2ms;
  while (system_os().now() < deadline) system_os().wait(word, 0, deadline);
  EXPECT_GE(system_os().now(), deadline);
}

TEST(SystemOs, WakeEndsAWaitOfAnotherThread) {
  Os& os = system_os();
  WakeWord word{0};
  std::atomic<int> seen{0};
  auto thread = os.start_thread({.name = "sleeper", .cpus = {}}, [&] {
    while (word.load(std::memory_order_acquire) == 0) os.wait(word, 0, kNever);
    seen = 1;
  });
  ASSERT_TRUE(thread);
  word.store(1, std::memory_order_release);
  os.wake(word);
  (*thread)->join();
  EXPECT_EQ(seen, 1);
}

TEST(SystemOs, SharedMemoryThatNoMachineHasIsRefused) {
  EXPECT_EQ(system_os().shared_memory("sinew-test", SIZE_MAX).error().code, Errc::out_of_memory);
  EXPECT_EQ(system_os().shared_memory("sinew-test", SIZE_MAX / 4096 * 4096).error().code, Errc::out_of_memory);
}

TEST(SystemOs, SharedMemoryIsZeroedAndPageAligned) {
  auto memory = system_os().shared_memory("sinew-test", 10'000);
  ASSERT_TRUE(memory);
  EXPECT_GE((*memory)->size(), 10'000u);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>((*memory)->data()) % 4096, 0u);
  for (std::size_t i = 0; i < (*memory)->size(); ++i) ASSERT_EQ((*memory)->data()[i], std::byte{0});
}

// Compilers rely on this where they use wide instructions: on 32-bit Windows neither comes by itself.
TEST(SystemOs, ObjectsOnHeapsAndStacksAreAlignedAsTheirTypeSays) {
  struct alignas(16) Wide {
    double value[3];
  };
  volatile std::uintptr_t low_bits = 0;  // volatile: the compiler must not assume them
  std::vector<std::unique_ptr<Wide>> all;
  std::vector<std::unique_ptr<char[]>> between;
  for (std::size_t i = 1; i < 100; ++i) {
    all.push_back(std::make_unique<Wide>());
    between.push_back(std::make_unique<char[]>(i));
    Wide* volatile at = all.back().get();
    low_bits = low_bits | (reinterpret_cast<std::uintptr_t>(at) & 15);
  }
  auto thread = system_os().start_thread({.name = "wide", .cpus = {}}, [&] {
    Wide here{};
    Wide* volatile at = &here;
    low_bits = low_bits | (reinterpret_cast<std::uintptr_t>(at) & 15);
  });
  ASSERT_TRUE(thread);
  (*thread)->join();
  EXPECT_EQ(low_bits, 0u);
}

TEST(SystemOs, ThreadCpuTimeGrowsWithWorkAndNotWithSleep) {
  Os& os = system_os();
  const Duration before = os.thread_cpu_time();
  volatile std::uint64_t sum = 0;
  do sum = sum + 1;  // a coarse clock may have ticked already
  while (os.thread_cpu_time() - before < 1ms);
  EXPECT_GT(sum, 0u);
}

TEST(SystemOs, EachOfManyWaitersIsWokenOnceForEachWake) {
  Os& os = system_os();
  WakeWord word{0};
  std::atomic<int> asleep{0}, awake{0};
  std::vector<std::unique_ptr<Thread>> threads;
  for (int i = 0; i < 4; ++i) {
    auto thread = os.start_thread({.name = "sleeper", .cpus = {}}, [&] {
      ++asleep;
      while (word.load(std::memory_order_acquire) == 0) os.wait(word, 0, kNever);
      ++awake;
    });
    ASSERT_TRUE(thread);
    threads.push_back(std::move(*thread));
  }
  while (asleep < 4) os.sleep_until(os.now() + 1ms);
  word.store(1, std::memory_order_release);
  for (int i = 0; i < 4; ++i) os.wake(word);  // no more than there are: none may be lost
  for (auto& thread : threads) thread->join();
  EXPECT_EQ(awake, 4);
}

TEST(SystemOs, AThreadWithAPriorityRunsAndSaysWhatItCouldNotHave) {
  bool ran = false;
  auto thread = system_os().start_thread({.name = "control", .fifo_priority = 80, .cpus = {1000}}, [&] { ran = true; });
  ASSERT_TRUE(thread);
  (*thread)->join();
  EXPECT_TRUE(ran);
  EXPECT_NE((*thread)->shortfall().find("CPU set"), std::string::npos);
}

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string read_text(Stream& stream) {
  std::array<std::byte, 64> buffer{};
  auto n = stream.read(buffer);
  return n ? std::string(reinterpret_cast<const char*>(buffer.data()), *n) : std::string(to_string(n.error().code));
}

std::string endpoint_of(const std::string& transport) {
  return transport == "tcp" ? "tcp:127.0.0.1:0"
                            : "unix:" + testing::TempDir() + "sinew_platform_" +
                                  std::to_string(reinterpret_cast<std::uintptr_t>(&transport));
}

/// Those that this system has.
std::vector<std::string> transports() {
  std::vector<std::string> all{"tcp"};
  const auto listening = listen_stream(endpoint_of("unix"));
  if (listening || listening.error().code != Errc::not_supported) all.emplace_back("unix");
  return all;
}

class Transport : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    auto listening = listen_stream(endpoint_of(GetParam()));
    ASSERT_TRUE(listening) << listening.error().where;
    listener_ = std::move(*listening);
    auto client = connect_stream(listener_->endpoint(), 5s);
    ASSERT_TRUE(client) << client.error().where;
    client_ = std::move(*client);
    auto server = listener_->accept(5s);
    ASSERT_TRUE(server) << server.error().where;
    server_ = std::move(*server);
  }
  std::unique_ptr<Listener> listener_;
  std::unique_ptr<Stream> client_, server_;
};

TEST_P(Transport, CarriesBytesBothWays) {
  ASSERT_TRUE(client_->write(bytes_of("hal"), bytes_of("lo")));
  std::string got;
  while (got.size() < 5) got += read_text(*server_);
  EXPECT_EQ(got, "hallo");
  ASSERT_EQ(*server_->write_now(bytes_of("du")), 2u);
  EXPECT_EQ(read_text(*client_), "du");
}

TEST_P(Transport, WritesAllOfALargeMessageWhileThePeerReadsSlowly) {
  std::vector<std::byte> head(100, std::byte{1}), tail(3'000'000, std::byte{2});
  std::size_t got = 0;
  auto reader = system_os().start_thread({"reader", 0, {}, 256 * 1024}, [&] {
    std::vector<std::byte> part(50'000);
    while (got < head.size() + tail.size()) {
      auto n = server_->read(part);
      if (!n) return;
      for (std::size_t i = 0; i < *n; ++i, ++got)
        if (part[i] != (got < head.size() ? std::byte{1} : std::byte{2})) return;
    }
  });
  ASSERT_TRUE(client_->write(head, tail));
  (*reader)->join();
  EXPECT_EQ(got, head.size() + tail.size());
}

TEST_P(Transport, ReadNowFindsNothingAndReadTimesOut) {
  std::array<std::byte, 8> buffer{};
  EXPECT_EQ(*server_->read_now(buffer), 0u);
  server_->set_patience(5ms);
  EXPECT_EQ(server_->read(buffer).error().code, Errc::timeout);
}

TEST_P(Transport, AReaderOfItsOwnReadsTimesOutAndEndsAsAnyOther) {
  server_->set_patience(5ms);
  server_->split();
  std::array<std::byte, 8> buffer{};
  EXPECT_EQ(server_->read(buffer).error().code, Errc::timeout);
  ASSERT_TRUE(client_->write(buffer));
  const auto n = server_->read(buffer);
  ASSERT_TRUE(n);
  EXPECT_EQ(*n, buffer.size());
  client_.reset();
  EXPECT_EQ(server_->read(buffer).error().code, Errc::closed);
}

TEST_P(Transport, PeerThatLeftIsClosedAndNoSignal) {
  client_.reset();
  EXPECT_EQ(read_text(*server_), "closed");
  Status status;
  for (int i = 0; i < 100 && status; ++i) status = server_->write(bytes_of("x"));  // TCP hears of it by the answer
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Errc::closed);
}

TEST_P(Transport, ShutdownWakesWhoeverReads) {
  std::string end;
  auto reader = system_os().start_thread({"reader", 0, {}, 256 * 1024}, [&] { end = read_text(*server_); });
  server_->shutdown();
  (*reader)->join();
  EXPECT_EQ(end, "closed");
}

INSTANTIATE_TEST_SUITE_P(All, Transport, testing::ValuesIn(transports()), [](const auto& kind) { return kind.param; });

TEST(Endpoints, WrongOnesAreRefusedBeforeAnythingHappens) {
  for (const char* wrong : {"", "nowhere", "tcp:localhost", "tcp::4560", "tcp:localhost:"}) {
    EXPECT_EQ(connect_stream(wrong, 0s).error().code, Errc::bad_argument) << wrong;
    EXPECT_EQ(listen_stream(wrong).error().code, Errc::bad_argument) << wrong;
  }
}

TEST(Endpoints, AbsentPeerIsNamed) {
  std::string endpoint;
  { endpoint = (*listen_stream("tcp:127.0.0.1:0"))->endpoint(); }
  EXPECT_EQ(connect_stream(endpoint, 10ms).error().code, Errc::closed);
}

TEST(Endpoints, PeerThatStartsLaterIsFound) {
  std::string endpoint;
  { endpoint = (*listen_stream("tcp:127.0.0.1:0"))->endpoint(); }
  std::unique_ptr<Listener> listener;
  auto starter = system_os().start_thread({"starter", 0, {}, 256 * 1024}, [&] {
    system_os().sleep_until(system_os().now() + 20ms);
    if (auto listening = listen_stream(endpoint)) listener = std::move(*listening);
  });
  EXPECT_TRUE(connect_stream(endpoint, 20s));
  (*starter)->join();
}

TEST(Endpoints, AcceptGivesUp) {
  auto listener = listen_stream("tcp:127.0.0.1:0");
  ASSERT_TRUE(listener);
  EXPECT_EQ((*listener)->accept(1ms).error().code, Errc::timeout);
}

}  // namespace
}  // namespace sinew::hal::platform_test
