#include "drivers/text/text_spec.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "hal/did_you_mean.hpp"
#include "hal/udp_address.hpp"
#include "wire/text/navdata.hpp"
#include "wire/text_scan.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kToIs = "\"tcp:HOST:PORT\" or \"udp:1.2.3.4:PORT\"";
constexpr std::string_view kUdpIs = "\"udp:1.2.3.4:PORT\"";
constexpr std::string_view kTemplateIs = "text with %d %i %u %f %e %g %s %b %q %%";
constexpr double kMostText = 1e15;
constexpr std::pair<std::string_view, TextDecoder> kDecoders[] = {{"usarsim", TextDecoder::usarsim},
                                                                  {"fields", TextDecoder::fields},
                                                                  {"words", TextDecoder::words},
                                                                  {"navdata", TextDecoder::navdata}};

std::string_view stripped(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

bool is_tcp(std::string_view to) {
  if (!to.starts_with("tcp:")) return false;
  const std::size_t colon = to.rfind(':');
  const std::string_view host = to.substr(4, colon < 4 ? 0 : colon - 4), port = to.substr(colon + 1);
  const auto number = wire::parse_decimal(port, 5);
  return !host.empty() && number && *number >= 1 && *number <= 65535;
}

void read_udp_peer(DeviceKeys& keys, std::string_view key, std::string_view to, std::string_view is, TextSocket& out) {
  const auto peer = to.starts_with("udp:") ? hal::udp_address(to.substr(4)) : std::nullopt;
  if (peer && !peer->is_multicast() && peer->ipv4 != 0)
    out.peer = *peer;
  else
    keys.problem(key, is);
}

/// A template without words that takes no value.
std::optional<wire::TextTemplate> read_fixed(DeviceKeys& keys, std::string_view key, std::string_view doc) {
  std::string text;
  if (!keys.read(key, text, kTemplateIs, {.doc = doc, .otherwise = "nothing"})) return std::nullopt;
  std::string why;
  auto made = wire::TextTemplate::parse(text, {}, why);
  if (made && made->values() > 0) made.reset(), why = "only %q and %%: there is no value for others here";
  if (!made) keys.problem(key, why);
  return made;
}

/// Line by line; an empty one is none.
std::vector<wire::TextTemplate> read_greeting(DeviceKeys& keys) {
  std::string text;
  std::vector<wire::TextTemplate> all;
  if (!keys.read(
          "greeting", text, "lines of text",
          {.doc = "sent when the link is made; UDP: again each second while nothing comes in", .otherwise = "nothing"}))
    return all;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = stripped(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.empty()) continue;
    std::string why;
    auto made = wire::TextTemplate::parse(line, {}, why);
    if (made && made->values() > 0) made.reset(), why = "only %q and %%: there is no value for others here";
    if (made)
      all.push_back(std::move(*made));
    else
      keys.problem("greeting", "\"" + std::string(line) + "\": " + why);
  }
  return all;
}

void read_range(DeviceKeys& keys, TextRange& range) {
  keys.read("min", range.min, -kMostText, kMostText, {.doc = "smallest that is written"});
  keys.read("max", range.max, -kMostText, kMostText, {.doc = "largest that is written"});
  keys.read("increment", range.increment, 0, kMostText,
            {.doc = "what is written is a multiple of it", .otherwise = "any number"});
  if (range.max < range.min) keys.problem("max", "not below min");
}

void read_sockets(DeviceKeys& keys, TextLinkSpec& link) {
  std::string ini, to, state;
  // The reader of robot files has merged the file into the keys.
  keys.read("ini", ini, "the path of a file",
            {.doc = "a configuration of altURI: keys and tables that are not here come from it", .otherwise = "none"});
  keys.read("to", to, kToIs, {.doc = "where commands go; what comes back there is read", .required = !keys.has("ini")});
  link.main.tcp = to.starts_with("tcp:");
  if (!to.empty() && !keys.told("to")) {
    if (link.main.tcp && is_tcp(to))
      link.main.endpoint = to;
    else if (link.main.tcp)
      keys.problem("to", kToIs);
    else
      read_udp_peer(keys, "to", to, kToIs, link.main);
  }
  link.main.port = link.main.peer.port;
  const std::string_view port_doc = "UDP: the port that commands are sent from, and answers come to";
  if (keys.read_integer("port", link.main.port, 1, 65535, {.doc = port_doc, .otherwise = "that of `to`"}) &&
      link.main.tcp)
    keys.problem("port", "no such key with TCP");
  keys.read_choice<TextDecoder>("decoder", link.main.decoder, kDecoders, {.doc = "how what comes back is read"});
  TextSocket second;
  second.decoder = TextDecoder::navdata;
  const bool has_state = keys.read("state", state, kUdpIs,
                                   {.doc = "a second socket, on which the robot tells its state", .otherwise = "none"});
  if (has_state && !keys.told("state")) read_udp_peer(keys, "state", state, kUdpIs, second);
  second.port = second.peer.port;
  for (const std::string_view key : {"state_port", "state_decoder", "state_hello"})
    if (!has_state && keys.has(key)) keys.problem(key, "no such key without state");
  keys.read_integer("state_port", second.port, 1, 65535,
                    {.doc = "the port that the state comes to", .otherwise = "that of `state`"});
  keys.read_choice<TextDecoder>("state_decoder", second.decoder, kDecoders, {.doc = "how it is read"});
  keys.read("state_hello", link.state_hello, "text",
            {.doc = "sent to `state` each second while nothing comes from there", .otherwise = "nothing"});
  if (has_state) link.state = second;
  if (!link.main.tcp) keys.claim("port", "UDP port " + std::to_string(link.main.port));
  if (has_state) keys.claim("state", "UDP port " + std::to_string(second.port));
}

template <class Parts, class Read>
void read_parts(DeviceKeys& keys, const std::vector<DeviceSpec>& tables, std::string_view what, std::size_t most,
                Parts& out, Read&& read) {
  std::set<std::string> names;
  for (const DeviceSpec& table : tables) {
    const std::string path = keys.path() + "." + std::string(what) + "." + table.name;
    DeviceKeys own(table, path, keys.problems());
    read(own, out);
    own.finish();
    if (!names.insert(table.name).second) keys.problems().push_back({table.line, path, "", "a name that no other has"});
  }
  if (tables.size() > most)
    keys.problems().push_back({tables[most].line, keys.path() + "." + std::string(what), std::to_string(tables.size()),
                               "at most " + std::to_string(most) + " of them"});
}

/// The texts of all drives with the prefix in front, as one template, or one for each.
void make_drive_lines(DeviceKeys& keys, TextLinkSpec& link, const std::string& prefix, const std::string& join,
                      bool separate) {
  std::vector<std::string> lines;
  for (const TextDrive& drive : link.drives) {
    if (separate || lines.empty())
      lines.push_back(prefix + drive.text);
    else
      lines.back() += join + drive.text;
  }
  for (const std::string& line : lines) {
    std::string why;
    auto made = wire::TextTemplate::parse(line, {}, why);
    if (!made && !keys.told("prefix")) keys.problem("prefix", why);
    if (made) link.drive_lines.push_back(std::move(*made));
  }
}

/// "Type=Sonar, Name=F2"
bool read_where(std::string_view text, TextValue& out) {
  for (const std::string& one : cut_list(text)) {
    const std::size_t cut = one.find('=');
    if (cut == std::string::npos || cut == 0) return false;
    out.where.emplace_back(stripped(one.substr(0, cut)), stripped(std::string_view(one).substr(cut + 1)));
  }
  return true;
}

}  // namespace

double TextRange::fitted(double value) const noexcept {
  if (increment > 0) {
    // Steps from zero, as altURI counts them. Sums like 3 * 0.1 are as near as a double is.
    const double steps = value / increment;
    if (std::fabs(steps) < 1e15) value = std::floor(steps + 0.5) * increment;
  }
  return std::clamp(value, min, std::max(min, max));
}

std::vector<std::string> cut_list(std::string_view text) {
  std::vector<std::string> all;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    if (const std::string_view one = stripped(text.substr(0, end)); !one.empty()) all.emplace_back(one);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return all;
}

void read_text_drive(DeviceKeys& keys, TextDrive& out) {
  out.name = keys.spec().name;
  if (keys.read("text", out.text, kTemplateIs, {.doc = "its part of the command, with one value", .required = true})) {
    std::string why;
    const auto made = wire::TextTemplate::parse(out.text, {}, why);
    if (!made)
      keys.problem("text", why);
    else if (made->values() != 1)
      keys.problem("text", "a text with one conversion that takes a value");
  }
  read_range(keys, out.range);
  keys.read("scale", out.scale, -kMostText, kMostText, {.doc = "what is written is setpoint * scale + offset"});
  keys.read("offset", out.offset, -kMostText, kMostText, {.doc = "see scale"});
  keys.read("rest", out.rest, -kMostText, kMostText, {.doc = "the setpoint where there is no valid one"});
}

std::optional<TextCommand> read_text_command(DeviceKeys& keys) {
  TextCommand command;
  command.name = keys.spec().name;
  std::string text, words, answers, why;
  const bool has_text = keys.read("text", text, kTemplateIs,
                                  {.doc = "the command; each conversion is a channel, none: sent when its channel "
                                          "becomes 1",
                                   .required = true});
  keys.read("words", words, "words with commas between", {.doc = "of %s: 0 is the first", .otherwise = "none"});
  read_range(keys, command.range);
  keys.read_ms("repeat_ms", command.repeat, 5, 60000,
               {.doc = "sent again so often", .otherwise = "once for each change"});
  if (keys.read("answer", answers, "words with commas between",
                {.doc = "with repeat_ms: until one of these replies comes", .otherwise = "none"})) {
    command.answers = cut_list(answers);
    if (!keys.has("repeat_ms")) keys.problem("answer", "no such key without repeat_ms");
  }
  if (!has_text) return std::nullopt;
  auto made = wire::TextTemplate::parse(text, cut_list(words), why);
  if (!made) {
    keys.problem("text", why);
    return std::nullopt;
  }
  if (made->values() > msg::kMaxChannels) keys.problem("text", "at most 8 conversions that take a value");
  command.text = std::move(*made);
  return command;
}

void read_text_value(DeviceKeys& keys, TextDecoder decoder, TextValue& out) {
  out.name = keys.spec().name;
  std::string where, words;
  keys.read("message", out.message, "the type of the line", {.doc = "the first word of the line", .otherwise = "any"});
  const bool has_key =
      keys.read("key", out.key, "the key", {.doc = "its name in the line; case matters", .required = true});
  keys.read_integer("index", out.index, 0, 1000, {.doc = "which of the values behind the key, from 0"});
  if (keys.read("where", where, "KEY=VALUE, with commas between",
                {.doc = "only lines with these; the key is looked for behind the last of them", .otherwise = "all"}) &&
      !read_where(where, out))
    keys.problem("where", "KEY=VALUE, with commas between");
  keys.read_choice<TextValue::As>(
      "as", out.as, {{"number", TextValue::As::number}, {"degrees_minutes", TextValue::As::degrees_minutes}},
      {.doc = "degrees_minutes: \"47,40.33,N\" from `index` on is 47.672 degrees"});
  if (keys.read(
          "words", words, "words with commas between",
          {.doc = "its value is the number of the word, from 0", .otherwise = "it is a number, or True or False"}))
    out.words = cut_list(words);
  keys.read("scale", out.scale, -kMostText, kMostText, {.doc = "value = number * scale + offset"});
  keys.read("offset", out.offset, -kMostText, kMostText, {.doc = "see scale"});
  if (decoder == TextDecoder::navdata && has_key && !wire::is_navdata_value(out.message, out.key, out.index))
    keys.problem("key",
                 "a value of navdata: of message demo battery, pitch, roll, yaw, altitude, velocity (index 0 to "
                 "2), fly_state, control_state; of raw voltage; of state a bit such as flying or emergency");
}

TextLinkSpec read_text_link(DeviceKeys& keys) {
  TextLinkSpec link;
  link.name = keys.spec().name;
  read_sockets(keys, link);
  keys.read("line_end", link.line_end, "text",
            {.doc = "behind each command; \"none\": nothing", .otherwise = "CR LF", .allowed = "text"});
  if (link.line_end == "none") link.line_end.clear();
  link.greeting = read_greeting(keys);
  std::string prefix, join = " ";
  bool separate = false;
  keys.read("prefix", prefix, kTemplateIs, {.doc = "in front of the drives' texts", .otherwise = "nothing"});
  keys.read("join", join, "text", {.doc = "between them", .otherwise = "a blank"});
  keys.read("separate", separate, {.doc = "each drive is a line of its own"});
  link.safe = read_fixed(keys, "safe", "in place of the drives without a valid setpoint; else they are at rest");
  link.stop = read_fixed(keys, "stop", "when the group is stopped: five times, one each period; else as `safe`");
  link.keep_alive = read_fixed(keys, "keep_alive", "sent all the time while the link is there");
  keys.read_ms("keep_alive_ms", link.keep_alive_period, 5, 60000, {.doc = "so often"});
  keys.read_ms("period_ms", link.period, 5, 1000, {.doc = "the drives are sent so often, changed or not"});
  keys.read_ms("silent_ms", link.silent, 20, 60000,
               {.doc = "without a whole message for so long the devices are gone"});
  keys.read_ms("reconnect_ms", link.reconnect, 100, 600000,
               {.doc = "TCP: without a whole message for so long the connection is made anew"});
  keys.read("decimal_comma", link.decimal_comma, {.doc = "the robot writes 1,5 for one and a half"});
  keys.read_integer("priority", link.fifo_priority, 0, 99, {.doc = "SCHED_FIFO of its thread; 0: an ordinary one"});

  const DeviceSpec& spec = keys.spec();
  read_parts(keys, spec.drives, "drive", msg::kMaxChannels, link.drives,
             [](DeviceKeys& own, auto& out) { read_text_drive(own, out.emplace_back()); });
  read_parts(keys, spec.commands, "command", 32, link.commands, [](DeviceKeys& own, auto& out) {
    if (auto command = read_text_command(own)) out.push_back(std::move(*command));
  });
  const TextDecoder decoder = link.state ? link.state->decoder : link.main.decoder;
  read_parts(keys, spec.messages, "message", msg::kMaxTextValues, link.values,
             [&](DeviceKeys& own, auto& out) { read_text_value(own, decoder, out.emplace_back()); });
  make_drive_lines(keys, link, prefix, join, separate);
  return link;
}

std::optional<double> find_value(const TextValue& wanted, const wire::UsarLine& line, bool decimal_comma) noexcept {
  if (!wanted.message.empty() && line.type != wanted.message) return std::nullopt;
  std::size_t from = 0;
  for (const auto& [key, value] : wanted.where) {
    std::size_t at = line.index_of(key, from);
    while (at < line.count && line.part[at].value != value) at = line.index_of(key, at + 1);
    if (at == line.count) return std::nullopt;
    from = at;
  }
  std::size_t at = line.index_of(wanted.key, from);
  if (at == line.count && from > 0) at = line.index_of(wanted.key);
  if (at == line.count) return std::nullopt;
  const std::string_view text = line.part[at].value;
  if (!wanted.words.empty()) {
    const auto item = wire::usar_item(text, wanted.index, decimal_comma);
    const auto word = std::find(wanted.words.begin(), wanted.words.end(), item);
    if (word == wanted.words.end()) return std::nullopt;
    return static_cast<double>(word - wanted.words.begin()) * wanted.scale + wanted.offset;
  }
  auto number = wire::usar_number(text, wanted.index, decimal_comma);
  if (number && wanted.as == TextValue::As::degrees_minutes) {
    const auto minutes = wire::usar_number(text, wanted.index + 1, decimal_comma);
    const std::string_view side = wire::usar_item(text, wanted.index + 2, decimal_comma);
    if (!minutes || (side != "N" && side != "S" && side != "E" && side != "W")) return std::nullopt;
    number = (*number + *minutes / 60) * (side == "S" || side == "W" ? -1 : 1);
  }
  if (!number) return std::nullopt;
  return *number * wanted.scale + wanted.offset;
}

}  // namespace sinew::drivers
