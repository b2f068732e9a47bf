#include "monitor/foxglove/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "monitor/foxglove/reply.hpp"

namespace sinew::foxglove {
namespace {

using namespace std::chrono_literals;

constexpr unsigned kMostSmallInRow = 64;     // then something larger may go between
constexpr auto kAckPeriod = 10ms;            // how often we look for what was delivered
constexpr auto kFar = 10ms, kBundle = 40ms;  // of a round trip; between bundles of small messages then
// Requests that change nothing: a connection without token may call them.
constexpr std::string_view kLooks[] = {"record.status", "playback"};

bool is_open(std::string_view request, const RobotFacts& facts) {
  if (std::find(std::begin(kLooks), std::end(kLooks), request) != std::end(kLooks)) return true;
  return facts.recorded_ns && request.starts_with("playback.");  // commands nothing
}

Bytes shared(std::vector<std::byte> bytes) { return std::make_shared<const std::vector<std::byte>>(std::move(bytes)); }

std::optional<PlaybackState> playback_of(const Json& reply, std::int64_t unix_ns) {
  const auto at = reply.find("time_ns"), speed = reply.find("speed");
  if (at == reply.end() || !at->is_number_integer()) return std::nullopt;
  PlaybackState state;
  state.time_ns = static_cast<std::uint64_t>(at->get<std::int64_t>() + unix_ns);
  if (speed != reply.end() && speed->is_number()) state.speed = speed->get<float>();
  const std::string word = text_of(reply, "state");
  using S = PlaybackState::Status;
  state.status = word == "playing" ? S::playing : word == "ended" ? S::ended : S::paused;
  return state;
}

}  // namespace

Session::Session(Options options, Host host)
    : options_(std::move(options)), host_(std::move(host)), backlog_(std::make_shared<Backlog>(host_.wake)) {}

Session::~Session() {
  backlog_->close();
  if (host_.closed) host_.closed();
}

// ---- robots

void Session::follow(const std::vector<std::shared_ptr<Robot>>& robots) {
  for (auto at = robots_.begin(); at != robots_.end();) {
    if (std::find(robots.begin(), robots.end(), at->robot) != robots.end()) {
      ++at;
      continue;
    }
    disappear(*at);
    at = robots_.erase(at);
  }
  std::vector<std::shared_ptr<Robot>> added;
  for (const auto& robot : robots)
    if (std::none_of(robots_.begin(), robots_.end(), [&](const Seen& s) { return s.robot == robot; }))
      added.push_back(robot);
  if (!begun_) {
    begun_ = true;
    ServerInfo info;
    info.name = options_.name, info.session_id = options_.id;
    info.capabilities = {"parameters", "parametersSubscribe", "services", "connectionGraph"};
    if (options_.may_command) info.capabilities.emplace_back("clientPublish");
    if (!options_.all_robots && !added.empty()) {
      const RobotFacts& facts = added.front()->facts();
      if (facts.own_clock) info.capabilities.emplace_back("time");
      if (facts.recorded_ns && options_.sdk) {
        info.capabilities.emplace_back("playbackControl");
        info.data_ns = facts.recorded_ns;
      }
      info.metadata = {{"robot", facts.name}, {"unix_ns", std::to_string(facts.unix_ns)}};
    }
    send(server_info(info));
    if (added.empty()) send(advertise({}));
  }
  for (const auto& robot : added) appear(robot);
}

void Session::appear(const std::shared_ptr<Robot>& robot) {
  const RobotFacts& facts = robot->facts();
  Seen seen{robot, options_.all_robots ? "/" + facts.name : ""};
  std::vector<ChannelText> channels;
  for (std::size_t i = 0; i < facts.channels.size(); ++i) {
    const Channel& c = facts.channels[i];
    const std::uint32_t id = ++last_channel_;
    channels.push_back({id, seen.prefix + c.topic, c.encoding, c.schema_name, c.schema, c.schema_encoding});
    channels_[id] = {robot, i};
    seen.channels.push_back(id);
  }
  std::vector<ServiceText> services;
  for (const std::string& request : facts.requests) {
    const std::uint32_t id = ++last_service_;
    services.push_back({id, seen.prefix + "/sinew/" + request, "sinew/" + request});
    services_[id] = {robot, request};
    seen.services.push_back(id);
  }
  send(advertise(channels));
  if (!services.empty()) send(advertise_services(services));
  robots_.push_back(std::move(seen));
  if (follows_graph_) {
    GraphUpdate update;
    add_graph(robots_.back(), update);
    send_graph(update);
  }
}

void Session::disappear(Seen& seen) {
  std::erase_if(subscriptions_, [&](const Subscription& s) { return channels_.at(s.channel).robot == seen.robot; });
  std::erase_if(client_channels_, [&](const auto& c) { return c.second.robot == seen.robot; });
  for (const std::uint32_t id : seen.channels) channels_.erase(id);
  for (const std::uint32_t id : seen.services) services_.erase(id);
  send(unadvertise(seen.channels));
  if (!seen.services.empty()) send(unadvertise_services(seen.services));
  if (follows_graph_) {
    GraphUpdate gone, all;
    add_graph(seen, all);
    for (const auto& [name, ends] : all.published) gone.removed_topics.push_back(name);
    for (const auto& [name, ends] : all.services) gone.removed_services.push_back(name);
    send_graph(gone);
  }
}

Session::Seen* Session::find(std::string_view name, std::string_view& rest) {
  for (Seen& seen : robots_) {
    if (!seen.prefix.empty()) {
      if (!name.starts_with(seen.prefix + "/")) continue;
      rest = name.substr(seen.prefix.size() + 1);
      return &seen;
    }
    rest = name.starts_with('/') ? name.substr(1) : name;
    return &seen;
  }
  return nullptr;
}

// ---- what we send

void Session::send(std::string text) {
  const auto bytes = std::as_bytes(std::span(text));
  if (control_bytes_ + bytes.size() > kMostControlBytes) {
    overflowed_ = true;
    return;
  }
  control_bytes_ += bytes.size();
  control_.push_back({false, monitor::bytes_of(text), {}});
  backlog_->tell();
}

void Session::send(std::vector<std::byte> bytes) {
  if (control_bytes_ + bytes.size() > kMostControlBytes) {
    overflowed_ = true;
    return;
  }
  control_bytes_ += bytes.size();
  control_.push_back({true, shared(std::move(bytes)), {}});
  backlog_->tell();
}

std::optional<monitor::Socket::Message> Session::next() {
  backlog_->look();
  if (picture_being_sent_) {
    picture_being_sent_ = false;
    if (const auto link = host_.link()) pace_.sent(host_.now(), *link);
  }
  if (!control_.empty()) {
    Message message = std::move(control_.front());
    control_.pop_front();
    control_bytes_ -= message.bytes->size();
    return message;
  }
  if (small_in_row_ < kMostSmallInRow && !holds_small())
    if (auto message = small_message()) return message;
  small_in_row_ = 0;
  if (auto message = picture()) {
    small_at_.reset();  // what waits goes in the same packet
    return message;
  }
  if (auto message = large_message()) return message;
  return holds_small() ? std::nullopt : small_message();
}

/// On a link with a long way messages that come soon after others wait for more: each packet is one more that may be
/// lost, and everything behind it then waits for it.
bool Session::holds_small() {
  if (!is_far_ || !small_at_) return false;
  const auto now = host_.now();
  const auto waits = kBundle - (now - *small_at_);
  if (waits <= Clock::duration{}) return false;
  if (now >= small_woken_) {
    const auto in = std::chrono::ceil<std::chrono::milliseconds>(waits);
    small_woken_ = now + in;
    host_.wake_in(in);
  }
  return true;
}

template <class Which>
std::optional<monitor::Socket::Message> Session::in_turn(std::size_t& next, const Which& which) {
  for (std::size_t i = 0; i < subscriptions_.size(); ++i) {
    next = (next + 1) % subscriptions_.size();
    Subscription& s = subscriptions_[next];
    if (!which(s)) continue;
    if (auto item = s.inbox->take()) {
      s.wanted = false;
      auto head = message_head(s.id, item->time_ns);
      head.insert(head.end(), item->head.begin(), item->head.end());
      return Message{true, std::move(item->payload), std::move(head)};
    }
  }
  return std::nullopt;
}

std::optional<monitor::Socket::Message> Session::small_message() {
  auto message = in_turn(next_small_, [](const Subscription& s) { return s.is_small; });
  if (message)
    ++small_in_row_;
  else if (small_in_row_ > 0)
    small_at_ = host_.now();
  return message;
}

std::optional<monitor::Socket::Message> Session::large_message() {
  return in_turn(next_large_, [](const Subscription& s) { return !s.is_small && s.kind != Channel::Kind::pictures; });
}

std::optional<monitor::Socket::Message> Session::picture() {
  if (std::none_of(subscriptions_.begin(), subscriptions_.end(), [](const Subscription& s) { return s.pictures; }))
    return std::nullopt;
  const auto now = host_.now();
  const auto link = host_.link();
  if (link) pace_.look(now, *link);
  auto message = in_turn(next_picture_, [](const Subscription& s) { return s.kind == Channel::Kind::pictures; });
  picture_being_sent_ = message.has_value();
  const bool may_send = !message && (!link || pace_.may_send(*link));
  bool waits = pace_.waits();
  for (Subscription& s : subscriptions_) {
    if (!s.pictures || s.wanted) continue;
    if (may_send) {
      s.wanted = true;
      s.pictures->want(pace_.size());
    } else {
      waits = true;
    }
  }
  if (!message && waits && (!woken_at_ || now - *woken_at_ >= kAckPeriod)) {
    woken_at_ = now;
    host_.wake_in(kAckPeriod);
  }
  return message;
}

// ---- what the client sends

bool Session::receive(bool binary, std::span<const std::byte> message) {
  if (overflowed_ || message.size() > kMostClientBytes) return false;
  std::string why;
  const auto parsed = parse(binary, message, why);
  if (!parsed) {
    complain(StatusLevel::error, "message refused: " + why);
    return ++garbage_ < kMostGarbage;
  }
  std::visit([this](const auto& m) { handle(m); }, *parsed);
  return !overflowed_;
}

void Session::handle(const Subscribe& message) {
  for (const auto& [id, channel] : message.subscriptions) subscribe(id, channel);
}

void Session::subscribe(std::uint32_t id, std::uint32_t channel) {
  const auto at = channels_.find(channel);
  if (at == channels_.end()) return complain(StatusLevel::warning, fmt::format("subscribe: no channel {}", channel));
  for (const Subscription& s : subscriptions_) {
    if (s.id == id) return complain(StatusLevel::error, fmt::format("subscribe: subscription {} is there already", id));
    if (s.channel == channel)
      return complain(StatusLevel::error, fmt::format("subscribe: channel {} is subscribed to already", channel));
  }
  const auto& [robot, index] = at->second;
  const Channel& about = robot->facts().channels[index];
  const auto inbox = std::make_shared<Inbox>(about.is_small ? kSmallMessages : 1, backlog_);
  Subscription s{id, channel, about.kind, about.is_small, inbox};
  if (about.kind == Channel::Kind::pictures)
    s.pictures = robot->look(index, inbox);
  else
    s.feed = robot->subscribe(index, inbox);
  subscriptions_.push_back(std::move(s));
  backlog_->tell();
}

void Session::handle(const Unsubscribe& message) {
  for (const std::uint32_t id : message.ids)
    if (std::erase_if(subscriptions_, [&](const Subscription& s) { return s.id == id; }) == 0)
      complain(StatusLevel::warning, fmt::format("unsubscribe: no subscription {}", id));
}

void Session::handle(const ClientAdvertise& message) {
  for (const auto& c : message.channels) {
    std::string_view topic;
    const Seen* const seen = find(c.topic, topic);
    std::string why;
    if (!options_.may_command)
      why = "needs the token: connect with ?token=TOKEN";
    else if (c.encoding != "json")
      why = "encoding has to be json";
    else if (!seen)
      why = "no such robot";
    else if (const auto& known = seen->robot->facts().external;
             std::find(known.begin(), known.end(), topic) == known.end())
      why = fmt::format("is no topic that is written from outside; these are: {}",
                        known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", ")));
    else if (client_channels_.contains(c.id))
      why = fmt::format("channel {} is there already", c.id);
    else if (client_channels_.size() >= kMostClientChannels)
      why = "too many channels";
    if (why.empty())
      client_channels_[c.id] = {seen->robot, std::string(topic)};
    else
      complain(StatusLevel::error, fmt::format("advertise: {}: {}", c.topic, why));
  }
}

void Session::handle(const ClientUnadvertise& message) {
  for (const std::uint32_t id : message.ids)
    if (client_channels_.erase(id) == 0) complain(StatusLevel::warning, fmt::format("unadvertise: no channel {}", id));
}

std::string Session::why_not(const std::shared_ptr<Robot>& robot, const std::string& request) const {
  if (is_open(request, robot->facts())) return {};
  if (!options_.may_command) return "needs the token: connect with ?token=TOKEN";
  return host_.refuses ? host_.refuses(robot->facts().name, request) : std::string();
}

/// Takes a reply from any thread to the server's.
Robot::Done Session::here(Answered done) {
  ++asked_;
  return [this, post = host_.post, alive = std::weak_ptr(alive_), done = std::move(done)](std::string reply) {
    post([this, alive, done, reply = std::move(reply)] {
      if (alive.expired()) return;  // the session is gone: nothing of it may be touched
      --asked_;
      done(reply);
    });
  };
}

bool Session::ask(const std::shared_ptr<Robot>& robot, std::string request, std::string arguments, Answered done) {
  if (asked_ >= kMostAsked) return false;
  robot->ask(std::move(request), std::move(arguments), here(std::move(done)));
  return true;
}

bool Session::ask_status(const std::shared_ptr<Robot>& robot, bool recent, Answered done) {
  if (!recent) return ask(robot, "status", "{}", std::move(done));
  if (asked_ >= kMostAsked) return false;
  robot->recent_status(here(std::move(done)));
  return true;
}

void Session::handle(const ClientData& message) {
  const auto at = client_channels_.find(message.channel);
  if (at == client_channels_.end())
    return complain(StatusLevel::error, fmt::format("message on channel {}: it is not advertised", message.channel));
  const auto& [robot, topic] = at->second;
  if (const std::string why = why_not(robot, "publish"); !why.empty())
    return complain(StatusLevel::error, topic + ": " + why);
  Json payload = Json::parse(message.payload, nullptr, false);
  if (!payload.is_object()) return complain(StatusLevel::error, topic + ": the message is no JSON object");
  const Json arguments{{"topic", topic}, {"message", std::move(payload)}};
  const bool asked = ask(robot, "publish", one_line(arguments), [this, name = topic](const std::string& reply) {
    if (const std::string why = error_of(object_of(reply)); !why.empty())
      complain(StatusLevel::error, name + ": " + why);
  });
  if (!asked) complain(StatusLevel::error, topic + ": too many messages at once");
}

void Session::handle(const ServiceCall& message) {
  const auto fail = [&](std::string_view why) { send(service_failure(message.service, message.call, why)); };
  const auto at = services_.find(message.service);
  if (at == services_.end()) return fail("no such service");
  if (message.encoding != "json") return fail("encoding has to be json");
  const auto& [robot, request] = at->second;
  if (const std::string why = why_not(robot, request); !why.empty()) return fail(why);
  const std::string arguments(message.payload.empty() ? std::string_view("{}") : message.payload);
  if (!Json::parse(arguments, nullptr, false).is_object()) return fail("the request is no JSON object");
  const bool asked =
      ask(robot, request, arguments, [this, service = message.service, call = message.call](const std::string& reply) {
        if (const std::string why = error_of(object_of(reply)); !why.empty())
          send(service_failure(service, call, why));
        else
          send(service_response(service, call, "json", reply));
      });
  if (!asked) fail("too many calls at once");
}

void Session::handle(const FetchAsset& message) { send(asset_failure(message.request, "there are no assets here")); }

// ---- graph

void Session::handle(const FollowGraph& message) {
  follows_graph_ = message.on;
  if (!message.on) return;
  GraphUpdate update;
  for (const Seen& seen : robots_) add_graph(seen, update);
  send_graph(update);
}

void Session::add_graph(const Seen& seen, GraphUpdate& update) const {
  const RobotFacts& facts = seen.robot->facts();
  const auto add = [&](const Ends& from, Ends& to) {
    for (const auto& [topic, modules] : from) {
      std::vector<std::string> ids;
      for (const std::string& m : modules) ids.push_back(seen.prefix.empty() ? m : seen.prefix + "/" + m);
      to.emplace_back(seen.prefix + topic, std::move(ids));
    }
  };
  add(facts.published, update.published);
  add(facts.subscribed, update.subscribed);
  for (const std::string& request : facts.requests)
    update.services.emplace_back(seen.prefix + "/sinew/" + request, std::vector<std::string>{facts.name});
}

// ---- time and playback

void Session::tick() {
  const auto link = host_.link();
  is_far_ = link && link->shortest_round_trip_us > std::chrono::microseconds(kFar).count();
  look_at_followed_parameters();
  if (options_.all_robots || robots_.empty()) return;
  const auto& robot = robots_.front().robot;
  if (robot->facts().own_clock) {
    const std::uint64_t now = robot->time_ns();
    if (now != told_time_) send(time(now));
    told_time_ = now;
  }
  if (options_.sdk && robot->facts().recorded_ns && !looks_at_playback_)
    looks_at_playback_ = ask(robot, "playback", "{}", [this](const std::string& reply) {
      looks_at_playback_ = false;
      playback_looked(reply, "", false);
    });
}

void Session::playback_looked(const std::string& reply, const std::string& request, bool did_seek) {
  const Json json = object_of(reply);
  auto state = playback_of(json, robots_.empty() ? 0 : robots_.front().robot->facts().unix_ns);
  if (!state) {
    if (!request.empty()) complain(StatusLevel::error, "playback: " + error_of(json));
    return;
  }
  state->request = request, state->did_seek = did_seek;
  const bool changed =
      !told_playback_ || told_playback_->status != state->status || told_playback_->speed != state->speed;
  told_playback_ = state;
  if (changed || !request.empty()) send(playback_state(*state));
}

void Session::handle(const PlaybackControl& message) {
  const bool is_there =
      options_.sdk && !options_.all_robots && !robots_.empty() && robots_.front().robot->facts().recorded_ns;
  if (!is_there) return complain(StatusLevel::error, "playback: only of a recorded run, by foxglove.sdk.v1");
  const auto robot = robots_.front().robot;
  const auto note = [this](const std::string& reply) {
    if (const std::string why = error_of(object_of(reply)); !why.empty())
      complain(StatusLevel::error, "playback: " + why);
  };
  // They keep their order; each is answered at once.
  bool asked = ask(robot, "playback.speed", one_line({{"speed", message.speed}}), note);
  if (message.seek_ns) {
    const auto at = static_cast<std::int64_t>(*message.seek_ns) - robot->facts().unix_ns;
    asked = asked && ask(robot, "playback.seek", one_line({{"time_ns", at}}), note);
  }
  asked = asked && ask(robot, message.play ? "playback.play" : "playback.pause", "{}", note);
  asked = asked && ask(robot, "playback", "{}",
                       [this, request = message.request, seeks = message.seek_ns.has_value()](
                           const std::string& reply) { playback_looked(reply, request, seeks); });
  if (!asked) complain(StatusLevel::error, "playback: too many requests at once");
}

}  // namespace sinew::foxglove
