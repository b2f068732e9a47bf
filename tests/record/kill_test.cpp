// A process that is killed while it records: it leaves the beginning of the file that it would have made. Everything up
// to the last whole chunk is read, and recover() makes a whole file of it.
#include <sched.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>

#include "hal/linux/file.hpp"
#include "record/recover.hpp"
#include "samples.hpp"

namespace sinew::record::kill_test {
namespace {

using testing::IsEmpty;

constexpr int kRuns = kSanitized ? 15 : 100;
constexpr std::uint64_t kMessages = 1500;

/// The same file at each call. `told` hears of every message.
template <class Told>
hal::Status record_all(std::unique_ptr<hal::OutputFile> file, const Told& told) {
  auto opened = Writer::open(std::move(file), {.chunk_bytes = 4096});
  if (!opened) return opened.error();
  Writer& out = **opened;
  const std::uint16_t imu = *out.add_channel("/imu", "cdr", 0);
  const std::uint16_t image = *out.add_channel("/image", "cdr", 0, {}, Packing::plain);
  for (std::uint32_t i = 0; i < kMessages; ++i) {
    const bool large = i % 100 == 37;
    const std::string data = some_data(i, large ? 70'000 : 60 + i % 90);
    if (auto done = out.write(large ? image : imu, {i, i, i}, as_bytes(data)); !done) return done;
    if (i == kMessages / 2)
      if (auto done = out.attach({i, i, "robot.toml", "application/toml", some_data(1, 3000)}); !done) return done;
    told(i + 1);
  }
  return out.finish();
}

/// A real file, but for the wait for its disk, which a killed process does not need.
class RealFile : public hal::OutputFile {
 public:
  explicit RealFile(hal::OutputFile& file) : file_(file) {}
  hal::Status append(hal::Parts parts) noexcept override { return file_.append(parts); }
  hal::Status sync() noexcept override { return {}; }
  hal::Status cut(std::uint64_t size) noexcept override { return file_.cut(size); }
  hal::Result<std::uint64_t> free_bytes() noexcept override { return file_.free_bytes(); }

 private:
  hal::OutputFile& file_;
};

/// Kills its process when so many bytes are written, inside of a piece, too.
class DeadlyFile final : public RealFile {
 public:
  DeadlyFile(hal::OutputFile& file, std::uint64_t bytes_to_live) : RealFile(file), left_(bytes_to_live) {}
  hal::Status append(hal::Parts parts) noexcept override {
    for (const auto& part : parts) {
      const auto written = part.first(static_cast<std::size_t>(std::min<std::uint64_t>(part.size(), left_)));
      if (auto done = RealFile::append({&written, 1}); !done) return done;
      if (written.size() < part.size()) ::raise(SIGKILL);
      left_ -= written.size();
    }
    return {};
  }

 private:
  std::uint64_t left_;
};

class Kill : public testing::Test {
 protected:
  Kill() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew-kill-XXXXXX").string();
    EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    auto file = hal::create_file(folder_ + "/run.mcap");
    EXPECT_TRUE(file);
    if (file) file_ = std::move(*file);
    EXPECT_TRUE(record_all(std::make_unique<MemoryOutput>(whole_), [](std::uint64_t) {}));
    auto reader = open(whole_.bytes);
    samples_ = all(*reader, {.topics = {}, .order = Order::file}).samples;
    Decompressor decompressor;
    for (const ChunkIndex& chunk : reader->chunks()) {
      MemoryInput input(whole_.bytes);
      ChunkContents contents;
      FileProblem why;
      EXPECT_TRUE(contents.load(input, {.offset = chunk.offset, .length = chunk.length, .channels = {}}, {},
                                decompressor, why));
      chunks_.emplace_back(chunk.offset + chunk.length, contents.entries().size());
    }
  }
  ~Kill() override { std::filesystem::remove_all(folder_); }

  std::string path() const { return folder_ + "/run.mcap"; }
  std::size_t samples_in(std::uint64_t size) const {
    std::size_t count = 0;
    for (const auto& [end, messages] : chunks_) count += end <= size ? messages : 0;
    return count;
  }

  /// A process that records; `body` is its whole life. The file at the end of `wait` is the file that it left.
  template <class Body, class Wait>
  static int end_of_process(const Body& body, const Wait& wait) {
    const pid_t child = ::fork();
    if (child == 0) {
      ::alarm(60);  // should we die first
      ::_exit(body() ? 0 : 1);
    }
    EXPECT_GT(child, 0);
    if (child < 0) return -1;
    wait(child);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return status;
  }

  void expect_all_up_to_the_last_whole_chunk() {
    const auto size = static_cast<std::size_t>(std::filesystem::file_size(path()));
    ASSERT_LE(size, whole_.bytes.size());
    Bytes bytes(size);
    auto file = hal::open_file(path());
    ASSERT_TRUE(file && (*file)->read_at(0, bytes));
    ASSERT_TRUE(std::equal(bytes.begin(), bytes.end(), whole_.bytes.begin()));
    FileProblem why;
    auto reader = Reader::open(std::move(*file), why);
    ASSERT_EQ(reader != nullptr, size >= kMagic.size());
    if (!reader) return;
    ASSERT_EQ(reader->by_summary(), size == whole_.bytes.size());
    const std::vector<Sample> wanted(samples_.begin(),
                                     samples_.begin() + static_cast<std::ptrdiff_t>(samples_in(size)));
    ASSERT_TRUE(all(*reader, {.topics = {}, .order = Order::file}).samples == wanted) << size;
    expect_recovered(wanted);
  }

  void expect_recovered(const std::vector<Sample>& wanted) {
    auto from = hal::open_file(path());
    Disk to;
    Recovered result;
    ASSERT_TRUE(from && recover(std::move(*from), std::make_unique<MemoryOutput>(to), result));
    ASSERT_THAT(check_bytes(to.bytes), IsEmpty());
    auto reader = open(to.bytes);
    ASSERT_TRUE(reader->by_summary());
    ASSERT_TRUE(by_time(all(*reader, {}).samples) == by_time(wanted));
  }

  std::string folder_;
  std::unique_ptr<hal::OutputFile> file_;  // the same one for every process
  Disk whole_;
  std::vector<Sample> samples_;                                // in the order of the file
  std::vector<std::pair<std::uint64_t, std::size_t>> chunks_;  // where it ends, how many messages are in it
};

TEST_F(Kill, AfterAnyNumberOfBytes) {
  ASSERT_GT(chunks_.size(), 40u);
  std::mt19937 random(4);
  for (int run = 0; run < kRuns; ++run) {
    ASSERT_TRUE(file_->cut(0));
    const std::uint64_t bytes = random() % whole_.bytes.size();
    const int status = end_of_process(
        [&] { return bool(record_all(std::make_unique<DeadlyFile>(*file_, bytes), [](std::uint64_t) {})); },
        [](pid_t) {});
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
    ASSERT_EQ(std::filesystem::file_size(path()), bytes);
    ASSERT_NO_FATAL_FAILURE(expect_all_up_to_the_last_whole_chunk());
  }
}

TEST_F(Kill, FromOutsideAtAnyMoment) {
  void* shared = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  auto& written = *new (shared) std::atomic<std::uint32_t>(0);  // the child's messages; a hint only, so relaxed
  std::mt19937 random(5);
  int killed = 0, inside = 0;
  for (int run = 0; run < kRuns; ++run) {
    ASSERT_TRUE(file_->cut(0));
    const std::uint64_t moment = random() % (kMessages + 1);
    written.store(0, std::memory_order_relaxed);
    const int status = end_of_process(
        [&] {
          return bool(record_all(std::make_unique<RealFile>(*file_), [&](std::uint64_t n) {
            written.store(static_cast<std::uint32_t>(n), std::memory_order_relaxed);
          }));
        },
        [&](pid_t child) {
          siginfo_t ended{};
          while (written.load(std::memory_order_relaxed) < moment && ended.si_pid == 0) {
            ::sched_yield();
            ::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
          }
          ::kill(child, SIGKILL);
        });
    ASSERT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0) << status;
    killed += WIFSIGNALED(status) ? 1 : 0;
    inside += samples_in(std::filesystem::file_size(path())) < samples_.size() ? 1 : 0;
    ASSERT_NO_FATAL_FAILURE(expect_all_up_to_the_last_whole_chunk());
  }
  ::munmap(shared, 4096);
  RecordProperty("killed", killed);
  RecordProperty("with_a_part_of_the_messages", inside);
}

}  // namespace
}  // namespace sinew::record::kill_test
