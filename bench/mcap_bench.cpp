// The time of the recorder's thread per message: record::Writer beside a chunked log that does only what it must (a
// head and a place for each message, zlib's checksum over each chunk of 1 MiB, one write). Both write files on the same
// disk; the bench measures this thread's processor time. Neither waits for the disk.
#include <fcntl.h>
#include <lz4.h>
#include <time.h>
#include <unistd.h>
#include <zlib.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "hal/linux/file.hpp"
#include "pairs.hpp"
#include "record/crc32.hpp"
#include "record/writer.hpp"

namespace sinew {
namespace {

constexpr std::size_t kChunk = 1 << 20;
constexpr std::size_t kSmall = 64, kFrame = 614400;  // 640 x 480 YUYV

double thread_us() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

struct FloorOptions {
  bool crc = true, lz4 = false;
};

class FloorLog {
 public:
  FloorLog(const std::string& path, FloorOptions options)
      : fd_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600)), options_(options) {
    if (fd_ < 0) std::perror(path.c_str()), std::exit(2);
    bytes_.reserve(kChunk + kFrame + 64);
    packed_.resize(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(kChunk + kFrame + 64))));
  }
  ~FloorLog() { ::close(fd_); }
  FloorLog(const FloorLog&) = delete;
  FloorLog& operator=(const FloorLog&) = delete;
  void write(std::uint16_t channel, std::uint64_t time, const std::uint8_t* data, std::size_t size) {
    std::uint8_t head[31] = {5};
    const std::uint64_t length = 22 + size;
    std::memcpy(head + 1, &length, 8), std::memcpy(head + 9, &channel, 2);
    std::memcpy(head + 15, &time, 8), std::memcpy(head + 23, &time, 8);
    places_.emplace_back(time, bytes_.size());
    bytes_.insert(bytes_.end(), head, head + 31);
    bytes_.insert(bytes_.end(), data, data + size);
    if (bytes_.size() >= kChunk) close_chunk();
  }
  void close_chunk() {
    const auto sum =
        options_.crc ? static_cast<std::uint32_t>(::crc32(0, bytes_.data(), static_cast<unsigned>(bytes_.size()))) : 0u;
    const std::uint8_t* data = bytes_.data();
    std::size_t size = bytes_.size();
    if (options_.lz4) {
      size = static_cast<std::size_t>(LZ4_compress_default(reinterpret_cast<const char*>(data),
                                                           reinterpret_cast<char*>(packed_.data()),
                                                           static_cast<int>(size), static_cast<int>(packed_.size())));
      data = packed_.data();
    }
    std::uint8_t head[64] = {6};
    std::memcpy(head + 1, &size, 8), std::memcpy(head + 9, &sum, 4);
    if (::write(fd_, head, 64) < 0 || ::write(fd_, data, size) < 0 ||
        ::write(fd_, places_.data(), places_.size() * 16) < 0)
      std::perror("write"), std::exit(2);
    bytes_.clear(), places_.clear();
  }

 private:
  int fd_;
  FloorOptions options_;
  std::vector<std::uint8_t> bytes_, packed_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> places_;
};

/// A real file that does not wait for its disk: only our work is measured.
class Unsynced final : public hal::OutputFile {
 public:
  explicit Unsynced(const std::string& path) {
    ::unlink(path.c_str());
    auto file = hal::create_file(path);
    if (!file) std::fprintf(stderr, "%s: %s\n", path.c_str(), file.error().where), std::exit(2);
    file_ = std::move(*file);
  }
  hal::Status append(hal::Parts parts) noexcept override { return file_->append(parts); }
  hal::Status sync() noexcept override { return {}; }
  hal::Status cut(std::uint64_t size) noexcept override { return file_->cut(size); }
  hal::Result<std::uint64_t> free_bytes() noexcept override { return file_->free_bytes(); }

 private:
  std::unique_ptr<hal::OutputFile> file_;
};

std::vector<std::vector<std::uint8_t>> frames() {
  std::vector<std::vector<std::uint8_t>> list(4, std::vector<std::uint8_t>(kFrame));
  std::uint32_t random = 1;
  for (auto& frame : list)
    for (std::size_t i = 0; i < frame.size(); ++i) {
      random = random * 1664525u + 1013904223u;
      frame[i] = static_cast<std::uint8_t>(128 + (i / 1280) % 64 + (random >> 30));  // a slope with noise of two bits
    }
  return list;
}

struct Case {
  const char* name;
  std::size_t size, count;
  record::Compression compression;
  FloorOptions floor;
  double goal;
};

bool measure(const Case& c, int pairs) {
  static const auto data = frames();
  const std::string path =
      (std::filesystem::temp_directory_path() / ("sinew-mcap-bench-" + std::to_string(::getpid()))).string();
  const auto ours = [&] {
    auto opened = record::Writer::open(std::make_unique<Unsynced>(path), {.compression = c.compression});
    if (!opened) std::exit(2);
    record::Writer& writer = **opened;
    for (int i = 0; i < 8; ++i)
      if (!writer.add_channel("/topic" + std::to_string(i), "cdr", 0, {},
                              c.size == kFrame ? record::Packing::plain : record::Packing::packed))
        std::exit(2);
    const double start = thread_us();
    for (std::size_t i = 0; i < c.count; ++i)
      if (!writer.write(static_cast<std::uint16_t>(1 + i % 8), {static_cast<std::uint32_t>(i), i, i},
                        std::as_bytes(std::span(data[i % 4].data(), c.size))))
        std::exit(2);
    if (!writer.flush()) std::exit(2);
    return (thread_us() - start) / static_cast<double>(c.count);
  };
  const auto floor = [&] {
    FloorLog log(path, c.floor);
    const double start = thread_us();
    for (std::size_t i = 0; i < c.count; ++i)
      log.write(static_cast<std::uint16_t>(1 + i % 8), i, data[i % 4].data(), c.size);
    log.close_chunk();
    return (thread_us() - start) / static_cast<double>(c.count);
  };
  ours(), floor();  // warm-up
  bench::Pairs all;
  for (int i = 0; i < pairs; ++i) {
    std::vector<double> x, y;
    if (i % 2 == 0)
      x = {ours()}, y = {floor()};
    else
      y = {floor()}, x = {ours()};
    all.add(std::move(x), std::move(y));
  }
  ::unlink(path.c_str());
  const bool small = c.size == kSmall;
  return bench::report(c.name, all.ratio().times(small ? 1000 : 1), c.goal, small ? "ns" : "us");
}

int run(int pairs) {
  using record::Compression;
  bool good = true;
  good &= measure({"64 B, with checksum", kSmall, 400'000, Compression::none, {.crc = true}, 1.3}, pairs);
  good &= measure({"64 B, bare chunks", kSmall, 400'000, Compression::none, {.crc = false}, 0}, pairs);
  good &= measure({"64 B, lz4", kSmall, 200'000, Compression::lz4, {.crc = true, .lz4 = true}, 1.3}, pairs);
  good &= measure({"614400 B, with checksum", kFrame, 150, Compression::lz4, {.crc = true}, 1.1}, pairs);
  good &= measure({"614400 B, bare chunks", kFrame, 150, Compression::lz4, {.crc = false}, 1.1}, pairs);
  const std::vector<std::uint8_t> frame(kFrame, 7);
  const auto ours = [&] { bench::keep(record::crc32(std::as_bytes(std::span(frame)))); };
  const auto zlib = [&] { bench::keep(::crc32(0, frame.data(), static_cast<unsigned>(frame.size()))); };
  good &= bench::report("614400 B, checksum alone", bench::alternate(pairs, 100, ours, zlib), 1.0);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) { return sinew::run(argc > 1 ? std::atoi(argv[1]) : 15); }
