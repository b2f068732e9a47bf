#pragma once
// Runs one module alone: for tests of modules, ours and those of library users.
//
//   GimbalLevel gimbal;
//   rt::ModuleRig rig(gimbal);
//   rig.set("kp", 2.0);
//   rig.put("imu", sample);
//   EXPECT_EQ(rig.step(now, 5ms), rt::Status::ok);
//   const msg::JointCommand* tilt = rig.get<msg::JointCommand>("tilt");
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/board.hpp"
#include "msg/bulk.hpp"
#include "rt/commit.hpp"
#include "rt/latch.hpp"
#include "rt/module.hpp"

namespace sinew::rt {

struct RigOptions {
  std::string name = "module";  // for Step::random and Setup::module_name()
  std::uint64_t seed = 1;
  std::uint32_t image_bytes = 640 * 480 * 3;  // capacity of every image, in and out
  std::uint32_t first_sequence = 0xFFFFFF00;  // shortly before the wrap
};

/// Topics, latch and commit around the module are the real ones; a step follows the step contract to the letter. An
/// input that was never put is empty. Using a name that the module does not declare, or another type, is a bug of the
/// test and aborts with its name.
/// Thread:  owner.
/// Owner:   the module outlives the rig. A message from get() stays until the next step().
class ModuleRig {
 public:
  explicit ModuleRig(Module& module, RigOptions options = {});
  ~ModuleRig();

  /// Sets a parameter; aborts when its range refuses the value (ask accepts() first to test that).
  void set(std::string_view param, const ParamValue& value);
  bool accepts(std::string_view param, const ParamValue& value) const;

  /// Calls the module's configure() with this board, or with one that has no devices.
  hal::Status configure(hal::Board& board);
  hal::Status configure();
  const std::vector<std::string>& explanations() const { return explanations_; }  // Setup::explain()
  void reset();

  /// Publishes a message on an input; the next step sees it. `published` is the commit instant, by default its stamp.
  template <msg::Described M>
  void put(std::string_view input, const M& message) {
    put(input, message, message.stamp);
  }
  template <msg::Described M>
  void put(std::string_view input, const M& message, Time published) {
    put_erased(input, msg::type_info<M>(), &message, published);
  }
  /// The same, filled in place: a message with its capacity set, published by the next put(), loan() or step().
  template <msg::Described M>
  M& loan(std::string_view input) {
    return *static_cast<M*>(loan_erased(input, msg::type_info<M>()));
  }

  /// collect(), latch, step(), commit or discard, emit(). `dt` must be more than 0.
  Status step(Time now, Duration dt, bool timed_out = false);

  /// The newest message of the last step on an output or raw port; null when it published none there.
  template <msg::Described M>
  const M* get(std::string_view output) const {
    const auto all = sent_erased(output, msg::type_info<M>());
    return all.empty() ? nullptr : static_cast<const M*>(all.back()->message());
  }
  /// All of them, oldest first.
  template <msg::Described M>
  std::vector<const M*> sent(std::string_view output) const {
    std::vector<const M*> messages;
    for (const SlotHeader* slot : sent_erased(output, msg::type_info<M>()))
      messages.push_back(static_cast<const M*>(slot->message()));
    return messages;
  }
  const Declaration& declaration() const { return declaration_; }
  std::uint32_t best_effort_calls() const { return best_effort_calls_; }

 private:
  struct Feed;  // the writer in front of one input
  void build();
  std::uint32_t port_index(std::string_view name, bool input, const msg::TypeInfo& type) const;
  void put_erased(std::string_view input, const msg::TypeInfo& type, const void* message, Time published);
  void* loan_erased(std::string_view input, const msg::TypeInfo& type);
  std::span<const SlotHeader* const> sent_erased(std::string_view output, const msg::TypeInfo& type) const;

  Module& module_;
  DriverModule* driver_;
  RigOptions options_;
  Declaration declaration_;
  std::vector<std::string> explanations_;
  std::unique_ptr<Segment> segment_;
  std::unique_ptr<Latch> latch_;
  std::unique_ptr<Commit> outputs_;
  std::vector<std::unique_ptr<Commit>> raws_;                    // per port; null: no raw port
  std::vector<std::unique_ptr<Feed>> feeds_;                     // per port; null: no input
  std::vector<std::pair<Commit*, std::uint32_t>> sent_through_;  // per port: commit and output
  Time now_;  // of the last step
  std::uint32_t number_ = 0, best_effort_calls_ = 0;
};

}  // namespace sinew::rt
