#pragma once
// Files of known contents, and a reader's view of a file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "memory_file.hpp"
#include "record/check.hpp"
#include "record/reader.hpp"
#include "record/writer.hpp"

namespace sinew::record {

// Sanitizers only go through a part of the cases: they are ten times slower.
#ifdef SINEW_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

struct Sample {
  std::string topic;
  Stamps stamps;
  std::string data;
  friend bool operator==(const Sample&, const Sample&) = default;
};
inline void PrintTo(const Sample& s, std::ostream* to) {
  *to << s.topic << " #" << s.stamps.sequence << " at " << s.stamps.log_time << ", " << s.data.size() << " bytes";
}

/// Text that compresses a little, of any length.
inline std::string some_data(std::uint32_t seed, std::size_t size) {
  std::mt19937 random(seed);
  std::string data(size, '\0');
  for (char& c : data) c = static_cast<char>('a' + random() % 12);
  return data;
}

/// Collects what it writes, so that a test can compare a file with it.
class SampleWriter {
 public:
  SampleWriter(Disk& disk, const WriterOptions& options) {
    auto opened = Writer::open(std::make_unique<MemoryOutput>(disk), options);
    if (opened) writer_ = std::move(*opened);
    EXPECT_TRUE(writer_);
  }
  Writer& writer() { return *writer_; }
  std::vector<Sample>& samples() { return samples_; }
  void add_channel(const std::string& topic, Packing packing = Packing::packed) {
    const auto schema = writer_->add_schema("test/msg/" + topic.substr(1), "ros2msg", "float64 " + topic.substr(1));
    topics_.emplace_back(topic, *writer_->add_channel(topic, "cdr", *schema, {{"note", topic}}, packing));
  }
  std::uint16_t id(const std::string& topic) const {
    for (const auto& [name, id] : topics_)
      if (name == topic) return id;
    return 0;
  }
  hal::Status write(const std::string& topic, std::uint64_t log_time, std::size_t size) {
    const auto n = static_cast<std::uint32_t>(samples_.size());
    Sample s{
        topic, {.sequence = 0xFFFFFFFE + n, .log_time = log_time, .publish_time = log_time - 3}, some_data(n, size)};
    auto done = writer_->write(id(topic), s.stamps, as_bytes(s.data));
    if (done) samples_.push_back(std::move(s));
    return done;
  }

 private:
  std::unique_ptr<Writer> writer_;
  std::vector<std::pair<std::string, std::uint16_t>> topics_;
  std::vector<Sample> samples_;
};

inline const auto kCompressions = testing::Values(Compression::none, Compression::lz4, Compression::zstd);
inline std::string compression_name(const testing::TestParamInfo<Compression>& info) {
  return info.param == Compression::none ? "none" : to_string(info.param);
}

struct Contents {
  std::vector<Sample> samples;
  std::vector<FileProblem> problems;  // from next()
};
inline Contents all(Reader& reader, const Query& query) {
  Contents contents;
  MessageReader messages = reader.messages(query);
  Message m;
  for (;;) switch (messages.next(m)) {
      case Next::end:
        return contents;
      case Next::problem:
        contents.problems.push_back(messages.problem());
        break;
      case Next::message:
        contents.samples.push_back({m.channel->topic, m.stamps, std::string(as_text(m.data))});
    }
}
inline std::unique_ptr<Reader> open(std::span<const std::byte> bytes, const ReadLimits& limits = {}) {
  FileProblem why;
  auto reader = Reader::open(std::make_unique<MemoryInput>(bytes), why, limits);
  EXPECT_TRUE(reader) << to_string(why);
  return reader;
}
inline std::vector<FileProblem> check_bytes(std::span<const std::byte> bytes) {
  MemoryInput input(bytes);
  return check(input);
}
inline void PrintTo(const FileProblem& p, std::ostream* to) { *to << to_string(p); }

inline std::vector<Sample> by_time(std::vector<Sample> samples) {
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.stamps.log_time < b.stamps.log_time; });
  return samples;
}

}  // namespace sinew::record
