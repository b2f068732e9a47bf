#pragma once
// What a robot file says about a robot or simulator that takes text commands and answers text (docs/text-robots.md).
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/device_keys.hpp"
#include "hal/connectors.hpp"
#include "msg/text_values.hpp"
#include "wire/text/text_fields.hpp"
#include "wire/text/text_template.hpp"

namespace sinew::drivers {

/// What comes in is read as one of these.
enum class TextDecoder : std::uint8_t { usarsim, fields, words, navdata };

/// The limits of one number in a text.
struct TextRange {
  double min = -1e9, max = 1e9;
  double increment = 0;  // it is a multiple of this; 0: any
  /// Pulls in, and rounds to a multiple of the increment.
  double fitted(double value) const noexcept;
};

/// One channel of the drives: "{Left %1.2f}".
struct TextDrive {
  std::string name, text;
  TextRange range;
  double scale = 1, offset = 0;  // what stands in the text is setpoint * scale + offset
  double rest = 0;               // setpoint without a valid one
};

/// A text that is sent when its number changes; each of its conversions is a channel, none: one that sends it when it
/// becomes 1.
struct TextCommand {
  std::string name;
  wire::TextTemplate text;
  TextRange range;
  hal::Duration repeat{};              // and again so often; 0: not
  std::vector<std::string> answers{};  // until one of these is the reply
  std::size_t channels() const { return text.values() > 0 ? text.values() : 1; }
};

/// One number of what comes in.
struct TextValue {
  std::string name, message, key;
  std::size_t index = 0;
  std::vector<std::pair<std::string, std::string>> where{};  // keys and values that the line must have
  enum class As : std::uint8_t { number, degrees_minutes } as = As::number;
  std::vector<std::string> words{};  // its number is that of the word
  double scale = 1, offset = 0;      // value = number * scale + offset
};

struct TextSocket {
  bool tcp = false;
  std::string endpoint;  // TCP: "tcp:HOST:PORT"
  hal::UdpAddress peer;  // UDP
  std::uint16_t port = 0;
  TextDecoder decoder = TextDecoder::usarsim;
};

struct TextLinkSpec {
  std::string name;
  TextSocket main;
  std::optional<TextSocket> state;  // a second socket for what comes in
  std::string state_hello;          // sent there each second while nothing comes
  std::string line_end = "\r\n";
  std::vector<wire::TextTemplate> greeting;
  std::vector<TextDrive> drives;
  std::vector<wire::TextTemplate> drive_lines;  // all drives in one, or one for each
  std::optional<wire::TextTemplate> safe, stop, keep_alive;
  std::vector<TextCommand> commands;
  std::vector<TextValue> values;
  hal::Duration period = std::chrono::milliseconds(50), keep_alive_period = std::chrono::seconds(1);
  hal::Duration silent = std::chrono::seconds(1), reconnect = std::chrono::seconds(5);
  bool decimal_comma = false;
  int fifo_priority = 0;
};

/// Reads [device.NAME] with driver "text" and its tables; problems become those of `keys`.
TextLinkSpec read_text_link(DeviceKeys& keys);

/// The keys of [[device.NAME.drive]], [[.command]] and [[.message]], for the table of keys.
void read_text_drive(DeviceKeys& keys, TextDrive& out);
std::optional<TextCommand> read_text_command(DeviceKeys& keys);
void read_text_value(DeviceKeys& keys, TextDecoder decoder, TextValue& out);

/// "land, takeoff" cut at its commas, without blanks around.
std::vector<std::string> cut_list(std::string_view text);

/// One number of a line; nothing: the line has no such one.   RT: yes.
std::optional<double> find_value(const TextValue& wanted, const wire::UsarLine& line, bool decimal_comma) noexcept;

}  // namespace sinew::drivers
