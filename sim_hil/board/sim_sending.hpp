#pragma once
#include "sim_hil/board/sim_board.hpp"

namespace sinew::sim_hil {

/// Marks that a thread sends on the board's line, the only one; false: there is no line just now. RT: yes.
class SimBoard::Sending {
 public:
  explicit Sending(SimBoard& board) noexcept : board_(board) {
    if (board_.options_.send_lock) board_.options_.send_lock->lock();
    board_.sending_.store(true, std::memory_order_seq_cst);
    linked_ = board_.linked_.load(std::memory_order_seq_cst);
  }
  ~Sending() {
    board_.sending_.store(false, std::memory_order_release);
    if (board_.options_.send_lock) board_.options_.send_lock->unlock();
  }
  Sending(const Sending&) = delete;
  Sending& operator=(const Sending&) = delete;
  explicit operator bool() const noexcept { return linked_; }

 private:
  SimBoard& board_;
  bool linked_;
};

}  // namespace sinew::sim_hil
