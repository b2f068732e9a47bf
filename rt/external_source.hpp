#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "hal/result.hpp"
#include "rt/module.hpp"

namespace sinew::rt {

/// A message from outside the robot: the bytes of its struct and, directly behind them, its pixels.
struct OutsideMessage {
  std::span<const std::byte> bytes{};         // of this process, or
  const hal::SharedMemory* memory = nullptr;  // `size` bytes at `offset` of memory that others may change at any moment
  std::size_t offset = 0, size = 0;
  Time stamp{};  // when it was measured; 0: the instant of the step that publishes it

  std::size_t length() const { return memory ? size : bytes.size(); }
  /// Reads each byte once. False: the memory does not reach that far.
  bool copy(std::size_t from, std::span<std::byte> into) const noexcept;
};

/// The one writer of topics declared `writer = "external"`: its next step publishes what came in by the mailbox. Made
/// by the graph, first in its thread.
///
/// A message waits in a place: any thread that posts takes a free place and fills it, the mailbox hands the place's
/// number to the executor, the step empties it. Messages without pixels share kRoom places and are copied in the step.
/// A topic with pixels has kImageRoom places that are slots of the topic itself, held over the steps (Raw<>::hold()
/// explains it): the poster writes the pixels where readers will find them, and the step only publishes the slot.
class ExternalSource final : public Module {
 public:
  struct Topic {
    std::string port;
    const msg::TypeInfo* type;
    std::uint32_t image_pixels = 0;  // an image has at most so many; types with pixels only
  };
  static constexpr std::uint32_t kRoom = 16, kImageRoom = 2;

  explicit ExternalSource(const std::vector<Topic>& topics);
  ~ExternalSource() override;

  void declare(Declaration& d) override;
  hal::Status configure(Setup& setup) override;
  StepStatus step(const Step& step) noexcept override;

  /// The executor's ports are bound: takes the slots that wait outside. Until then a topic with pixels is busy.
  void bound() noexcept;

  /// Copies a message into a free place, checks the copy, and answers the place's number.
  /// Thread:  any.   RT: yes, as far as the copy is.
  /// Errors:  busy when all places are taken; bad_argument, with the reason in `where` and a number in `detail`: a
  /// wrong
  ///          size (detail: the size), a number that is not finite, an image whose header does not fit its bytes or its
  ///          topic; bad_data: the memory is shorter than the message says.
  hal::Result<std::uint32_t> stage(std::uint32_t port, const OutsideMessage& message) noexcept;
  /// Gives back a place whose number was not posted. Thread: any.
  void unstage(std::uint32_t place) noexcept;
  /// Places of this port: kRoom or kImageRoom.
  std::uint32_t room(std::uint32_t port) const;
  /// What waits in a place: the port, and the message with its used pixels. Thread: executor, before the step.
  std::uint32_t port_of(std::uint32_t place) const { return places_[place].port; }
  std::span<const std::byte> message_of(std::uint32_t place) const;
  /// The next step publishes it, after those taken before. Thread: executor, between steps.   RT: yes.
  void take(std::uint32_t place) noexcept;

 private:
  struct Port;
  struct Place {
    std::uint32_t port = 0;
    std::byte* message = nullptr;
  };
  /// Some of places_. A set bit is a free place: acquire on taking one, release on giving it back, so a poster fills a
  /// place only after the step has emptied it.
  struct Pool {
    std::atomic<std::uint32_t> free{0};
    std::uint32_t first = 0;
  };
  Pool& pool_of(std::uint32_t port) noexcept;
  hal::Status fill(Port& port, Place& place, const OutsideMessage& message) const noexcept;

  std::vector<std::unique_ptr<Port>> ports_;  // bound by address
  std::vector<Place> places_;
  std::vector<std::max_align_t> plain_;  // of the first kRoom places
  Pool shared_;                          // of the ports without pixels
  std::vector<std::uint32_t> taken_;     // in the order of the mailbox
};

}  // namespace sinew::rt
