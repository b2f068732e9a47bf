#pragma once
#include "record/chunk_contents.hpp"

namespace sinew::record {

/// Steps from record to record of a file, looking at their heads only.
class RecordWalk {
 public:
  struct Place {
    Op op{};
    std::uint64_t offset = 0, length = 0;  // of the whole record
  };
  /// From `at` up to `end`, which is at most the file's size.
  RecordWalk(hal::InputFile& file, std::uint64_t at, std::uint64_t end) : file_(file), at_(at), end_(end) {}
  std::uint64_t at() const { return at_; }
  enum class Next { record, end, problem };
  /// After a problem the walk stays where it is.
  Next next(Place& place, FileProblem& problem);

 private:
  bool look(FileProblem& problem);
  hal::InputFile& file_;
  std::uint64_t at_, end_;
  Buffer window_;
  std::uint64_t window_at_ = 0;
};

}  // namespace sinew::record
