#pragma once
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "msg/describe.hpp"
#include "rt/module.hpp"
#include "rt/port.hpp"

namespace sinew::record {

/// A module whose outputs repeat the messages of a recording: in its order, with the old stamps, each in the first step
/// at or after the instant at which it is due. An ordinary thread reads the file and hands over the messages some time
/// before.
class Player final : public rt::Module {
 public:
  struct Topic {
    std::string port;
    const msg::TypeInfo* type;
    std::uint32_t bulk_bytes = 0;  // of images: room for the pixels
  };
  explicit Player(std::vector<Topic> topics);
  ~Player() override;

  void declare(rt::Declaration& d) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

  enum class Handed : std::uint8_t { yes, no_room, too_large };
  /// Copies a message; an image with its pixels.   Thread: one, any.
  Handed hand(std::uint32_t topic, rt::Time due, const void* message) noexcept;
  /// True when every message handed over has been published.   Thread: any.
  bool idle() const noexcept;
  const std::vector<Topic>& topics() const { return topics_; }

 private:
  struct Port;
  struct Place {
    rt::Time due;
    std::uint32_t topic = 0;
    std::vector<std::byte> bytes;
  };
  std::vector<Topic> topics_;
  std::vector<std::unique_ptr<Port>> ports_;        // bound by address
  std::vector<Place> places_;                       // a ring
  std::atomic<std::uint32_t> handed_{0}, said_{0};  // release/acquire: hand a place over, and back
};

}  // namespace sinew::record
