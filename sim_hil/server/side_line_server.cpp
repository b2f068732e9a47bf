#include "sim_hil/server/side_line_server.hpp"

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;
using hal::Status;

Status answer(const Message& message, const SideLineService& service, MessageWriter& out) {
  const std::int64_t received_ns = service.host.now().ns;
  switch (message.header.type) {
    case Type::clock_ask: {
      ClockAsk ask;
      if (auto ok = decode(message.header, message.payload, ask); !ok) return ok;
      static_cast<void>(
          out.add(Type::clock_answer, 0, Time{}, ClockAnswer{ask.asked_ns, received_ns, service.host.now().ns}));
      return {};
    }
    case Type::stop:
      service.stopped.store(true, std::memory_order_release);  // before the answer, which says that we obey
      static_cast<void>(out.add(Type::stopped, 0, Time{}));
      return {};
    case Type::bye:
      return Error{Errc::closed, "the other side has hung up"};
    default:
      return Error{Errc::bad_data, "message does not belong on a side line", std::int64_t(message.header.type)};
  }
}

}  // namespace

void serve_side_line(Caller& caller, const SideLineService& service) {
  MessageWriter out(kMaxSmallBytes);
  Welcome welcome;
  welcome.step = service.plant.step, welcome.seed = service.plant.seed.value_or(caller.hello.seed);
  welcome.plant = service.plant.name, welcome.devices = service.plant.devices;
  static_cast<void>(out.add(Type::welcome, 0, Time{}, welcome));  // an empty buffer holds any Welcome
  for (;;) {
    if (!caller.stream->write(out.pending())) return;
    out.clear();
    Message message;
    auto next = caller.in.next(message);
    if (next && !*next) {
      auto n = caller.stream->read(caller.in.space());
      if (!n) return;
      caller.in.filled(*n);
      continue;
    }
    std::string offence;
    if (!next)
      offence = describe_failure(next.error(), "side line ended");
    else if (auto ok = answer(message, service, out); !ok)
      offence = describe_failure(ok.error(), "side line ended");
    if (offence.empty()) continue;
    static_cast<void>(out.add_text(Type::bye, Time{}, offence));
    static_cast<void>(caller.stream->write(out.pending()));  // nobody may be there any more
    return;
  }
}

}  // namespace sinew::sim_hil
