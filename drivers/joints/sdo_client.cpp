#include "drivers/joints/sdo_client.hpp"

namespace sinew::drivers {

using wire::Sdo;

void SdoClient::start(const Sdo& request) noexcept {
  request_ = request;
  value_ = abort_code_ = 0;
  length_ = 0;
  repeated_ = false;
  state_ = State::busy;
  ask(request);
}

void SdoClient::ask(const Sdo& frame) noexcept {
  frame_ = frame;
  to_send_ = true;
  tries_ = 0;
}

void SdoClient::tick(Time now, FrameSink& out) noexcept {
  if (state_ != State::busy) return;
  if (!to_send_ && now - sent_ < kPatience) return;
  if (tries_ == kTries) {
    finish(State::timeout);
    return;
  }
  out.send(encode_sdo_request(node_, frame_));
  to_send_ = false;
  sent_ = now;
  if (tries_ > 0) repeated_ = true;
  ++tries_;
}

Heard SdoClient::on_reply(const msg::CanFrame& frame) noexcept {
  const auto reply = wire::decode_sdo_reply(frame);
  if (!reply) return Heard::malformed;
  if (state_ != State::busy || tries_ == 0) {
    if (state_ == State::done && !repeated_ && reply->object == request_.object) twice_ = true;
    return Heard::foreign;
  }
  if (reply->kind == Sdo::Kind::segment) return on_segment(*reply);
  if (reply->object != request_.object) return Heard::foreign;  // the answer to an earlier question
  switch (reply->kind) {
    case Sdo::Kind::value:
      if (request_.kind != Sdo::Kind::read) return Heard::foreign;
      value_ = reply->value();
      for (length_ = 0; length_ < reply->size; ++length_) text_[length_] = static_cast<char>(reply->data[length_]);
      finish(State::done);
      return Heard::mine;
    case Sdo::Kind::begin_segments: {
      if (request_.kind != Sdo::Kind::read || frame_.kind != Sdo::Kind::read) return Heard::foreign;
      Sdo next;
      next.kind = Sdo::Kind::read_segment;
      ask(next);
      return Heard::mine;
    }
    case Sdo::Kind::written:
      if (request_.kind != Sdo::Kind::write) return Heard::foreign;
      finish(State::done);
      return Heard::mine;
    default:
      abort_code_ = reply->abort_code;
      finish(State::aborted);
      return Heard::mine;
  }
}

std::int32_t SdoClient::signed_value() const noexcept {
  if (length_ == 1) return static_cast<std::int8_t>(value_);
  if (length_ == 2) return static_cast<std::int16_t>(value_);
  return static_cast<std::int32_t>(value_);
}

Heard SdoClient::on_segment(const Sdo& reply) noexcept {
  if (frame_.kind != Sdo::Kind::read_segment || reply.toggle != frame_.toggle) return Heard::foreign;
  for (std::size_t i = 0; i < reply.size && length_ < text_.size(); ++i) {
    text_[length_++] = static_cast<char>(reply.data[i]);
  }
  if (reply.last) {
    finish(State::done);
    return Heard::mine;
  }
  Sdo next = frame_;
  next.toggle = !frame_.toggle;
  ask(next);
  return Heard::mine;
}

}  // namespace sinew::drivers
