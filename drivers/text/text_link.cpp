#include "drivers/text/text_link.hpp"

#include <algorithm>
#include <cmath>

#include "hal/platform.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kReadPatience = 5ms, kConnectPatience = 100ms, kWaitAtMost = 20ms, kHelloPeriod = 1s;
constexpr hal::Duration kFirstTextPause = 100ms, kLongTextPause = 2s, kTornFor = 1s, kValuesBy = 3s;
constexpr int kStops = 5, kReadsAtOnce = 16, kDatagramsAtOnce = 64;

/// "silent, but connected" and the like may not change while they last: no numbers in them.
std::string endpoint_of(const TextSocket& socket) {
  return socket.tcp ? socket.endpoint : "udp:" + hal::to_text(socket.peer);
}

}  // namespace

// ---- groups

hal::Status TextGroup::write(const msg::ActuatorCommand& command, hal::Duration lease) noexcept {
  if (command.count != channels_) return hal::Error{hal::Errc::bad_argument, "number of channels", command.count};
  last_.value = command.value;
  last_.count = command.count;
  last_.stopped = false;
  last_.until = os_.now() + lease;
  setpoints_.put(last_);
  if (!up_.load(std::memory_order_relaxed)) return hal::Error{hal::Errc::closed, "text link"};
  return {};
}

hal::Status TextGroup::stop() noexcept {
  if (!last_.stopped) {
    last_.stopped = true;
    last_.until = {};
    setpoints_.put(last_);
  }
  if (!up_.load(std::memory_order_relaxed)) return hal::Error{hal::Errc::closed, "text link"};
  return {};
}

hal::Status TextGroup::fall_back(hal::FallBack how) noexcept {
  if (how == hal::FallBack::limp) return stop();
  last_.until = {};
  setpoints_.put(last_);
  return {};
}

// ---- from outside

hal::Result<std::shared_ptr<TextLink>> TextLink::open(const TextLinkSpec& spec, DeviceContext& context,
                                                      std::string& why) {
  std::shared_ptr<TextLink> link(new TextLink(spec, context.os));
  link->drives_ = std::make_shared<TextGroup>(context.os, spec.drives.size(), link->up_);
  link->values_.count = static_cast<std::uint32_t>(spec.values.size());
  const auto open_radio = [&](const TextSocket& socket, std::unique_ptr<hal::Radio>& out) -> hal::Status {
    hal::RadioSpec radio;
    radio.peers = {socket.peer};
    radio.port = socket.port;
    auto opened = context.connectors.radio(radio, why);
    if (!opened) return opened.error();
    out = std::move(*opened);
    return {};
  };
  if (!spec.main.tcp)
    if (const hal::Status opened = open_radio(spec.main, link->radio_); !opened) return opened.error();
  if (spec.state)
    if (const hal::Status opened = open_radio(*spec.state, link->state_radio_); !opened) return opened.error();
  if (link->radio_) link->radio_->set_wake(link.get());
  if (link->state_radio_) link->state_radio_->set_wake(link.get());
  link->pause_ = kFirstTextPause;
  hal::ThreadOptions thread;
  thread.name = spec.name;
  thread.fifo_priority = spec.fifo_priority;
  auto started = context.os.start_thread(thread, [l = link.get()] { l->run(); });
  if (!started) {
    why = "its thread cannot be started";
    return started.error();
  }
  link->thread_ = std::move(*started);
  return link;
}

TextLink::~TextLink() {
  stop_.store(true, std::memory_order_relaxed);
  wake();
  thread_.reset();
  if (radio_) radio_->set_wake(nullptr);
  if (state_radio_) state_radio_->set_wake(nullptr);
}

void TextLink::wake() noexcept {
  word_.fetch_add(1, std::memory_order_release);
  os_.wake(word_);
}

void TextLink::add(std::shared_ptr<TextSink> sink) {
  const std::lock_guard lock(mutex_);
  sink->set_link(up_.load(std::memory_order_relaxed));
  sinks_.push_back(std::move(sink));
}

std::shared_ptr<TextGroup> TextLink::add_commands(const std::vector<std::size_t>& commands) {
  std::size_t channels = 0;
  for (const std::size_t c : commands) channels += spec_.commands[c].channels();
  auto group = std::make_shared<TextGroup>(os_, channels, up_);
  const std::lock_guard lock(mutex_);
  std::size_t channel = 0;
  for (const std::size_t c : commands) {
    command_states_[c].group = group;
    command_states_[c].channel = channel;
    channel += spec_.commands[c].channels();
  }
  return group;
}

std::string TextLink::trouble() const { return trouble_.get(); }

// ---- the thread

void TextLink::run() noexcept {
  now_ = os_.now();
  connected_ = !spec_.main.tcp;
  if (connected_) made_ = now_, values_.connections = 1;
  next_send_ = next_alive_ = next_hello_ = next_connect_ = now_;
  while (!stop_.load(std::memory_order_relaxed)) {
    const std::uint32_t seen = word_.load(std::memory_order_acquire);
    if (spec_.main.tcp && !stream_ && now_ >= next_connect_) connect();
    if (stream_) poll_stream();
    now_ = os_.now();
    if (radio_) poll_radio(*radio_, spec_.main, !spec_.state);
    if (state_radio_) poll_radio(*state_radio_, *spec_.state, true);
    if (connected_) send_due();
    look();
    if (!stream_) os_.wait(word_, seen, std::min(connected_ ? next_send_ : next_connect_, now_ + kWaitAtMost));
    now_ = os_.now();
  }
  // The last word: what is under way stays valid in the robot otherwise.
  if (!connected_ || !live_) return;
  if (spec_.stop || spec_.safe) {
    send(spec_.stop ? *spec_.stop : *spec_.safe);
  } else {
    stops_left_ = 0;
    send_drives();
  }
  for (int i = 0; i < 20 && pending_size_ > 0 && stream_; ++i) flush(), os_.sleep_until(os_.now() + kReadPatience);
}

void TextLink::connect() {
  auto made = hal::connect_stream(spec_.main.endpoint, kConnectPatience);
  now_ = os_.now();
  if (!made) {
    last_error_ = std::string("no connection: ") + hal::to_string(made.error().code);
    next_connect_ = now_ + pause_;
    pause_ = std::min<hal::Duration>(2 * pause_, kLongTextPause);
    return;
  }
  stream_ = std::move(*made);
  stream_->set_patience(kReadPatience);
  connected_ = true;
  made_ = heard_ = now_;
  ever_heard_ = false;
  pending_size_ = 0;
  splitter_.lines.reset();
  ++values_.connections;
  last_error_.clear();
  greet();
  for (CommandState& state : command_states_) state.known = false;
}

void TextLink::lose(const char* why) {
  if (!stream_) return;
  stream_->shutdown();
  stream_.reset();
  connected_ = ever_heard_ = false;
  pending_size_ = 0;
  if (splitter_.lines.reset()) torn();
  last_error_ = why;
  next_connect_ = now_ + pause_;
  pause_ = std::min<hal::Duration>(2 * pause_, kLongTextPause);
}

void TextLink::poll_stream() {
  std::array<std::byte, 4096> bytes;
  for (int reads = 0; reads < kReadsAtOnce && stream_; ++reads) {
    const auto got = reads == 0 ? stream_->read(bytes) : stream_->read_now(bytes);
    now_ = os_.now();
    if (!got && got.error().code == hal::Errc::timeout) return;
    if (!got) return lose("the connection was lost");
    if (*got == 0) return;
    take_text(spec_.main.decoder, splitter_, {reinterpret_cast<const std::uint8_t*>(bytes.data()), *got});
  }
}

void TextLink::poll_radio(hal::Radio& radio, const TextSocket& socket, bool is_state) {
  msg::Datagram datagram;
  for (int n = 0; n < kDatagramsAtOnce; ++n) {
    const auto got = radio.read(datagram);
    if (!got || !*got) return;
    if (datagram.sender != socket.peer.ipv4) continue;  // not the robot's
    const std::uint32_t before = values_.lines;
    if (socket.decoder == TextDecoder::navdata) {
      take_navdata(datagram.bytes());
    } else {
      Splitter& splitter = &socket == &spec_.main ? splitter_ : state_splitter_;
      take_text(socket.decoder, splitter, datagram.bytes());
      take_text(socket.decoder, splitter, std::array<std::uint8_t, 1>{'\n'});  // a datagram ends its line
    }
    if (values_.lines != before && is_state) state_heard_ = now_;
  }
}

void TextLink::take_text(TextDecoder decoder, Splitter& splitter, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes)
    if (splitter.lines.push(static_cast<char>(byte))) take_line(decoder, splitter.lines.line());
  for (; splitter.dropped < splitter.lines.dropped(); ++splitter.dropped) torn();
}

void TextLink::take_line(TextDecoder decoder, std::string_view line) {
  const auto form = decoder == TextDecoder::fields  ? wire::TextForm::fields
                    : decoder == TextDecoder::words ? wire::TextForm::words
                                                    : wire::TextForm::usarsim;
  const wire::UsarError error = wire::parse_text(form, line, line_);
  if (error == wire::UsarError::empty) return;
  if (error != wire::UsarError::none) return torn();
  ++values_.lines;
  const std::string_view reply = line_.type == "reply" ? line_.find("text").value : line_.type;
  for (std::size_t c = 0; c < spec_.commands.size(); ++c) {
    const auto& answers = spec_.commands[c].answers;
    if (std::find(answers.begin(), answers.end(), reply) != answers.end()) command_states_[c].answered = true;
  }
  std::uint32_t fresh = 0;
  for (std::size_t i = 0; i < spec_.values.size(); ++i) {
    const auto value = find_value(spec_.values[i], line_, spec_.decimal_comma);
    if (!value) continue;
    values_.value[i] = *value;
    values_.measured[i] = now_;
    fresh |= 1u << i;
  }
  hear(fresh);
}

void TextLink::take_navdata(std::span<const std::uint8_t> bytes) {
  if (wire::decode_navdata(bytes, navdata_) != wire::NavdataError::none) return torn();
  const std::uint32_t behind = navdata_sequence_ - navdata_.sequence;
  if (behind < 100) return;  // again, or late
  navdata_sequence_ = navdata_.sequence;
  if (!navdata_.has_demo) return;  // it waits for its configuration: the greeting
  ++values_.lines;
  std::uint32_t fresh = 0;
  for (std::size_t i = 0; i < spec_.values.size(); ++i) {
    const TextValue& wanted = spec_.values[i];
    const auto number = wire::navdata_value(navdata_, wanted.message, wanted.key, wanted.index);
    if (!number) continue;
    values_.value[i] = *number * wanted.scale + wanted.offset;
    values_.measured[i] = now_;
    fresh |= 1u << i;
  }
  hear(fresh);
}

void TextLink::torn() {
  ++values_.torn;
  torn_at_ = now_;
}

void TextLink::hear(std::uint32_t fresh) {
  heard_ = now_;
  ever_heard_ = true;
  pause_ = kFirstTextPause;
  if (fresh == 0) return;
  values_.stamp = now_;
  values_.fresh = fresh;
  values_.known |= fresh;
  set_up(true);
  const std::lock_guard lock(mutex_);
  for (const auto& sink : sinks_) sink->offer(values_);
}

void TextLink::set_up(bool up) {
  if (up_.load(std::memory_order_relaxed) == up) return;
  up_.store(up, std::memory_order_relaxed);
  const std::lock_guard lock(mutex_);
  for (const auto& sink : sinks_) sink->set_link(up);
}

void TextLink::look() {
  const hal::Time last = spec_.state ? state_heard_ : heard_;
  const bool heard = connected_ && last.ns != 0 && (ever_heard_ || spec_.state) && now_ - last < spec_.silent;
  set_up(spec_.values.empty() ? connected_ : heard);
  if (stream_ && !spec_.values.empty() && now_ - heard_ >= spec_.reconnect) lose("it was silent for too long");
  const std::string at = endpoint_of(spec_.main);
  std::string text;
  if (!connected_)
    text = at + ": " + (last_error_.empty() ? "not connected yet" : last_error_);
  else if (torn_at_.ns != 0 && now_ - torn_at_ < kTornFor)
    text = at + (heard ? ": some lines come in torn" : ": what comes in is no message of its form");
  else if (!spec_.values.empty() && !heard && now_ - made_ >= spec_.silent)
    text = (spec_.state ? endpoint_of(*spec_.state) : at) + ": nothing comes in (is it there, is the address right?)";
  else if (heard && now_ - made_ >= kValuesBy)
    for (std::size_t i = 0; i < spec_.values.size(); ++i)
      if (values_.measured[i].ns == 0)
        text += (text.empty() ? "these values never came: " : ", ") + spec_.values[i].name;
  if (text != trouble_.get()) trouble_.set(text);
}

// ---- to the robot

void TextLink::greet() {
  greeted_ = now_;
  for (const wire::TextTemplate& line : spec_.greeting) send(line);
}

void TextLink::send_due() {
  const hal::Time last = spec_.state ? state_heard_ : heard_;
  const bool silent = last.ns == 0 || now_ - last >= kHelloPeriod;
  if (!spec_.main.tcp && silent && (greeted_.ns == 0 || now_ - greeted_ >= kHelloPeriod)) greet();
  if (state_radio_ && !spec_.state_hello.empty() && silent && now_ >= next_hello_) {
    next_hello_ = now_ + kHelloPeriod;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(spec_.state_hello.data());
    static_cast<void>(state_radio_->send({bytes, spec_.state_hello.size()}));  // again in a second
  }
  if (spec_.keep_alive && now_ >= next_alive_) {
    next_alive_ = now_ + spec_.keep_alive_period;
    send(*spec_.keep_alive);
  }
  if (now_ >= next_send_) {
    next_send_ = std::max(next_send_ + spec_.period, now_);
    if (!spec_.drives.empty()) send_drives();
    send_commands();
  }
  flush();
}

void TextLink::send_drives() {
  TextSetpoints::Content wanted;
  if (!drives_->setpoints().take(wanted)) return;
  const bool ending = stop_.load(std::memory_order_relaxed);
  const bool valid = !ending && !wanted.stopped && now_ < wanted.until;
  if (valid) {
    live_ = true;
    stops_left_ = kStops;
  } else if (!live_) {
    return;  // never steered: nothing to end
  } else if (wanted.stopped && !ending) {
    if (stops_left_ == 0) return;
    if (--stops_left_ == 0) live_ = false;
    if (spec_.stop) {
      send(*spec_.stop);
      return;
    }
  }
  if (!valid && spec_.safe) {
    send(*spec_.safe);
    return;
  }
  std::array<double, msg::kMaxChannels> numbers{};
  bool moves = false;
  for (std::size_t i = 0; i < spec_.drives.size(); ++i) {
    const TextDrive& drive = spec_.drives[i];
    const double setpoint = valid ? wanted.value[i] : drive.rest;
    numbers[i] = drive.range.fitted(setpoint * drive.scale + drive.offset);
    moves = moves || numbers[i] != 0;
  }
  if (spec_.drive_lines.size() == 1) {
    send(spec_.drive_lines.front(), std::span(numbers).first(spec_.drives.size()));
    return;
  }
  // A line for each: one that moves nothing would end what another began.
  for (std::size_t i = 0; i < spec_.drive_lines.size(); ++i)
    if (numbers[i] != 0 || (!moves && i == 0)) send(spec_.drive_lines[i], std::span(numbers).subspan(i, 1));
}

void TextLink::send_commands() {
  const std::lock_guard lock(mutex_);
  for (std::size_t c = 0; c < spec_.commands.size(); ++c)
    if (command_states_[c].group) send_command(spec_.commands[c], command_states_[c]);
}

bool TextLink::send_command(const TextCommand& command, CommandState& state) {
  TextSetpoints::Content wanted;
  if (!state.group->setpoints().take(wanted) || wanted.stopped || now_ >= wanted.until) return true;
  const std::size_t values = command.text.values();
  std::array<double, msg::kMaxChannels> numbers{};
  for (std::size_t i = 0; i < command.channels(); ++i)
    numbers[i] = command.range.fitted(wanted.value[state.channel + i]);
  const bool first = !state.known;
  const bool changed = numbers != state.sent;
  state.known = true;
  const bool repeats =
      command.repeat > hal::Duration{0} && now_ >= state.next && !(state.answered && !command.answers.empty());
  // What is 0 from the beginning was never asked for; after a new connection all else is said again.
  const bool again = first && state.sent != std::array<double, msg::kMaxChannels>{};
  const bool pending =
      command.repeat > hal::Duration{0} && (command.answers.empty() || again || changed || state.next.ns != 0);
  if (!changed && !again && !(repeats && pending)) return true;
  if (changed || again) state.answered = false;
  if (values == 0 && !(changed ? numbers[0] != 0 : state.sent[0] != 0)) {
    state.sent = numbers;  // back to 0: ready to be sent anew
    return true;
  }
  if (!send(command.text, std::span(numbers).first(values))) return false;  // tried again in the next period
  state.sent = numbers;
  state.next = now_ + command.repeat;
  return true;
}

bool TextLink::send(const wire::TextTemplate& text, std::span<const double> values) {
  std::array<char, wire::TextTemplate::kLongest + 200> line;
  const std::size_t size = text.write(values, sequence_, line);
  if (size == 0 || size + spec_.line_end.size() > line.size()) {
    ++values_.unsent;
    return false;
  }
  std::copy(spec_.line_end.begin(), spec_.line_end.end(), line.begin() + static_cast<std::ptrdiff_t>(size));
  const bool sent = send_bytes({line.data(), size + spec_.line_end.size()});
  ++(sent ? values_.sent : values_.unsent);
  return sent;
}

bool TextLink::send_bytes(std::string_view bytes) {
  if (radio_) return radio_->send({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}).has_value();
  if (!stream_ || bytes.size() > pending_.size() - pending_size_) return false;
  std::copy(bytes.begin(), bytes.end(), pending_.begin() + static_cast<std::ptrdiff_t>(pending_size_));
  pending_size_ += bytes.size();
  return true;
}

void TextLink::flush() {
  if (!stream_ || pending_size_ == 0) return;
  const auto written = stream_->write_now(std::as_bytes(std::span(pending_).first(pending_size_)));
  if (!written) return lose("the connection was lost");
  std::copy(pending_.begin() + static_cast<std::ptrdiff_t>(*written),
            pending_.begin() + static_cast<std::ptrdiff_t>(pending_size_), pending_.begin());
  pending_size_ -= *written;
}

}  // namespace sinew::drivers
