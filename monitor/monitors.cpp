#include "monitor/monitors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "monitor/json_reply.hpp"

namespace sinew::monitor {
namespace {

constexpr std::size_t kMostHost = 253, kMostWhy = 200, kMostProgram = 64;  // characters
constexpr std::pair<std::string_view, bool> kSchemes[] = {{"http://", false}, {"https://", true}};

/// What another machine says, shortened, and without what is no text.
std::string shown(std::string_view text, std::size_t most) {
  std::string out(text.substr(0, most));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < ' ' || c == '\x7f'; }, ' ');
  while (out.ends_with(' ')) out.pop_back();
  return out;
}

bool is_of_a_host(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
}

/// Why it refuses, of a reply in JSON or in plain text.
std::string reason_in(const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object()) return shown(body, kMostWhy);
  const auto error = json.find("error");
  return error != json.end() && error->is_object() ? shown(text_of(*error, "why"), kMostWhy) : std::string();
}

}  // namespace

bool parse_place(std::string_view text, MonitorPlace& place, std::string& why) {
  std::string rest(text);
  std::transform(rest.begin(), rest.end(), rest.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; });
  place.tls = false;
  for (const auto& [scheme, tls] : kSchemes)
    if (rest.starts_with(scheme)) {
      rest.erase(0, scheme.size());
      place.tls = tls;
      if (rest.ends_with('/')) rest.pop_back();
      break;
    }
  const std::size_t colon = rest.find(':');
  place.host = rest.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : rest.substr(colon + 1);
  const auto read = std::from_chars(port.data(), port.data() + port.size(), place.port);
  const bool is_place = !place.host.empty() && place.host.size() <= kMostHost && read.ec == std::errc() &&
                        read.ptr == port.data() + port.size() && place.port > 0 &&
                        std::all_of(place.host.begin(), place.host.end(), is_of_a_host);
  place.address = fmt::format("{}:{}", place.host, place.port);
  if (!is_place)
    why = fmt::format("'{}': the address of a monitor is HOST:PORT or https://HOST:PORT", shown(text, 100));
  return is_place;
}

/// One question to a monitor: GET /api.
class Monitors::Look final : public Client::Listener {
 public:
  /// `done` is the last thing that it does.
  Look(Client& client, const MonitorPlace& place, std::function<void(Client::End, const std::string&)> done)
      : done_(std::move(done)) {
    Call call;
    call.host = place.host, call.port = place.port, call.tls = place.tls;
    call.target = "/api", call.patience = kPatience;
    connection_ = client.open(std::move(call), *this);
  }
  int status() const { return status_; }
  const std::string& body() const { return body_; }

  void answered(const Client::Answer& answer) override { status_ = answer.status; }
  void received(const Client::Piece& piece) override {
    body_.append(reinterpret_cast<const char*>(piece.bytes.data()), piece.bytes.size());
    if (body_.size() <= kMostAnswer) return;
    connection_.reset();
    ended(Client::End::lost, "its answer is too long");
  }
  void ended(Client::End how, const std::string& why) override {
    const auto done = std::move(done_);  // it destroys this
    done(how, std::string(why));
  }

 private:
  std::function<void(Client::End, const std::string&)> done_;
  std::unique_ptr<Client::Connection> connection_;
  int status_ = 0;
  std::string body_{};
};

Monitors::Monitors(Server& server, Gate& gate, OnRemoved on_removed)
    : server_(server), gate_(gate), on_removed_(std::move(on_removed)) {}

Monitors::~Monitors() = default;

bool Monitors::add(std::string_view address, std::string& why) {
  MonitorPlace place;
  if (!parse_place(address, place, why)) return false;
  if (const auto known = known_.find(place.address); known != known_.end()) {
    if (known->second.place.tls == place.tls) return true;
    remove(place.address);
  }
  if (known_.size() >= kMost) {
    why = fmt::format("{} monitors are known already", kMost);
    return false;
  }
  known_[place.address].place = place;
  return true;
}

const MonitorPlace* Monitors::find(std::string_view address) const {
  const auto known = known_.find(address);
  return known == known_.end() ? nullptr : &known->second.place;
}

void Monitors::remove(const std::string& address) {
  known_.erase(address);
  on_removed_(address);
}

void Monitors::answer(const Request& request, const Server::Reply& reply) {
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (request.path == "/api/monitors" && reads) return list(reply);
  const bool adds = request.path == "/api/monitors", removes = request.path == "/api/monitors/remove";
  if (!adds && !removes) return reply(json_error(404, "not_found", "known are /api/monitors and /api/monitors/remove"));
  if (request.method != "POST") return reply(json_error(405, "bad_argument", "POST changes the list of monitors"));
  if (const auto refusal = gate_.refuses_command(request))
    return reply(json_error(refusal->status, "denied", refusal->why));
  Response refusal;
  const auto body = json_body(request, refusal);
  if (!body) return reply(std::move(refusal));
  const std::string address = text_of(*body, "address");
  std::string why;
  if (adds) {
    if (!add(address, why)) return reply(json_error(400, "bad_argument", why));
  } else {
    MonitorPlace place;
    if (!parse_place(address, place, why)) return reply(json_error(400, "bad_argument", why));
    if (!find(place.address))
      return reply(json_error(404, "not_found", fmt::format("no monitor '{}' is known", place.address)));
    remove(place.address);
  }
  list(reply);
}

void Monitors::list(const Server::Reply& reply) {
  static constexpr std::string_view kStates[] = {"reached", "not reached", "refused"};
  Json all = Json::array();
  for (auto& [address, known] : known_) {
    all.push_back({{"address", address},
                   {"tls", known.place.tls},
                   {"state", kStates[static_cast<std::size_t>(known.state)]},
                   {"why", known.why},
                   {"program", known.program},
                   {"commands", known.commands}});
    if (!known.look && Clock::now() - known.asked >= kLook) look(known);
  }
  reply(json_response(200, to_text({{"ok", true}, {"monitors", std::move(all)}})));
}

void Monitors::look(Known& known) {
  known.asked = Clock::now();
  known.look = std::make_unique<Look>(
      server_.client(), known.place, [this, address = known.place.address](Client::End how, const std::string& why) {
        const auto at = known_.find(address);
        if (at == known_.end()) return;
        Known& k = at->second;
        const auto seen = std::move(k.look);
        k.program.clear(), k.commands = false, k.why.clear(), k.state = State::refused;
        if (how != Client::End::whole) {
          if (how == Client::End::lost) k.state = State::not_reached;
          k.why = shown(why, kMostWhy);
          return;
        }
        const Json about = Json::parse(seen->body(), nullptr, false);
        const bool is_one = seen->status() == 200 && about.is_object() && !text_of(about, "program").empty();
        if (!is_one) {
          k.why = seen->status() == 200 ? "no monitor answers there" : reason_in(seen->body());
          if (k.why.empty()) k.why = fmt::format("status {}", seen->status());
          return;
        }
        k.state = State::reached;
        k.program = shown(text_of(about, "program"), kMostProgram);
        const auto commands = about.find("commands");
        k.commands = commands != about.end() && commands->is_boolean() && commands->get<bool>();
      });
}

}  // namespace sinew::monitor
