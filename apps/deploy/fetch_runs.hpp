#pragma once
// Recorded files fetched from a board: which ones, and where their bytes go. A file grows as NAME.part. It gets its
// name when it is complete and has the same checksum as on the board.
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// CRC of the POSIX utility `cksum`. Source: POSIX.1-2017, cksum.
class PosixCksum {
 public:
  void add(std::string_view bytes);
  /// Checksum of all bytes added.
  std::uint32_t value() const;

 private:
  std::uint32_t crc_ = 0;
  std::uint64_t length_ = 0;
};

struct BoardFile {
  std::string name;  // "runs/quad-20260101-120000/run.mcap"
  std::uint64_t size = 0;
  std::int64_t changed_s = 0;
};

struct BoardListing {
  std::int64_t now_s = 0;  // by the board's clock
  std::vector<BoardFile> files;
  std::vector<std::string> problems;  // lines that name no file below the folder
};
/// What apps/deploy/list.sh printed.
BoardListing parse_listing(std::string_view now, std::string_view lines);

/// The part of a file that is still missing here.
struct FetchPart {
  std::string name;
  std::uint64_t offset = 0, size = 0;  // of the whole file
};

struct FetchPlan {
  std::vector<FetchPart> parts;
  std::uint64_t bytes = 0;             // to come
  std::size_t here = 0;                // files that are here already
  std::vector<std::string> recording;  // folders of runs that are being written: left for the next time
  std::vector<std::string> different;  // files that are here with another size: left alone
};
/// Compares the listing with the folder `into`. A run is being written when one of its files changed within the last 5
/// s.
FetchPlan plan_fetch(const BoardListing& listing, const std::string& into);

/// The input of apps/deploy/get.sh.
std::string request_text(const FetchPlan& plan);

/// Takes the output of apps/deploy/get.sh.
class FetchSink {
 public:
  FetchSink(const FetchPlan& plan, std::string into);
  void take(std::string_view bytes);
  /// Why it ended early; empty: everything came.
  std::string failure() const;
  std::size_t files_done() const { return done_; }
  std::uint64_t bytes_done() const { return bytes_; }

 private:
  void begin_part();
  void take_content(std::string_view& bytes);
  void take_line(std::string_view& bytes);
  void end_part();
  std::string path() const;

  const FetchPlan& plan_;
  std::string into_, line_, failure_;
  std::ofstream out_;
  PosixCksum sum_;
  std::uint64_t left_ = 0, bytes_ = 0;
  std::size_t index_ = 0, done_ = 0;
  bool synced_ = false, begun_ = false;  // past the words of the login; within a file
};

}  // namespace sinew::app
