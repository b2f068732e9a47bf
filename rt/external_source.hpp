#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/result.hpp"
#include "rt/module.hpp"

namespace sinew::rt {

/// The one writer of topics declared `writer = "external"`: its next step publishes what came in by the mailbox, each
/// message stamped with the instant of that step. Made by the graph, first in its thread.
///
/// A message waits in one of kRoom places, for all topics of the source together: any thread that posts takes a free
/// place and fills it, the mailbox hands the place's number to the executor, the step empties it.
class ExternalSource final : public Module {
 public:
  struct Topic {
    std::string port;
    const msg::TypeInfo* type;  // without bulk
  };
  static constexpr std::uint32_t kRoom = 16;

  explicit ExternalSource(const std::vector<Topic>& topics);
  ~ExternalSource() override;

  void declare(Declaration& d) override;
  StepStatus step(const Step& step) noexcept override;

  /// Copies a message of the type's size into a free place; answers its number.
  /// Thread:  any.
  /// Errors:  busy when all places are taken.
  hal::Result<std::uint32_t> stage(std::uint32_t port, std::span<const std::byte> message) noexcept;
  /// Gives back a place whose number was not posted. Thread: any.
  void unstage(std::uint32_t place) noexcept;
  /// What waits in a place: the port and the message. Thread: executor, before the step.
  std::uint32_t port_of(std::uint32_t place) const { return places_[place].port; }
  std::span<const std::byte> message_of(std::uint32_t place) const;
  /// The next step publishes it, after those taken before. Thread: executor, between steps.   RT: yes.
  void take(std::uint32_t place) noexcept;

 private:
  struct Port;
  struct Place {
    std::uint32_t port = 0;
    std::vector<std::byte> bytes;
  };
  std::vector<std::unique_ptr<Port>> ports_;  // bound by address
  std::vector<Place> places_;
  // A set bit is a free place. acquire on taking one, release on giving it back: a poster fills a place only after
  // it was emptied.
  std::atomic<std::uint32_t> free_{(1u << kRoom) - 1};
  std::vector<std::uint32_t> taken_;  // in the order of the mailbox
};

}  // namespace sinew::rt
