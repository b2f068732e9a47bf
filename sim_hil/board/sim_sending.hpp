#pragma once
#include "sim_hil/board/sim_board.hpp"

namespace sinew::sim_hil {

/// Marks that a thread sends on the board's line; false: there is no line just now. RT: yes.
class SimBoard::Sending {
 public:
  explicit Sending(SimBoard& board) noexcept : board_(board) {
    board_.sending_.store(true, std::memory_order_seq_cst);
    linked_ = board_.linked_.load(std::memory_order_seq_cst);
  }
  ~Sending() { board_.sending_.store(false, std::memory_order_release); }
  Sending(const Sending&) = delete;
  Sending& operator=(const Sending&) = delete;
  explicit operator bool() const noexcept { return linked_; }

 private:
  SimBoard& board_;
  bool linked_;
};

}  // namespace sinew::sim_hil
