#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "hal/stream.hpp"
#include "sim_hil/message_io.hpp"

namespace sinew::sim_hil {

/// What to do while a plant is silent, where somebody waits for it.
struct Silence {
  /// About ten times a second: `silent` since the wait began. False: waits no longer.
  std::function<bool(Duration silent)> go_on;
  /// After that: something has come at last.
  std::function<void(Duration silent)> over = [](Duration) {};
};

/// The runtime's end of a connection to a plant, from Hello and Welcome on.
/// Thread:  receive() one, send by `out` and flush() another.
struct PlantConnection {
  std::unique_ptr<hal::Stream> stream;
  MessageReceiver in{Sender::plant};
  MessageWriter out{kMaxSmallBytes};
  Welcome welcome;
  std::unique_ptr<hal::SharedMemory> memory;  // of the frames; null: they come in the stream
  const Silence* silence = nullptr;           // asked while receive() waits; null: nobody
  Duration patience{0};                       // of receive() with `silence`; without it that of the stream

  /// From now on receive() waits for so long. Before the traffic starts.
  void wait_for(Duration longest, const Silence* asked);

  /// Says Hello and hears the Welcome. On failure tells the plant, and `why` has it in words.
  /// Errors:  closed when the plant refused; bad_data, timeout, io.
  hal::Status shake_hands(const Hello& hello, std::string& why);
  /// Waits for the next message.
  hal::Status receive(Message& message);
  /// Waits for some bytes.
  hal::Result<std::size_t> read(std::span<std::byte> into);
  hal::Status flush();

 private:
  hal::Status adopt(const Message& message, std::string& why);
};

/// The differences of a plant that came back, in words; empty: its devices are the same.
std::string difference(const Welcome& before, const Welcome& now);

}  // namespace sinew::sim_hil
