#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "hal/clock.hpp"
#include "hal/stop_line.hpp"
#include "hal/stream.hpp"
#include "sim_hil/message_io.hpp"

namespace sinew::sim_hil {

/// A second, independent connection to a plant, beside the runtime's. Its owner can stop all actuators until the end of
/// the run, even when the runtime is dead or hangs, and can compare clocks undisturbed by samples and pixels.
///     auto line = SideLine::open(std::move(*hal::connect_stream("unix:/run/plant.sock", 5s)), "parent", 1s, why);
///     ...
///     (*line)->stop();
/// Thread:  owner.   RT: allocates nothing after open(); waits for each answer, at most `patience`.
class SideLine final : public hal::StopLine {
 public:
  /// Errors:  closed when the plant takes no side line (`why` has its words), timeout, bad_data, io.
  static hal::Result<std::unique_ptr<SideLine>> open(std::unique_ptr<hal::Stream> stream, std::string_view name,
                                                     hal::Duration patience, std::string& why);
  ~SideLine() override;

  const std::string& plant() const { return plant_; }
  hal::Status stop() noexcept override;

  /// The four time stamps of one exchange, each on the host clock of the side that took it: ours, theirs, theirs, ours.
  struct Exchange {
    Time asked, received, answered, arrived;
  };
  hal::Result<Exchange> compare_clocks(const hal::Clock& host) noexcept;
  /// Ends the wait of another thread in one of these calls; every later call says closed.
  void hang_up() noexcept { stream_->shutdown(); }

 private:
  explicit SideLine(std::unique_ptr<hal::Stream> stream);
  hal::Status shake_hands(std::string_view name, std::string& why);
  hal::Status flush() noexcept;
  hal::Status receive(Type expected, Message& out) noexcept;

  std::unique_ptr<hal::Stream> stream_;
  MessageReceiver in_{Sender::plant};
  MessageWriter out_{kMaxSmallBytes};
  std::string plant_;
};

}  // namespace sinew::sim_hil
