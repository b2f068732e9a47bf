#include "hal/linux/socket.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "hal/linux/memory.hpp"
#include "hal/linux/os.hpp"
#include "hal/linux/shared_memory.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string read_text(Stream& stream) {
  std::array<std::byte, 64> buffer{};
  auto n = stream.read(buffer);
  return n ? std::string(reinterpret_cast<const char*>(buffer.data()), *n) : std::string(to_string(n.error().code));
}

std::string socket_path(const char* name) {
  return testing::TempDir() + "sinew_" + name + "_" + std::to_string(::getpid());
}

class Transport : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const bool tcp = std::strcmp(GetParam(), "tcp") == 0;
    auto listening = listen_stream(tcp ? "tcp:127.0.0.1:0" : "unix:" + socket_path("transport"));
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
  auto reader = linux_os().start_thread({"reader", 0, {}, 256 * 1024}, [&] {
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
  auto reader = linux_os().start_thread({"reader", 0, {}, 256 * 1024}, [&] { end = read_text(*server_); });
  server_->shutdown();
  (*reader)->join();
  EXPECT_EQ(end, "closed");
}

INSTANTIATE_TEST_SUITE_P(All, Transport, testing::Values("unix", "tcp"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST(Endpoints, WrongOnesAreRefusedBeforeAnythingHappens) {
  for (const char* wrong : {"", "unix:", "nowhere", "tcp:localhost", "tcp::4560", "tcp:localhost:"}) {
    EXPECT_EQ(connect_stream(wrong, 0s).error().code, Errc::bad_argument) << wrong;
    EXPECT_EQ(listen_stream(wrong).error().code, Errc::bad_argument) << wrong;
  }
  EXPECT_EQ(connect_stream("unix:/" + std::string(200, 'x'), 0s).error().code, Errc::bad_argument);
}

TEST(Endpoints, AbsentPeerIsNamed) {
  EXPECT_EQ(connect_stream("unix:" + socket_path("nobody"), 10ms).error().code, Errc::not_found);
  std::string endpoint;
  { endpoint = (*listen_stream("tcp:127.0.0.1:0"))->endpoint(); }
  EXPECT_EQ(connect_stream(endpoint, 10ms).error().code, Errc::closed);
}

TEST(Endpoints, PeerThatStartsLaterIsFound) {
  const std::string path = socket_path("later");
  std::unique_ptr<Listener> listener;
  auto starter = linux_os().start_thread({"starter", 0, {}, 256 * 1024}, [&] {
    linux_os().sleep_until(linux_os().now() + 20ms);
    listener = std::move(*listen_stream(path));
  });
  EXPECT_TRUE(connect_stream(path, 20s));
  (*starter)->join();
}

TEST(UnixSocket, FileIsForItsOwnerOnlyAndGoesWithTheListener) {
  const std::string path = socket_path("mode");
  struct stat info {};
  {
    auto listener = listen_stream("unix:" + path);
    ASSERT_TRUE(listener);
    ASSERT_EQ(::stat(path.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0600u);
  }
  EXPECT_NE(::stat(path.c_str(), &info), 0);
}

TEST(UnixSocket, FileOfADeadProcessIsReplacedAndThatOfALivingIsNot) {
  const std::string path = socket_path("dead");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(dead, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ::close(dead);
  auto listener = listen_stream("unix:" + path);
  ASSERT_TRUE(listener);
  EXPECT_EQ(listen_stream("unix:" + path).error().code, Errc::busy);
}

TEST(UnixSocket, OrdinaryFileIsNeverRemoved) {
  const std::string path = socket_path("file");
  std::ofstream(path) << "precious";
  EXPECT_EQ(listen_stream("unix:" + path).error().code, Errc::busy);
  EXPECT_TRUE(std::filesystem::exists(path));
  std::filesystem::remove(path);
}

TEST(UnixSocket, AcceptGivesUp) {
  auto listener = listen_stream("unix:" + socket_path("accept"));
  EXPECT_EQ((*listener)->accept(5ms).error().code, Errc::timeout);
}

// ---- memory

std::size_t open_files() {
  std::size_t n = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) n += entry.exists() ? 1 : 0;
  return n;
}

TEST(SharedMemoryHandOver, PeerSeesTheSameBytesAndCannotWriteThem) {
  auto ends = stream_pair();
  auto mine = create_shared_memory("test", 5000);
  ASSERT_TRUE(ends->first->write_with_memory(bytes_of("here"), **mine));
  EXPECT_EQ(read_text(*ends->second), "here");
  auto theirs = ends->second->take_memory(Stream::MemoryAccess::mapped);
  ASSERT_TRUE(theirs) << theirs.error().where;
  ASSERT_GE((*theirs)->size(), 5000u);
  EXPECT_NE((*theirs)->data(), (*mine)->data());
  (*mine)->data()[4999] = std::byte{0x5A};
  EXPECT_EQ((*theirs)->data()[4999], std::byte{0x5A});
  const int fd = static_cast<int>((*theirs)->handle());
  EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0), MAP_FAILED);
  EXPECT_NE(::ftruncate(fd, 0), 0) << "a reader would die of a bus error";
}

TEST(SharedMemoryHandOver, WhoOnlyCopiesHasNoPageOfIt) {
  constexpr std::size_t kBytes = 4 * 1024 * 1024;
  auto ends = stream_pair();
  auto mine = create_shared_memory("test", kBytes);
  ASSERT_TRUE(ends->first->write_with_memory(bytes_of("here"), **mine));
  EXPECT_EQ(read_text(*ends->second), "here");
  auto theirs = ends->second->take_memory(Stream::MemoryAccess::copied);
  ASSERT_TRUE(theirs) << theirs.error().where;
  EXPECT_EQ((*theirs)->data(), nullptr);
  EXPECT_GE((*theirs)->size(), kBytes);
  std::memset((*mine)->data(), 0x5A, kBytes);
  std::vector<std::byte> got(kBytes / 2);
  const std::uint64_t before = memory_use().peers;
  ASSERT_TRUE((*theirs)->copy(kBytes / 2, got));
  EXPECT_EQ(got.back(), std::byte{0x5A});
  EXPECT_EQ(memory_use().peers, before);
  for (auto* memory : {mine->get(), theirs->get()})
    EXPECT_FALSE(memory->copy(memory->size() - got.size() + 1, got)) << "one byte too far";
}

TEST(SharedMemoryHandOver, MemoryThatItsOwnerCanShrinkIsRefused) {
  const int fd = ::memfd_create("soft", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  ASSERT_EQ(::ftruncate(fd, 4096), 0);
  const std::size_t before = open_files();
  EXPECT_EQ(open_shared_memory(fd, Stream::MemoryAccess::copied).error().code, Errc::bad_data);
  EXPECT_EQ(open_files(), before - 1) << "the handle is closed all the same";
}

TEST(SharedMemoryHandOver, HandleThatIsNoMemoryIsRefused) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  EXPECT_EQ(open_shared_memory(pipe[0], Stream::MemoryAccess::mapped).error().code, Errc::bad_data);
  ::close(pipe[1]);
}

TEST(SharedMemoryHandOver, HandlesNobodyAskedForAreClosed) {
  auto memory = create_shared_memory("test", 4096);
  auto ends = stream_pair();
  const std::size_t before = open_files();
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(ends->first->write_with_memory(bytes_of("x"), **memory));
    EXPECT_EQ(read_text(*ends->second), "x");
  }
  EXPECT_EQ(open_files(), before + 1) << "the first is kept for take_memory()";
  ends->second.reset();
  EXPECT_EQ(open_files(), before - 1);
}

TEST(SharedMemoryHandOver, NothingCameIsNotFound) {
  auto ends = stream_pair();
  EXPECT_EQ(ends->second->take_memory(Stream::MemoryAccess::mapped).error().code, Errc::not_found);
}

TEST(SharedMemoryHandOver, IsNotForTcp) {
  auto listener = listen_stream("tcp:127.0.0.1:0");
  auto client = connect_stream((*listener)->endpoint(), 5s);
  auto memory = create_shared_memory("test", 4096);
  EXPECT_FALSE((*client)->local());
  EXPECT_EQ((*client)->write_with_memory(bytes_of("x"), **memory).error().code, Errc::not_supported);
}

}  // namespace
}  // namespace sinew::hal
