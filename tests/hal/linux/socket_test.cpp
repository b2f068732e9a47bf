#include "hal/linux/socket.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netdb.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "hal/linux/memory.hpp"
#include "hal/linux/shared_memory.hpp"
#include "hal/platform.hpp"

namespace sinew::hal::socket_test {
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

bool resolves_to_ipv6(const char* host) {
  addrinfo hints{};
  hints.ai_family = AF_INET6;
  addrinfo* list = nullptr;
  if (::getaddrinfo(host, nullptr, &hints, &list) != 0) return false;
  ::freeaddrinfo(list);
  return true;
}

TEST(UnixSocket, WrongEndpointsAreRefusedBeforeAnythingHappens) {
  for (const std::string& wrong : {std::string("unix:"), "unix:/" + std::string(200, 'x')}) {
    EXPECT_EQ(connect_stream(wrong, 0s).error().code, Errc::bad_argument) << wrong;
    EXPECT_EQ(listen_stream(wrong).error().code, Errc::bad_argument) << wrong;
  }
  EXPECT_EQ(connect_stream("unix:" + socket_path("nobody"), 10ms).error().code, Errc::not_found);
}

TEST(TcpSocket, EachAddressOfAHostIsTried) {
  for (const char* own : {"127.0.0.1", "[::1]"}) {
    auto listener = listen_stream(std::string("tcp:") + own + ":0");
    if (!listener) continue;  // no IPv6 here
    const std::string& at = (*listener)->endpoint();
    auto stream = connect_stream("tcp:localhost" + at.substr(at.rfind(':')), 0s);
    if (own[0] == '[' && !stream && !resolves_to_ipv6("localhost")) continue;
    EXPECT_TRUE(stream) << at << ": " << to_string(stream.error().code);
  }
}

TEST(UnixSocket, PeerThatStartsLaterIsFound) {
  const std::string path = socket_path("later");
  std::unique_ptr<Listener> listener;
  auto starter = system_os().start_thread({"starter", 0, {}, 256 * 1024}, [&] {
    system_os().sleep_until(system_os().now() + 20ms);
    listener = std::move(*listen_stream(path));
  });
  EXPECT_TRUE(connect_stream(path, 20s));
  (*starter)->join();
}

TEST(Socket, ConnectingIsGivenUpWhenAsked) {
  int asked = 0;
  const auto begin = system_os().now();
  EXPECT_EQ(connect_stream_until("unix:" + socket_path("nobody"), 100s, [&] { return ++asked > 3; }).error().code,
            Errc::timeout);
  EXPECT_GE(asked, 3);
  EXPECT_LT(system_os().now() - begin, 50s);
  auto listener = listen_stream("tcp:127.0.0.1:0");
  ASSERT_TRUE(listener);
  EXPECT_TRUE(connect_stream_until((*listener)->endpoint(), 100s, [] { return false; }));
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
}  // namespace sinew::hal::socket_test
