#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "hal/result.hpp"

namespace sinew::tap {

/// Answers the requests record.*: the recorder of the run. It answers later, and the server asks again.
class RecordControl {
 public:
  enum class Command : std::uint8_t { start, stop, status, snapshot };
  struct Answer {
    std::optional<hal::Errc> refused{};
    std::string text{};  // a JSON object with the members of the reply, or why it is refused
  };
  virtual ~RecordControl() = default;
  /// Answers the number that answer() wants. Ask for it until it has its answer, or never again. Never waits.
  virtual std::uint64_t ask(Command command) = 0;
  virtual std::optional<Answer> answer(std::uint64_t number) = 0;
};

}  // namespace sinew::tap
