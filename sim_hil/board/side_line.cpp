#include "sim_hil/board/side_line.hpp"

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;
using hal::Result;
using hal::Status;

}  // namespace

SideLine::SideLine(std::unique_ptr<hal::Stream> stream) : stream_(std::move(stream)) {}

SideLine::~SideLine() {
  static_cast<void>(out_.add_text(Type::bye, Time{}, "side line is no longer needed"));
  static_cast<void>(stream_->write_now(out_.pending()));  // nobody may be there any more
}

Result<std::unique_ptr<SideLine>> SideLine::open(std::unique_ptr<hal::Stream> stream, std::string_view name,
                                                 hal::Duration patience, std::string& why) {
  stream->set_patience(patience);
  why.clear();
  std::unique_ptr<SideLine> line(new SideLine(std::move(stream)));
  if (auto ok = line->shake_hands(name, why); !ok) {
    if (why.empty()) why = describe_failure(ok.error(), "no side line to the plant");
    return ok.error();
  }
  return line;
}

Status SideLine::shake_hands(std::string_view name, std::string& why) {
  Hello hello;
  hello.mode = Mode::side_line;
  hello.robot = name;
  static_cast<void>(out_.add(Type::hello, 0, Time{}, hello));  // the first message always fits
  if (auto ok = flush(); !ok) return ok;
  Message message;
  if (auto ok = receive(Type::welcome, message); !ok) {
    if (message.header.type == Type::bye) why = "plant refused: " + decode_text(message.payload);
    return ok;
  }
  Welcome welcome;
  if (auto ok = decode(message.header, message.payload, welcome); !ok) return ok;
  plant_ = welcome.plant;
  return {};
}

Status SideLine::stop() noexcept {
  out_.clear();
  static_cast<void>(out_.add(Type::stop, kAllGroups, Time{}));
  if (auto ok = flush(); !ok) return ok;
  Message message;
  return receive(Type::stopped, message);
}

Result<SideLine::Exchange> SideLine::compare_clocks(const hal::Clock& host) noexcept {
  Exchange e;
  e.asked = host.now();
  static_cast<void>(out_.add(Type::clock_ask, 0, Time{}, ClockAsk{e.asked.ns}));
  if (auto ok = flush(); !ok) return ok.error();
  Message message;
  ClockAnswer answer;
  do {  // late answers to earlier questions may come first
    if (auto ok = receive(Type::clock_answer, message); !ok) return ok.error();
    e.arrived = host.now();
    if (auto ok = decode(message.header, message.payload, answer); !ok) return ok.error();
  } while (answer.asked_ns != e.asked.ns);
  e.received = Time{answer.received_ns};
  e.answered = Time{answer.answered_ns};
  return e;
}

Status SideLine::flush() noexcept {
  auto sent = stream_->write(out_.pending());
  out_.clear();
  return sent;
}

/// The next message of this type; skips late answers to earlier questions.
Status SideLine::receive(Type expected, Message& out) noexcept {
  for (;;) {
    auto next = in_.next(out);
    if (!next) return next.error();
    if (!*next) {
      auto n = stream_->read(in_.space());
      if (!n) return n.error();
      in_.filled(*n);
      continue;
    }
    const Type type = out.header.type;
    if (type == expected) return {};
    if (type == Type::bye) return Error{Errc::closed, "the plant has hung up"};
    if (type != Type::clock_answer && type != Type::stopped)
      return Error{Errc::bad_data, "message does not belong on a side line", std::int64_t(type)};
  }
}

}  // namespace sinew::sim_hil
