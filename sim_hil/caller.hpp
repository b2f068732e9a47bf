#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "hal/stream.hpp"
#include "sim_hil/message_io.hpp"

namespace sinew::sim_hil {

/// Somebody who has connected to a plant and said what for.
struct Caller {
  std::unique_ptr<hal::Stream> stream;
  MessageReceiver in{Sender::runtime};  // with what has come behind the Hello
  Hello hello;
};

/// Waits for the Hello on `caller.stream`, as long as its patience allows. On failure the peer is told, and `why` says
/// it in words. Errors:  closed, timeout, io; bad_data for what is no Hello of this version.
hal::Status hear_hello(Caller& caller, std::string_view plant, std::string& why);

/// Says Bye on a line on which the plant has sent nothing else yet. Nobody may be there to hear it.
void turn_away(hal::Stream& stream, std::string_view reason);

}  // namespace sinew::sim_hil
