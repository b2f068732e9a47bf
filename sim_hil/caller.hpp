#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "hal/stream.hpp"
#include "sim_hil/message_io.hpp"

namespace sinew::sim_hil {

/// A peer that has connected to a plant and said Hello.
struct Caller {
  std::unique_ptr<hal::Stream> stream;
  MessageReceiver in{Sender::runtime};  // with the bytes that came behind the Hello
  Hello hello;
};

/// Waits for the Hello on `caller.stream`, as long as its patience allows. On failure tells the peer, and `why` has it
/// in words.
/// Errors:  closed, timeout, io; bad_data for a first message that is no Hello of this version.
hal::Status hear_hello(Caller& caller, std::string_view plant, std::string& why);

/// Says Bye on a line on which the plant has sent nothing else yet. The peer may be gone already.
void turn_away(hal::Stream& stream, std::string_view reason);

}  // namespace sinew::sim_hil
