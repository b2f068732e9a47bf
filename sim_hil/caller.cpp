#include "sim_hil/caller.hpp"

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;
using hal::Status;

Status first_message(hal::Stream& stream, MessageReceiver& in, Message& out) {
  for (;;) {
    auto next = in.next(out);
    if (!next) return next.error();
    if (*next) return {};
    auto n = stream.read(in.space());
    if (!n) return n.error();
    in.filled(*n);
  }
}

}  // namespace

void turn_away(hal::Stream& stream, std::string_view reason) {
  MessageWriter out(kMaxSmallBytes);
  static_cast<void>(out.add_text(Type::bye, Time{}, reason));  // an empty buffer holds any text
  static_cast<void>(stream.write(out.pending()));
}

Status hear_hello(Caller& caller, std::string_view plant, std::string& why) {
  Message message;
  Status ok = first_message(*caller.stream, caller.in, message);
  if (!ok) {
    why = describe_failure(ok.error(), "no Hello from the runtime");
  } else if (message.header.type != Type::hello) {
    ok = Error{Errc::bad_data, "sim link: no Hello"};
    why = "the first message must be Hello";
  } else if (ok = decode(message.header, message.payload, caller.hello); !ok) {
    why = describe_failure(ok.error(), "Hello is refused");
    if (caller.hello.version != kVersion)
      why = "runtime speaks version " + std::to_string(caller.hello.version) + " of the simulator protocol, plant '" +
            std::string(plant) + "' speaks version " + std::to_string(kVersion);
  }
  if (!ok) turn_away(*caller.stream, why);
  return ok;
}

}  // namespace sinew::sim_hil
