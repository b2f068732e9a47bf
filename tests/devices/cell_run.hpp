#pragma once
// Plays one cell of the matrix and measures its outcome.
#include <gtest/gtest.h>

#include "robot.hpp"

namespace sinew::test {

/// Texts in the order of their appearance. Texts that differ in numbers only are one text, with N for these numbers.
class TextLog {
 public:
  void add(const std::string& text);
  const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::vector<std::string> texts_;
};

/// One fault on one device: healthy and armed, then the fault for five seconds, then healed; or with the fault from the
/// start. Asserts what must hold in every cell; the Cell has the outcome.
class CellRun final : private Script {
 public:
  CellRun(const RigKind& kind, Fault fault, std::size_t way) : kind_(kind), fault_(fault), way_(way) {}
  Cell play();

 private:
  enum class Stage { warm, healthy, faulty, healed, settled, armed_again, disarmed, done, failed };
  bool at(Time now) override;
  void go(Stage stage, Time now) { stage_ = stage, since_ = now; }
  void begin_fault(Time now);
  void during_fault(Time now);
  void end_fault(Time now);
  void look_for_recovery(Time now);
  bool works() const;
  bool every(Duration period) const { return steps_ % (period / Robot::kStep) == 0; }
  void add_reason(const std::string& text);
  void cannot_start(std::vector<std::string> read);
  void check_opening_texts();
  void check_fault();
  std::string what_guardian_did() const;
  std::string recovery_text() const;
  std::string other_joint() const;

  const RigKind& kind_;
  const Fault fault_;
  const std::size_t way_;
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<Robot> robot_;
  Stage stage_ = Stage::warm;
  Time since_{}, injected_{}, acted_at_{}, healed_{};
  std::uint32_t acted_ = 0;
  TextLog read_, refused_;
  std::string how_;
  std::int64_t steps_ = 0;
  Seen in_fault_;  // from 1 s after it struck
  double farthest_other_ = 0;
  bool other_stopped_ = false, own_stopped_ = false, until_enabled_ = false;
  Duration back_{};
};

}  // namespace sinew::test
