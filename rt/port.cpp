#include "rt/port.hpp"

#include "rt/commit.hpp"

namespace sinew::rt {

void* OutputBase::loan_erased() {
  void* message = commit_->try_loan(index_);
  if (!message) bug("more loans in one step than the declared burst", "output");
  return message;
}

void OutputBase::cancel_erased() {
  if (!commit_->cancel(index_)) bug("cancel() without a loan", "output");
}

void* OutputBase::try_loan_erased() { return commit_->try_loan(index_); }

const void* OutputBase::committed_erased() const {
  const auto slots = commit_->committed(index_);
  return slots.empty() ? nullptr : slots.back()->message();
}

}  // namespace sinew::rt
