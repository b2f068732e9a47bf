#include "monitor/robot_feed.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "hal/platform.hpp"
#include "monitor/json_reply.hpp"
#include "msg/cdr.hpp"
#include "msg/ros2_image.hpp"
#include "msg/ros2msg.hpp"

namespace sinew::monitor {
namespace {

using foxglove::Channel;
using namespace std::chrono_literals;

constexpr std::size_t kSmallBytes = 1024;
constexpr int kCopyTries = 3;
constexpr auto kStatusAge = 180ms;  // asked five times a second, however many look
constexpr std::int64_t kSameClockNs = 1'000'000;
constexpr unsigned kTicksOfStatus = 2, kTicksOfTimeline = 10, kTicksOfPlayback = 1;

constexpr const char* kEnded = R"({"ok":false,"error":{"code":"closed","why":"the robot has ended"}})";

// The requests that are neither parameters, channels nor client publish.
constexpr const char* kServices[] = {"arm",         "disarm",        "stop",           "record.start",
                                     "record.stop", "record.status", "record.snapshot"};
constexpr const char* kPlaybackServices[] = {"playback",      "playback.play", "playback.pause",
                                             "playback.seek", "playback.step", "playback.speed"};

constexpr const char* kStatusSchema = R"({"type":"object","properties":{
"unix_ns":{"type":"integer"},"ok":{"type":"boolean"},"now_ns":{"type":"integer"},
"threads":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"priority":{"type":"integer"},
"trigger":{"type":"string"},"period_ns":{"type":"integer"},"modules":{"type":"array","items":{"type":"string"}},
"releases":{"type":"integer"},"completions":{"type":"integer"},"overruns":{"type":"integer"},"skips":{"type":"integer"},
"lateness":{"$ref":"#/definitions/histogram"},"exec":{"$ref":"#/definitions/histogram"}}}},
"modules":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"type":{"type":"string"},
"thread":{"type":"string"},"running":{"type":"boolean"},"steps":{"type":"integer"},"ok":{"type":"integer"},
"stale":{"type":"integer"},"fault":{"type":"integer"},"stops":{"type":"integer"},
"exec":{"$ref":"#/definitions/histogram"}}}},
"topics":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"messages":{"type":"integer"},
"drops":{"type":"integer"},"last_stamp_ns":{"type":"integer"},"last_published_ns":{"type":"integer"},
"age":{"$ref":"#/definitions/histogram"}}}},
"chains":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"budget_ns":{"type":"integer"},
"budget_misses":{"type":"integer"},"age":{"$ref":"#/definitions/histogram"}}}},
"guardian":{"type":"object"},"devices":{"type":"object"},"outsiders":{"type":"object"}},
"definitions":{"histogram":{"type":"object","properties":{"count":{"type":"integer"},"min_ns":{"type":"integer"},
"mean_ns":{"type":"number"},"p50_ns":{"type":"integer"},"p99_ns":{"type":"integer"},"p999_ns":{"type":"integer"},
"max_ns":{"type":"integer"}}}}})";
constexpr const char* kTimelineSchema = R"({"type":"object","properties":{
"unix_ns":{"type":"integer"},"ok":{"type":"boolean"},"threads":{"type":"array","items":{"type":"string"}},
"modules":{"type":"array","items":{"type":"string"}},"columns":{"type":"array","items":{"type":"string"}},
"left_out":{"type":"integer"},"events":{"type":"array","items":{"type":"array"}}}})";
constexpr const char* kPlaybackSchema = R"({"type":"object","properties":{
"unix_ns":{"type":"integer"},"ok":{"type":"boolean"},"state":{"type":"string"},"time_ns":{"type":"integer"},
"begin_ns":{"type":"integer"},"end_ns":{"type":"integer"},"speed":{"type":"number"}}})";

Json feed_object(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_object() ? json : Json::object();
}

std::int64_t integer_of(const Json& json, const char* member) {
  const auto at = json.find(member);
  return at != json.end() && at->is_number_integer() ? at->get<std::int64_t>() : 0;
}

std::string string_of(const Json& json, const char* member) {
  const auto at = json.find(member);
  return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
}

bool is_image(const msg::TypeInfo& type) { return &type == &msg::type_info<msg::Image>(); }

Channel report_channel(const char* name, const char* schema) {
  Channel c;
  c.topic = std::string("/sinew/") + name, c.encoding = "json", c.schema_name = std::string("sinew.") + name;
  c.schema = schema, c.schema_encoding = "jsonschema", c.kind = Channel::Kind::report;
  return c;
}

Channel topic_channel(const tap::Topic& topic) {
  const msg::TypeInfo& type = *topic.info;
  Channel c;
  c.topic = "/" + topic.name, c.encoding = "cdr", c.schema_encoding = "ros2msg";
  if (is_image(type)) {
    c.schema_name = msg::ros2_image_schema().name, c.schema = msg::ros2_image_schema().text;
  } else {
    c.schema_name = msg::ros2_name(type), c.schema = msg::ros2msg_schema(type);
    c.is_small = topic.message_bytes + topic.bulk_bytes < kSmallBytes;
  }
  return c;
}

/// Modules and threads, as the robot describes them.
void read_graph(const Json& topics, foxglove::RobotFacts& facts) {
  const auto list = topics.find("topics");
  if (list == topics.end() || !list->is_array()) return;
  for (const Json& t : *list) {
    if (!t.is_object()) continue;
    const std::string name = string_of(t, "name");
    facts.published.push_back({"/" + name, {string_of(t, "writer")}});
    std::vector<std::string> readers;
    if (const auto at = t.find("readers"); at != t.end() && at->is_array())
      for (const Json& r : *at)
        if (r.is_string()) readers.push_back(r.get<std::string>());
    facts.subscribed.emplace_back("/" + name, std::move(readers));
    const auto external = t.find("external");
    if (external != t.end() && external->is_boolean() && external->get<bool>()) facts.external.push_back(name);
  }
}

}  // namespace

std::optional<RobotFeed::Parts> RobotFeed::connect(const std::string& robot, const std::string& hello_text,
                                                   std::string& why) {
  auto connected = tap::Client::connect(robot, why);
  if (!connected) return std::nullopt;
  auto client = std::move(*connected);
  Parts parts;
  foxglove::RobotFacts& facts = parts.facts;
  const Json hello = feed_object(hello_text);
  facts.name = robot;
  const auto ask = [&](const char* request) {
    const auto reply = client->request(request);
    return reply ? feed_object(*reply) : Json::object();
  };
  read_graph(ask("topics"), facts);
  const std::int64_t before_ns = hal::system_os().now().ns;
  const Json status = ask("status");
  const std::int64_t robot_ns = integer_of(status, "now_ns"), after_ns = hal::system_os().now().ns;
  if (const auto threads = status.find("threads"); threads != status.end() && threads->is_array())
    for (const Json& t : *threads)
      if (t.is_object()) facts.threads.push_back(string_of(t, "name"));
  const bool recorded = !string_of(hello, "recording").empty();
  const auto virtual_time = hello.find("virtual_time");
  facts.own_clock = recorded ||
                    (virtual_time != hello.end() && virtual_time->is_boolean() && virtual_time->get<bool>()) ||
                    robot_ns < before_ns - kSameClockNs || robot_ns > after_ns + kSameClockNs;
  if (!facts.own_clock) {
    const auto unix_now = std::chrono::system_clock::now().time_since_epoch();
    facts.unix_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(unix_now).count() - hal::system_os().now().ns;
  }
  if (recorded) {
    const Json playback = ask("playback");
    facts.unix_ns = integer_of(playback, "unix_ns");
    const auto at = [&](const char* member) {
      return static_cast<std::uint64_t>(integer_of(playback, member) + facts.unix_ns);
    };
    facts.recorded_ns = {at("begin_ns"), at("end_ns")};
  }
  if (const auto reader = client->reader()) {
    for (std::uint32_t t = 0; t < (*reader)->topics().size(); ++t) {
      const tap::Topic& topic = (*reader)->topics()[t];
      if (!topic.known()) continue;
      facts.channels.push_back(topic_channel(topic));
      parts.topic_of.emplace_back(t);
      if (!is_image(*topic.info) || !images::is_built(images::Kind::jpeg)) continue;
      Channel jpeg = facts.channels.back();
      jpeg.topic += "/jpeg", jpeg.kind = Channel::Kind::pictures;
      jpeg.schema_name = msg::ros2_compressed_image_schema().name;
      jpeg.schema = msg::ros2_compressed_image_schema().text;
      facts.channels.push_back(std::move(jpeg));
      parts.topic_of.emplace_back(t);
    }
    parts.topics = std::make_unique<RobotTopics>(std::move(client), **reader);
  }
  facts.channels.push_back(report_channel("status", kStatusSchema));
  facts.channels.push_back(report_channel("timeline", kTimelineSchema));
  facts.requests.assign(std::begin(kServices), std::end(kServices));
  if (recorded) {
    facts.channels.push_back(report_channel("playback", kPlaybackSchema));
    facts.requests.insert(facts.requests.end(), std::begin(kPlaybackServices), std::end(kPlaybackServices));
  }
  parts.topic_of.resize(facts.channels.size());
  return parts;
}

struct RobotFeed::Handle {
  Handle(std::shared_ptr<RobotFeed> f, std::list<Subscriber>::iterator a) : feed(std::move(f)), at(a) {}
  ~Handle() { feed->remove(at); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  const std::shared_ptr<RobotFeed> feed;
  const std::list<Subscriber>::iterator at;
};

RobotFeed::RobotFeed(Parts parts, std::weak_ptr<RobotLink> link) : parts_(std::move(parts)), link_(std::move(link)) {
  const auto& channels = parts_.facts.channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].topic == "/sinew/status") reports_[i] = {"status", "{}", kTicksOfStatus};
    if (channels[i].topic == "/sinew/timeline") reports_[i] = {"timeline", R"({"last_ms": 1000})", kTicksOfTimeline};
    if (channels[i].topic == "/sinew/playback") reports_[i] = {"playback", "{}", kTicksOfPlayback};
  }
  if (!parts_.topics) return;
  waiter_.emplace(*parts_.topics);
  reader_ = std::thread([this] { read(); });
  pictures_.emplace(*parts_.topics);
}

RobotFeed::~RobotFeed() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  if (!waiter_) return;
  waiter_->wake();
  reader_.join();
}

// ---- subscribers

std::shared_ptr<void> RobotFeed::subscribe(std::size_t channel, std::shared_ptr<foxglove::Inbox> inbox) {
  bool first = false;
  std::shared_ptr<void> handle;
  {
    const std::lock_guard lock(mutex_);
    first = inboxes_of(channel).empty();
    subscribers_.push_back({channel, std::move(inbox)});
    ++changes_;
    handle = std::make_shared<Handle>(shared_from_this(), std::prev(subscribers_.end()));
  }
  if (waiter_) waiter_->wake();
  const auto report = reports_.find(channel);
  if (report == reports_.end()) return handle;
  if (first && std::strcmp(report->second.request, "timeline") == 0)
    ask("zones", R"({"on": true})", [](std::string) {});
  ask_for(channel);
  return handle;
}

void RobotFeed::remove(std::list<Subscriber>::iterator subscriber) {
  const std::size_t channel = subscriber->channel;
  bool last = false;
  {
    const std::lock_guard lock(mutex_);
    subscribers_.erase(subscriber);
    ++changes_;
    last = inboxes_of(channel).empty();
  }
  const auto report = reports_.find(channel);
  if (last && report != reports_.end() && std::strcmp(report->second.request, "timeline") == 0)
    ask("zones", R"({"on": false})", [](std::string) {});
}

std::shared_ptr<RobotPictures> RobotFeed::pictures() {
  return pictures_ ? std::shared_ptr<RobotPictures>(shared_from_this(), &*pictures_) : nullptr;
}

std::shared_ptr<foxglove::PictureTap> RobotFeed::look(std::size_t channel, std::shared_ptr<foxglove::Inbox> inbox) {
  struct Tap final : foxglove::PictureTap {
    void want(const foxglove::PictureSize& size) override {
      Recipe recipe;
      recipe.cut.scale = size.scale, recipe.options.quality = size.quality;
      viewer->want(recipe);
    }
    std::shared_ptr<RobotPictures::Viewer> viewer;
  };
  const std::uint32_t topic = *parts_.topic_of[channel];
  auto tap = std::make_shared<Tap>();
  // The feed outlives its picture thread.
  tap->viewer = RobotPictures::look(pictures(), topic, [this, topic, inbox](const auto& picture) {
    if (!picture) return true;
    if (!picture->file) return false;
    inbox->put(item_of(*picture, topic));
    return true;
  });
  return tap;
}

foxglove::Item RobotFeed::item_of(const Picture& picture, std::uint32_t topic) {
  const auto head =
      msg::Ros2ImageHead::of_file(picture.stamp_ns + parts_.facts.unix_ns, parts_.topics->reader().topics()[topic].name,
                                  "jpeg", static_cast<std::uint32_t>(picture.file->size()));
  if (parts_.facts.own_clock) {
    const std::lock_guard lock(mutex_);
    time_ns_ = std::max(time_ns_, picture.published_ns);
  }
  return {message_time(picture.published_ns), picture.file, {head.bytes().begin(), head.bytes().end()}};
}

RobotFeed::Inboxes RobotFeed::inboxes_of(std::size_t channel) const {
  Inboxes found;
  for (const Subscriber& s : subscribers_)
    if (s.channel == channel) found.push_back(s.inbox);
  return found;
}

RobotFeed::Counters RobotFeed::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

std::uint64_t RobotFeed::time_ns() const {
  const std::lock_guard lock(mutex_);
  return message_time(time_ns_);
}

// ---- reports and requests

void RobotFeed::ask(std::string request, std::string arguments, Done done) {
  if (const auto link = link_.lock()) return link->ask(std::move(request), std::move(arguments), std::move(done));
  done(kEnded);
}

void RobotFeed::recent_status(Done done) {
  if (const auto link = link_.lock()) return link->look("status", kStatusAge, std::move(done));
  done(kEnded);
}

void RobotFeed::tick() {
  ++ticks_;
  for (const auto& [channel, report] : reports_)
    if (ticks_ % report.every == 0) ask_for(channel);
}

/// Also without subscribers to the status of a robot with a clock of its own: sessions show its time.
void RobotFeed::ask_for(std::size_t channel) {
  Report& report = reports_.at(channel);
  {
    const std::lock_guard lock(mutex_);
    const bool for_time = parts_.facts.own_clock && std::strcmp(report.request, "status") == 0;
    if (report.asked || (!for_time && inboxes_of(channel).empty())) return;
    report.asked = true;
  }
  const auto done = [weak = weak_from_this(), channel](const std::string& reply) {
    if (const auto self = weak.lock()) self->received(channel, reply);
  };
  if (std::strcmp(report.request, "status") == 0) return recent_status(done);
  ask(report.request, report.arguments, done);
}

void RobotFeed::received(std::size_t channel, const std::string& reply) {
  constexpr std::string_view kNow = "\"now_ns\":";
  const bool ok = reply.starts_with("{") && reply.find("\"ok\":true") != std::string::npos;
  Inboxes inboxes;
  foxglove::Item item;
  {
    const std::lock_guard lock(mutex_);
    reports_.at(channel).asked = false;
    if (!ok) return;
    if (const auto at = reply.find(kNow); at != std::string::npos)
      time_ns_ = std::strtoll(reply.c_str() + at + kNow.size(), nullptr, 10);
    inboxes = inboxes_of(channel);
    item.time_ns = message_time(parts_.facts.own_clock ? time_ns_ : hal::system_os().now().ns);
  }
  if (inboxes.empty()) return;
  item.payload = bytes_of("{\"unix_ns\":" + std::to_string(parts_.facts.unix_ns) + "," + reply.substr(1));
  for (const auto& inbox : inboxes) inbox->put(item);
}

// ---- messages

void RobotFeed::read() {
  while (true) {
    waiter_->listen();
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return;
    }
    if (take_changes()) continue;  // a message may have come before the robot knew
    for (auto& [topic, state] : topics_) read(topic, state);
    waiter_->wait();
  }
}

/// Who subscribes to what may have changed. A new subscriber gets the newest message.
bool RobotFeed::take_changes() {
  std::map<std::uint32_t, Inboxes> wanted;
  {
    const std::lock_guard lock(mutex_);
    if (seen_changes_ == changes_) return false;
    seen_changes_ = changes_;
    for (const Subscriber& s : subscribers_)
      if (const auto& topic = parts_.topic_of[s.channel]) wanted[*topic].push_back(s.inbox);
  }
  std::vector<std::uint32_t> topics;
  for (const auto& [topic, inboxes] : wanted) topics.push_back(topic);
  waiter_->follow(std::move(topics));
  std::erase_if(topics_, [&](const auto& t) { return !wanted.contains(t.first); });
  for (auto& [topic, inboxes] : wanted) {
    Topic& state = topics_[topic];
    read(topic, state);  // for those that were there before
    Inboxes added;
    for (const auto& inbox : inboxes)
      if (std::find(state.inboxes.begin(), state.inboxes.end(), inbox) == state.inboxes.end()) added.push_back(inbox);
    state.inboxes = std::move(inboxes);
    if (added.empty() || !state.any) continue;
    if (const auto newest = parts_.topics->reader().newest(topic); newest && newest->sequence == state.last)
      put(*newest, added);
  }
  return true;
}

/// True: there was something new.
bool RobotFeed::read(std::uint32_t topic, Topic& state) {
  const tap::SegmentReader& reader = parts_.topics->reader();
  if (state.inboxes.empty()) return false;
  const tap::Topic& about = reader.topics()[topic];
  const bool every = !is_image(*about.info) && about.message_bytes + about.bulk_bytes < kSmallBytes;
  bool any = false;
  while (const auto message = every ? reader.next(topic, state.cursor) : reader.newest(topic)) {
    if (!every && state.any && message->sequence == state.last) break;
    any = put(*message, state.inboxes) || any;
    state.any = true, state.last = message->sequence;
    if (!every) break;
  }
  return any;
}

bool RobotFeed::put(const tap::Message& message, const Inboxes& to) {
  Bytes payload;
  std::int64_t published_ns = 0;
  tap::Message tried = message;
  const bool image = is_image(*parts_.topics->reader().topics()[message.topic].info);
  for (int i = 0; i < kCopyTries && !payload; ++i) {
    published_ns = tried.header->published.ns;
    payload = image ? encode_image(tried) : encode(tried);
    if (payload) break;
    const std::lock_guard lock(mutex_);
    ++counters_.torn;
    if (!image) return false;  // the next one comes
    const auto newest = parts_.topics->reader().newest(message.topic);
    if (!newest) return false;
    tried = *newest;
  }
  if (!payload) return false;
  {
    const std::lock_guard lock(mutex_);
    ++counters_.encoded;
    if (parts_.facts.own_clock) time_ns_ = published_ns;
  }
  for (const auto& inbox : to) inbox->put({message_time(published_ns), payload});
  return true;
}

/// Null: it was overwritten meanwhile.
Bytes RobotFeed::encode(const tap::Message& message) {
  const tap::Topic& topic = parts_.topics->reader().topics()[message.topic];
  const std::size_t size = parts_.topics->reader().bytes(message.topic);
  scratch_.resize(size / sizeof(std::max_align_t) + 1);
  const auto copy = std::as_writable_bytes(std::span(scratch_));
  if (!parts_.topics->reader().copy(message, copy)) return nullptr;
  const std::byte* const at = copy.data() + (size - topic.message_bytes - topic.bulk_bytes);
  auto bytes = std::make_shared<std::vector<std::byte>>(msg::cdr_size(*topic.info, at));
  msg::cdr_encode(*topic.info, at, {reinterpret_cast<std::uint8_t*>(bytes->data()), bytes->size()});
  return bytes;
}

/// From its place to where it is sent from, in one copy.
Bytes RobotFeed::encode_image(const tap::Message& message) const {
  const tap::Topic& topic = parts_.topics->reader().topics()[message.topic];
  msg::Image image;
  std::memcpy(static_cast<void*>(&image), message.data(), sizeof image);
  image.capacity_bytes = topic.bulk_bytes;  // until it holds, its numbers may be anything
  const std::uint32_t used = image.bulk_used();
  const auto head = msg::Ros2ImageHead::of_image(image, used, parts_.facts.unix_ns, topic.name);
  auto bytes = std::make_shared<std::vector<std::byte>>();
  bytes->reserve(head.bytes().size() + used);
  bytes->assign(head.bytes().begin(), head.bytes().end());
  bytes->insert(bytes->end(), message.data() + sizeof image, message.data() + sizeof image + used);
  return parts_.topics->reader().holds(message) ? bytes : nullptr;
}

}  // namespace sinew::monitor
