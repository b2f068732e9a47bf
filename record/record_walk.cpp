#include "record/record_walk.hpp"

namespace sinew::record {

bool RecordWalk::look(FileProblem& problem) {
  if (at_ >= window_at_ && at_ + kRecordHead <= window_at_ + window_.size()) return true;
  constexpr std::uint64_t kWindow = 16 << 10;
  window_at_ = at_;
  window_.clear();
  return read_bytes(file_, at_, std::min(kWindow, end_ - at_), {}, window_, problem);
}

RecordWalk::Next RecordWalk::next(Place& place, FileProblem& problem) {
  if (at_ >= end_) return Next::end;
  if (end_ - at_ < kRecordHead) {
    problem = {ProblemKind::truncated, at_, "the file ends inside the head of a record"};
    return Next::problem;
  }
  if (!look(problem)) return Next::problem;
  Cursor head(window_.bytes().subspan(static_cast<std::size_t>(at_ - window_at_)));
  const auto op = head.number<std::uint8_t>();
  const auto length = head.number<std::uint64_t>();
  if (op == 0) {
    problem = {ProblemKind::bad_record, at_, "a record of kind 0, which does not exist"};
    return Next::problem;
  }
  if (length > end_ - at_ - kRecordHead) {
    problem = {ProblemKind::truncated, at_,
               "a record of kind " + std::to_string(op) + " and " + std::to_string(length) + " bytes, of which " +
                   std::to_string(end_ - at_ - kRecordHead) + " are there"};
    return Next::problem;
  }
  place = {static_cast<Op>(op), at_, kRecordHead + length};
  at_ += place.length;
  return Next::record;
}

}  // namespace sinew::record
