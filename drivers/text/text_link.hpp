#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/driver.hpp"
#include "drivers/seq_lock.hpp"
#include "drivers/text/text_spec.hpp"
#include "hal/sensor_queue.hpp"
#include "hal/stream.hpp"
#include "wire/text/navdata.hpp"

namespace sinew::drivers {

/// A device made of values of a link: what came in, and whether the link is there. Thread: the link's.
class TextSink {
 public:
  virtual ~TextSink() = default;
  virtual void offer(const msg::TextValues& values) noexcept = 0;
  virtual void set_link(bool up) noexcept = 0;
};

/// The setpoints of one group as the guardian wrote them last. Thread: put(): the guardian's; take(): the link's.
class TextSetpoints {
 public:
  struct Content {
    std::array<double, msg::kMaxChannels> value{};
    std::uint32_t count = 0;
    bool stopped = true;
    hal::Time until;  // they are valid
  };
  void put(const Content& content) noexcept { content_.store(content); }
  bool take(Content& out) const noexcept { return content_.load(out); }

 private:
  SeqLock<Content> content_;
};

/// A group of channels of a link: its drives, or some of its commands.
/// RT:      yes: a store in memory; the link's thread sends.
/// Errors:  closed while the link is not there; bad_argument for a wrong number of channels.
class TextGroup final : public hal::Actuators {
 public:
  TextGroup(hal::Os& os, std::size_t channels, const std::atomic<bool>& up) : os_(os), channels_(channels), up_(up) {}
  hal::Status write(const msg::ActuatorCommand& command, hal::Duration lease) noexcept override;
  hal::Status stop() noexcept override;
  hal::Status fall_back(hal::FallBack how) noexcept override;
  const TextSetpoints& setpoints() const { return setpoints_; }

 private:
  hal::Os& os_;
  const std::size_t channels_;
  const std::atomic<bool>& up_;
  TextSetpoints::Content last_;  // the guardian's own
  TextSetpoints setpoints_;
};

/// The connection to one robot that speaks text: a thread connects, greets, reads, keeps alive and sends. Nobody else
/// touches a socket. Whole lines become values; what is torn, too long or no text is counted and dropped.
///
/// Up is a link on which a whole message came within `silent_ms` (without any [[message]]: as soon as it is made). When
/// it is not up, its devices are gone and its groups refuse setpoints. TCP is made anew after a loss and after
/// `reconnect_ms` of silence.
///
/// Thread:  its own; the groups and sensors as they say.
class TextLink final : public hal::SelfReport, private hal::Wake {
 public:
  /// Opens sockets and starts. The peer need not be there.
  /// Errors:  those of UDP ports and of the thread; `why` has the words.
  static hal::Result<std::shared_ptr<TextLink>> open(const TextLinkSpec& spec, DeviceContext& context,
                                                     std::string& why);
  ~TextLink() override;

  const TextLinkSpec& spec() const { return spec_; }
  TextGroup& drives() { return *drives_; }
  /// Before or during the run: what comes in from now on.
  void add(std::shared_ptr<TextSink> sink);
  /// A group of these commands, by their numbers in the spec. They must not be in another group.
  std::shared_ptr<TextGroup> add_commands(const std::vector<std::size_t>& commands);

  std::string trouble() const override;
  std::string shortfall() const override { return thread_ ? thread_->shortfall() : std::string(); }

 private:
  struct CommandState {
    std::shared_ptr<TextGroup> group;
    std::size_t channel = 0;  // of the group
    std::array<double, msg::kMaxChannels> sent{};
    bool known = false;  // `sent` is what went out last
    bool answered = false;
    hal::Time next;  // repeated then
  };
  TextLink(const TextLinkSpec& spec, hal::Os& os) : spec_(spec), os_(os) {}
  void wake() noexcept override;  // a datagram came

  void run() noexcept;
  void connect();
  void lose(const char* why);
  void poll_stream();
  void poll_radio(hal::Radio& radio, const TextSocket& socket, bool is_state);
  struct Splitter {
    wire::UsarLines lines;
    std::uint64_t dropped = 0;  // counted as torn
  };
  void take_text(TextDecoder decoder, Splitter& splitter, std::span<const std::uint8_t> bytes);
  void take_line(TextDecoder decoder, std::string_view line);
  void take_navdata(std::span<const std::uint8_t> bytes);
  void torn();
  void hear(std::uint32_t fresh);
  void look();
  void set_up(bool up);

  void greet();
  void send_due();
  void send_drives();
  void send_commands();
  bool send_command(const TextCommand& command, CommandState& state);
  /// False: there was no room, or it could not be written.
  bool send(const wire::TextTemplate& text, std::span<const double> values = {});
  bool send_bytes(std::string_view bytes);
  void flush();

  const TextLinkSpec spec_;
  hal::Os& os_;
  std::shared_ptr<TextGroup> drives_;
  std::unique_ptr<hal::Radio> radio_, state_radio_;
  hal::WakeWord word_{0};
  std::atomic<bool> stop_{false}, up_{false};  // relaxed: each says only what it says

  // The thread's own.
  std::unique_ptr<hal::Stream> stream_;
  std::array<char, 8192> pending_{};  // TCP took only a part
  std::size_t pending_size_ = 0;
  Splitter splitter_, state_splitter_;
  wire::UsarLine line_;
  wire::Navdata navdata_;
  std::uint32_t navdata_sequence_ = 0;
  msg::TextValues values_;
  std::uint32_t sequence_ = 1;
  hal::Time now_, heard_, greeted_, made_, next_send_, next_alive_, next_hello_, next_connect_, torn_at_;
  hal::Time state_heard_;
  bool connected_ = false, ever_heard_ = false, live_ = false;
  int stops_left_ = 0;
  hal::Duration pause_{};
  std::array<CommandState, 32> command_states_{};
  std::string last_error_;

  mutable std::mutex mutex_;  // sinks_, and groups of command_states_: the thread and whoever opens devices
  std::vector<std::shared_ptr<TextSink>> sinks_;
  hal::TroubleText trouble_;
  std::unique_ptr<hal::Thread> thread_;  // last: ends before what it uses
};

}  // namespace sinew::drivers
